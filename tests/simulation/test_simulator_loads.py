"""Load cases beside the drop: the worse of both drives and decides, and what cannot be solved is never viable."""

from __future__ import annotations

import numpy as np
import pytest

from mechstyle.errors import BadInput, SimulationFailed
from mechstyle.records.load_cases import Load, LoadCase, Patch, Support
from mechstyle.records.material import LIBRARY
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.simulation import simulator as module
from mechstyle.simulation.carrying import AGAIN
from mechstyle.simulation.part_test import judge_alone
from mechstyle.simulation.validation.meshes import box
from support.dropped_block import bumps, ripples, simulator

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
    assert 0.75 * push.peak < loaded.stress.max() <= 1.00001 * push.peak  # the surface's vertices lie between those of the tetrahedra
    assert np.all(loaded.envelope >= dropped.envelope)
    assert loaded.overall == dropped.overall


def test_drop_and_loads_are_kept_each_by_itself(block, memo):
    """As each is judged by what the original does in that very test, also where the record is read again."""
    dropped = simulator(block, memo).baseline
    simulator(block, memo, loads=(PUSH, REST)).baseline  # noqa: B018 — remembered
    loaded = simulator(block, memo, loads=(PUSH, REST)).baseline
    assert loaded.drop == dropped.as_placed == loaded.landings[0].measures
    assert np.array_equal(loaded.drop_stress, dropped.stress)
    assert loaded.loaded_stress.shape == (2, len(dropped.stress))
    assert np.array_equal(loaded.stress, np.maximum(dropped.stress, loaded.loaded_stress.max(axis=0)))
    for case in loaded.loaded:
        assert case.measures.peak == case.peak
        assert loaded.load(case.name) == case.measures
        assert 0.75 * case.peak < loaded.load_stress(case.name).max() <= 1.00001 * case.peak


def test_a_drop_that_is_worse_than_its_loads_stays_as_it_is(block, memo):
    dropped, loaded = (simulator(block, memo, **settings).baseline for settings in ({}, {"loads": (REST,)}))
    assert loaded.governing == ""
    assert loaded.as_placed == loaded.drop == dropped.as_placed
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


def test_a_short_arm_of_long_elements_is_not_sure_to_hold(memo):
    """The unsafe side: 15 mm long and of elements of 5 mm, it read 31 MPa of the 48 at its clamp, and was VIABLE without a word."""
    tets, (length, width, thickness) = box((3, 2, 1), (15.0, 9.0, 4.0)), (15.0, 9.0, 4.0)
    used, faces = np.unique(tets.boundary_faces, return_inverse=True)
    arm = LoadCase(
        name="arm",
        supports=(Support(at=Patch(plane=(0, 0, 0, -1, 0, 0))),),
        loads=(Load(at=Patch(plane=(length, 0, 0, 1, 0, 0)), force=(0.0, 0.0, -48.0 * width * thickness**2 / 6.0 / length)),),
    )
    sim = simulator((SurfaceMesh(tets.vertices[used], faces.reshape(-1, 3)), tets), memo, orientations=1, loads=(arm,))
    (told,) = sim.baseline.loaded
    assert told.peak < 0.75 * LIBRARY["PLA"].yield_strength < told.border
    verdict = judge_alone(sim.baseline, LIBRARY["PLA"], "robust")
    assert (verdict.outcome, verdict.marginal) == ("VIABLE", True)
    assert "and under the load 'arm' elements where a support or load ends are too long to read its stress there" in verdict.words


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
