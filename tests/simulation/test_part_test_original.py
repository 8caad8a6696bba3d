"""A styled file read as its original with a relief, and how tetrahedra follow a part as it was given."""

from __future__ import annotations

import numpy as np
import pytest
from manifold3d import Manifold

from mechstyle.errors import BadInput
from mechstyle.geometry.remeshing.evening import even, surface_of
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.simulation.part_test import SEEN, fit_of, relief_over
from validation.meshes import box


@pytest.fixture(scope="module")
def block():
    """Tetrahedra of a 12 x 10 x 16 mm block, and its surface."""
    tets = box((30, 25, 16), (12.0, 10.0, 16.0))
    used, faces = np.unique(tets.boundary_faces, return_inverse=True)
    return tets, SurfaceMesh(tets.vertices[used], faces.reshape(-1, 3))


def waves(surface):
    x, y, z = surface.vertices.T
    return (0.3 * np.sin(x) * np.cos(y) * np.sin(z + 1.0) - 0.1).astype(np.float32)


def shuffled(surface):
    """The same surface as a file may have it: other numbers for the vertices, in single precision."""
    order = np.random.default_rng(3).permutation(len(surface.vertices))
    numbers = np.empty_like(order)
    numbers[order] = np.arange(len(order))
    return SurfaceMesh(surface.vertices[order].astype(np.float32), numbers[surface.faces].astype(np.int32))


def test_the_relief_of_a_file_is_the_one_it_was_made_with(block):
    _, plain = block
    found = relief_over(plain, shuffled(plain.displaced(waves(plain))))
    assert np.quantile(np.abs(found - waves(plain)), 0.97) < SEEN
    assert np.abs(found - waves(plain)).max() < 0.1


def test_a_deep_relief_that_folds_over_the_edges_is_found(block):
    """Cactus on a thin handle: beside a fold the nearest surface was a neighbour's, and the part of one run was "not its original"."""
    plain = surface_of(Manifold.cube((12.0, 10.0, 16.0), True).refine_to_length(1.5))
    deep = np.random.default_rng(0).uniform(-0.3, 1.5, len(plain.vertices)).astype(np.float32)
    found = relief_over(plain, shuffled(plain.displaced(deep)))
    assert np.abs(found - deep).max() <= SEEN + 1e-4


def test_a_part_that_is_its_original_has_no_relief(block):
    _, plain = block
    assert not relief_over(plain, shuffled(plain)).any()


def test_what_no_printer_shows_is_no_relief(block):
    """The rounded figures of a file made a relief under the part, which no tetrahedra could follow."""
    _, plain = block
    noise = np.random.default_rng(1).uniform(-0.004, 0.004, plain.vertices.shape)
    assert not relief_over(plain, plain.moved(plain.vertices + noise)).any()


def test_a_deep_mark_at_one_vertex_is_found(block):
    """The unsafe side: a notch that is overlooked would be judged as none."""
    _, plain = block
    mark = np.zeros(len(plain.vertices), np.float32)
    mark[np.linalg.norm(plain.vertices - [6.0, 0.0, 8.0], axis=1).argmin()] = -0.4
    assert relief_over(plain, shuffled(plain.displaced(mark))).min() == pytest.approx(-0.4, abs=0.02)


@pytest.mark.parametrize(
    ("stretch", "shift"), [((1.3, 1.3, 1.3), 0.0), ((1.0, 1.0, 3.0), 0.0), ((1.0, 1.0, 1 / 3), 0.0), ((1.0, 1.0, 1.0), 3.0)]
)
def test_another_part_is_refused(block, stretch, shift):
    _, plain = block
    with pytest.raises(BadInput, match="is not its original"):
        relief_over(plain, plain.moved(plain.vertices * stretch + (shift, 0.0, 0.0)))


def test_a_part_with_something_stuck_to_it_is_refused(block):
    """Its strength would be compared with that of another part."""
    _, plain = block
    boss = np.where(np.linalg.norm(plain.vertices - [6.0, 5.0, 16.0], axis=1)[:, None] < 3.0, [0.0, 0.0, 30.0], 0.0)
    with pytest.raises(BadInput, match="of its surface is elsewhere"):
        relief_over(plain, plain.moved(plain.vertices + boss))


def test_a_slot_between_the_vertices_of_the_original_is_refused():
    """The unsafe side: a notch of less than a fiftieth of the area, met by no normal of the original, would be judged as none."""
    bar = Manifold.cube((80.0, 20.0, 16.0))
    plain = even(surface_of(bar), 600)
    slot = Manifold.cube((0.2, 3.0, 22.0)).translate((41.13, 17.5, -3.0))
    with pytest.raises(BadInput, match=r"one place lies 2\.[0-9] mm away"):
        relief_over(plain, surface_of((bar - slot).refine_to_length(1.0)))


def test_tetrahedra_beside_a_part_are_seen(block):
    tets, plain = block
    assert (fit_of(tets, plain).mean, fit_of(tets, plain).volume) == pytest.approx((0.0, 0.0), abs=1e-5)
    fit = fit_of(tets, plain.displaced(np.full(len(plain.vertices), 0.2, np.float32)))
    assert fit.mean == pytest.approx(0.2, abs=0.05)
    assert "0.2" in fit.words
    assert fit.volume < -0.05
