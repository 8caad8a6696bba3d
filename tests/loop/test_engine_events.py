"""What a run tells while it goes on: each test is announced and ends, each checkpoint is on disk, and the end comes last and once."""

import itertools

import pytest

from mechstyle.loop.engine import Checkpointed, Corrected, Event, Finished, Simulated, SimulationStarted, Stylized


@pytest.fixture
def told(bench):
    """A run that is lowered at its end, and what it told."""
    engine = bench.engine(bench.recipe(schedule="every", every=20, control="none"))
    return engine, list(engine.run())


def of(told, kind):
    return [event for event in told[1] if isinstance(event, kind)]


def test_every_event_is_one_that_listeners_know(told):
    assert all(isinstance(event, Event) for event in told[1])
    assert {type(event) for event in told[1]} == {Stylized, SimulationStarted, Simulated, Corrected, Checkpointed, Finished}


def test_every_test_is_announced_right_before_it_ends(told):
    ends = [(one, other) for one, other in itertools.pairwise(told[1]) if isinstance(other, Simulated)]
    assert len(ends) == len(of(told, SimulationStarted)) >= 3
    for begun, ended in ends:
        assert isinstance(begun, SimulationStarted)
        assert (begun.iteration, begun.reason) == (ended.iteration, ended.reason)


def test_every_iteration_is_told_once_in_order(told):
    assert [event.iteration for event in of(told, Stylized)] == list(range(1, 61))
    assert all(event.moved > 0.0 for event in of(told, Stylized)[:10])


def test_a_checkpoint_that_is_told_is_on_disk(told):
    engine, _ = told
    for event in of(told, Checkpointed):
        assert engine.store.checkpoint(event.digest).iteration == event.checkpoint.iteration


def test_a_correction_says_what_it_does_and_is_tested(told):
    for index, event in enumerate(told[1]):
        if isinstance(event, Corrected):
            assert event.step
            assert 0.0 < event.kept <= 1.0
            assert any(isinstance(later, Simulated) for later in told[1][index:])


def test_the_end_comes_last_and_names_the_last_checkpoint(told):
    (end,) = of(told, Finished)
    assert told[1][-1] is end
    assert end.digest == of(told, Checkpointed)[-1].digest
    assert end.verdict.passes
