"""Stress where the surface curves away: bending of round bars is read at their surface, roots and edges are left to the mean."""

import math

import numpy as np
import pytest

from mechstyle.fea.plane_sections import Patches
from mechstyle.fea.statics.load_test import StaticTest
from mechstyle.fea.surface_stress import SurfaceStress
from mechstyle.records.load_cases import Load, LoadCase, Patch, Support
from mechstyle.simulation.validation.meshes import lattice


def round_bar(diameter, length, edge, shake=0.0):
    """A bar along x about the axis y = z = 0 [mm]: square shells bent into round ones, cells of about an edge [mm].

    Vertices are moved by up to `shake` of a cell, those of its round surface along that.
    """
    across = 2 * max(1, round(0.125 * math.pi * diameter / edge))
    straight = lattice(np.linspace(0.0, length, round(length / edge) + 1), *[np.linspace(-1.0, 1.0, across + 1)] * 2)
    x, section = straight.vertices[:, :1], straight.vertices[:, 1:]
    shell = np.abs(section).max(axis=1, keepdims=True)
    outward = np.tan(0.25 * math.pi * section / np.maximum(shell, 1e-12))
    outward /= np.maximum(np.linalg.norm(outward, axis=1, keepdims=True), 1e-12)
    vertices = np.hstack([x, 0.5 * diameter * shell * outward])
    inner = (x > 1e-9) & (x < length - 1e-9)
    step = shake * min(edge, diameter / across) * np.random.default_rng(0).uniform(-1.0, 1.0, vertices.shape)
    moved = vertices + inner * step
    skin = np.isclose(shell[:, 0], 1.0)
    moved[skin, 1:] *= 0.5 * diameter / np.linalg.norm(moved[skin, 1:], axis=1, keepdims=True)
    upright = np.where((straight.moved(moved).volumes < 0.0)[:, None], straight.tets[:, [0, 2, 1, 3]], straight.tets)
    bar = type(straight)(moved, upright)
    assert (bar.volumes > 0.0).all()
    return bar


def mean_along(reading, body, at_vertices):
    """The mean over 2 mm alone, where no side is a splinter."""
    weights = reading.sides.weights(body)
    return (reading._near @ (weights * (reading.sides.points @ at_vertices))) / (reading._near @ weights)


def in_the_middle(reading, length):
    x = reading.sides.positions[:, 0]
    return (x > 4.0) & (x < length - 4.0)


@pytest.mark.parametrize("shake", [0.0, 0.15])
@pytest.mark.parametrize(
    ("diameter", "edge", "mean"),
    [(2.0, 0.4, 0.80), (2.0, 0.8, 0.86), (2.0, 1.5, 0.87), (3.0, 0.8, 0.83), (4.0, 0.8, 0.87), (4.0, 1.5, 0.87), (6.0, 1.5, 0.94),
     (12.0, 2.0, 0.98)],
)  # fmt: skip
def test_bending_of_a_round_bar_is_read_as_it_is_at_the_surface(diameter, edge, mean, shake):
    """Of 100 MPa at the surface the mean over 2 mm sees as much as is said, because it lies deeper."""
    bar = round_bar(diameter, 14.0, edge, shake)
    reading, stress = SurfaceStress(bar), 200.0 * np.abs(bar.vertices[:, 2]) / diameter
    middle = in_the_middle(reading, 14.0)
    there = stress[reading.sides.vertices][middle].max()
    assert mean_along(reading, bar, stress)[middle].max() == pytest.approx(mean * there, rel=0.05)
    assert 0.95 * there < reading.along(bar, stress)[middle].max() <= there


def test_between_the_tension_and_the_pressure_of_a_bar_each_place_has_its_own_stress():
    """Von Mises stress is none at the neutral axis, and as large below as above it."""
    bar = round_bar(3.0, 14.0, 0.4)
    reading, stress = SurfaceStress(bar), 100.0 * np.abs(bar.vertices[:, 2]) / 1.5
    middle = in_the_middle(reading, 14.0)
    there = stress[reading.sides.vertices]
    found, mean = reading.along(bar, stress), mean_along(reading, bar, stress)
    off_axis = middle & (there > 87.0)  # the patch reaches 60° to both sides, the axis is 90° from the top
    assert found[off_axis] == pytest.approx(there[off_axis], rel=0.02)
    assert np.array_equal(found[middle & (there < 20.0)], mean[middle & (there < 20.0)])


def test_a_round_bar_bent_by_a_force_reads_what_its_surface_bears(pla):
    bar = round_bar(3.0, 24.0, 0.8, 0.15)
    low, high = Patch(plane=(0, 0, 0, -1, 0, 0)), Patch(plane=(24, 0, 0, 1, 0, 0))
    case = LoadCase(name="bent", supports=(Support(at=low),), loads=(Load(at=high, force=(0.0, 0.0, -10.0)),))
    response = StaticTest(bar, (case,)).run(bar, pla)["bent"]
    reading = SurfaceStress(bar)
    stress, middle = reading.at_vertices(bar, response.corners)[0], in_the_middle(reading, 24.0)
    there = stress[reading.sides.vertices][middle].max()
    assert mean_along(reading, bar, stress)[middle].max() < 0.86 * there
    assert 0.95 * there < reading.along(bar, stress)[middle].max() <= there


def test_the_mean_is_only_ever_raised_and_not_above_the_stress_at_the_spot():
    bar = round_bar(3.0, 14.0, 0.8, 0.15)
    reading, stress = SurfaceStress(bar), np.random.default_rng(0).uniform(0.0, 50.0, len(bar.vertices))
    found, mean = reading.along(bar, stress), mean_along(reading, bar, stress)
    middle = in_the_middle(reading, 14.0)
    assert (found >= mean - 1e-9)[middle].all()
    assert (found <= np.maximum(mean, stress[reading.sides.vertices]) + 1e-9)[middle].all()
    assert (found > mean + 0.1)[middle].any()


def test_a_notch_in_a_thick_bar_raises_the_mean_by_no_more_than_the_bending_of_such_a_bar():
    """Its stress falls off within 0.3 mm; of bending around 12 mm across the mean misses a fiftieth."""
    bar = round_bar(12.0, 14.0, 1.5)
    reading, stress = SurfaceStress(bar), 100.0 * np.exp((np.abs(bar.vertices[:, 2]) - 6.0) / 0.3)
    middle = in_the_middle(reading, 14.0)
    found, mean = reading.along(bar, stress), mean_along(reading, bar, stress)
    assert 1.01 < (found / mean)[middle].max() < 1.04


@pytest.mark.parametrize("slope", [0.0, 0.5])
def test_flat_faces_are_read_as_before(box, slope):
    """A slope of the stress along the surface is none across it, however the triangles lie, and whichever way the face was morphed."""
    plate = box((12, 12, 3), (20.0, 20.0, 4.0), shake=0.3)
    body = plate.moved(plate.vertices + slope * np.outer(plate.vertices[:, 0], [0.0, 0.0, 1.0]))
    reading, stress = SurfaceStress(plate), np.random.default_rng(0).uniform(0.0, 50.0, len(plate.vertices)) + 10.0 * plate.vertices[:, 0]
    inner = (reading._near @ reading.sides.weights(body)) > 2.0
    assert reading.along(body, stress)[inner] == pytest.approx(mean_along(reading, body, stress)[inner], rel=1e-12)


def waved(box, depth):
    """A plate whose upper side goes up and down over 12 mm, valleys at x = 0, 12 and 24, crests at 6 and 18 [mm]."""
    plate = box((48, 8, 3), (24.0, 8.0, 6.0))
    up = 0.5 * depth * (1.0 - np.cos(2.0 * np.pi * plate.vertices[:, 0] / 12.0)) * plate.vertices[:, 2] / 6.0
    return plate, plate.moved(plate.vertices + np.outer(up, [0.0, 0.0, 1.0]))


@pytest.mark.parametrize("made_flat", [True, False])
def test_crests_are_raised_and_roots_are_not_by_the_shape_of_the_body_that_was_dropped(box, made_flat):
    """Stress grows with the height where one looks, in the root with the depth; neighbours may be those of another morph."""
    plate, body = waved(box, 2.0)
    reading = SurfaceStress(plate if made_flat else body)
    x, y = body.vertices[reading.sides.vertices, :2].T
    above = (reading.sides._directions[:, 2] > 0.5) & (np.abs(y - 4.0) < 1.5)
    crest, root = above & np.isclose(x, 6.0), above & np.isclose(x, 12.0)
    height = body.vertices[:, 2]
    for stress, rises in ((10.0 * height, crest), (100.0 - 10.0 * height, crest & ~crest)):
        found, mean = reading.along(body, stress), mean_along(reading, body, stress)
        assert np.array_equal(found[root], mean[root])
        assert (found > mean + 1.0)[crest].all() == rises.any()
        assert found[crest & ~rises] == pytest.approx(mean[crest & ~rises], rel=1e-12)
        assert found[rises] == pytest.approx(stress[reading.sides.vertices[rises]], rel=0.005)


def test_an_edge_is_no_bar(box):
    """Two planes at 29° each meet smoothly enough for one side, and the crest of a brick is not told for itself."""
    straight = box((24, 12, 3), (12.0, 12.0, 4.0))
    x, _, z = straight.vertices.T
    roof = straight.moved(straight.vertices - np.outer(math.tan(math.radians(29.0)) * np.abs(x - 6.0) * z / 4.0, [0.0, 0.0, 1.0]))
    reading, stress = SurfaceStress(roof), 10.0 * roof.vertices[:, 2]
    ridge = np.isclose(reading.sides.positions, [6.0, 6.0, 4.0]).all(axis=1)
    assert ridge.sum() == 1
    assert stress[reading.sides.vertices[ridge]] > mean_along(reading, roof, stress)[ridge] + 3.0
    assert reading.along(roof, stress)[ridge] == pytest.approx(mean_along(reading, roof, stress)[ridge], rel=1e-12)


@pytest.mark.parametrize("worst", [np.inf, np.nan])
def test_stress_without_limit_or_number_stays_so(box, worst):
    """Nothing that broke down is ever read as bearing little."""
    _, body = waved(box, 2.0)
    reading = SurfaceStress(body)
    crest = np.isclose(body.vertices, [6.0, 4.0, 8.0]).all(axis=1)
    stress = np.where(crest, worst, 1.0)
    found = Patches(reading._near, reading.sides, body).along(reading.sides.points @ stress, stress[reading.sides.vertices])
    assert crest.sum() == 1
    assert np.array_equal(found[crest[reading.sides.vertices]], [worst], equal_nan=True)
