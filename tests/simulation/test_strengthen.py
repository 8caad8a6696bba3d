"""Thickening: where it yields and nowhere else, within the budget, and told in grams and mm. The bend is a known function of walls."""

import re

import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.fea.drop import resolve_device
from mechstyle.gallery import make
from mechstyle.geometry.region_selection import selected
from mechstyle.records.material import LIBRARY
from mechstyle.records.regions import region
from mechstyle.runs.recipes import changed, recipe_for
from mechstyle.simulation import strengthen as module
from mechstyle.simulation.part import Workpiece, standardised
from mechstyle.simulation.strengthen import strengthened
from support.lanes import CORNER
from support.records import landing, simulation

YIELD = LIBRARY["PLA"].yield_strength


class Bent:
    """Stands in for the drop: a bar bent around its middle, σ ∝ 1 / t²; it yields from .9 on, .2 mm · (σ over strength)⁴ stays bent."""

    load = 1.5

    def __init__(self, part, *_, **__):
        self.surface = part.surface

    def simulate(self, displacement, **_):
        along = self.surface.vertices[:, 0] / np.ptp(self.surface.vertices[:, 0])
        stress = (self.load * YIELD * np.exp(-((along / 0.2) ** 2)) * (4.0 / (4.0 + 2.0 * displacement.max())) ** 2).astype(np.float32)
        over = stress / YIELD
        strain, bend = np.where(over > 0.9, 0.0025 + 0.01 * (over - 0.9), 0.0), 0.2 * over**4
        flat = landing(permanent_set=float(bend.max()), plastic_strain=float(strain.max()), maximum=2.0 * float(stress.max()))
        return simulation(
            displacement=displacement, contact=np.zeros(len(stress), bool), landings=(flat,), landing_stress=stress[None],
            landing_strain=strain[None], landing_set=bend[None, :, None] * np.array([0.0, 0.0, -1.0]), loads=(),
            load_stress=np.zeros((0, len(stress))), failure="",
        )  # fmt: skip


@pytest.fixture(scope="module")
def part():
    mesh = standardised(make("cable_winder"), 1500)
    return Workpiece(mesh, CORNER, np.full(len(mesh.vertices), 4.0, np.float32), stands=True)


@pytest.fixture
def bent(monkeypatch):
    monkeypatch.setattr(module, "DropSimulator", Bent)
    return monkeypatch


def strengthen(part, budget, **settings):
    return strengthened(part, recipe_for("brick", strengthen=budget, **settings), device=resolve_device("cpu"))


def test_what_does_not_hold_is_thickened_until_it_does(bent, part):
    found = strengthen(part, 2.0)
    assert [verdict.outcome for verdict in found.verdicts] == ["FAILS", "HOLDS"]
    assert 0 < found.added.max() <= 2.0
    assert found.added.max() > 0.5 * 4.0 * (np.sqrt(1.5) - 1.0)  # what bending asks for, half on each side
    assert found.mass_gained == pytest.approx((found.surface.volume - part.surface.volume) * LIBRARY["PLA"].density)
    assert found.mass_gained > 0.0
    assert f"{found.mass_gained:.1f} g" in found.words
    assert re.search(r"flat: \d\.\d\d mm, then flat: 0\.1\d mm: it holds$", found.words)


def test_a_part_that_only_just_holds_is_thickened_on(bent, part):
    """On other tetrahedra, which its style will have, it may read a tenth more and not hold."""
    bent.setattr(Bent, "load", 1.41)
    found = strengthen(part, 0.8)
    assert found.rounds > 1
    assert (found.verdicts[1].outcome, found.verdicts[1].sure) == ("HOLDS", True)


def test_what_only_just_holds_when_the_budget_is_spent_says_so(bent, part):
    bent.setattr(Bent, "load", 1.41)
    found = strengthen(part, 0.4)
    assert (found.verdicts[1].outcome, found.verdicts[1].sure) == ("HOLDS", False)
    assert "it only just holds, within 0.4 mm" in found.words


def test_nothing_is_added_far_from_what_is_overloaded_or_to_what_it_stands_on(bent, part):
    found = strengthen(part, 2.0)
    far = np.abs(part.surface.vertices[:, 0]) > 38.0
    assert not found.added[far].any()
    assert not found.added[part.surface.vertices[:, 2] < 0.5].any()
    assert (found.added >= 0.0).all()


def test_a_protected_region_keeps_its_shape(bent, part):
    where = region("back 12")
    found = strengthen(part, 2.0, protect=[where])
    held = selected(where, part.surface, part.thickness)
    assert not found.added[held].any()
    assert found.added[~held].any()


def test_the_budget_is_the_end_of_it(bent, part):
    bent.setattr(Bent, "load", 9.0)
    found = strengthen(part, 0.3)
    assert found.added.max() == pytest.approx(0.3)
    assert found.verdicts[1].outcome == "FAILS"
    assert "still does not hold within 0.3 mm" in found.words


def test_what_holds_stays_as_it_is(bent, part):
    bent.setattr(Bent, "load", 0.8)
    found = strengthen(part, 2.0)
    assert not found.added.any()
    assert found.rounds == 0
    assert found.result is part
    assert "it holds as it is" in found.words


def test_a_budget_is_a_length_and_a_branch_has_none():
    with pytest.raises(BadInput, match="strengthen is 30"):
        recipe_for("brick", strengthen=30.0)
    with pytest.raises(BadInput, match="before its style"):
        changed(recipe_for("brick"), {"strengthen": 1.0})


def test_whoever_no_longer_waits_ends_it_in_a_drop_as_before_one(monkeypatch, part):
    """Seven drops and a meshing may be minutes; the Studio's Stop has to reach into them."""
    asked = []

    class Asking(Bent):
        def __init__(self, part, *given, **more):
            super().__init__(part, *given, **more)
            self.progress = given[4]

        def simulate(self, displacement, **how):
            self.progress(0.5)
            return super().simulate(displacement, **how)

    def go_on():
        asked.append(len(asked))
        if len(asked) == 2:
            raise InterruptedError

    monkeypatch.setattr(module, "DropSimulator", Asking)
    with pytest.raises(InterruptedError):
        strengthened(part, recipe_for("brick", strengthen=2.0), device="cpu", go_on=go_on)
    assert len(asked) == 2


def test_a_part_is_prepared_by_what_the_caller_prepares_with(bent, part):
    """A kernel prepares in another process, because remeshing holds the interpreter."""
    asked = []

    def prepared(_mesh, *, vertices, stage, go_on):
        asked.append(vertices)
        go_on()
        return part

    strengthened(make("cable_winder"), recipe_for("brick", strengthen=2.0), vertices=1500, device="cpu", prepare=prepared)
    assert asked == [1500]
