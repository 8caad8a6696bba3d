"""What corrects a finished relief: where it is lowered, that a step looks at its own effect, what is kept in the end, and that it ends."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from mechstyle.loop import correction
from mechstyle.loop.correction import (
    AIM,
    EDGES,
    GAIN,
    LOCAL_ROUNDS,
    MIN_GAIN,
    MOST,
    NEAREST,
    REACH,
    Correction,
    Finding,
    lowered_share,
    neighbours,
    remaining_share,
)
from mechstyle.records.mesh import SurfaceMesh
from support.bench import grid

COUNT = 60
LINE = np.zeros((COUNT, 3))
LINE[:, 0] = np.arange(COUNT)  # [mm]: one vertex every millimetre, so that distances can be read off
NEAR = neighbours(LINE, REACH + 1e-9)
STRIP = SurfaceMesh(LINE, np.arange(COUNT - 2)[:, None] + np.arange(3))  # without any area, hence with edges of no length
RAISED = np.ones(COUNT, np.float32)
BRICKS = np.where(np.arange(COUNT) % 2, -1.0, 1.0).astype(np.float32)
"""A relief that cuts into every second vertex and raises the others [mm]."""
NOWHERE = np.zeros(COUNT, bool)
UNDER = np.arange(COUNT) < 40  # as if the first 40 mm were what the part stands on
MOST_TRIES = 14


def peak(*places, height=1.2, elsewhere=0.2):
    """Overload that is high at some places and low elsewhere."""
    used = np.full(COUNT, elsewhere, np.float32)
    used[list(places)] = height
    return used


def corrected(worst, overload=lambda _: peak(30), wanted=RAISED, finished=None, standing=NOWHERE, target=None):
    """The reliefs that were tested with their findings, the finished one first, and what is kept in the end.

    A made part passes a relief whose `worst` is at most 1; `worst` is None where a test gives no answer.
    """
    target = wanted if target is None else target

    def kept(relief):
        return float((relief * target).sum() / (target * target).sum())

    def tested(relief):
        used = worst(relief)
        if used is None:
            return Finding(False)
        return Finding(used <= 1.0, used, None if used <= 1.0 else overload(relief))

    finished = wanted if finished is None else finished
    tried = [(finished, "", tested(finished))]
    search = Correction(STRIP, wanted, kept, standing).tries(finished, tried[0][-1])
    step = next(search, None)
    while step is not None:
        tried.append((*step, tested(step[0])))
        try:
            step = search.send(tried[-1][-1])
        except StopIteration:
            step = None
    assert len(tried) <= 1 + MOST_TRIES
    assert len({relief.tobytes() for relief, *_ in tried}) == len(tried), "none is tested twice"
    assert all(np.all((one * np.sign(wanted) >= 0.0) & (np.abs(one) <= np.abs(wanted))) for one, *_ in tried)
    return tried, max((kept(relief) for relief, _, found in tried if found.passes), default=None)


# --- lowering -------------------------------------------------------------------------------------------------------


def test_relief_is_lowered_around_what_is_overloaded_and_nowhere_else():
    taken = lowered_share(peak(30), NEAR)
    assert taken[30] == taken.max() > 0.3
    assert np.all(taken[27:34] > 0.0)
    assert not taken[:24].any()  # 3 mm of reach, and 3 of smoothing
    assert not taken[37:].any()


def test_the_more_overloaded_the_more_is_taken_but_never_all():
    slightly, plainly, wildly = (lowered_share(peak(30, height=height), NEAR)[30] for height in (0.9, 1.0, 50.0))
    assert 0.0 < slightly < plainly < wildly <= MOST


def test_what_is_taken_of_a_place_that_is_overloaded_all_around():
    over = np.float32(0.2)
    expected = GAIN * over / (1.0 + 0.3 * over)
    assert lowered_share(np.full(COUNT, AIM, np.float32) + over * (np.arange(COUNT) > 20), NEAR)[40] == pytest.approx(expected, rel=1e-5)


def test_where_no_vertex_is_overloaded_though_a_test_does_not_pass_the_highest_are_lowered():
    taken = lowered_share(peak(30, height=0.5), NEAR)
    assert taken[30] > 0.0
    assert not taken[:24].any()


@pytest.mark.parametrize("share", [0.0, 1e-3, 0.4])
def test_a_part_without_any_stress_loses_little(share):
    assert lowered_share(np.full(COUNT, share, np.float32), NEAR).max() <= 0.11 * share * 2.5 + 1e-6


@pytest.mark.parametrize("edge", [1.0, 4.0, 15.0])
def test_on_coarse_triangles_too_more_than_the_overloaded_vertex_is_lowered(edge):
    surface = grid(12, edge)
    middle = int(np.argmin(np.linalg.norm(surface.vertices - surface.vertices.mean(axis=0), axis=1)))
    used = np.full(len(surface.vertices), 0.2, np.float32)
    used[middle] = 1.3
    whole = np.ones_like(used)
    search = Correction(surface, whole, lambda relief: float(relief.mean()), used < 0.0)
    relief, _ = next(search.tries(whole, Finding(False, 1.3, used)))
    beside = surface.edges[(surface.edges == middle).any(axis=1)]
    assert np.all(relief[beside] < 0.75), "a vertex that stands alone is not relieved by being lowered alone"
    away = np.linalg.norm(surface.vertices - surface.vertices[middle], axis=1)
    assert np.all(relief[away > 2.0 * max(REACH, EDGES * surface.edge_length)] == 1.0)


def test_what_is_left_is_a_share_of_what_there_was_and_all_of_it_where_it_was_raised():
    before, after = np.array([0.5, -0.5, 0.0, 2.0, 1.0, 1.0], np.float32), np.array([0.25, -0.5, 0.3, 0.0, 1.5, -0.1], np.float32)
    assert np.array_equal(remaining_share(before, after), np.array([0.5, 1.0, 1.0, 0.0, 1.0, 0.0], np.float32))


# --- what is kept in the end ----------------------------------------------------------------------------------------


def test_a_relief_that_passes_at_once_is_not_touched():
    tried, kept = corrected(lambda _: 0.99)
    assert (len(tried), kept) == (1, 1.0)


@pytest.mark.parametrize("factor", [0.17, 0.8])
def test_where_nothing_local_helps_it_ends_at_the_factor_that_passes_and_never_at_none(factor):
    """A pill box in brick ended without any relief, where .8 of it passed; what bears is not lowered a third time."""
    tried, kept = corrected(lambda relief: float(np.abs(relief).max()) / factor, wanted=BRICKS)
    assert factor - NEAREST <= kept <= factor
    assert len(tried) <= 1 + 2 + 4


def test_one_factor_is_tried_where_the_lowering_here_and_there_kept_less():
    """Lowered here and there it passes with a third, by one factor with .8."""
    tried, kept = corrected(
        lambda relief: min(float(relief.max()) / 0.8, float(relief.mean()) / 0.35), lambda _: np.full(COUNT, 1.6, np.float32)
    )
    assert any(found.passes and "relief lowered" in words for _, words, found in tried)
    assert 0.8 - NEAREST <= kept <= 0.8


def test_where_it_yields_at_one_place_far_more_is_kept_than_by_one_factor():
    tried, kept = corrected(lambda relief: float(relief[30]) / 0.4)
    assert kept > 0.85
    assert len(tried) <= 8


def test_half_of_what_was_too_much_is_given_back():
    tried, kept = corrected(lambda relief: float(relief[30]) / 0.74, lambda _: peak(*range(20, 40)))
    lowered = tried[1][0]
    assert kept > lowered.mean() / RAISED.mean()
    assert "half of the removed relief put back" in [words for _, words, _ in tried]


def test_what_was_tested_as_a_factor_is_not_tested_again_as_half_of_what_was_taken(monkeypatch):
    """Lowered by half everywhere, half of it given back is three quarters, a factor that failed before."""
    monkeypatch.setattr(correction, "lowered_share", lambda used, _: np.full(len(used), 0.5, np.float32))
    tried, kept = corrected(lambda relief: float(relief.max()) / 0.55)
    assert kept == 0.5
    assert "75% of the whole relief" in [words for _, words, _ in tried]


def test_a_little_is_not_given_back():
    tried, _ = corrected(lambda relief: float(relief[30]) / 0.99, lambda _: peak(30, height=0.9))
    assert "put back" not in tried[-1][1]


def test_only_a_part_that_fails_in_every_try_loses_all_of_it():
    tried, kept = corrected(lambda relief: 2.0 if relief.any() else 0.5, wanted=BRICKS)
    assert kept == 0.0
    assert tried[-1][1] == "the relief removed"
    assert not np.signbit(tried[-1][0]).any(), "no minus zero: the bytes of the unstylized part"
    assert corrected(lambda _: 2.0)[1] is None


def test_where_a_test_gave_no_answer_one_factor_is_tried_at_once():
    tried, kept = corrected(lambda relief: None if relief.max() > 0.6 else 0.9)
    assert [words for _, words, _ in tried[1:]] == ["50% of the whole relief", "75% of the whole relief", "62% of the whole relief",
                                                    "56% of the whole relief"]  # fmt: skip
    assert kept == pytest.approx(0.5625)


@given(
    seed=st.integers(0, 2**16), factor=st.floats(0.07, 1.0), slack=st.floats(0.3, 3.0), masked=st.floats(0.1, 1.0), cuts=st.booleans(),
    breaks=st.booleans(),
)  # fmt: skip
def test_whatever_the_part_no_less_is_kept_than_by_the_best_factor(seed, factor, slack, masked, cuts, breaks):
    """It passes with that factor on all of the relief and with less, and by the mean of some places that are lowered."""
    draw, wanted = np.random.default_rng(seed), BRICKS if cuts else RAISED
    places = draw.choice(COUNT, 12, replace=False)

    def worst(relief):
        whole, here = float(np.abs(relief).max()) / factor, float(np.abs(relief[places]).mean()) / (factor * slack)
        return None if breaks and 1.5 < min(whole, here) < 2.0 else min(whole, max(here, 0.3 * whole))

    finished = (wanted * np.float32(masked)).astype(np.float32)
    noise = draw.uniform(0.0, 2.0, COUNT).astype(np.float32)
    _, kept = corrected(worst, lambda _: np.where(np.isin(np.arange(COUNT), places), noise + 1.0, noise), wanted, finished)
    assert kept >= min(factor, 1.0) - NEAREST - 1e-6
    assert kept > 0.0


def best_by_halving(passes):
    """The factor on all of a relief that halving to NEAREST finds, as the arm of a study does that does nothing else."""
    low, high = 0.0, 1.0
    while high - low > NEAREST:
        factor = 0.5 * (low + high)
        low, high = (factor, high) if passes(factor) else (low, factor)
    return low


@given(passing=st.sets(st.integers(1, 15)), here=st.floats(0.0, 1.0), width=st.integers(1, 50), cuts=st.booleans())
@example(passing=set(range(1, 12)), here=0.66, width=30, cuts=False)
def test_no_less_is_kept_than_by_one_factor_alone_even_where_less_relief_is_no_better(passing, here, width, cuts):
    """A pill box in brick failed with .9 of it and with all, and passed with .8; lowered here and there a part passes with what is left."""
    wanted = BRICKS if cuts else RAISED

    def worst(relief):
        share = np.abs(relief)
        if share.min() < share.max():
            return 0.9 if share.mean() <= here else 1.5
        return 0.9 if share[0] == 0.0 or passes(float(share[0])) else 2.0

    def passes(factor):
        return math.ceil(16.0 * factor - 1e-4) in passing

    _, kept = corrected(worst, lambda _: peak(*range(width), height=1.6), wanted)
    assert kept >= best_by_halving(passes) - 1e-6


# --- a step looks at its own effect ---------------------------------------------------------------------------------


def section(relief, load):
    """Share used of a section that a raised place strengthens and a cut weakens, at its weakest place."""
    return load / float((1.0 + 0.5 * relief)[20:40].min())


def test_cuts_are_filled_before_anything_raised_is_lowered():
    tried, kept = corrected(lambda relief: section(relief, 0.8), lambda _: peak(*range(20, 40), height=1.6), BRICKS)
    first, words, _ = tried[1]
    assert words.startswith("cuts filled around 20 places")
    assert np.array_equal(first[BRICKS > 0.0], BRICKS[BRICKS > 0.0]), "what bears stays"
    assert np.all(first[20:40][BRICKS[20:40] < 0.0] > -0.5)
    assert np.all(first[:10] == BRICKS[:10])
    assert kept > 0.8


def test_a_lowering_that_made_it_worse_is_undone_and_the_other_way_is_tried():
    """What is raised is the lever here, and filling a cut adds to it."""
    tried, kept = corrected(lambda relief: float(0.3 + relief[30] + 0.5 * (1.0 + relief[31])), lambda _: peak(30, 31), BRICKS)
    assert [words.split(" around")[0] for _, words, _ in tried[1:3]] == ["cuts filled", "relief lowered"]
    second = tried[2][0]
    assert second[31] == -1.0
    assert second[30] < 1.0
    assert kept > 0.8


def test_a_lowering_that_helped_is_gone_on_from():
    tried, kept = corrected(lambda relief: float(0.5 - 1.5 * relief[31]), lambda _: peak(30, 31), BRICKS)
    assert -1.0 < tried[1][0][31] < tried[2][0][31]
    assert np.all(tried[2][0][::2] == 1.0)
    assert kept > 0.8


def test_after_a_lowering_that_helped_both_ways_are_open_again():
    answers = iter([3.0, 2.5, 2.6, 2.4, 2.3, 2.2] + [0.5] * 9)
    tried, _ = corrected(lambda _: next(answers), lambda _: peak(*range(20, 40)), BRICKS)
    ways = [words.split(" around")[0] for _, words, _ in tried[1:6]]
    assert ways == ["cuts filled", "cuts filled", "relief lowered", "relief lowered", "relief lowered"]


def test_of_a_relief_that_is_less_than_was_asked_for_no_factor_is_tried_that_keeps_less_than_is_known_to_pass():
    """Without restraint .8 of the target came about, and half of that passes already."""
    tried, kept = corrected(
        lambda relief: float(relief.mean()) / 0.6, lambda _: np.full(COUNT, 0.95, np.float32), target=np.float32(1.25) * RAISED
    )
    local = next(relief for relief, words, found in tried if found.passes)
    factors = [relief.mean() for relief, words, _ in tried if words.endswith("whole relief")]
    assert min(factors) > local.mean(), "those were halved, and not tested"
    assert any(factors[0] == pytest.approx(factor) for factor in (0.5, 0.75, 0.875))
    assert kept >= 0.8 * (0.6 - NEAREST)


def test_what_helped_neither_way_is_left_for_one_factor():
    """Raised or cut, each lowering makes it worse: the relief bears."""
    tried, _ = corrected(lambda relief: 4.0 - 2.0 * float(np.abs(relief).mean()) if relief.any() else 0.5, wanted=BRICKS)
    words = [words.split(" around")[0] for _, words, _ in tried[1:]]
    assert words[:3] == ["cuts filled", "relief lowered", "50% of the whole relief"]


def test_a_step_without_an_answer_is_undone_too():
    tried, kept = corrected(lambda relief: None if (relief[1::2] != -1.0).any() and relief.max() == 1.0 else float(relief[30]) / 0.6,
                            lambda _: peak(*range(28, 33)), BRICKS)  # fmt: skip
    assert not tried[1][2].passes
    assert tried[2][1].startswith("relief lowered")
    assert kept > 0.5


def test_lowering_here_and_there_ends_after_some_rounds():
    left = iter(np.linspace(3.0, 2.0, 40))
    tried, _ = corrected(lambda _: float(next(left)))
    assert sum("lowered around" in words for _, words, _ in tried) == LOCAL_ROUNDS


# --- what masks held back -------------------------------------------------------------------------------------------

HALF = np.full(COUNT, 0.5, np.float32)


def test_all_that_was_held_back_is_tried_at_once_and_taken_if_the_part_passes_with_it():
    tried, kept = corrected(lambda _: 0.9, finished=np.where(UNDER, 0.0, HALF).astype(np.float32), standing=UNDER)
    assert (len(tried), kept) == (2, 1.0)


@pytest.mark.parametrize("limit", [0.7, 0.4], ids=["passes", "fails"])
def test_where_it_fails_lowering_begins_at_all_that_is_asked_for(limit):
    """What masks held back of half a relief is seldom what overloads the finished one; a factor below it is no gain."""
    tried, kept = corrected(lambda relief: float(relief[30]) / limit, finished=HALF)
    assert np.array_equal(tried[1][0], RAISED)
    assert np.array_equal(tried[2][0] < 1.0, lowered_share(peak(30), NEAR) > 0.0)
    assert kept > 0.85


def test_what_passed_is_never_exchanged_for_less():
    tried, kept = corrected(lambda relief: 0.9 if relief is HALF else 2.0, finished=HALF)
    assert kept == 0.5
    assert all(relief.mean() > 0.5 for relief, words, _ in tried if words.endswith("whole relief"))


def test_a_little_that_was_held_back_is_not_worth_a_drop():
    assert len(corrected(lambda _: 0.9, finished=np.full(COUNT, 1.0 - 0.9 * MIN_GAIN, np.float32))[0]) == 1


# --- what the part stands on ----------------------------------------------------------------------------------------


def test_where_the_part_stands_relief_is_taken_away_around_what_yields_because_a_lower_gap_carries_no_more():
    tried, _ = corrected(lambda relief: 2.0 if relief[20] else 0.9, lambda _: peak(20), standing=UNDER)
    lowered = tried[1][0]
    assert np.array_equal(np.flatnonzero(lowered == 0.0), np.arange(17, 24)), "it stands on more, 3 mm around"
    assert np.all(lowered[:11] == 1.0), "and has its relief elsewhere"


def test_a_part_that_yields_elsewhere_keeps_its_relief_where_it_stands():
    tried, _ = corrected(lambda relief: float(relief[55]) / 0.7, lambda _: peak(55), standing=UNDER)
    assert all(np.all(relief[UNDER] == 1.0) for relief, words, _ in tried if "whole" not in words)


def test_what_was_laid_flat_is_not_given_back_by_halves():
    tried, kept = corrected(lambda relief: 2.0 if relief[30] else 0.9, lambda _: peak(*range(25, 45)), standing=UNDER)
    given_back = [relief for relief, words, _ in tried if words == "half of the removed relief put back"]
    assert given_back
    assert all(np.array_equal(relief == 0.0, tried[1][0] == 0.0) for relief in given_back)
    assert kept > tried[1][0].mean()
