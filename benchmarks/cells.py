"""What one cell of a study costs: seconds of the processor for each drop test, and for all else.

    python -m benchmarks.cells [MODEL] [STYLE] [--vertices 6000] [--iterations 60]

Freely, in one thread as a worker of a study has, and in a cache of its own, so that the part is prepared and its original dropped. Wall
time is not told: it says little on a machine that others use as well.
"""

from __future__ import annotations

import argparse
import os
import platform
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest.mock import patch

from rich.console import Console
from rich.table import Table

from benchmarks.study.cells import Row, carry_out
from benchmarks.study.grids import Factors, cells_of
from mechstyle.fea.drop import Drop
from mechstyle.fea.explicit import THREADS
from mechstyle.simulation import simulator


@dataclass(frozen=True)
class Test:
    """A drop test in some landings, and the seconds of the processor it took."""

    found: Drop
    seconds: float

    @property
    def cells(self) -> tuple[str, ...]:
        """Its line of the table."""
        landings, tets, _ = self.found.von_mises.shape
        steps = sum(round((phase.end - phase.start) / self.found.time_step) for phases in self.found.phases for phase in phases)
        figures = (f"{1e6 * self.found.time_step:.0f}", f"{steps / 1e3:.0f}", f"{tets * steps / self.seconds / 1e6:.1f}")
        return f"{landings} landings, {tets} tetrahedra", *figures, f"{self.seconds:.0f}"


def busy() -> float:
    """Seconds of the processor so far, with those of processes that meshed."""
    return sum(os.times()[:4])


def watched(drop: Callable[..., Drop], tests: list[Test]) -> Callable[..., Drop]:
    """A drop test that is noted with its time."""

    def noted(*given: Any, **named: Any) -> Drop:
        begun = busy()
        found = drop(*given, **named)
        tests.append(Test(found, busy() - begun))
        return found

    return noted


def carried_out(factors: Factors) -> tuple[Row, list[Test]]:
    """The row of the one cell, and the drop tests on the way, the original's first."""
    tests: list[Test] = []
    (cell,) = cells_of("formative", factors)
    with tempfile.TemporaryDirectory() as folder, patch.object(simulator, "drop", watched(simulator.drop, tests)):
        own = {THREADS: "1", "MECHSTYLE_CACHE": str(Path(folder) / "cache")}
        with patch.dict(os.environ, own):
            return carry_out(cell, Path(folder) / "study"), tests


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description="Seconds of the processor for one cell of a study.")
    parser.add_argument("model", nargs="?", default="wall_hook", help="a gallery model")
    parser.add_argument("style", nargs="?", default="green", help="a prompt")
    parser.add_argument("--vertices", type=int, default=6000)
    parser.add_argument("--iterations", type=int, default=60)
    asked = parser.parse_args()
    factors = Factors(models=[asked.model], styles=[asked.style], vertices=asked.vertices, iterations=asked.iterations, device="cpu")
    row, tests = carried_out(factors)
    what = f"{row.part} × {row.prompt}, {row.vertices} vertices, {row.iterations} iterations: {row.outcome or row.refused}"
    table = Table(title=what, caption=f"{platform.machine()}, load {os.getloadavg()[0]:.1f}")
    for heading in ("drop test", "step [ns]", "steps [10³]", "M updates/s", "processor [s]"):
        table.add_column(heading, justify="left" if heading == "drop test" else "right")
    for test in tests:
        table.add_row(*test.cells)
    table.add_row("all else", "", "", "", f"{row.cpu_seconds - sum(test.seconds for test in tests):.0f}")
    table.add_row("the cell", "", "", "", f"{row.cpu_seconds:.0f}")
    Console(width=120).print(table)


if __name__ == "__main__":
    main()
