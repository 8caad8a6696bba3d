"""σ_V against closed forms; a reading that is too low lets a part pass that yields."""

import math

import numpy as np
import pytest
from scipy.interpolate import BSpline

from mechstyle.fea.stressed_volume import LOADED, Walls, at_nodes, exceeded, share_above
from mechstyle.records import Landing, Recipe, Simulation, judge
from mechstyle.records.material import LIBRARY
from mechstyle.records.mesh import TetMesh
from validation.meshes import box, lattice, refined

V0 = LOADED**3
FIELDS = {
    "apart": [1.0, 2.0, 4.0, 7.0],
    "low pair": [1.0, 1.0, 4.0, 7.0],
    "middle pair": [1.0, 4.0, 4.0, 7.0],
    "high pair": [1.0, 2.0, 7.0, 7.0],
    "two pairs": [1.0, 1.0, 7.0, 7.0],
    "low three": [1.0, 1.0, 1.0, 7.0],
    "high three": [1.0, 7.0, 7.0, 7.0],
    "about zero": [-3.0, -1.0, 0.0, 2.0],
}


def exactly(values, level):
    """Share above a level: a linear field over a simplex is spread like the B-spline of its corner values."""
    low, high = values[0], values[-1]
    inside, end = np.clip(level, low, high), high - 1e-12 * (high - low)
    spline = BSpline.basis_element(np.asarray(values, float), extrapolate=False)
    return 3.0 / (high - low) * float(spline.integrate(min(inside, end), end))


def read(mesh, nodal, weights=1.0, volume=V0):
    return exceeded(mesh, nodal, weights, volume).stress


# --- the share of one tetrahedron -------------------------------------------------------------------------------------


@pytest.mark.parametrize("values", FIELDS.values(), ids=FIELDS)
def test_the_share_above_a_level_is_the_integral(values):
    for level in np.linspace(values[0] - 1.0, values[-1] + 1.0, 41):
        assert share_above(np.array([values]), level)[0] == pytest.approx(exactly(values, level), abs=1e-5)


def test_the_share_of_random_fields_is_the_integral():
    values = np.sort(np.random.default_rng(0).uniform(0.0, 100.0, (200, 4)), axis=1)
    for level in (5.0, 30.0, 50.0, 95.0):
        assert share_above(values, level) == pytest.approx([exactly(row, level) for row in values], abs=1e-4)


def test_the_share_is_that_of_points_drawn_at_random():
    values, points = np.array([3.0, 10.0, 11.0, 40.0]), np.random.default_rng(1).dirichlet(np.ones(4), 200_000)
    for level in (8.0, 10.5, 20.0):
        assert share_above(values[None], level)[0] == pytest.approx((points @ values > level).mean(), abs=0.004)


@pytest.mark.parametrize("value", [0.0, 1e-12, 45.6, 1e9])
def test_a_uniform_field_is_above_what_is_less_and_not_above_what_is_more(value):
    values = np.full((1, 4), value)
    assert share_above(values, value - 0.01 * max(value, 1.0)) == 1.0
    assert share_above(values, value + 0.01 * max(value, 1.0)) == 0.0


@pytest.mark.parametrize("apart", [1e-4, 1e-7, 1e-10, 1e-16])
def test_a_nearly_uniform_field_gives_a_share_that_only_falls_with_the_level(apart):
    values = 45.6 * (1.0 + apart * np.array([[0.0, 1.0, 1.5, 3.0]]))
    shares = [float(share_above(values, level)[0]) for level in 45.6 * (1.0 + np.linspace(-1.0, 4.0, 101) * max(apart, 1e-6))]
    assert all(0.0 <= share <= 1.0 for share in shares)
    assert np.all(np.diff(shares) <= 1e-9)
    assert (shares[0], shares[-1]) == (1.0, 0.0)


# --- σ_V of known fields ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("stress", [0.0, 1e-3, 45.6, 2e3])
def test_uniform_stress_is_read_as_it_is(stress):
    block = box((3, 3, 3), (10.0, 10.0, 10.0))
    assert read(block, np.full(len(block.vertices), stress)) == pytest.approx(stress, rel=1e-9)


@pytest.mark.parametrize("size", [(10.0, 10.0, 10.0), (3.0, 3.0, 2.0), (100.0, 20.0, 0.8)])
@pytest.mark.parametrize("counts", [(1, 1, 1), (4, 3, 2)])
def test_a_linear_field_is_read_at_its_quantile(size, counts):
    block = box(counts, size)
    nodal = 100.0 * block.vertices[:, 2] / size[2]
    assert read(block, nodal) == pytest.approx(100.0 * (1.0 - V0 / np.prod(size)), rel=1e-5)


@pytest.mark.parametrize("thickness", [2.0, 4.0, 8.0])
def test_a_plate_in_pure_bending_is_read_at_its_quantile(thickness):
    plate = box((6, 3, 2), (30.0, 10.0, thickness))
    nodal = 37.5 * np.abs(plate.vertices[:, 2] - 0.5 * thickness) / (0.5 * thickness)
    assert read(plate, nodal) == pytest.approx(37.5 * (1.0 - V0 / (300.0 * thickness)), rel=1e-5)


def test_a_random_field_is_read_as_many_places_drawn_in_its_tetrahedra_would_be():
    block, rng = box((4, 4, 4), (12.0, 12.0, 12.0)), np.random.default_rng(2)
    nodal = rng.gamma(2.0, 10.0, len(block.vertices))
    places = rng.dirichlet(np.ones(4), 4000)
    parts = (nodal[block.tets] @ places.T).ravel()
    order = np.argsort(-parts)
    held = np.cumsum(np.repeat(block.volumes / len(places), len(places))[order])
    assert read(block, nodal) == pytest.approx(parts[order][np.searchsorted(held, V0)], rel=0.01)


@pytest.mark.parametrize("size", [1.0, 1.9, 2.0])
def test_of_a_part_no_larger_than_v0_the_least_stress_is_read(size):
    cube = box((2, 2, 2), (size, size, size))
    assert read(cube, 10.0 + cube.vertices[:, 2]) == pytest.approx(10.0, rel=1e-4)


def test_weights_count_a_volume_more_than_once():
    """Eight times as much for walls of 1 mm, so that a cube of 1 mm is enough."""
    block = box((2, 2, 2), (10.0, 10.0, 10.0))
    nodal = 10.0 * block.vertices[:, 2]
    assert read(block, nodal, weights=8.0) == pytest.approx(read(block, nodal, volume=1.0), rel=1e-9)
    assert read(block, nodal, weights=8.0) == pytest.approx(99.9, rel=1e-5)
    thin = np.where(block.vertices[block.tets].mean(axis=1)[:, 2] > 5.0, 8.0, 1.0)
    assert read(block, nodal, weights=thin) == pytest.approx(99.9, rel=1e-5)
    assert read(block, nodal, weights=9.0 - thin) == pytest.approx(99.2, rel=1e-5)


@pytest.mark.parametrize(("share", "reads"), [(0.009, 40.0), (0.007, 20.0)])
def test_a_pin_of_a_hundredth_of_a_part_is_read_once_it_has_8_mm3(share, reads):
    """A part of 1000 mm³ whose pin bears twice as much as the rest."""
    bar = lattice(np.array([0.0, 100.0 * share, 100.0]), np.array([0.0, 2.5, 5.0]), np.array([0.0, 1.0, 2.0]))
    pin = bar.vertices[bar.tets].mean(axis=1)[:, 0] < 100.0 * share
    step = TetMesh(bar.vertices[bar.tets].reshape(-1, 3), np.arange(4 * len(bar.tets), dtype=np.int32).reshape(-1, 4))
    assert read(step, np.repeat(np.where(pin, 40.0, 20.0), 4)) == pytest.approx(reads, rel=1e-5)


def test_a_single_singular_corner_does_not_matter_however_high_it_is():
    axis = np.array([0.0, 0.4, 2.0, 4.0, 6.0, 8.0, 10.0])
    block = lattice(axis, axis, axis)
    sliver = int(np.argmin(block.volumes))
    assert 0.005 < block.volumes[sliver] < 0.02
    corners = np.broadcast_to(5.0 * block.vertices[block.tets][..., 2], (len(block.tets), 4)).copy()
    usual = read(block, at_nodes(block, corners))
    corners[sliver] = 1e4
    assert read(block, at_nodes(block, corners)) == pytest.approx(usual, rel=0.01)


# --- what must not matter, and what must ------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def field():
    """A block and a random field over its vertices [MPa]."""
    block = box((3, 4, 3), (9.0, 12.0, 9.0))
    return block, np.random.default_rng(3).gamma(2.0, 10.0, len(block.vertices))


def test_numbering_does_not_matter(field):
    (block, nodal), rng = field, np.random.default_rng(4)
    order = rng.permutation(len(nodal))
    place = np.argsort(order).astype(np.int32)
    even = block.tets[rng.permutation(len(block.tets))][:, [1, 2, 0, 3]]
    again = TetMesh(block.vertices[order], place[even])
    assert read(again, nodal[order]) == pytest.approx(read(block, nodal), rel=1e-9)


def test_neither_rotation_nor_a_mirror_matters(field):
    block, nodal = field
    turn = np.linalg.qr(np.random.default_rng(5).standard_normal((3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    mirrored = TetMesh(block.vertices * [-1.0, 1.0, 1.0], block.tets[:, [0, 2, 1, 3]])
    for other, place in ((block.moved(block.vertices @ turn.T), exceeded(block, nodal, 1.0, V0).where @ turn.T), (mirrored, None)):
        assert read(other, nodal) == pytest.approx(read(block, nodal), rel=1e-9)
        if place is not None:
            assert exceeded(other, nodal, 1.0, V0).where == pytest.approx(place, abs=1e-6)


def test_cutting_every_tetrahedron_into_eight_does_not_matter(field):
    block, nodal = field
    fine = refined(block)
    middles = np.full(len(fine.vertices), np.nan)
    middles[: len(nodal)] = nodal
    for tet in block.tets:
        for a, b in ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)):
            pair = tet[[a, b]]
            at = np.flatnonzero(np.isclose(fine.vertices, fine.vertices[pair].mean(axis=0)).all(axis=1))
            middles[at] = nodal[pair].mean()
    assert read(fine, middles) == pytest.approx(read(block, nodal), rel=1e-5)


def test_more_stress_anywhere_never_reads_less(field):
    (block, nodal), rng = field, np.random.default_rng(6)
    usual = read(block, nodal)
    for _ in range(20):
        more = nodal + rng.uniform(0.0, 30.0, len(nodal)) * (rng.random(len(nodal)) < 0.1)
        assert read(block, more) >= usual * (1.0 - 1e-6)
    assert read(block, nodal, volume=0.9 * V0) > usual > read(block, nodal, volume=1.1 * V0)
    assert read(block, nodal, weights=1.1) > usual


@pytest.mark.parametrize("factor", [0.1, 2.0, 1e3])
def test_it_grows_in_proportion_to_the_stress(field, factor):
    block, nodal = field
    assert read(block, factor * nodal) == pytest.approx(factor * read(block, nodal), rel=1e-6)


def test_where_is_the_middle_of_what_exceeds_it():
    block = box((10, 10, 10), (20.0, 20.0, 20.0))
    away = np.linalg.norm(block.vertices - [4.0, 16.0, 10.0], axis=1)
    assert exceeded(block, 100.0 * np.exp(-away / 4.0), 1.0, V0).where == pytest.approx((4.0, 16.0, 10.0), abs=0.5)


# --- what is not a number never passes --------------------------------------------------------------------------------


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_one_stress_that_is_no_number_makes_the_outcome_unknown(field, bad):
    block, nodal = field
    nodal = np.where(np.arange(len(nodal)) == 7, bad, 1.0)
    stress, where = exceeded(block, nodal, 1.0, V0)
    assert math.isnan(stress)
    one = Landing(name="as placed", way="flat", normal=(0.0, 0.0, 1.0), stress=stress, maximum=1.0, where=where, fall=1500.0,
                  critical_height=1e5)  # fmt: skip
    nothing = np.zeros(0, np.float32)
    part = Simulation(displacement=nothing, contact=nothing.astype(bool), landings=(one,))
    recipe = Recipe.of(prompt="", material=LIBRARY["PLA"])
    verdict = judge(part, None, recipe)
    assert (verdict.outcome, verdict.passes, verdict.sure) == ("UNKNOWN", False, False)


# --- from corners to nodes, and walls ---------------------------------------------------------------------------------


def test_corner_values_of_a_linear_field_are_its_values_at_the_nodes():
    block = box((3, 2, 4), (9.0, 5.0, 12.0))
    nodal = 3.0 + block.vertices @ [1.0, -2.0, 0.5]
    assert at_nodes(block, nodal[block.tets]) == pytest.approx(nodal, rel=1e-12)


def test_a_large_tetrahedron_counts_more_at_a_node_it_shares():
    vertices = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -3.0], [9.0, 9.0, 9.0]])
    pair = TetMesh(vertices, np.array([[0, 1, 2, 3], [0, 2, 1, 4]], np.int32))
    nodal = at_nodes(pair, [[10.0] * 4, [50.0] * 4])
    assert nodal == pytest.approx([40.0, 40.0, 40.0, 10.0, 50.0, 0.0])


@pytest.mark.parametrize(("thickness", "weight"), [(0.8, 125.0), (1.0, 64.0), (2.0, 8.0), (4.0, 1.0), (8.0, 1.0)])
def test_a_volume_of_a_thin_wall_counts_several_times(thickness, weight):
    block = box((2, 2, 2), (10.0, 10.0, 10.0))
    walls = Walls(block.vertices, np.full(len(block.vertices), thickness))
    assert walls.weights(block) == pytest.approx(np.full(len(block.tets), weight))


def test_the_nearest_wall_counts_and_none_without_thickness_counts_for_ever():
    bar = box((20, 1, 1), (40.0, 2.0, 2.0))
    walls = Walls(np.array([[5.0, 1.0, 1.0], [35.0, 1.0, 1.0]]), np.array([1.0, 0.0]))
    weights, x = walls.weights(bar), bar.vertices[bar.tets].mean(axis=1)[:, 0]
    assert np.all(weights[x < 20.0] == 64.0)
    assert np.all(weights[x > 20.0] > 64.0)
    assert np.isfinite(weights).all()
