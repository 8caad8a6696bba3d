"""What decides a drop: all of it is in the names its results are remembered under, and the period of the part ends an impact."""

from __future__ import annotations

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from mechstyle.loop.objects import Memo, Memos, Objects
from mechstyle.records.material import LIBRARY
from mechstyle.simulation import physics as physics_module
from mechstyle.simulation.physics import memo_key, physics, prescribed
from support.dropped_block import bumps, discretised, simulator
from support.records import recipe

NOTHING = np.zeros(3, np.float32)
SETTINGS = {
    "height": 1000.0, "friction": 0.3, "window": 0.12, "damping": 0.2, "element": "tet4", "transfer": "nearest",
    "material": LIBRARY["PETG"], "build_direction": (0.0, 0.0, 1.0), "criterion": "paper",
}  # fmt: skip
OTHERS = {name: recipe().with_settings(**{name: value}) for name, value in SETTINGS.items()}
FIGURES = ("yield_strength", "hardening", "elongation")
OTHERS |= {
    name: recipe(material=msgspec.structs.replace(LIBRARY["PLA"], **{name: 1.1 * getattr(LIBRARY["PLA"], name)})) for name in FIGURES
}
OTHERS |= {name: recipe().on(**{name: "6" * 64}) for name in ("surface", "tetrahedra")}


@pytest.mark.parametrize("name", OTHERS)
def test_another_test_is_never_answered_with_what_is_remembered_of_this_one(name):
    """The unsafe side: a setting that is missing from the name gives the answer to another question."""
    assert memo_key(physics(recipe()), NOTHING) != memo_key(physics(OTHERS[name]), NOTHING)


def test_whatever_changes_the_test_that_is_prescribed_is_in_its_name():
    usual = recipe()
    for name, other in OTHERS.items():
        assert prescribed(other) == prescribed(usual) or physics(other) != physics(usual), name
    test = prescribed(usual.with_settings(height=1000.0, friction=0.3, damping=0.2, element="tet4"))
    assert (test.height, test.friction, test.damping, test.element, test.plastic) == (1000.0, 0.3, 0.2, "tet4", True)
    assert not prescribed(recipe(criterion="paper")).plastic


def test_the_floor_is_soft_by_the_published_rule_alone_and_in_the_name():
    """The unsafe side: on a floor that gives way a part bears less, so no other criterion may ever have one."""
    soft = {"contact_stiffness": 300.0}
    assert prescribed(recipe(criterion="paper", **soft)).contact_stiffness == 300.0
    assert prescribed(recipe(**soft)).contact_stiffness == prescribed(recipe(criterion="paper")).contact_stiffness == 0.0
    assert physics(recipe(criterion="paper", **soft)) != physics(recipe(criterion="paper"))
    assert physics(recipe(**soft)) == physics(recipe())


def test_another_relief_has_another_name_and_the_same_has_the_same():
    inputs, relief = physics(recipe()), np.linspace(0.0, 1.0, 3, dtype=np.float32)
    assert memo_key(inputs, relief) == memo_key(inputs, relief.astype(np.float64))
    assert len({memo_key(inputs, each) for each in (relief, relief[::-1], 2 * relief, NOTHING)}) == 4


def test_without_a_window_the_impact_ends_by_the_period_of_the_unstylized_part(block, memo, tmp_path, monkeypatch):
    asked, real = [], physics_module.lowest_period

    def counting(body):
        asked.append(len(body.volumes))
        return real(body)

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
    assert physics_module.period_of(lambda: block[1], sim.recipe, Memos((shared,))) == real(discretised(block))
    simulator(block, memo).simulate(bumps(block), thorough=False)
    assert len(asked) == 1, "a window needs no period"


def test_a_forged_period_of_a_run_folder_stays_in_that_folder(block, memo, tmp_path):
    stranger, users = (Memo(tmp_path / name, Objects(tmp_path / f"{name}-objects")) for name in ("stranger", "users"))
    sim = simulator(block, memo, window=None, element="tet4")
    honest = physics_module.period_of(lambda: block[1], sim.recipe, Memos((memo,)))
    (key,) = [path.name for path in memo.folder.iterdir()]
    stranger.remember(key, 10.0 * honest)
    assert physics_module.period_of(lambda: block[1], sim.recipe, Memos((users, stranger))) == 10.0 * honest
    assert not users.folder.exists()
    users.remember(key, honest)
    assert physics_module.period_of(lambda: block[1], sim.recipe, Memos((users, stranger))) == honest
