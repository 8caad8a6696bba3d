"""Time left and time spent."""

import pytest

from mechstyle_widgets.state import time_left
from mechstyle_widgets.state.time_left import Outlook, Stopwatch


def test_nothing_is_foretold_before_a_drop_test():
    outlook = Outlook()
    outlook.record(0.1, simulated=False)
    assert outlook.seconds_left(10) is None


def test_drop_tests_are_expected_as_often_as_they_came():
    """One in four at 8 s, the others at 1 s: eight more are two drop tests and six others."""
    outlook = Outlook()
    for simulated in (False, False, False, True):
        outlook.record(8.0 if simulated else 1.0, simulated=simulated)
    assert outlook.seconds_left(8) == pytest.approx(2 * 8.0 + 6 * 1.0)


def test_the_last_iteration_is_a_drop_test_whatever_came_before():
    outlook = Outlook()
    outlook.record(5.0, simulated=True)
    for _ in range(9):
        outlook.record(1.0, simulated=False)
    assert outlook.seconds_left(1) == pytest.approx(5.0)


def test_pauses_do_not_count(monkeypatch):
    now = [0.0]
    monkeypatch.setattr(time_left.time, "monotonic", lambda: now[0])
    watch = Stopwatch()
    for step, act in ((0.0, watch.run), (3.0, watch.pause), (100.0, watch.run), (2.0, watch.run)):
        now[0] += step
        act()
    assert watch.lap() == pytest.approx(5.0)
    now[0] += 1.5
    assert watch.lap() == pytest.approx(1.5)
    assert watch.total == pytest.approx(6.5)
