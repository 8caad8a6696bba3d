"""Impacts in a report: only those that were looked at, each moment to within half a step, and no more than there is room for."""

import gzip
import re

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mechstyle.records import sentences
from mechstyle.runs.report import replay_data as module
from mechstyle.runs.report.page import report_page
from mechstyle.runs.report.replay_data import MOMENTS, impact_data, impacts, moments
from mechstyle.simulation.impact import FALLING, Impact, heights, impact_key


@pytest.fixture
def lane(sheet):
    """A lane of its own: what is remembered in it is no other test's."""
    return sheet()


@pytest.fixture
def impact(lane):
    """Forty moments in which the sheet turns, sinks and bulges, with the peak at the eighth; last, the shape that stays."""
    rest = lane.surface().vertices
    moved = []
    for share in np.linspace(0.0, 1.0, 40):
        turned = rest @ Rotation.from_euler("x", 0.2 * share).as_matrix().T
        moved.append(turned + [0.0, 0.0, -3.0 * share] + 0.3 * share * np.sin(rest[:, :1]) * [0.0, 0.0, 1.0] - rest)
    stress = np.outer(np.r_[np.linspace(0.0, 50.0, 8), np.linspace(49.0, 5.0, 32)], np.linspace(0.2, 1.0, len(rest)))
    return Impact(np.linspace(0.0, 0.8, 40), np.array(moved, np.float32), stress.astype(np.float32))


@pytest.fixture
def seen(lane, impact):
    """The lane, with that impact remembered."""
    remember(lane, impact)
    return lane


def remember(lane, impact):
    simulation = lane.simulation()
    lane.store.memo.remember(impact_key(lane.recipe, simulation, simulation.flat.normal), impact)


def planes(played, name):
    """What the browser makes of a channel: the values of every frame, shape [frames, vertex_count * width]."""
    content, at, count = gzip.decompress(played.payload), 0, None
    total = sum(spec["planes"] * spec["width"] * spec["size"] for spec in played.header["channels"])
    count = len(content) // total
    for spec in played.header["channels"]:
        length = count * spec["width"]
        raw = np.frombuffer(content, np.uint8, spec["planes"] * 2 * length, at).reshape(spec["planes"], 2, length).astype(np.uint32)
        at += 2 * length * spec["planes"]
        if spec["name"] == name:
            whole = np.cumsum(raw[:, 0] + (raw[:, 1] << 8), axis=0, dtype=np.uint32).astype(np.uint16)
            return spec["low"] + spec["step"] * whole, spec["step"]
    raise AssertionError(name)


def test_every_moment_is_that_of_the_impact(seen, impact):
    played = impact_data(seen, seen.simulation(), seen.simulation().flat, impact)
    deformation, step = planes(played, "deformation")
    surface, frames = seen.surface(), moments(40, 7)
    for number, frame in enumerate(played.header["frames"][FALLING:], start=FALLING):
        turn = np.reshape(frame["turn"], (3, 3))
        shown = surface.vertices @ turn.T + frame["shift"] + 20.0 * deformation[number].reshape(-1, 3)
        assert np.abs(shown - impact.shape(surface, frames[number - FALLING], 20.0).vertices).max() <= 20.0 * 0.51 * step + 1e-6
    assert np.abs(played.header["frames"][-1]["shift"]).max() > 2.0


def test_it_comes_through_the_air_without_stress_and_undeformed(seen, impact):
    header = (played := impact_data(seen, seen.simulation(), seen.simulation().flat, impact)).header
    air, size = header["frames"][:FALLING], seen.part.surface.size
    assert [frame["above"] for frame in air] == heights(size, 1500.0).tolist()
    assert [frame["shift"][2] - header["frames"][FALLING]["shift"][2] for frame in air] == pytest.approx(heights(size, 1500.0).tolist())
    assert header["fall"] == "1.5 m"
    assert np.abs(planes(played, "moment")[0][:FALLING]).max() == 0.0


def test_no_stress_is_lost_between_the_moments_that_are_shown(seen, impact):
    played = impact_data(seen, seen.simulation(), seen.simulation().flat, impact)
    stress, step = planes(played, "moment")
    assert stress.max(axis=0) == pytest.approx(impact.stress.max(axis=0), abs=step)
    assert int(stress.max(axis=1).argmax()) == played.header["peak"]
    assert played.header["layers"][0]["threshold"] == seen.recipe.test.material.yield_strength


def test_it_ends_in_the_shape_that_stays_and_says_how_far_it_is_off(seen, impact):
    header = impact_data(seen, seen.simulation(), seen.simulation().flat, impact).header
    assert header["frames"][-1]["time"] == impact.time[impact.end]
    assert header["stays"] == sentences.bend(seen.simulation().flat.permanent_set)


@pytest.mark.parametrize(("count", "peak"), [(50, 0), (50, 1), (50, 49), (33, 20), (3, 1), (1, 0), (16, 5), (17, 16)])
def test_the_moments_hold_the_first_the_peak_and_the_last(count, peak):
    chosen = moments(count, peak)
    assert {0, peak, count - 1} <= set(chosen) <= set(range(count))
    assert len(chosen) == len(set(chosen)) <= MOMENTS
    assert len(chosen) >= min(count, MOMENTS - 1)


@pytest.mark.slow
def test_a_report_has_the_impacts_that_were_looked_at_and_no_others(lane, impact):
    assert "h-impact" not in report_page(lane)
    remember(lane, impact)
    page = report_page(lane)
    assert page.count('id="impact"') == 1
    assert re.findall(r'<option value="0">([^<]+)</option>', page) == ["flat"]


def test_what_there_is_no_room_for_is_left_out(seen, monkeypatch):
    assert len(impacts(seen)) == 1
    monkeypatch.setattr(module, "BUDGET", 10)
    assert impacts(seen) == []
