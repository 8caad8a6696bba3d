"""What a run will take: falls are counted as the simulator makes them, time grows with what is asked for."""

import pytest

from mechstyle.records import sentences
from mechstyle.simulation.estimate import (
    NEARLY_FLAT,
    SECONDS_PER_STEP,
    STEP,
    Estimate,
    before_the_first_fall,
    estimated,
    impact_times,
    seconds_of_a_fall,
)
from support.dropped_block import simulator

TRY = {"vertices": 4000, "tests": 5, "height": 1500.0, "iterations": 200, "cores": 2}


def test_falls_are_those_of_the_plain_part_of_the_tests_on_the_way_and_of_the_last():
    assert estimated(**TRY, nearly_flat=False).falls == 1 + 4 + 1
    assert estimated(**TRY).falls == 2 * (1 + NEARLY_FLAT) + 4 * 3
    assert estimated(**TRY, orientations=6).falls == 2 * (6 + NEARLY_FLAT) + 4 * 3
    quick = estimated(**TRY, hardest_only=True, rough=True)
    assert quick.falls == 1 + NEARLY_FLAT // 2 + 5 * 3
    assert quick.seconds < estimated(**TRY, hardest_only=True).seconds < estimated(**TRY).seconds
    known = [estimated(**TRY, nearly_flat=False, rough=rough, fall=3.0).seconds for rough in (False, True)]
    assert known[0] == known[1], "a fall that was measured is as rough as the others"


def test_time_is_tetrahedra_times_steps():
    assert seconds_of_a_fall(1000, window=0.4) == pytest.approx(1000 * 0.4 / STEP * SECONDS_PER_STEP["tet10"])
    assert seconds_of_a_fall(2000) == 2 * seconds_of_a_fall(1000)
    # 7974 tetrahedra of the wall hook took 15 120 steps and 6.3 s of one core when steps were 1.4 times shorter
    assert seconds_of_a_fall(7974) == pytest.approx(6.3 / 1.4, rel=0.15)


def test_what_falls_took_on_this_machine_counts_more_than_the_estimate():
    slow, quick = (estimated(**TRY, fall=seconds).seconds for seconds in (60.0, 0.1))
    assert quick < estimated(**TRY).seconds < slow


@pytest.mark.parametrize("more", [{"vertices": 8000}, {"tests": 9}, {"orientations": 20}, {"cores": 1}, {"window": 3.0}])
def test_more_of_anything_takes_longer(more):
    assert estimated(**{**TRY, **more}).seconds > estimated(**TRY).seconds


def test_it_is_one_sentence_in_round_figures():
    assert Estimate(1500.0, 8, 38.2).words == "We let it fall from 1.5 m, in simulation, about 8 times: about 40 s."
    assert sentences.planned(800.0, 30, 431.0) == "We let it fall from 80 cm, in simulation, about 30 times: about 7 min."
    assert sentences.planned(1500.0, 8, 0.4).endswith("about 5 s.")
    assert sentences.measured_out(13, 38.2).endswith("it falls about 13 times, which takes about 40 s.")


@pytest.mark.parametrize(("settings", "falls"), [
    ({"orientations": 1}, 1 + 1),
    ({"orientations": 3}, 2 * (3 + 1)),
    ({"orientations": 1, "nearly_flat": True}, 2 * (9 + 1)),
    ({"orientations": 1, "nearly_flat": True, "hardest_only": True}, 9 + 3),
    ({"orientations": 1, "nearly_flat": True, "hardest_only": True, "rough": True}, 4 + 3),
])  # fmt: skip
def test_before_the_first_fall_the_very_tetrahedra_are_asked(block, memo, settings, falls):
    sim = simulator(block, memo, **settings)
    found = before_the_first_fall(sim, cores=1)
    assert found.falls == falls
    assert before_the_first_fall(sim, cores=4).seconds > 0.0
    assert found.seconds > 0.0


def test_a_nearly_flat_fall_is_followed_until_the_far_side_is_down(block, memo):
    flat, tilted = impact_times(simulator(block, memo, window=None))
    assert 0.05 < flat < tilted < flat + 0.5
    assert impact_times(simulator(block, memo, window=0.1)) == (0.1, 0.1)
