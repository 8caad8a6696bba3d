"""How tetrahedra follow a part, and how much of a relief over its original they carry."""

from __future__ import annotations

import numpy as np
import pytest

from mechstyle.geometry.level_base import LevelBase
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.simulation.beside_original import fit_of, other_part
from mechstyle.simulation.validation.meshes import box


@pytest.fixture(scope="module")
def block():
    """Tetrahedra of a 12 x 10 x 16 mm block, and the places of their vertices on its surface."""
    tets = box((30, 25, 16), (12.0, 10.0, 16.0))
    used, faces = np.unique(tets.boundary_faces, return_inverse=True)
    return tets, SurfaceMesh(tets.vertices[used], faces.reshape(-1, 3)), used


def waves(surface):
    x, y, z = surface.vertices.T
    return (0.3 * np.sin(x) * np.cos(y) * np.sin(z + 1.0) - 0.1).astype(np.float32)


def followed(block, surface):
    """The tetrahedra with their boundary on another surface of the same triangles."""
    tets, _, used = block
    vertices = tets.vertices.copy()
    vertices[used] = surface.vertices
    return tets.moved(vertices)


def test_a_part_that_is_its_original_has_no_relief(block):
    tets, plain, _ = block
    fit = fit_of(tets, plain, plain)
    assert (fit.mean, fit.most, fit.volume) == pytest.approx((0.0, 0.0, 0.0), abs=1e-5)
    assert (fit.relief.lowest, fit.relief.highest) == pytest.approx((0.0, 0.0), abs=1e-5)
    assert (fit.relief.carried, fit.relief.carried_base) == (1.0, None)


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_the_share_of_a_relief_that_is_carried_is_found(block, share):
    _, plain, _ = block
    part = plain.displaced(waves(plain))
    fit = fit_of(followed(block, plain.displaced(share * waves(plain))), part, plain)
    assert fit.relief.carried == pytest.approx(share, abs=0.05)
    assert fit.relief.carried_base == pytest.approx(share, abs=0.05)
    assert fit.relief.lowest == pytest.approx(waves(plain).min(), abs=0.05)
    assert fit.relief.highest == pytest.approx(waves(plain).max(), abs=0.05)
    assert (fit.most < 1e-4) == (share == 1.0)


def test_what_moves_as_a_whole_under_a_part_is_no_relief_that_could_be_lost(block):
    """A relief is drawn inwards there until the part stands level."""
    _, plain, _ = block
    drawn_in = plain.displaced((waves(plain) - 0.3 * LevelBase(plain).resting).astype(np.float32))
    fit = fit_of(followed(block, plain.displaced(waves(plain))), drawn_in, plain)
    assert fit.relief.carried_base == pytest.approx(1.0, abs=0.2)  # 0.33 with the shift; what is missing is at its rim


def test_a_base_laid_flat_has_no_relief_whatever_the_tetrahedra_make_of_it(block):
    """717 % of what was left under a part were once carried: thousandths of a millimetre, beside which triangles lay a tenth inside."""
    _, plain, _ = block
    above = plain.vertices[:, 2] > plain.vertices[:, 2].min() + 1e-6
    part = plain.displaced((waves(plain) * np.where(above, 1.0, 0.004)).astype(np.float32))
    fit = fit_of(followed(block, plain.displaced(waves(plain))), part, plain)
    assert fit.relief.carried_base is None
    assert fit.relief.carried > 0.8


def test_a_small_deep_mark_under_a_part_that_is_lost_is_not_overlooked(block):
    """Averaged over all of the base it is less than a hundredth of a millimetre."""
    _, plain, _ = block
    mark = np.zeros(len(plain.vertices), np.float32)
    mark[np.linalg.norm(plain.vertices - [6.0, 5.2, plain.vertices[:, 2].min()], axis=1).argmin()] = -0.2
    assert fit_of(followed(block, plain), plain.displaced(mark), plain).relief.carried_base == pytest.approx(0.0, abs=0.05)


def test_without_an_original_nothing_is_told_of_a_relief(block):
    tets, plain, _ = block
    fit = fit_of(tets, plain.displaced(np.full(len(plain.vertices), 0.2, np.float32)))
    assert fit.relief is None
    assert fit.mean == pytest.approx(0.2, abs=0.05)
    assert "0.2" in fit.words
    assert fit.volume < -0.05


@pytest.mark.parametrize(
    ("stretch", "shift", "told"),
    [
        ((1.0, 1.0, 1.0), 0.0, ""),
        ((1.3, 1.3, 1.3), 0.0, ""),
        ((1.0, 1.0, 3.0), 0.0, "different parts"),
        ((1.0, 1.0, 1 / 3), 0.0, "different parts"),
        ((1.0, 1.0, 1.0), 25.0, "do not stand in the same place"),
        ((1.0, 1.0, 1.0), 3.0, ""),
    ],
)
def test_what_cannot_be_the_original_is_told(cube, stretch, shift, told):
    part = cube.moved(cube.vertices * 20.0 / cube.extents)
    warning = other_part(part, part.moved(part.vertices * stretch + (shift, 0.0, 0.0)))
    assert (told in warning) if told else warning == ""


def test_a_thin_plate_under_a_deep_relief_is_still_its_own_original(cube):
    plate = cube.moved(cube.vertices * (60.0, 60.0, 1.2) / cube.extents)
    assert other_part(plate.moved(plate.vertices * (1.0, 1.0, 5.0)), plate) == ""
