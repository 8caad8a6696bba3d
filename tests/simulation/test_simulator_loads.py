"""Load cases beside the drop: each is a test of its own, and what cannot be solved never passes."""

from __future__ import annotations

import numpy as np
import pytest

from mechstyle.errors import BadInput, SimulationFailed
from mechstyle.records.load_cases import Load, LoadCase, Patch, Support
from mechstyle.records.material import LIBRARY
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.simulation import simulator as module
from mechstyle.simulation.meshes import AGAIN
from support.dropped_block import bumps, ripples, simulator
from validation.meshes import box

PUSH = LoadCase(
    name="push", supports=(Support(at="resting face"),), loads=(Load(at=Patch(plane=(0, 0, 10, 0, 0, 1)), force=(1e3, 0.0, 0.0)),)
)
REST = LoadCase(name="rest", supports=(Support(at="resting face"),), loads=(Load(gravity=1.0),))


def test_drop_and_loads_are_each_a_test_of_its_own(block, memo):
    dropped, loaded = (simulator(block, memo, **settings).baseline for settings in ({}, {"loads": (PUSH, REST)}))
    push, rest = loaded.loads
    assert loaded.landings == dropped.landings
    assert np.array_equal(loaded.landing_stress, dropped.landing_stress)
    assert [case.name for case in loaded.loads] == ["push", "rest"]
    assert push.maximum > rest.maximum > 0.0
    assert (push.permanent_set, rest.permanent_set, rest.place) == (0.0, 0.0, "")
    assert push.factor > 1.0
    assert loaded.load_set.shape == (2, len(dropped.stress), 3)
    assert np.array_equal(loaded.stress, np.maximum(dropped.stress, loaded.load_stress.max(axis=0))), "the part as it stands"
    verdict = simulator(block, memo, loads=(PUSH, REST)).judge(loaded, alone=True)
    assert verdict.outcome == verdict.row(load="push").outcome == verdict.row(load="rest").outcome == "HOLDS"


def arm(size, clamped, stress):
    """An arm along x whose clamp sees a stress [MPa] by beam theory, as a part of tetrahedra and its load."""
    tets, (length, width, thickness) = box(clamped, size), size
    used, faces = np.unique(tets.boundary_faces, return_inverse=True)
    force = stress * width * thickness**2 / 6.0 / length
    bend = LoadCase(
        name="bend",
        supports=(Support(at=Patch(plane=(0, 0, 0, -1, 0, 0))),),
        loads=(Load(at=Patch(plane=(length, 0, 0, 1, 0, 0)), force=(0.0, 0.0, -force)),),
    )
    return (SurfaceMesh(tets.vertices[used], faces.reshape(-1, 3)), tets), bend


@pytest.mark.slow
def test_an_arm_holds_what_bends_it_elastically_and_fails_beyond_its_hinge(memo):
    """A rectangular section carries 1.5 times the moment at which it begins to yield."""
    strength = LIBRARY["PLA"].yield_strength
    for share, outcome in ((0.7, "HOLDS"), (1.8, "FAILS")):
        part, bend = arm((60.0, 12.0, 3.0), (20, 4, 2), share * strength)
        sim = simulator(part, memo, orientations=1, loads=(bend,), element="tet10")
        verdict = sim.judge(sim.baseline, alone=True)
        row = verdict.row(load="bend")
        assert (row.outcome, row.sure) == (outcome, True)
        assert 1.0 < row.carries * share < 1.8, "between first yield and a little more than the hinge, where it stiffens by its slope"
        if outcome == "FAILS":
            assert verdict.deciding is row
            assert row.collapses or row.permanent_set > 0.2
            assert row.place == "low on the left", "at its clamp"


def test_other_loads_and_another_tolerance_are_another_question_and_their_answer_is_remembered(block, memo, drops, monkeypatch):
    solved, real = [], module.StaticTest.loaded

    def counting(self, *args, **options):
        solved.append(tuple(case.name for case in self.cases))
        return real(self, *args, **options)

    monkeypatch.setattr(module.StaticTest, "loaded", counting)
    asked = ({}, {"loads": (REST,)}, {"loads": (PUSH,)}, {"loads": (REST,)}, {"loads": (REST,), "tolerance": 0.1})
    for settings in asked:
        found = simulator(block, memo, **settings).simulate(bumps(block), thorough=False)
        assert len(found.loads) == len(settings.get("loads", ()))
    assert drops == [2, 1], "loads are no reason to drop it again"
    assert solved == [("rest",)] * 2 + [("push",)] * 2 + [("rest",)] * 2, "of the original and of the part"


def test_loads_that_cannot_be_solved_are_unknown_and_never_pass(block, memo, monkeypatch):
    def singular(*_args, **_options):
        raise SimulationFailed("the load cases could not be solved")

    sim = simulator(block, memo, loads=(REST,))
    assert sim.judge(sim.baseline).passes
    monkeypatch.setattr(module.StaticTest, "loaded", singular)
    verdict = sim.judge(sim.simulate(bumps(block), thorough=False))
    assert (verdict.outcome, verdict.failure) == ("UNKNOWN", "the load cases could not be solved")


def test_a_place_that_is_not_there_is_refused_before_the_long_drop(block, memo, drops):
    nowhere = LoadCase(name="nowhere", supports=(Support(at=Patch(sphere=(99, 0, 0, 1))),), loads=(Load(gravity=1.0),))
    with pytest.raises(BadInput, match="'nowhere': sphere"):
        _ = simulator(block, memo, loads=(nowhere,)).baseline
    assert drops == []


def test_loads_keep_their_places_where_the_part_is_meshed_again(block, memo):
    result = simulator(block, memo, orientations=1, loads=(PUSH,)).simulate(ripples(block), thorough=True)
    assert result.meshing == AGAIN
    assert [case.name for case in result.loads] == ["push"]
    assert result.loads[0].maximum > 0.0
