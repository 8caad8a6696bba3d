"""The drop test as a whole: conservation laws, the bar, and what it says when it cannot answer."""

import subprocess
import sys

import numpy as np
import pytest
import warp as wp
from scipy.spatial.transform import Rotation

from mechstyle.errors import BadInput, MissingPiece
from mechstyle.fea import drop as module
from mechstyle.fea import explicit
from mechstyle.fea.drop import GRAVITY, DropTest, available_devices, drop, resolve_device
from mechstyle.fea.elasticity import LAWS
from mechstyle.fea.elements import ELEMENTS
from mechstyle.fea.orientations import directions

UPRIGHT = [[0.0, 0.0, 1.0]]
SHORT = DropTest(window=0.05)
each_element = pytest.mark.parametrize("element", ELEMENTS)


@pytest.fixture(scope="module")
def bar(box):
    """A slender bar standing on end, 4 x 4 x 60 mm."""
    return box((2, 2, 30), (4.0, 4.0, 60.0))


@pytest.fixture(scope="module", params=ELEMENTS)
def dropped(block, pla, request):
    """The elastic block in three orientations, undamped: what the energy balance misses then is the integration's error."""
    test = DropTest(window=0.4, damping=0.0, element=request.param, plastic=False)
    return drop(block, pla, directions(3), test, device="cpu")


@pytest.mark.parametrize("law", LAWS)
@each_element
def test_a_bar_that_lands_on_its_end_carries_rho_c_v(bar, pla, element, law):
    test, c = DropTest(law=law, window=0.06, element=element, plastic=False), pla.bar_wave_speed
    (history,) = drop(bar, pla, UPRIGHT, test, device="cpu").history
    # The plateau lasts until the wave returns at 2L/c = 0.071 ms; the first tenth is the rise of the front.
    plateau = history.time > 0.1 * 2 * 60.0 / c
    stress = history.contact_force[plateau].mean() / 16.0
    assert stress == pytest.approx(pla.density * c * test.speed, rel=0.02)


@each_element
def test_the_stress_front_runs_up_the_bar_at_the_bar_wave_speed(bar, pla, element):
    c = pla.bar_wave_speed
    half = 0.5 * pla.density * c * DropTest().speed
    heights = bar.vertices[bar.tets].mean(axis=1)[:, 2]
    levels = np.unique(np.round(heights, 1))

    def front(window):
        peak = drop(bar, pla, UPRIGHT, DropTest(window=window, element=element), device="cpu").von_mises[0].mean(axis=1)
        mean = np.array([peak[np.abs(heights - level) < 0.06].mean() for level in levels])
        return np.interp(half, mean[::-1], levels[::-1])

    # Two windows: the shape of the front, which is smeared over some elements, drops out.
    assert (front(0.03) - front(0.015)) / 0.015 == pytest.approx(c, rel=0.03)


def test_energy_is_conserved_over_a_whole_drop(dropped):
    assert dropped.failure == ""
    for history in dropped.history:
        assert history.strain.max() > 0.1 * history.kinetic[0], "something must have been squeezed"
        # Measured: 3e-6. What remains is float32, and central differences conserving a linear body's energy only.
        assert np.abs(history.damping_loss).max() < 1e-3 * history.kinetic[0]


def test_the_named_energies_add_up_at_every_moment(block, pla):
    for history in drop(block, pla, directions(3), SHORT, device="cpu").history:
        kept = history.kinetic + history.strain + history.plastic_work
        total = kept + history.contact_loss + history.damping_loss - history.gravity_work
        np.testing.assert_allclose(total, total[0], rtol=1e-12)
        assert history.damping_loss[-1] > 0.0
        assert history.gravity_work[1] > 0.0, "weight works while the part still sinks"


def test_momentum_changes_by_the_impulse_of_floor_and_weight(dropped, block, pla):
    mass = pla.density * block.volumes.sum() * (1.0 + dropped.added_mass)
    for history in dropped.history:
        interval = history.time[1] - history.time[0]
        impulse = np.cumsum(history.contact_force) * interval - mass * GRAVITY * history.time
        np.testing.assert_allclose(history.momentum - history.momentum[0], impulse, atol=1e-4 * np.abs(history.momentum[0]))


def test_the_history_starts_at_first_touch_and_fills_the_window(dropped, block, pla):
    mass = pla.density * block.volumes.sum() * (1.0 + dropped.added_mass)
    speed = DropTest().speed
    assert speed == pytest.approx(np.sqrt(2 * 9.81e-3 * 1500.0))
    for history, phases in zip(dropped.history, dropped.phases, strict=True):
        np.testing.assert_allclose(history.kinetic[0], mass * speed**2 / 2, rtol=1e-9)
        np.testing.assert_allclose(history.momentum[0], -mass * speed, rtol=1e-9)
        assert history.time[0] == 0.0
        assert history.time[-1] == pytest.approx(0.4, rel=1e-12)
        assert [(phase.start, phase.speed) for phase in phases] == [(0.0, speed)]
        assert phases[0].end == history.time[-1]
        assert not history.phase.any()
    assert dropped.endings == ("the window of 0.4 ms was over",) * 3
    assert dropped.steps * dropped.time_step == pytest.approx(0.4, rel=1e-12)


def test_contact_and_friction_only_ever_take_energy(block, pla):
    for history in drop(block, pla, directions(3), DropTest(window=0.3, friction=0.3), device="cpu").history:
        # A vertex leaving the floor in mid-step may give a trace back: 1e-3 of what fell.
        assert np.diff(history.contact_loss).min() > -1e-3 * history.kinetic[0]
        assert history.contact_loss[-1] > 0.0
        assert np.diff(history.damping_loss).min() > -1e-3 * history.kinetic[0]
        assert history.damping_loss[-1] > 0.0


@pytest.mark.parametrize("stiffness", [30.0, 1000.0, 30000.0])
@each_element
def test_a_penalty_floor_gives_back_what_it_took_and_no_more(block, pla, element, stiffness):
    """The unsafe side of a step that is too long for the floor: it would add energy, or seem to take some that was never there."""
    test = DropTest(window=1.5, damping=0.0, element=element, plastic=False, contact_stiffness=stiffness)
    result = drop(block, pla, [*directions(3), [0.5, 0.2, 1.0]], test, device="cpu")
    assert result.failure == ""
    for history in result.history:
        held = history.contact_loss / history.kinetic[0]
        assert held.max() > 0.01, "it must have been pressed"
        assert held.min() > -0.01
        free = history.contact_force[-5:].max() == 0.0
        assert abs(held[-1]) < 0.02 or not free
        assert np.abs(history.damping_loss).max() < 1e-3 * history.kinetic[0]
        assert (history.kinetic + history.strain).max() < 1.01 * history.kinetic[0]


def test_the_stiffer_a_penalty_floor_the_nearer_it_comes_to_the_rigid_one(block, pla):
    def peak(stiffness):
        test = DropTest(window=0.3, plastic=False, element="tet4", contact_stiffness=stiffness)
        return drop(block, pla, directions(3)[2:], test, device="cpu").von_mises.max()

    soft, hard, harder, rigid = map(peak, (300.0, 3000.0, 1e5, 0.0))
    assert soft < hard < harder
    assert harder == pytest.approx(rigid, rel=0.1)


def test_friction_takes_energy_from_a_tilted_body(block, pla):
    tilted = directions(3)[1:2]
    smooth, rough = (drop(block, pla, tilted, DropTest(window=0.3, friction=mu), device="cpu").history[0] for mu in (0.0, 0.5))
    assert rough.contact_loss[-1] > 2.0 * smooth.contact_loss[-1]


def test_turning_body_and_floor_together_changes_nothing(block, pla):
    Q = Rotation.from_rotvec([0.3, 0.9, -0.4]).as_matrix()
    normal = np.array([0.2, 0.1, 1.0])
    straight = drop(block, pla, [normal], SHORT, device="cpu")
    turned = drop(block.moved(block.vertices @ Q.T), pla, [Q @ normal], SHORT, device="cpu")
    # The same in exact arithmetic; float32 and a bound of the frequency in other axes remain, amplified by contact.
    np.testing.assert_allclose(turned.von_mises, straight.von_mises, atol=0.02 * straight.von_mises.max())


def test_same_inputs_give_the_same_bytes_however_many_threads(block, pla, monkeypatch):
    results = []
    for count in (2, 2, 1, 5):
        monkeypatch.setattr(explicit, "cores", lambda count=count: count)
        result = drop(block, pla, directions(4), SHORT, device="cpu")
        results.append((result.von_mises.tobytes(), result.contact.tobytes(), *(each.kinetic.tobytes() for each in result.history)))
    assert len(set(results)) == 1


def test_an_orientation_gives_the_same_bytes_alone_and_in_company(block, pla):
    all_four = drop(block, pla, directions(4), SHORT, device="cpu")
    alone = drop(block, pla, directions(4)[2:3], SHORT, device="cpu")
    assert alone.von_mises[0].tobytes() == all_four.von_mises[2].tobytes()
    assert alone.contact[0].tobytes() == all_four.contact[2].tobytes()


def test_results_come_in_the_callers_numbering(block, pla):
    rng = np.random.default_rng(0)
    vertices, tets = rng.permutation(len(block.vertices)), rng.permutation(len(block.tets))
    number = np.argsort(vertices)
    shuffled = type(block)(block.vertices[vertices], number[block.tets[tets]])
    straight, mixed = drop(block, pla, UPRIGHT, SHORT, device="cpu"), drop(shuffled, pla, UPRIGHT, SHORT, device="cpu")
    np.testing.assert_allclose(mixed.von_mises[0], straight.von_mises[0][tets], atol=1e-2 * straight.von_mises.max())
    np.testing.assert_array_equal(mixed.contact[0], straight.contact[0][vertices])
    np.testing.assert_array_equal(straight.contact[0], block.vertices[:, 2] < 1e-9)


def test_mass_scaling_lengthens_the_step_within_its_limit(block, pla):
    squeezed = block.vertices.copy()
    inner = np.setdiff1d(np.arange(len(block.vertices)), block.boundary_faces)[0]
    around = block.tets[(block.tets == inner).any(axis=1)][0]
    squeezed[inner] += 0.98 * (squeezed[around[around != inner]].mean(axis=0) - squeezed[inner])
    sliver, tests = block.moved(squeezed), [DropTest(window=0.02, damping=0.0, added_mass=share) for share in (0.0, 0.005)]
    plain, scaled = (drop(sliver, pla, UPRIGHT, test, device="cpu") for test in tests)
    assert plain.added_mass == 0.0
    assert 0.0 < scaled.added_mass <= 0.005 * (1 + 1e-9)
    # In 288 tetrahedra a sliver's neighbours are a fair share of the mass; in real meshes the gain is 1.2 to 5 times.
    assert scaled.time_step > 1.15 * plain.time_step


@pytest.mark.parametrize("safety", [1.3, 2.0])
def test_a_step_beyond_the_stable_limit_is_named_and_gives_no_stress(block, pla, safety):
    result = drop(block, pla, directions(2), DropTest(safety=safety, element="tet4", window=1.5), device="cpu")
    assert "unstable" in result.failure or "no longer finite" in result.failure
    assert np.isposinf(result.von_mises).all()
    assert all(np.isfinite(values).all() for history in result.history for values in vars(history).values())
    assert result.history[0].time[-1] < 0.75, "it stops where it breaks"


def test_a_drop_that_would_take_hours_is_not_started_and_names_the_place(block, pla, monkeypatch):
    monkeypatch.setattr(module, "MAX_STEPS", 100)
    result = drop(block, pla, directions(2), device="cpu")
    assert f"would need {result.steps} steps" in result.failure
    assert "mm: mesh the part again" in result.failure
    assert np.isposinf(result.von_mises).all()
    assert [history.time.tolist() for history in result.history] == [[0.0], [0.0]]


def test_the_safe_step_is_stable_for_long(box, pla):
    result = drop(box((2, 2, 2), (10.0, 10.0, 10.0)), pla, directions(2), DropTest(window=5.0), device="cpu")
    assert result.failure == ""


def test_without_vector_code_the_plain_kernels_drop_it_and_say_so(block, pla, monkeypatch, caplog):
    expected = drop(block, pla, UPRIGHT, SHORT, device="cpu")

    def broken(discretisation):
        raise Exception("CPU kernel build failed with error code -1")  # noqa: TRY002 - what Warp raises

    monkeypatch.setattr(module, "CoreBody", broken)
    result = drop(block, pla, UPRIGHT, SHORT, device="cpu")
    np.testing.assert_allclose(result.von_mises, expected.von_mises, atol=1e-3 * expected.von_mises.max())
    assert "slower" in caplog.text


def test_progress_rises_to_one_and_can_cancel(block, pla):
    seen = []
    drop(block, pla, directions(2), SHORT, device="cpu", progress=seen.append)
    assert seen == sorted(seen)
    assert seen[-1] == 1.0
    assert len(seen) > 5

    def stop(fraction):
        if fraction > 0.3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        drop(block, pla, directions(2), SHORT, device="cpu", progress=stop)


def test_directions_start_upright_and_are_all_different():
    for count in (1, 2, 5, 13, 64):
        normals = directions(count)
        assert normals.shape == (count, 3)
        np.testing.assert_array_equal(normals[0], [0.0, 0.0, 1.0])
        np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, rtol=1e-12)
        tilt = np.degrees(np.arccos(np.clip(normals[1:] @ [0.0, 0.0, 1.0], -1.0, 1.0)))
        assert (tilt > 20.0).all(), "nearly upright is upright again"
        cosines = normals @ normals.T - 2.0 * np.eye(count)
        assert cosines.max() < np.cos(0.5 * np.sqrt(4.0 * np.pi / count)), "no two directions are near-duplicates"
    assert directions(13).tobytes() == directions(13).tobytes()


def test_devices_are_resolved_or_refused(capfd):
    assert resolve_device("cpu") == "cpu"
    assert resolve_device("auto") in {"cpu", "cuda:0"}
    with pytest.raises(BadInput, match="unknown device 'gpu'"):
        resolve_device("gpu")
    with pytest.raises(MissingPiece, match="cuda:99"):
        resolve_device("cuda:99")
    if not wp.get_cuda_device_count():
        with pytest.raises(MissingPiece, match="install an NVIDIA driver"):
            resolve_device("cuda")
        assert capfd.readouterr() == ("", ""), "Warp's own words for it"


def test_nothing_is_printed_to_standard_output():
    program = (
        "import numpy as np; from mechstyle.fea.drop import DropTest, drop; from mechstyle.records.material import LIBRARY;"
        "from mechstyle.records.mesh import TetMesh; tet = TetMesh(np.eye(4, 3, -1) * 5.0, [[0, 1, 2, 3]]);"
        "assert drop(tet, LIBRARY['PLA'], [[0, 0, 1]], DropTest(window=0.01), device='cpu').failure == ''"
    )
    outcome = subprocess.run([sys.executable, "-c", program], capture_output=True, check=True, timeout=300)
    assert outcome.stdout == b""


def test_the_cpu_is_always_there_and_every_device_named_can_be_used():
    devices = available_devices()
    assert devices[0] == "cpu"
    assert [resolve_device(device) for device in devices] == devices
