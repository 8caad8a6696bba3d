"""The impact of a test: on its own tetrahedra, with its field, ending in the shape that stays; rigid motion is told from deformation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mechstyle.errors import SimulationFailed
from mechstyle.loop.objects import Memo, Objects
from mechstyle.records.mesh import SurfaceMesh, TetMesh
from mechstyle.simulation import impact as module
from mechstyle.simulation import meshes
from mechstyle.simulation.impact import Impact, impact_of, rigid_motion
from support.dropped_block import ripples, simulator


@pytest.fixture(scope="module")
def shared(tmp_path_factory):
    folder = tmp_path_factory.mktemp("impact")
    return Memo(folder / "memo", Objects(folder / "objects"))


@pytest.fixture(scope="module")
def tested(block, shared):
    """A block that lands from 20 m, and its test."""
    dropped = simulator(block, shared, height=2e4)
    return dropped, dropped.baseline


@pytest.fixture(scope="module")
def impact(tested):
    """Of its landing on an edge, where it stays bent."""
    return impact_of(*tested, tested[1].landings[1].name)


def test_it_ends_in_the_shape_that_the_test_found_to_stay(tested, impact):
    """The film of a landing ended somewhere in its ringing, and what the verdict told was nowhere to be seen."""
    dropped, simulation = tested
    edge = simulation.landings[1].name
    bend = simulation.set_of(landing=edge)
    assert np.abs(bend).max() > 0.05, "it yields"
    before = dropped.part.surface.vertices
    wanted = before + bend - nearest(before, before + bend)
    shown = impact.motion(before, impact.end).deformation  # turned with the part
    assert np.linalg.norm(shown, axis=1) == pytest.approx(np.linalg.norm(wanted, axis=1), abs=2e-4)
    assert impact.time[-1] > impact.time[-2]
    assert np.array_equal(impact.stress[-1], simulation.stress_of(landing=edge))


def test_no_moment_has_more_stress_than_the_landing_and_the_peak_is_a_moment_before_rest(tested, impact):
    whole = tested[1].stress_of(landing=tested[1].landings[1].name)
    assert (impact.stress <= whole + 1e-4).all()
    assert impact.stress[:-1].max() == pytest.approx(whole.max(), rel=0.1)
    assert impact.peak < impact.end


def test_it_is_dropped_on_the_tetrahedra_of_its_test(block, shared, monkeypatch):
    """The badge told of other tetrahedra than the film beside it showed."""
    other, seen = TetMesh(block[1].vertices, block[1].tets[::-1]), []
    monkeypatch.setattr(meshes, "mesh_for_relief", lambda shape, *_: (other, np.zeros(len(shape.surface.vertices), np.float32)))
    dropped = simulator(block, shared)
    simulation = dropped.simulate(ripples(block), thorough=True)
    real = module.snapshots
    monkeypatch.setattr(module, "snapshots", lambda tets, *given, **more: seen.append(tets) or real(tets, *given, **more))
    impact_of(dropped, simulation)
    assert simulation.mesh != block[1].digest, "the part was meshed again"
    assert np.array_equal(seen[0].tets, other.tets)
    assert float(seen[0].volumes.sum()) == pytest.approx(simulation.volume)


def test_each_landing_is_remembered_as_its_own(tested, monkeypatch):
    dropped, simulation = tested
    other = simulation.landings[1]
    first, _ = impact_of(dropped, simulation, other.name), impact_of(dropped, simulation)
    assert first.normal == other.normal
    monkeypatch.setattr(module, "snapshots", lambda *_, **__: pytest.fail("it was dropped again"))
    assert impact_of(dropped, simulation, other.name).normal == other.normal
    assert impact_of(dropped, simulation).normal == (0.0, 0.0, 1.0)


def test_what_was_not_tested_has_no_impact(tested):
    dropped, simulation = tested
    with pytest.raises(SimulationFailed, match="there was no landing 'on its nose'"):
        impact_of(dropped, simulation, "on its nose")
    with pytest.raises(SimulationFailed, match="it blew up"):
        impact_of(dropped, replace(simulation, landings=(), **_without_fields(), failure="it blew up"))
    with pytest.raises(SimulationFailed, match="are gone: test the part again"):
        impact_of(dropped, replace(simulation, mesh="0" * 64))


def _without_fields():
    nothing = np.zeros((0, 0), np.float32)
    return {f"landing_{what}": nothing for what in ("stress", "strain", "set")}


def test_the_floor_is_level_below_whatever_way_it_lands(tested, impact):
    """A block that lands on its side: what is below is what was at that side, at the height at which it stood."""
    surface: SurfaceMesh = tested[0].part.surface
    fallen = replace(impact, normal=(1.0, 0.0, 0.0), displacement=np.zeros((1, len(surface.vertices), 3), np.float32))
    shape = fallen.shape(surface, 0)
    assert np.allclose(np.sort(shape.extents), np.sort(surface.extents), atol=1e-6)
    side = surface.vertices[:, 0] == surface.vertices[:, 0].min()
    assert np.allclose(shape.vertices[side, 2], surface.vertices[:, 2].min(), atol=1e-6)
    assert shape.extents[2] == pytest.approx(surface.extents[0])


@pytest.fixture
def turned(sphere):
    """The sphere turned, shifted and then stretched along z by 1 %."""
    stretched = sphere.vertices * [1.0, 1.0, 1.01]
    rotation = Rotation.from_rotvec([0.1, -0.2, 0.3])
    return rotation, rotation.apply(stretched) + np.array([3.0, -1.0, 2.0])


def nearest(points, moved):
    """Points as they lie after the motion as a whole that brings them nearest to others."""
    turn, shift = rigid_motion(points, moved)
    return points @ turn.T + shift


def test_a_rigid_motion_is_found_again(sphere):
    moved = Rotation.from_rotvec([0.5, 0.1, -0.7]).apply(np.array(sphere.vertices)) + np.array([1.0, 2.0, 3.0])
    assert np.allclose(nearest(sphere.vertices, moved), moved, atol=1e-9)


def test_a_mirror_image_is_no_rigid_motion(sphere):
    bent = sphere.vertices * [-1.0, 1.0, 1.2]
    turned = nearest(sphere.vertices, bent)
    a, b, c, d = (turned[index] - turned.mean(axis=0) for index in (0, 100, 2000, 3000))
    e, f, g, h = (sphere.vertices[index] for index in (0, 100, 2000, 3000))
    assert np.linalg.det([a - d, b - d, c - d]) == pytest.approx(np.linalg.det([e - h, f - h, g - h]), abs=1e-6)


def test_only_the_deformation_is_exaggerated(sphere, turned):
    rotation, moved = turned
    impact = Impact(np.array([0.0]), (moved - sphere.vertices)[None].astype(np.float32), np.zeros((1, len(moved)), np.float32))
    assert np.allclose(impact.shape(sphere, 0, 1.0).vertices, moved, atol=1e-5)
    stretched = rotation.apply(sphere.vertices * [1.0, 1.0, 1.0 + 0.01 * 30]) + np.array([3.0, -1.0, 2.0])
    assert np.allclose(impact.shape(sphere, 0, 30.0).vertices, stretched, atol=0.02)
