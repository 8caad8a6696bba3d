"""Words of painted triangles: those the slicers' sources name, and every one of ours read back."""

import itertools

import numpy as np
import pytest

from mechstyle.geometry.threemf import distinct, paint_codes
from support.painting import decoded, state_at

# `CONST_FILAMENTS` of Bambu Studio and OrcaSlicer; PrusaSlicer reads the same.
WHOLE = ["4", "8", "0C", "1C", "2C", "3C", "4C", "5C", "6C", "7C", "8C", "9C", "AC", "BC", "CC", "DC"]


@pytest.mark.parametrize("filament", range(16))
def test_a_triangle_of_one_filament_has_the_word_that_slicers_list(filament):
    assert paint_codes(np.full((1, 3), filament)) == [WHOLE[filament]]


def test_each_corner_of_a_triangle_has_its_filament_and_each_side_changes_in_its_middle():
    corners = np.array(list(itertools.product(range(5), repeat=3)))
    for filaments, word in zip(corners, paint_codes(corners), strict=True):
        tree = decoded(word)
        for corner in range(3):
            for share in (0.9, 0.6, 0.51):
                for other in (1, 2):
                    place = [0.0, 0.0, 0.0]
                    place[corner], place[(corner + other) % 3] = share, 1.0 - share
                    assert state_at(tree, place) == filaments[corner] + 1


def test_the_middle_is_of_two_corners_or_of_the_first_filament():
    middle = (0.4, 0.3, 0.3)
    for filaments, state in (((2, 1, 1), 2), ((1, 2, 1), 2), ((1, 1, 2), 2), ((3, 1, 2), 2), ((5, 9, 0), 1)):
        assert state_at(decoded(paint_codes(np.array([filaments]))[0]), middle) == state


@pytest.mark.parametrize("filaments", [1, 2, 16])
def test_distinct_triples_are_those_that_occur_in_order(filaments):
    corners = np.random.default_rng(filaments).integers(0, filaments, (500, 3)).astype(np.int32)
    kinds, which = distinct(corners)
    expected, places = np.unique(corners, axis=0, return_inverse=True)
    assert np.array_equal(kinds, expected)
    assert np.array_equal(which, places.reshape(-1))
