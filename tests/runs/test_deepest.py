"""The deepest relief that passes: which depths are tried, and what is said to limit it."""


import pytest

from mechstyle.errors import BadInput
from mechstyle.runs.deepest import DEPTHS, deepest, deepest_of
from support.records import FALL, VERDICT, row
from support.records import verdict as judged


def trial(limit):
    """A verdict for every depth up to a limit that holds, and what was asked for."""
    asked = []

    def verdict(depth):
        asked.append(depth)
        if depth <= limit:
            return VERDICT
        return judged(row(0.5 * FALL, original=2.0 * FALL), style=f"brick at {depth:g}")

    return verdict, asked


@pytest.mark.parametrize("limit", [0.0, 0.15, 0.2, 0.3, 0.5, 0.7, 0.9])
def test_the_deepest_relief_that_passes_is_found_and_the_next_one_says_why(limit):
    verdict, asked = trial(limit)
    found = deepest_of(DEPTHS, verdict)
    within = [depth for depth in DEPTHS if depth <= limit]
    assert found.amplitude == (max(within) if within else DEPTHS[0])
    assert len(asked) == len(set(asked)) <= 4
    beyond = [depth for depth in DEPTHS if depth > limit]
    assert (f"brick at {beyond[0]:g}" in found.words) if beyond else ("it passes" in found.words)


def test_the_deepest_is_tried_first_because_often_it_passes():
    verdict, asked = trial(1.0)
    assert deepest_of(DEPTHS, verdict).amplitude == DEPTHS[-1]
    assert asked == [DEPTHS[-1]]


def test_a_part_that_bears_no_relief_at_all_gets_the_least_and_the_reason():
    verdict, _ = trial(0.0)
    failed = verdict(0.15)
    assert failed.words.startswith("FAILS a fall of 1.5 m")
    assert deepest_of(DEPTHS, verdict).words == f"even 0.15 of the wall does not pass without correction ({failed.words})"


def test_a_relief_that_is_no_worse_passes():
    found = deepest_of(DEPTHS, lambda _: judged(row(0.9 * FALL, outcome="NO WORSE", original=FALL)))
    assert found.amplitude == DEPTHS[-1]


def test_a_relief_in_millimetres_leaves_nothing_to_find(sphere, tmp_path):
    with pytest.raises(BadInput, match=r"a relief of 0\.6 mm is asked for, and the deepest that passes: leave out one of them"):
        deepest(sphere, "brick", out=tmp_path, relief=0.6)
