"""The impact on the surface: its field is the verdict's, rigid motion is told from deformation, what was worked out is remembered."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mechstyle.fea.orientations import UP
from mechstyle.fea.snapshots import Snapshots
from mechstyle.fea.stressed_volume import at_nodes
from mechstyle.geometry.transfer import SurfaceMean, Transfer
from mechstyle.loop.objects import Memo, Objects
from mechstyle.records import Recipe
from mechstyle.records.material import LIBRARY
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.simulation import impact as module
from mechstyle.simulation.impact import Impact, impact_of, nearest_rigid
from mechstyle.simulation.part import Workpiece
from validation.meshes import box


@pytest.fixture(scope="module")
def part():
    """A block whose surface is finer than its tetrahedra, so that each way of bringing a field to it gives another one."""
    size = (12.0, 10.0, 16.0)
    fine = box((7, 6, 9), size)
    used, faces = np.unique(fine.boundary_faces, return_inverse=True)
    surface = SurfaceMesh(fine.vertices[used], faces.reshape(-1, 3))
    return Workpiece(surface, box((4, 3, 4), size), np.full(len(used), 10.0, np.float32), stands=True)


@pytest.fixture
def seen(part, monkeypatch):
    """One moment in which stress and displacement vary over the part, in place of a drop; how often it was asked for."""
    rng = np.random.default_rng(0)
    stress, corners = (rng.uniform(1.0, 50.0, (1, len(part.tets.tets), places)).astype(np.float32) for places in (1, 4))
    touched = part.tets.vertices[:, 2] < 1.0
    moved = rng.uniform(-1.0, 1.0, (1, len(part.tets.vertices), 3)).astype(np.float32)
    asked = []

    def moment(*_args, **_options):
        asked.append(1)
        return Snapshots(np.zeros(1), moved, stress, corners, touched)

    monkeypatch.setattr(module, "snapshots", moment)
    return Snapshots(np.zeros(1), moved, stress, corners, touched), asked


@pytest.fixture
def impact(part, seen, tmp_path):
    """Makes the impact of the unstylized part under a recipe with given settings."""
    plain = Recipe.of(surface=part.surface.digest, tetrahedra=part.tets.digest, prompt="", material=LIBRARY["PLA"])
    memo, flat = Memo(tmp_path / "memo", Objects(tmp_path / "objects")), np.zeros(len(part.surface.vertices), np.float32)

    def made(landing=UP, **settings):
        return impact_of(part, plain.with_settings(**settings), flat, memo, normal=landing)

    return made


@pytest.mark.parametrize("transfer", ["barycentric", "nearest"])
def test_stress_comes_to_the_surface_as_that_of_the_verdict_does(part, seen, impact, transfer):
    moment, _ = seen
    nodal = at_nodes(part.tets, moment.corners[0])
    wanted = SurfaceMean(part.surface)(Transfer(part.surface, part.tets, transfer).to_surface(nodal))
    assert np.allclose(impact(transfer=transfer).stress[0], wanted)


def test_the_deformed_surface_is_the_same_whatever_brings_its_stress(impact):
    assert np.array_equal(impact(transfer="nearest").displacement, impact(transfer="barycentric").displacement)


def test_the_floor_is_level_below_whatever_way_it_lands(part, impact):
    """A block that lands on its side: what is below is what was at that side, at the height at which it stood."""
    fallen = replace(impact(), normal=(1.0, 0.0, 0.0), displacement=np.zeros((1, len(part.surface.vertices), 3), np.float32))
    shape = fallen.shape(part.surface, 0)
    assert np.allclose(np.sort(shape.extents), np.sort(part.surface.extents), atol=1e-6)
    side = part.surface.vertices[:, 0] == part.surface.vertices[:, 0].min()
    assert np.allclose(shape.vertices[side, 2], part.surface.vertices[:, 2].min(), atol=1e-6)
    assert shape.extents[2] == pytest.approx(part.surface.extents[0])


def test_each_landing_is_remembered_as_its_own(part, seen, impact):
    _, asked = seen
    first = impact()
    assert first.normal == (0.0, 0.0, 1.0)
    tipped = impact(landing=(0.0, 1.0, 0.0))
    assert (tipped.normal, len(asked)) == ((0.0, 1.0, 0.0), 2)
    assert impact(landing=(0.0, 1.0, 0.0)).normal == (0.0, 1.0, 0.0)
    assert (impact().normal, len(asked)) == ((0.0, 0.0, 1.0), 2)


@pytest.mark.parametrize(("setting", "drops"), [({"transfer": "nearest"}, 2), ({"friction": 0.3}, 2), ({"seed": 7}, 1)])
def test_what_decides_the_physics_is_another_question_and_nothing_else_is(seen, impact, setting, drops):
    _, asked = seen
    impact()
    impact(**setting)
    assert len(asked) == drops


@pytest.fixture
def turned(sphere):
    """The sphere turned, shifted and then stretched along z by 1 %."""
    stretched = sphere.vertices * [1.0, 1.0, 1.01]
    rotation = Rotation.from_rotvec([0.1, -0.2, 0.3])
    return rotation, rotation.apply(stretched) + np.array([3.0, -1.0, 2.0])


def test_a_rigid_motion_is_found_again(sphere):
    moved = Rotation.from_rotvec([0.5, 0.1, -0.7]).apply(np.array(sphere.vertices)) + np.array([1.0, 2.0, 3.0])
    assert np.allclose(nearest_rigid(sphere.vertices, moved), moved, atol=1e-9)


def test_a_mirror_image_is_no_rigid_motion(sphere):
    bent = sphere.vertices * [-1.0, 1.0, 1.2]
    turned = nearest_rigid(sphere.vertices, bent)
    a, b, c, d = (turned[index] - turned.mean(axis=0) for index in (0, 100, 2000, 3000))
    e, f, g, h = (sphere.vertices[index] for index in (0, 100, 2000, 3000))
    assert np.linalg.det([a - d, b - d, c - d]) == pytest.approx(np.linalg.det([e - h, f - h, g - h]), abs=1e-6)


def test_only_the_deformation_is_exaggerated(sphere, turned):
    rotation, moved = turned
    impact = Impact(np.array([0.0]), (moved - sphere.vertices)[None].astype(np.float32), np.zeros((1, len(moved)), np.float32))
    assert np.allclose(impact.shape(sphere, 0, 1.0).vertices, moved, atol=1e-5)
    stretched = rotation.apply(sphere.vertices * [1.0, 1.0, 1.0 + 0.01 * 30]) + np.array([3.0, -1.0, 2.0])
    assert np.allclose(impact.shape(sphere, 0, 30.0).vertices, stretched, atol=0.02)
