"""The page with every style on a few parts."""

import io

import numpy as np
import pytest
from matplotlib.image import imread

from mechstyle.errors import BadInput
from mechstyle.gallery import style_sheet
from mechstyle.gallery.style_sheet import CELL, GAP, LINE, MARGIN, Specimen
from mechstyle.styling.prompt import Wish


@pytest.fixture(scope="module")
def sheet(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MECHSTYLE_CACHE", str(tmp_path_factory.mktemp("cache")))
        told: list[str] = []
        page = style_sheet.contact_sheet(
            styles=("marble", "weathered"), parts={"utensil_grip": {"length": 120.0}}, vertices=2000, columns=2, stage=told.append
        )
    return imread(io.BytesIO(page.png))[..., :3], told


def cell(pixels, column, picture):
    left = MARGIN + column * (2 * CELL + GAP) + picture * CELL
    return pixels[MARGIN + LINE : MARGIN + LINE + CELL, left : left + CELL]


def test_a_page_holds_every_style_coloured_and_grey(sheet):
    pixels, told = sheet
    assert told == ["preparing utensil_grip", "marble", "weathered"]
    assert pixels.shape[:2] == (CELL + LINE + 2 * MARGIN, 4 * CELL + GAP + 2 * MARGIN)
    for column in (0, 1):
        assert np.ptp(cell(pixels, column, 1), axis=2).max() < 0.05  # grey
        assert (np.ptp(cell(pixels, column, 1).mean(axis=2))) > 0.2  # and something to see
    assert np.ptp(cell(pixels, 1, 0), axis=2).max() > 0.3  # rust


def test_names_stand_above_the_pictures(sheet):
    pixels, _ = sheet
    line = pixels[MARGIN : MARGIN + LINE, MARGIN : MARGIN + 2 * CELL]
    assert line.min() < 0.3


def test_a_specimen_is_styled_within_its_walls(sphere):
    specimen = Specimen(sphere, np.full(len(sphere.vertices), 2.0))
    styled, notes = specimen.styled(Wish("stone"))
    moved = np.einsum("ij,ij->i", styled.vertices - sphere.vertices, sphere.vertex_normals)
    assert 0.0 < np.abs(moved).max() <= 2.0
    assert styled.colours is not None
    assert all(isinstance(note, str) for note in notes)


def test_unknown_names_are_refused_before_anything_is_drawn():
    with pytest.raises(BadInput, match="'brick'"):
        style_sheet.contact_sheet(styles=("bricks",))
