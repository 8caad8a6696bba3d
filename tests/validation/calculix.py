"""CalculiX as a second opinion: write its input, run it, read what it prints. It wants mm, t and s; that is converted here."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mechstyle.errors import MissingPiece, SimulationFailed
from mechstyle.fea.elements import ElementMesh
from mechstyle.records.material import Material
from mechstyle.records.mesh import Floats

TONNES_PER_GRAM, SECONDS_PER_MILLISECOND = 1e-6, 1e-3
NODE_ORDER = {4: [0, 1, 2, 3], 10: [0, 1, 2, 3, 4, 7, 5, 6, 8, 9]}
"""CalculiX numbers the middles of the edges 01, 12, 02, 03, 13, 23."""
SECONDS = 1800
PENALTY, NO_FORCE = 1e5, 1e-3
"""Stiffness of a floor node [N/mm], and what it is asked to pull with when far away [N]. A fifth of the stiffness gives way, by 3 % of the
stress beside the contact; with four times as much the force rings faster than FRAMES can follow."""
FRAMES = 120
"""Moments of a landing that are printed, about."""
INCREMENT = 0.05
"""Largest share of a way that is gone at a time."""


@dataclass(frozen=True, eq=False)
class Answer:
    """Results CalculiX printed at the end of its step.

    Attributes:
        displacement: Of the nodes [mm], shape [node_count, 3].
        stress: Cauchy stress at the Gauss points [MPa], shape [tet_count, points, 3, 3].
        seconds: Wall time of the run [s].
    """

    displacement: Floats
    stress: Floats
    seconds: float


@dataclass(frozen=True, eq=False)
class Landing:
    """A landing on the floor, moment by moment.

    Attributes:
        time: Since the start [ms], shape [frames].
        displacement: Of the nodes [mm], shape [frames, node_count, 3].
        force: Of the floor [N], shape [frames].
        seconds: Wall time of the run [s].
    """

    time: Floats
    displacement: Floats
    force: Floats
    seconds: float


def available() -> bool:
    """Whether there is a `ccx` to run."""
    return shutil.which("ccx") is not None


def static(mesh: ElementMesh, material: Material, fixed: NDArray[np.bool_], forces: Floats) -> Answer:
    """Small-strain statics: nodes held in all directions and forces on nodes [N], shape [node_count, 3]."""
    loads = "".join(f"{node + 1},{axis + 1},{forces[node, axis]:.9e}\n" for node, axis in np.argwhere(forces != 0.0))
    step = f"*BOUNDARY\nFIXED,1,3\n*STEP\n*STATIC\n*CLOAD\n{loads}"
    return _run(mesh, material, {"FIXED": fixed}, step)


def impact(
    mesh: ElementMesh, material: Material, held: NDArray[np.bool_], speed: float, window: float, step: float, *, plastic: bool = False
) -> Answer:
    """Explicit dynamics of a body that moves down the z-axis while the given nodes cannot.

    Args:
        mesh: The body [mm].
        material: Its material.
        held: Nodes held along z, shape [node_count].
        speed: Initial speed [mm/ms].
        window: Simulated time [ms].
        step: Time step [ms].
        plastic: Whether the material flows where it reaches its yield strength.
    """
    velocity = -speed / SECONDS_PER_MILLISECOND
    times = f"{step * SECONDS_PER_MILLISECOND:.6e},{window * SECONDS_PER_MILLISECOND:.6e}"
    start = f"*INITIAL CONDITIONS,TYPE=VELOCITY\nNALL,3,{velocity:.6f}\n*BOUNDARY\nHELD,3,3\n"
    return _run(mesh, material, {"HELD": held}, f"{start}*STEP,INC=10000000,NLGEOM\n*DYNAMIC,EXPLICIT\n{times}\n", plastic=plastic)


def most_force(mesh: ElementMesh, material: Material, held: NDArray[np.bool_], moved: NDArray[np.bool_], way: Floats) -> float:
    """Largest force [N] along the way on which some nodes are moved while others are held in all directions, with large displacements.

    Args:
        mesh: The body [mm].
        material: Its material, which flows where it reaches its yield strength.
        held: Nodes that are held, shape [node_count].
        moved: Nodes that are moved, along one axis, free along the others, shape [node_count].
        way: How far they are moved in the end [mm], shape [3], zero along all axes but one.
    """
    axis = int(np.flatnonzero(way)[0])
    step = f"*BOUNDARY\nHELD,1,3\n*STEP,INC=1000,NLGEOM\n*STATIC\n{INCREMENT},1.,1e-6,{INCREMENT}\n"
    step += f"*BOUNDARY\nMOVED,{axis + 1},{axis + 1},{way[axis]:.9e}\n"
    prints = "*NODE PRINT,NSET=MOVED,TOTALS=ONLY\nRF\n*END STEP\n"
    text, _ = _job(_model(mesh, material, {"HELD": held, "MOVED": moved}, plastic=True) + step + prints)
    rows = [line.split() for line in text.splitlines()]
    totals = [float(row[axis]) for row in rows if len(row) == 3]
    return max(abs(total) for total in totals)


def landing(mesh: ElementMesh, material: Material, speed: float, window: float, step: float) -> Landing:
    """Explicit dynamics of a body that falls on the floor z = 0, which pushes without friction through one-sided springs of PENALTY.

    Args:
        mesh: The body above the floor [mm].
        material: Its material.
        speed: Initial speed along −z [mm/ms].
        window: Simulated time [ms].
        step: Longest time step [ms]; CalculiX takes shorter ones where it thinks fit.
    """
    reached = np.flatnonzero(mesh.nodes[:, 2] < 1.2 * speed * window)
    first_node, first_element = len(mesh.nodes) + 1, len(mesh.connectivity) + 1
    lines = ["*NODE,NSET=GROUND"]
    lines += [f"{first_node + k},{x:.12e},{y:.12e},0.0" for k, (x, y, _) in enumerate(mesh.nodes[reached])]
    for k, node in enumerate(reached):
        lines += [f"*ELEMENT,TYPE=GAPUNI,ELSET=GAP{k}", f"{first_element + k},{first_node + k},{node + 1}"]
        lines += [f"*GAP,ELSET=GAP{k}", f"{mesh.nodes[node, 2]:.12e},0.0,0.0,1.0,,{PENALTY:g},{NO_FORCE:g}"]
    lines += ["*BOUNDARY", "GROUND,1,3", "*INITIAL CONDITIONS,TYPE=VELOCITY", f"NALL,3,{-speed / SECONDS_PER_MILLISECOND:.6f}"]
    end = window * SECONDS_PER_MILLISECOND
    lines += ["*TIME POINTS,NAME=MOMENTS,GENERATE", f"{end / FRAMES:.9e},{end:.9e},{end / FRAMES:.9e}"]
    lines += ["*STEP,INC=10000000,NLGEOM", "*DYNAMIC,EXPLICIT", f"{step * SECONDS_PER_MILLISECOND:.6e},{end:.6e}"]
    lines += ["*NODE PRINT,NSET=NALL,TIME POINTS=MOMENTS", "U", "*END STEP"]
    text, seconds = _job(_model(mesh, material, {}) + "\n".join(lines) + "\n")
    time, displacement = _read_moments(text, len(mesh.nodes))
    below = np.maximum(-(mesh.nodes[reached, 2] + displacement[:, reached, 2]), 0.0)
    return Landing(time, displacement, PENALTY * below.sum(axis=1), seconds)


def _run(mesh: ElementMesh, material: Material, sets: Mapping[str, NDArray[np.bool_]], step: str, *, plastic: bool = False) -> Answer:
    """Write, run and read a job with one result at its end."""
    prints = "*NODE PRINT,NSET=NALL,FREQUENCY=1000000\nU\n*EL PRINT,ELSET=EALL,FREQUENCY=1000000\nS\n*END STEP\n"
    text, seconds = _job(_model(mesh, material, sets, plastic=plastic) + step + prints)
    return Answer(*_read(text, mesh), seconds)


def _job(deck: str) -> tuple[str, float]:
    """Run an input in a folder of its own: what it printed, and its wall time [s].

    MissingPiece without CalculiX, SimulationFailed with its last words if it does not finish.
    """
    if not available():
        raise MissingPiece("CalculiX is not installed: install it (Debian: apt-get install calculix-ccx) or leave its cases out")
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "job.inp").write_text(deck)
        started = time.perf_counter()
        one_core = {**os.environ, "OMP_NUM_THREADS": "1"}
        job = subprocess.run(["ccx", "job"], cwd=folder, capture_output=True, text=True, timeout=SECONDS, check=False, env=one_core)
        seconds = time.perf_counter() - started
        if "Job finished" not in job.stdout:
            raise SimulationFailed(f"CalculiX did not finish: {' '.join(job.stdout.split()[-40:])}")
        return Path(folder, "job.dat").read_text(), seconds


def _model(mesh: ElementMesh, material: Material, sets: Mapping[str, NDArray[np.bool_]], *, plastic: bool = False) -> str:
    """Nodes, elements, material and node sets; what hardens does so linearly in the plastic strain."""
    nodes = mesh.element.nodes
    lines = ["*NODE,NSET=NALL"]
    lines += [f"{number},{x:.12e},{y:.12e},{z:.12e}" for number, (x, y, z) in enumerate(mesh.nodes, start=1)]
    lines += [f"*ELEMENT,TYPE=C3D{nodes},ELSET=EALL"]
    lines += [f"{number},{','.join(map(str, row))}" for number, row in enumerate(mesh.connectivity[:, NODE_ORDER[nodes]] + 1, start=1)]
    lines += ["*MATERIAL,NAME=M", "*ELASTIC", f"{material.youngs_modulus:.12g},{material.poisson_ratio:.12g}"]
    if plastic:
        strength, far = material.yield_strength, 10.0
        lines += ["*PLASTIC", f"{strength:.12g},0.", f"{strength + far * material.hardening:.12g},{far:g}"]
    lines += ["*DENSITY", f"{material.density * TONNES_PER_GRAM:.12e}", "*SOLID SECTION,ELSET=EALL,MATERIAL=M"]
    for name, chosen in sets.items():
        lines += [f"*NSET,NSET={name}", *(str(node + 1) for node in np.flatnonzero(chosen))]
    return "\n".join(lines) + "\n"


def _read(text: str, mesh: ElementMesh) -> tuple[Floats, Floats]:
    """The last printed displacements and stresses of a .dat file."""
    displacement = np.zeros_like(mesh.nodes)
    stress = np.zeros((len(mesh.connectivity), mesh.element.points, 3, 3))
    for line in text.splitlines():
        words = line.split()
        if len(words) == 4 and words[0].isdigit():
            displacement[int(words[0]) - 1] = [float(word) for word in words[1:]]
        elif len(words) == 8 and words[0].isdigit():
            xx, yy, zz, xy, xz, yz = (float(word) for word in words[2:])
            stress[int(words[0]) - 1, int(words[1]) - 1] = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    return displacement, stress


def _read_moments(text: str, count: int) -> tuple[Floats, Floats]:
    """Times since the start [ms] and displacements of the nodes [mm], [frames, count, 3], of a .dat file."""
    times, rows = list[float](), list[list[float]]()
    for line in text.splitlines():
        words = line.split()
        if words[:1] == ["displacements"]:
            times.append(float(words[-1]) / SECONDS_PER_MILLISECOND)
        elif len(words) == 4 and words[0].isdigit():
            rows.append([float(word) for word in words[1:]])
    return np.array(times), np.array(rows).reshape(len(times), count, 3)
