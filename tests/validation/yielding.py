"""Bodies that yield: Taylor's bars, an elastic-plastic wave, and what grooved, necked, stout and slender bars bear."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import msgspec
import numpy as np
from scipy.optimize import brentq

from mechstyle.fea.backends.cpu import CoreBody
from mechstyle.fea.discretisation import discretise
from mechstyle.fea.drop import GRAVITY, DropTest, drop, scheme_for
from mechstyle.fea.elasticity import law_named
from mechstyle.fea.elements import QUADRATIC, element_named, with_nodes
from mechstyle.fea.explicit import Starts
from mechstyle.fea.loading import MOST
from mechstyle.fea.statics import StaticTest
from mechstyle.records.load_cases import Load, LoadCase, Patch, Support
from mechstyle.records.material import LIBRARY, Material
from mechstyle.records.mesh import Floats, TetMesh
from support.plasticity import Point
from validation import calculix
from validation.cases import Result, compared
from validation.meshes import box, grooved_bar, necked_bar, upright_bar

PLA = LIBRARY["PLA"]
PERFECT = msgspec.structs.replace(PLA, hardening=0.0)
UPRIGHT = np.array([[0.0, 0.0, 1.0]])
COPPER = Material(name="copper", youngs_modulus=117e3, poisson_ratio=0.35, density=8.93e-3, yield_strength=400.0, hardening=100.0)
ALUMINIUM = Material(name="aluminium", youngs_modulus=70e3, poisson_ratio=0.3, density=2.7e-3, yield_strength=420.0, hardening=100.0)
LENGTH, WAVE, LOAD = 0.03, 0.02, 0.1
NEVER = 1e6
"""A tolerance that only what gives way exceeds [mm]."""


# --- impacts ----------------------------------------------------------------------------------------------------------


def taylor_copper() -> Iterator[Result]:
    """Taylor's bar of copper, 32.4 x 3.2 mm, at 227 m/s (Wilkins and Guinan 1973, Simo 1992), for 80 µs: plastic strains up to 3."""
    tets = upright_bar(3.2, 32.4, 6, 18)
    found = tets.vertices + _struck(tets, COPPER, 227.0, 0.08)
    length, radius = float(np.ptp(found[:, 2])), float(np.hypot(*found[:, :2].T).max())
    note = "Sierra/SM, 1.5 million composite tetrahedra (Foulk et al. 2021), by the Taylor bar benchmark of Carina.jl"
    yield compared("taylor_copper: length", length, 21.43, LENGTH, "mm", note)
    yield compared("taylor_copper: radius", radius, 7.23, LENGTH, "mm", note)


def taylor_aluminium() -> Iterator[Result]:
    """A bar of aluminium, 23.47 x 3.81 mm, at 478 m/s, geometry and material of Ansys VMC8, for 45 µs: the same elements in CalculiX."""
    tets, speed, window = upright_bar(3.81, 23.47, 2, 8), 478.0, 0.045
    mesh = with_nodes(tets, QUADRATIC)
    answer = calculix.impact(mesh, ALUMINIUM, mesh.nodes[:, 2] < 1e-9, speed, window, 1e-5, plastic=True)
    ours, theirs = tets.vertices + _struck(tets, ALUMINIUM, speed, window), mesh.nodes + answer.displacement
    note = f"CalculiX *DYNAMIC, EXPLICIT with *PLASTIC, {len(tets.tets)} C3D10; what Ansys prints was not at hand"
    yield compared("taylor_aluminium: length", float(np.ptp(ours[:, 2])), float(np.ptp(theirs[:, 2])), LENGTH, "mm", note)
    radius, reference = (float(np.hypot(*each[:, :2].T).max()) for each in (ours, theirs))
    yield compared("taylor_aluminium: radius", radius, reference, LENGTH, "mm", note)


def _struck(tets: TetMesh, material: Material, speed: float, window: float) -> Floats:
    """Displacement of the vertices of a body that hits the floor [mm], shape [vertex_count, 3], faster than any height of a drop test."""
    test = DropTest(window=window, safety=0.6, added_mass=0.0)
    body = discretise(tets, material, test.added_mass, element_named(test.element))
    scheme = replace(scheme_for(body, material, test), speed=speed)
    (batch,) = CoreBody(body).batches(scheme, Starts.falling(body.arms, UPRIGHT, speed))
    batch.advance(scheme.samples)
    return np.asarray(batch.motion()[0][0][body.place][: len(tets.vertices)], np.float64)


def plastic_bar() -> Iterator[Result]:
    """A bar that lands on its end at 30 m/s: an elastic wave to the yield strength, a slower plastic one behind it.

    The textbook's linear strains are off by a tenth in ε_p at h = 300 MPa: pushed together, a bar pushes back on its first section with
    P = τ/λ, so the modulus dP/de of the second wave is (h' + τ)/λ² and not h' = E h/(E + h), 46 MPa more of 276.
    """
    speed, side = 30.0, 2.5
    for hardening in (300.0, 1000.0):
        material = msgspec.structs.replace(PLA, hardening=hardening)
        tets = box((2, 2, 160), (side, side, 200.0))
        test = DropTest(height=speed**2 / (2.0 * GRAVITY), window=0.2, safety=0.6)
        found = drop(tets, material, UPRIGHT, test, device="cpu")
        history, height = found.history[0], tets.vertices[tets.tets].mean(axis=1)[:, 2]
        pressure = float(history.contact_force[history.time > 0.03].mean()) / side**2
        behind = (height > 3.0 * side) & (height < 0.5 * history.time[-1] * math.sqrt(hardening / material.density))
        strain = float(np.average(found.plastic_strain[0].mean(axis=1)[behind], weights=tets.volumes[behind]))
        expected, flowed = _behind_the_plastic_wave(material, speed)
        name, note = f"plastic_bar: h = {hardening:g} MPa", "two jumps of uniaxial stress, force over the first section"
        yield compared(f"{name}, pressure", pressure, expected, WAVE, "MPa", note)
        yield compared(f"{name}, plastic strain", strain, flowed, WAVE, "", note)


def _behind_the_plastic_wave(material: Material, speed: float) -> tuple[float, float]:
    """Force over the undeformed section [MPa] and plastic strain behind the second wave, at which the bar stands still.

    Across a wave momentum and length are kept: (Δv)² = ΔP Δe/ρ, e the shortening per length (Rankine and Hugoniot), since the modulus
    rises with the shortening in both branches.
    """
    shortening = np.concatenate([np.linspace(0.002, 0.012, 6), np.linspace(0.0121, 0.015, 200), np.linspace(0.0152, 0.06, 200)])
    point, side, rows = Point(law_named("stable_neo_hookean", material), material.yield_strength, material.hardening), 1.0, []
    for e in shortening:
        side = brentq(partial(_pressed_aside, point, 1.0 - e), side - 0.005, side + 0.02)
        point, stress = point.at(np.diag([side, side, 1.0 - e]))
        rows.append((-stress[2, 2] / (1.0 - e), point.strain))
    force, flowed = np.array(rows).T
    last = int(np.flatnonzero(flowed == 0.0)[-1])
    first = math.sqrt(force[last] * shortening[last] / material.density)
    second = np.sqrt((force[last:] - force[last]) * (shortening[last:] - shortening[last]) / material.density)
    return float(np.interp(speed, first + second, force[last:])), float(np.interp(speed, first + second, flowed[last:]))


def _pressed_aside(point: Point, along: float, side: float) -> float:
    """Stress across [MPa] of a point that is stretched along and across."""
    return float(point.at(np.diag([side, side, along]))[1][0, 0])


# --- loads ------------------------------------------------------------------------------------------------------------


def groove() -> Iterator[Result]:
    """A bar with a groove all round that is bent, without hardening: what it bears, beside the same elements in CalculiX."""
    bar = grooved_bar()
    mesh = with_nodes(bar, QUADRATIC)
    x, _, z = mesh.nodes.T
    middle = (x > 32.0 - 1e-9) & (np.abs(z - 4.0) < 1e-6)  # of the end, which may turn: a whole face that is moved may not
    theirs = calculix.most_force(mesh, PERFECT, x < 1e-9, middle, np.array([0.0, 0.0, -2.5]))
    note = "CalculiX *PLASTIC, NLGEOM, 1458 C3D10, moved by 2.5 mm: its largest force"
    yield compared("groove: collapse", _borne(bar, PERFECT, (0.0, 0.0, -52.0)), theirs, LOAD, "N", note)


def neck() -> Iterator[Result]:
    """A neck between two blocks that is pulled: it becomes thinner, so that large displacements bear a sixth less than small ones."""
    bar = necked_bar()
    mesh = with_nodes(bar, QUADRATIC)
    x = mesh.nodes[:, 0]
    theirs = calculix.most_force(mesh, PLA, x < 1e-9, x > 11.0 - 1e-9, np.array([0.6, 0.0, 0.0]))
    note = "CalculiX *PLASTIC, NLGEOM, 708 C3D10, pulled by 0.6 mm: its largest force; 1375 N with small displacements"
    yield compared("neck: collapse", _borne(bar, PLA, (1375.0, 0.0, 0.0)), theirs, LOAD, "N", note)


def collapse() -> Iterator[Result]:
    """A stout cantilever bears its plastic moment, σ_y b h²/4, and a slender strut the load of Euler, π² E I/(4 L²)."""
    hinge = PLA.yield_strength * 6.0**3 / 4.0 / 60.0
    beam = _borne(box((20, 2, 2), (60.0, 6.0, 6.0)), PERFECT, (0.0, 0.0, -hinge))
    yield compared("collapse: cantilever 60 x 6 x 6 mm", beam, hinge, LOAD, "N", "plastic hinge")
    euler = math.pi**2 * PLA.youngs_modulus * 2.0**4 / 12.0 / (4.0 * 100.0**2)
    strut = _borne(box((30, 1, 1), (100.0, 2.0, 2.0)), PLA, (-2.0 * euler, 0.0, 0.0))
    yield compared("collapse: strut 100 x 2 x 2 mm", strut, euler, LOAD, "N", "Euler, held at one end")


def _borne(tets: TetMesh, material: Material, force: tuple[float, float, float]) -> float:
    """The most [N] that a part bears, clamped at its near end along x, of a force on its far end; at most MOST times the force."""
    near, far = tets.vertices[:, 0].min(), tets.vertices[:, 0].max()
    clamped, end = Patch(plane=(near, 0, 0, -1, 0, 0)), Patch(plane=(far, 0, 0, 1, 0, 0))
    case = LoadCase(name="load", supports=(Support(at=clamped),), loads=(Load(at=end, force=force),))
    found = StaticTest(tets, (case,)).loaded(tets, material, tolerance=NEVER)["load"]
    return (found.result.factor if found.result.reached else MOST) * float(np.linalg.norm(force))
