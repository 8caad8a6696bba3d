"""Load cases beside the drop: each is a test of its own, and what cannot be solved never passes."""

from __future__ import annotations

import numpy as np
import pytest

from mechstyle.errors import BadInput, SimulationFailed
from mechstyle.fea.statics import StaticTest
from mechstyle.fea.stressed_volume import at_nodes, exceeded
from mechstyle.records.load_cases import Load, LoadCase, Patch, Support
from mechstyle.records.material import LIBRARY
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.simulation import simulator as module
from mechstyle.simulation.meshes import AGAIN
from support.dropped_block import bumps, ripples, simulator
from validation.meshes import box

PUSH = LoadCase(
    name="push", supports=(Support(at="resting face"),), loads=(Load(at=Patch(plane=(0, 0, 10, 0, 0, 1)), force=(3e4, 0.0, 0.0)),)
)
REST = LoadCase(name="rest", supports=(Support(at="resting face"),), loads=(Load(gravity=1.0),))


def test_drop_and_loads_are_each_a_test_of_its_own(block, memo):
    dropped, loaded = (simulator(block, memo, **settings).baseline for settings in ({}, {"loads": (PUSH, REST)}))
    push, rest = loaded.loads
    assert loaded.landings == dropped.landings
    assert np.array_equal(loaded.landing_stress, dropped.landing_stress)
    assert [case.name for case in loaded.loads] == ["push", "rest"]
    assert push.stress > dropped.flat.stress > rest.stress > 0.0
    assert push.maximum > push.stress
    assert loaded.load_stress.shape == (2, len(dropped.stress))
    assert np.array_equal(loaded.stress, np.maximum(dropped.stress, loaded.load_stress.max(axis=0))), "the part as it stands"
    for case, stress in zip(loaded.loads, loaded.load_stress, strict=True):
        assert 0.0 < stress.max() < 1.2 * case.maximum, "values at corners are a little above those inside"
    verdict = simulator(block, memo, loads=(PUSH, REST)).judge(loaded, alone=True)
    assert verdict.outcome == "FAILS"
    assert verdict.deciding.load == "push"
    assert verdict.row("flat").outcome == verdict.row("load", "rest").outcome == "HOLDS"


def test_the_stress_of_a_load_is_what_a_cube_of_2_mm_exceeds(block, memo):
    push = simulator(block, memo, loads=(PUSH,)).baseline.loads[0]
    response = StaticTest(block[1], (PUSH,), "tet10").run(block[1], LIBRARY["PLA"])["push"]
    read = exceeded(block[1], at_nodes(block[1], response.corners), 1.0, 8.0)
    assert (push.stress, push.where) == (pytest.approx(read.stress), pytest.approx(read.where))


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


def test_a_plate_whose_clamp_sees_80_mpa_fails_and_one_of_35_holds(memo):
    """3 mm thick, 45.6 MPa of yield strength: a mean over a ball reads half of it and lets it pass."""
    for stress, outcome in ((80.0, "FAILS"), (35.0, "HOLDS")):
        part, bend = arm((60.0, 12.0, 3.0), (20, 4, 1), stress)
        sim = simulator(part, memo, orientations=1, loads=(bend,))
        row = sim.judge(sim.baseline, alone=True).row("load", "bend")
        assert (row.outcome, row.sure) == (outcome, True)
        assert 0.8 * stress < row.stress < stress
        assert row.factor == pytest.approx(LIBRARY["PLA"].yield_strength / row.stress)


def test_other_loads_are_another_question_and_their_answer_is_remembered(block, memo, drops):
    for loads in ((), (REST,), (PUSH,), (REST,)):
        assert len(simulator(block, memo, loads=loads).simulate(bumps(block), thorough=False).loads) == len(loads)
    assert drops == [2, 1] * 3


def test_loads_that_cannot_be_solved_are_unknown_and_never_pass(block, memo, monkeypatch):
    def singular(*_args):
        raise SimulationFailed("the load cases could not be solved")

    sim = simulator(block, memo, loads=(REST,))
    assert sim.judge(sim.baseline).passes
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
    assert [case.name for case in result.loads] == ["push"]
    assert result.loads[0].stress > 0.0
