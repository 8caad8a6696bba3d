"""A run with a picture of the user's: it keeps the pixels, and needs neither the file nor the machine it was begun on."""

from __future__ import annotations

import shutil

import numpy as np
import pytest
from PIL import Image

from mechstyle.errors import BadInput, DamagedStore
from mechstyle.runs.images import digest_of, file_name, raster_of, remember
from mechstyle.runs.recipes import changed, recipe_for
from mechstyle.runs.report.reproduce import command_for
from mechstyle.runs.run import Run, stylize
from support.knob import knob

QUICK = {"iterations": 40, "orientations": 1, "nearly_flat": False, "window": 0.2, "element": "tet4", "schedule": "never",
         "base": "free", "device": "cpu"}  # fmt: skip
SIZE = 128
SHADES = np.add.outer(np.arange(SIZE), np.arange(SIZE)).astype(np.uint8)
STRIPED = np.dstack([np.tile(np.arange(SIZE) // 8 % 2 * 200, (SIZE, 1)), SHADES, SHADES]).astype(np.uint8)
"""Slow in green and blue, which a mesh can carry; fast in red, which it cannot."""


@pytest.fixture
def picture(tmp_path):
    path = tmp_path / "mine.png"
    Image.fromarray(SHADES).save(path)
    return path


@pytest.fixture(scope="module")
def elsewhere(tmp_path_factory) -> Run:
    """A run with a picture, opened in another folder by somebody who has neither the file nor a cache."""
    folder = tmp_path_factory.mktemp("images")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MECHSTYLE_CACHE", str(folder / "cache"))
        Image.fromarray(STRIPED).save(folder / "mine.png")
        stylize(knob(), image=folder / "mine.png", image_size=10, relief=0.5, out=folder / "run", **QUICK)
        (folder / "mine.png").unlink()
        shutil.rmtree(folder / "cache")
        patch.setenv("MECHSTYLE_CACHE", str(folder / "other"))
        yield Run.open((folder / "run").rename(folder / "moved"), "cpu")


def test_a_recipe_names_the_pixels_not_the_file(picture):
    recipe = recipe_for(image=picture)
    assert recipe.style.prompt == "picture"
    assert recipe.style.image == digest_of(SHADES) == digest_of(picture.read_bytes()) == digest_of(recipe.style.image)
    assert np.isclose(raster_of(recipe).aspect, 1.0)
    assert recipe_for("brick").style.image == ""
    assert changed(recipe, {"image": "", "prompt": "brick"}).style.image == ""


def test_the_run_shows_the_picture_and_keeps_it_as_a_file_for_people(elsewhere):
    state = elsewhere.checkpoint()
    assert np.ptp(state.displacement) > 0.1
    assert np.ptp(state.colour) > 0.2
    kept = elsewhere.store.root / file_name(elsewhere.recipe.style.image)
    assert digest_of(kept) == elsewhere.recipe.style.image
    assert "prompt read as picture" in elsewhere.summary.notes
    assert any(note.startswith("the picture is 10 mm wide") for note in elsewhere.summary.notes)


def test_it_is_branched_without_the_file(elsewhere):
    branch = elsewhere.branch(20, image_as="height", control="none").go()
    assert np.ptp(branch.checkpoint().colour) < np.ptp(elsewhere.checkpoint().colour)


def test_the_command_that_makes_it_again_names_that_file(elsewhere):
    command = command_for(Run(elsewhere.store), elsewhere.store.history("main"))
    assert f"--image {file_name(elsewhere.recipe.style.image)} " in command
    assert "--image-size 10.0" in command


def test_another_run_with_its_picture_can_be_asked_for_where_it_was_opened(elsewhere):
    remember(elsewhere.recipe, elsewhere.store)
    again = recipe_for(image=elsewhere.recipe.style.image, projection="around")
    assert raster_of(again).aspect == 1.0


@pytest.mark.parametrize(
    ("settings", "why"),
    [
        ({"prompt": "brick", "image": SHADES}, "names 'brick', but not the picture"),
        ({"prompt": "outside: picture"}, "give its file, with `--image`"),
        ({"prompt": " "}, "the prompt is empty"),
        ({"image": "gone.png"}, "gone.png does not exist"),
        ({"image": "f" * 64}, "missing or unreadable"),
        ({"image": 7}, "not int"),
        ({"image": SHADES, "image_size": 0.1}, "image size is 0.1"),
        ({"image": SHADES, "projection": "conical"}, "unknown projection 'conical'|projection"),
        ({"image": SHADES, "guidance": "clip"}, "draws no pictures"),
    ],
)
def test_what_cannot_be_is_refused_before_anything_is_done(settings, why):
    with pytest.raises((BadInput, DamagedStore), match=why):
        recipe_for(**settings)


@pytest.mark.parametrize(
    "forged", [np.zeros((4, 4, 9), np.uint8), np.zeros((4, 4), np.uint8), np.zeros((4, 4, 2), np.uint8), np.zeros((4, 9000, 1), np.uint8),
               np.zeros((4, 4, 3), np.uint16), np.zeros((4, 4, 1))]
)  # fmt: skip
def test_pixels_that_somebody_forged_are_refused(bench, forged):
    objects = bench.engine(bench.recipe()).store.objects
    recipe = bench.recipe(prompt="picture", image=objects.put_array(forged))
    with pytest.raises(DamagedStore, match="picture"):
        raster_of(recipe, objects)
