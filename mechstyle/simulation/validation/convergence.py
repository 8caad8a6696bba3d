"""Mesh convergence: change of the deciding measures with a finer mesh of the same part."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from mechstyle.fea.criterion import measures
from mechstyle.fea.drop import DropTest, drop
from mechstyle.fea.orientations import directions
from mechstyle.fea.surface_stress import SurfaceStress
from mechstyle.records.material import LIBRARY
from mechstyle.records.mesh import TetMesh
from mechstyle.simulation.validation.bodies import styled_cup
from mechstyle.simulation.validation.cases import Result, bounded
from mechstyle.simulation.validation.meshes import cup, refined

PLA = LIBRARY["PLA"]
ORIENTATIONS = 5
P99, PEAK = 0.06, 0.12


class Figures(NamedTuple):
    """The measures that decide [MPa]: the peak as placed and the 99th percentile over all orientations."""

    peak: float
    p99: float


def finer() -> Iterator[Result]:
    """A smooth cup, and the same with every tetrahedron cut into eight."""
    coarse = cup(12.0, 20.0, 2.0, (28, 8, 3))
    yield from _finer("finer: cup", coarse, refined(coarse))


def finer_styled() -> Iterator[Result]:
    """A square cup in brick whose resting face is protected, and the same with every tetrahedron cut into eight."""
    part = styled_cup()
    yield from _finer("finer: brick cup", part.morphed, refined(part.morphed))


def figures(tets: TetMesh) -> Figures:
    """Drop a body in all orientations."""
    result = drop(tets, PLA, directions(ORIENTATIONS), DropTest(window=1.2))
    deciding = SurfaceStress(tets).of_landing(tets, result.von_mises[0], result.corners[0], result.contact[0])
    return Figures(deciding.peak, measures(tets, result.von_mises.max(axis=0), deciding).p99)


def _finer(name: str, coarse: TetMesh, fine: TetMesh) -> Iterator[Result]:
    one, other = figures(coarse), figures(fine)
    for label, before, after, limit in (
        ("envelope p99", one.p99, other.p99, P99),
        ("2 mm peak as placed", one.peak, other.peak, PEAK),
    ):
        note = f"{len(coarse.tets)} and {len(fine.tets)} TET10: {before:.1f} and {after:.1f} MPa"
        yield bounded(f"{name}, {label}", abs(before / after - 1.0), limit, note)
