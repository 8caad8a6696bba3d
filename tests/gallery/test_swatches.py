"""The list of styles with its pictures."""

import io

import numpy as np
import pytest
from matplotlib.image import imread

import mechstyle as ms
from mechstyle.errors import BadInput
from mechstyle.gallery import swatches
from mechstyle.styling.library import names
from mechstyle.styling.style import Relief, Style


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("MECHSTYLE_CACHE", str(tmp_path))
    return tmp_path / "pictures"


def test_all_styles_are_listed_in_words():
    known = ms.styles()
    assert [style.name for style in known] == list(names())
    assert len(known) == len(names())
    lines = repr(known).splitlines()
    assert [line.split()[0] for line in lines] == list(names())


def test_a_notebook_shows_a_picture_for_every_style_offline(cache, monkeypatch):
    monkeypatch.setattr(swatches, "_drawn", lambda style: style.name.encode())
    shown = ms.styles()._repr_html_()
    assert shown.count("data:image/png;base64,") == len(names())
    assert "http" not in shown
    assert all(f'alt="{name}"' in shown for name in names())


def test_a_swatch_is_drawn_once_and_kept(cache, monkeypatch):
    png = swatches.swatch("marble")
    pixels = imread(io.BytesIO(png))[..., :3]
    assert pixels.shape[:2] == (swatches.PLATE_ROWS, swatches.PLATE_COLUMNS)
    assert pixels.std() > 0.05
    monkeypatch.setattr(swatches, "_drawn", lambda _: pytest.fail("drawn again"))
    assert swatches.swatch("marble") == png


def test_an_unknown_style_has_no_swatch(cache):
    with pytest.raises(BadInput, match="'brick'"):
        swatches.swatch("bricks")


def brightness(to_the_right, upwards):
    """Of a grey plate that rises so much to the right and upwards, over that of its colour."""
    z, x = (swatches.PLATE_STEP * grid.ravel() for grid in np.mgrid[: swatches.PLATE_ROWS, : swatches.PLATE_COLUMNS])
    relief = Relief((to_the_right * x + upwards * z) / swatches.PLATE_HEIGHT, np.full((x.size, 3), 0.4))
    drawn = swatches._drawn(Style("slope", "A slope.", 1.0, lambda _canvas: relief))
    return imread(io.BytesIO(drawn))[..., :3].mean() / 0.4


def test_a_groove_is_seen_by_its_sides_as_light_comes_from_the_upper_left():
    """Sides of 17° are told apart at a glance: one is more than one and a half times as bright as the other, and neither is white."""
    assert brightness(0.0, 0.0) == pytest.approx(1.0, abs=0.01)
    for left, right in (((0.3, 0.0), (-0.3, 0.0)), ((0.0, -0.3), (0.0, 0.3))):
        assert 1.6 < brightness(*left) / brightness(*right) < 1.9
        assert brightness(*left) < 1.3
