"""A picture looked up at places and scales: what it shows there, how wide its light and dark are, whether its edges meet."""

import numpy as np
import pytest

from mechstyle.styling.drawing.raster import Raster

RNG = np.random.default_rng(0)


def stripes(period: int, size: int = 240) -> np.ndarray:
    return np.tile(np.where(np.arange(size) % period < period // 2, 255, 0).astype(np.uint8), (size, 1))[..., None]


def test_every_pixel_is_shown_where_it_lies_light_high_and_dark_low():
    pixels = RNG.integers(0, 256, (5, 7, 3)).astype(np.uint8)
    down, right = np.indices((5, 7)).reshape(2, -1)
    seen = Raster(pixels).at((right + 0.5) / 7 - 0.5, 0.5 - (down + 0.5) / 5, 0.0, repeated=True)
    assert np.allclose(seen.colour, pixels.reshape(-1, 3) / 255.0, atol=1e-3)
    grey = seen.colour @ [0.2126, 0.7152, 0.0722]
    assert np.allclose(seen.height, 2.0 * (grey - grey.min()) / np.ptp(grey) - 1.0, atol=1e-3)
    assert np.allclose(seen.cover, 1.0)


def test_tiles_follow_each_other_without_a_seam_and_a_single_picture_ends():
    raster = Raster(RNG.integers(0, 256, (16, 16, 1)).astype(np.uint8))
    u, v = RNG.uniform(-0.5, 0.5, (2, 200))
    one, other = (raster.at(u + shift, v - shift, 0.05, repeated=True) for shift in (0.0, 3.0))
    assert np.allclose(one.height, other.height, atol=1e-4)
    assert not raster.at(u + 2.0, v, 0.05, repeated=False).cover.any()
    assert np.allclose(raster.at(0.4 * u, 0.4 * v, 0.05, repeated=False).cover, 1.0, atol=1e-3)


def test_what_is_finer_than_a_place_is_averaged():
    raster = Raster(stripes(4))
    u = np.linspace(-0.5, 0.5, 400)
    assert np.ptp(raster.at(u, np.zeros(400), 0.0, repeated=True).height) > 1.9
    assert np.abs(raster.at(u, np.zeros(400), 0.05, repeated=True).height).max() < 0.02


@pytest.mark.parametrize("period", [16, 40, 80])
def test_the_width_of_its_detail_is_half_the_period_of_stripes(period):
    raster = Raster(stripes(period))
    assert raster.detail == pytest.approx(0.5 * period / 240, rel=0.1)
    assert raster.finest == pytest.approx(0.5 * period / 240, rel=0.6)
    assert raster.finest >= 0.4 * period / 240


def test_edges_that_do_not_meet_are_a_seam():
    slope = np.tile(np.linspace(0, 255, 64).astype(np.uint8), (64, 1))[..., None]
    wave = np.tile((127 + 127 * np.cos(2.0 * np.pi * np.arange(64) / 64)).astype(np.uint8), (64, 1))[..., None]
    assert Raster(slope).seam > 0.5
    assert Raster(wave).seam < 0.05
    assert Raster(stripes(40)).seam < 0.05, "an edge like those within is none"
