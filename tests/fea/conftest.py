"""Meshes whose answers are known: structured boxes of tetrahedra, straight or shaken."""

from collections.abc import Callable

import numpy as np
import pytest

from mechstyle.records.material import LIBRARY, Material
from mechstyle.records.mesh import TetMesh
from validation.meshes import box as straight_box
from validation.meshes import lattice

Box = Callable[..., TetMesh]


def box_mesh(counts: tuple[int, int, int], size: tuple[float, float, float], shake: float = 0.0) -> TetMesh:
    """A box in the positive octant, each cell cut into the six Kuhn tetrahedra; inner vertices moved by `shake` of a cell."""
    straight = straight_box(counts, size)
    vertices = straight.vertices.copy()
    inside = np.all((vertices > 1e-9) & (vertices < np.array(size) - 1e-9), axis=1)
    cell = np.array(size) / np.array(counts)
    vertices[inside] += shake * cell * np.random.default_rng(1).uniform(-1.0, 1.0, (int(inside.sum()), 3))
    return straight.moved(vertices)


@pytest.fixture(scope="session")
def box() -> Box:
    """The mesher itself."""
    return box_mesh


def comb_mesh(wall: float, slot: float, cell: float) -> TetMesh:
    """Three walls of a thickness with two slots between them along x, 6 mm deep along y and 8 mm high, on a base up to z = 4 [mm].

    Cells of about `cell` [mm], each cut into the six Kuhn tetrahedra.
    """
    widths = [wall, slot, wall, slot, wall]
    counts = [max(1, round(width / cell)) for width in widths]
    x = np.concatenate([[0.0], np.cumsum(np.repeat(np.divide(widths, counts), counts))])
    mesh = lattice(x, np.linspace(0.0, 6.0, round(6.0 / cell) + 1), np.linspace(0.0, 12.0, 3 * round(4.0 / cell) + 1))
    across, _, up = mesh.vertices[mesh.tets].mean(axis=1).T
    return TetMesh(mesh.vertices, mesh.tets[(up < 4.0) | (across % (wall + slot) < wall)])


@pytest.fixture(scope="session")
def comb() -> Box:
    """The mesher of three walls on a base."""
    return comb_mesh


@pytest.fixture(scope="session")
def block() -> TetMesh:
    """A shaken block of 12 x 10 x 16 mm, 288 tetrahedra."""
    return box_mesh((4, 3, 4), (12.0, 10.0, 16.0), shake=0.2)


@pytest.fixture(scope="session")
def pla() -> Material:
    """PLA from the library."""
    return LIBRARY["PLA"]
