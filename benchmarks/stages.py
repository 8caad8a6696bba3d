"""Seconds per stage of a run on a gallery model, beside their budgets: a report, not a test.

Budgets are seconds on two laptop cores. Wall time depends on what else the machine does; CPU time, with that of child processes,
is the figure to compare.

    python benchmarks/stages.py [MODEL] [--device cpu|cuda]
"""

from __future__ import annotations

import argparse
import os
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from rich.console import Console
from rich.table import Table

from mechstyle.errors import MechStyleError
from mechstyle.fea.drop import DropTest, drop
from mechstyle.fea.orientations import directions
from mechstyle.gallery import make
from mechstyle.geometry.morph import Morph
from mechstyle.geometry.remeshing.evening import even
from mechstyle.geometry.remeshing.filling import fill
from mechstyle.geometry.thickness import local_thickness
from mechstyle.geometry.transfer import Transfer
from mechstyle.loop.engine import Event, Stylized
from mechstyle.records.material import LIBRARY
from mechstyle.records.mesh import STANDARD_VERTICES, SurfaceMesh, TetMesh
from mechstyle.runs.recipes import plan
from mechstyle.runs.run import Draft
from mechstyle.simulation.part import TETS, Workpiece
from mechstyle.styling.dimensions import Dimensions
from mechstyle.styling.drawn import Target, target
from mechstyle.styling.prompt import Wish

Result = TypeVar("Result")

ITERATIONS = 200
BUDGETS = {
    "import mechstyle": 0.3,
    "standardise": 15.0,
    "tetrahedralise": 30.0,
    "thickness": 1.0,
    "style target": 8.0,
    f"{ITERATIONS} style iterations": 10.0,
    "morph and transfer": 0.3,
    "one drop": 4.0,
    "five drops": 15.0,
}


@dataclass(frozen=True)
class Cost:
    """What a stage took [s]: on the clock at the first call, which compiles kernels, then on the clock and on the processor."""

    first: float
    wall: float
    cpu: float


class Stages:
    """Runs stages and keeps what they cost."""

    def __init__(self) -> None:
        self.costs: dict[str, Cost] = {}

    def __call__(self, name: str, work: Callable[[], Result], *, again: bool = True) -> Result:
        """Run a stage, and once more unless its first call is as good as any."""
        print(f"… {name}", file=sys.stderr, flush=True)
        first, cpu, result = timed(work)
        wall = first
        if again:
            wall, cpu, result = timed(work)
        self.costs[name] = Cost(first, wall, cpu)
        return result


def timed(work: Callable[[], Result]) -> tuple[float, float, Result]:
    """Wall seconds, CPU seconds with those of finished child processes, and what came out."""
    begun, before = time.perf_counter(), os.times()
    result = work()
    wall, after = time.perf_counter() - begun, os.times()
    return wall, sum(after[:4]) - sum(before[:4]), result


def import_cost() -> Cost:
    """What `import mechstyle` adds to starting Python, best of five."""
    costs = []
    for program in ("pass", "import mechstyle"):
        tries = [timed(lambda: subprocess.run([sys.executable, "-c", program], check=True))[:2] for _ in range(5)]  # noqa: B023
        costs.append((tries[0][0], *np.min(tries, axis=0)))
    bare, loaded = costs
    return Cost(*(float(b - a) for a, b in zip(bare, loaded, strict=True)))


def run(stage: Stages, model: str, device: str) -> str:
    """Every stage of a run, in order; what it was run on, in words."""
    stage.costs["import mechstyle"] = import_cost()
    original = make(model)
    surface = stage("standardise", lambda: even(original, STANDARD_VERTICES), again=False)
    tets = stage("tetrahedralise", lambda: fill(surface, TETS), again=False)
    thickness = stage("thickness", lambda: local_thickness(surface))
    aim = stage("style target", lambda: brick(surface, thickness))
    part = Workpiece(surface, tets, thickness.astype(np.float32), stands=True)
    with tempfile.TemporaryDirectory() as folder:
        events = iterations(part, folder)
        stage(f"{ITERATIONS} style iterations", lambda: iterated(events), again=False)
    moved = stage("morph and transfer", lambda: morphed(surface, tets, aim))
    stage("one drop", lambda: drop(moved, LIBRARY["PLA"], directions(1), DropTest(), device=device))
    result = stage("five drops", lambda: drop(moved, LIBRARY["PLA"], directions(5), DropTest(), device=device))
    steps = f"{result.steps} steps of {1e3 * result.time_step:.2g} µs"
    return f"{model}: {len(surface.vertices)} vertices, {len(tets.tets)} tets, {result.failure or steps}"


def brick(surface: SurfaceMesh, thickness: np.ndarray[Any, Any]) -> Target:
    """The relief of a brick wall, as deep as a run would let it be."""
    size = Dimensions(amplitude=0.15, side="both", nozzle=0.0)
    return target(surface, Wish("brick"), size, seed=0, thickness=thickness, inward=0.25 * thickness, outward=thickness)


def iterations(part: Workpiece, folder: str) -> Iterator[Event]:
    """The events of a run that simulates at its end only, its target drawn and the part as it came simulated already."""
    run = Draft(plan(part, "green", schedule="never", iterations=ITERATIONS), part, folder=Path(folder) / "run", device="cpu").begin()
    events = run.events()
    next(events)
    return events


def iterated(events: Iterator[Event]) -> None:
    """The whole loop with its checkpoints on disk, up to where the first simulation would begin."""
    for event in events:
        if isinstance(event, Stylized) and event.iteration == ITERATIONS:
            return


def morphed(surface: SurfaceMesh, tets: TetMesh, aim: Target) -> TetMesh:
    """The tetrahedra under the relief, and a field brought back from them."""
    result = Morph(surface, tets).morphed(aim.displacement).tets
    Transfer(surface, tets).to_surface(tets.vertices[:, 2])
    return result


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description="Seconds per stage, beside their budgets.")
    parser.add_argument("model", nargs="?", default="pen_holder", help="a gallery model")
    parser.add_argument("--device", default="cpu", help="cpu or cuda, for the drops")
    options = parser.parse_args()
    stage = Stages()
    try:
        what = run(stage, options.model, options.device)
    except MechStyleError as error:
        what = f"{options.model}: {error}"
    table = Table(title=what, caption=f"{platform.machine()}, {os.cpu_count()} cores, drops on {options.device}")
    for heading in ("stage", "first call [s]", "wall [s]", "CPU [s]", "budget [s]", "CPU / budget"):
        table.add_column(heading, justify="left" if heading == "stage" else "right")
    for name, cost in stage.costs.items():
        share = cost.cpu / BUDGETS[name]
        figures = (f"{cost.first:.2f}", f"{cost.wall:.2f}", f"{cost.cpu:.2f}", f"{BUDGETS[name]:.1f}", f"{share:.2f}")
        table.add_row(name, *figures, style="red" if share > 1 else "")
    Console().print(table)
    if "five drops" in stage.costs:
        print(f"five drops cost {stage.costs['five drops'].cpu / stage.costs['one drop'].cpu:.1f} x one drop")


if __name__ == "__main__":
    main()
