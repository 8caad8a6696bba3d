"""From the sums of the kernels to energies and forces: over several phases, and where they stop being numbers."""

from types import SimpleNamespace

import numpy as np
import pytest

from mechstyle.fea.drop import history_of, phases_of
from mechstyle.fea.explicit import QUANTITIES

DT, STRIDE, GRAVITY = 0.01, 4, 0.5
SCHEME = SimpleNamespace(time_step=DT, stride=STRIDE, gravity=GRAVITY, across=(0.0, 0.0, 0.0))


def samples(count, **columns):
    """Rows of a phase, quantities not named at nothing."""
    rows = np.zeros((count, len(QUANTITIES)))
    for name, values in columns.items():
        rows[:, QUANTITIES.index(name)] = values
    return rows


@pytest.fixture
def track():
    """Two phases of three and two samples with a flight between them."""
    first = samples(3, kinetic=[10.0, 6.0, 6.0], strain=[0.0, 3.0, 1.0], plastic_work=[0.0, 0.0, 1.0], impulse=[0.0, 2.0, 3.0],
                    contact_loss=[0.0, 0.5, 1.0], height=[0.0, -1.0, -2.0], momentum=[-4.0, -2.0, -1.0],
                    peak_squared=[0.0, 4.0, 9.0])  # fmt: skip
    second = samples(2, kinetic=[6.0, 4.0], strain=[0.0, 1.0], plastic_work=[1.0, 1.0], impulse=[0.0, 1.0],
                     contact_loss=[0.0, 0.25], peak_squared=[0.0, 16.0])  # fmt: skip
    return SimpleNamespace(samples=[first, second], begun=[0.0, 1.0], sunk=[0.0, -3.0], speeds=[5.0, 2.0], normals=[(0, 0, 1), (0, 1, 0)])


def test_time_goes_on_over_a_flight_and_every_sample_knows_its_phase(track):
    history = history_of(track, SCHEME)
    np.testing.assert_allclose(history.time, [0.0, 0.04, 0.08, 1.0, 1.04])
    assert history.phase.tolist() == [0, 0, 0, 1, 1]


def test_what_the_floor_took_is_carried_over_and_its_force_is_not(track):
    history = history_of(track, SCHEME)
    np.testing.assert_allclose(history.contact_loss, [0.0, 0.5, 1.0, 1.0, 1.25])
    np.testing.assert_allclose(history.contact_force, np.array([0.0, 2.0, 1.0, 0.0, 1.0]) / (STRIDE * DT))


def test_what_is_missing_of_the_energy_at_first_touch_is_the_loss_by_damping(track):
    history = history_of(track, SCHEME)
    np.testing.assert_allclose(history.gravity_work, [0.0, 0.5, 1.0, 1.5, 1.5], err_msg="the flight sank it by three more")
    kept = history.kinetic + history.strain + history.plastic_work
    total = kept + history.contact_loss + history.damping_loss - history.gravity_work
    np.testing.assert_allclose(total, 10.0)
    assert history.damping_loss[1] == pytest.approx(10.0 - (6.0 + 3.0 + 0.5 - 0.5))
    np.testing.assert_allclose(history.peak_stress, [0.0, 2.0, 3.0, 0.0, 4.0])


@pytest.mark.parametrize("wrong", [np.nan, np.inf])
def test_a_phase_ends_where_it_is_no_number_any_more(track, wrong):
    track.samples[1][1, QUANTITIES.index("strain")] = wrong
    history = history_of(track, SCHEME)
    assert history.time.tolist() == pytest.approx([0.0, 0.04, 0.08, 1.0])
    assert all(np.isfinite(values).all() for values in vars(history).values())


def test_phases_say_when_how_fast_and_onto_what(track):
    first, second = phases_of(track, SCHEME)
    assert (first.start, first.end, first.speed, first.normal) == (0.0, pytest.approx(0.08), 5.0, (0.0, 0.0, 1.0))
    assert (second.start, second.end, second.speed, second.normal) == (1.0, pytest.approx(1.04), 2.0, (0.0, 1.0, 0.0))
