"""Estimate of the falls and the time of a run.

Before it begins it is made from the size of its mesh, or from what falls took on this machine; before its first fall from its very
tetrahedra.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from mechstyle.fea.discretisation import discretise
from mechstyle.fea.drop import body_on, tracks_for
from mechstyle.fea.elements import element_named
from mechstyle.fea.explicit import cores as cores_allowed
from mechstyle.fea.explicit import damped_step, no_progress
from mechstyle.fea.orientations import TILT
from mechstyle.fea.phases import follow
from mechstyle.records import sentences
from mechstyle.records.mesh import TetMesh
from mechstyle.simulation.physics import prescribed
from mechstyle.simulation.simulator import STEERING, DropSimulator

SECONDS_PER_STEP = {"tet10": 50e-9, "tet4": 12e-9}
"""Time of one core for one tetrahedron and one step [s]: of four drops of three parts of 2000 to 4000 vertices 48 to 57 ns were measured
for tet10; tet4 is a guess."""
STEP, STEPS = 1.1e-4, 12_500
"""Time step [ms], and steps until an impact has ended: 10 300 to 22 700 were counted of parts of 2000 to 3000 vertices."""
TETRAHEDRA, FINEST = 2.6, 13_000
"""Tetrahedra for each vertex of the surface: 2.0 to 3.3 of these and one of 12 000; a surface of more vertices than FINEST gets no more."""
NEARLY_FLAT = 8
"""Landings on the corners and sides of what a part stands on: eight of a box, six of a round base. Half of them mirror others."""
ROUGHLY = 0.68
"""Processor time of a rough drop over that of another: of 247 drops of 16 parts, in the median."""
MESHING = 2.2e-3
"""Time of one core to mesh a part, for each vertex of its surface [s]."""
STYLING = 4e-6
"""Time of an iteration without a fall, for each vertex [s]."""

CONTACT, LEAST_CONTACT = 0.05, 0.05
"""A flat impact lasts so many lowest periods, and so many milliseconds besides, until it is quiet: of eight parts within a third …"""
ROCKING = 0.85
"""… and a nearly flat one longer by this share of the time in which the far side comes down over the whole base: 0.2 to 1.35."""
TRIED, TRIALS = 1000, 3
"""Steps that are tried to see how fast this machine is, and how often: the quickest counts, as a first one may wait for anything. Of 200
steps too many are samples of the history: a spectacle frame seemed to take half as long again."""


@dataclass(frozen=True)
class Estimate:
    """Falls and time of a run that has not begun.

    Attributes:
        height: Height of the falls [mm].
        falls: How many there will be, about.
        seconds: How long it will take, about [s].
    """

    height: float
    falls: int
    seconds: float

    @property
    def words(self) -> str:
        """The test and its time, in one sentence."""
        return sentences.planned(self.height, self.falls, self.seconds)


def estimated(
    vertices: int,
    tests: int,
    *,
    height: float,
    iterations: int,
    orientations: int = 1,
    nearly_flat: bool = True,
    hardest_only: bool = False,
    rough: bool = False,
    element: str = "tet10",
    window: float | None = None,
    fall: float | None = None,
    cores: int | None = None,
) -> Estimate:
    """Estimate of a run; the unstylized part is tested besides.

    Args:
        vertices: Of the standardised surface.
        tests: Tests of the styled part, the last of them in all landings.
        height: Height of fall [mm].
        iterations: Iterations of the run.
        orientations: Landings of the last test without those that are nearly flat.
        nearly_flat: Whether it lands nearly flat, too.
        hardest_only: Whether the styled part then lands only in what is hardest for the plain one.
        rough: Whether drops are rough.
        element: Kind of the tetrahedra.
        window: Simulated time of a fall [ms]; None until the impact has ended.
        fall: What a fall of this part took on one core of this machine [s]; None to estimate it.
        cores: Cores of this machine, each of which takes a fall; None for those there are.
    """
    cores = cores or cores_allowed()
    plain = orientations + (NEARLY_FLAT // 2 if rough else NEARLY_FLAT) * nearly_flat
    steering, last = 1 + STEERING * nearly_flat, orientations + STEERING * nearly_flat if hardest_only else plain
    usual = seconds_of_a_fall(TETRAHEDRA * min(vertices, FINEST), element=element, window=window) * (ROUGHLY if rough else 1.0)
    each = usual if fall is None else fall
    rounds = math.ceil(plain / cores) + math.ceil(last / cores) + (tests - 1) * math.ceil(steering / cores)
    seconds = rounds * each + 2 * MESHING * min(vertices, 2 * FINEST) + iterations * STYLING * vertices
    return Estimate(height, plain + last + (tests - 1) * steering, seconds)


def seconds_of_a_fall(tetrahedra: float, *, element: str = "tet10", window: float | None = None) -> float:
    """Time of one core for a fall [s]: tetrahedra times steps times the time of one.

    Args:
        tetrahedra: How many the part has.
        element: Their kind.
        window: Simulated time [ms]; None until the impact has ended.
    """
    steps = STEPS if window is None else window / STEP
    return tetrahedra * steps * SECONDS_PER_STEP[element]


def before_the_first_fall(simulator: DropSimulator, cores: int | None = None) -> Estimate:
    """Estimate of the tests of a plain part and of its finished style on a processor, without corrections.

    Args:
        simulator: The drop test, its tetrahedra made.
        cores: Cores of this machine, each of which takes a fall; None for those this process may use.
    """
    cores, recipe = cores or cores_allowed(), simulator.recipe
    plain, styled = simulator.meshes.plain[0].tets, simulator.meshes.first.tets
    flat, tilted = impact_times(simulator)
    every, few = len(simulator.landings.names), recipe.test.hardest_only
    nearly = sum(way == "nearly flat" for way in simulator.landings.ways)
    retried, last = 0 if few else min(1, every - 1), every - max(nearly - STEERING, 0) if few else every
    seconds, falls = 0.0, 0
    for tets, landings in ((plain, every), (styled, last)):
        rounds = math.ceil((landings - 1) / cores) + retried
        seconds += seconds_per_millisecond(simulator, tets) * (flat / min(cores, landings) + rounds * tilted)
        falls += landings + retried
    return Estimate(recipe.test.height, falls, seconds)


def impact_times(simulator: DropSimulator) -> tuple[float, float]:
    """About how long a flat and a nearly flat fall are followed [ms]."""
    test = prescribed(simulator.recipe)
    if test.window is not None or simulator.period is None:
        return test.window or 0.0, test.window or 0.0
    vertices, standing = simulator.part.surface.vertices, simulator.part.shape.level_base.standing
    stands = vertices[standing] if standing.any() else vertices
    flat = (CONTACT + test.quiet) * simulator.period + LEAST_CONTACT
    return flat, flat + ROCKING * math.tan(math.radians(TILT)) * float(np.ptp(stands[:, :2], axis=0).max()) / test.speed


def seconds_per_millisecond(simulator: DropSimulator, tets: TetMesh) -> float:
    """Time of one core for a millisecond of a fall [s/ms], from a few steps of one."""
    test, material = prescribed(simulator.recipe), simulator.recipe.test.material
    body = discretise(tets, material, test.added_mass, element_named(test.element))
    step = test.safety * damped_step(body, test.damping)[0]
    on_cores, window, quickest = body_on("cpu", body), replace(test, window=TRIED * step), math.inf
    for _ in range(TRIALS):
        tracks, scheme = tracks_for(body, material, simulator.landings.normals[:1], window)
        begun = perf_counter()
        follow(on_cores, scheme, tracks, no_progress)
        quickest = min(quickest, perf_counter() - begun)
    return quickest / (TRIED * step)
