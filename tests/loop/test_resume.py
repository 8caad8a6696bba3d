"""Stopping loses nothing: a run carried on from any point gives the same bytes as one that never stopped."""

from __future__ import annotations

import itertools
import os
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from mechstyle.loop.engine import Checkpointed, Simulated
from mechstyle.loop.store import Lane, Store
from support import ROOT

SETTINGS = {"schedule": "every", "every": 7, "iterations": 45}


def objects_of(root) -> dict[str, bytes]:
    return {str(path.relative_to(root)): path.read_bytes() for path in sorted(Path(root).rglob("*")) if path.is_file()}


@pytest.fixture
def whole(bench, tmp_path):
    bench.gain = 200.0  # so that there is restraint, and corrections to resume into
    straight = replace(bench, root=tmp_path / "straight")
    list(straight.engine(straight.recipe(**SETTINGS)).run())
    return straight.root


@pytest.mark.parametrize("stop_after", [1, 2, 40, 41, 60, 97, 100, 103, 106])
def test_a_run_stopped_between_any_two_events_resumes_to_the_same_bytes(bench, whole, stop_after):
    recipe = bench.recipe(**SETTINGS)
    taken = list(itertools.islice(bench.engine(recipe).run(), stop_after))
    assert len(taken) == stop_after, "the run must still have been going"
    list(bench.engine(recipe).run())
    assert objects_of(bench.root) == objects_of(whole)


def test_a_finished_run_carried_on_changes_nothing(bench, whole):
    before = objects_of(whole)
    again = replace(bench, root=whole)
    events = list(again.engine(again.recipe(**SETTINGS)).run())
    assert objects_of(whole) == before
    assert events


CRAWL = """
import sys
sys.path[:0] = [{tests!r}]
from support.bench import Bench
from support import ROOT
bench = Bench({root!r}, gain=200.0)
print("started", flush=True)
for event in bench.engine(bench.recipe(**{settings!r})).run():
    print(type(event).__name__, flush=True)
"""


@pytest.mark.parametrize("lines", [3, 30, 77])
def test_a_run_killed_with_sigkill_resumes_to_the_same_bytes(bench, whole, lines):
    script = CRAWL.format(tests=str(ROOT / "tests"), root=str(bench.root), settings=SETTINGS)
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, env={**os.environ, "PYTHONUNBUFFERED": "1"}) as process:
        for _ in range(lines):
            assert process.stdout.readline()
        process.send_signal(signal.SIGKILL)
    list(bench.engine(bench.recipe(**SETTINGS)).run())
    leftovers = {name for name in objects_of(bench.root) if ".new-" in name}
    assert {name: data for name, data in objects_of(bench.root).items() if name not in leftovers} == objects_of(whole)


def test_a_branch_shares_its_past_with_its_parent(bench):
    recipe = bench.recipe(**SETTINGS)
    list(bench.engine(recipe).run())
    store = Store(bench.root)
    fork = store.find(20).digest
    other = bench.recipe(**{**SETTINGS, "control": "linear"})
    store.move("other", Lane(recipe=store.put_recipe(other), head=fork, forked_from=fork))
    list(bench.engine(other, "other").run())
    main, branch = store.history("main"), store.history("other")
    assert [entry.digest for entry in main[:21]] == [entry.digest for entry in branch[:21]]
    assert main[21].digest != branch[21].digest
    assert branch[21].recipe == other.digest
    assert branch[-1].final


def test_a_branch_without_changes_repeats_its_parent(bench):
    recipe = bench.recipe(**SETTINGS)
    list(bench.engine(recipe).run())
    store = Store(bench.root)
    fork = store.find(20).digest
    store.move("same", Lane(recipe=store.put_recipe(recipe), head=fork, forked_from=fork))
    list(bench.engine(recipe, "same").run())
    assert store.lane("same").head == store.lane("main").head


def test_resuming_replays_the_stylizer_from_the_nearest_keyframe_only(bench):
    recipe = bench.recipe(schedule="never", iterations=60, guarantee=False)
    for event in bench.engine(recipe).run():
        if isinstance(event, Checkpointed) and event.checkpoint.iteration == 50:
            break
    engine = bench.engine(recipe)
    next(event for event in engine.run() if isinstance(event, Simulated))
    assert engine.stylizer.steps == 10 + (60 - 50)
