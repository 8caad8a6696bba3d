"""The walk over the cells of a study: here, in processes side by side, or on Dask workers; the rows on disk are the truth."""

from __future__ import annotations

import multiprocessing
import os
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import msgspec

from benchmarks.study.cells import Cell, Row, Rows, carry_out
from mechstyle.errors import BadInput
from mechstyle.fea.explicit import THREADS, cores

DEATHS = 3
"""A cell whose process died so often is a row that says so."""
AHEAD = 2
"""Cells a scheduler is given for each worker: one in hand and one to follow, so that stopping and priorities stay cheap."""

THREADS_OF = (THREADS, "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Environment variables that say how many threads a process has."""

Tell = Callable[[Row], None]


def walk(cells: Sequence[Cell], folder: str | Path, *, jobs: int = 1, scheduler: str = "", tell: Tell = lambda _: None) -> list[Row]:
    """The rows of all cells, in their order; what has a row already is only read, unless it was refused.

    With a Dask scheduler, its address such as `tcp://10.0.0.1:8786` or its file, `jobs`, processes on this machine, do not count. `tell` is
    called with every row when it is done, those that were there before first. BadInput if there is no such scheduler.
    """
    rows = Rows(folder)
    todo: dict[str, Cell] = {}
    for cell in _models_in_turn(cells):
        known = rows.settled(cell)
        if known is None:
            todo.setdefault(cell.key, cell)
        else:
            tell(known)
    if scheduler:
        done = _on_workers(list(todo.values()), rows, scheduler)
    elif jobs > 1:
        done = _side_by_side(list(todo.values()), rows, jobs)
    else:
        done = (carry_out(cell, folder) for cell in todo.values())
    for row in done:
        tell(row)
    return [row for row in map(rows.of, cells) if row is not None]


def _models_in_turn(cells: Sequence[Cell]) -> list[Cell]:
    """The cells so that neighbours are of different models: workers then find a part prepared, instead of preparing it at the same time."""
    by_model: dict[str, list[Cell]] = {}
    for cell in cells:
        by_model.setdefault(cell.model, []).append(cell)
    longest = max(map(len, by_model.values()), default=0)
    return [own[turn] for turn in range(longest) for own in by_model.values() if turn < len(own)]


def _side_by_side(cells: Sequence[Cell], rows: Rows, jobs: int) -> Iterator[Row]:
    """Carry cells out in processes; a process that dies takes the pool with it, which is begun anew for what is left.

    What was in hand then is tried alone, so that the cell that ends its process is found and its neighbours are not blamed.
    """
    left, deaths = {cell.key: cell for cell in cells}, Counter[str]()
    while left:
        suspects = [cell for key, cell in left.items() if deaths[key]]
        batch, width = (suspects[:1], 1) if suspects else (list(left.values()), jobs)
        try:
            for row, cell in _in_a_pool(batch, rows, width, deaths):
                del left[cell.key]
                yield row
        except BrokenProcessPool:
            for key in [key for key in left if deaths[key] >= DEATHS]:
                cell = left.pop(key)
                row = cell.row(status="failed", refused=f"the run ended its process {DEATHS} times: memory, or a fault in native code")
                rows.write(cell, row)
                yield row


def _in_a_pool(cells: Sequence[Cell], rows: Rows, jobs: int, deaths: Counter[str]) -> Iterator[tuple[Row, Cell]]:
    """Rows as they come; a death is counted against every cell that was in hand."""
    context = multiprocessing.get_context("spawn")
    coming = iter(cells)
    begun = context.Value("i", 0)
    pool = ProcessPoolExecutor(jobs, mp_context=context, initializer=_begin_process, initargs=(begun, jobs, os.getpid()))
    with _threads_shared(jobs), pool:
        hand: dict[Future[Row], Cell] = {}
        while True:
            for cell in coming:  # no more than there are processes, so that a death is blamed on few
                hand[pool.submit(carry_out, cell, rows.folder)] = cell
                if len(hand) == jobs:
                    break
            if not hand:
                return
            done = wait(hand, return_when=FIRST_COMPLETED).done
            if any(isinstance(future.exception(), BrokenProcessPool) for future in done):
                deaths.update(cell.key for cell in hand.values() if rows.settled(cell) is None)
            for future in done:
                yield future.result(), hand.pop(future)


@contextmanager
def _threads_shared(jobs: int) -> Iterator[None]:
    """Processes that begin in the block have as many threads as their share of the cores, unless the environment says otherwise.

    Libraries read it when they are loaded, before a process takes its share.
    """
    share = str(max(1, cores() // jobs))
    added = [name for name in THREADS_OF if name not in os.environ]
    os.environ.update(dict.fromkeys(added, share))
    try:
        yield
    finally:
        for name in added:
            del os.environ[name]


def _begin_process(begun: Any, jobs: int, parent: int) -> None:
    """Take a share of the cores, where the system lets it, and end when whoever started this process ends, however that is.

    Threads of several processes on all cores are slower; a process left behind by a study that was killed would hold its run.
    """

    def end_with_parent() -> None:
        while os.getppid() == parent:
            time.sleep(0.5)
        os._exit(1)

    threading.Thread(target=end_with_parent, daemon=True).start()
    if not hasattr(os, "sched_setaffinity"):
        return
    with begun.get_lock():
        place, begun.value = begun.value % jobs, begun.value + 1
    os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[place::jobs] or os.sched_getaffinity(0))


# on the workers of a scheduler


def on_worker(cell: str, folder: str) -> str:
    """Carry out a cell given as JSON and return its key: what a Dask worker runs. Its row is on disk, never in the worker's memory.

    A worker simulates with as many threads as MECHSTYLE_THREADS says, by default one: several share a machine.
    """
    os.environ.setdefault(THREADS, "1")
    asked = msgspec.json.decode(cell, type=Cell)
    carry_out(asked, folder)
    return asked.key


def _on_workers(cells: Sequence[Cell], rows: Rows, scheduler: str) -> Iterator[Row]:
    """Carry cells out on the workers of a scheduler, a few ahead of those in hand; nothing is kept in its memory."""
    try:
        from distributed import Client, as_completed  # noqa: PLC0415 — an extra
    except ImportError as error:
        raise BadInput("a scheduler needs Dask: pip install 'dask[distributed]', or use --jobs, which needs nothing") from error
    coming = iter(cells)
    known = {f"mechstyle-{cell.key}": cell for cell in cells}
    try:
        client_of = Client(scheduler_file=scheduler) if scheduler.endswith(".json") else Client(scheduler)
    except (OSError, ValueError) as error:
        raise BadInput(f"no Dask scheduler answers at {scheduler} ({error}): start one with `dask scheduler`, give its address") from error
    with client_of as client:
        running = as_completed()

        def submit_next() -> None:
            cell = next(coming, None)
            if cell is not None:
                need = {"GPU": 1} if cell.device == "cuda" else None
                text, where = msgspec.json.encode(cell).decode(), str(rows.folder.resolve())
                running.add(client.submit(on_worker, text, where, key=f"mechstyle-{cell.key}", retries=0, resources=need))

        for _ in range(AHEAD * max(len(client.nthreads()), 1)):
            submit_next()
        for future in running:
            cell = known[future.key]
            row = rows.of(cell)
            if row is None:
                row = cell.row(status="failed", refused=f"the run was lost with its worker: {future.exception()}")
                rows.write(cell, row)
            future.release()
            submit_next()
            yield row
