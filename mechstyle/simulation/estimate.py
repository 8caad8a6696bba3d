"""Estimate of the falls and the time of a run, before it begins: from the size of its mesh, or from what falls took on this machine."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass

from mechstyle.records import sentences
from mechstyle.simulation.simulator import STEERING

SECONDS_PER_STEP = {"tet10": 50e-9, "tet4": 12e-9}
"""Time of one core for one tetrahedron and one step [s]: of four drops of three parts of 2000 to 4000 vertices 48 to 57 ns were measured
for tet10; tet4 is a guess."""
STEP, STEPS = 8e-5, 17_000
"""Time step [ms], and steps until an impact has ended, of which 15 120 to 19 800 were counted: finer meshes are dropped with more mass."""
TETRAHEDRA, FINEST = 2.6, 13_000
"""Tetrahedra for each vertex of the surface: 2.0 to 3.3 of these and one of 12 000; a surface of more vertices than FINEST gets no more."""
NEARLY_FLAT = 8
"""Landings on the corners and sides of what a part stands on: eight of a box, six of a round base."""
MESHING = 2.2e-3
"""Time of one core to mesh a part, for each vertex of its surface [s]."""
STYLING = 4e-6
"""Time of an iteration without a fall, for each vertex [s]."""


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
        element: Kind of the tetrahedra.
        window: Simulated time of a fall [ms]; None until the impact has ended.
        fall: What a fall of this part took on one core of this machine [s]; None to estimate it.
        cores: Cores of this machine, each of which takes a fall; None for those there are.
    """
    cores = cores or os.cpu_count() or 1
    thorough, steering = orientations + NEARLY_FLAT * nearly_flat, 1 + STEERING * nearly_flat
    each = seconds_of_a_fall(TETRAHEDRA * min(vertices, FINEST), element=element, window=window) if fall is None else fall
    rounds = 2 * math.ceil(thorough / cores) + (tests - 1) * math.ceil(steering / cores)
    seconds = rounds * each + 2 * MESHING * min(vertices, 2 * FINEST) + iterations * STYLING * vertices
    return Estimate(height, 2 * thorough + (tests - 1) * steering, seconds)


def seconds_of_a_fall(tetrahedra: float, *, element: str = "tet10", window: float | None = None) -> float:
    """Time of one core for a fall [s]: tetrahedra times steps times the time of one.

    Args:
        tetrahedra: How many the part has.
        element: Their kind.
        window: Simulated time [ms]; None until the impact has ended.
    """
    steps = STEPS if window is None else window / STEP
    return tetrahedra * steps * SECONDS_PER_STEP[element]
