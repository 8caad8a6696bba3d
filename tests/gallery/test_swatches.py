"""The list of styles with its pictures."""

import io

import numpy as np
import pytest
from matplotlib.image import imread

import mechstyle as ms
from mechstyle.errors import BadInput
from mechstyle.gallery import swatches
from mechstyle.styling.library import names, style_named


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


def test_a_swatch_of_other_code_is_not_shown(cache, monkeypatch):
    monkeypatch.setattr(swatches, "_drawn", lambda _: b"old")
    assert swatches.swatch("marble") == b"old"
    monkeypatch.setattr(swatches, "_code", lambda: "changed since then")
    monkeypatch.setattr(swatches, "_drawn", lambda _: b"new")
    assert swatches.swatch("marble") == b"new"


def test_a_plate_stands_upright_with_up_in_the_picture_up():
    relief = style_named("stripes").program(swatches.Canvas(swatches._plate(), seed=0, size=swatches.PLATE_SIZE))
    columns = relief.height.reshape(swatches.PLATE_ROWS, swatches.PLATE_COLUMNS).mean(axis=0)
    rows = relief.height.reshape(swatches.PLATE_ROWS, swatches.PLATE_COLUMNS).mean(axis=1)
    assert rows.std() > 1.5 * columns.std()  # bands lie
    assert np.allclose(swatches._plate().face_normals, [0.0, -1.0, 0.0])


def test_an_unknown_style_has_no_swatch(cache):
    with pytest.raises(BadInput, match="'brick'"):
        swatches.swatch("bricks")
