"""What a print costs: colours counted layer by layer on bodies whose answer is known."""

import numpy as np
import pytest

from mechstyle.geometry.filaments import Painted, in_bands
from mechstyle.geometry.print_cost import SECONDS, banded, changes_of, cheaper, colours_by_layer, print_cost

FOUR = ("#000000", "#0000FF", "#FFFFFF", "#FF0000")


def quarters(sphere):
    """The sphere in four colours around its axis: each layer shows all four."""
    x, y, _ = sphere.vertices.T
    return Painted(sphere, FOUR, (2 * (x > 0.0) + (y > 0.0)).astype(np.int32))


def test_every_layer_of_quarters_shows_four_colours(sphere):
    shown = colours_by_layer(quarters(sphere))
    assert shown.shape == (100, 4)
    assert shown[1:-1].all()
    assert changes_of(shown) == pytest.approx(3 * 100, abs=6)  # at the poles a colour may begin a layer later


def test_bands_change_as_often_as_they_have_borders(sphere):
    cost = print_cost(in_bands(sphere, FOUR))
    assert (cost.layers, cost.palette) == (100, FOUR)
    assert 3 <= cost.changes <= 3 * 3  # a border runs along edges, through two layers or three
    assert banded(quarters(sphere)).changes == cost.changes


def test_a_layer_that_shares_nothing_with_the_last_takes_a_change_more():
    shown = np.array([[1, 0, 0], [0, 1, 0], [0, 1, 1], [0, 0, 1]], dtype=bool)
    assert changes_of(shown) == 1 + 1
    assert changes_of(shown[:1]) == 0


def test_hours_grow_with_changes_and_one_colour_has_none(sphere):
    one = print_cost(Painted(sphere, FOUR, np.zeros(len(sphere.vertices), np.int32)))
    four = print_cost(quarters(sphere))
    assert (one.changes, one.purged, one.palette) == (0, (0.0, 0.0), FOUR[:1])
    assert one.hours == (one.hours_plain, one.hours_plain)
    assert four.hours_plain == one.hours_plain < four.hours_laying
    assert four.hours == pytest.approx([four.hours_laying + four.changes * each / 3600.0 for each in SECONDS])
    assert "no change of filament" in one.words
    assert f"{four.changes} changes of filament in 100 layers" in four.words


def test_fewer_filaments_are_offered_with_fewer_changes_each(sphere):
    offers = cheaper(quarters(sphere))
    assert [len(offer.palette) for offer in offers] == [3, 2]
    assert all(set(offer.palette) < set(FOUR) for offer in offers)
    counts = [print_cost(quarters(sphere)).changes, *(offer.changes for offer in offers)]
    assert counts == sorted(counts, reverse=True)
