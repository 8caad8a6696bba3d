"""What the walk over a study costs by itself: cells whose part does not exist, so that each is a lock, a start and a row with its reason.

python -m benchmarks.scheduling                # 10 000 cells in one process, in two, and on two Dask workers of this machine
python -m benchmarks.scheduling --cells 1000 --way walk --way jobs

Each way walks in a process of its own, which is the driver; its memory is the most it ever held, beside what it held when it began. Wall
time on a busy machine says little, so processor time is told beside it: of the driver, and of everything, with the start of its processes.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from benchmarks.study.cells import Cell
from benchmarks.study.walk import walk
from mechstyle.runs.recipes import recipe_for

WORKERS = 2


def cells(count: int) -> list[Cell]:
    """Cells that are refused as soon as they are begun."""
    recipe = recipe_for("brick")
    return [Cell(model=f"part {number}.stl", arm="freestyle", recipe=recipe, vertices=1000) for number in range(count)]


def in_one_process(asked: list[Cell], folder: Path) -> None:
    """One cell after the other."""
    walk(asked, folder)


def in_jobs(asked: list[Cell], folder: Path) -> None:
    """As `--jobs` does."""
    walk(asked, folder, jobs=WORKERS)


def on_a_cluster(asked: list[Cell], folder: Path) -> None:
    """As `--scheduler` does; this scheduler lives in the driver's process, so its work and its memory are counted as the driver's."""
    from distributed import LocalCluster  # noqa: PLC0415 — an extra

    settings = {"n_workers": WORKERS, "threads_per_worker": 1, "processes": True, "host": "127.0.0.1", "dashboard_address": None}
    with LocalCluster(**settings) as cluster:
        walk(asked, folder, scheduler=cluster.scheduler_address)


WAYS: dict[str, Callable[[list[Cell], Path], None]] = {"walk": in_one_process, "jobs": in_jobs, "dask": on_a_cluster}


def measure(way: str, count: int) -> str:
    """Walk, then walk again over rows that are all there; a line of figures."""
    asked, before = cells(count), _memory()
    with tempfile.TemporaryDirectory() as name:
        began, own = time.perf_counter(), time.process_time()
        WAYS[way](asked, Path(name))
        wall, driver, everyone = time.perf_counter() - began, time.process_time() - own, sum(os.times()[:4])
        memory = _memory()
        began = time.process_time()
        assert len(walk(asked, name)) == count
        reading = time.process_time() - began
    each = f"{1e3 * driver / count:.2f} ms of the driver's processor, {1e3 * everyone / count:.2f} ms of all"
    return f"{way:5} {count / wall:6.0f} cells/s; a cell {each}; {before:.0f} → {memory:.0f} MB; read again {count / reading:.0f} cells/s"


def _memory() -> float:
    """Most memory that this process held so far [MB]."""
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most / (1e6 if sys.platform == "darwin" else 1e3)


def main() -> None:
    """Measure each way in a process of its own."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--way", choices=WAYS, action="append", help="unless told, all")
    parser.add_argument("--cells", type=int, default=10_000)
    parser.add_argument("--here", action="store_true", help="in this process, which is the driver")
    given = parser.parse_args()
    for way in given.way or WAYS:
        if given.here:
            print(measure(way, given.cells), flush=True)
        else:
            command = [sys.executable, __file__, "--way", way, "--here", "--cells", str(given.cells)]
            subprocess.run(command, check=True)


if __name__ == "__main__":
    main()
