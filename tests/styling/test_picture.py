"""A picture drawn on parts: what is light stands out, what is transparent stays, and what cannot be printed is said."""

import numpy as np
import pytest

from mechstyle.records.material import LIBRARY
from mechstyle.records.recipe import Recipe
from mechstyle.styling.dimensions import Dimensions
from mechstyle.styling.drawing.colours import NEUTRAL
from mechstyle.styling.drawing.raster import Raster, pixels_of
from mechstyle.styling.drawn import canvas_for, target
from mechstyle.styling.prompt import read
from styling.conftest import boxed
from support import ROOT

ASKED = Recipe.of(prompt="picture", material=LIBRARY["PLA"], image="0" * 64, image_size=20.0, relief=0.6)


def disc(*, clear: bool, size: int = 80) -> Raster:
    """A red disc, light in its middle, on black or on nothing; it takes half of the picture's width."""
    y, x = np.indices((size, size)) / (size - 1) - 0.5
    light = np.clip(1.0 - np.hypot(x, y) / 0.25, 0.0, 1.0)
    inside = np.hypot(x, y) < 0.25
    colour = np.dstack([inside * (80.0 + 170.0 * light), 80.0 * light, 80.0 * light])
    return Raster(np.dstack([colour, 255.0 * inside] if clear else [colour]).astype(np.uint8))


@pytest.fixture(scope="module")
def block():
    """A box of 40 mm in steps of 1 mm."""
    return boxed((40, 40, 40), lambda *_: True, edge=1.0)


def drawn(mesh, raster, prompt="picture", **settings):
    recipe = ASKED.with_settings(prompt=prompt, **settings)
    wish = read(prompt, picture=True).wishes[0]
    wall = np.full(len(mesh.vertices), 8.0)
    canvas = canvas_for(recipe, wish, mesh, wall, raster)
    limit = np.full(len(mesh.vertices), 5.0)
    return target(mesh, wish, Dimensions.of(recipe, wish), seed=0, thickness=wall, inward=limit, outward=limit, canvas=canvas)


def front(mesh):
    """Vertices of the front, away from its edges, and their distance to the middle of the nearest disc [mm]."""
    x, y, z = mesh.vertices.T
    here = (y == 0.0) & (np.abs(x - 20.0) < 18.0) & (np.abs(z - 20.0) < 18.0)
    away = np.hypot(*(np.abs((value - 10.0) % 20.0 - 10.0)[here] for value in (x, z)))
    return here, away


def test_what_is_transparent_stays_as_it_is_and_the_rest_stands_on_it(block):
    aim = drawn(block, disc(clear=True))
    here, away = front(block)
    assert not aim.displacement[here][away > 7.0].any()
    assert np.allclose(aim.colour[here][away > 7.0], NEUTRAL)
    assert aim.displacement[here][away < 0.5] == pytest.approx(0.6, abs=0.1)
    assert np.all(aim.displacement[here][away < 4.0] > 0.15), "its dark border stands out as well"
    assert aim.colour[here][away < 0.5][:, 0].min() > 0.8


@pytest.mark.parametrize(("side", "low", "high"), [("outwards", 0.0, 0.6), ("inwards", -0.6, 0.0), ("both", -0.3, 0.3)])
@pytest.mark.parametrize("clear", [True, False])
def test_it_goes_to_the_side_it_is_told_and_is_as_deep(block, side, low, high, clear):
    relief = drawn(block, disc(clear=clear), side=side).displacement[front(block)[0]]
    mean = 0.0 if side != "both" or clear else 0.5 * float(relief.min() + relief.max())  # without gain or loss of volume
    assert low - 1e-5 <= relief.min() - mean <= relief.max() - mean <= high + 1e-5
    assert np.ptp(relief) > 0.35


def test_light_is_higher_than_dark_and_of_an_opaque_picture_dark_is_cut_in(block):
    here, away = front(block)
    relief = drawn(block, disc(clear=False)).displacement[here]
    assert relief[away > 7.0].max() < 0.0 < relief[away < 0.5].min()


def test_only_its_relief_or_only_its_colours(block):
    height, colour = (drawn(block, disc(clear=False), image_as=what) for what in ("height", "colour"))
    both = drawn(block, disc(clear=False))
    assert np.array_equal(height.displacement, both.displacement)
    assert np.allclose(height.colour, NEUTRAL)
    assert not colour.displacement.any()
    assert np.array_equal(colour.colour, both.colour)


def test_a_silhouette_stands_out_or_is_cut_in_as_a_whole(block):
    shape = np.zeros((40, 40, 4), np.uint8)
    shape[10:30, 10:30, 3] = 255
    here, away = front(block)
    for side, depth in (("auto", 0.6), ("outwards", 0.6), ("inwards", -0.6)):
        assert drawn(block, Raster(shape), side=side).displacement[here][away < 2.0] == pytest.approx(depth, abs=0.02)


def test_it_comes_once_where_it_is_placed_from_the_side_the_prompt_names(block):
    aim = drawn(block, disc(clear=True), "left: picture", projection="planar", image_layout="placed", image_size=20.0)
    x, y, z = block.vertices.T
    raised = aim.displacement > 0.1
    assert raised.any()
    assert np.all(x[raised] == 0.0)
    assert np.hypot(y - 20.0, z - 20.0)[raised].max() < 6.0


def test_a_prompt_colours_it_and_says_how_wide_it_is(block):
    gold = drawn(block, disc(clear=True), "gold", image_as="height").colour
    assert np.ptp(gold, axis=0).max() < 1e-6
    assert gold[0, 0] > gold[0, 1] > gold[0, 2]
    notes = drawn(block, disc(clear=True), "12 mm picture", image_size=None).notes
    assert any(note.startswith("the picture is 12 mm wide") for note in notes)


def test_what_is_finer_than_the_nozzle_or_the_mesh_is_said_with_its_figure(block):
    page = np.full((200, 200, 1), 255, np.uint8)
    page[:, ::10] = page[:, 1::10] = 0  # lines of a hundredth of the width
    notes = " ".join(drawn(block, Raster(page)).notes)
    assert "details of the picture of 0.2 mm are finer than a nozzle of 0.4 mm prints: they come out from a width of 40 mm on" in notes
    assert "the mesh (edge 1.1 mm) is too coarse" in notes
    assert "nozzle" not in " ".join(drawn(block, Raster(page), image_size=60.0).notes)
    assert "nozzle" not in " ".join(drawn(block, Raster(page), image_as="colour").notes)


def test_a_picture_of_one_shade_and_one_that_cannot_be_tiled_are_told_of(block):
    assert "no relief" in " ".join(drawn(block, Raster(np.full((9, 9, 1), 99, np.uint8))).notes)
    slope = Raster(np.tile(np.linspace(0, 255, 64).astype(np.uint8), (64, 1))[..., None])
    assert "show seams" in " ".join(drawn(block, slope).notes)
    assert "show seams" not in " ".join(drawn(block, slope, image_layout="placed").notes)


def test_the_example_of_the_page_on_pictures_is_a_leaf(block, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    page = (ROOT / "docs" / "prompts.md").read_text()
    exec(compile(page.partition("```python\n")[2].partition("```")[0], "prompts.md", "exec"), {})
    aim = drawn(block, Raster(pixels_of("leaf.png")), image_size=40.0)
    here, _ = front(block)
    assert any("are finer than a nozzle" in note for note in aim.notes) is (40.0 * Raster(pixels_of("leaf.png")).finest < 0.4)
    assert np.ptp(aim.displacement[here]) == pytest.approx(0.6, abs=0.15)
    green = aim.colour[here][aim.displacement[here] > 0.3]
    assert np.all(green.argmax(axis=1) == 1)
