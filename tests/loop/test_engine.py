"""The loop: what moves, what is restrained, when it is simulated, and how it ends."""

from __future__ import annotations

import inspect
import itertools
from dataclasses import replace

import msgspec
import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.loop.engine import (
    STEP_LIMIT,
    Checkpointed,
    Corrected,
    Engine,
    Finished,
    Simulated,
    SimulationStarted,
    Stylized,
    retained_share,
)
from mechstyle.loop.store import Lane
from mechstyle.records import Doubt, Simulation
from support.bench import BumpStylizer, LeverSimulator


def states(events):
    return [event.checkpoint for event in events if isinstance(event, Checkpointed)]


def test_the_last_checkpoint_is_what_keeps_most_of_all_that_passed_with_its_verdict(bench):
    engine = bench.engine(bench.recipe(schedule="every", every=5))
    events = list(engine.run())
    last = states(events)[-1]
    ends = [event for event in events if isinstance(event, Simulated) and event.iteration == 60]
    best = max(
        (event for event in ends if event.verdict.passes),
        key=lambda event: engine.kept(replace(last, displacement=event.simulation.displacement)),
    )
    assert isinstance(events[-1], Finished)
    assert last.final
    assert np.array_equal(last.displacement, best.simulation.displacement)
    assert events[-1].verdict == last.verdict == engine.simulator.judge(best.simulation)


def test_a_checkpoint_names_the_simulation_its_stress_comes_from(bench):
    engine = bench.engine(bench.recipe(schedule="every", every=20))
    last = None
    for event in engine.run():
        if isinstance(event, Simulated):
            last = event.simulation
        elif isinstance(event, Checkpointed):
            kept_one = engine.store.objects.get_record(event.checkpoint.simulation, Simulation)
            assert np.array_equal(kept_one.stress, event.checkpoint.stress), "flat is the test that decides here"
            assert last is None or event.checkpoint.final or kept_one.landings == last.landings  # the final one is the best


def test_every_iteration_is_checkpointed_and_names_its_parent(bench):
    engine = bench.engine(bench.recipe())
    saved = [event for event in engine.run() if isinstance(event, Checkpointed)]
    assert [event.checkpoint.iteration for event in saved][:61] == list(range(61))
    assert all(later.checkpoint.parent == earlier.digest for earlier, later in itertools.pairwise(saved))


def test_the_stress_of_a_checkpoint_is_that_of_the_test_that_decides(bench):
    bench.tilt = 2.0
    engine = bench.engine(bench.recipe(schedule="every", every=20, guarantee=False))
    tested = [state for state in states(engine.run()) if state.verdict is not None]
    assert [state.iteration for state in tested] == [0, 20, 40, 60, 60]
    for state in tested:
        simulation = engine.store.objects.get_record(state.simulation, Simulation)
        assert state.verdict.deciding.test == "nearly flat"
        assert np.array_equal(state.stress, simulation.landing_stress[1])


def test_the_last_iteration_is_always_tested_thoroughly(bench):
    engine = bench.engine(bench.recipe(schedule="never"))
    started = [event for event in engine.run() if isinstance(event, SimulationStarted)]
    assert (started[0].iteration, started[0].reason) == (60, "last iteration")
    assert engine.simulator.asked[0][1]


def test_tests_in_between_are_those_that_steer(bench):
    engine = bench.engine(bench.recipe(schedule="every", every=20, guarantee=False))
    simulated = [event for event in engine.run() if isinstance(event, Simulated)]
    assert [event.iteration for event in simulated] == [20, 40, 60]
    assert [thorough for _, thorough in engine.simulator.asked] == [False, False, True]


def test_freestyle_follows_the_proposal_exactly(bench):
    engine = bench.engine(bench.recipe(control="none", schedule="never", guarantee=False))
    last = states(engine.run())[-1]
    assert np.allclose(last.displacement, engine.stylizer.proposal().displacement, rtol=1e-5)  # float32 sums of 60 increments
    wanted = engine.stylizer.proposal().displacement
    assert retained_share(last.displacement, wanted, engine.surface.vertex_areas) == pytest.approx(1.0, rel=1e-5)


def test_one_relief_of_one_style_is_kept_by_one_share_whether_a_mask_or_the_mesh_held_the_rest_back(bench, tmp_path, monkeypatch):
    """Freestyle is measured by the style's target, too, not by what it reached itself."""
    real = LeverSimulator.simulate

    def followed_in_part(simulator, displacement, *, thorough):
        return real(simulator, np.float32(0.8) * displacement, thorough=thorough)

    monkeypatch.setattr(LeverSimulator, "simulate", followed_in_part)
    shares, bench.gain = {}, 0.0
    for control in ("none", "exponential"):
        one = replace(bench, root=tmp_path / control)
        engine = one.engine(one.recipe(control=control, schedule="never", guarantee=False, minimum_wall=0.0))
        shares[control] = engine.kept(states(engine.run())[-1])
    assert shares["none"] == pytest.approx(0.8, rel=1e-4)
    assert shares["exponential"] == pytest.approx(0.8, rel=1e-4)


def test_no_wall_is_cut_below_the_minimum_unless_nothing_restrains(bench, tmp_path):
    """Walls of 4 mm with a minimum of 3 may lose half a millimetre from each side; the relief asks for one."""
    bench.height, bench.gain = -1.0, 0.0
    last = states(bench.engine(bench.recipe(minimum_wall=3.0)).run())[-1]
    assert -0.5 <= last.displacement.min() < -0.3
    free = replace(bench, root=tmp_path / "free")
    freestyle = states(free.engine(free.recipe(minimum_wall=3.0, control="none")).run())[-1]
    assert freestyle.displacement.min() == pytest.approx(-1.0, abs=0.01)


def test_masked_vertices_do_not_move_but_their_colours_do(bench):
    freedom = np.ones(64, np.float32)
    freedom[:20] = 0.0
    bench.freedom = freedom
    saved = states(bench.engine(bench.recipe()).run())
    assert not any(state.displacement[:20].any() for state in saved)
    assert np.all(saved[40].displacement[20:] > 0)
    assert np.all(saved[40].colour[:20] < saved[0].colour[:20])


def test_feedback_keeps_stress_lower_than_freestyle(bench, tmp_path):
    fed = bench.engine(bench.recipe(schedule="every", every=5, guarantee=False))
    peak_fed = [event for event in fed.run() if isinstance(event, Simulated)][-1].simulation.stress.max()
    free_bench = replace(bench, root=tmp_path / "free")
    free = free_bench.engine(bench.recipe(control="none", schedule="never", guarantee=False))
    peak_free = [event for event in free.run() if isinstance(event, Simulated)][-1].simulation.stress.max()
    assert peak_fed < 45.6 < peak_free


def test_masks_lie_between_nothing_and_all(bench):
    masks = np.stack([state.mask for state in states(bench.engine(bench.recipe(schedule="every", every=5)).run())])
    assert masks.min() >= 0.0
    assert masks.max() <= 1.0
    assert masks.min() < 0.5 < masks.max()


def test_a_vertex_moves_at_most_one_percent_of_the_size_per_iteration(bench):
    bench.height = 40.0
    bench.gain = 0.0
    engine = bench.engine(bench.recipe(guarantee=False))
    moved = np.diff(np.stack([state.displacement for state in states(engine.run())]), axis=0)
    assert np.abs(moved).max() == pytest.approx(STEP_LIMIT * engine.surface.size, rel=1e-5)


def test_a_wall_that_is_thin_at_one_vertex_is_a_corner_and_sets_off_no_simulation(bench):
    engine, settings = bench.engine, {"schedule": "geometry", "travel": 0.5, "guarantee": False}
    plain = engine(bench.recipe(**settings))
    corner = plain.bounds.thickness.copy()
    corner[27] = 0.1
    sharp = replace(engine(bench.recipe(**settings), lane="sharp"), bounds=replace(plain.bounds, thickness=corner))
    reasons = [[event.reason for event in one.run() if isinstance(event, Simulated)] for one in (plain, sharp)]
    assert reasons[0] == reasons[1]


def test_no_vertex_passes_its_bounds(bench):
    bench.height = 40.0
    bench.gain = 0.0
    engine = bench.engine(bench.recipe(guarantee=False))
    assert states(engine.run())[-1].displacement.max() <= engine.bounds.outward.max()


@pytest.mark.parametrize("gain", [30.0, 70.0, 400.0])
def test_a_finished_relief_is_corrected_until_it_passes_and_keeps_no_less_than_by_one_factor(bench, gain):
    """That of 45.6 MPa: the largest relief is 1 mm, and the plain part has 20 MPa."""
    bench.gain = gain
    engine = bench.engine(bench.recipe(schedule="never", control="none"))
    events = list(engine.run())
    assert not next(event for event in events if isinstance(event, Simulated)).verdict.passes
    assert events[-1].verdict.outcome == "HOLDS"
    assert engine.kept(states(events)[-1]) >= 25.6 / gain - 0.07


def test_the_run_ends_with_the_largest_relief_that_passed_not_with_the_last_one_tried(bench):
    bench.gain = 90.0
    engine = bench.engine(bench.recipe(schedule="never"))
    events = list(engine.run())
    tried = [event for event in events if isinstance(event, Simulated)]
    left = [event.kept for event in events if isinstance(event, Corrected)]
    passed = [event.verdict.passes for event in tried[1:]]
    assert not passed[-1], "what was tried last was too much"
    last = states(events)[-1]
    assert last.final
    assert last.passes
    assert engine.kept(last) == pytest.approx(max(kept for kept, passes in zip(left, passed, strict=True) if passes), abs=1e-6)


def test_what_masks_held_back_is_given_back_where_the_finished_relief_leaves_reserve(bench):
    """A harsh threshold closes masks long before any limit: at the end there is reserve everywhere."""
    bench.gain = 1.0
    events = list(bench.engine(bench.recipe(schedule="every", every=5, threshold=0.05)).run())
    grown = next(state for state in states(events) if state.iteration == 60)
    raised = [event for event in events if isinstance(event, Corrected)]
    assert [event.step for event in raised] == ["all of the held-back relief put back"]
    last, asked = states(events)[-1], BumpStylizer(len(grown.displacement)).target
    assert last.passes
    assert np.all(last.displacement >= grown.displacement)
    assert np.abs(last.displacement).sum() > 1.2 * np.abs(grown.displacement).sum()
    assert np.all(last.displacement <= asked + 1e-6), "never more than the style asks for"
    assert np.array_equal(last.share, grown.share)


@pytest.mark.parametrize("control", ["linear", "none"])
def test_what_the_tetrahedra_do_not_follow_is_not_given_back_where_no_mask_held_any_of_it(bench, monkeypatch, control):
    """They would not follow it the next time either, and the test costs a minute."""
    bench.gain, real = 60.0, LeverSimulator.simulate
    monkeypatch.setattr(LeverSimulator, "simulate", lambda self, asked, *, thorough: real(self, np.float32(0.9) * asked, thorough=thorough))
    events = list(bench.engine(bench.recipe(schedule="never", control=control)).run())
    steps = [event.step for event in events if isinstance(event, Corrected)]
    assert steps
    assert not [step for step in steps if "held back" in step]
    assert events[-1].verdict.passes


def test_of_two_that_keep_as_much_the_one_that_is_sure_is_taken_and_doubt_costs_no_relief(bench, monkeypatch):
    bench.gain, real = 1.0, LeverSimulator.judge

    def doubtful_when_raised(simulator, simulation, *, alone=False):
        verdict = real(simulator, simulation, alone=alone)
        raised = bool(simulation.stress.max() > 20.72)  # what the masks let grow reads 20.70
        return msgspec.structs.replace(verdict, doubts=(Doubt(about="limit", value=0.99, test="flat", landing="flat"),) * raised)

    monkeypatch.setattr(LeverSimulator, "judge", doubtful_when_raised)
    engine = bench.engine(bench.recipe(schedule="every", every=5, threshold=0.05))
    saved = states(engine.run())
    assert not saved[-1].verdict.sure
    assert engine.kept(saved[-1]) > 0.99
    grown = next(state for state in saved if state.iteration == 60)
    doubted = replace(grown, verdict=msgspec.structs.replace(grown.verdict, doubts=saved[-1].verdict.doubts))
    target = np.asarray(engine.stylizer.proposal().displacement)
    assert engine._worth(grown, target) > engine._worth(doubted, target)


def test_a_correction_lowers_where_the_landing_that_fails_yields(bench):
    """Flat would hold: only nearly flat is to be met, and its field says where."""
    bench.gain, bench.tilt = 24.0, 1.6
    events = list(bench.engine(bench.recipe(schedule="never", control="none")).run())
    verdicts = [event.verdict for event in events if isinstance(event, Simulated)]
    assert [verdicts[0].row(landing=name).outcome for name in ("flat", "tilted 3°")] == ["HOLDS", "FAILS"]
    assert events[-1].verdict.passes


def test_nothing_is_given_back_where_it_is_protected(bench):
    bench.gain, bench.freedom = 1.0, np.repeat(np.float32([0.0, 1.0]), 32)
    last = states(bench.engine(bench.recipe(schedule="every", every=5, threshold=0.05)).run())[-1]
    assert "put back" in last.reason
    assert not last.displacement[:32].any()


def test_a_correction_is_a_checkpoint_with_its_reason_and_the_share_that_is_left(bench):
    bench.gain = 200.0
    saved = states(bench.engine(bench.recipe(schedule="never")).run())
    grown = next(state for state in saved if state.iteration == 60)
    corrected = [state for state in saved if state.reason.startswith("correction: relief lowered around")]
    assert corrected
    for state in corrected:
        assert state.iteration == 60
        assert np.allclose(state.displacement, state.share * grown.displacement, atol=1e-6)
        assert state.verdict is not None


def test_without_the_guarantee_a_failing_part_is_said_to_fail(bench):
    bench.gain = 200.0
    events = list(bench.engine(bench.recipe(schedule="never", guarantee=False)).run())
    assert events[-1].verdict.outcome == "FAILS"
    assert not any(isinstance(event, Corrected) for event in events)


def test_a_failed_simulation_is_unknown_and_is_corrected_not_trusted(bench):
    bench.broken_above = 0.5
    bench.gain = 1.0
    events = list(bench.engine(bench.recipe(schedule="never")).run())
    outcomes = [event.verdict.outcome for event in events if isinstance(event, Simulated)]
    assert outcomes[0] == "UNKNOWN"
    assert events[-1].verdict.passes
    assert np.abs(states(events)[-1].displacement).max() <= 0.5


def test_a_failed_simulation_in_between_leaves_the_mask_alone(bench):
    bench.broken_above = 0.0
    saved = states(bench.engine(bench.recipe(schedule="every", every=20, guarantee=False)).run())
    assert all(np.array_equal(state.mask, saved[0].mask) for state in saved)


def test_asking_for_fewer_iterations_than_the_lane_has_is_refused(bench):
    list(bench.engine(bench.recipe()).run())
    short = bench.recipe(iterations=30)
    engine = bench.engine(short)
    with pytest.raises(BadInput, match="beyond the 30 asked for"):
        list(engine.run())


def test_events_of_an_iteration_come_in_order(bench):
    kinds = [type(event) for event in bench.engine(bench.recipe(schedule="every", every=20)).run()]
    first = kinds.index(SimulationStarted)
    assert kinds[0] is Checkpointed
    assert kinds[first - 1 : first + 3] == [Stylized, SimulationStarted, Simulated, Checkpointed]


def test_the_loop_is_short_enough_to_read_aloud():
    assert len(inspect.getsource(Engine.run).splitlines()) <= 25


def test_a_branch_with_another_style_starts_from_the_surface_it_branched_at(bench):
    list(bench.engine(bench.recipe(schedule="never", guarantee=False)).run())
    store = bench.engine(bench.recipe()).store
    fork = store.find(30).digest
    other = bench.recipe(prompt="another", schedule="never", guarantee=False)
    store.move("other", Lane(recipe=store.put_recipe(other), head=fork, forked_from=fork))
    bench.height = 0.1
    saved = states(bench.engine(other, "other").run())
    assert saved[0].iteration == 31
    # the other target is lower, so the relief shrinks from where it stood instead of jumping
    assert 0 < saved[0].displacement[-1] < store.checkpoint(fork).displacement[-1]
    assert saved[0].displacement[-1] > 0.8 * store.checkpoint(fork).displacement[-1]


def test_a_failure_in_the_middle_of_the_corrections_is_undone_and_one_factor_found(bench, monkeypatch):
    bench.gain = 200.0
    engine = bench.engine(bench.recipe(schedule="never"))
    real, asked = engine.simulator.simulate, []

    def failing_once(displacement, *, thorough):
        asked.append(displacement)
        result = real(displacement, thorough=thorough)
        return replace(result, failure="the integration blew up") if len(asked) == 2 else result

    monkeypatch.setattr(engine.simulator, "simulate", failing_once)
    events = list(engine.run())
    assert [event.verdict.outcome for event in events if isinstance(event, Simulated)][1] == "UNKNOWN"
    assert [event.step for event in events if isinstance(event, Corrected)][1].endswith("of the whole relief")
    assert events[-1].verdict.passes


def branched(bench, iteration, **settings):
    """The states of a branch of a finished, restrained run."""
    list(bench.engine(bench.recipe(schedule="every", every=5, guarantee=False)).run())
    other = bench.recipe(schedule="never", guarantee=False, **settings)
    engine = bench.engine(other, "main")
    fork = engine.store.find(iteration).digest
    engine.store.move("other", Lane(recipe=engine.store.put_recipe(other), head=fork, forked_from=fork))
    engine = bench.engine(other, "other")
    return states(engine.run()), engine


def test_a_branch_is_restrained_by_its_own_control_from_its_first_iteration_on(bench):
    saved, engine = branched(bench, 30, control="none")
    assert engine.store.checkpoint(engine.store.find(30).digest).mask.min() < 0.5
    assert all(np.all(state.mask == 1.0) for state in saved)


def test_extending_a_finished_run_winds_the_stylizer_by_iterations_not_by_checkpoints(bench):
    bench.gain = 200.0
    list(bench.engine(bench.recipe(schedule="never")).run())
    longer = bench.recipe(schedule="never", iterations=70)
    engine = bench.engine(longer)
    assert len([entry for entry in engine.store.history() if entry.iteration == 60]) > 1
    list(engine.run())
    assert engine.stylizer.steps == 10  # 60 is a keyframe


def test_a_stricter_threshold_holds_back_more(bench, tmp_path):
    def let_through(name: str, threshold: float) -> float:
        other = replace(bench, root=tmp_path / name)
        engine = other.engine(other.recipe(control="linear", schedule="every", every=5, threshold=threshold))
        return next(float(state.mask.mean()) for state in states(engine.run()) if state.iteration == 5)

    assert let_through("strict", 0.4) < let_through("plain", 1.0) < let_through("loose", 5.0)


def test_colours_stay_where_the_user_wants_them_kept(bench):
    engine = bench.engine(bench.recipe(schedule="never", guarantee=False))
    kept = np.zeros((64, 1), bool)
    kept[:20] = True
    engine = replace(engine, bounds=replace(engine.bounds, uncoloured=kept))
    saved = states(engine.run())
    assert all(np.array_equal(state.colour[:20], saved[0].colour[:20]) for state in saved)
    assert np.all(saved[40].colour[20:] < saved[0].colour[20:])
    assert np.all(saved[40].displacement[:20] > 0), "the relief is free there"
    assert saved[-1].style_loss == pytest.approx(engine.stylizer.loss(saved[-1].displacement, saved[-1].colour.astype(np.float32)))
