"""What a page holds to draw iterations by itself: packed off the kernel's thread, and no more of it used than is still the lane's."""

from __future__ import annotations

import asyncio

import pytest

from mechstyle.runs.report.replay_data import replay_data
from mechstyle_widgets.replay.scrubber import Cache, Packer, Scrubber, digests_of, served
from mechstyle_widgets.state.studio_state import StudioState
from mechstyle_widgets.timeline.timeline import Timeline
from mechstyle_widgets.viewer.run_viewer import RunViewer
from support.lanes import carry_on, lane_on_a_sheet


@pytest.fixture
def run(tmp_path):
    return lane_on_a_sheet(tmp_path / "run", iterations=12, every=4)


@pytest.fixture
def state(run):
    return StudioState(run)


def packed(state):
    return Cache(replay_data(state.run), dict(enumerate(digests_of(state))))


async def next_of(found):
    return await asyncio.wait_for(found.get(), 30)


def test_a_lane_at_rest_is_packed(run):
    async def act():
        found = asyncio.Queue()
        packer = Packer(StudioState(run), found.put_nowait)
        cache = await next_of(found)
        packer.close()
        return cache

    cache = asyncio.run(act())
    assert cache._payload == replay_data(run).payload
    assert len(cache.digests) == 13


def test_while_a_run_goes_on_it_is_packed_now_and_then_and_once_it_rests(run):
    async def act():
        state, found = StudioState(run), asyncio.Queue()
        packer = Packer(state, found.put_nowait)
        await next_of(found)
        whole = state.history
        state.status, state.history = "running", whole[:11]
        packer._digests = tuple(row.digest for row in whole[:11])
        state.histories, state.history = {}, whole
        assert not packer._busy, "two iterations more are not worth it"
        state.status = "finished"
        assert packer._busy
        await next_of(found)
        packer.close()

    asyncio.run(act())


def test_what_is_served_are_the_iterations_that_are_still_the_lanes(state):
    cache = packed(state)
    assert served(cache, state) == list(range(13))
    branch = state.run.branch(6, lane="soft", threshold=0.5)
    carry_on(branch)
    state.open(branch)
    assert served(cache, state) == list(range(7)), "up to the fork a branch is its parent"
    assert served(None, state) == []


def test_a_scrubber_takes_a_newer_cache_and_closes_the_older(state):
    scrubber = Scrubber(state)
    first, second = packed(state), packed(state)
    scrubber._take(first)
    assert scrubber._served == list(range(13))
    scrubber._take(second)
    assert (first.comm, second.comm is None) == (None, False)
    state.status = "running"
    assert scrubber._live, "while a run goes on the kernel is asked at every step"
    scrubber.close()
    assert second.comm is None


def test_a_view_lends_its_buffers_for_what_a_page_holds(state):
    state.layer = "stress"
    viewer, timeline = RunViewer(state), Timeline(state)
    timeline.scrubber.serve(viewer)
    page = timeline.scrubber._page
    assert (page["layer"], page["drawn"], page["view"]) == ("stress", 12, viewer._views[0].model_id)
    assert page["buffers"]["position"] == viewer._scenes[0]._vertices.model_id
    state.iteration = 3
    assert timeline.scrubber._page["drawn"] == 3
    viewer.layer = "thickness"
    assert timeline.scrubber._page == {}, "a page does not hold it for every iteration"
    timeline.scrubber.serve(None)
    viewer.layer = "style"
    assert timeline.scrubber._page == {}
    timeline.close()
    viewer.close()
