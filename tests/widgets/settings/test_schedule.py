"""The schedule selector: its preview follows the engine's own rules."""

import itertools

import pytest

from mechstyle_widgets.settings.schedule import ScheduleSelector


@pytest.mark.parametrize(
    ("schedule", "expected"),
    [
        ("every", [5, 10, 15, 20]),
        ("quadratic", [1, 4, 9, 16, 20]),
        ("exponential", [2, 4, 8, 16, 20]),
        ("never", [20]),
    ],
)
def test_fixed_schedules_are_previewed_exactly(schedule, expected):
    assert ScheduleSelector(schedule=schedule, every=5, iterations=20).plan.places == tuple(expected)


def test_a_schedule_that_follows_the_surface_is_estimated_from_a_relief_that_grows_freely():
    """A relief of 1.2 · 0.5 = 0.6 walls, one simulation every tenth of a wall: early ones, one late check, and the last."""
    selector = ScheduleSelector(schedule="geometry", amplitude=0.5, travel=0.1)
    places = selector.plan.places
    gaps = [b - a for a, b in itertools.pairwise(places[:-1])]
    assert places[0] < 15
    assert gaps == sorted(gaps)
    assert 5 <= len(places) <= 8
    assert "an estimate" in selector._note.value


def test_the_preview_moves_with_every_parameter():
    selector = ScheduleSelector(schedule="every", every=50, iterations=200)
    seen = {selector._plot.value}
    other = {"every": 20, "iterations": 100, "schedule": "geometry", "travel": 0.03, "amplitude": 0.5, "relief": 1.5}
    for name, value in other.items():
        setattr(selector, name, value)
        seen.add(selector._plot.value)
    assert len(seen) == 7
