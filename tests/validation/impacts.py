"""Bodies that hit the floor: wave theory, Hertz's contact, CalculiX's explicit dynamics, and our own arithmetic in double precision."""

from __future__ import annotations

import itertools
import math
import platform
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mechstyle.errors import MissingPiece
from mechstyle.fea import elasticity
from mechstyle.fea.discretisation import discretise
from mechstyle.fea.drop import GRAVITY, Drop, DropTest, available_devices, drop, scheme_for
from mechstyle.fea.elasticity import law_named
from mechstyle.fea.elements import ELEMENTS, LINEAR, QUADRATIC, ElementMesh, with_nodes
from mechstyle.fea.explicit import RECORD_EVERY
from mechstyle.fea.orientations import directions
from mechstyle.fea.permanent_set import quantile
from mechstyle.fea.snapshots import snapshots
from mechstyle.records.material import LIBRARY, Material
from mechstyle.records.mesh import Floats, TetMesh
from support import hyperelasticity
from validation import calculix
from validation.cases import Result, bounded, compared
from validation.meshes import ball, box, bracket

PLA, UPRIGHT = LIBRARY["PLA"], ((0.0, 0.0, 1.0),)
SAME = 1e-3
FOLDER = str(Path(__file__).parents[1])
"""Where this package is found."""
ELSEWHERE = """
import sys
from mechstyle._warp import wp
own = wp.config.cpu_compiler_flags or "-march=native"  # None means the same
wp.config.cpu_compiler_flags = own.replace("-march=native", "-target-cpu x86-64")
sys.path.insert(0, sys.argv[2])
from validation.impacts import _plate
sys.stdout.buffer.write(_plate(sys.argv[1]).tobytes())
"""
"""The plate in a process whose kernels are compiled for another processor."""


def bar() -> Iterator[Result]:
    """A bar that lands on its end carries ρ c v until the wave comes back from the other end, after 2 L / c."""
    length, c = 100.0, PLA.bar_wave_speed
    for name in ELEMENTS:
        tets = box((2, 2, 40), (5.0, 5.0, length))
        test = DropTest(window=0.13, element=name, law="st_venant_kirchhoff", plastic=False)
        history = drop(tets, PLA, UPRIGHT, test, device="cpu").history[0]
        plateau = (history.time > 0.15 * 2.0 * length / c) & (history.time < 0.9 * 2.0 * length / c)
        pressure = float(history.contact_force[plateau].mean()) / 25.0
        yield compared(f"bar: {name}, pressure", pressure, PLA.density * c * DropTest().speed, 0.005, "MPa", "ρ c v")


def rod() -> Iterator[Result]:
    """A steel rod on a wall, Ansys VM265 after Carpenter, Taylor and Katona 1991: it leaves after 2 L / c as fast as it came.

    A rod in theory is not wider where it is pressed, hence ν = 0; one of steel, ten times as long as wide, keeps 4 % in its vibrations.
    """
    inch, speed, length = 25.4, 202.2e-3 * 25.4, 254.0
    steel = Material(name="steel", youngs_modulus=206.8e3, poisson_ratio=0.0, density=7.8e-3, yield_strength=1e3)
    back = 2.0 * length / steel.bar_wave_speed
    for name, counts in (("tet4", (1, 1, 240)), ("tet10", (4, 4, 120))):
        test = DropTest(height=speed**2 / (2.0 * GRAVITY), window=1.2 * back, damping=0.0, element=name, plastic=False, added_mass=0.0)
        history = drop(box(counts, (inch, inch, length)), steel, UPRIGHT, test, device="cpu").history[0]
        force, half = history.contact_force, 0.5 * steel.density * steel.bar_wave_speed * speed * inch**2
        last = int(np.flatnonzero(force > half)[-1])
        share = (force[last] - half) / (force[last] - force[last + 1])
        middle = share - 0.5  # a force is the mean since the sample before
        release = float(history.time[last] + middle * history.time[1])
        rebound = float(history.momentum[-1] / (steel.density * inch**2 * length))
        yield compared(f"rod: {name}, release", 1e3 * release, 1e3 * back, 0.02, "µs", "2 L / c, where half of the force is gone")
        yield compared(f"rod: {name}, speed after it", rebound, speed, 0.02, "m/s", "the speed before it")


def bar_calculix() -> Iterator[Result]:
    """The stress in a bar on the floor while the wave runs up: linear elements in CalculiX's explicit dynamics, end face held."""
    mesh = with_nodes(box((4, 4, 40), (5.0, 5.0, 50.0)), LINEAR)
    window = 0.04
    test = DropTest(window=window, damping=0.0, law="st_venant_kirchhoff", plastic=False, element="tet4", added_mass=0.0, safety=0.25)
    theirs = calculix.impact(mesh, PLA, mesh.nodes[:, 2] < 1e-9, test.speed, window, 1e-4)
    u = snapshots(mesh.tets, PLA, test, frames=4).displacement[-1].astype(np.float64)
    H = elasticity.displacement_gradients(mesh, u)
    ours = elasticity.von_mises(hyperelasticity.cauchy_stress(H, hyperelasticity.first_piola(law_named(test.law, PLA), H)))
    reference = elasticity.von_mises(theirs.stress)
    note = "CalculiX *DYNAMIC, EXPLICIT, 3840 C3D4, after 0.04 ms"
    yield bounded("bar_calculix: von Mises, L2", _distance(ours, reference), 0.015, note)
    yield bounded("bar_calculix: displacement, L2", _distance(u, theirs.displacement), 0.005, note)


def sphere() -> Iterator[Result]:
    """A ball on the floor: force and duration of Hertz's contact (Johnson, Contact Mechanics, §11.4), for the mass that was meshed.

    St. Venant–Kirchhoff's law: the strain of some per cent under the contact stiffens a neo-Hookean ball by 2 %, which is not in Hertz.
    """
    radius, test = 20.0, DropTest(window=0.2, law="st_venant_kirchhoff", plastic=False)
    tets = ball(radius, 16, 5.0)
    stiffness = PLA.youngs_modulus / (1.0 - PLA.poisson_ratio**2)
    result = drop(tets, PLA, UPRIGHT, test)
    mass = float(tets.volumes.sum()) * PLA.density * (1.0 + result.added_mass)
    depth = (15.0 * mass * test.speed**2 / (16.0 * math.sqrt(radius) * stiffness)) ** 0.4
    force = 4.0 / 3.0 * stiffness * math.sqrt(radius) * depth**1.5
    duration = 2.94 * depth / test.speed
    history = result.history[0]
    measured = history.contact_force
    contact = float(history.time[measured > 0.0][-1])
    impulse = float(measured.sum() * (history.time[1] - history.time[0]))
    yield compared("sphere: mean force", impulse / contact, 2.0 * mass * test.speed / duration, 0.01, "N", "Hertz")
    own_modes = "Hertz; the ball's own modes ride on his pulse, on 200k elements they add 1.2 %"
    yield compared("sphere: largest force", float(measured.max()), force, 0.02, "N", own_modes)
    yield compared("sphere: contact time", contact, duration, 0.02, "ms", "Hertz, quasi-static")


def precision() -> Iterator[Result]:
    """The kernels' single precision against the same steps in double precision: von Mises over a whole impact."""
    tets = box((3, 3, 4), (12.0, 10.0, 16.0))
    for name, element in ELEMENTS.items():
        test, normals = DropTest(window=0.05, element=name, plastic=False), directions(3)
        single = drop(tets, PLA, normals, test, device="cpu").von_mises
        double = np.stack([_in_double_precision(tets, test, element.name, normal) for normal in normals])
        yield bounded(f"precision: {name}, von Mises, L2", _distance(single, double), SAME, "float64 numpy, three orientations")


def devices() -> Iterator[Result]:
    """CUDA against CPU: von Mises in five orientations."""
    if len(available_devices()) == 1:
        raise MissingPiece("there is no CUDA device here, so CPU and CUDA were not compared")
    for name in ELEMENTS:
        yield bounded(f"devices: {name}, von Mises, L2", _distance(_plate(name, "cuda"), _plate(name)), SAME, "CPU against CUDA")


def instructions() -> Iterator[Result]:
    """This processor's instructions against the oldest that x86-64 processors have in common: von Mises, and its largest."""
    if platform.machine() not in ("x86_64", "AMD64"):
        raise MissingPiece(f"the oldest instructions are known for x86-64, not for {platform.machine()}, so they were not compared")
    for name in ELEMENTS:
        here = _plate(name)
        answer = subprocess.run([sys.executable, "-c", ELSEWHERE, name, FOLDER], check=True, stdout=subprocess.PIPE).stdout
        there = np.frombuffer(answer, here.dtype)
        largest, note = float(here.max()), "x86-64 without extensions against this processor"
        yield compared(f"instructions: {name}, largest von Mises", largest, float(there.max()), 1e-5, "MPa", note)
        yield bounded(f"instructions: {name}, von Mises, L2", _distance(here.ravel(), there), SAME, note)


def _plate(element: str, device: str = "cpu") -> NDArray[np.float32]:
    """A plate dropped in five orientations: von Mises [MPa], shape [orientations, tet_count, points]."""
    return drop(box((16, 16, 2), (40.0, 40.0, 5.0)), PLA, directions(5), DropTest(window=0.3, element=element), device=device).von_mises


def energy() -> Iterator[Result]:
    """Energy balance of an undamped drop: work of gravity against kinetic, strain, contact and damping energy, and plastic work.

    A body that yields takes a smaller step: at the full one, crushed tetrahedra are softer, and that takes energy.
    """
    tets = box((4, 3, 4), (12.0, 10.0, 16.0))
    for name, plastic in itertools.product(ELEMENTS, (False, True)):
        test = DropTest(window=0.5, damping=0.0, element=name, plastic=plastic, safety=0.6 if plastic else 0.95)
        result: Drop = drop(tets, PLA, directions(5), test, device="cpu")
        error = max(np.abs(history.damping_loss).max() / history.kinetic[0] for history in result.history)
        words = f"energy: {name}, {'plastic' if plastic else 'elastic'}, balance"
        yield bounded(words, float(error), 0.001, "largest gap over five undamped drops")


def _in_double_precision(tets: TetMesh, test: DropTest, element: str, normal: Floats) -> Floats:
    """The drop by the numpy reference: running maximum of von Mises [MPa], shape [tet_count, points]."""
    body = discretise(tets, PLA, test.added_mass, LINEAR if element == "tet4" else QUADRATIC)
    scheme = scheme_for(body, PLA, test)
    masses, damping = body.masses[body.place][:, None], np.empty_like(scheme.damping)
    damping[body.tet_order] = scheme.damping
    heights = body.mesh.nodes @ normal - (body.mesh.nodes @ normal).min()
    u, v = np.zeros_like(body.mesh.nodes), np.tile(-scheme.speed * normal, (len(masses), 1))
    peak = np.zeros((len(tets.tets), body.mesh.element.points))
    for step in range(scheme.steps):
        H, rate = (elasticity.displacement_gradients(body.mesh, field) for field in (u, v))
        H = H + damping[:, None, None, None] * rate
        if step % RECORD_EVERY == 0:
            peak = np.maximum(peak, elasticity.von_mises(hyperelasticity.cauchy_stress(H, hyperelasticity.first_piola(scheme.law, H))))
        v = v + scheme.time_step * (hyperelasticity.forces_of(body.mesh, scheme.law, H) / masses - scheme.gravity * normal)
        gap = heights + (u + scheme.time_step * v) @ normal
        v = v + np.maximum(-gap / scheme.time_step, 0.0)[:, None] * normal
        u = u + scheme.time_step * v
    return peak


def _distance(one: ArrayLike, other: ArrayLike) -> float:
    """Relative distance in the L2 norm."""
    return float(np.linalg.norm(np.subtract(one, other)) / np.linalg.norm(other))


TILT = np.array([0.35, 0.2, 1.0])
"""Floor normal in the frame of the bracket: it lands on a corner, its legs bend and it turns."""
IMPULSE, FORCE, STRESS = 0.01, 0.04, 0.02
PARTS = 15


class Landed(NamedTuple):
    """A landing.

    Attributes:
        time: Since first touch [ms], shape [samples].
        pushed: Impulse of the floor until then [mN s], shape [samples].
        reading: The von Mises stress that more than 64 mm³ exceed [MPa].
        von_mises: Largest stress at the Gauss points [MPa], shape [tet_count, points].
    """

    time: Floats
    pushed: Floats
    reading: float
    von_mises: Floats


def bracket_of_calculix(name: str, cell: float, window: float) -> Iterator[Result]:
    """A bracket of elements of a size [mm] that lands on its corner, for a while [ms], in CalculiX as well."""
    tets, up = bracket(20.0, 8.0, 4.0, cell), TILT / np.linalg.norm(TILT)
    x, y, z = np.cross(up, UPRIGHT[0])
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turned = tets.vertices @ (np.eye(3) + cross + cross @ cross / (1.0 + up[2])).T  # TILT upright, the lowest vertex on z = 0
    tets = tets.moved(turned - [0.0, 0.0, turned[:, 2].min()])
    test = DropTest(window=window, damping=0.0, law="st_venant_kirchhoff", plastic=False, added_mass=0.0, safety=0.5)
    mesh = with_nodes(tets, QUADRATIC)
    result = drop(tets, PLA, UPRIGHT, test, device="cpu")
    history = result.history[0]
    pushed = np.cumsum(history.contact_force) * (history.time[1] - history.time[0])
    ours = Landed(history.time, pushed, quantile(result.von_mises[0], tets.volumes, 64.0), result.von_mises[0].astype(np.float64))
    answer = calculix.landing(mesh, PLA, test.speed, window, 1e-3)
    theirs = _theirs(mesh, answer, test)
    note = f"CalculiX *DYNAMIC, EXPLICIT with GAPUNI, {len(tets.tets)} C3D10, {window:g} ms, {answer.seconds:.0f} s"
    yield compared(f"{name}: impulse of the floor", float(ours.pushed[-1]), float(theirs.pushed[-1]), IMPULSE, "mN s", note)
    one, other = (_means(landed) for landed in (ours, theirs))
    distance = np.linalg.norm(one - other) / np.linalg.norm(other)
    yield bounded(f"{name}: force of the floor over time, L2", float(distance), FORCE, f"{note}; means over {PARTS} parts of it")
    yield compared(f"{name}: stress over 64 mm³", ours.reading, theirs.reading, STRESS, "MPa", note)
    distance = np.linalg.norm(ours.von_mises - theirs.von_mises) / np.linalg.norm(theirs.von_mises)
    yield bounded(f"{name}: largest von Mises, L2", float(distance), STRESS, note)


def _theirs(mesh: ElementMesh, answer: calculix.Landing, test: DropTest) -> Landed:
    """Stress from the displacements by the same formulas: it is the motion that is compared; the elements are by another case."""
    law, points = law_named(test.law, PLA), np.zeros((len(mesh.connectivity), 4))
    for u in answer.displacement:
        H = elasticity.displacement_gradients(mesh, u)
        points = np.maximum(points, elasticity.von_mises(hyperelasticity.cauchy_stress(H, hyperelasticity.first_piola(law, H))))
    time, force = np.append(0.0, answer.time), np.append(0.0, answer.force)
    pushed = np.append(0.0, np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(time)))
    return Landed(time, pushed, quantile(points, mesh.tets.volumes, 64.0), points)


def _means(landed: Landed) -> Floats:
    """Mean force in each of PARTS equal parts of the time [N]: a node that hits a stiff spring rings on it."""
    edges = np.linspace(0.0, landed.time[-1], PARTS + 1)
    return np.diff(np.interp(edges, landed.time, landed.pushed)) / np.diff(edges)
