"""When a drop ends: the second impact is found, a flat landing ends early, a soft one is followed, and neighbours agree."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mechstyle.fea import drop as module
from mechstyle.fea import explicit, phases
from mechstyle.fea.backends.cpu import CoreBody
from mechstyle.fea.backends.gpu import DeviceBody
from mechstyle.fea.discretisation import discretise
from mechstyle.fea.drop import DropTest, drop
from mechstyle.fea.elements import LINEAR, QUADRATIC
from mechstyle.fea.flight import RigidBody
from mechstyle.fea.linear_solvers import lowest_period
from mechstyle.fea.snapshots import snapshots
from mechstyle.records.material import LIBRARY
from mechstyle.records.mesh import TetMesh
from validation.meshes import lattice

SPEED = DropTest().speed


def tilt(angle):
    """A bar along x that lands with one end, the floor tilted by so many degrees."""
    turn = np.radians(angle)
    return [np.sin(turn), 0.05 * np.sin(turn), np.cos(turn)]


def read(part, dropped, number=0):
    """The stress that more than 64 mm³ of the part exceed in one landing [MPa]."""
    stress = dropped.von_mises[number]
    order, volumes = np.argsort(-stress, axis=None), np.repeat(part.volumes / stress.shape[1], stress.shape[1])
    return stress.ravel()[order][np.searchsorted(np.cumsum(volumes[order]), 64.0)]


@pytest.fixture(scope="module")
def bar(box):
    return box((15, 3, 1), (120.0, 20.0, 4.0))


@pytest.fixture(scope="module")
def period(bar, pla):
    return lowest_period(discretise(bar, pla, 0.01, QUADRATIC))


@pytest.fixture(scope="module")
def tilted(bar, pla, period):
    """The bar tilted by 34, 35 and 36 degrees, elastic."""
    return drop(bar, pla, [tilt(angle) for angle in (34.0, 35.0, 36.0)], DropTest(plastic=False), device="cpu", period=period)


def test_the_second_impact_comes_when_and_as_fast_as_in_a_long_window(bar, pla, tilted):
    body = discretise(bar, pla, 0.01, QUADRATIC)
    normals = np.array([tilt(35.0)]) / np.linalg.norm(tilt(35.0))
    (track,), scheme = module.tracks_for(body, pla, normals, DropTest(window=8.0, plastic=False))
    phases.follow(CoreBody(body), scheme, [track], lambda _: None)
    first, second = tilted.phases[1][:2]
    samples, times = track.samples[0], track.interval * np.arange(len(track.samples[0]))
    again = int(np.flatnonzero((np.diff(samples[:, phases.IMPULSE]) > 0.0) & (times[1:] > 0.5 * (first.end + second.start)))[0])
    assert second.start == pytest.approx(times[again], rel=0.02)
    rigid = RigidBody.of(body, scheme.gravity)
    motion = rigid.motion(samples[again])
    x, v = rigid.arms @ motion.rotation.T + motion.shift, rigid.velocities(motion) @ motion.rotation.T
    assert second.speed == pytest.approx(-(v @ normals[0])[(x @ normals[0]).argmin()], rel=0.02)
    assert second.speed > 1.5 * SPEED, "that end comes down faster than the first"


def test_the_second_impact_is_the_harder_one(bar, tilted):
    first = drop(bar, LIBRARY["PLA"], [tilt(35.0)], DropTest(window=tilted.phases[1][0].end, plastic=False), device="cpu")
    peaks = [read(bar, first), read(bar, tilted, 1)]
    assert peaks[1] > 1.3 * peaks[0]


def test_a_slow_touch_does_not_hide_the_slap_behind_it(pla):
    """The unsafe side: a foot grazed the floor at 0.4 of the first speed, there the drop ended, and the far end came down unseen."""
    block = lattice(np.linspace(0.0, 120.0, 31), np.linspace(0.0, 20.0, 6), np.array([0.0, 4.0, 8.0, 12.0]))
    x, y, z = block.vertices[block.tets].mean(axis=1).T
    gone = (z < 8.0) & ((np.abs(x - 50.0) > 2.0) | (np.abs(y - 10.0) > 2.0))
    used, corners = np.unique(block.tets[~gone], return_inverse=True)
    part = TetMesh(block.vertices[used], corners.reshape(-1, 4).astype(np.int32))
    found = drop(part, pla, [tilt(22.0)], DropTest(plastic=False), device="cpu")
    first, second = found.phases[0][:2]
    assert second.speed < phases.MIN_SPEED_RATIO * SPEED
    before = drop(part, pla, [tilt(22.0)], DropTest(window=first.end, plastic=False), device="cpu")
    peaks = [read(part, one) for one in (before, found)]
    assert peaks[1] > 1.25 * peaks[0]


def test_a_degree_of_tilt_does_not_draw_lots(bar, tilted):
    peaks = np.array([read(bar, tilted, number) for number in range(3)])
    assert peaks.std() < 0.04 * peaks.mean()
    speeds = np.array([each[1].speed for each in tilted.phases])
    assert speeds.std() < 0.04 * speeds.mean()


def test_the_history_goes_through_all_phases_and_leaves_out_the_flights(tilted):
    history, parts = tilted.history[1], tilted.phases[1]
    assert len(parts) >= 2
    for number, phase in enumerate(parts):
        here = history.phase == number
        assert (history.time[here][0], history.time[here][-1]) == pytest.approx((phase.start, phase.end))
        # Within a phase nothing but damping takes energy; that of central differences itself wavers by some 1e-4.
        left = history.damping_loss[here] - history.damping_loss[here][0]
        assert np.diff(left).min() > -1e-3 * history.kinetic[0]
    assert (np.diff(history.time) > 0.0).all()
    total = history.kinetic + history.strain + history.contact_loss + history.damping_loss - history.gravity_work
    np.testing.assert_allclose(total, total[0], rtol=1e-9)
    jumps = np.flatnonzero(np.diff(history.phase))
    assert (np.diff(history.damping_loss)[jumps] > 0.0).all(), "a flight takes what vibrated"
    np.testing.assert_allclose(np.diff(history.contact_loss)[jumps], 0.0, atol=1e-12)


def test_a_flight_keeps_the_momentum_that_rigid_motion_has(bar, pla, tilted):
    """Along the floor normal only the weight changes it."""
    history, mass = tilted.history[1], pla.density * bar.volumes.sum() * (1.0 + tilted.added_mass)
    jump = int(np.flatnonzero(np.diff(history.phase))[0])
    flown = history.time[jump + 1] - history.time[jump]
    assert history.momentum[jump + 1] - history.momentum[jump] == pytest.approx(-mass * module.GRAVITY * flown, rel=1e-3)
    before, after = history.gravity_work[[jump, jump + 1]]
    mean = 0.5 * (history.momentum[jump] + history.momentum[jump + 1]) / mass
    assert after - before == pytest.approx(-mass * module.GRAVITY * mean * flown, rel=1e-3)


def test_a_compact_part_that_lands_flat_is_done_soon(block, pla):
    period = lowest_period(discretise(block, pla, 0.01, QUADRATIC))
    result = drop(block, pla, [[0.0, 0.0, 1.0]], DropTest(plastic=False), device="cpu")
    assert result.endings == ("it leaves the floor, no next touch",)
    ((phase,),) = result.phases
    assert phase.end < 2.0 * period
    history = result.history[0]
    last = history.time[history.contact_force > 0.0].max()
    assert phase.end - last >= (phases.QUIET_TIME - 0.1) * period
    assert len(history.time) > 0.2 * result.steps
    (sooner,) = drop(block, pla, [[0.0, 0.0, 1.0]], device="cpu").phases[0]
    assert phases.CALM_TIME * period <= sooner.end - last < 0.5 * (phase.end - last), "a body that could yield is calm sooner"


def test_contact_that_lasts_is_followed_to_its_end(bar):
    """A soft bar on its end still presses on the floor when a stiff one is long gone."""
    soft = LIBRARY["TPU"]
    result = drop(bar, soft, [tilt(35.0)], DropTest(element="tet4"), device="cpu")
    period = lowest_period(discretise(bar, soft, 0.01, LINEAR))
    history, phase = result.history[0], result.phases[0][0]
    last = history.time[(history.contact_force > 0.0) & (history.phase == 0)].max()
    assert last > 1.5
    assert phase.end > last
    assert phase.end - last < (phases.QUIET_TIME + 0.1) * period


def test_drops_side_by_side_close_and_are_packed_without_changing_the_others(bar, pla, period, monkeypatch):
    """On a device all drops are one batch; on cores each is alone."""
    ways = [tilt(angle) for angle in (0.0, 35.0, 3.0, 2.0)]
    alone = drop(bar, pla, ways, DropTest(element="tet4"), device="cpu", period=period)
    monkeypatch.setattr(module, "body_on", lambda where, discretisation: DeviceBody(discretisation, where))
    side_by_side = drop(bar, pla, ways, DropTest(element="tet4"), device="cpu", period=period)
    assert side_by_side.endings == alone.endings
    assert len({len(each) for each in alone.phases}) > 1
    for one, other in zip(side_by_side.phases, alone.phases, strict=True):
        np.testing.assert_allclose([phase.start for phase in one], [phase.start for phase in other], rtol=1e-3, atol=1e-9)
        np.testing.assert_allclose([phase.speed for phase in one], [phase.speed for phase in other], rtol=1e-3)
    np.testing.assert_allclose(side_by_side.von_mises.max(axis=(1, 2)), alone.von_mises.max(axis=(1, 2)), rtol=0.02)
    for one, other in zip(side_by_side.history, alone.history, strict=True):
        np.testing.assert_allclose(one.contact_loss, other.contact_loss, atol=2e-3 * other.kinetic[0])
    assert (side_by_side.contact == alone.contact).mean() > 0.99


def test_the_same_input_gives_the_same_bytes_whatever_the_cores(bar, pla, period, monkeypatch):
    results = set()
    for count in (2, 1, 5):
        monkeypatch.setattr(explicit, "cores", lambda count=count: count)
        result = drop(bar, pla, [tilt(35.0), tilt(0.0)], DropTest(element="tet4"), device="cpu", period=period)
        results.add((result.von_mises.tobytes(), *(history.kinetic.tobytes() for history in result.history)))
    assert len(results) == 1


@pytest.mark.parametrize(
    ("limit", "value", "words"),
    [
        ("MOST_PHASES", 1, "comes after 1 phases, the most"),
        ("MIN_SPEED_RATIO", 3.0, "is slower than 3 of the first"),
        ("MOST_BESIDES", -12.0, "ms were simulated"),
    ],
)
def test_what_is_not_followed_is_said(limit, value, words, bar, pla, period, monkeypatch):
    monkeypatch.setattr(phases, limit, value)
    result = drop(bar, pla, [tilt(35.0)], DropTest(element="tet4"), device="cpu", period=period)
    assert words in result.endings[0]
    assert len(result.phases[0]) == 1


def test_a_window_that_is_given_is_all_there_is(bar, pla):
    result = drop(bar, pla, [tilt(35.0)], DropTest(window=0.5, element="tet4"), device="cpu")
    assert result.phases[0][0].end == pytest.approx(0.5)
    assert result.endings == ("the window of 0.5 ms was over",)


def test_the_player_sees_the_part_where_the_flight_has_brought_it(bar, pla, period):
    """As placed the flat bar lands once; stood on its edge by turning it, it comes down again, and lies on the floor then."""
    turn = np.radians(35.0)
    R = np.array([[np.cos(turn), 0.0, -np.sin(turn)], [0.0, 1.0, 0.0], [np.sin(turn), 0.0, np.cos(turn)]])
    stood = bar.moved(bar.vertices @ R.T)
    result = drop(stood, pla, [[0.0, 0.0, 1.0]], DropTest(element="tet4"), device="cpu", period=period)
    seen = snapshots(stood, pla, DropTest(element="tet4"), period=period)
    assert len(result.phases[0]) > 1
    floor = stood.vertices[:, 2].min()
    lowest = (stood.vertices[:, 2] + seen.displacement[:, :, 2]).min(axis=1)
    assert lowest.min() > floor - 0.1
    second = result.phases[0][1]
    there = seen.time > second.start
    assert there.any()
    assert seen.time[-1] == pytest.approx(result.phases[0][-1].end)
    at = int(np.flatnonzero(there)[0])
    moved = stood.vertices + seen.displacement[at]
    before, after = (points - points.mean(axis=0) for points in (stood.vertices, moved))
    assert np.abs(after - Rotation.align_vectors(after, before)[0].apply(before)).max() < 3.0, "turned and bent a little, no more"
    assert lowest[at] < floor + 1.0, "it touches again"
    np.testing.assert_allclose(seen.von_mises.max(axis=0), result.von_mises[0], rtol=1e-6)


def test_a_drop_that_breaks_down_in_a_phase_is_named_and_flies_no_further(bar, pla, period):
    test = DropTest(element="tet4", safety=1.3)
    result = drop(bar, pla, [tilt(35.0), tilt(0.0)], test, device="cpu", period=period)
    assert "unstable at" in result.failure
    assert np.isposinf(result.von_mises).all()
    assert replace(result, failure="").endings
