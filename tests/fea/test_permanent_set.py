"""What a plastic strain leaves and how it is read, against closed forms; a reading that is too low lets a part pass that is bent."""

import math

import numpy as np
import pytest
from scipy.interpolate import BSpline

from mechstyle.errors import SimulationFailed
from mechstyle.fea import linear_solvers
from mechstyle.fea.discretisation import discretise
from mechstyle.fea.elements import ELEMENTS, LINEAR, QUADRATIC, at_vertices
from mechstyle.fea.permanent_set import (
    VOLUME,
    Springback,
    exceeded,
    measured,
    measured_volume,
    plastic_strain,
    quantile,
    share_above,
)
from mechstyle.records.mesh import TetMesh
from validation.meshes import box, carved, lattice, refined

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


def read(mesh, nodal, volume=VOLUME):
    return exceeded(mesh, nodal, volume)[0]


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


# --- the value that a volume exceeds, of known fields -------------------------------------------------------------------


@pytest.mark.parametrize("stress", [0.0, 1e-3, 45.6, 2e3])
def test_uniform_stress_is_read_as_it_is(stress):
    block = box((3, 3, 3), (10.0, 10.0, 10.0))
    assert read(block, np.full(len(block.vertices), stress)) == pytest.approx(stress, rel=1e-9)


@pytest.mark.parametrize("size", [(10.0, 10.0, 10.0), (3.0, 3.0, 2.0), (100.0, 20.0, 0.8)])
@pytest.mark.parametrize("counts", [(1, 1, 1), (4, 3, 2)])
def test_a_linear_field_is_read_at_its_quantile(size, counts):
    block = box(counts, size)
    nodal = 100.0 * block.vertices[:, 2] / size[2]
    assert read(block, nodal) == pytest.approx(100.0 * (1.0 - VOLUME / np.prod(size)), rel=1e-5)


@pytest.mark.parametrize("thickness", [2.0, 4.0, 8.0])
def test_a_plate_in_pure_bending_is_read_at_its_quantile(thickness):
    plate = box((6, 3, 2), (30.0, 10.0, thickness))
    nodal = 37.5 * np.abs(plate.vertices[:, 2] - 0.5 * thickness) / (0.5 * thickness)
    assert read(plate, nodal) == pytest.approx(37.5 * (1.0 - VOLUME / (300.0 * thickness)), rel=1e-5)


def test_a_random_field_is_read_as_many_places_drawn_in_its_tetrahedra_would_be():
    block, rng = box((4, 4, 4), (12.0, 12.0, 12.0)), np.random.default_rng(2)
    nodal = rng.gamma(2.0, 10.0, len(block.vertices))
    places = rng.dirichlet(np.ones(4), 4000)
    parts = (nodal[block.tets] @ places.T).ravel()
    order = np.argsort(-parts)
    held = np.cumsum(np.repeat(block.volumes / len(places), len(places))[order])
    assert read(block, nodal) == pytest.approx(parts[order][np.searchsorted(held, VOLUME)], rel=0.01)


@pytest.mark.parametrize("size", [1.0, 1.9, 2.0])
def test_of_a_part_no_larger_than_v0_the_least_stress_is_read(size):
    cube = box((2, 2, 2), (size, size, size))
    assert read(cube, 10.0 + cube.vertices[:, 2]) == pytest.approx(10.0, rel=1e-4)


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
    points = 5.0 * block.vertices[block.tets][..., 2].mean(axis=1, keepdims=True)
    usual = read(block, at_vertices(block, points))
    points[sliver] = 1e4
    assert read(block, at_vertices(block, points)) == pytest.approx(usual, rel=0.01)


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
    for other, place in ((block.moved(block.vertices @ turn.T), exceeded(block, nodal, VOLUME)[1] @ turn.T), (mirrored, None)):
        assert read(other, nodal) == pytest.approx(read(block, nodal), rel=1e-9)
        if place is not None:
            assert exceeded(other, nodal, VOLUME)[1] == pytest.approx(place, abs=1e-6)


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
    assert read(block, nodal, volume=0.9 * VOLUME) > usual > read(block, nodal, volume=1.1 * VOLUME)


@pytest.mark.parametrize("factor", [0.1, 2.0, 1e3])
def test_it_grows_in_proportion_to_the_stress(field, factor):
    block, nodal = field
    assert read(block, factor * nodal) == pytest.approx(factor * read(block, nodal), rel=1e-6)


def test_where_is_the_middle_of_what_exceeds_it():
    block = box((10, 10, 10), (20.0, 20.0, 20.0))
    away = np.linalg.norm(block.vertices - [4.0, 16.0, 10.0], axis=1)
    assert exceeded(block, 100.0 * np.exp(-away / 4.0), VOLUME)[1] == pytest.approx((4.0, 16.0, 10.0), abs=1.0)


@pytest.fixture(scope="module")
def ring():
    """A square ring of 40 mm with a hole of 32 mm."""
    axis = np.linspace(-20.0, 20.0, 21)
    return carved(axis, axis, np.array([0.0, 4.0]), lambda x, y, _: np.maximum(np.abs(x), np.abs(y)) > 16.0)


def test_two_dents_at_opposite_sides_are_told_of_at_the_larger_and_not_in_the_hole_between(ring):
    """The middle of both is the middle of the hole."""
    to_left, to_right = (np.linalg.norm(ring.vertices - [x, 0.0, 2.0], axis=1) for x in (-18.0, 18.0))
    where = exceeded(ring, np.maximum(np.exp(-to_left / 4.0), np.exp(-to_right / 3.0)), VOLUME)[1]
    assert where == pytest.approx((-18.0, 0.0, 2.0), abs=1.5)


def test_a_rim_bent_all_round_is_told_of_at_a_place_of_the_rim(ring):
    where = exceeded(ring, np.ones(len(ring.vertices)), VOLUME)[1]
    assert 16.0 <= max(abs(where[0]), abs(where[1])) <= 20.0


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_one_value_that_is_no_number_makes_the_reading_none(field, bad):
    block, nodal = field
    assert math.isnan(exceeded(block, np.where(np.arange(len(nodal)) == 7, bad, 1.0), VOLUME)[0])


# --- values at the points ---------------------------------------------------------------------------------------------


def test_a_quantile_counts_the_share_of_every_point():
    volumes, values = np.array([4.0, 8.0]), np.array([[1.0, 2.0, 3.0, 4.0], [0.0, 0.0, 10.0, 9.0]])
    for volume, reads in ((0.0, 10.0), (1.9, 10.0), (2.0, 9.0), (3.9, 9.0), (4.0, 4.0), (5.5, 3.0), (7.5, 1.0), (8.0, 0.0), (99.0, 0.0)):
        assert quantile(values, volumes, volume) == reads


def test_what_counts_is_a_cube_of_2_mm_or_a_hundredth_of_the_part():
    assert measured_volume(box((1, 1, 1), (10.0, 10.0, 10.0))) == pytest.approx(8.0)
    assert measured_volume(box((1, 1, 1), (4.0, 5.0, 5.0))) == pytest.approx(1.0)


def test_the_figures_of_a_test_are_the_quantiles_of_both_fields():
    block = box((4, 4, 4), (20.0, 20.0, 20.0))
    bent = np.outer(block.vertices[:, 2], [0.0, 0.6, -0.8])
    found = measured(block, bent, np.full((len(block.tets), 4), 0.03))
    assert found.permanent_set == pytest.approx(20.0 * (1.0 - VOLUME / 8000.0), rel=1e-5)
    assert (found.plastic_strain, found.where[2] > 15.0) == (0.03, True)


# --- springback -------------------------------------------------------------------------------------------------------


def flow_of(strain):
    """A = C_p⁻¹ − I as six numbers of a logarithmic plastic strain, shape [..., 3, 3]."""
    values, axes = np.linalg.eigh(strain)
    A = (axes * np.expm1(-2.0 * values)[..., None, :]) @ np.swapaxes(axes, -1, -2)
    return A[..., [0, 1, 2, 0, 1, 2], [0, 1, 2, 1, 2, 0]]


def without_motion(displacement, body):
    """Displacement less its best fit by a motion as a whole, weighted by mass; by least squares, one node at a time."""
    arms, weights = body.arms, np.sqrt(body.masses)
    motions = [np.broadcast_to(axis, arms.shape) for axis in np.eye(3)] + [np.cross(axis, arms) for axis in np.eye(3)]
    basis = np.stack([(weights[:, None] * motion).ravel() for motion in motions], axis=1)
    share = np.linalg.lstsq(basis, (weights[:, None] * displacement).ravel(), rcond=None)[0]
    return displacement - np.tensordot(share, np.array(motions), 1)


def test_the_logarithm_is_that_of_the_plastic_stretch():
    rng = np.random.default_rng(7)
    strain = 0.1 * rng.standard_normal((5, 4, 3, 3))
    strain = strain + strain.swapaxes(-1, -2)
    strain[2, 1] = 0.0
    assert plastic_strain(flow_of(strain)) == pytest.approx(strain, abs=1e-12)


@pytest.mark.parametrize("element", ELEMENTS.values(), ids=ELEMENTS)
def test_a_uniform_plastic_strain_stretches_the_body_as_a_whole(block, pla, element):
    """K u = f of a displacement that is linear in space: what is left is that very displacement."""
    body = discretise(block, pla, 0.01, element)
    strain = np.array([[4e-3, 1e-3, -2e-3], [1e-3, -3e-3, 5e-4], [-2e-3, 5e-4, -1e-3]])
    flow = np.broadcast_to(flow_of(strain), (1, len(body.volumes), element.points, 6))
    assert Springback(body)(flow)[0] == pytest.approx(without_motion(body.arms @ strain, body), abs=1e-6)


def test_a_bar_with_a_plastic_curvature_is_an_arc(box, pla):
    """ε_xx = κ z about the middle, less ν_p = 1/2 of it across: the middle line is bent by κ x²/2, κ L²/8 in its middle."""
    length, height, kappa = 60.0, 4.0, 1e-4
    body = discretise(box((20, 2, 2), (length, 4.0, height)), pla, 0.0, QUADRATIC)
    inside = np.einsum(
        "pa,tai->tpi", (QUADRATIC.derivatives[:, np.arange(4), np.arange(4)] + 1.0) / 4.0, body.positions[body.connectivity[:, :4]]
    )
    z = inside[..., 2] - 0.5 * height
    strain = kappa * z[..., None, None] * np.diag([1.0, -0.5, -0.5])
    bent = Springback(body)(flow_of(strain)[None])[0]
    middle = np.abs(body.arms[:, 1:]).max(axis=1) < 1e-9
    x, sag = body.arms[middle, 0], bent[middle, 2]
    # The bar is free to bend across as well, so that nothing holds it: the strain is compatible and u_z = −κ x²/2 + ….
    arc = -0.5 * kappa * (x**2 - length**2 / 12.0)
    assert sag == pytest.approx(arc, abs=0.01 * kappa * length**2 / 8.0)


def test_numbering_and_rotation_do_not_matter(block, pla):
    body, rng = discretise(block, pla, 0.0, QUADRATIC), np.random.default_rng(8)
    strain = np.zeros((len(block.tets), 4, 3, 3))
    strain[:40] = 0.05 * rng.standard_normal((40, 4, 3, 3))
    strain = strain + strain.swapaxes(-1, -2)
    usual = Springback(body)(flow_of(strain)[None, body.tet_order])[0][body.place[: len(block.vertices)]]
    order, tets = rng.permutation(len(block.vertices)), rng.permutation(len(block.tets))
    turn = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    again = TetMesh((block.vertices @ turn.T)[order], np.argsort(order).astype(np.int32)[block.tets[tets]])
    other = discretise(again, pla, 0.0, QUADRATIC)
    turned = flow_of(turn @ strain @ turn.T)[None, tets][:, other.tet_order]
    found = np.empty_like(usual)
    found[order] = Springback(other)(turned)[0][other.place[: len(order)]] @ turn
    assert found == pytest.approx(usual, abs=1e-4 * np.abs(usual).max())


def test_nothing_flowed_nothing_stays(block, pla):
    body = discretise(block, pla, 0.0, QUADRATIC)
    flow = np.zeros((3, len(block.tets), 4, 6), np.float32)
    flow[1, 0, 0, 3] = 0.1
    found = Springback(body)(flow)
    assert (np.any(found[0]), np.any(found[1]), np.any(found[2])) == (False, True, False)


def test_what_stays_is_the_same_to_the_bit_whatever_is_asked_for_with_it(block, pla):
    body, rng = discretise(block, pla, 0.0, QUADRATIC), np.random.default_rng(9)
    flow = np.zeros((5, len(block.tets), 4, 6))
    for number in range(5):
        flow[number, 40 * number : 40 * number + 7 * number + 1] = 0.02 * rng.standard_normal((7 * number + 1, 4, 6))
    together = Springback(body)(flow)
    for number in range(5):
        assert np.array_equal(Springback(body)(flow[[number]])[0], together[number])


def test_pieces_apart_are_each_free(block, pla):
    beside = block.moved(block.vertices + np.array([30.0, 0.0, 0.0]))
    count = len(block.tets)
    pair = TetMesh(np.concatenate([block.vertices, beside.vertices]), np.concatenate([block.tets, block.tets + len(block.vertices)]))
    bodies = discretise(block, pla, 0.0, QUADRATIC), discretise(pair, pla, 0.0, QUADRATIC)
    strain = np.zeros((2 * count, 4, 3, 3))
    strain[count + 5, :] = np.diag([0.1, -0.05, -0.05])
    alone = Springback(bodies[0])(flow_of(strain[count:])[None, bodies[0].tet_order])[0][bodies[0].place]
    both = Springback(bodies[1])(flow_of(strain)[None, bodies[1].tet_order])[0][bodies[1].place[: 2 * len(block.vertices)]]
    first, second = both[: len(block.vertices)], both[len(block.vertices) :]
    size = np.abs(alone).max()
    assert np.abs(first).max() < 1e-4 * size
    assert second == pytest.approx(alone[: len(block.vertices)], abs=1e-4 * size)


def test_a_plate_of_flat_tetrahedra_is_solved_by_factors(box, pla, monkeypatch):
    body = discretise(box((5, 5, 1), (60.0, 58.0, 2.0)), pla, 0.0, QUADRATIC)
    flow = np.zeros((1, len(body.volumes), 4, 6))
    flow[0, 7, :, 0] = 0.05
    usual = Springback(body)(flow)
    monkeypatch.setattr(linear_solvers.TwoLevel, "__call__", lambda _, right: right)
    assert Springback(body)(flow) == pytest.approx(usual, abs=1e-3 * np.abs(usual).max())


@pytest.mark.parametrize("flow", [np.nan, np.inf, -1.5])
def test_what_is_no_plastic_strain_fails(block, pla, flow):
    body = discretise(block, pla, 0.0, LINEAR)
    with pytest.raises(SimulationFailed, match="not a finite number"):
        Springback(body)(np.full((1, len(block.tets), 1, 6), flow))
