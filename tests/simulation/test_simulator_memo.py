"""What is simulated once and remembered, what is another question, and whom the answers of others may convince."""

from __future__ import annotations

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from mechstyle.loop.objects import Memo, Objects
from mechstyle.records.material import LIBRARY
from support.dropped_block import bumps, simulator


def test_the_same_question_is_simulated_once(block, memo, drops):
    sim = simulator(block, memo)
    first = sim.simulate(bumps(block), thorough=False)
    second = simulator(block, memo).simulate(bumps(block), thorough=False)
    assert drops == [2, 1], "the original, which says in which landings to test, and the part"
    assert np.array_equal(first.stress, second.stress)
    assert first.landings == second.landings


@pytest.mark.parametrize(
    "settings",
    [
        {"window": 0.12},
        {"height": 1000.0},
        {"damping": 0.2},
        {"friction": 0.3},
        {"material": msgspec.structs.replace(LIBRARY["PLA"], youngs_modulus=2000.0)},
    ],
)
def test_anything_that_matters_makes_it_another_question(block, memo, drops, settings):
    sim = simulator(block, memo)
    sim.simulate(bumps(block), thorough=False)
    replace(sim, recipe=sim.recipe.with_settings(**settings)).simulate(bumps(block), thorough=False)
    assert drops == [2, 1, 2, 1]


def test_what_does_not_matter_does_not(block, memo, drops):
    for settings in ({}, {"control": "linear"}, {"schedule": "never"}, {"iterations": 3}, {"seed": 7}, {"tolerance": 0.5}):
        simulator(block, memo, **settings).simulate(bumps(block), thorough=False)
    assert drops == [2, 1]


def test_the_baseline_is_shared_between_runs(block, memo, tmp_path, drops):
    shared = Memo(tmp_path / "shared", Objects(tmp_path / "shared-objects"))
    for name in ("a", "b"):
        own = Memo(tmp_path / name, Objects(tmp_path / f"{name}-objects"))
        assert replace(simulator(block, own), shared=shared).baseline.stress.any()
    assert drops == [2]


def forged(sim, memo, block):
    """Remembers in a folder, as a stranger could have written it, that nothing stays bent of a landing; what its landing is then."""
    body, normal = sim.meshes.first, sim.landings.normals[0].tolist()
    morphed = body.morph.morphed(np.zeros(len(block[0].vertices), np.float32))
    honest = sim._landed(body, morphed, [0])[0]
    lie = replace(honest, landing=msgspec.structs.replace(honest.landing, maximum=0.1 * honest.landing.maximum))
    memo.remember(sim._key("landing", body, morphed, normal), lie)
    return lie.landing


def test_a_forged_landing_of_a_run_folder_stays_in_that_folder(block, memo, tmp_path):
    stranger, users = (Memo(tmp_path / name, Objects(tmp_path / f"{name}-objects")) for name in ("stranger", "users"))
    lie = forged(simulator(block, memo), stranger, block)
    sim = replace(simulator(block, stranger), shared=users)
    assert sim.baseline.flat == lie  # the folder is believed about itself
    own = replace(simulator(block, Memo(tmp_path / "own", memo.objects)), shared=users)
    assert own.baseline.flat != lie
    assert own.baseline.landings[1] == sim.baseline.landings[1]


def test_what_the_user_computed_before_is_believed_rather_than_a_run_folder(block, memo, tmp_path):
    stranger, users = (Memo(tmp_path / name, Objects(tmp_path / f"{name}-objects")) for name in ("stranger", "users"))
    honest = replace(simulator(block, memo), shared=users).baseline
    lie = forged(simulator(block, Memo(tmp_path / "third", memo.objects)), stranger, block)
    assert replace(simulator(block, stranger), shared=users).baseline.flat == honest.flat != lie


def test_the_baseline_of_a_part_that_is_not_the_one_its_recipe_names_is_for_itself(block, memo, tmp_path):
    """A run folder could hold a sturdy part under the recipe of another one."""
    users = Memo(tmp_path / "users", Objects(tmp_path / "users-objects"))
    sim = simulator(block, memo)
    claimed = replace(sim, shared=users, recipe=sim.recipe.on(surface="5" * 64))
    assert claimed.baseline.stress.any()
    assert not users.folder.exists()


def test_what_is_remembered_for_others_bears_the_name_of_the_tetrahedra_it_is_of(block, memo, tmp_path, drops):
    """The unsafe side: sturdy tetrahedra under a name that an honest run asks for."""
    users = Memo(tmp_path / "users", Objects(tmp_path / "users-objects"))
    sim = simulator(block, memo)
    claimed = replace(sim, shared=users, part=replace(sim.part, tets=block[1].moved(block[1].vertices * (1.0, 1.0, 2.0))))
    assert claimed.baseline.mesh != block[1].digest
    honest = replace(simulator(block, Memo(tmp_path / "own", memo.objects)), shared=users).baseline
    assert honest.mesh == block[1].digest
    assert len(drops) == 2
