"""The pool with jobs that misbehave, and the energy by which a drop is found out."""

import os

import numpy as np
import pytest

from mechstyle.fea.elasticity import StVenantKirchhoff
from mechstyle.fea.explicit import QUANTITIES, Scheme, carry, failing

SCHEME = Scheme(StVenantKirchhoff(1.0, 1.0), 1e-3, np.zeros(1), 9.81e-3, 0.0, speed=2.0, stride=4, samples=10)
ENERGY = 2.0


class Counted:
    """A job of so many goes."""

    def __init__(self, goes):
        self.goes, self.taken = goes, 0

    def advance(self):
        self.taken += 1

    def look(self):
        return [self] if self.taken < self.goes else []


def falling(kinetic=ENERGY, count=10):
    samples = np.zeros((count, len(QUANTITIES), 1))
    samples[:, QUANTITIES.index("kinetic")] = kinetic
    return samples


def test_all_jobs_run_to_their_ends_and_somebody_is_told():
    jobs, told = [Counted(goes) for goes in (1, 5, 3, 10, 2)], []
    carry(jobs, lambda: told.append(sum(job.taken for job in jobs)))
    assert [job.taken for job in jobs] == [1, 5, 3, 10, 2]
    assert told == sorted(told)


def test_a_job_may_go_on_as_several_others():
    class Parting(Counted):
        def look(self):
            return after

    after = [Counted(3), Counted(4)]
    carry([Parting(1), Counted(2)], lambda: None)
    assert [job.taken for job in after] == [3, 4]


@pytest.mark.parametrize("value", [np.nan, np.inf, 3.0])
def test_what_is_not_finite_or_too_much_is_failing(value):
    broken = np.concatenate([falling(), falling()], axis=2)
    broken[3:, QUANTITIES.index("kinetic"), 1] = value
    bad = failing(broken, SCHEME)
    assert not bad[:, 0].any()
    np.testing.assert_array_equal(bad[:, 1], [False] * 3 + [True] * 7)


def test_energy_that_damping_took_does_not_hide_energy_gained():
    damped = falling()
    damped[:, QUANTITIES.index("kinetic"), 0] = ENERGY * np.array([1.0, 0.7, 0.5, 0.5, 0.505, 0.52, 0.52, 0.52, 0.4, 0.4])
    bad = failing(damped, SCHEME)[:, 0]
    np.testing.assert_array_equal(bad, [False] * 5 + [True] * 3 + [False] * 2)


def test_a_floor_that_gives_more_than_it_took_is_failing():
    """Of a penalty floor: its work is known exactly, so that what it gives would balance what the body gains."""
    pushed = falling()
    kinetic, lost = (pushed[:, QUANTITIES.index(name), 0] for name in ("kinetic", "contact_loss"))
    kinetic[5:] += 0.02 * ENERGY
    lost[5:] -= 0.02 * ENERGY
    np.testing.assert_array_equal(failing(pushed, SCHEME)[:, 0], [False] * 5 + [True] * 5)


def test_opposite_infinities_are_a_failure_not_a_warning():
    broken = falling()
    broken[1, QUANTITIES.index("strain")], broken[1, QUANTITIES.index("kinetic")] = -np.inf, np.inf
    assert failing(broken, SCHEME)[1, 0]


def test_threads_that_fill_the_cores_have_one_each_and_the_caller_keeps_all():
    if not hasattr(os, "sched_getaffinity") or len(os.sched_getaffinity(0)) < 2:
        pytest.skip("ONE CORE, or a system without affinities: pinning was NOT tested")
    seen = []

    class Watching(Counted):
        def advance(self):
            seen.append(frozenset(os.sched_getaffinity(0)))
            super().advance()

    before = os.sched_getaffinity(0)
    carry([Watching(10) for _ in range(4 * len(before))], lambda: None)
    assert all(len(cores) == 1 for cores in seen)
    carry([Watching(10)], lambda: None)
    assert seen[-1] == before, "one thread may run anywhere"
    assert os.sched_getaffinity(0) == before


def test_what_a_batch_raises_reaches_the_caller():
    class Torn(Counted):
        def advance(self):
            raise RuntimeError("out of memory")

    with pytest.raises(RuntimeError, match="out of memory"):
        carry([Counted(10), Torn(10)], lambda: None)


def test_threads_are_limited_by_the_environment_and_then_pinned_nowhere(monkeypatch):
    from mechstyle.errors import BadInput  # noqa: PLC0415
    from mechstyle.fea import explicit  # noqa: PLC0415

    monkeypatch.setenv("MECHSTYLE_THREADS", "3")
    assert explicit.cores() == 3
    monkeypatch.setattr(explicit.os, "sched_getaffinity", lambda _: {0, 1, 2}, raising=False)
    assert explicit._places(3).empty()
    monkeypatch.delenv("MECHSTYLE_THREADS")
    assert not explicit._places(3).empty()
    monkeypatch.setenv("MECHSTYLE_THREADS", "many")
    with pytest.raises(BadInput, match="whole number of threads"):
        explicit.cores()
