"""From displacement to verdict: what is remembered, what is meshed anew, and what a failure becomes."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import msgspec
import numpy as np
import pytest
import trimesh

from mechstyle.fea.stressed_volume import at_nodes, exceeded
from mechstyle.geometry.level_base import LevelBase
from mechstyle.geometry.morph import Morph
from mechstyle.geometry.remeshing.filling import fill
from mechstyle.geometry.thickness import local_thickness
from mechstyle.loop.objects import Memo, Objects
from mechstyle.records.material import LIBRARY
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.records.simulation import GREATEST_HEIGHT, LEAST_CARRIED, LEAST_HEIGHT, VOLUME_ERROR
from mechstyle.simulation import simulator as module
from mechstyle.simulation.meshes import AGAIN, SAME_PART, Body
from mechstyle.simulation.part import Shape, carrying
from mechstyle.simulation.simulator import LIKELY_EXPONENT, exponent_of, harder
from support import records
from support.dropped_block import bumps, ripples, simulator, slopes


def test_no_relief_is_the_baseline_bit_for_bit_and_passes(block, memo):
    sim = simulator(block, memo)
    again = sim.simulate(np.zeros(len(block[0].vertices), np.float32), thorough=True)
    assert np.array_equal(again.stress, sim.baseline.stress)
    assert again.landings == sim.baseline.landings
    assert sim.judge(again).passes


def test_every_landing_is_read_by_the_stress_that_a_cube_of_4_mm_exceeds(block, memo):
    """No wall of the block is thinner than that, so its volumes count as they are."""
    _, found = simulator(block, memo, orientations=3).detail(np.zeros(len(block[0].vertices), np.float32))
    assert [landing.way for landing in found.simulation.landings] == ["flat", "any landing", "any landing"]
    for landing, corners, inside in zip(found.simulation.landings, found.drop.corners, found.drop.von_mises, strict=True):
        read = exceeded(block[1], at_nodes(block[1], corners), 1.0, 64.0)
        assert (landing.stress, landing.where) == (pytest.approx(read.stress), pytest.approx(read.where))
        assert landing.maximum == inside.max() > landing.stress > 0.0
        assert landing.fall == 1500.0


def test_the_critical_height_of_the_flat_landing_follows_from_its_drop(block, memo):
    base = simulator(block, memo, orientations=1).baseline
    height = min(1500.0 * (LIBRARY["PLA"].yield_strength / base.flat.stress) ** 2, GREATEST_HEIGHT)
    assert (base.flat.critical_height, base.flat.exponent, base.flat.retried) == (pytest.approx(height), 0.5, 0)


def test_stress_and_contact_are_brought_to_the_surface(block, memo):
    base = simulator(block, memo).baseline
    assert base.landing_stress.shape == (2, len(block[0].vertices))
    for landing, stress in zip(base.landings, base.landing_stress, strict=True):
        assert stress.max() > landing.stress, "which a volume exceeds"
        assert (stress > 0.0).all()
    assert base.stress.max() < 1.5 * base.flat.maximum, "values at corners lie above those inside, most at an edge that lands"
    assert np.array_equal(base.stress, base.landing_stress[0])
    assert base.contact.any()
    assert block[0].vertices[base.contact, 2].max() < 4.0  # a block standing flat touches with its underside, seen through 4 mm elements


def test_only_the_thorough_test_turns_the_part(block, memo, drops):
    sim = simulator(block, memo)
    within, last = (sim.simulate(bumps(block), thorough=thorough) for thorough in (False, True))
    assert [[landing.way for landing in found.landings] for found in (within, last)] == [["flat"], ["flat", "any landing"]]
    assert drops == [2, 1, 1, 1], "the original first, then flat, the original flat on these tetrahedra, and what is not known yet"


def test_poses_are_another_question_where_the_part_is_turned_and_only_there(block, memo, drops):
    for poses in ("fibonacci", "faces6"):
        for thorough in (False, True):
            simulator(block, memo, poses=poses).simulate(bumps(block), thorough=thorough)
    assert drops == [2, 1, 1, 1, 2, 1]


def test_a_block_is_dropped_on_what_it_rests_on(block, memo, drops):
    base = simulator(block, memo, poses="resting", orientations=24, window=0.05).baseline
    assert drops == [6]
    normals = np.array([landing.normal for landing in base.landings])
    np.testing.assert_allclose(np.abs(normals).max(axis=1), 1.0, atol=1e-6)
    assert base.flat.normal == (0.0, 0.0, 1.0)


def test_in_the_loop_it_is_dropped_flat_and_nearly_flat_where_the_original_is_nearest_to_its_limit(block, memo, drops):
    sim = simulator(block, memo, nearly_flat=True, guarantee=False)
    flat = simulator(block, memo).simulate(slopes(block), thorough=False).flat
    drops.clear()
    within, last = (sim.simulate(slopes(block), thorough=thorough) for thorough in (False, True))
    nearly = sim.baseline.of("nearly flat")
    assert drops == [len(sim.baseline.landings), 3, len(sim.baseline.landings)]
    assert within.flat == last.flat == flat, "what other landings do is judged apart"
    hardest = sorted(nearly, key=lambda landing: -landing.stress)[:2]
    assert {landing.name for landing in within.of("nearly flat")} == {landing.name for landing in hardest}
    for landing in within.of("nearly flat"):
        assert landing.stress == last.landing(landing.name).stress
    assert len(last.of("nearly flat")) == len(nearly) > 4
    assert len(last.of("any landing")) == 1


def test_a_test_in_two_parts_is_the_same_as_in_one(block, memo, tmp_path):
    """Landings that steer come first where a relief is corrected; a part that no correction follows is dropped in all at once."""
    other = Memo(tmp_path / "other", Objects(tmp_path / "others"))
    chosen = {"nearly_flat": True, "orientations": 1, "material": msgspec.structs.replace(LIBRARY["PLA"], yield_strength=300.0)}
    found = simulator(block, memo, **chosen).simulate(slopes(block), thorough=True)
    alone = simulator(block, other, **chosen, guarantee=False).simulate(slopes(block), thorough=True)
    assert found.landings == alone.landings
    assert np.array_equal(found.landing_stress, alone.landing_stress)
    assert np.array_equal(found.contact, alone.contact)
    assert (found.steps, found.carried, found.volume) == (alone.steps, alone.carried, alone.volume)


@pytest.mark.parametrize(("corrected", "dropped"), [(True, 3), (False, 9)])
def test_what_fails_for_certain_where_it_steers_is_dropped_no_further_if_it_is_corrected(block, memo, drops, corrected, dropped):
    weak = msgspec.structs.replace(LIBRARY["PLA"], yield_strength=1.0)
    sim = simulator(block, memo, nearly_flat=True, orientations=1, guarantee=corrected, material=weak)
    before = len(sim.baseline.landings)
    found = sim.simulate(8.0 * slopes(block), thorough=True)
    verdict = sim.judge(found)
    assert (verdict.outcome, verdict.sure) == ("FAILS", True)
    assert before == 9
    assert len(found.landings) == dropped == drops[1]


def test_in_the_hardest_only_a_styled_part_is_dropped_as_while_it_grows_and_in_what_else_was_asked_for(block, memo, drops):
    sim = simulator(block, memo, nearly_flat=True, orientations=2, hardest_only=True)
    found = sim.simulate(slopes(block), thorough=True)
    assert (drops[0], len(sim.baseline.landings)) == (10, 10)
    hardest = sorted(sim.baseline.of("nearly flat"), key=lambda landing: -landing.stress)[:2]
    assert {one.name for one in found.of("nearly flat")} == {one.name for one in hardest}
    assert not any(one.retried for one in (*found.landings, *sim.baseline.landings))
    assert {one.exponent for one in found.of("nearly flat")} == {one.exponent for one in hardest} == {LIKELY_EXPONENT}
    if len(found.landings) > 3:  # unless it fails for certain
        assert [one.way for one in found.landings] == ["flat", "nearly flat", "nearly flat", "any landing"]


def test_the_hardest_of_each_other_kind_is_dropped_again_and_tells_the_exponent_of_its_kind(block, memo):
    sim = simulator(block, memo, nearly_flat=True, orientations=3)
    base, within = sim.baseline, sim.simulate(slopes(block), thorough=False)
    for way in ("nearly flat", "any landing"):
        same = base.of(way)
        hardest = max(same, key=lambda landing: landing.stress)
        assert hardest.retried <= 2
        assert not any(landing.retried for landing in same if landing is not hardest)
        assert {landing.exponent for landing in same} == {hardest.exponent}
        for landing in same:
            height = 1500.0 * (LIBRARY["PLA"].yield_strength / landing.stress) ** (1.0 / landing.exponent)
            assert landing.critical_height == pytest.approx(np.clip(height, LEAST_HEIGHT, GREATEST_HEIGHT))
    assert any(landing.retried for landing in base.of("nearly flat")), "its critical height is far from the fall"
    assert {landing.exponent for landing in within.of("nearly flat")} == {base.of("nearly flat")[0].exponent}
    assert not any(landing.retried for landing in within.landings)


@pytest.mark.parametrize("exponent", [0.2, 0.35, 0.5])
@pytest.mark.parametrize("stress", [20.0, 60.0, 150.0])
def test_the_exponent_of_a_power_law_is_found_by_two_drops_at_most(exponent, stress):
    guess = 1500.0 * (45.6 / stress) ** 2
    asked = []

    def stress_from(height):
        asked.append(height)
        return stress * (height / 1500.0) ** exponent

    found, drops = exponent_of(records.landing(stress=stress, critical_height=guess), 45.6, stress_from)
    assert found == pytest.approx(exponent)
    assert drops == len(asked) <= 2
    assert asked[0] == pytest.approx(guess)


def test_the_right_exponent_to_begin_with_spares_the_second_drop():
    guess = 1500.0 * (45.6 / 90.0) ** (1.0 / 0.35)
    found, drops = exponent_of(
        records.landing(stress=90.0, critical_height=guess, exponent=0.35), 45.6, lambda height: 90.0 * (height / 1500.0) ** 0.36
    )
    assert (found, drops) == (pytest.approx(0.36), 1)


def test_no_further_drop_is_from_higher_than_is_simulated():
    asked = []
    guess = records.landing(stress=5.0, critical_height=GREATEST_HEIGHT, exponent=0.5)
    exponent_of(guess, 45.6, lambda height: asked.append(height) or 5.0 * (height / 1500.0) ** 0.3)
    assert max(asked) == GREATEST_HEIGHT


def test_a_landing_that_yields_just_at_its_fall_is_not_dropped_again():
    found, drops = exponent_of(records.landing(stress=45.6, critical_height=1500.0), 45.6, lambda _: pytest.fail("it was dropped"))
    assert (found, drops) == (0.5, 0)


@pytest.mark.parametrize("wrong", [np.nan, 0.0, np.inf])
def test_a_further_drop_that_gives_no_number_is_a_failure(block, memo, monkeypatch, wrong):
    sim, real = simulator(block, memo, orientations=2), module.drop

    def numberless(tets, material, normals, test, **options):
        found = real(tets, material, normals, test, **options)
        return found if test.height == 1500.0 else replace(found, corners=wrong * np.ones_like(found.corners))

    monkeypatch.setattr(module, "drop", numberless)
    with np.errstate(all="ignore"):
        assert "is not a finite number above 0" in sim.baseline.failure
        assert sim.judge(sim.baseline, alone=True).outcome == "UNKNOWN"


def test_what_the_tets_could_not_follow_is_taken_out(block, memo):
    wild = (np.random.default_rng(0).choice([-4.0, 4.0], len(block[0].vertices)) * (block[0].vertices[:, 2] > 3.0)).astype(np.float32)
    result = simulator(block, memo).simulate(wild, thorough=False)
    assert result.backed_off > 0
    assert np.abs(result.displacement).max() <= 4.0
    assert np.abs(result.displacement - wild).max() == pytest.approx(result.deviation, abs=1e-3)


def test_a_lower_gap_under_a_part_carries_no_more_but_standing_on_more_does(memo):
    """Why the relief a part stands on is taken away where it is overloaded, and not lowered."""
    box = trimesh.creation.box((30.0, 20.0, 10.0)).apply_translation((0.0, 0.0, 5.0))
    box = box.subdivide().subdivide().subdivide()
    surface = SurfaceMesh(box.vertices, box.faces)
    middle, standing = np.hypot(surface.vertices[:, 0], surface.vertices[:, 1]), LevelBase(surface).standing
    gap = np.where(standing & (middle > 3.0), -0.3, 0.0).astype(np.float32)
    half = np.float32(0.5) * gap
    tets = fill(surface.displaced(half), 1500, keep=surface.displaced(2.0 * gap))
    sim = simulator((surface, tets), memo, at=half)
    gaps = (gap, np.float32(0.5) * gap, np.where(middle < 8.0, np.float32(0.0), gap))
    whole, lower, wider = (sim.simulate(displacement, thorough=False) for displacement in gaps)
    assert lower.flat.stress > 0.85 * whole.flat.stress
    assert wider.level_share > 4.0 * whole.level_share
    assert wider.flat.stress < 0.85 * whole.flat.stress


def test_a_relief_that_the_tets_carry_is_judged_on_them(block, memo):
    result = simulator(block, memo, orientations=1).simulate(slopes(block), thorough=True)
    assert (result.meshing, result.mesh) == ("morphed", block[1].digest)
    assert min(result.carried, result.carried_base) >= LEAST_CARRIED


def test_a_relief_that_they_do_not_carry_is_judged_on_tets_made_for_half_of_it(block, memo, drops):
    sim = simulator(block, memo, orientations=1)
    seen = sim.simulate(ripples(block), thorough=False)
    assert (seen.meshing, seen.mesh) == ("morphed", block[1].digest)
    assert min(seen.carried, seen.carried_base) < 0.7
    result = sim.simulate(ripples(block), thorough=True)
    assert result.meshing == AGAIN
    assert result.mesh != block[1].digest
    assert min(result.carried, result.carried_base) >= LEAST_CARRIED
    assert abs(result.volume_error) < VOLUME_ERROR
    assert drops == [1, 1, 1], "nothing is tested thoroughly on tetrahedra that do not carry it"


def test_the_original_is_dropped_on_its_own_tets_and_what_was_found_is_remembered(block, memo, drops):
    sim = simulator(block, memo)
    result = sim.simulate(ripples(block), thorough=True)
    verdict = sim.judge(result)
    assert sim.baseline.mesh == block[1].digest != result.mesh
    assert drops[:2] == [2, 1]
    asked = len(drops)
    later = simulator(block, memo)
    assert later.judge(later.simulate(ripples(block), thorough=True)) == verdict
    assert len(drops) == asked, "all is remembered"


def original_of(*stresses, hung=20.0, failure=""):
    """An original with these σ_V, flat first, and under a load."""
    names = ("flat", "tilted left", "tilted right")[: len(stresses)]
    landings = tuple(
        records.landing(name, way="nearly flat" if name != "flat" else "flat", stress=stress, critical_height=1500.0 * (45.6 / stress) ** 2)
        for name, stress in zip(names, stresses, strict=True)
    )
    load = msgspec.structs.replace(records.simulation().loads[0], stress=hung)
    fields = {"landings": landings, "landing_stress": np.ones((len(landings), records.COUNT)), "loads": (load,), "failure": failure}
    return records.simulation(**fields)


def test_an_original_is_as_hard_as_on_the_harder_of_two_meshes():
    found = harder(original_of(40.0, 60.0, 60.0, hung=30.0), original_of(42.0, 80.0, 50.0, hung=40.0))
    assert [landing.stress for landing in found.landings] == pytest.approx([42.0, 80.0, 60.0])
    assert found.loads[0].stress == pytest.approx(40.0)
    for landing in found.landings:
        assert landing.critical_height == pytest.approx(1500.0 * (45.6 / landing.stress) ** 2)


@pytest.mark.parametrize(("left", "asked"), [(0.0, True), (0.9 * SAME_PART, True), (1.1 * SAME_PART, False)])
def test_tets_that_keep_a_notch_of_the_relief_are_not_asked_about_the_plain_part(block, memo, monkeypatch, left, asked):
    """The unsafe side: what a notch on the way back reads of the plain part would excuse any style."""
    relief = ripples(block)
    tets, at = carrying(block[0], relief)
    body = Body(Shape(block[0], local_thickness(block[0])), tets, 0.4, at=at)
    assert body.made_for_relief
    real = Morph.morphed

    def stuck(self, displacement):
        found = real(self, displacement)
        return replace(found, followed=np.full_like(found.followed, left * body.shape.walls.thickness.min()))

    monkeypatch.setattr(Morph, "morphed", stuck)
    assert body.is_the_plain_part == asked


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -1.0, 0.0])
def test_tets_on_which_it_gives_no_number_excuse_nothing(wrong):
    own, here = original_of(40.0, 60.0), original_of(42.0, 70.0)
    broken = replace(
        here, landings=tuple(msgspec.structs.replace(one, stress=wrong) for one in here.landings),
        loads=(msgspec.structs.replace(here.loads[0], stress=wrong),),
    )  # fmt: skip
    assert harder(own, broken).landings == own.landings
    assert harder(own, broken).loads == own.loads
    nothing = replace(here, landings=(), landing_stress=np.zeros((0, records.COUNT)), loads=(), load_stress=np.zeros((0, records.COUNT)))
    assert harder(own, nothing).landings == own.landings


@pytest.mark.parametrize(("rough", "outcome", "asked"), [
    (False, "NO WORSE", True), (True, "NO WORSE", False), (True, "FAILS", True), (False, "UNKNOWN", False),
])  # fmt: skip
def test_the_plain_part_is_read_on_the_mesh_of_a_relief_that_does_not_pass_for_sure_a_rough_one_only_if_it_fails(
    block, memo, monkeypatch, rough, outcome, asked
):
    sim, meshes = simulator(block, memo, rough=rough), []
    base = sim.baseline
    unsure = SimpleNamespace(settled=False, passes=outcome == "NO WORSE", outcome=outcome)
    monkeypatch.setattr(module, "judge", lambda *_: unsure)
    vars(sim)["meshes"] = SimpleNamespace(known=meshes.append)
    assert sim.judge(base) is unsure
    assert meshes == [base.mesh] * asked


def test_a_drop_that_breaks_down_is_unknown_and_never_passes(block, memo, monkeypatch):
    sim = simulator(block, memo)
    assert sim.judge(sim.baseline).passes
    real = module.drop

    def broken(*args, **options):
        return replace(real(*args, **options), failure="the energy grew")

    monkeypatch.setattr(module, "drop", broken)
    result = sim.simulate(bumps(block), thorough=True)
    assert result.failure == "the energy grew"
    assert sim.judge(result).outcome == "UNKNOWN"


def test_progress_can_cancel_a_drop(block, memo):
    class Enough(Exception):
        pass

    def stop(_fraction):
        raise Enough

    sim = replace(simulator(block, memo), progress=stop)
    with pytest.raises(Enough):
        sim.simulate(bumps(block), thorough=False)
    assert replace(sim, progress=lambda _: None).simulate(bumps(block), thorough=False).stress.any()
