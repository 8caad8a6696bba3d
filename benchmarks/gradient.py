"""Cost of the experimental derivative of a short drop: a report, not a test.

The part is the gallery's pen holder, coarsely meshed; its tetrahedra are kept in the cache, since meshing takes far longer than the rest.

    python benchmarks/gradient.py [--device cpu|cuda] [--steps 200] [--vertices 4000]
"""

from __future__ import annotations

import argparse
import os
import platform
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from mechstyle._warp import wp
from mechstyle.fea.drop import DropTest
from mechstyle.fea.elements import ELEMENTS
from mechstyle.fea.sensitivity.gradient import ShortDrop
from mechstyle.gallery import make
from mechstyle.records.material import LIBRARY
from mechstyle.records.mesh import TetMesh
from mechstyle.simulation.part import prepare

TILTED = (0.2, -0.3, 0.9)
REPEATS = 3
NEARBY = 1e-4
"""Millimetres the vertices move in all for the difference: contact bends the peak beyond that, rounding hides it below."""
BUDGET = 5.0
"""Times forward that backward may cost; 3.8 was measured on a prototype."""


def short_drop(tets: TetMesh, element: str, steps: int, device: str) -> ShortDrop:
    """A drop of about so many steps."""
    first = ShortDrop(tets, LIBRARY["PLA"], TILTED, DropTest(window=1e-3, element=element), device=device)
    window = steps * first.scheme.time_step
    return ShortDrop(tets, LIBRARY["PLA"], TILTED, DropTest(window=window, element=element), device=device)


def best(work: Callable[[], Any], device: str) -> float:
    """CPU seconds of the cheapest of several calls after one that compiles; wall seconds on a GPU."""
    clock = time.process_time if device == "cpu" else time.perf_counter
    times = []
    for _ in range(REPEATS + 1):
        begun = clock()
        work()
        times.append(clock() - begun)
    return min(times[1:])


def megabytes(short: ShortDrop) -> float:
    """What is kept for each step, from the arrays on the tape: forces, displacement, velocity, their sum, each with its derivative."""
    per_step = 4 * 2 * 3 * np.dtype(np.float32).itemsize
    return per_step * short.node_count / 1e6


def agreement(short: ShortDrop, distance: float) -> float:
    """Derivative along the gradient over a central difference of so many mm in all, less one."""
    gradient = short.sensitivity().gradient
    along = gradient / np.linalg.norm(gradient)
    ahead, behind = (short.smooth_peak(short.tets.vertices + sign * distance * along) for sign in (1.0, -1.0))
    return float(np.linalg.norm(gradient)) / ((ahead - behind) / (2.0 * distance)) - 1.0


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description="Cost of the experimental derivative of a short drop.")
    parser.add_argument("--device", default="cpu", help="cpu or cuda")
    parser.add_argument("--steps", type=int, default=200, help="steps of the drop, about")
    parser.add_argument("--vertices", type=int, default=4000, help="vertices of the standardised surface")
    options = parser.parse_args()
    tets = prepare(make("pen_holder"), vertices=options.vertices).tets
    machine = wp.get_device(options.device).name if options.device != "cpu" else platform.machine()
    clock = "CPU time" if options.device == "cpu" else "wall time"
    table = Table(title=f"pen holder, {len(tets.tets)} tetrahedra, one drop", caption=f"{machine}, {os.cpu_count()} cores, {clock}")
    measured = ("steps", "forward [ms/step]", "backward [ms/step]", "backward / forward", "budget", "MB/step", "against differences")
    for heading in ("element", *measured):
        table.add_column(heading, justify="left" if heading == "element" else "right")
    for element in ELEMENTS:
        short = short_drop(tets, element, options.steps, options.device)
        steps = short.scheme.steps
        forward = best(short.smooth_peak, options.device)
        backward = best(short.sensitivity, options.device) - forward
        costs = (f"{1e3 * forward / steps:.2f}", f"{1e3 * backward / steps:.2f}", f"{backward / forward:.1f}", f"{BUDGET:.1f}")
        kept, gap = f"{megabytes(short):.2f}", f"{100.0 * agreement(short, NEARBY):+.2f} %"
        table.add_row(element, str(steps), *costs, kept, gap, style="red" if backward > BUDGET * forward else "")
    Console(width=140).print(table)


if __name__ == "__main__":
    main()
