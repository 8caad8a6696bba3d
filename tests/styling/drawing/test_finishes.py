"""Metals on any style: told from paints, shaded as they are, darker in their hollows and brighter on their crests."""

import numpy as np
import pytest

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import FINISHES, finish_of, luminance, recoloured, rgb, shaded
from mechstyle.styling.vocabulary import COLOURS, SHADES

METALS = ("gold", "copper", "bronze", "brass", "rose_gold", "silver", "chrome", "platinum", "gunmetal", "rust")


@pytest.mark.parametrize("shade", [1.0, *SHADES.values()])
def test_every_metal_is_known_in_every_shade_and_no_paint_is_one(shade):
    for word, code in COLOURS.items():
        found = finish_of(shaded(rgb(code), shade))
        assert (found is not None) == (code in FINISHES), word
        if found is not None:
            assert found[0] is FINISHES[code]
            assert found[1] == pytest.approx(shade)
    assert {COLOURS[word] for word in METALS} == set(FINISHES)
    assert finish_of(None) is None


@pytest.mark.parametrize("word", METALS)
def test_a_metal_has_more_contrast_than_a_paint_and_its_own_colour_between(sphere, word):
    colour = rgb(COLOURS[word])
    light = np.repeat(0.5 + 0.03 * sphere.vertices[:, 2:], 3, axis=1)
    painted = Canvas(sphere, seed=0, colour=tuple(colour)).painted(light)
    assert painted.min() >= 0.0
    assert painted.max() <= 1.0
    plain = recoloured(light, colour)
    assert np.ptp(luminance(painted)) > np.ptp(luminance(plain))
    middle = np.abs(sphere.vertices[:, 2]) < 0.3
    assert np.allclose(painted[middle].mean(axis=0), colour, atol=0.06)


def test_rust_is_mottled_and_decided_by_the_seed(sphere):
    rust = tuple(rgb(COLOURS["rust"]))
    even = np.full(sphere.vertices.shape, 0.5)
    one, again, other = (Canvas(sphere, seed, colour=rust).painted(even) for seed in (0, 0, 1))
    assert one.tobytes() == again.tobytes()
    assert luminance(one).std() > 0.02
    assert not np.array_equal(one, other)
    gold = Canvas(sphere, seed=0, colour=tuple(rgb(COLOURS["gold"]))).painted(even)
    assert np.ptp(gold, axis=0).max() < 1e-12
