"""Speed and memory of the drop test beside their budgets: a report, not a test.

On the CPU rates are element updates (a tetrahedron through a step of a drop) per second of CPU time, so that other work on the machine
counts little; what two cores give is wall time, which says little on a busy machine. CalculiX, where it is installed, runs the same mesh
over the same time. On CUDA all orientations step together; bytes are counted as the kernels ask for them, which the cache answers in part.

    python benchmarks/drops.py [--device cpu|cuda] [--model pen_holder] [--vertices 4000]

The pen holder gets 10k tetrahedra from 4000 vertices, and keeps them in the cache.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import platform
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from rich.console import Console
from rich.table import Table

from mechstyle._warp import wp
from mechstyle.fea.backends.cpu import CoreBody
from mechstyle.fea.backends.gpu import DeviceBody
from mechstyle.fea.discretisation import Discretisation, discretise
from mechstyle.fea.drop import DropTest, drop, scheme_for
from mechstyle.fea.elements import ELEMENTS, LINEAR, with_nodes
from mechstyle.fea.explicit import RECORD_EVERY, Batch, Scheme, Starts, carry
from mechstyle.fea.orientations import directions, landings
from mechstyle.gallery import make
from mechstyle.geometry.remeshing.filling import fill
from mechstyle.records.material import LIBRARY
from mechstyle.records.mesh import TetMesh
from mechstyle.simulation.part import Workpiece, prepare
from mechstyle.styling.dimensions import Dimensions
from mechstyle.styling.drawn import target
from mechstyle.styling.prompt import Wish

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from validation import calculix
from validation.meshes import box

PLA = LIBRARY["PLA"]
STRIDE, CPU_SAMPLES, DEVICE_SAMPLES = 120, 2, 120
"""Steps between samples of the history, as in a whole drop, and how many strides are timed: on a GPU a whole drop, so that the recording
of its graph does not show."""

WINDOW = 1.5
"""Of a drop [ms]; it is not followed to its end."""

LOOK = 5
"""Samples between two moments at which the host looks, as in a whole drop."""

REPEATS = 5
RATES = {"tet4": 100.0, "tet10": 30.0}
"""Budget of one core in million element updates per second."""

STYLED_TETS = 18_000
TWO_CORES, MEMORY, FASTER_THAN_CALCULIX, PLASTIC = 1.9, 1.0, 20.0, 1.3
"""Budgets: rate of two cores over that of one, GB of 64 drops of 30k tetrahedra, CalculiX's time over ours, and a plastic step's over an
elastic one's."""

SECONDS = {"13 orientations of the smooth part": 25.0, "flat and nearly flat landings of a styled part of 18k": 25.0}
"""Budgets of whole drop tests on two cores [s]."""

ORIENTATIONS = (1, 8, 16, 64)
FLOAT, VECTOR, INDEX = 4, 12, 4
"""Bytes of what the kernels read and write."""


@dataclass(frozen=True)
class Row:
    """One line of the table; `most` says whether the budget is the most it may be, or the least it must be."""

    what: str
    measured: float
    budget: float
    unit: str
    most: bool = False

    @property
    def ratio(self) -> float:
        """Above 1 is better than the budget."""
        return self.budget / self.measured if self.most else self.measured / self.budget


@dataclass
class Timed:
    """Drops that are carried through so many samples, and not looked at but at the end, which waits for a GPU."""

    batch: Batch
    samples: int
    done: int = 0

    def advance(self) -> None:
        """Some samples on."""
        ahead = min(LOOK, self.samples - self.done)
        self.batch.advance(ahead)
        self.done += ahead

    def look(self) -> list[Timed]:
        """Itself until the end."""
        self.batch.history(self.done - 1, self.done)
        return [self] if self.done < self.samples else []


@dataclass(frozen=True)
class Case:
    """A discretised part with the steps to be timed."""

    body: CoreBody | DeviceBody
    discretisation: Discretisation
    scheme: Scheme

    def updates(self, orientations: int) -> int:
        """Element updates of a run."""
        return len(self.discretisation.volumes) * self.scheme.steps * orientations

    def run(self, orientations: int) -> Callable[[], object]:
        """Drops at first touch; calling the result carries them through the window, once."""
        starts = Starts.falling(self.discretisation.positions, directions(orientations), self.scheme.speed)
        jobs = [Timed(batch, self.scheme.samples) for batch in self.body.batches(self.scheme, starts)]
        return lambda: carry(jobs, lambda: None)


def case(tets: TetMesh, element: str, device: str, *, plastic: bool = True) -> Case:
    """A part in drops long enough to be timed."""
    body = discretise(tets, PLA, DropTest().added_mass, ELEMENTS[element])
    where = CoreBody(body) if device == "cpu" else DeviceBody(body, device)
    scheme = scheme_for(body, PLA, DropTest(element=element, window=WINDOW, plastic=plastic))
    return Case(where, body, replace(scheme, stride=STRIDE, samples=CPU_SAMPLES if device == "cpu" else DEVICE_SAMPLES))


@contextlib.contextmanager
def cores(count: int) -> Iterator[None]:
    """Leave this process so many cores."""
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, sorted(before)[:count])
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)


def quickest(start: Callable[[], Callable[[], object]], clock: Callable[[], float]) -> float:
    """Seconds of the quickest of several runs after one that compiles, what leads up to them left out."""
    times = []
    for _ in range(REPEATS + 1):
        work = start()
        begun = clock()
        work()
        times.append(clock() - begun)
    return min(times[1:])


def rates(tets: TetMesh) -> Iterator[Row]:
    """Element updates per second of one core, and what a second core adds."""
    for element in ELEMENTS:
        timed = case(tets, element, "cpu")
        with cores(1):
            alone = quickest(lambda: timed.run(1), time.process_time)  # noqa: B023
            one = quickest(lambda: timed.run(1), time.perf_counter)  # noqa: B023
        yield Row(f"{element}, one core", timed.updates(1) / alone / 1e6, RATES[element], "M updates/s")
        elastic = case(tets, element, "cpu", plastic=False)
        with cores(1):
            without = quickest(lambda: elastic.run(1), time.process_time)  # noqa: B023
        ratio = alone / timed.updates(1) * elastic.updates(1) / without
        yield Row(f"{element}, a step with plastic flow over an elastic one", ratio, PLASTIC, "x", most=True)
        if len(os.sched_getaffinity(0)) > 1:
            with cores(2):
                both = quickest(lambda: timed.run(2), time.perf_counter)  # noqa: B023
            yield Row(f"{element}, two cores over one", 2.0 * one / both, TWO_CORES, "x")


def whole_drops(part: Workpiece) -> Iterator[Row]:
    """Whole drop tests as a run makes them, on two cores: wall time, which says little on a busy machine, and CPU time in the name."""
    thickness = part.thickness
    size = Dimensions(amplitude=0.15, side="both", nozzle=0.0)
    aim = target(part.surface, Wish("brick"), size, seed=0, thickness=thickness, inward=0.25 * thickness, outward=thickness)
    styled = fill(part.surface.displaced(aim.displacement), STYLED_TETS)
    sets = ((part.tets, directions(13)), (styled, landings(part.surface, "fibonacci", 1, nearly_flat=True).normals))
    for (name, budget), (tets, normals) in zip(SECONDS.items(), sets, strict=True):
        begun, busy = time.perf_counter(), time.process_time()
        with cores(2):
            result = drop(tets, PLA, normals, device="cpu")
        wall, busy = time.perf_counter() - begun, time.process_time() - busy
        words = f"{name}: tet10, {len(tets.tets)} tets, {result.steps} steps, {result.failure or '1.5 ms'}, {busy:.0f} CPU s"
        yield Row(words, wall, budget, "s", most=True)


def memory() -> Row:
    """What 64 orientations of 30k quadratic tetrahedra add to a process of their own."""
    done = subprocess.run([sys.executable, __file__, "--memory"], check=True, capture_output=True, text=True)
    return Row("memory of 64 orientations, tet10, 29 478 tets", float(done.stdout), MEMORY, "GB", most=True)


def print_memory() -> None:
    """Gigabytes that the drops add to what a process with everything loaded and compiled has, at its peak."""
    test = DropTest(window=1e-3)
    drop(box((2, 2, 2), (4.0, 4.0, 4.0)), PLA, directions(9), test, device="cpu")
    tets = box((17, 17, 17), (60.0, 60.0, 60.0))
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    drop(tets, PLA, directions(64), test, device="cpu")
    print((resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1e6)


def against_calculix() -> Row:
    """CalculiX's wall time over ours for a bar on the floor, both on one core, over the same time of 0.04 ms, from mesh to stress.

    Each takes the step it finds stable: CalculiX needs the same time and gives the same answer whatever step is asked for.
    """
    tets, upright = box((4, 4, 40), (5.0, 5.0, 50.0)), directions(1)
    window = 0.04
    test = DropTest(window=window, damping=0.0, law="st_venant_kirchhoff", plastic=False, element="tet4", added_mass=0.0)
    with cores(1):
        mesh = with_nodes(tets, LINEAR)
        held = mesh.nodes[:, 2] < 1e-9
        theirs = calculix.impact(mesh, PLA, held, test.speed, window, 1e-4).seconds
        ours = quickest(lambda: lambda: drop(tets, PLA, upright, test, device="cpu"), time.perf_counter)
    words = f"CalculiX {theirs:.1f} s over ours {1e3 * ours:.0f} ms, 3840 C3D4, 0.04 ms, one core"
    return Row(words, theirs / ours, FASTER_THAN_CALCULIX, "x")


def counted_bytes(timed: Case, orientations: int) -> int:
    """Bytes the two kernels of a step ask for: what belongs to a tetrahedron or node once, its state and forces for each orientation."""
    body = timed.discretisation
    nodes, points = body.connectivity.shape[1], timed.body.element.points
    geometry = len(body.volumes) * (10 * FLOAT + 2 * nodes * INDEX) + len(body.masses) * (FLOAT + 2 * INDEX)
    element = 2 * nodes * VECTOR + 2 * points * FLOAT // RECORD_EVERY
    gather = nodes * VECTOR
    node = FLOAT + 5 * VECTOR
    return geometry + orientations * (len(body.volumes) * (element + gather) + len(body.masses) * node)


def roof(device: str) -> float:
    """Bytes per second of a copy from memory to memory, read and written, best of several."""
    count = 1 << 28
    source, destination = (wp.zeros(count, dtype=wp.float32, device=device) for _ in range(2))

    def copied() -> None:
        wp.copy(destination, source)
        wp.synchronize_device(device)

    return 2 * FLOAT * count / quickest(lambda: copied, time.perf_counter)


def device_table(tets: TetMesh, device: str) -> Table:
    """Microseconds a step, rates, and the share of the memory roof, by element and number of orientations."""
    top = roof(device)
    title = f"{wp.get_device(device).name}: {len(tets.tets)} tets, a copy moves {top / 1e12:.2f} TB/s"
    table = Table(title=title, caption="bytes as the kernels ask for them, the cache's share included")
    for heading in ("element", "orientations", "us / step", "over an elastic one", "G updates/s", "TB/s counted", "share of the roof"):
        table.add_column(heading, justify="left" if heading == "element" else "right")
    for element in ELEMENTS:
        timed, elastic = (case(tets, element, device, plastic=plastic) for plastic in (True, False))
        for count in ORIENTATIONS:
            seconds = quickest(lambda: timed.run(count), time.perf_counter)  # noqa: B023
            without = quickest(lambda: elastic.run(count), time.perf_counter)  # noqa: B023
            ratio = seconds / timed.scheme.steps * elastic.scheme.steps / without
            step, speed = seconds / timed.scheme.steps, timed.updates(count) / seconds
            rate = counted_bytes(timed, count) / step
            figures = (f"{one:.2f}" for one in (ratio, speed / 1e9, rate / 1e12, rate / top))
            table.add_row(element, str(count), f"{1e6 * step:.1f}", *figures)
    return table


def cpu_table(part: Workpiece) -> Table:
    """Every row, as it comes."""
    caption = f"{platform.machine()}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}; a ratio above 1 is better than the budget"
    table = Table(title=f"drop test on the CPU, {len(part.tets.tets)} tets", caption=caption)
    for heading in ("what", "measured", "budget", "ratio"):
        table.add_column(heading, justify="left" if heading == "what" else "right")
    for row in cpu_rows(part):
        print(f"… {row.what}: {row.measured:.3g} {row.unit}", file=sys.stderr, flush=True)
        budget = f"{'≤' if row.most else '≥'} {row.budget:g} {row.unit}"
        table.add_row(row.what, f"{row.measured:.3g} {row.unit}", budget, f"{row.ratio:.2f}", style="red" if row.ratio < 1 else "")
    return table


def cpu_rows(part: Workpiece) -> Iterator[Row]:
    """Rates, memory, CalculiX where it is, whole drop tests last because they take longest."""
    yield from rates(part.tets)
    yield memory()
    if calculix.available():
        yield against_calculix()
    yield from whole_drops(part)


def main() -> None:
    """Print the table of the device."""
    parser = argparse.ArgumentParser(description="Speed and memory of the drop test beside their budgets.")
    parser.add_argument("--device", default="cpu", help="cpu or cuda")
    parser.add_argument("--model", default="pen_holder", help="a gallery model")
    parser.add_argument("--vertices", type=int, default=4000, help="vertices of its standardised surface")
    parser.add_argument("--memory", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.memory:
        print_memory()
        return
    part = prepare(make(options.model), vertices=options.vertices)
    Console(width=140).print(cpu_table(part) if options.device == "cpu" else device_table(part.tets, options.device))


if __name__ == "__main__":
    main()
