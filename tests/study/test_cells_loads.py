"""Loads scaled to what the plain part carries: in proportion, once for all runs of a study, and the same for each."""

from types import SimpleNamespace

import numpy as np
import pytest

from mechstyle.fea.statics import StaticTest
from mechstyle.gallery import make
from mechstyle.records.load_cases import Load, LoadCase, Patch, Support
from mechstyle.runs.recipes import draft
from mechstyle.simulation.part import prepare
from mechstyle.study import cells as module
from mechstyle.study.cells import scaled, with_loads, words_of
from support.knob import knob
from support.records import load_result

PULLED = LoadCase(
    name="pulled",
    supports=(Support(at="resting face"),),
    loads=(Load(at=Patch(sphere=(0, 0, 9, 4)), force=(3.0, 0.0, -4.0)), Load(gravity=2.0)),
)


def test_every_load_of_a_case_is_multiplied_and_its_place_is_kept():
    pressed = LoadCase(name="pressed", supports=PULLED.supports, loads=(Load(at="resting face", pressure=0.5),))
    assert scaled(PULLED, 2.0).loads == (Load(at=PULLED.loads[0].at, force=(6.0, 0.0, -8.0)), Load(gravity=4.0))
    assert scaled(pressed, 3.0).loads[0].pressure == 1.5
    assert scaled(PULLED, 2.0).supports == PULLED.supports


def test_a_case_is_named_with_its_size():
    assert words_of(PULLED) == "pulled, 5 N, 2 × its weight"
    assert words_of(scaled(PULLED, 140.6)) == "pulled, 703 N, 281 × its weight"


@pytest.fixture
def factors(monkeypatch):
    """A plain part that carries a hundred times the case, and how often it was asked."""
    asked = []

    def load_factors(recipe, model, vertices):
        asked.append(vertices)
        return {case.name: 100.0 for case in recipe.test.loads}

    monkeypatch.setattr(module, "load_factors", load_factors)
    return asked


def test_what_the_plain_part_carries_is_worked_out_once_for_each_case_material_and_resolution(factors, tmp_path):
    model, recipe = make("coaster"), draft("brick", loads=[PULLED])
    found = with_loads(recipe, model, 900, share=0.85, folder=tmp_path)
    assert found.test.loads[0].loads[0].force == pytest.approx((255.0, 0.0, -340.0))
    assert [name for name, *_ in found.differences(recipe)] == ["loads"]
    assert with_loads(draft("stone", loads=[PULLED]), model, 900, share=0.85, folder=tmp_path).test.loads == found.test.loads
    assert factors == [900]
    for asked in (draft("brick", "PETG", loads=[PULLED]), draft("brick", loads=[scaled(PULLED, 2.0)])):
        with_loads(asked, model, 900, share=0.85, folder=tmp_path)
    with_loads(recipe, model, 1200, share=0.85, folder=tmp_path)
    assert factors == [900, 900, 900, 1200]


def test_a_file_that_a_killed_writer_broke_is_made_again(factors, tmp_path):
    model, recipe = make("coaster"), draft("brick", loads=[PULLED])
    found = with_loads(recipe, model, 900, share=0.85, folder=tmp_path)
    (path,) = tmp_path.glob("*.json")
    path.write_bytes(path.read_bytes()[:10])
    assert with_loads(recipe, model, 900, share=0.85, folder=tmp_path) == found
    assert len(factors) == 2


def test_a_load_is_raised_until_the_plain_part_gives_way(monkeypatch):
    """What a test follows ends at a multiple of the load that it is given."""

    class Tested:
        def __init__(self, _tets, cases, _element):
            self.case = cases[0]

        def loaded(self, *_, tolerance, **__):
            assert tolerance == 0.2
            carries = 50.0 / np.hypot(*self.case.loads[0].force[::2])
            return {self.case.name: SimpleNamespace(result=load_result(factor=min(carries, 3.0), reached=carries <= 3.0))}

    monkeypatch.setattr(module, "StaticTest", Tested)
    monkeypatch.setattr(module, "prepare", lambda *_, **__: SimpleNamespace(tets=None))
    assert module.load_factors(draft("brick", loads=[PULLED]), None, 900) == {"pulled": pytest.approx(10.0)}


@pytest.mark.slow
def test_under_the_scaled_load_as_much_stays_bent_of_the_plain_part_as_the_tolerance(tmp_path):
    model, side = knob(), Load(at=Patch(sphere=(20, 0, 15, 6)), force=(3.0, 0.0, -4.0))
    recipe = draft("brick", loads=[LoadCase(name="pulled", supports=PULLED.supports, loads=(side,))])
    part = prepare(model)
    for share, within in ((0.9, True), (1.1, False)):
        found = with_loads(recipe, model, len(model.vertices), share=share, folder=tmp_path)
        tested = StaticTest(part.tets, found.test.loads, found.test.element)
        (case,) = tested.loaded(part.tets, found.test.material, tolerance=recipe.test.tolerance).values()
        assert (case.result.permanent_set <= recipe.test.tolerance) is within
