"""Mesh convergence of σ_V: contact at a point, along a line and over a plane, and cups, plain and styled."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from mechstyle.fea.drop import DropTest
from mechstyle.fea.orientations import landings
from mechstyle.records.mesh import TetMesh
from mechstyle.simulation.validation.cases import Result, bounded, compared
from mechstyle.simulation.validation.meshes import ball, box, cup, refined, roller
from mechstyle.simulation.validation.reading import Body, styled_cup

POINT, LINE, PLANE = 0.05, 0.12, 0.08
FLAT, NEARLY = 0.06, 0.12
FEW = 3
"""Nearly flat landings that are compared."""


def point() -> Iterator[Result]:
    """A ball of 20 mm: contact at a point."""
    yield from _steady("point", [ball(10.0, cells, 4.0) for cells in (10, 12, 16)], 0.12, POINT)


def line() -> Iterator[Result]:
    """A round bar on its side, 16 × 24 mm: contact along a line."""
    yield from _steady("line", [roller(8.0, 24.0, cells, cells, 6.0) for cells in (10, 12, 16)], 0.1, LINE)


def plane() -> Iterator[Result]:
    """A cube of 16 mm on its side: contact over a plane."""
    yield from _steady("plane", [box((cells, cells, cells), (16.0, 16.0, 16.0)) for cells in (5, 6, 8)], 0.06, PLANE)


def finer() -> Iterator[Result]:
    """A plain cup, and the same with every tetrahedron cut into eight."""
    coarse = cup(12.0, 20.0, 2.0, (28, 8, 3))
    yield from _finer("finer: cup", coarse, coarse)


def finer_styled() -> Iterator[Result]:
    """A square cup in brick whose resting face is plain, and the same with every tetrahedron cut into eight."""
    part = styled_cup()
    yield from _finer("finer: brick cup", part.morphed, part.unstyled)


def _steady(name: str, meshes: Sequence[TetMesh], window: float, limit: float) -> Iterator[Result]:
    """Bodies of about 1, 2 and 4 times as many tetrahedra, each against the finest."""
    found = [Body(mesh).dropped(DropTest(window=window))[0] for mesh in meshes]
    finest, many = found[-1], len(meshes[-1].tets)
    for mesh, one in zip(meshes[:-1], found[:-1], strict=True):
        note = f"{many} TET10; largest stress {one.maximum:.0f} and {finest.maximum:.0f} MPa"
        yield compared(f"{name}: {len(mesh.tets)} tetrahedra", one.stress, finest.stress, limit, "MPa", note)


def _finer(name: str, coarse: TetMesh, plain: TetMesh) -> Iterator[Result]:
    ways = landings(plain.boundary, "fibonacci", 1, nearly_flat=True).normals[: 1 + FEW]
    fine = refined(coarse)
    (flat, *nearly), (flat_finer, *nearly_finer) = (
        [found.stress for found in Body(mesh).dropped(DropTest(window=1.2), ways)] for mesh in (coarse, fine)
    )
    for label, before, after, limit in (("flat", flat, flat_finer, FLAT), ("nearly flat", max(nearly), max(nearly_finer), NEARLY)):
        note = f"{len(coarse.tets)} and {len(fine.tets)} TET10: {before:.1f} and {after:.1f} MPa"
        yield bounded(f"{name}, {label}", abs(before / after - 1.0), limit, note)
