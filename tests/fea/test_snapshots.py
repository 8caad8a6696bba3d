"""A drop looked at on its way is the drop itself."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from mechstyle.fea.drop import DropTest, drop
from mechstyle.fea.snapshots import snapshots

TEST = DropTest(window=0.2)


@pytest.fixture(scope="module")
def seen(block, pla):
    return snapshots(block, pla, TEST, frames=30)


def test_the_greatest_stress_over_all_frames_is_that_of_the_drop(block, pla, seen):
    whole = drop(block, pla, [[0.0, 0.0, 1.0]], TEST, device="cpu")
    assert np.array_equal(seen.von_mises.max(axis=0), whole.von_mises[0])


def test_it_begins_at_first_touch_and_ends_with_the_window(seen):
    assert seen.time[0] == 0.0
    assert seen.time[-1] == pytest.approx(TEST.window)
    assert np.all(np.diff(seen.time) > 0)
    assert not seen.displacement[0].any()
    assert not seen.von_mises[0].any()


def test_nothing_goes_through_the_floor_and_the_top_falls_freely_at_first(block, pla, seen):
    """Until the wave arrives the top moves at the speed of the fall."""
    heights = block.vertices[:, 2] - block.vertices[:, 2].min()
    assert (heights + seen.displacement[:, :, 2]).min() > -1e-4
    seen = snapshots(block, pla, DropTest(window=0.012))
    top = int(heights.argmax())
    arrival = heights[top] / (1.3 * np.sqrt(3500.0 / 1.24e-3))  # the fastest wave in PLA
    early = seen.time < arrival
    assert early.sum() >= 2
    assert np.allclose(seen.displacement[early, top, 2], -TEST.speed * seen.time[early], rtol=0.01, atol=1e-4)


def test_the_fraction_done_rises_to_one_and_may_cancel(block, pla):
    told = []
    snapshots(block, pla, DropTest(window=0.01), frames=5, progress=told.append)
    assert told == sorted(told)
    assert told[-1] == 1.0

    def stop(_fraction):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        snapshots(block, pla, DropTest(window=0.01), frames=5, progress=stop)


@pytest.mark.parametrize("frames", [4, 7, 8, 11])
def test_of_many_moments_as_many_are_kept_as_were_asked_for_and_no_stress_is_lost(frames, block, pla, seen):
    few = snapshots(block, pla, TEST, frames=frames)
    assert frames / 2 < len(few.time) <= frames
    assert set(few.time) <= set(seen.time)
    assert few.time[-1] == seen.time[-1]
    assert np.array_equal(few.von_mises.max(axis=0), seen.von_mises.max(axis=0))
    for frame, (before, now) in enumerate(itertools.pairwise(few.time), start=1):
        between = (seen.time > before) & (seen.time <= now)
        assert np.array_equal(few.von_mises[frame], seen.von_mises[between].max(axis=0))
        assert np.array_equal(few.displacement[frame], seen.displacement[np.flatnonzero(between)[-1]])
