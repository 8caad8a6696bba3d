"""What a run will take: falls are counted as the simulator makes them, time grows with what is asked for."""

import pytest

from mechstyle.runs.recipes import recipe_for
from mechstyle.simulation.estimate import NEARLY_FLAT, SECONDS_PER_STEP, STEP, Estimate, estimated, plan_of, seconds_of_a_fall


def of(vertices=4000, cores=2, fall=None, **settings):
    return estimated(recipe_for("brick", **settings), vertices, cores=cores, fall=fall)


def test_plain_part_finished_relief_and_a_correction_fall_in_all_landings():
    assert of(nearly_flat=False).falls == 3
    assert of().falls == 3 * (1 + NEARLY_FLAT)
    assert of(orientations=6).falls == 3 * (6 + NEARLY_FLAT)
    assert of(freestyle=True).falls == 2 * (1 + NEARLY_FLAT), "which is not corrected"


def test_on_the_way_it_falls_in_the_landings_that_steer():
    planned = plan_of(recipe_for("brick", schedule="stress").settings)
    assert not planned.certain
    assert 1 < len(planned.places) < 12
    assert of(schedule="stress").falls == of().falls + (len(planned.places) - 1) * 3
    assert of(schedule="every", every=20, iterations=200).falls == of().falls + 9 * 3
    assert of(schedule="every", every=20, iterations=200, nearly_flat=False).falls == 3 + 9


def test_time_is_tetrahedra_times_steps():
    assert seconds_of_a_fall(1000, window=0.4) == pytest.approx(1000 * 0.4 / STEP * SECONDS_PER_STEP["tet10"])
    assert seconds_of_a_fall(2000) == 2 * seconds_of_a_fall(1000)
    # 7974 tetrahedra of the wall hook took 15 120 steps and 6.3 s of one core when steps were 1.4 times shorter
    assert seconds_of_a_fall(7974) == pytest.approx(6.3 / 1.4, rel=0.15)


def test_what_falls_took_on_this_machine_counts_more_than_the_estimate():
    assert of(fall=0.1).seconds < of().seconds < of(fall=60.0).seconds


@pytest.mark.parametrize("more", [{"vertices": 8000}, {"schedule": "stress"}, {"orientations": 20}, {"cores": 1}, {"window": 3.0}])
def test_more_of_anything_takes_longer(more):
    assert of(**more).seconds > of().seconds


def test_it_is_one_sentence_in_round_figures():
    assert Estimate(1500.0, 8, 38.2).words == "We let it fall from 1.5 m, in simulation, about 8 times: about 40 s."
    assert Estimate(800.0, 30, 431.0).words == "We let it fall from 80 cm, in simulation, about 30 times: about 7 min."
    assert Estimate(1500.0, 8, 0.4).words.endswith("about 5 s.")
