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
from mechstyle.geometry.proximity import TriangleTree
from mechstyle.loop.objects import Memo
from mechstyle.records import Recipe
from mechstyle.records.mesh import Floats, SurfaceMesh, TetMesh

PHYSICS_VERSION = 20
"""Counts changes that alter results, so that remembered simulations of older code are not reused."""


ROUGH: dict[str, Any] = {"added_mass": 0.01, "quiet": 0.5}
"""What a rough drop differs in."""

SAME_PART, SAME_PLACE = 0.0015, 0.02
"""Distance of a part that is turned or mirrored from itself, on average and at most, over its size, up to which it is the same: of 30
parts of 2000 vertices the symmetries leave 0.0013 and 0.016, a hook on one side of a winder 0.024 at most, the lobes of a vase 0.0036 on
average. What is smaller than 0.02 of the size is not seen."""


def prescribed(recipe: Recipe) -> DropTest:
    """The drop test a recipe prescribes."""
    test = recipe.test
    return DropTest(
        height=test.height, friction=test.friction, window=test.window, damping=test.damping, element=test.element,
        across=test.across_layers, **(ROUGH if test.rough else {}),
    )  # fmt: skip


def landings_of(surface: SurfaceMesh, recipe: Recipe) -> Orientations:
    """The landings that a recipe prescribes for a part; of those that mirror each other a rough test has the first.

    The surface is the part's without relief [mm], closed; BadInput as for `orientations.landings`.
    """
    test = recipe.test
    every = landings(surface, test.poses, test.orientations, nearly_flat=test.nearly_flat)
    if not test.rough or any(test.across_layers[:2]):  # layers that do not lie level know left from right
        return every
    tree, kept = TriangleTree(surface.vertices, surface.faces), list[int]()
    for number, (normal, way) in enumerate(zip(every.normals, every.ways, strict=True)):
        others = (every.normals[other] for other in kept if every.ways[other] == way)
        if not any(mirrored(surface, tree, normal, other) for other in others):
            kept.append(number)
    return Orientations(every.normals[kept], tuple(every.names[n] for n in kept), tuple(every.ways[n] for n in kept))


def mirrored(surface: SurfaceMesh, tree: TriangleTree, normal: Floats, other: Floats) -> bool:
    """Whether a turn about the vertical, or an upright mirror, brings a part onto itself and one landing onto another.

    Args:
        surface: The part [mm].
        tree: Its triangles.
        normal: Floor normal of the one landing, a unit vector in the frame of the part, shape [3].
        other: That of the other, shape [3].
    """
    if abs(normal[2] - other[2]) > 1e-9:
        return False
    one, there = complex(*normal[:2]), complex(*other[:2])
    centre = np.array([*surface.centre_of_mass[:2], 0.0])
    from_axis = surface.vertices - centre
    place = from_axis[:, 0] + 1.0j * from_axis[:, 1]
    turned, reflected = place * there / one, place.conj() * there / one.conjugate()
    for moved in (turned, reflected):
        away = tree.nearest(np.column_stack([moved.real, moved.imag, from_axis[:, 2]]) + centre).distance
        if away.max() < SAME_PLACE * surface.size and np.average(away, weights=surface.vertex_areas) < SAME_PART * surface.size:
            return True
    return False


def physics(recipe: Recipe) -> tuple[Any, ...]:
    """What decides the drop of a displaced part as placed and the stress it leaves on the surface."""
    test = recipe.test
    return test.specimen, test.material, prescribed(recipe), test.transfer


def memo_key(inputs: tuple[Any, ...], displacement: NDArray[np.float32]) -> str:
    """The name under which what follows from inputs and a displacement [mm], shape [vertex_count], is remembered."""
    return hashlib.sha256(msgspec.json.encode(inputs) + np.ascontiguousarray(displacement, np.float32).tobytes()).hexdigest()


def period_of(tets: Callable[[], TetMesh], recipe: Recipe, memo: Memo, trusted: Memo | None = None) -> float | None:
    """Lowest elastic period of the unstylized part [ms], by which the end of an impact is found, also of a styled one.

    None if the recipe has a window, which needs none.

    Args:
        tets: Makes the tetrahedra of the unstylized part; fine ones, for a relief, would take minutes to tell the same.
        recipe: What decides the physics.
        memo: Where the answer is remembered.
        trusted: Where it is looked for first, and remembered if it was worked out here; None for nowhere.
    """
    if recipe.test.window is not None:
        return None
    surface, material, element = recipe.test.specimen.surface, recipe.test.material, recipe.test.element
    key = memo_key(("period", PHYSICS_VERSION, surface, material, element), np.empty(0, np.float32))
    memos = [memo] if trusted is None else [trusted, memo]
    period = next((found for one in memos if (found := one.recall(key, float)) is not None), None)
    if period is not None:
        memo.remember(key, period)  # a run folder holds what its drops rest on, whoever worked it out
        return period
    # With the mass of any test: what is remembered must not depend on who asked first.
    period = lowest_period(discretise(tets(), material, DropTest.added_mass, element_named(element)))
    for one in memos:
        one.remember(key, period)
    return period
