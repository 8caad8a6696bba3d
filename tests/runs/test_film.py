"""The film of a fall: every moment in one scale, stress only rises, legible without colour, and what cannot be compared is refused."""

from itertools import pairwise

import numpy as np
import pytest
from PIL import Image, ImageSequence

from mechstyle.errors import BadInput
from mechstyle.runs import film as module
from mechstyle.runs.film import FALLING, film
from mechstyle.simulation.impact import Impact
from support.lanes import lane_on_a_sheet


def landing(rest, greatest):
    """Twenty moments in which a sheet sinks and bulges; stress rises at one end up to the middle of them and falls again."""
    moved = [np.outer(np.sin(0.1 * rest[:, 0]), [0.0, 0.0, -0.5 * share]) for share in np.linspace(0.0, 1.0, 20)]
    course = np.r_[np.linspace(0.0, greatest, 10), np.linspace(greatest, 0.0, 10)]
    stress = np.outer(course, rest[:, 0] / rest[:, 0].max())
    return Impact(np.linspace(0.0, 0.4, 20), np.array(moved, np.float32), stress.astype(np.float32))


@pytest.fixture
def lane(tmp_path, monkeypatch):
    run = lane_on_a_sheet(tmp_path / "run", iterations=3)
    greatest = {True: 30.0, False: 90.0}  # plain, styled
    monkeypatch.setattr(module, "impact_of", lambda part, _r, moved, *_: landing(part.surface.vertices, greatest[not moved.any()]))
    return run


def pictures(path):
    with Image.open(path) as opened:
        return [np.asarray(one.convert("RGB")).astype(float) for one in ImageSequence.Iterator(opened)]


def test_it_falls_lands_and_ends_on_a_frame_that_stays_and_that_needs_no_colour(lane, tmp_path):
    path = film([lane], tmp_path / "fall.gif", frames=8, size=160)
    with Image.open(path) as opened:
        durations = [one.info["duration"] for one in ImageSequence.Iterator(opened)]
        assert opened.info["loop"] == 0
    assert len(durations) == FALLING + 8
    assert durations[-1] > 10 * durations[0]
    every = pictures(path)
    first, touch, last = every[0], every[FALLING], every[-1]
    assert np.abs(first - touch).mean() > 1.0
    assert np.abs(touch - last).mean() > 1.0
    grey = last @ [0.299, 0.587, 0.114]
    middle = grey[module.BAND : -module.BAR]
    plain, styled = np.array_split(middle, 2, axis=1)
    striped = [(np.abs(np.diff(half, axis=1)) > 40.0).sum() for half in (plain, styled)]
    assert striped[1] > striped[0] + 100  # stripes over what yields


def test_stress_is_the_largest_so_far(lane):
    scene = module._scenes(lane, plain=False, progress=lambda _: None)[0]
    seen = []

    def noted(_mesh, *, field, width, height, **_):
        seen.append(float(field.values.max()))
        return np.zeros((height, width, 3), np.uint8)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "render", noted)
        module._frames([scene], 45.6, 12, 160, lambda _: None)
    assert seen[:FALLING] == [0.0] * FALLING
    assert all(now <= later for now, later in pairwise(seen))
    assert seen[-1] == pytest.approx(90.0)


def test_what_cannot_be_compared_or_written_is_refused_in_one_sentence(lane, tmp_path):
    other = lane_on_a_sheet(tmp_path / "other", side=9, iterations=3)
    higher = lane_on_a_sheet(tmp_path / "higher", iterations=3, height=3000.0)
    for runs, name, words in (
        ([lane], "fall.mp4", "fall.gif instead"),
        ([lane, other], "fall.gif", "another part"),
        ([lane, higher], "fall.gif", "another fall"),
        ([lane] * 5, "fall.gif", "1 to 4 runs, not 5"),
        ([], "fall.gif", "1 to 4 runs, not 0"),
    ):
        with pytest.raises(BadInput, match=words):
            film(runs, tmp_path / name, frames=8, size=160)
    with pytest.raises(BadInput, match="not 3 of 160"):
        film([lane], tmp_path / "fall.gif", frames=3, size=160)
    assert not (tmp_path / "fall.gif").exists()
