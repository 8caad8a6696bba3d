"""The film of a fall: every moment in one scale, stress only rises, legible without colour, and what cannot be compared is refused."""

from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image, ImageSequence

from mechstyle.errors import BadInput
from mechstyle.records import sentences
from mechstyle.runs import film as module
from mechstyle.runs.film import FALLING, film
from mechstyle.simulation.impact import Impact
from support.bench import Bench
from support.lanes import lane_on_a_sheet


def landing(rest, greatest):
    """Twenty moments in which a sheet sinks and bulges; stress rises at one end up to the middle of them and falls again; it stays bent."""
    moved = [np.outer(np.sin(0.1 * rest[:, 0]), [0.0, 0.0, -0.5 * share]) for share in np.linspace(0.0, 1.0, 20)]
    course = np.r_[np.linspace(0.0, greatest, 10), np.linspace(greatest, 0.0, 10)]
    stress = np.outer(course, rest[:, 0] / rest[:, 0].max())
    return Impact(np.linspace(0.0, 0.42, 21), np.array([*moved, moved[5]], np.float32), np.array([*stress, stress.max(axis=0)], np.float32))


@pytest.fixture
def lane(tmp_path, monkeypatch):
    run = lane_on_a_sheet(tmp_path / "run", iterations=3)
    greatest = {True: 30.0, False: 90.0}  # plain, styled
    bench = Bench(run.store.root).engine(run.recipe).simulator
    simulator = SimpleNamespace(part=run.part, baseline=bench.baseline)
    monkeypatch.setattr(type(run), "simulator", lambda *_: simulator)
    rest = run.part.surface.vertices
    monkeypatch.setattr(module, "impact_of", lambda _, simulation, *__: landing(rest, greatest[not simulation.displacement.any()]))
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
    assert striped[1] > striped[0] + 50  # stripes over what yields


def test_it_ends_in_the_shape_that_stays_and_says_how_far_it_is_off(lane, monkeypatch):
    """It ended somewhere in the ringing, over a height that no caliper reads."""
    scenes, shapes = module._scenes(lane, plain=True, progress=lambda _: None), []
    assert scenes[0].ending == f"{sentences.bend(lane.simulation(0).flat.permanent_set)} stays bent"
    assert scenes[1].ending == f"{sentences.bend(lane.simulation().flat.permanent_set)} stays bent"
    monkeypatch.setattr(module, "render", lambda mesh, *, width, height, **_: shapes.append(mesh) or np.zeros((height, width, 3), np.uint8))
    module._frames(scenes[1:], 45.6, 12, 160, lambda _: None)
    impact, surface = scenes[1].impact, scenes[1].surface
    shown, kept = shapes[-1].vertices - surface.vertices, impact.shape(surface, impact.end).vertices - surface.vertices
    assert np.abs(shown).max() >= np.abs(kept).max()
    assert np.abs(shapes[-1].vertices - shapes[-2].vertices).max() > 1e-3


def test_a_crack_is_named_after_the_millimetres(lane, monkeypatch):
    """It ended with «0.53 mm, cracks stays bent»."""
    monkeypatch.setattr(module.sentences, "found", lambda _: "0.53 mm, cracks")
    assert module._scenes(lane, plain=False, progress=lambda _: None)[0].ending == "0.53 mm stays bent, cracks"


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
