"""The truth behind the Studio: what it shows of a run on disk, and how the news of a worker thread reaches it."""

from __future__ import annotations

import asyncio
import threading

import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.loop.engine import Checkpointed
from mechstyle.loop.objects import Objects
from mechstyle.runs.session import Session
from mechstyle_widgets.state.studio_state import StudioState
from support.lanes import lane_on_a_sheet

PATIENCE = 30.0  # seconds before a test gives up; nothing waits this long


# --- a run on disk ------------------------------------------------------------------------------------------------


def test_a_run_is_shown_where_it_stands(done):
    state = StudioState(done)
    assert (state.lane, state.iteration, state.iterations_done) == ("main", 12, 12)
    assert state.checkpoint.iteration == 12
    assert state.checkpoint.final
    assert (state.status, state.fraction, state.message, state.title) == ("finished", 1.0, "", "sheet, brick")
    assert [row.iteration for row in state.history] == list(range(13))


def test_rows_say_why_and_how_it_went(done):
    rows = StudioState(done).history
    assert [row.iteration for row in rows if row.reason] == [0, 4, 8, 12]
    assert rows[4].reason == "every 4 iterations"
    assert rows[4].outcome in ("HOLDS", "FAILS")
    assert rows[4].words == done.history[4].verdict.words
    assert rows[5].words == ""
    assert rows[4].travel == 0.0  # measured from the last simulation, which this is


def test_travel_is_over_the_threshold_of_the_schedule(done):
    state = StudioState(done)
    at = done.checkpoint(3)
    assert state.history[3].travel == pytest.approx(np.abs(at.displacement - at.anchor).max() / 4.0 / 0.1)


def test_choosing_an_iteration_shows_its_checkpoint(done):
    state = StudioState(done)
    state.iteration = 5
    assert state.checkpoint.iteration == 5
    assert not state.follow


def test_an_iteration_that_is_not_there_is_brought_to_the_nearest(done):
    state = StudioState(done)
    state.iteration = 99
    assert state.iteration == 12
    state.iteration = -3
    assert state.iteration == 0


def test_what_is_told_of_a_run_that_is_opened_is_set_when_it_is_there(done, tmp_path):
    """All that *Both* tells may come in one batch: the lane to compare with is one of the run that is opened, not of the one before."""
    state, other = StudioState(lane_on_a_sheet(tmp_path / "other", iterations=4)), done.store.root
    found = []
    state.observe(lambda change: found.append((change["new"], state.run.store.root)), "pinned")
    state.tell(opened=done, pinned=("soft", 3))
    state.pump()
    assert found == [(("soft", 3), other)]


def test_lanes_know_their_parent_and_what_they_changed(done):
    main, soft = StudioState(done).branches
    assert (main.lane, main.parent, main.forked_at, main.changes) == ("main", "", None, ())
    assert (soft.lane, soft.parent, soft.forked_at) == ("soft", "main", 6)
    assert ("control", "exponential", "linear") in soft.changes
    assert ("every", 4, 3) in soft.changes
    assert soft.finished


def test_a_lane_begun_before_its_parent_had_ended_knows_it(fake):
    """Backing off and ending add checkpoints to the last iteration, so the newest of it is no longer the one that was branched at."""
    events = fake.bench.engine(fake.run.recipe).run()
    next(event for event in events if isinstance(event, Checkpointed) and event.checkpoint.iteration == 12)
    fake.run.branch(12, lane="longer", iterations=16)
    fake.go()
    longer = StudioState(fake.run).branches[1]
    assert (longer.lane, longer.parent, longer.forked_at) == ("longer", "main", 12)


def test_no_array_is_read_again_when_nothing_is_new(done, monkeypatch):
    """Not even those of checkpoints that share the last iteration with a later one."""
    state, read, whole = StudioState(done), [], Objects.get_array
    monkeypatch.setattr(Objects, "get_array", lambda objects, digest: read.append(digest) or whole(objects, digest))
    state.tell(stale=True)
    state.pump()
    assert read == []


def test_another_lane_brings_its_own_history(done):
    state = StudioState(done)
    state.iteration = 9
    before = state.checkpoint
    state.lane = "soft"
    assert state.run.lane == "soft"
    assert state.iteration == 9
    assert state.checkpoint is not before
    assert state.history[6].digest == state.histories["main"][6].digest
    assert state.history[7].digest != state.histories["main"][7].digest


def test_a_lane_that_is_not_there_is_refused(done):
    with pytest.raises(BadInput, match="unknown lane"):
        StudioState(done).lane = "sof"


def test_checkpoints_are_kept_in_memory_for_a_while(done):
    state = StudioState(done)
    assert state.checkpoint_at(3) is state.checkpoint_at(3)
    assert state.checkpoint_at(6, "soft") is state.checkpoint_at(6, "main")  # their common past
    assert state.checkpoint_at(77) is None


# --- news ---------------------------------------------------------------------------------------------------------


def test_nothing_changes_before_it_is_pumped(fake):
    state = StudioState(fake.run)
    session = fake.session()
    state.watch(session, 12)
    session.run()
    assert session.wait(PATIENCE) == "finished"
    assert (state.status, state.iterations_done) == ("idle", 0)
    state.pump()
    assert (state.status, state.iterations_done, state.iteration, state.fraction) == ("finished", 12, 12, 1.0)
    assert state.message == ""
    assert all(row.seconds is not None for row in state.history)


def test_an_earlier_iteration_stays_on_show_while_the_run_goes_on(fake):
    state = StudioState(fake.run)
    session = fake.session()
    state.watch(session, 12)
    session.run_until(lambda event: isinstance(event, Checkpointed) and event.checkpoint.iteration == 5)
    session.wait(PATIENCE)
    state.pump()
    assert (state.status, state.iteration) == ("paused", 5)
    assert state.seconds_left is None
    assert state.fraction == pytest.approx(5 / 12)
    state.iteration = 2
    session.run()
    session.wait(PATIENCE)
    state.pump()
    assert (state.iteration, state.iterations_done) == (2, 12)


def test_traits_change_in_the_thread_of_the_event_loop_only(fake):
    async def cell() -> set[str]:
        state, session = StudioState(fake.run), fake.session()
        state.watch(session, 12)
        threads, ended = set(), asyncio.Event()
        state.observe(lambda _change: threads.add(threading.current_thread().name))
        state.observe(lambda change: ended.set() if change["new"] == "finished" else None, "status")
        session.run()
        await asyncio.wait_for(ended.wait(), PATIENCE)
        return threads

    assert asyncio.run(cell()) == {threading.main_thread().name}


def test_what_fails_is_told_in_one_sentence(fake):
    def broken(_progress):
        raise BadInput("the disk is made of cheese: eat it")
        yield

    state, session = StudioState(fake.run), Session(broken)
    state.watch(session, 12)
    session.run()
    session.wait(PATIENCE)
    state.pump()
    assert (state.status, state.message) == ("failed", "the disk is made of cheese: eat it")


def test_an_older_session_has_nothing_more_to_say(fake):
    state, old, new = StudioState(fake.run), fake.session(), fake.session()
    state.watch(old, 12)
    state.watch(new, 12)
    old.stop()
    state.pump()
    assert state.status == "idle"


def test_a_run_that_ends_while_it_is_opened_is_not_looked_for_in_an_empty_history(fake, monkeypatch):
    monkeypatch.setattr(type(fake.run), "finished", property(lambda _run: True))
    state = StudioState(fake.run)
    assert (state.status, state.message, state.history) == ("idle", "", [])
