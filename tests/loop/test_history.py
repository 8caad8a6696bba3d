"""What a log, a timeline and a report tell of a run: a row for each checkpoint, what was simulated, which lane came from which."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from mechstyle.loop.history import (
    LaneSummary,
    SimulationLine,
    lanes,
    largest_mask_change,
    per_iteration,
    rows,
    simulated,
    simulations,
    standing,
    steps,
)  # fmt: skip
from mechstyle.loop.objects import Objects
from mechstyle.loop.store import Lane, Store
from mechstyle.records import Doubt
from support.bench import Bench
from support.records import STRENGTH, UNKNOWN, published_row, verdict
from support.records import row as judged_row

THICKNESS = np.full(64, 4.0, np.float32)


@pytest.fixture(scope="module")
def store(tmp_path_factory) -> Store:
    """A lane that had to back off at its end, and a lane branched from its iteration 6; only looked at."""
    bench = Bench(tmp_path_factory.mktemp("history"), gain=120.0)
    recipe = bench.recipe(schedule="every", every=4, iterations=12)
    engine = bench.engine(recipe)
    list(engine.run())
    other, fork = recipe.with_settings(control="linear"), engine.store.find(6).digest
    engine.store.move("soft", Lane(recipe=engine.store.put_recipe(other), head=fork, forked_from=fork))
    list(bench.engine(other, "soft").run())
    return engine.store


@pytest.fixture
def read(monkeypatch) -> list[str]:
    """Digests of the objects that were read."""
    digests: list[str] = []
    whole = Objects.get
    monkeypatch.setattr(Objects, "get", lambda objects, digest: digests.append(digest) or whole(objects, digest))
    return digests


def test_a_row_says_of_each_checkpoint_what_it_holds(store):
    found = rows(store, thickness=THICKNESS)
    assert [row.digest for row in found] == [entry.digest for entry in store.history()]
    for row in found:
        state = store.checkpoint(row.digest)
        assert (row.iteration, row.reason, row.verdict, row.final) == (state.iteration, state.reason, state.verdict, state.final)
        assert (row.restrained, row.vertices) == (int(state.restrained.sum()), 64)
        assert row.travel == pytest.approx(float(np.abs(state.displacement - state.anchor).max()) / 4.0 / 0.1)
        assert row.share == row.restrained / 64
    assert any(0 < row.restrained < 64 for row in found)


def test_a_row_without_a_simulation_has_no_verdict_to_tell(store):
    plain, told = rows(store)[3], rows(store)[4]
    assert (plain.outcome, plain.words) == ("", "")
    assert (told.outcome, told.words) == (told.verdict.outcome, told.verdict.words)


def test_each_iteration_leaves_its_newest_checkpoint(store):
    newest = per_iteration(rows(store))
    assert [row.iteration for row in newest] == list(range(13))
    assert newest[-1].final
    assert len(rows(store)) > 14  # correcting and ending make checkpoints of their own


def test_steps_are_all_simulations_with_what_each_restrained(store):
    told = steps(store, rows(store))
    assert [step.iteration for step in told[:4]] == [0, 4, 8, 12]
    assert all(step.reason.startswith("correction") and step.iteration == 12 for step in told[4:])
    assert len(told) > 4
    assert not any(step.final for step in told)
    before = np.zeros(64, bool)
    for step in told:
        held = store.checkpoint(step.digest).mask < 0.5
        assert (step.restrained, step.added) == (int(held.sum()), int((held & ~before).sum()))
        before = held
    assert largest_mask_change(told) is max(told[1:], key=lambda step: step.added)
    assert largest_mask_change(told[:1]) is None


def test_the_log_leaves_out_the_unstylized_part(store):
    told = steps(store, rows(store))[1:]
    worst = [step.verdict.deciding for step in told]
    wanted = [(step.iteration, step.reason, step.outcome, step.verdict.sure) for step in told]
    found = simulations(store.history())
    assert [(line.iteration, line.reason, line.outcome, line.sure) for line in found] == wanted
    assert [(line.permanent_set, line.allowed) for line in found] == [(row.permanent_set, row.allowed) for row in worst]
    assert {line.stress for line in found} == {None}, "which the published rule alone reads"


def test_what_is_known_is_not_read_again(store, read):
    first = rows(store, thickness=THICKNESS)
    known = {row.digest: row for row in first}
    read.clear()
    assert rows(store, known=known, thickness=THICKNESS) == first
    assert read == []
    rows(store, "soft", known=known, thickness=THICKNESS)
    assert not set(read) & set(known)
    assert not set(read) & {row.mask for row in first}


def test_arrays_are_read_only_where_they_are_asked_for(store, read):
    found = rows(store)
    masks = {row.mask for row in found}
    assert len(masks) < len(found)  # a mask stays from one simulation to the next
    assert sorted(read) == sorted([*(row.digest for row in found), *masks])
    assert all(row.travel is None and row.seconds is None for row in found)


def test_what_a_lane_has_come_to_is_what_is_delivered_not_what_was_simulated_last(store):
    """A report told FAILS of a part that holds, because more had been tried after it in vain."""
    found = rows(store)
    entry, delivered = standing(found)
    assert entry.final
    assert delivered.passes
    worse = [*found[:-1], msgspec.structs.replace(found[-2], verdict=verdict(judged_row(9.0))), found[-1]]
    assert standing(worse) == (entry, delivered)
    begun = found[:6]  # of a lane that has not ended: its last simulation
    assert standing(begun)[0] is [one for one in begun if one.verdict is not None][-1]


def test_seconds_are_those_that_were_measured(store):
    last = store.lane().head
    found = rows(store, seconds={last: 3.5})
    assert [row.seconds for row in found] == [None] * (len(found) - 1) + [3.5]


def test_lanes_say_where_they_stand_and_where_they_come_from(store):
    main, soft = lanes(store, {name: rows(store, name) for name in store.lanes()})
    assert (main.lane, main.parent, main.forked_at, main.changes) == ("main", "", None, ())
    assert (soft.lane, soft.parent, soft.forked_at) == ("soft", "main", 6)
    assert soft.changes == (("control", "exponential", "linear"),)
    for lane in (main, soft):
        assert (lane.iteration, lane.iterations, lane.finished) == (12, 12, True)
        assert lane.outcome == store.checkpoint(store.lane(lane.lane).head).verdict.outcome


def test_entries_tell_of_lanes_what_rows_do(store):
    histories, told = ({name: read(name) for name in store.lanes()} for read in (store.history, lambda name: rows(store, name)))
    assert lanes(store, histories) == lanes(store, told)


def test_programs_that_read_the_log_find_its_fields(store):
    """The fields of `mechstyle log --json` and of the summaries on disk."""
    summary = LaneSummary.of(store, "soft", store.history("soft"))
    assert set(msgspec.to_builtins(summary)) == {"lane", "recipe", "iteration", "finished", "forked_at", "simulations"}
    assert SimulationLine.__struct_fields__ == (
        "iteration", "reason", "outcome", "permanent_set", "allowed", "stress", "limit", "words", "sure",
    )  # fmt: skip


@pytest.mark.parametrize("sure", [True, False])
def test_a_line_knows_whether_its_verdict_is_sure(store, sure):
    entry, known = next(simulated(store.history("main")))
    doubts = () if sure else (Doubt(about="relief", value=0.8),)
    line = SimulationLine.of(entry, msgspec.structs.replace(known, doubts=doubts))
    assert (line.sure, "Not sure" in line.words) == (sure, not sure)


def test_a_line_of_the_published_rule_has_a_stress_and_no_bend(store):
    entry, _ = next(simulated(store.history("main")))
    line = SimulationLine.of(entry, verdict(published_row(60.0), criterion="paper"))
    assert (line.permanent_set, line.allowed, line.stress, line.limit) == (None, None, 60.0, STRENGTH)


def test_a_line_without_an_answer_has_no_figures(store):
    entry, _ = next(simulated(store.history("main")))
    line = SimulationLine.of(entry, UNKNOWN)
    assert (line.outcome, line.permanent_set, line.allowed, line.stress, line.sure) == ("UNKNOWN", None, None, None, False)
