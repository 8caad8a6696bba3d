"""A landing on a corner against CalculiX: floor force, impulse and σ_V, on the same mesh."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from mechstyle.fea import elasticity
from mechstyle.fea.drop import DropTest, drop
from mechstyle.fea.elasticity import law_named
from mechstyle.fea.elements import QUADRATIC, ElementMesh, with_nodes
from mechstyle.fea.stressed_volume import DROPPED
from mechstyle.records.mesh import Floats, TetMesh
from mechstyle.simulation.validation import calculix
from mechstyle.simulation.validation.cases import Result, bounded, compared
from mechstyle.simulation.validation.meshes import bracket
from mechstyle.simulation.validation.reading import PLA, UPRIGHT, Body, Reading

TILT = np.array([0.35, 0.2, 1.0])
"""Floor normal in the frame of the bracket: it lands on a corner, its legs bend and it turns."""
IMPULSE, FORCE, STRESS = 0.01, 0.04, 0.02
PARTS = 15


class Landed(NamedTuple):
    """A landing.

    Attributes:
        time: Since first touch [ms], shape [samples].
        pushed: Impulse of the floor until then [mN s], shape [samples].
        reading: σ_V and the largest stress.
        von_mises: Largest stress at the Gauss points [MPa], shape [tet_count, points].
    """

    time: Floats
    pushed: Floats
    reading: Reading
    von_mises: Floats


def bracket_coarse() -> Iterator[Result]:
    """A bracket one element thick for .15 ms, which CalculiX does in seconds."""
    yield from _against_calculix("contact", 4.0, 0.15)


def bracket_fine() -> Iterator[Result]:
    """The same in two layers for .1 ms."""
    yield from _against_calculix("contact_fine", 2.0, 0.1)


def _against_calculix(name: str, cell: float, window: float) -> Iterator[Result]:
    tets = _tilted(bracket(20.0, 8.0, 4.0, cell))
    test = DropTest(window=window, damping=0.0, law="st_venant_kirchhoff", added_mass=0.0, safety=0.5)
    mesh = with_nodes(tets, QUADRATIC)
    ours = _ours(tets, test)
    answer = calculix.landing(mesh, PLA, test.speed, window, 1e-3)
    theirs = _theirs(mesh, answer, test)
    note = f"CalculiX *DYNAMIC, EXPLICIT with GAPUNI, {len(tets.tets)} C3D10, {window:g} ms, {answer.seconds:.0f} s"
    yield compared(f"{name}: impulse of the floor", float(ours.pushed[-1]), float(theirs.pushed[-1]), IMPULSE, "mN s", note)
    one, other = (_means(landed) for landed in (ours, theirs))
    distance = np.linalg.norm(one - other) / np.linalg.norm(other)
    yield bounded(f"{name}: force of the floor over time, L2", float(distance), FORCE, f"{note}; means over {PARTS} parts of it")
    yield compared(f"{name}: σ_V", ours.reading.stress, theirs.reading.stress, STRESS, "MPa", note)
    distance = np.linalg.norm(ours.von_mises - theirs.von_mises) / np.linalg.norm(theirs.von_mises)
    yield bounded(f"{name}: largest von Mises, L2", float(distance), STRESS, note)


def _ours(tets: TetMesh, test: DropTest) -> Landed:
    result = drop(tets, PLA, UPRIGHT, test, device="cpu")
    history = result.history[0]
    pushed = np.cumsum(history.contact_force) * (history.time[1] - history.time[0])
    return Landed(history.time, pushed, Body(tets).read(result.corners[0], DROPPED), result.von_mises[0].astype(np.float64))


def _theirs(mesh: ElementMesh, answer: calculix.Landing, test: DropTest) -> Landed:
    """Stress from the displacements by the same formulas: it is the motion that is compared; the elements are by another case."""
    law, zero = law_named(test.law, PLA), np.zeros((len(mesh.connectivity), 4))
    points, corners = zero, zero
    for u in answer.displacement:
        H, at_corners = elasticity.displacement_gradients(mesh, u), elasticity.corner_gradients(mesh, u)
        points, corners = (
            np.maximum(before, elasticity.von_mises(elasticity.cauchy_stress(now, law.first_piola(now))))
            for before, now in ((points, H), (corners, at_corners))
        )
    time, force = np.append(0.0, answer.time), np.append(0.0, answer.force)
    pushed = np.append(0.0, np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(time)))
    return Landed(time, pushed, Body(mesh.tets).read(corners, DROPPED), points)


def _tilted(tets: TetMesh) -> TetMesh:
    """The body with TILT turned upright, its lowest vertex on z = 0."""
    up = TILT / np.linalg.norm(TILT)
    axis = np.cross(up, UPRIGHT[0])
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turned = tets.vertices @ (np.eye(3) + cross + cross @ cross / (1.0 + up[2])).T
    return tets.moved(turned - [0.0, 0.0, turned[:, 2].min()])


def _means(landed: Landed) -> Floats:
    """Mean force in each of PARTS equal parts of the time [N]: a node that hits a stiff spring rings on it."""
    edges = np.linspace(0.0, landed.time[-1], PARTS + 1)
    return np.diff(np.interp(edges, landed.time, landed.pushed)) / np.diff(edges)
