"""What decides a drop: the test and the landings a recipe prescribes, the names of its results, and the period of the part."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from mechstyle.fea.discretisation import discretise
from mechstyle.fea.drop import DropTest
from mechstyle.fea.elements import element_named
from mechstyle.fea.linear_solvers import lowest_period
from mechstyle.fea.orientations import Orientations, landings
from mechstyle.loop.objects import Memos
from mechstyle.records import Recipe
from mechstyle.records.mesh import SurfaceMesh, TetMesh
from mechstyle.simulation.printed import printed_body

PHYSICS_VERSION = 22
"""Counts changes that alter results, so that remembered simulations of older code are not reused."""

PRINTED_VERSION = 2
"""The same of changes that alter those of prints with infill alone."""


def prescribed(recipe: Recipe) -> DropTest:
    """The drop test a recipe prescribes."""
    test = recipe.test
    return DropTest(
        height=test.height, friction=test.friction, window=test.window, damping=test.damping, element=test.element,
        across=test.across_layers, plastic=test.criterion != "paper", contact_stiffness=test.floor,
    )  # fmt: skip


def landings_of(surface: SurfaceMesh, recipe: Recipe) -> Orientations:
    """The landings that a recipe prescribes for a part.

    The surface is the part's without relief [mm], closed; BadInput as for `orientations.landings`.
    """
    test = recipe.test
    return landings(surface, test.poses, test.orientations, nearly_flat=test.nearly_flat)


def physics(recipe: Recipe) -> tuple[Any, ...]:
    """What decides the drop of a displaced part as placed and the stress it leaves on the surface."""
    test = recipe.test
    inside = () if recipe.printed.solid else (PRINTED_VERSION, recipe.printed, test.build_direction)
    return test.specimen, test.material, prescribed(recipe), test.transfer, *inside


def memo_key(inputs: tuple[Any, ...], displacement: NDArray[np.float32]) -> str:
    """The name under which what follows from inputs and a displacement [mm], shape [vertex_count], is remembered."""
    return hashlib.sha256(msgspec.json.encode(inputs) + np.ascontiguousarray(displacement, np.float32).tobytes()).hexdigest()


def period_of(tets: Callable[[], TetMesh], recipe: Recipe, memos: Memos) -> float | None:
    """Lowest elastic period of the unstylized part [ms], by which the end of an impact is found, also of a styled one.

    None if the recipe has a window, which needs none.

    Args:
        tets: Makes the tetrahedra of the unstylized part; fine ones, for a relief, would take minutes to tell the same.
        recipe: What decides the physics.
        memos: Where the answer is remembered.
    """
    if recipe.test.window is not None:
        return None
    surface, material, element = recipe.test.specimen.surface, recipe.test.material, recipe.test.element
    inside = () if recipe.printed.solid else (PRINTED_VERSION, recipe.printed, recipe.test.build_direction)
    key = memo_key(("period", PHYSICS_VERSION, surface, material, element, *inside), np.empty(0, np.float32))
    period = memos.recall(key, float)
    if period is None:  # with the mass of any test: what is remembered must not depend on who asked first
        body = tets()
        relative = None if recipe.printed.solid else printed_body(body, recipe)
        period = lowest_period(discretise(body, material, DropTest.added_mass, element_named(element), relative))
        memos.remember(key, period)
    return period
