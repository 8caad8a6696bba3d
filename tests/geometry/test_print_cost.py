"""What a print costs: colours counted layer by layer on bodies whose answer is known."""

import numpy as np
import pytest
from manifold3d import Manifold

from mechstyle.geometry.filaments import PURGED, Painted, banded, changes_of, cheaper, colours_by_layer, in_bands, print_cost
from mechstyle.geometry.remeshing.evening import surface_of
from mechstyle.geometry.threemf import threemf_bytes
from support.slicer import FOUR_FILAMENTS, prusa_slicer, tools_by_height

FOUR = ("#000000", "#0000FF", "#FFFFFF", "#FF0000")


def quarters(sphere):
    """The sphere in four colours around its axis: each layer shows all four."""
    x, y, _ = sphere.vertices.T
    return Painted(sphere, FOUR, (2 * (x > 0.0) + (y > 0.0)).astype(np.int32))


@pytest.fixture(scope="module")
def patched():
    """A block 9 mm high of one filament, with a patch of another in the middle of its floor and of its top."""
    mesh = surface_of(Manifold.cube((20.0, 20.0, 9.0)).refine(20))
    x, y, z = mesh.vertices.T
    within = (np.maximum(np.abs(x - 10.0), np.abs(y - 10.0)) < 6.5) & (np.abs(z - 4.5) > 4.4)
    return Painted(mesh, FOUR[:2], within.astype(np.int32))


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


def test_a_layer_is_of_the_colour_at_its_middle(cube):
    """The cube is 10 mm high, of one filament below and another above: they meet at 5 mm, above the middle of the sixth of these layers."""
    shown = colours_by_layer(Painted(cube, FOUR[:2], (cube.vertices[:, 2] > 5.0).astype(np.int32)), 0.9)
    assert shown.tolist() == [[True, False]] * 6 + [[False, True]] * 6
    assert changes_of(shown) == 1


def test_floors_and_tops_colour_their_solid_layers(patched):
    shown = colours_by_layer(patched, 0.3)
    assert shown[:, 0].all()
    assert np.flatnonzero(shown[:, 1]).tolist() == [0, 1, 2, 26, 27, 28, 29]


def test_prusaslicer_shows_in_each_layer_what_was_reckoned(patched, tmp_path):
    (tmp_path / "part.3mf").write_bytes(threemf_bytes(patched.mesh, paint=patched))
    prusa_slicer("--export-gcode", *FOUR_FILAMENTS, "-o", tmp_path / "part.gcode", tmp_path / "part.3mf")
    found = tools_by_height((tmp_path / "part.gcode").read_text())
    shown = colours_by_layer(patched, 0.3)
    assert [found[height] for height in sorted(found)] == [set(np.flatnonzero(layer)) for layer in shown]


def test_a_layer_that_shares_nothing_with_the_last_takes_a_change_more():
    shown = np.array([[1, 0, 0], [0, 1, 0], [0, 1, 1], [0, 0, 1]], dtype=bool)
    assert changes_of(shown) == 1 + 1
    assert changes_of(shown[:1]) == 0


def test_each_change_purges_and_one_colour_needs_none(sphere):
    one = print_cost(Painted(sphere, FOUR, np.zeros(len(sphere.vertices), np.int32)))
    four = print_cost(quarters(sphere))
    assert (one.changes, one.purged, one.palette) == (0, (0.0, 0.0), FOUR[:1])
    assert four.purged == pytest.approx([four.changes * each for each in PURGED])
    assert one.words == "no change of filament in 100 layers"
    assert four.words == f"{four.changes} changes of filament in 100 layers, 32 to 120 cm³ purged"


def test_fewer_filaments_are_offered_with_fewer_changes_each(sphere):
    offers = cheaper(quarters(sphere))
    assert [len(offer.palette) for offer in offers] == [3, 2, 1]
    assert all(set(offer.palette) < set(FOUR) for offer in offers)
    counts = [print_cost(quarters(sphere)).changes, *(offer.changes for offer in offers)]
    assert counts == sorted(counts, reverse=True)
    assert counts[-1] == 0
