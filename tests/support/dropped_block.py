"""A simulator of a small block, and reliefs that its tetrahedra carry, or do not."""

from __future__ import annotations

import numpy as np

from mechstyle.fea.discretisation import discretise
from mechstyle.fea.drop import DropTest
from mechstyle.fea.elements import LINEAR
from mechstyle.records import Recipe
from mechstyle.records.material import LIBRARY
from mechstyle.simulation.part import Workpiece
from mechstyle.simulation.simulator import DropSimulator

WALL = 3.0
"""What the walls of the block are taken for [mm], so that its reliefs are deep enough to matter."""


def simulator(block, memo, at=None, **settings) -> DropSimulator:
    surface, tets = block
    part = Workpiece(surface, tets, np.full(len(surface.vertices), WALL, np.float32), stands=True, at=at)
    chosen = {"material": LIBRARY["PLA"], "orientations": 2, "nearly_flat": False, "window": 0.1, "element": "tet4", **settings}
    recipe = Recipe.of(surface=surface.digest, tetrahedra=tets.digest, prompt="", **chosen)
    return DropSimulator(part, recipe, memo)


def discretised(block):
    """The linear tetrahedra as a drop takes them."""
    return discretise(block[1], LIBRARY["PLA"], DropTest().added_mass, LINEAR)


def bumps(block, height=0.2):
    """A smooth relief that is zero on the resting face."""
    x, y, z = block[0].vertices.T
    return (height * np.sin(x) * np.sin(y) * (z > 3.0)).astype(np.float32)


def slopes(block, height=0.2):
    """A relief as slow as the tetrahedra are large, above the floor and not level under the part."""
    return (-height * (1.0 + np.sin(0.06 * block[0].vertices[:, 0]))).astype(np.float32)


def ripples(block, height=0.3):
    """A relief finer than the tetrahedra, all of it inwards."""
    x, y, z = block[0].vertices.T
    return (-height * (1.0 + np.sin(1.1 * x) * np.cos(1.1 * y) * np.cos(1.1 * z))).astype(np.float32)
