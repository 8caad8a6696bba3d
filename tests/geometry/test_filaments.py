"""Colours of filaments: palettes read and chosen, nearest colours, islands no nozzle draws."""

import warnings

import numpy as np
import pytest

from mechstyle._colour import oklab, srgb_to_linear
from mechstyle.errors import BadInput
from mechstyle.geometry import filaments as module
from mechstyle.geometry.filaments import LINE, MOST, Painted, clustered, display, in_bands, merged, nearest, painted, palette_of

BLACK_WHITE = ("#000000", "#FFFFFF")


def rainbow(count):
    """`count` different colours, shape [count, 3]."""
    return np.random.default_rng(4).random((count, 3)).astype(np.float32)


def test_a_palette_is_read_as_people_write_it():
    assert palette_of(" #111111, f4f1e8,#C0392b") == ("#111111", "#F4F1E8", "#C0392B")
    assert palette_of(["111111", "#222222"]) == ("#111111", "#222222")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (",".join(f"{k:06x}" for k in range(17)), "17 colours"),
        ("red,#111111", "'red' is no colour"),
        ("#111,#222222", "six hexadecimal digits"),
        ("#ABCDEF,abcdef", "#ABCDEF is twice"),
        ("#111111,,#222222", "'' is no colour"),
    ],
)
def test_a_palette_that_is_none_is_refused_in_a_sentence(text, said):
    with pytest.raises(BadInput, match=said):
        palette_of(text)


@pytest.mark.parametrize("count", [1, 2, 5, MOST])
def test_a_choice_has_no_more_colours_than_asked_for_all_used_and_different(count):
    chosen = clustered(rainbow(3000), count)
    assert min(count, 2) <= len(set(chosen)) == len(chosen) <= count
    assert set(nearest(rainbow(3000), chosen)) == set(range(len(chosen)))


def test_few_colours_are_kept_exactly_the_commonest_first():
    colours = np.array([(1, 0, 0)] * 3 + [(0, 0, 1)] * 5 + [(0, 1, 0)] * 4, dtype=np.float32)
    assert clustered(colours, 3) == ("#0000FF", "#00FF00", "#FF0000")


def test_colours_out_of_range_are_clipped():
    assert clustered(np.array([(-1.0, 0.5, 2.0)]), 2) == ("#0080FF",)


def test_a_choice_stays_close_to_smooth_colours():
    """In Oklab the cube of colours has a volume of 0.053: 16 cells are 0.15 wide, and a point of a cube is 0.48 of that from the middle."""
    colours = rainbow(3000)
    chosen = clustered(colours, MOST)
    apart = oklab(srgb_to_linear(display(chosen)))[nearest(colours, chosen)] - oklab(srgb_to_linear(colours))
    assert np.sqrt((apart**2).sum(axis=1).mean()) < 0.48 * 0.15 * 1.25


def test_separate_hues_are_told_apart():
    middles = np.array([(0.9, 0.1, 0.1), (0.1, 0.9, 0.1), (0.1, 0.1, 0.9)])
    colours = np.repeat(middles, 200, axis=0) + np.random.default_rng(1).uniform(-0.1, 0.1, (600, 3))
    chosen = clustered(colours, 3)
    found = display(chosen)[nearest(colours, chosen)].reshape(3, 200, 3)
    assert np.abs(found - middles[:, None]).max() < 0.05


def test_the_same_colours_give_the_same_choice():
    assert clustered(rainbow(1000), 6) == clustered(rainbow(1000), 6)


def test_a_cluster_that_runs_empty_is_a_colour_less_and_no_warning(monkeypatch):
    """Rare, so the clustering stands in here; under pytest a warning would be an error."""

    def clusters(points, count, **_):
        warnings.warn("One of the clusters is empty.", stacklevel=1)
        return np.array([(0.2, 0, 0), (0.5, 0, 0), (1.0, 0, 0)]), np.full(len(points), 2)

    monkeypatch.setattr(module, "kmeans2", clusters)
    assert clustered(rainbow(100), 3) == ("#FFFFFF",)


def test_the_nearest_is_what_looks_alike_not_what_is_near_in_numbers():
    """A grey green is 0.38 from a loud green and 0.47 from a teal in RGB, but in Oklab 0.22 and 0.08."""
    grey_green, palette = np.array([(119, 153, 119)]) / 255.0, ("#66DD33", "#009977")
    assert np.linalg.norm(display(palette) - grey_green, axis=1).argmin() == 0
    assert nearest(grey_green, palette).tolist() == [1]


# --- islands ------------------------------------------------------------------------------------------------------


def spotted(sphere, radius):
    """A black sphere of radius 10 mm with a white cap of a radius [mm] around +z."""
    away = 10.0 * np.arccos(np.clip(sphere.vertices[:, 2] / 10.0, -1.0, 1.0))
    return Painted(sphere, BLACK_WHITE, (away <= radius).astype(np.int32))


def test_an_island_two_lines_wide_stays_and_a_narrower_one_goes(sphere):
    """Edges of 0.35 to 0.5 mm, so that a border is known to half of that."""
    spot = spotted(sphere, 1.0)
    assert merged(spot, LINE).merged == 0
    assert np.array_equal(merged(spot, LINE).filament, spot.filament)
    speck = spotted(sphere, 0.1)
    assert speck.filament.sum() == 1
    gone = merged(speck, LINE)
    assert (gone.merged, gone.filament.sum()) == (1, 0)
    assert merged(speck, 0.0).filament.sum() == 1


def test_a_long_narrow_stripe_is_no_more_to_be_printed_than_a_speck(sphere):
    stripe = Painted(sphere, BLACK_WHITE, (np.abs(sphere.vertices[:, 2]) < 0.05).astype(np.int32))
    assert stripe.filament.sum() > 50
    assert merged(stripe, LINE).filament.sum() == 0


def test_an_island_goes_to_the_nearest_colour_that_stays(sphere):
    x = sphere.vertices[:, 0]
    halves = np.where(x > 0.0, 1, 0)
    halves[np.argmax(x)] = 2
    whole = merged(Painted(sphere, ("#000000", "#FFFFFF", "#FF0000"), halves.astype(np.int32)), LINE)
    assert whole.filament[np.argmax(x)] == 1
    assert np.array_equal(whole.filament == 1, x > 0.0)


def test_noise_alone_is_left_as_it_is(sphere):
    noise = Painted(sphere, BLACK_WHITE, np.random.default_rng(0).integers(0, 2, len(sphere.vertices)).astype(np.int32))
    assert np.array_equal(merged(noise, 50.0).filament, noise.filament)


def test_a_surface_is_painted_by_its_nearest_filaments(sphere):
    grey = np.repeat((sphere.vertices[:, 2:] > 0.0).astype(np.float32) * 0.6 + 0.2, 3, axis=1)
    paint = painted(sphere.coloured(grey), BLACK_WHITE)
    assert np.array_equal(paint.filament, sphere.vertices[:, 2] > 0.0)
    assert painted(sphere, BLACK_WHITE).filament.max() == 0  # no colours: all of filament 1
    assert np.array_equal(paint.shown.colours[:, 0], paint.filament.astype(np.float32))


def test_bands_lie_one_above_the_other(sphere):
    bands = in_bands(sphere, ("#000000", "#777777", "#888888", "#FFFFFF"))
    z = sphere.vertices[:, 2]
    assert np.array_equal(bands.filament, np.digitize(z, [-5.0, 0.0, 5.0]))
