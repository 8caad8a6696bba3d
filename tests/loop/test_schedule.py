"""When a simulation is due: exact iterations, triggers on hand-made fields, and reasons a person can read."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mechstyle.loop.schedule import RULES, Progress, due
from mechstyle.records import SCHEDULES, Recipe
from mechstyle.records.material import LIBRARY


def recipe(schedule, **settings):
    return Recipe.of(**{"surface": "s", "tetrahedra": "t", "prompt": "brick", "material": LIBRARY["PLA"], "schedule": schedule, **settings})


def progress(travelled=(0.0, 0.0, 0.0), thickness=(2.0, 4.0, 1.0), demand=(0.0, 0.0, 0.0), iteration=30, simulated_at=0):
    fields = (np.array(values, np.float32) for values in (travelled, thickness, demand))
    return Progress(iteration, simulated_at, *fields)


def iterations_due(one, state=None):
    """Iterations 1 to 200 at which a run that does what the schedule says is simulated."""
    found, state = [], state or progress()
    for iteration in range(1, 201):
        if due(one, replace(state, iteration=iteration, simulated_at=found[-1] if found else 0)):
            found.append(iteration)
    return found


# --- by iteration -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("schedule", "settings", "expected"),
    [
        ("every", {"every": 20}, [20, 40, 60, 80, 100, 120, 140, 160, 180, 200]),
        ("every", {"every": 70}, [70, 140]),
        ("every", {"every": 1}, list(range(1, 201))),
        ("every", {"every": 201}, []),
        ("quadratic", {}, [1, 4, 9, 16, 25, 36, 49, 64, 81, 100, 121, 144, 169, 196]),
        ("exponential", {}, [2, 4, 8, 16, 32, 64, 128]),
        ("never", {}, []),
    ],
)
def test_schedules_by_iteration_are_due_exactly_then(schedule, settings, expected):
    assert iterations_due(recipe(schedule, **settings)) == expected


@pytest.mark.parametrize("schedule", SCHEDULES)
def test_no_reason_is_no_words(schedule):
    """What is due is shown to the user and kept in the run; every schedule rests at iteration 3."""
    assert due(recipe(schedule), progress(iteration=3, simulated_at=2)) == ""


@pytest.mark.parametrize("schedule", ["every", "quadratic", "exponential", "never"])
def test_schedules_by_iteration_do_not_look_at_the_surface(schedule):
    wild = progress(travelled=(9.0, 9.0, 9.0), demand=(5.0, 5.0, 5.0))
    assert iterations_due(recipe(schedule), wild) == iterations_due(recipe(schedule))


@pytest.mark.parametrize(
    ("schedule", "steps"),
    [("quadratic", [root * root for root in range(1, 317)]), ("exponential", [2**power for power in range(1, 17)])],
)
def test_steps_stay_exact_up_to_the_longest_run(schedule, steps):
    long = recipe(schedule, iterations=100_000)
    assert all(due(long, progress(iteration=step)) for step in steps)
    assert not any(due(long, progress(iteration=step + 1)) for step in steps)


@pytest.mark.parametrize(
    ("schedule", "iteration", "words"),
    [
        ("every", 40, "every 20 iterations"),
        ("quadratic", 49, "quadratic step 7² = 49"),
        ("exponential", 64, "exponential step 2^6 = 64"),
    ],
)
def test_reasons_name_the_step(schedule, iteration, words):
    assert due(recipe(schedule), progress(iteration=iteration)) == words


# --- by geometry --------------------------------------------------------------------------------------------------


def test_geometry_is_due_when_one_vertex_moved_a_tenth_of_its_wall():
    moved = progress(travelled=(0.1, 0.52, 0.05), thickness=(2.0, 4.0, 1.0))  # 5 %, 13 % and 5 %
    assert due(recipe("geometry"), moved) == "the relief has moved 0.52 mm on a wall of 4.0 mm: more than 10.0% of it"
    assert due(recipe("geometry", travel=0.2), moved) == ""


def test_the_share_of_the_wall_counts_not_the_way():
    moved = progress(travelled=(0.3, 0.39, 0.2), thickness=(4.0, 4.0, 1.0))
    assert due(recipe("geometry"), moved).startswith("the relief has moved 0.20 mm on a wall of ")


def test_a_cut_counts_as_much_as_a_bump():
    inwards = progress(travelled=(0.0, -0.52, 0.0))
    assert due(recipe("geometry"), inwards) == "the relief has moved 0.52 mm on a wall of 4.0 mm: more than 10.0% of it"


def test_geometry_is_due_above_its_threshold_not_at_it():
    at = np.float32(0.5)  # an eighth of 4 mm, exact in binary
    above = np.nextafter(at, np.float32(1))
    assert due(recipe("geometry", travel=0.125), progress(travelled=(0.0, at, 0.0))) == ""
    assert due(recipe("geometry", travel=0.125), progress(travelled=(0.0, above, 0.0)))


def test_geometry_does_not_look_at_demand():
    assert due(recipe("geometry"), progress(travelled=(0.1, 0.1, 0.01), demand=(9.0, 9.0, 9.0))) == ""


# --- by stress ----------------------------------------------------------------------------------------------------


def test_stress_lowers_the_threshold_in_proportion_to_demand():
    moved = (0.0, 0.24, 0.0)  # 6 % of 4 mm, between half of 10 % and 10 %
    assert due(recipe("stress"), progress(travelled=moved)) == ""
    loaded = progress(travelled=moved, demand=(0.0, 0.5, 0.0))
    assert due(recipe("stress"), loaded) == "the relief has moved 0.24 mm on a wall of 4.0 mm: more than 5.0% of it"


def test_stress_is_due_above_its_threshold_not_at_it():
    at = np.float32(0.25)  # a sixteenth of 4 mm: half of an eighth, exact in binary
    above = np.nextafter(at, np.float32(1))
    assert due(recipe("stress", travel=0.125), progress(travelled=(0.0, at, 0.0), demand=(0.0, 0.5, 0.0))) == ""
    assert due(recipe("stress", travel=0.125), progress(travelled=(0.0, above, 0.0), demand=(0.0, 0.5, 0.0)))


def test_stress_names_the_vertex_furthest_beyond_its_own_threshold():
    """Not the one that moved furthest: 8 % of an unloaded wall is fine, 3 % of a loaded one is not."""
    loaded = progress(travelled=(0.16, 0.12, 0.0), demand=(0.0, 0.8, 0.0))
    assert due(recipe("stress"), loaded) == "the relief has moved 0.12 mm on a wall of 4.0 mm: more than 2.0% of it"


@pytest.mark.parametrize("demand", [0.9, 1.0, 7.0, np.inf])
def test_the_threshold_falls_to_a_tenth_and_no_further(demand):
    below, above = (progress(travelled=(0.0, way, 0.0), demand=(0.0, demand, 0.0)) for way in (0.036, 0.044))  # 0.9 % and 1.1 %
    assert due(recipe("stress"), below) == ""
    assert due(recipe("stress"), above).endswith("more than 1.0% of it")


@given(demand=st.floats(0, 3, width=32))
def test_the_threshold_is_never_above_that_of_geometry(demand):
    """Not even where the stress has fallen below that of the unstylized part, whatever demand a caller makes of that."""
    moved = progress(travelled=(0.0, 0.44, 0.0), demand=(0.0, -demand, 0.0))  # 11 % of 4 mm
    assert due(recipe("stress"), moved).endswith("more than 10.0% of it")


ways = arrays(np.float32, 5, elements=st.floats(-1, 1, width=32))
loads = arrays(np.float32, 5, elements=st.floats(0, 3, width=32))
walls = arrays(np.float32, 5, elements=st.floats(0.5, 10, width=32))


@given(travelled=ways, thickness=walls)
def test_without_demand_stress_is_due_when_geometry_is(travelled, thickness):
    state = progress(travelled, thickness, np.zeros(5))
    assert bool(due(recipe("stress"), state)) == bool(due(recipe("geometry"), state))


@given(travelled=ways, thickness=walls, demand=loads)
def test_demand_never_postpones_a_simulation(travelled, thickness, demand):
    calm, loaded = progress(travelled, thickness, np.zeros(5)), progress(travelled, thickness, demand)
    assert due(recipe("stress"), loaded) or not due(recipe("stress"), calm)


# --- the late check -----------------------------------------------------------------------------------------------

driven = pytest.mark.parametrize("schedule", ["geometry", "stress"])


@driven
def test_a_surface_that_hardly_moves_is_looked_at_once_late(schedule):
    assert iterations_due(recipe(schedule)) == [150]
    assert due(recipe(schedule), progress(iteration=150)) == "late check after 75% of the iterations"


@driven
def test_the_late_check_follows_the_length_of_the_run(schedule):
    assert iterations_due(recipe(schedule, iterations=40)) == [30]


@driven
def test_there_is_no_late_check_if_something_was_simulated_since(schedule):
    assert due(recipe(schedule), progress(iteration=160, simulated_at=150)) == ""
    assert due(recipe(schedule), progress(iteration=160, simulated_at=155)) == ""


@driven
def test_a_lane_that_comes_to_its_schedule_late_is_checked_at_once(schedule):
    """A branch at 160 of a run that was never simulated must not wait for an iteration that is past."""
    assert due(recipe(schedule), progress(iteration=161, simulated_at=0))


@driven
def test_a_trigger_at_the_late_check_gives_its_own_reason(schedule):
    assert due(recipe(schedule), progress(travelled=(0.0, 0.52, 0.0), iteration=150)).startswith("the relief has moved")


# --- names --------------------------------------------------------------------------------------------------------


def test_every_schedule_a_recipe_may_name_has_a_rule():
    assert set(RULES) == set(SCHEDULES)
