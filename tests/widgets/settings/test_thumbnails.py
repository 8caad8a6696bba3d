"""Pictures of models and styles: drawn once, kept, and hung up as they come."""

import asyncio
import io

import numpy as np
import pytest
from matplotlib.image import imread

from mechstyle.errors import BadInput
from mechstyle_widgets.jupyter.prepare import prepare_in_worker
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


def test_pictures_come_from_another_process_and_are_hung_up(empty_cache):
    async def cell() -> bytes:
        choice = PictureChoice("style", {"brick": "bricks"})
        hung = asyncio.Event()
        choice.observe(lambda _: hung.set(), "pictures")
        await asyncio.wait_for(hung.wait(), 60.0)
        return choice.pictures["brick"]

    assert asyncio.run(cell()).startswith(b"\x89PNG")


def test_giving_up_ends_the_other_process(sphere):
    class Enough(Exception):
        pass

    def give_up():
        raise Enough

    with pytest.raises(Enough):
        prepare_in_worker(sphere, 1000, lambda _: None, give_up)


def test_what_cannot_be_prepared_is_refused_in_its_own_words(sphere, empty_cache):
    with pytest.raises(BadInput, match="vertices is 3, but must be a whole number between"):
        prepare_in_worker(sphere, 3, lambda _: None, lambda: None)


def test_a_part_is_made_ready_and_the_stages_are_told(cube):
    stages = []
    part = prepare_in_worker(cube, 600, stages.append, lambda: None)
    assert np.allclose(part.surface.extents, 10.0, atol=0.1)
    assert stages[0] == "standardising the surface"
    assert len(stages) >= 3
