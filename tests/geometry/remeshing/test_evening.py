"""An even triangulation of the wished size that is still the same part."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from manifold3d import CrossSection, Manifold, OpType

from mechstyle.errors import BadInput
from mechstyle.gallery import make
from mechstyle.geometry.proximity import TriangleTree
from mechstyle.geometry.remeshing.crossings import crossings
from mechstyle.geometry.remeshing.evening import (
    _bends,
    _fixed,
    _without_false_creases,
    even,
    even_edge,
    manifold_of,
    shell_count,
    surface_of,
)  # fmt: skip
from mechstyle.records.mesh import SurfaceMesh


@pytest.mark.parametrize("wished", [800, 3000])
def test_the_count_is_met_within_five_percent(cup, wished):
    assert abs(len(even(cup, wished).vertices) / wished - 1) <= 0.05


def test_triangles_are_nearly_equilateral(cup):
    sides = np.linalg.norm(np.roll(cup.corners, -1, axis=1) - cup.corners, axis=2)
    quality = 4 * np.sqrt(3) * cup.face_areas / (sides**2).sum(axis=1)
    assert quality.mean() > 0.9
    assert np.percentile(quality, 1) > 0.4


def test_the_shape_stays(cup):
    assert cup.is_closed
    assert len(cup.vertices) - len(cup.edges) + len(cup.faces) == 2
    ideal = np.pi * (20**2 * 30 - 17**2 * 27)
    assert cup.volume == pytest.approx(ideal, rel=0.01)
    assert cup.extents == pytest.approx([40, 40, 30], abs=0.05)


def test_sharp_edges_stay_where_they_are():
    box = trimesh.creation.box((30.0, 20.0, 10.0))
    evened = even(SurfaceMesh(box.vertices, box.faces), 2000)
    distance = TriangleTree(evened.vertices, evened.faces).nearest(box.vertices).distance
    assert distance.max() < 1e-4
    assert evened.volume == pytest.approx(6000, rel=1e-4)


def test_handles_and_cavities_are_kept():
    ring = Manifold.cylinder(6.0, 15.0, 15.0, 48) - Manifold.cylinder(6.0, 9.0, 9.0, 48)
    hollow = Manifold.sphere(12.0, 48) - Manifold.sphere(8.0, 48)
    even_ring, even_hollow = even(surface_of(ring), 1500), even(surface_of(hollow), 2000)
    assert len(even_ring.vertices) - len(even_ring.edges) + len(even_ring.faces) == 0
    assert shell_count(even_hollow) == 2


def test_the_same_input_gives_the_same_bytes(cup):
    assert even(cup, 1500).digest == even(cup, 1500).digest


@pytest.mark.parametrize("count", [10, 499, 400_001])
def test_counts_out_of_range_are_refused(cup, count):
    with pytest.raises(BadInput, match="between 500 and 400000"):
        even(cup, count)


def test_an_open_surface_is_refused(cup):
    with pytest.raises(BadInput, match="not closed"):
        even(SurfaceMesh(cup.vertices, cup.faces[:-1]), 1000)


@pytest.fixture(scope="module")
def rounded():
    """A cup whose rim is rounder than its triangles are small, the case that remeshing likes least."""
    wall, turn = 3.0, np.linspace(0.0, np.pi, 13)
    rim = np.column_stack([20 - wall / 2 + wall / 2 * np.cos(turn), 30 + wall / 2 * np.sin(turn)])
    profile = np.vstack([[(0.0, 0.0), (20.0, 0.0)], rim, [(20.0 - wall, wall), (0.0, wall)]])
    return surface_of(Manifold.revolve(CrossSection([profile]), 96))


@pytest.fixture(scope="module")
def evened_round(rounded):
    return even(rounded, 2500)


def test_every_vertex_lies_on_the_part(rounded, evened_round):
    assert TriangleTree(rounded.vertices, rounded.faces).nearest(evened_round.vertices).distance.max() < 2e-4


def test_the_volume_stays_where_rounds_are_narrower_than_triangles(rounded, evened_round):
    assert evened_round.volume == pytest.approx(rounded.volume, rel=0.01)


def test_no_flap_is_left_at_a_narrow_round(evened_round):
    _, turns, _ = _bends(evened_round)
    assert turns.max() < np.radians(110.0)


def test_a_narrow_round_is_as_round_as_the_part(rounded, evened_round):
    """Without vertices of its own the rim comes out ragged, cut by triangles that miss it by half a wall."""
    rim = rounded.vertices[rounded.vertices[:, 2] > 30.0]
    assert TriangleTree(evened_round.vertices, evened_round.faces).nearest(rim).distance.max() < 0.45


def test_the_radius_of_a_round_is_found(rounded):
    edges, turns, radii = _bends(rounded)
    on_rim = (rounded.vertices[edges][:, :, 2] > 30.1).all(axis=1) & (turns > np.radians(10.0))
    assert np.median(radii[on_rim]) == pytest.approx(1.5, rel=0.05)


def test_a_knife_edge_of_the_part_itself_is_no_flap():
    blade = Manifold.hull_points([(0, -2, 0), (0, 2, 0), (12, 0, 0), (0, -2, 20), (0, 2, 20), (12, 0, 20)])
    evened = even(surface_of(blade), 1500)
    edge = TriangleTree(evened.vertices, evened.faces).nearest(np.column_stack([np.full(50, 12.0), np.zeros(50), np.linspace(0, 20, 50)]))
    assert edge.distance.max() < 1e-4
    assert evened.volume == pytest.approx(480.0, rel=1e-4)


@pytest.mark.slow
def test_too_few_vertices_for_the_features_are_refused_with_advice():
    teeth = [Manifold.cube((0.12, 20.0, 2.0)).translate((0.25 * x, 0.0, 0.0)) for x in range(70)]
    comb = Manifold.batch_boolean([Manifold.cube((17.5, 20.0, 1.0)), *teeth], OpType.Add)
    with pytest.raises(BadInput, match=r"could not be brought to 500 even vertices .*; ask for "):
        even(surface_of(comb), 500)


def test_a_relief_finer_than_the_triangles_is_kept_in_as_many_vertices_as_asked_for(embossed):
    """A delivered surface was refused: every vertex of its creases stayed, and 4580 was the nearest to 2500."""
    plain, styled = embossed
    evened = even(styled, 2500)
    there = TriangleTree(evened.vertices, evened.faces).nearest(styled.vertices).point
    wanted, found = (np.einsum("ij,ij->i", there - plain.vertices, plain.vertex_normals) for there in (styled.vertices, there))
    assert len(evened.vertices) == pytest.approx(2500, rel=0.05)
    assert len(evened.vertices) - len(evened.edges) + len(evened.faces) == 2
    assert evened.volume == pytest.approx(styled.volume, rel=0.01)
    assert (wanted @ found) / (wanted @ wanted) > 0.9  # 0.94; only a third of the vertices are left


def test_flat_faces_beside_such_a_relief_still_have_triangles(embossed):
    half = manifold_of(embossed[1]).split_by_plane((0.0, 0.0, 1.0), 0.0)[0]
    evened = even(surface_of(half), 2000)
    below = evened.corners[(evened.corners[:, :, 2] < 1e-6).all(axis=1)]
    longest = np.linalg.norm(below - np.roll(below, 1, axis=1), axis=2).max()
    assert longest < 2.1 * even_edge(evened, len(evened.faces))


class Unwanted(Exception):
    """Raised by who no longer waits."""


def asking(times: int):
    """A question that is answered so many times with nothing, then with Unwanted; and how often it was asked."""
    asked = []

    def go_on() -> None:
        asked.append(len(asked))
        if len(asked) > times:
            raise Unwanted

    return go_on, asked


def test_it_is_asked_in_every_round_whether_to_go_on(cup):
    """Trials, iterations, and in them rounds of splits, collapses, flips and smoothing: the longest stretch is one of these."""
    go_on, asked = asking(10_000)
    assert even(cup, 800, go_on=go_on).digest == even(cup, 800).digest
    assert len(asked) > 4 * (3 + 8)  # four kinds of rounds in the iterations of two trials


@pytest.mark.parametrize("times", [0, 1, 2, 7, 30])
def test_it_ends_where_it_is_told_to(cup, times):
    go_on, asked = asking(times)
    with pytest.raises(Unwanted):
        even(cup, 800, go_on=go_on)
    assert len(asked) == times + 1


def test_the_rim_of_a_recess_is_not_notched():
    """Its round is narrower than a triangle: vertices anywhere across it, and edges across it, cut notches of half a millimetre."""
    part = make("tealight_holder")
    evened = even(part, 3000)
    assert TriangleTree(evened.vertices, evened.faces).nearest(part.vertices).distance.max() < 0.45
    assert crossings(evened).pairs == 0


def test_what_a_part_stands_on_stays_flat():
    """Pads of a relief under the part end where it turns by 17°, which is no sharp edge: cut across, they lost the area that lands."""
    box = trimesh.creation.box((30.0, 30.0, 8.0)).apply_translation((0.0, 0.0, 4.0))
    for _ in range(5):
        box = box.subdivide()
    plain = SurfaceMesh(box.vertices, box.faces)
    beside = np.abs((plain.vertices[:, :2] + 3.75) % 7.5 - 3.75)
    height = np.where(plain.vertices[:, 2] < 1e-6, np.clip(0.3 * (np.linalg.norm(beside, axis=1) - 2.5), 0.0, 0.5), 0.0)
    padded = SurfaceMesh(plain.vertices + height[:, None] * (0.0, 0.0, 1.0), plain.faces)
    evened = even(padded, 3000)
    assert _resting_area(evened) == pytest.approx(_resting_area(padded), rel=0.1)


def _resting_area(mesh):
    return mesh.face_areas[(mesh.corners[:, :, 2] < 1e-3).all(axis=1)].sum()


@pytest.mark.slow
def test_a_count_that_a_part_jumps_over_is_missed_by_a_tenth_at_most():
    """A coaster's rounds take a whole row more or less at once: 2830 vertices or 3160, whatever the edge length."""
    assert abs(len(even(make("coaster"), 3000).vertices) / 3000 - 1) <= 0.1


@pytest.fixture
def needled():
    """A chamfered bar of 60 mm; along the middle of its chamfer runs a needle 0.01 mm high that looks 45° elsewhere."""
    section = ((0, 0), (10, 0), (10, 8), (8, 10), (0, 10))
    near, far = ([(x, y, z) for y, z in section] for x in (0.0, 60.0))
    needle = [(0.0, 9.0, 9.0), (60.0, 9.0, 9.0), (60.14, 8.99, 9.0)]
    sides = [face for i in (0, 1, 3, 4) for j in [(i + 1) % 5] for face in ((i, i + 5, j + 5), (i, j + 5, j))]
    chamfer = [(2, 7, 11), (2, 11, 10), (10, 11, 12), (10, 12, 8), (10, 8, 3)]
    ends = [(0, 1, 2), (0, 2, 10), (0, 10, 3), (0, 3, 4), (5, 7, 6), (5, 11, 7), (5, 12, 11), (5, 8, 12), (5, 9, 8)]
    return SurfaceMesh(np.array([*near, *far, *needle]), np.array([*sides, *chamfer, *ends], np.int32)[:, ::-1])


def test_a_needle_left_of_a_simplified_round_is_no_crease(needled):
    """Vertices were fixed on both its long sides: put down on the part some passed each other, and triangles crossed."""
    assert needled.is_closed
    assert needled.volume > 0.0
    fine = surface_of(_without_false_creases(manifold_of(needled), 0.0165).refine_to_length(1.65))
    fixed = fine.vertices[_fixed(fine, 1.65)[0]]
    assert len(fixed) > 200, "the edges of the bar"
    assert not ((np.abs(fixed[:, 0] - 30.0) < 25.0) & (fixed[:, 1:] > 8.5).all(axis=1)).any()


@pytest.mark.slow
def test_triangles_of_a_bracket_do_not_cross():
    assert crossings(even(make("shelf_bracket"), 10_000)).pairs == 0
