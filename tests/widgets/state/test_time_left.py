"""Time spent."""

import pytest

from mechstyle_widgets.state import time_left
from mechstyle_widgets.state.time_left import Stopwatch


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
