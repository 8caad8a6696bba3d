"""Small parts whose rows, columns and sides are known: a pen holder and an L-shaped stand."""

import itertools
import sys

import numpy as np
import pytest

from mechstyle.records.mesh import SurfaceMesh
from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.operators import Operators
from mechstyle.styling.meaning import MODULE

EDGE = 4.0  # mm


def revolved(profile: list[tuple[float, float]], edge: float = EDGE) -> SurfaceMesh:
    """The solid of revolution of a closed outline (radius, z) [mm] from axis to axis, counter-clockwise, in rings of about `edge`."""
    outline = [np.array(profile[0])]
    for start, end in itertools.pairwise(profile):
        steps = max(round(float(np.hypot(end[0] - start[0], end[1] - start[1])) / edge), 1)
        outline += [np.array(start) + (np.array(end) - np.array(start)) * k / steps for k in range(1, steps + 1)]
    around = round(2.0 * np.pi * max(radius for radius, _ in profile) / edge)
    angle = 2.0 * np.pi * np.arange(around) / around
    points, rings = [], []
    for radius, z in outline:
        here = np.zeros(1) if radius == 0.0 else angle
        rings.append(len(points) + np.arange(len(here)))
        points += list(np.stack([radius * np.cos(here), radius * np.sin(here), np.full(len(here), z)], axis=1))
    faces = []
    for below, above in itertools.pairwise(rings):
        for k in range(around):
            a, b = below[k % len(below)], below[(k + 1) % len(below)]
            c, d = above[(k + 1) % len(above)], above[k % len(above)]
            faces += [face for face in ((a, b, c), (a, c, d)) if len(set(face)) == 3]
    return SurfaceMesh(np.array(points), np.array(faces))


def boxed(steps: tuple[int, int, int], inside, edge: float = EDGE) -> SurfaceMesh:
    """The surface of the cells of a grid for which `inside(i, j, k)`, two triangles a side."""
    full = np.zeros(np.add(steps, 2), bool)
    full[1:-1, 1:-1, 1:-1] = np.broadcast_to(inside(*np.indices(steps)), steps)
    sides = {
        (0, 0, 1): ((0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)),
        (0, 0, -1): ((0, 0, 0), (0, 1, 0), (1, 1, 0), (1, 0, 0)),
        (0, 1, 0): ((0, 1, 0), (0, 1, 1), (1, 1, 1), (1, 1, 0)),
        (0, -1, 0): ((0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1)),
        (1, 0, 0): ((1, 0, 0), (1, 1, 0), (1, 1, 1), (1, 0, 1)),
        (-1, 0, 0): ((0, 0, 0), (0, 0, 1), (0, 1, 1), (0, 1, 0)),
    }
    index: dict[tuple[int, ...], int] = {}
    faces = []
    shown = [full & ~np.roll(full, np.negative(direction), (0, 1, 2)) for direction in sides]
    for *cell, side in np.argwhere(np.stack(shown, axis=3)).tolist():
        i, j, k = (place - 1 for place in cell)
        a, b, c, d = (index.setdefault((i + x, j + y, k + z), len(index)) for x, y, z in list(sides.values())[side])
        faces += [(a, b, c), (a, c, d)]
    return SurfaceMesh(np.array(list(index), dtype=float) * edge, np.array(faces))


@pytest.fixture(autouse=True)
def _without_an_encoder(monkeypatch):
    """What the tables say, whether or not the extra `words` is installed."""
    monkeypatch.setitem(sys.modules, MODULE, None)


@pytest.fixture(scope="session")
def holder() -> SurfaceMesh:
    """A pen holder, 80 mm wide, 100 mm high, 3 mm wall: smooth walls inside and out, flat floors, a narrow rim."""
    return revolved([(0, 0), (40, 0), (40, 100), (37, 100), (37, 4), (0, 4)])


@pytest.fixture(scope="session")
def cup() -> SurfaceMesh:
    """The same with longer edges: for what is done once for every style, where a fifth of the vertices shows the same faults."""
    return revolved([(0, 0), (40, 0), (40, 100), (37, 100), (37, 4), (0, 4)], edge=8.0)


@pytest.fixture(scope="session")
def coarse_cup() -> SurfaceMesh:
    """The same in 362 vertices, which seams make more than twice as many."""
    return revolved([(0, 0), (40, 0), (40, 100), (37, 100), (37, 4), (0, 4)], edge=14.0)


@pytest.fixture(scope="session")
def ball() -> SurfaceMesh:
    """A smooth ball, 100 mm wide."""
    return revolved([(50.0 * np.sin(angle), -50.0 * np.cos(angle)) for angle in np.linspace(0.0, np.pi, 30)], edge=6.0)


@pytest.fixture(scope="session")
def blank():
    """A function of a mesh and what else a canvas takes: canvases of one mesh share what is worked out of that mesh alone."""
    first: dict[int, Canvas] = {}

    def of(mesh: SurfaceMesh, seed: int = 0, **size: float) -> Canvas:
        canvas = Canvas(mesh, seed, **size)
        canvas.share(first.setdefault(id(mesh), canvas))
        return canvas

    return of


@pytest.fixture(scope="session")
def hourglass() -> SurfaceMesh:
    """A solid of revolution 100 mm high, 60 mm wide at its ends and 30 mm at its waist."""
    z = np.linspace(0.0, 100.0, 26)
    return revolved([(0, 0), *zip(22.5 + 7.5 * np.cos(np.pi * z / 50.0), z, strict=True), (0, 100)])


@pytest.fixture(scope="session")
def stand() -> SurfaceMesh:
    """An L of 60 x 48 x 80 mm, 8 mm thick: all its faces along the axes."""
    return boxed((15, 12, 20), lambda _i, j, k: (k < 2) | (j >= 10))


@pytest.fixture(scope="session")
def slab():
    """Makes a slab of so many edges of 4 mm along each axis."""
    return lambda *steps: boxed(steps, lambda *_: True)


@pytest.fixture(scope="session")
def fine_wall() -> SurfaceMesh:
    """A wall of 80 x 10 x 60 mm with edges of 1 mm, fine enough for bricks of their nominal size."""
    return boxed((80, 10, 60), lambda *_: True, edge=1.0)


@pytest.fixture(scope="session")
def holder_operators(holder) -> Operators:
    return Operators(holder)


@pytest.fixture(scope="session")
def outside(holder) -> np.ndarray:
    """Which vertices of the holder lie on its outer wall, edges left out."""
    radius = np.hypot(holder.vertices[:, 0], holder.vertices[:, 1])
    z = holder.vertices[:, 2]
    return (np.abs(radius - 40.0) < 1e-6) & (z > 2.0) & (z < 98.0)


@pytest.fixture(scope="session")
def sphere_operators(sphere) -> Operators:
    return Operators(sphere)
