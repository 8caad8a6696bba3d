"""Mesh convergence: change of the deciding measures with a finer mesh or another mesh of the same part."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from mechstyle.fea.criterion import measures
from mechstyle.fea.drop import DropTest, drop
from mechstyle.fea.orientations import directions
from mechstyle.fea.surface_stress import SurfaceStress
from mechstyle.fea.verdict import CONTACT_BAND
from mechstyle.geometry.morph import Morph
from mechstyle.geometry.tetrahedra import tetrahedralise
from mechstyle.geometry.thickness import local_thickness
from mechstyle.records.material import LIBRARY
from mechstyle.records.mesh import SurfaceMesh, TetMesh
from mechstyle.simulation.part import Workpiece
from mechstyle.simulation.validation.cases import Result, bounded
from mechstyle.simulation.validation.meshes import cup, refined, square_cup
from mechstyle.styling.drawn import target
from mechstyle.styling.prompt import read

PLA = LIBRARY["PLA"]
ORIENTATIONS = 5
MESHES, TETS = 5, 9_000  # as the rule of the simulation page has it for a smooth part; with 6000 the 99th percentile scatters by 4 %
P99_FINER, P99_AGAIN, PEAK = 0.06, 0.04, 0.12


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
    part = _styled()
    yield from _finer("finer: brick cup", part.morphed, refined(part.morphed))


def again() -> Iterator[Result]:
    """Five meshes of a smooth square cup: the spread is half the range over the mean."""
    yield from _again("again: cup", _meshes(_unstyled().surface))


def again_styled() -> Iterator[Result]:
    """Five meshes of a square cup in brick whose resting face is protected: the spread, and whether the verdict is the same on all."""
    yield from _again("again: brick cup", _meshes(_styled().surface))


def figures(tets: TetMesh) -> Figures:
    """Drop a body in all orientations."""
    result = drop(tets, PLA, directions(ORIENTATIONS), DropTest(window=1.2))
    deciding = SurfaceStress(tets).of_landing(tets, result.von_mises[0], result.corners[0], result.contact[0])
    return Figures(deciding.peak, measures(tets, result.von_mises.max(axis=0), deciding).p99)


class Styled(NamedTuple):
    """A small square cup before and after.

    Attributes:
        surface: The surface in brick, the resting face left smooth.
        morphed: The tetrahedra of the smooth one, moved along.
    """

    surface: SurfaceMesh
    morphed: TetMesh


def _styled() -> Styled:
    part = _unstyled()
    bounds = part.shape.bounds("protected", 0.0)
    aim = target(
        part.surface, read("brick"), seed=0, amplitude=0.15, thickness=part.thickness, inward=bounds.inward, outward=bounds.outward
    )  # fmt: skip
    relief = (aim.displacement * bounds.freedom).astype(np.float32)
    return Styled(part.surface.displaced(relief), Morph(part.surface, part.tets).morphed(relief).tets)


def _unstyled() -> Workpiece:
    """In even tetrahedra, so that steps are long and eight times as many can be afforded."""
    tets = square_cup(24.0, 24.0, 2.0)
    used, numbers = np.unique(tets.boundary_faces, return_inverse=True)
    surface = SurfaceMesh(tets.vertices[used], numbers.reshape(-1, 3).astype(np.int32))
    return Workpiece(surface, tets, local_thickness(surface).astype(np.float32), stands=True)


def _meshes(surface: SurfaceMesh) -> list[TetMesh]:
    """The inside meshed with slightly different wishes, so that five meshes are five meshes."""
    return [tetrahedralise(surface, round(TETS * factor)) for factor in np.linspace(0.95, 1.05, MESHES)]


def _finer(name: str, coarse: TetMesh, fine: TetMesh) -> Iterator[Result]:
    one, other = figures(coarse), figures(fine)
    for label, before, after, limit in (
        ("envelope p99", one.p99, other.p99, P99_FINER),
        ("2 mm peak as placed", one.peak, other.peak, PEAK),
    ):
        note = f"{len(coarse.tets)} and {len(fine.tets)} TET10: {before:.1f} and {after:.1f} MPa"
        yield bounded(f"{name}, {label}", abs(before / after - 1.0), limit, note)


def _again(name: str, meshes: list[TetMesh]) -> Iterator[Result]:
    found = [figures(tets) for tets in meshes]
    for label, values, limit in (
        ("envelope p99", [one.p99 for one in found], P99_AGAIN),
        ("2 mm peak as placed", [one.peak for one in found], PEAK),
    ):
        spread = 0.5 * float(np.ptp(values)) / float(np.mean(values))
        listed = ", ".join(f"{value:.1f}" for value in values)
        yield bounded(f"{name}, {label}", spread, limit, f"half the range over the mean of {listed} MPa")
    sides = {one.peak <= PLA.yield_strength for one in found}
    near = any(abs(one.peak / PLA.yield_strength - 1.0) <= CONTACT_BAND for one in found)
    yield bounded(f"{name}, verdicts that differ", float(len(sides) - 1), 0.0, "MARGINAL on some" if near else "none is MARGINAL")
