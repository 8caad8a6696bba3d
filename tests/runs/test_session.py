"""A background session pauses, steps and stops between events, and outlives its listeners."""

from __future__ import annotations

import threading

import pytest

from mechstyle.loop.engine import Checkpointed, Finished, Simulated, Stylized
from mechstyle.runs.session import Session

PATIENCE = 30.0  # seconds before a test gives up; nothing waits this long


@pytest.fixture
def engine(bench):
    return bench.engine(bench.recipe(schedule="every", every=20))


def session_of(engine) -> Session:
    return Session(lambda _progress: engine.run())


def test_it_runs_to_the_end_and_tells_every_event(engine):
    session, heard = session_of(engine), []
    session.listen(heard.append)
    session.run()
    assert session.wait(PATIENCE) == "finished"
    assert isinstance(heard[-1], Finished)
    assert sum(isinstance(event, Stylized) for event in heard) == 60


def test_stepping_takes_one_event_at_a_time(engine):
    session, heard = session_of(engine), []
    session.listen(heard.append)
    for count in (1, 2, 3):
        session.step()
        assert session.wait(PATIENCE) == "paused"
        assert len(heard) == count


def test_stepping_to_a_simulation_pauses_after_it(engine):
    session, heard = session_of(engine), []
    session.listen(heard.append)
    session.step_to_simulation()
    session.wait(PATIENCE)
    assert isinstance(heard[-1], Simulated)
    assert heard[-1].iteration == 20


def test_a_stopped_session_leaves_a_run_that_goes_on(engine, bench):
    session = session_of(engine)
    session.step_to_simulation()
    session.wait(PATIENCE)
    session.stop()
    assert session.wait(PATIENCE) == "stopped"
    rest = session_of(bench.engine(engine.recipe))
    rest.run()
    assert rest.wait(PATIENCE) == "finished"


def test_stopping_before_the_start_is_a_stop(engine):
    session = session_of(engine)
    session.stop()
    assert session.state == "stopped"
    with pytest.raises(RuntimeError, match="start a new one"):
        session.run()


def test_a_listener_that_raises_does_not_stop_the_run(engine, caplog):
    session, heard = session_of(engine), []

    def bad(_event):
        raise ValueError("broken plot")

    session.listen(bad)
    session.listen(heard.append)
    session.run()
    assert session.wait(PATIENCE) == "finished"
    assert isinstance(heard[-1], Finished)
    assert "broken plot" in caplog.text


def test_a_listener_can_leave(engine):
    session, heard = session_of(engine), []
    leave = session.listen(heard.append)
    session.step()
    session.wait(PATIENCE)
    leave()
    session.step()
    session.wait(PATIENCE)
    assert len(heard) == 1


def test_an_error_in_the_run_is_kept_for_whoever_asks():
    def broken(_progress):
        yield Stylized(1, 0.0, 0.0)
        raise RuntimeError("no more disk")

    session = Session(broken)
    session.run()
    assert session.wait(PATIENCE) == "failed"
    assert str(session.error) == "no more disk"


@pytest.mark.parametrize("ask", [Session.run, Session.step, Session.step_to_simulation])
def test_a_session_told_to_stop_cannot_be_told_to_go_on(ask):
    inside, leave = threading.Event(), threading.Event()

    def held(_progress):
        yield Stylized(1, 0.0, 0.0)
        inside.set()
        assert leave.wait(PATIENCE)
        yield Stylized(2, 0.0, 0.0)
        yield Stylized(3, 0.0, 0.0)

    session, heard = Session(held), []
    session.listen(heard.append)
    session.run()
    assert inside.wait(PATIENCE)
    session.stop()
    with pytest.raises(RuntimeError, match="asked to stop"):
        ask(session)
    session.pause()
    leave.set()
    assert session.wait(PATIENCE) == "stopped"
    assert [event.iteration for event in heard] == [1, 2]


def test_a_stop_while_stepping_is_a_stop():
    inside, leave = threading.Event(), threading.Event()

    def held(_progress):
        inside.set()
        assert leave.wait(PATIENCE)
        yield Stylized(1, 0.0, 0.0)

    session = Session(held)
    session.step()
    assert inside.wait(PATIENCE)
    session.stop()
    leave.set()
    assert session.wait(PATIENCE) == "stopped"


def test_events_are_closed_before_a_session_says_that_it_stopped():
    """What they hold, such as the lock of a lane, must be free for the next session."""
    held, closed = threading.Event(), []

    def holding(_progress):
        try:
            while True:
                held.set()
                yield Stylized(1, 0.0, 0.0)
        finally:
            closed.append(session.state)

    session = Session(holding)
    session.run()
    assert held.wait(PATIENCE)
    session.stop()
    assert session.wait(PATIENCE) == "stopped"
    assert closed == ["running"]


def test_stopping_reaches_into_a_simulation():
    inside = threading.Event()

    def endless(progress):
        while True:
            inside.set()
            progress(0.5)
            yield from ()

    session = Session(endless)
    session.run()
    assert inside.wait(PATIENCE)
    session.stop()
    assert session.wait(PATIENCE) == "stopped"


def test_it_runs_until_what_was_asked_for_has_happened(engine):
    session, heard = session_of(engine), []
    session.listen(heard.append)
    session.run_until(lambda event: isinstance(event, Checkpointed) and event.checkpoint.iteration == 3)
    assert session.wait(PATIENCE) == "paused"
    assert heard[-1].checkpoint.iteration == 3


def test_a_watcher_is_told_every_state(engine):
    session, states = session_of(engine), []
    session.watch(states.append)
    session.step()
    session.wait(PATIENCE)
    session.run()
    session.wait(PATIENCE)
    assert states == ["running", "paused", "running", "finished"]
