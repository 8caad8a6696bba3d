"""The walk over cells: side by side, with processes that die, resumed, and on the workers of a scheduler."""

import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
from collections import Counter
from pathlib import Path

import pytest

from mechstyle.errors import BadInput
from mechstyle.runs.recipes import draft
from mechstyle.study import walk as module
from mechstyle.study.cells import Cell, Rows, carry_out
from mechstyle.study.walk import DEATHS, walk


class Quick(Cell, frozen=True, kw_only=True):
    """A cell that tells where it ran instead of stylizing: its model is what it does."""

    def run(self, out):
        if self.model == "dies":
            os.kill(os.getpid(), signal.SIGKILL)
        if self.model == "dies once" and Rows(out).begin(self) < 3:  # its own start and this one
            os.kill(os.getpid(), signal.SIGKILL)
        (out / "where").mkdir(exist_ok=True)
        cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1
        (out / "where" / f"{self.key}-{os.getpid()}").write_text(str(cores))
        time.sleep(0.05)
        raise RuntimeError("it ran")  # which is a row as any other, and not tried again as one that was refused


def quick(*models):
    recipe = draft("brick", orientations=1)
    return [Quick(model=model, arm="masks", recipe=recipe, vertices=1000) for model in models]


def starts(folder):
    return Counter({path.name: path.stat().st_size for path in (folder / "starts").iterdir()})


def test_every_cell_is_run_once_and_a_second_walk_only_reads(tmp_path):
    told = []
    rows = walk(quick("a", "b", "a"), tmp_path, tell=told.append)
    assert [row.part for row in rows] == ["a", "b", "a"]
    assert len(told) == 2
    assert walk(quick("a", "b"), tmp_path) == rows[:2]
    assert set(starts(tmp_path).values()) == {1}


def test_neighbours_are_of_different_models():
    cells = [Quick(model=model, arm=arm, recipe=draft("brick"), vertices=9) for model in "abc" for arm in "xy"]
    assert [cell.model for cell in module._models_in_turn(cells)] == ["a", "b", "c", "a", "b", "c"]


@pytest.mark.skipif(sys.platform == "win32", reason="kills processes")
def test_processes_that_die_cost_their_own_cell_alone(tmp_path):
    rows = {row.part: row for row in walk(quick("a", "dies", "dies once", "b"), tmp_path, jobs=2)}
    assert rows["dies"].status == "failed"
    assert f"{DEATHS} times" in rows["dies"].refused
    assert {rows[name].refused for name in ("a", "b", "dies once")} == {"RuntimeError: it ran"}
    if hasattr(os, "sched_getaffinity") and len(os.sched_getaffinity(0)) > 1:
        shares = [int(path.read_text()) for path in (tmp_path / "where").iterdir()]
        assert min(shares) <= (len(os.sched_getaffinity(0)) + 1) // 2  # what is tried alone has all cores
    assert os.getpid() not in {int(path.name.split("-")[-1]) for path in (tmp_path / "where").iterdir()}


def test_a_process_has_as_many_threads_as_its_share_of_the_cores_unless_the_environment_says_otherwise(monkeypatch):
    for name in module.THREADS_OF:
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("OMP_NUM_THREADS", "5")
    monkeypatch.setattr(module, "cores", lambda: 16)
    before = dict(os.environ)
    for jobs, share in ((4, "4"), (16, "1"), (40, "1")):
        with module._threads_shared(jobs):
            given = [os.environ[name] for name in module.THREADS_OF if name != "OMP_NUM_THREADS"]
            assert (given, os.environ["OMP_NUM_THREADS"]) == ([share] * 3, "5")
        assert dict(os.environ) == before


def _for_long(parent):
    module._begin_process(multiprocessing.get_context("spawn").Value("i", 0), 1, parent)
    time.sleep(60)


@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX processes")
def test_a_process_ends_with_the_study_that_began_it():
    gone = subprocess.Popen([sys.executable, "-c", "pass"])
    gone.wait()
    process = multiprocessing.get_context("spawn").Process(target=_for_long, args=(gone.pid,))
    process.start()
    process.join(30)
    assert process.exitcode == 1


@pytest.fixture
def scheduler():
    """A scheduler on this machine with two workers that are processes of their own; skipped where Dask is not installed."""
    pytest.importorskip("distributed")
    from distributed import LocalCluster  # noqa: PLC0415

    settings = {"n_workers": 2, "threads_per_worker": 1, "processes": True, "host": "127.0.0.1", "dashboard_address": None}
    with LocalCluster(**settings) as cluster:
        yield cluster


@pytest.mark.filterwarnings("ignore")  # Dask's own, of workers that were killed
def test_a_worker_that_is_killed_leaves_a_complete_table(scheduler, tmp_path):
    recipe = draft("brick", orientations=1)  # of parts that do not exist: rows with a reason, in no time
    cells = [Cell(model=f"part {number}.stl", arm="masks", recipe=recipe, vertices=1000) for number in range(40)]
    pids, killed = [worker.pid for worker in scheduler.workers.values()], threading.Event()

    def kill_one():
        while len(list((tmp_path / "rows").glob("*.json"))) < 3:
            time.sleep(0.02)
        os.kill(pids[0], signal.SIGKILL)
        killed.set()

    threading.Thread(target=kill_one, daemon=True).start()
    rows = walk(cells, tmp_path, scheduler=scheduler.scheduler_address)
    assert sorted(row.part for row in rows) == sorted(cell.part for cell in cells)
    assert {row.status for row in rows} == {"refused"}
    assert len(list((tmp_path / "rows").glob("*.json"))) == 40
    assert killed.is_set()
    assert max(starts(tmp_path).values()) <= 2


def test_a_scheduler_that_is_not_there_is_told_in_one_sentence(tmp_path):
    pytest.importorskip("distributed")
    from dask import config  # noqa: PLC0415

    with config.set({"distributed.comm.timeouts.connect": "200ms"}), pytest.raises(BadInput, match="no Dask scheduler answers"):
        walk(quick("a"), tmp_path, scheduler="tcp://127.0.0.1:9")


def test_without_dask_the_way_to_it_is_told(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(BadInput, match="pip install"):
        walk(quick("a"), tmp_path, scheduler="tcp://127.0.0.1:9")


def test_a_worker_is_given_text_and_answers_with_a_key(tmp_path, monkeypatch):
    import msgspec  # noqa: PLC0415

    monkeypatch.setattr(module, "Cell", Quick)
    monkeypatch.delenv("MECHSTYLE_THREADS", raising=False)
    (cell,) = quick("a")
    assert module.on_worker(msgspec.json.encode(cell).decode(), str(tmp_path)) == cell.key
    assert Rows(tmp_path).of(cell) == carry_out(cell, tmp_path)
    assert os.environ.pop("MECHSTYLE_THREADS") == "1"
    assert Path(tmp_path / "rows").is_dir()
