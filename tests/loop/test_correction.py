"""What lowers a finished relief that does not pass for sure: where, by how much, what is given back, and that it always ends."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mechstyle.loop.correction import (
    EDGES,
    GIVE_BACK,
    LOCAL_ROUNDS,
    MIN_GAIN,
    MOST,
    PATCH_ROUNDS,
    REACH,
    WHOLE,
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
WHOLE_RELIEF = np.ones(COUNT, np.float32)


def peak(*places, height=1.2, elsewhere=0.2):
    """Utilisation that is high at some places and low elsewhere."""
    used = np.full(COUNT, elsewhere, np.float32)
    used[list(places)] = height
    return used


NOWHERE = np.zeros(COUNT, bool)
UNDER = np.arange(COUNT) < 40  # as if the first 40 mm were what the part stands on


def search(passes, used, limit=40, standing=NOWHERE, begun=WHOLE_RELIEF, sure=None):
    """The shares that were tested, the correction at its end; `passes`, `used` and `sure` are functions of the shares.

    The relief is one millimetre high everywhere, so that what is left of it are its shares. What passes does so for sure unless told.
    """
    found, share, tested = Correction(STRIP, WHOLE_RELIEF, lambda share: float(share.mean()), standing), begun, []
    while True:
        tested.append(share)
        assert len(tested) < limit
        settled = passes(share) if sure is None else sure(share)
        tried = found.tested(share, Finding(passes(share), None if settled else used(share)))
        if tried is None:
            return tested, found
        share = tried[0]


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


def test_where_no_vertex_is_overloaded_though_a_test_does_not_pass_the_highest_are_lowered():
    taken = lowered_share(peak(30, height=0.5), NEAR)
    assert taken[30] > 0.0
    assert not taken[:24].any()


@pytest.mark.parametrize("share", [0.0, 1e-3, 0.4])
def test_a_part_without_any_stress_loses_little(share):
    assert lowered_share(np.full(COUNT, share, np.float32), NEAR).max() <= 0.11 * share * 2.5 + 1e-6


# --- the search -----------------------------------------------------------------------------------------------------


def test_a_relief_that_passes_for_sure_is_left_as_it_is():
    tested, found = search(lambda _: True, lambda _: peak(30))
    assert len(tested) == 1
    assert found.sure is WHOLE_RELIEF


def test_one_correction_is_lowered_and_then_given_back_while_that_is_worth_a_drop():
    tested, found = search(lambda share: share[30] < 0.8, lambda _: peak(*range(20, 40)))
    assert found.sure is not None
    assert found.sure[30] < 0.8
    assert 1.0 > found.sure.mean() > tested[1].mean(), "some of the first lowering was given back"
    assert len(tested) == 2 + GIVE_BACK


def test_what_is_given_back_never_fails_in_the_end():
    tested, found = search(lambda share: share[30] < 0.45, lambda _: peak(*range(20, 40)))
    assert found.sure is not None
    assert found.sure[30] < 0.45
    assert any(np.array_equal(found.sure, share) for share in tested)


def test_a_little_is_not_given_back():
    tested, _ = search(lambda share: share[30] < 0.99, lambda _: peak(30, height=0.4))
    assert len(tested) == 2, "less than a hundredth of the relief was lowered"


def test_where_lowering_here_and_there_is_not_enough_the_whole_relief_is():
    tested, found = search(lambda share: not share.any(), lambda _: peak(30))
    assert len(tested) == 1 + LOCAL_ROUNDS + len(WHOLE) + GIVE_BACK
    assert found.sure is not None
    assert not found.sure.any()
    assert np.array_equal(np.signbit(found.sure), np.zeros(COUNT, bool)), "no minus zero: the bytes of the unstylized part"


def test_a_test_without_a_field_leads_straight_to_the_whole_relief():
    tested, _ = search(lambda share: share[0] <= 0.7, lambda _: None)
    assert np.all(tested[1] == np.float32(WHOLE[0]))


def test_what_passes_but_not_for_sure_is_lowered_here_and_there_and_never_as_a_whole():
    """To be sure is worth some relief at its place, not half of all of it."""
    tested, found = search(lambda _: True, lambda _: peak(30), sure=lambda _: False)
    assert len(tested) == 1 + LOCAL_ROUNDS
    assert (found.sure, found.passed) == (None, True)
    assert all(np.all(share[:20] == 1.0) for share in tested)


def test_what_passes_is_lowered_until_it_does_so_for_sure():
    tested, found = search(lambda _: True, lambda _: peak(30), sure=lambda share: share[30] < 0.8)
    assert found.sure is not None
    assert found.sure[30] < 0.8 < tested[0][30]


def test_what_failed_and_passes_only_just_is_not_halved():
    """Halving would cost relief far from the place that is nearest to its limit."""
    tested, found = search(lambda share: share[30] < 0.9, lambda _: peak(30), sure=lambda _: False)
    assert found.passed
    assert all(share[:20].min() == 1.0 for share in tested)


def test_a_part_that_fails_without_any_relief_ends_too():
    tested, found = search(lambda _: False, lambda _: peak(30))
    assert found.sure is None
    assert len(tested) == 1 + LOCAL_ROUNDS + len(WHOLE)


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**16), bound=st.floats(0.0, 1.0))
def test_whatever_the_stress_the_search_ends_with_shares_between_none_and_all(seed, bound):
    draw = np.random.default_rng(seed)
    tested, found = search(lambda share: float(share.mean()) <= bound, lambda _: draw.uniform(0.0, 3.0, COUNT).astype(np.float32))
    assert all(share.min() >= 0.0 and share.max() <= 1.0 for share in tested)
    assert found.sure is not None
    assert found.sure.mean() <= bound


@pytest.mark.parametrize("edge", [1.0, 4.0, 15.0])
def test_on_coarse_triangles_too_more_than_the_overloaded_vertex_is_lowered(edge):
    surface = grid(12, edge)
    middle = int(np.argmin(np.linalg.norm(surface.vertices - surface.vertices.mean(axis=0), axis=1)))
    used = np.full(len(surface.vertices), 0.2, np.float32)
    used[middle] = 1.3
    search = Correction(surface, np.ones_like(used), lambda share: float(share.mean()), used < 0.0)
    share, _ = search.tested(np.ones_like(used), Finding(passes=False, utilisation=used))
    beside = surface.edges[(surface.edges == middle).any(axis=1)]
    assert np.all(share[beside] < 0.75), "a vertex that stands alone is not relieved by being lowered alone"
    away = np.linalg.norm(surface.vertices - surface.vertices[middle], axis=1)
    assert np.all(share[away > 2.0 * max(REACH, EDGES * surface.edge_length)] == 1.0)


# --- what the part stands on ----------------------------------------------------------------------------------------


def test_under_a_load_the_base_is_a_place_like_any_other():
    """What laying it flat costs buys nothing there: no load goes from bump to bump of what the part stands on."""
    search = Correction(STRIP, WHOLE_RELIEF, lambda share: float(share.mean()), UNDER)
    share = WHOLE_RELIEF
    for _ in range(2):
        tried = search.tested(share, Finding(passes=False, utilisation=peak(50), fails_by_drop=False))
        assert tried is not None
        share = tried[0]
    assert share[50] < 0.6
    assert np.all(share[:30] == 1.0)


def test_where_the_part_stands_relief_is_taken_away_around_what_is_overloaded_because_a_lower_gap_carries_no_more():
    tested, _ = search(lambda share: share[20] == 0.0, lambda _: peak(20), standing=UNDER)
    lowered = tested[1]
    assert np.array_equal(np.flatnonzero(lowered == 0.0), np.arange(17, 24)), "it stands on more, 3 mm around"
    assert np.all(lowered[:11] == 1.0), "and has its relief elsewhere"


def test_a_part_that_is_overloaded_elsewhere_first_keeps_its_relief_where_it_stands():
    tested, _ = search(lambda share: share[55] < 0.9, lambda _: peak(55), standing=UNDER)
    assert len(tested) > 1
    assert all(np.all(share[UNDER] == 1.0) for share in tested)


@pytest.mark.parametrize("overloaded", [20, 55])
def test_when_wider_patches_do_not_help_it_is_laid_flat_before_anything_is_lowered_as_a_whole(overloaded):
    """Wherever it is overloaded: a phone stand bends by what it stands on, 50 MPa at its top instead of 44."""
    tested, found = search(lambda share: not share[UNDER].any(), lambda _: peak(overloaded), standing=UNDER)
    assert len([share for share in tested if share[UNDER].any()]) == 1 + PATCH_ROUNDS
    assert not found.sure[UNDER].any()
    assert found.sure[[45, 50, 59]].all(), "the rest was lowered at most"


def test_what_was_laid_flat_is_not_given_back_by_halves():
    tested, found = search(lambda share: share[30] == 0.0, lambda _: peak(*range(25, 45)), standing=UNDER)
    given_back = tested[2:]
    assert given_back
    assert all(np.array_equal(share == 0.0, tested[1] == 0.0) for share in given_back)
    assert found.sure.mean() > tested[1].mean()


# --- what is given back ---------------------------------------------------------------------------------------------

HELD_BACK = np.full(COUNT, 0.5, np.float32)


def test_all_that_was_held_back_is_given_back_at_once_if_the_part_holds_with_it():
    """What the part stands on, too: the loop lays it flat at the first high landing of a relief that is half grown."""
    begun = np.where(UNDER, 0.0, HELD_BACK).astype(np.float32)
    tested, found = search(lambda _: True, lambda _: peak(30, height=0.95), standing=UNDER, begun=begun)
    assert len(tested) == 2
    assert np.array_equal(found.sure, WHOLE_RELIEF)


def test_what_lowering_leaves_of_it_is_given_back_where_it_fails():
    tested, found = search(lambda share: share[30] < 0.7, lambda _: peak(30), begun=HELD_BACK)
    assert np.array_equal(tested[1], WHOLE_RELIEF)
    assert np.array_equal(tested[2] < 1.0, lowered_share(peak(30), NEAR) > 0.0)
    assert found.sure.mean() > 0.9


def test_half_of_what_was_too_much_is_given_back():
    tested, found = search(lambda share: share[30] < 0.75, lambda _: peak(*range(20, 40)), begun=WHOLE_RELIEF)
    assert tested[2][30] == pytest.approx(0.5 * (1.0 + tested[1][30]))
    assert found.sure is tested[2]


def test_lowering_begins_at_all_that_is_asked_for_whatever_was_held_back_before():
    """What masks held back of half a relief is seldom what overloads the finished one."""
    tested, found = search(lambda share: share[30] < 0.45, lambda _: peak(30), begun=HELD_BACK)
    assert np.all(tested[1][:24] == 1.0)
    assert found.sure.mean() > 0.9


def test_a_relief_that_failed_whole_is_not_tried_whole_again():
    tested, _ = search(lambda share: share[30] < 0.7, lambda _: peak(30))
    assert not any(np.array_equal(share, WHOLE_RELIEF) for share in tested[1:])


def test_giving_back_ends():
    """Whatever fails, it is given up for what held."""
    tested, found = search(lambda share: share is HELD_BACK, lambda _: peak(30), begun=HELD_BACK)
    assert len(tested) == 1 + GIVE_BACK
    assert found.sure is HELD_BACK


def test_where_it_has_failed_with_it_nothing_is_given_back_under_the_part():
    flat = np.where(UNDER, 0.0, HELD_BACK).astype(np.float32)
    tested, found = search(lambda share: not share[UNDER].any(), lambda _: peak(height=0.0, elsewhere=0.4), standing=UNDER, begun=flat)
    assert [bool(share[UNDER].any()) for share in tested] == [False, True, False]
    assert tested[2][~UNDER].mean() > flat[~UNDER].mean()
    assert found.sure is tested[2]


def test_a_little_that_was_held_back_is_not_worth_a_drop():
    tested, _ = search(lambda _: True, lambda _: np.zeros(COUNT, np.float32), begun=np.full(COUNT, 1.0 - 0.9 * MIN_GAIN, np.float32))
    assert len(tested) == 1


def test_what_is_left_is_a_share_of_what_there_was_and_all_of_it_where_it_was_raised():
    before, after = np.array([0.5, -0.5, 0.0, 2.0, 1.0, 1.0], np.float32), np.array([0.25, -0.5, 0.3, 0.0, 1.5, -0.1], np.float32)
    assert np.array_equal(remaining_share(before, after), np.array([0.5, 1.0, 1.0, 0.0, 1.0, 0.0], np.float32))
