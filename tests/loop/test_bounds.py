"""How far a style may go: whatever it proposes, it stays within its bounds, above the floor, and out of walls that are thin."""

from dataclasses import replace

import numpy as np
import pytest

from mechstyle.loop.bounds import Bounds, advanced, unrestrained_relief
from support.bench import grid
from support.records import recipe

COUNT = 6
WALL = np.full(COUNT, 4.0, np.float32)
ALL = np.ones(COUNT, np.float32)
WILD = np.array([-9.0, -0.5, 0.0, 0.5, 2.0, 9.0], np.float32)


class Floor:
    """Stands on its first two vertices, where nothing goes out; the rest is level as it is."""

    standing = np.arange(COUNT) < 2

    def levelled(self, displacement):
        return np.where(self.standing, 0.0, displacement).astype(np.float32)

    def clipped(self, displacement):
        return np.where(self.standing, np.minimum(displacement, 0.0), displacement).astype(np.float32)


@pytest.fixture
def bounds():
    return Bounds(thickness=WALL, inward=0.25 * WALL, outward=WALL, freedom=ALL)


def test_a_relief_is_cut_at_its_bounds_and_otherwise_left(bounds):
    assert bounds.clipped(WILD).tolist() == [-1.0, -0.5, 0.0, 0.5, 2.0, 4.0]
    assert np.array_equal(bounds.levelled(WILD), WILD)
    assert not bounds.standing.any()


def test_what_it_stands_on_has_the_last_word(bounds):
    """The unsafe side: a bump under a part lets it stand on less than it is tested on."""
    based = replace(bounds, base=Floor())
    assert based.clipped(np.abs(WILD))[:2].tolist() == [0.0, 0.0]
    assert based.standing.tolist() == [True, True, False, False, False, False]
    assert based.levelled(WILD)[:2].tolist() == [0.0, 0.0]


def test_what_cannot_be_seen_does_not_count_unless_nothing_can(bounds):
    surface = grid(3)
    areas = surface.vertex_areas
    half = np.where(np.arange(9) < 4, 0.0, 1.0).astype(np.float32)
    assert np.array_equal(bounds.seen_areas(surface), areas)
    assert np.array_equal(replace(bounds, seen=half).seen_areas(surface), areas * half)
    assert np.array_equal(replace(bounds, seen=0.0 * half).seen_areas(surface), areas)


def test_an_iteration_lets_through_what_the_mask_says_and_no_more_than_the_bounds(bounds):
    free = recipe(control="none", schedule="never")
    mask = np.array([0.0, 0.0, 0.5, 0.5, 1.0, 1.0], np.float32)
    found = advanced(np.full(COUNT, 3.5, np.float32), mask, ALL, bounds, free)
    assert found.tolist() == [3.5, 3.5, 4.0, 4.0, 4.0, 4.0]


def test_many_iterations_never_cut_a_wall_below_the_thinnest_that_can_be_printed():
    thin = Bounds(thickness=np.full(COUNT, 1.0, np.float32), inward=ALL, outward=ALL, freedom=ALL)
    asked, minimum = np.full(COUNT, -1.0, np.float32), 0.8
    grown = unrestrained_relief(asked, thin, recipe(iterations=20, minimum_wall=minimum))
    assert (1.0 + grown).min() >= minimum - 1e-3
    assert grown.max() < 0.0


def test_a_finished_proposal_grows_to_itself_where_nothing_is_in_its_way(bounds):
    asked = np.linspace(-0.9, 3.9, COUNT).astype(np.float32)
    np.testing.assert_allclose(unrestrained_relief(asked, bounds, recipe(iterations=40)), asked, atol=1e-4)
    assert not unrestrained_relief(asked, replace(bounds, freedom=0.0 * ALL), recipe(iterations=40)).any()
