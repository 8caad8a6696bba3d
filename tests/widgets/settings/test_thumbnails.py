"""Pictures of models and styles: drawn once, kept, and hung up as they come."""

import asyncio
import io

import numpy as np
import pytest
from matplotlib.image import imread

from mechstyle.errors import BadInput
from mechstyle_widgets.jupyter.prepare import prepare_aside
from mechstyle_widgets.jupyter.worker_process import Aside
from mechstyle_widgets.settings import thumbnails
from mechstyle_widgets.settings.thumbnail_buttons import PictureChoice


@pytest.fixture
def empty_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("MECHSTYLE_CACHE", str(tmp_path / "cache"))


@pytest.mark.parametrize(("kind", "name"), [("model", "wall_hook"), ("style", "brick")])
def test_a_picture_shows_something_and_is_kept(empty_cache, kind, name):
    assert thumbnails.cached(kind, name) is None
    png = thumbnails.draw(kind, name)
    assert thumbnails.cached(kind, name) == png
    pixels = imread(io.BytesIO(png))[..., :3]
    assert pixels.std() > 0.05


def test_the_bricks_of_the_picture_are_red_and_lie_level():
    pixels = imread(io.BytesIO(thumbnails.style_picture("brick")))[..., :3]
    red, _, blue = pixels.mean(axis=(0, 1))
    assert red > 1.2 * blue
    rows, columns = pixels.mean(axis=(1, 2)), pixels.mean(axis=(0, 2))
    assert rows.std() > 2.0 * columns.std()  # joints run across


def test_pictures_come_from_another_process_and_are_hung_up(empty_cache):
    async def cell() -> bytes:
        choice = PictureChoice("style", {"brick": "bricks"})
        hung = asyncio.Event()
        choice.observe(lambda _: hung.set(), "pictures")
        await asyncio.wait_for(hung.wait(), 60.0)
        return choice.pictures["brick"]

    assert asyncio.run(cell()).startswith(b"\x89PNG")


def test_a_press_chooses_and_is_counted():
    choice = PictureChoice("style", {"brick": "bricks", "wood": "wood"})
    for name in ("wood", "wood", "nothing that is offered"):
        choice._handle_custom_msg({"kind": "press", "name": name}, [])
    assert (choice.value, choice.pressed) == ("wood", 2)


def test_the_page_is_told_the_pictures_it_shows_and_no_others(monkeypatch):
    monkeypatch.setattr(thumbnails, "cached", lambda _kind, name: name.encode())
    choice = PictureChoice("style", dict.fromkeys("abcdefgh", ""))
    assert set(choice.pictures) == set("abc")
    choice.value = "g"
    assert choice.few == ["g", "a", "b"]
    assert set(choice.pictures) == set("abcg")
    choice.all = True
    assert set(choice.pictures) == set("abcdefgh")


# --- work aside ---------------------------------------------------------------------------------------------------


def test_what_is_said_comes_in_order_and_then_it_ends(empty_cache):
    said = list(Aside(thumbnails._draw_all, "style", ["wood", "brick"]).said())
    assert [name for name, _ in said] == ["wood", "brick"]
    assert said[1][1] == thumbnails.cached("style", "brick")


def test_giving_up_ends_the_other_process(sphere):
    class Enough(Exception):
        pass

    def give_up():
        raise Enough

    with pytest.raises(Enough):
        prepare_aside(sphere, 1000, lambda _: None, give_up)


def test_what_cannot_be_prepared_is_refused_in_its_own_words(sphere, empty_cache):
    with pytest.raises(BadInput, match="vertices is 3, but must be a whole number between"):
        prepare_aside(sphere, 3, lambda _: None, lambda: None)


def test_a_part_is_made_ready_and_the_stages_are_told(cube):
    stages = []
    part = prepare_aside(cube, 600, stages.append, lambda: None)
    assert np.allclose(part.surface.extents, 10.0, atol=0.1)
    assert stages[0] == "standardising the surface"
    assert len(stages) >= 3
