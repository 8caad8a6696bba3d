"""From displacement to what stays bent: what is dropped and remembered, on which mesh, what is shown, and what a failure becomes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mechstyle.fea.orientations import Orientations
from mechstyle.fea.permanent_set import measured
from mechstyle.loop.control import YIELDED
from mechstyle.loop.objects import Memo, Objects
from mechstyle.records.material import LIBRARY
from mechstyle.records.simulation import LEAST_GROUNDED, THICKER, VOLUME_ERROR, place_in_words
from mechstyle.records.verdict import REPEATS
from mechstyle.simulation import simulator as module
from mechstyle.simulation.meshes import AGAIN
from mechstyle.simulation.simulator import BEYOND, STEERING, flow_stress
from support.dropped_block import bumps, ripples, simulator, slopes

PLA = LIBRARY["PLA"]
HARD = {"orientations": 3, "height": 2e4}
"""A fall of 20 m, after which the block stays bent where it lands on an edge."""


def nothing(block):
    return np.zeros(len(block[0].vertices), np.float32)


# --- what a landing leaves ----------------------------------------------------------------------------------------


def test_no_relief_is_the_baseline_bit_for_bit_and_passes(block, memo):
    sim = simulator(block, memo)
    again = sim.simulate(nothing(block), thorough=True)
    assert again.landings == sim.baseline.landings
    for name in ("landing_stress", "landing_strain", "landing_set"):
        assert np.array_equal(getattr(again, name), getattr(sim.baseline, name))
    assert sim.judge(again).passes


def test_every_landing_has_the_figures_of_its_drop_and_a_place_in_words(block, memo):
    sim = simulator(block, memo, **HARD)
    landings, drop = sim.baseline.landings, sim.dropped(block[1], range(3))
    assert [landing.way for landing in landings] == ["flat", "any landing", "any landing"]
    for landing, permanent, tension, inside in zip(landings, drop.permanent, drop.tension_strain, drop.von_mises, strict=True):
        read = measured(block[1], permanent, tension)
        assert (landing.permanent_set, landing.where, landing.plastic_strain) == read
        assert landing.place == (place_in_words(landing.where, (-15, -10, 0), (15, 10, 10)) if landing.permanent_set else "")
        assert (landing.maximum, landing.fall) == (inside.max(), 2e4)
    assert max(landing.permanent_set for landing in landings) > 0.1


def test_what_stays_bent_and_what_yields_is_seen_at_the_surface(block, memo):
    base = simulator(block, memo, **HARD).baseline
    assert base.landing_set.shape == (3, len(block[0].vertices), 3)
    for landing, stress, strain, bend in zip(base.landings, base.landing_stress, base.landing_strain, base.landing_set, strict=True):
        length = np.linalg.norm(bend, axis=1)
        assert length.max() >= 0.9 * landing.permanent_set
        if landing.permanent_set > 0.05:
            near = np.linalg.norm(block[0].vertices - landing.where, axis=1) < 5.0  # an edge of the tetrahedra
            assert length[near].max() > 0.9 * landing.permanent_set, "the place is one that is bent"
        assert np.array_equal(stress > PLA.yield_strength, strain > YIELDED), "what is above the strength is what has yielded"


def test_stress_is_at_most_the_strength_where_nothing_yields_and_the_flow_stress_where_it_does():
    stress, strain = np.array([10.0, 60.0, 60.0, 10.0, 90.0]), np.array([0.0, 0.0, YIELDED, 0.1, 0.1])
    flows = PLA.yield_strength * (1.0 + BEYOND) + 0.1 * PLA.hardening
    expected = [10.0, PLA.yield_strength, PLA.yield_strength, flows, flows]
    assert flow_stress(stress, strain, PLA) == pytest.approx(expected)


def test_by_the_published_rule_nothing_yields(block, memo):
    base = simulator(block, memo, criterion="paper", **HARD).baseline
    assert not any(landing.permanent_set or landing.plastic_strain or landing.place for landing in base.landings)
    assert not base.landing_set.any()
    assert base.landing_stress.max() > PLA.yield_strength


def test_a_block_standing_flat_touches_with_its_underside(block, memo):
    base = simulator(block, memo).baseline
    assert base.contact.any()
    assert block[0].vertices[base.contact, 2].max() < 4.0  # seen through elements of 4 mm


@pytest.mark.parametrize("height", [1500.0, 3000.0, 24e3])
def test_twice_the_height_never_leaves_less(block, memo, height):
    """To the end of the impact; what a second touch adds may differ by as much as a test repeats."""
    low, high = (simulator(block, memo, orientations=5, height=times * height, window=None).baseline for times in (1.0, 2.0))
    for one, other in zip(low.landings, high.landings, strict=True):
        assert other.permanent_set >= one.permanent_set - 0.5 * REPEATS
    assert sum(landing.permanent_set for landing in high.landings) > 1.3 * sum(landing.permanent_set for landing in low.landings)


# --- in which landings --------------------------------------------------------------------------------------------


def asked_in(sim, *numbers, words="{}"):
    """The same simulator with some of its landings, the flat one first, under other names."""
    every = sim.landings
    names = tuple(words.format(every.names[number]) for number in numbers)
    vars(sim)["landings"] = Orientations(every.normals[list(numbers)], names, tuple(every.ways[number] for number in numbers))
    return sim


def test_a_landing_is_remembered_by_itself_whatever_list_it_is_asked_for_in(block, memo, drops):
    settings = {"poses": "box26", "orientations": 10}
    first = asked_in(simulator(block, memo, **settings), 0, 1, 2).baseline
    again = asked_in(simulator(block, memo, **settings), 0, 3, 2, words="the {}").baseline
    assert drops == [3, 1]
    assert [landing.name.removeprefix("the ") for landing in again.landings][2] == first.landings[2].name
    assert again.landings[2].permanent_set == first.landings[2].permanent_set
    assert np.array_equal(again.landing_set[2], first.landing_set[2])
    assert asked_in(simulator(block, memo, **settings), 0, 2).simulate(nothing(block), thorough=True).landings[1] == first.landings[2]
    assert drops == [3, 1]


def test_landings_are_the_same_dropped_together_or_apart(block, memo, tmp_path):
    other = Memo(tmp_path / "other", Objects(tmp_path / "others"))
    sim, alone = (simulator(block, one, nearly_flat=True, orientations=2) for one in (memo, other))
    sim.simulate(slopes(block), thorough=False)
    apart, together = (one.simulate(slopes(block), thorough=True) for one in (sim, alone))
    assert apart.landings == together.landings
    assert np.array_equal(apart.landing_set, together.landing_set)
    assert np.array_equal(apart.landing_stress, together.landing_stress)


def test_in_the_loop_it_is_dropped_flat_and_as_the_original_stays_bent_most_and_at_the_end_in_all_that_was_asked_for(block, memo, drops):
    sim = simulator(block, memo, nearly_flat=True, orientations=2)
    within, last = (sim.simulate(slopes(block), thorough=thorough) for thorough in (False, True))
    count, nearly = len(sim.baseline.landings), sim.baseline.landed("nearly flat")
    assert drops == [count, 1 + STEERING, count - 1 - STEERING], "what steered is not dropped again"
    hardest = sorted(nearly, key=lambda landing: -landing.permanent_set)[:STEERING]
    assert {landing.name for landing in within.landings[1:]} == {landing.name for landing in hardest}
    assert [landing.name for landing in last.landings] == list(sim.landings.names)
    for landing in within.landings:
        assert landing == last.landing(landing.name)
    assert [row.landing for row in sim.judge(last).rows] == list(sim.landings.names)


def test_one_landing_that_stays_bent_among_those_asked_for_decides(block, memo):
    sim = simulator(block, memo, poses="box26", orientations=10, height=2e4, tolerance=0.15)
    verdict = sim.judge(sim.baseline, alone=True)
    bent = [landing.name for landing in sim.baseline.landings if landing.permanent_set > 0.15 or landing.plastic_strain > PLA.elongation]
    assert [row.landing for row in verdict.rows if row.outcome == "FAILS"] == bent
    assert (verdict.outcome, verdict.deciding.landing in bent) == ("FAILS", True)
    assert sum(row.outcome == "HOLDS" for row in verdict.rows) >= 1


def test_a_block_is_dropped_on_what_it_rests_on(block, memo, drops):
    base = simulator(block, memo, poses="resting", orientations=24, window=0.05).baseline
    assert drops == [6]
    normals = np.array([landing.normal for landing in base.landings])
    np.testing.assert_allclose(np.abs(normals).max(axis=1), 1.0, atol=1e-6)
    assert base.flat.normal == (0.0, 0.0, 1.0)


# --- on which tetrahedra ------------------------------------------------------------------------------------------


def test_what_the_tets_could_not_follow_is_taken_out(block, memo):
    wild = (np.random.default_rng(0).choice([-4.0, 4.0], len(block[0].vertices)) * (block[0].vertices[:, 2] > 3.0)).astype(np.float32)
    result = simulator(block, memo).simulate(wild, thorough=False)
    assert result.backed_off > 0
    assert np.abs(result.displacement).max() <= 4.0
    assert np.abs(result.displacement - wild).max() == pytest.approx(result.deviation, abs=1e-3)


def test_a_relief_that_the_tets_carry_is_judged_on_them(block, memo):
    result = simulator(block, memo, orientations=1).simulate(slopes(block), thorough=True)
    assert (result.meshing, result.mesh) == ("morphed", block[1].digest)
    assert result.carried > 0.9
    assert result.thicker <= THICKER


def test_a_relief_that_they_do_not_carry_is_judged_on_tets_made_for_half_of_it_and_the_original_on_its_own(block, memo, drops):
    sim = simulator(block, memo, orientations=1)
    seen = sim.simulate(ripples(block), thorough=False)
    assert (seen.meshing, seen.mesh) == ("morphed", block[1].digest)
    assert seen.thicker > 1.5 * THICKER
    result = sim.simulate(ripples(block), thorough=True)
    assert result.meshing == AGAIN
    assert result.thicker <= THICKER
    assert result.grounded >= LEAST_GROUNDED
    assert abs(result.volume_error) < VOLUME_ERROR
    assert drops == [1, 1, 1], "nothing is tested thoroughly on tetrahedra that do not carry it"
    verdict = sim.judge(result)
    assert sim.baseline.mesh == block[1].digest != result.mesh
    later = simulator(block, memo, orientations=1)
    assert later.judge(later.simulate(ripples(block), thorough=True)) == verdict
    assert drops == [1, 1, 1], "all is remembered"


# --- what a failure becomes ---------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_drop_that_breaks_down_is_unknown_with_its_reason_and_loses_no_other(block, memo, monkeypatch, drops):
    sim, counting = simulator(block, memo, orientations=3), module.drop
    assert sim.judge(sim.baseline).passes
    bad, named = sim.landings.normals[1], f"in the landing {sim.landings.names[1]!r} the energy grew"

    def broken(tets, material, normals, test, **options):
        found = counting(tets, material, normals, test, **options)
        return replace(found, failure="the energy grew") if any(np.array_equal(normal, bad) for normal in normals) else found

    monkeypatch.setattr(module, "drop", broken)
    result = sim.simulate(bumps(block), thorough=True)
    assert (result.failure, result.landings) == (named, ())
    verdict = sim.judge(result)
    assert (verdict.outcome, verdict.failure) == ("UNKNOWN", named)
    assert drops == [3, 3, 1, 1, 1], "together, and then each by itself"
    others = asked_in(simulator(block, memo, orientations=3), 0, 2)
    assert not others.simulate(bumps(block), thorough=True).failure
    assert drops == [3, 3, 1, 1, 1], "what did not break down is remembered"


@pytest.mark.parametrize("wrong", [np.nan, np.inf])
def test_a_set_that_is_no_number_is_unknown(block, memo, monkeypatch, wrong):
    sim, real = simulator(block, memo), module.drop

    def numberless(*args, **options):
        found = real(*args, **options)
        return replace(found, permanent=np.full_like(found.permanent, wrong))

    monkeypatch.setattr(module, "drop", numberless)
    with np.errstate(all="ignore"):
        assert sim.judge(sim.baseline, alone=True).outcome == "UNKNOWN"


def test_progress_can_cancel_a_drop(block, memo):
    class Enough(Exception):
        pass

    def stop(_fraction):
        raise Enough

    sim = replace(simulator(block, memo), progress=stop)
    with pytest.raises(Enough):
        sim.simulate(bumps(block), thorough=False)
    assert replace(sim, progress=lambda _: None).simulate(bumps(block), thorough=False).stress.any()
