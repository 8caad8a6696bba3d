"""The loop over batches with batches that misbehave."""

import os

import numpy as np
import pytest

from mechstyle.fea.elasticity import StVenantKirchhoff
from mechstyle.fea.explicit import QUANTITIES, Scheme, failing, integrate

SCHEME = Scheme(StVenantKirchhoff(1.0, 1.0), 1e-3, np.zeros(1), 9.81e-3, 0.0, speed=2.0, stride=4, samples=10)
ENERGY = 2.0


class Recorded:
    """A batch of one that plays back samples."""

    def __init__(self, samples):
        self.samples, self.taken = samples, 0

    def advance(self, samples):
        self.taken += samples

    def history(self, samples):
        return self.samples[:samples]


def falling(kinetic=ENERGY, count=10):
    samples = np.zeros((count, len(QUANTITIES), 1))
    samples[:, QUANTITIES.index("kinetic")] = kinetic
    return samples


def test_all_batches_run_to_the_end():
    batches, fractions = [Recorded(falling(1.0 + 0.1 * index)) for index in range(5)], []
    samples = integrate(batches, SCHEME, ENERGY, fractions.append)
    np.testing.assert_array_equal(samples, np.concatenate([batch.samples for batch in batches], axis=2))
    assert [batch.taken for batch in batches] == [10] * 5
    assert fractions[-1] == 1.0


@pytest.mark.parametrize("value", [np.nan, np.inf, 3.0])
def test_a_batch_that_breaks_down_stops_and_the_others_go_on(value):
    broken = falling()
    broken[3:, QUANTITIES.index("kinetic")] = value
    batches = [Recorded(falling()), Recorded(broken)]
    samples = integrate(batches, SCHEME, ENERGY, lambda _: None)
    assert [batch.taken for batch in batches] == [10, 4]
    bad = failing(samples, SCHEME, ENERGY)
    assert not bad[:, 0].any()
    np.testing.assert_array_equal(bad[:, 1], [False, False, False, True])


def test_energy_that_damping_took_does_not_hide_energy_gained():
    damped = falling()
    damped[:, QUANTITIES.index("kinetic"), 0] = ENERGY * np.array([0.9, 0.7, 0.5, 0.5, 0.505, 0.52, 0.52, 0.52, 0.4, 0.4])
    bad = failing(damped, SCHEME, ENERGY)[:, 0]
    np.testing.assert_array_equal(bad, [False] * 5 + [True] * 3 + [False] * 2)


def test_opposite_infinities_are_a_failure_not_a_warning():
    broken = falling()
    broken[0, QUANTITIES.index("strain")], broken[0, QUANTITIES.index("kinetic")] = -np.inf, np.inf
    assert failing(broken, SCHEME, ENERGY)[0, 0]


def test_threads_that_fill_the_cores_have_one_each_and_the_caller_keeps_all():
    if not hasattr(os, "sched_getaffinity") or len(os.sched_getaffinity(0)) < 2:
        pytest.skip("ONE CORE, or a system without affinities: pinning was NOT tested")
    seen = []

    class Watching(Recorded):
        def advance(self, samples):
            seen.append(frozenset(os.sched_getaffinity(0)))
            super().advance(samples)

    before = os.sched_getaffinity(0)
    integrate([Watching(falling()) for _ in range(4 * len(before))], SCHEME, ENERGY, lambda _: None)
    assert all(len(cores) == 1 for cores in seen)
    integrate([Watching(falling())], SCHEME, ENERGY, lambda _: None)
    assert seen[-1] == before, "one thread may run anywhere"
    assert os.sched_getaffinity(0) == before


def test_what_a_batch_raises_reaches_the_caller():
    class Torn(Recorded):
        def advance(self, samples):  # noqa: ARG002 - it fails before
            raise RuntimeError("out of memory")

    with pytest.raises(RuntimeError, match="out of memory"):
        integrate([Recorded(falling()), Torn(falling())], SCHEME, ENERGY, lambda _: None)
