"""From displacement to verdict: what is remembered, what is meshed anew, and what a failure becomes."""

from __future__ import annotations

from dataclasses import replace

import msgspec
import numpy as np
import pytest
import trimesh

from mechstyle.errors import BadInput, SimulationFailed
from mechstyle.fea.discretisation import discretise
from mechstyle.fea.drop import DropTest
from mechstyle.fea.elements import LINEAR
from mechstyle.geometry.tetrahedra import VOLUME_ERROR, tetrahedralise
from mechstyle.loop.objects import Memo, Objects
from mechstyle.records import Recipe
from mechstyle.records.load_cases import Load, LoadCase, Patch, Support
from mechstyle.records.material import LIBRARY
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.simulation import physics as physics_module
from mechstyle.simulation import simulator as module
from mechstyle.simulation.carrying import AGAIN, LEAST_CARRIED, carrying
from mechstyle.simulation.part_test import judge_alone
from mechstyle.simulation.simulator import DropSimulator
from mechstyle.simulation.validation.meshes import box


@pytest.fixture(scope="module")
def block():
    """A 30 × 20 × 10 mm block and its tetrahedra."""
    box = trimesh.creation.box((30.0, 20.0, 10.0))
    box.apply_translation((0, 0, 5.0))
    for _ in range(3):
        box = box.subdivide()
    surface = SurfaceMesh(box.vertices, box.faces)
    return surface, tetrahedralise(surface, 600)


@pytest.fixture
def memo(tmp_path):
    return Memo(tmp_path / "memo", Objects(tmp_path / "objects"))


@pytest.fixture
def drops(monkeypatch):
    """Counts drop tests; each entry is the number of orientations."""
    counted, real = [], module.drop

    def counting(tets, material, floor_normals, test, **options):
        counted.append(len(floor_normals))
        return real(tets, material, floor_normals, test, **options)

    monkeypatch.setattr(module, "drop", counting)
    return counted


def simulator(block, memo, **settings) -> DropSimulator:
    surface, tets = block
    chosen = {"material": LIBRARY["PLA"], "orientations": 2, "tilts": 0, "window": 0.1, **settings}
    recipe = Recipe(surface=surface.digest, tetrahedra=tets.digest, prompt="", **chosen)
    return DropSimulator(surface, tets, recipe, memo)


def discretised(block):
    """The linear tetrahedra as a drop takes them."""
    return discretise(block[1], LIBRARY["PLA"], DropTest().added_mass, LINEAR)


def bumps(block, height=0.2):
    """A smooth relief that is zero on the resting face."""
    x, y, z = block[0].vertices.T
    return (height * np.sin(x) * np.sin(y) * (z > 3.0)).astype(np.float32)


def slopes(block, height=0.2):
    """A relief as slow as the tetrahedra are large, above the floor and not level under the part."""
    return (-height * (1.0 + np.sin(0.06 * block[0].vertices[:, 0]))).astype(np.float32)


def ripples(block, height=0.3):
    """A relief finer than the tetrahedra, all of it inwards."""
    x, y, z = block[0].vertices.T
    return (-height * (1.0 + np.sin(1.1 * x) * np.cos(1.1 * y) * np.cos(1.1 * z))).astype(np.float32)


def test_no_relief_is_the_baseline_bit_for_bit_and_viable(block, memo):
    sim = simulator(block, memo)
    again = sim.simulate(np.zeros(len(block[0].vertices), np.float32), thorough=True)
    assert np.array_equal(again.stress, sim.baseline.stress)
    assert sim.judge(again).viable


def test_stress_is_there_and_its_largest_is_the_peak(block, memo):
    base = simulator(block, memo).baseline
    assert base.stress.max() == pytest.approx(base.as_placed.peak, rel=0.05)
    assert base.as_placed.peak == max(base.as_placed.surface, base.as_placed.contact) > 0.0
    assert base.envelope.max() == pytest.approx(base.overall.peak, rel=0.05)
    assert base.overall.peak == max(landing.measures.peak for landing in base.landings)
    assert np.all(base.envelope >= base.stress - 1e-4)
    assert base.contact.any()
    assert block[0].vertices[base.contact, 2].max() < 4.0  # a block standing flat touches with its underside, seen through 4 mm elements


def test_the_same_question_is_simulated_once(block, memo, drops):
    sim = simulator(block, memo)
    first = sim.simulate(bumps(block), thorough=False)
    second = simulator(block, memo).simulate(bumps(block), thorough=False)
    assert drops == [1]
    assert np.array_equal(first.stress, second.stress)
    assert first.as_placed == second.as_placed


@pytest.mark.parametrize(
    "settings",
    [
        {"window": 0.12},
        {"drop_height": 1000.0},
        {"damping": 0.2},
        {"friction": 0.3},
        {"material": msgspec.structs.replace(LIBRARY["PLA"], youngs_modulus=2000.0)},
    ],
)
def test_anything_that_matters_makes_it_another_question(block, memo, drops, settings):
    sim = simulator(block, memo)
    sim.simulate(bumps(block), thorough=False)
    replace(sim, recipe=msgspec.structs.replace(sim.recipe, **settings)).simulate(bumps(block), thorough=False)
    assert drops == [1, 1]


def test_what_does_not_matter_does_not(block, memo, drops):
    for settings in ({}, {"control": "linear"}, {"schedule": "never"}, {"iterations": 3}, {"seed": 7}):
        simulator(block, memo, **settings).simulate(bumps(block), thorough=False)
    assert drops == [1]


def test_the_baseline_is_shared_between_runs(block, memo, tmp_path, drops):
    shared = Memo(tmp_path / "shared", Objects(tmp_path / "shared-objects"))
    for name in ("a", "b"):
        own = Memo(tmp_path / name, Objects(tmp_path / f"{name}-objects"))
        assert replace(simulator(block, own), shared=shared).baseline.stress.any()
    assert drops == [2]


def forged(sim):
    """The baseline made ten times as strong as it is, as a stranger could have written it into a run folder."""
    honest = sim.simulate(np.zeros(len(sim.surface.vertices), np.float32), thorough=True)
    return replace(honest, as_placed=msgspec.structs.replace(honest.as_placed, peak=0.1 * honest.as_placed.peak))


def test_a_forged_baseline_of_a_run_folder_stays_in_that_folder(block, memo, tmp_path, drops):
    stranger, users = (Memo(tmp_path / name, Objects(tmp_path / f"{name}-objects")) for name in ("stranger", "users"))
    sim = replace(simulator(block, stranger), shared=users)
    lie = forged(simulator(block, memo))
    stranger.remember(sim._key(np.zeros(len(block[0].vertices), np.float32), thorough=True), lie)
    assert sim.baseline.as_placed == lie.as_placed  # the folder is believed about itself
    assert not users.folder.exists()
    assert replace(simulator(block, Memo(tmp_path / "own", memo.objects)), shared=users).baseline.as_placed != lie.as_placed
    assert drops == [2, 2]


def test_what_the_user_computed_before_is_believed_rather_than_a_run_folder(block, memo, tmp_path):
    stranger, users = (Memo(tmp_path / name, Objects(tmp_path / f"{name}-objects")) for name in ("stranger", "users"))
    honest = replace(simulator(block, memo), shared=users).baseline
    sim = replace(simulator(block, stranger), shared=users)
    stranger.remember(sim._key(honest.displacement, thorough=True), forged(simulator(block, memo)))
    assert sim.baseline.as_placed == honest.as_placed


@pytest.mark.parametrize("other", ["surface", "tetrahedra"])
def test_the_baseline_of_a_part_that_is_not_the_one_its_recipe_names_is_for_itself(block, memo, tmp_path, other):
    """A run folder could hold a sturdy part under the recipe of another one."""
    users = Memo(tmp_path / "users", Objects(tmp_path / "users-objects"))
    sim = simulator(block, memo)
    claimed = replace(sim, shared=users, recipe=msgspec.structs.replace(sim.recipe, **{other: "5" * 64}))
    assert claimed.baseline.stress.any()
    assert not users.folder.exists()


def test_without_a_window_the_impact_ends_by_the_period_of_the_unstylized_part(block, memo, tmp_path, monkeypatch):
    asked, real = [], physics_module.lowest_period

    def counting(body, material):
        asked.append(len(body.volumes))
        return real(body, material)

    monkeypatch.setattr(physics_module, "lowest_period", counting)
    shared = Memo(tmp_path / "shared", Objects(tmp_path / "shared-objects"))
    for own in (memo, Memo(tmp_path / "other", Objects(tmp_path / "objects"))):
        sim = replace(simulator(block, own, window=None, element="tet4"), shared=shared)
        plain, styled = sim.baseline, sim.simulate(bumps(block), thorough=False)
        for simulation in (plain, styled):
            assert simulation.landings
            for landing in simulation.landings:
                assert landing.touches[0] == pytest.approx(np.sqrt(2 * 9.81e-3 * 1500.0))
                assert landing.ended
    assert asked == [len(block[1].tets)]
    assert physics_module.period_of(lambda: block[1], sim.recipe, shared) == real(discretised(block), LIBRARY["PLA"])
    simulator(block, memo).simulate(bumps(block), thorough=False)
    assert len(asked) == 1, "a window needs no period"


def test_a_forged_period_of_a_run_folder_stays_in_that_folder(block, memo, tmp_path):
    stranger, users = (Memo(tmp_path / name, Objects(tmp_path / f"{name}-objects")) for name in ("stranger", "users"))
    sim = simulator(block, memo, window=None, element="tet4")
    honest = physics_module.period_of(lambda: block[1], sim.recipe, memo)
    (key,) = [path.name for path in memo.folder.iterdir()]
    stranger.remember(key, 10.0 * honest)
    assert physics_module.period_of(lambda: block[1], sim.recipe, stranger, users) == 10.0 * honest
    assert not users.folder.exists()
    users.remember(key, honest)
    assert physics_module.period_of(lambda: block[1], sim.recipe, stranger, users) == honest


def test_only_the_thorough_test_turns_the_part(block, memo, drops):
    sim = simulator(block, memo)
    assert sim.simulate(bumps(block), thorough=False).overall is None
    assert sim.simulate(bumps(block), thorough=True).overall is not None
    assert drops == [1, 2]


def test_poses_are_another_question_where_the_part_is_turned_and_only_there(block, memo, drops):
    for poses in ("fibonacci", "tilts"):
        for thorough in (False, True):
            simulator(block, memo, poses=poses).simulate(bumps(block), thorough=thorough)
    assert drops == [1, 2, 2]


def test_a_block_is_dropped_on_what_it_rests_on(block, memo, drops):
    base = simulator(block, memo, poses="resting", orientations=24, window=0.05).baseline
    assert drops == [6]
    normals = np.array([landing.normal for landing in base.landings])
    np.testing.assert_allclose(np.abs(normals).max(axis=1), 1.0, atol=1e-6)
    assert base.landings[0].measures == base.as_placed
    assert base.landings[0].weight > 0.25  # the largest side of 30 × 20 × 10 mm


def test_tilted_landings_are_dropped_beside_the_one_as_placed_in_the_loop_as_well(block, memo, drops):
    sim = simulator(block, memo, tilts=3)
    placed = simulator(block, memo).simulate(slopes(block), thorough=False)
    within, last = (sim.simulate(slopes(block), thorough=thorough) for thorough in (False, True))
    assert drops == [1, 4, 5]
    assert [landing.name[:6] for landing in last.landings] == ["as pla", "tilted", "tilted", "tilted", "direct"]
    assert within.as_placed == placed.as_placed, "what tilted landings do is judged apart"
    assert np.array_equal(within.stress, placed.stress)
    for found in (within, last):
        assert found.tilted.surface == max(landing.measures.surface for landing in found.landings[1:4])
        # Brought to the vertices of the part, which may miss the place.
        assert 0.0 < found.tilted_stress.max() <= 1.001 * found.tilted.surface
        assert np.all(found.envelope >= found.tilted_stress - 1e-4)
    assert within.overall is None
    assert last.overall.p99 >= within.tilted.p99
    assert sum(landing.weight for landing in last.landings) == pytest.approx(1.0)
    assert len({landing.weight for landing in last.landings[:4]}) == 1


def test_where_a_tilted_landing_touches_is_left_to_the_rule_over_all_orientations(block, memo):
    """An edge that is hit has no finite stress, styled or not; what tilts are judged by is the surface away from it."""
    found = simulator(block, memo, tilts=3).simulate(bumps(block), thorough=False)
    corner = found.tilted_stress[block[0].vertices[:, 2] < 0.5]
    assert found.envelope[block[0].vertices[:, 2] < 0.5].max() > 1.2 * corner.max()


def test_probability_is_the_weight_of_the_drops_that_exceed_the_yield_strength(block, memo):
    first = simulator(block, memo, orientations=4).baseline
    peaks = [landing.measures.peak for landing in first.landings]
    between = msgspec.structs.replace(LIBRARY["PLA"], yield_strength=float(np.mean(sorted(peaks)[1:3])))
    base = simulator(block, memo, orientations=4, material=between).baseline
    beyond = [landing.weight for landing in base.landings if landing.measures.peak > between.yield_strength]
    assert len(beyond) == 2
    assert base.failure_probability == pytest.approx(sum(beyond))
    assert 0.0 < base.probability.max() <= base.failure_probability + 1e-6
    assert np.array_equal(base.probability > 0.0, base.probability >= min(beyond) - 1e-6)
    assert (base.envelope[base.probability > 0.0] > between.yield_strength).all()
    assert not base.probability[base.envelope <= between.yield_strength].any()


def test_one_drop_has_no_probability(block, memo):
    weak = msgspec.structs.replace(LIBRARY["PLA"], yield_strength=1.0)
    alone = simulator(block, memo, material=weak, orientations=1).baseline
    assert alone.as_placed.peak > 1.0
    assert not alone.probability.any()
    assert alone.failure_probability is None


def test_what_the_tets_could_not_follow_is_taken_out(block, memo):
    wild = (np.random.default_rng(0).choice([-4.0, 4.0], len(block[0].vertices)) * (block[0].vertices[:, 2] > 3.0)).astype(np.float32)
    result = simulator(block, memo).simulate(wild, thorough=False)
    assert result.backed_off > 0
    assert np.abs(result.displacement).max() <= 4.0
    assert np.abs(result.displacement - wild).max() == pytest.approx(result.deviation, abs=1e-3)


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
    assert drops == [1, 1], "nothing is dropped on tetrahedra that do not carry it"


def test_the_original_is_dropped_on_its_own_tets_and_beside_a_part_that_fails_on_those_of_the_part(block, memo, drops):
    sim = simulator(block, memo)
    result = sim.simulate(ripples(block), thorough=True)
    assert sim.baseline.mesh == block[1].digest != result.mesh
    assert sim.judge(sim.baseline).all_orientations.limit == sim.judge(result).all_orientations.limit
    assert drops == [2, 2, 1]
    later = simulator(block, memo)
    assert later.judge(later.simulate(ripples(block), thorough=True)) == sim.judge(result)
    assert len(drops) == 3, "all are remembered"


def test_the_tets_of_a_relief_are_taken_for_the_next_that_they_carry(block, memo, monkeypatch):
    asked, real = [], module.carrying
    monkeypatch.setattr(module, "carrying", lambda surface, relief: asked.append(1) or real(surface, relief))
    sim = simulator(block, memo, orientations=1)
    first = sim.simulate(ripples(block), thorough=True)
    lower = sim.simulate(0.8 * ripples(block), thorough=True)
    assert lower.mesh == first.mesh
    assert len(asked) == 1


def test_a_part_that_cannot_be_meshed_again_is_judged_as_it_is_and_says_so(block, memo, monkeypatch):
    def refuse(*_args, **_options):
        raise SimulationFailed("fTetWild gave up")

    monkeypatch.setattr(module, "carrying", refuse)
    result = simulator(block, memo, orientations=1).simulate(ripples(block), thorough=True)
    assert result.meshing.startswith("morphed, carrying")
    assert "fTetWild gave up" in result.meshing


def test_a_run_on_tets_made_for_its_relief_needs_no_others(block, memo):
    surface = block[0]
    tets, at = carrying(surface, ripples(block))
    sim = replace(simulator((surface, tets), memo, orientations=1), at=at)
    result = sim.simulate(ripples(block), thorough=True)
    assert (result.meshing, result.mesh) == ("morphed", tets.digest)
    assert min(result.carried, result.carried_base) >= LEAST_CARRIED


def test_a_drop_that_breaks_down_is_unknown_never_viable(block, memo, monkeypatch):
    sim = simulator(block, memo)
    assert sim.judge(sim.baseline).viable
    real = module.drop

    def broken(*args, **options):
        return replace(real(*args, **options), failure="the energy grew")

    monkeypatch.setattr(module, "drop", broken)
    result = sim.simulate(bumps(block), thorough=True)
    assert result.failure == "the energy grew"
    assert sim.judge(result).outcome == "UNKNOWN"


PUSH = LoadCase(
    name="push", supports=(Support(at="resting face"),), loads=(Load(at=Patch(plane=(0, 0, 10, 0, 0, 1)), force=(3e4, 0.0, 0.0)),)
)
REST = LoadCase(name="rest", supports=(Support(at="resting face"),), loads=(Load(gravity=1.0),))


def test_the_worse_of_drop_and_loads_drives_and_decides(block, memo):
    dropped, loaded = (simulator(block, memo, **settings).baseline for settings in ({}, {"loads": (PUSH, REST)}))
    push, rest = loaded.loaded
    assert loaded.governing == "push"
    assert loaded.as_placed.peak == push.peak > dropped.as_placed.peak > rest.peak > 0.0
    assert loaded.as_placed.where == push.where
    assert np.all(loaded.stress >= dropped.stress)
    assert loaded.stress.max() == pytest.approx(push.peak, rel=0.1)  # the surface's vertices lie between those of the tetrahedra
    assert np.all(loaded.envelope >= dropped.envelope)
    assert loaded.overall == dropped.overall


def test_a_drop_that_is_worse_than_its_loads_stays_as_it_is(block, memo):
    dropped, loaded = (simulator(block, memo, **settings).baseline for settings in ({}, {"loads": (REST,)}))
    assert loaded.governing == ""
    assert loaded.as_placed == dropped.as_placed
    assert len(loaded.loaded) == 1


def test_a_plate_whose_clamp_sees_80_mpa_fails(memo):
    """3 mm thick, 80 MPa by beam theory, 45.6 MPa of yield strength: a mean over a ball reads half of it and calls it viable."""
    tets, (length, width, thickness) = box((20, 4, 1), (60.0, 12.0, 3.0)), (60.0, 12.0, 3.0)
    used, faces = np.unique(tets.boundary_faces, return_inverse=True)
    force = 80.0 * width * thickness**2 / 6.0 / length
    bend = LoadCase(
        name="bend",
        supports=(Support(at=Patch(plane=(0, 0, 0, -1, 0, 0))),),
        loads=(Load(at=Patch(plane=(length, 0, 0, 1, 0, 0)), force=(0.0, 0.0, -force)),),
    )
    sim = simulator((SurfaceMesh(tets.vertices[used], faces.reshape(-1, 3)), tets), memo, orientations=1, loads=(bend,))
    verdict = judge_alone(sim.baseline, LIBRARY["PLA"], "robust")
    (told,) = sim.baseline.loaded
    assert verdict.outcome == "FAILS"
    assert not verdict.as_placed.marginal
    assert sim.baseline.governing == "bend"
    assert told.peak == max(told.surface, told.averaged) == pytest.approx(80.0 * 0.95, rel=0.1)
    assert sim.baseline.stress.max() == pytest.approx(told.peak, rel=1e-6)
    assert sim.baseline.as_placed.surface == told.peak


def test_other_loads_are_another_question_and_their_answer_is_remembered(block, memo, drops):
    for loads in ((), (REST,), (PUSH,), (REST,)):
        assert len(simulator(block, memo, loads=loads).simulate(bumps(block), thorough=False).loaded) == len(loads)
    assert drops == [1, 1, 1]


def test_loads_that_cannot_be_solved_are_unknown_never_viable(block, memo, monkeypatch):
    def singular(*_args):
        raise SimulationFailed("the load cases could not be solved")

    sim = simulator(block, memo, loads=(REST,))
    assert sim.judge(sim.baseline).viable
    monkeypatch.setattr(module.StaticTest, "run", singular)
    assert sim.judge(sim.simulate(bumps(block), thorough=False)).outcome == "UNKNOWN"


def test_a_place_that_is_not_there_is_refused_before_the_long_drop(block, memo, drops):
    nowhere = LoadCase(name="nowhere", supports=(Support(at=Patch(sphere=(99, 0, 0, 1))),), loads=(Load(gravity=1.0),))
    with pytest.raises(BadInput, match="'nowhere': sphere"):
        _ = simulator(block, memo, loads=(nowhere,)).baseline
    assert drops == []


def test_loads_keep_their_places_where_the_part_is_meshed_again(block, memo):
    result = simulator(block, memo, orientations=1, loads=(PUSH,)).simulate(ripples(block), thorough=True)
    assert result.meshing == AGAIN
    assert result.governing == "push"


def test_progress_can_cancel_a_drop(block, memo):
    class Enough(Exception):
        pass

    def stop(_fraction):
        raise Enough

    sim = replace(simulator(block, memo), progress=stop)
    with pytest.raises(Enough):
        sim.simulate(bumps(block), thorough=False)
    assert replace(sim, progress=lambda _: None).simulate(bumps(block), thorough=False).stress.any()
