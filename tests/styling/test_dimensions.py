"""Relief and features in mm: how deep, to which side, how large, and what is said where that cannot be."""

import manifold3d
import numpy as np
import pytest

from mechstyle.geometry.remeshing.evening import even, surface_of
from mechstyle.geometry.thickness import face_width
from mechstyle.records import Recipe
from mechstyle.records.material import LIBRARY
from mechstyle.styling.dimensions import LEGIBLE, Dimensions, Layout, gradual_thickness, outwards
from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.operators import Operators
from mechstyle.styling.drawn import target
from mechstyle.styling.library import style_named
from mechstyle.styling.prompt import Wish

WALL = 3.0
BRICK = style_named("brick").feature_mm


def laid(mesh, wall, feature=10.0, amount=1.0, **asked) -> Layout:
    return Dimensions(**asked).layout(Operators(mesh), np.full(len(mesh.vertices), wall), feature, amount)


def wave(mesh):
    """A relief of a style: waves upwards, from -1 to 1."""
    return np.sin(mesh.vertices[:, 2])


def ends(mesh, layout) -> tuple[float, float]:
    """The lowest and the highest of a wave that is laid out so [mm]."""
    moved = layout.displacement(wave(mesh), mesh.vertex_areas)
    return float(moved.min()), float(moved.max())


# --- depth and side ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("side", "low", "high"), [("outwards", 0.0, 0.8), ("inwards", -0.8, 0.0), ("both", -0.4, 0.4), ("auto", -0.4, 0.4)]
)
def test_a_relief_in_millimetres_is_so_deep_and_goes_to_its_side(holder, side, low, high):
    lowest, highest = ends(holder, laid(holder, 4.0, relief=0.8, side=side))
    assert lowest == pytest.approx(low, abs=0.06)
    assert highest == pytest.approx(high, abs=0.06)
    assert highest - lowest == pytest.approx(0.8, abs=0.03)


def test_a_relief_in_millimetres_is_no_deeper_for_a_style_that_draws_high(holder):
    layout, height = laid(holder, WALL, relief=0.8), wave(holder)
    once, twice = (layout.displacement(factor * height, holder.vertex_areas) for factor in (1.0, 2.0))
    assert np.allclose(once, twice)


def test_a_relief_on_both_sides_moves_no_volume(holder):
    moved = laid(holder, WALL, side="both").displacement(wave(holder) ** 3, holder.vertex_areas)
    assert abs(holder.vertex_areas @ moved) < 1e-9 * holder.vertex_areas @ np.abs(moved)


def test_a_style_that_draws_nothing_moves_nothing(holder):
    for side in ("auto", "both", "inwards", "outwards"):
        assert not laid(holder, WALL, side=side).displacement(np.ones(len(holder.vertices)), holder.vertex_areas).any()


@pytest.mark.parametrize("wall", [0.7, 1.2, 3.0, 20.0])
@pytest.mark.parametrize("feature", [2.4, 10.0])
def test_unless_told_a_relief_can_be_seen_on_any_wall(holder, wall, feature):
    lowest, highest = ends(holder, laid(holder, wall, feature))
    assert highest - lowest >= 0.95 * LEGIBLE
    assert -lowest <= 0.25 * wall + 0.03
    assert highest <= outwards(wall) + 0.03


@pytest.mark.parametrize(("feature", "depth"), [(2.4, 0.72), (10.0, 1.0), (25.0, 2.5), (60.0, 3.0)])
def test_unless_told_a_relief_grows_with_its_features_but_not_for_ever(holder, feature, depth):
    assert np.ptp(ends(holder, laid(holder, WALL, feature))) == pytest.approx(depth, rel=0.03)


@pytest.mark.parametrize("wall", [0.7, 1.2])
def test_a_wall_too_thin_to_be_cut_is_not_cut_and_that_is_said(holder, wall):
    layout = laid(holder, wall)
    assert ends(holder, layout)[0] > -0.02
    assert layout.notes == ("the relief only stands out of the wall on 100% of the surface: it is too thin to be cut",)
    assert laid(holder, WALL).notes == ()


def test_without_a_minimum_a_thin_wall_is_cut_by_a_quarter(holder):
    assert ends(holder, laid(holder, 1.2, minimum_wall=0.0))[0] == pytest.approx(-0.3, abs=0.02)


def test_on_a_wall_that_bears_no_such_relief_it_is_lower_and_that_is_said(holder):
    layout = laid(holder, 0.2, relief=1.0)
    assert np.ptp(ends(holder, layout)) == pytest.approx(0.4, abs=0.02)
    assert layout.notes[-1] == ("the relief is down to 0.4 mm deep instead of 1 mm on 100% of the surface: the walls there bear no more")
    assert "0.4 mm deep instead of 0.6 mm" in laid(holder, 0.2).notes[-1]
    assert "0.4 mm deep instead of 0.6 mm on 100% of the surface: features of 1 mm bear no more" in laid(holder, WALL, 1.0).notes[-1]


def test_words_for_the_depth_change_one_that_is_not_told_in_millimetres(holder):
    half = [np.ptp(ends(holder, laid(holder, WALL, amount=0.5, **asked))) for asked in ({}, {"amplitude": 0.2}, {"relief": 0.7})]
    whole = [np.ptp(ends(holder, laid(holder, WALL, **asked))) for asked in ({}, {"amplitude": 0.2}, {"relief": 0.7})]
    assert np.divide(half, whole) == pytest.approx([0.5, 0.5, 1.0])
    assert laid(holder, WALL, amount=0.5).notes == (), "subtle was asked for"


def test_reach_is_the_depth_shared_out_between_the_sides(holder):
    for side, share in (("outwards", 0.0), ("inwards", 1.0), ("both", 0.5), ("auto", 0.25)):
        inward, outward = laid(holder, 2.0, relief=0.4, side=side, minimum_wall=1.2).reach
        assert np.allclose(inward + outward, 0.4)
        assert np.allclose(inward, 0.4 * share), side


def test_where_a_style_has_no_feature_the_wall_alone_decides(holder):
    for wall, depth in ((1.0, LEGIBLE), (4.0, 1.2), (20.0, 6.0)):
        inward, outward = laid(holder, wall, None, side="both").reach
        assert np.allclose(inward + outward, depth)
        assert np.allclose(inward, outward)


def test_the_recipe_goes_before_the_prompt_and_millimetres_before_a_share():
    recipe = Recipe.of(prompt="brick", material=LIBRARY["PLA"])
    told = Wish("brick", feature=5.0, relief=0.9)

    def sizes(**changes):
        found = Dimensions.of(Recipe.of(**{**recipe.settings, "surface": "", "tetrahedra": "", **changes}), told)
        return found.relief, found.amplitude, found.feature

    assert sizes() == (0.9, None, 5.0)
    assert sizes(relief=0.6, amplitude=0.3, feature=4.0) == (0.6, 0.3, 4.0)
    assert sizes(amplitude=0.3) == (None, 0.3, 5.0)


def test_relief_stands_out_of_thin_walls_as_out_of_walls_of_1_2_mm_but_out_of_an_edge_like_a_knife_hardly():
    assert outwards([0.0, 0.1, 0.4, 0.7, 1.2, 3.0]) == pytest.approx([0.0, 0.2, 0.8, 1.2, 1.2, 3.0])


# --- features ---------------------------------------------------------------------------------------------------


def feature(mesh, *, wall=WALL, wish=None, **asked) -> float:
    """Height of a brick on the canvas [mm]."""
    canvas = Dimensions(**asked).canvas(mesh, np.full(len(mesh.vertices), wall), wish or Wish("brick"), seed=0)
    return BRICK * canvas.scale


def test_features_of_a_size_that_is_told_are_of_that_size_whatever_the_words(fine_wall):
    assert feature(fine_wall, feature=7.0) == pytest.approx(7.0)
    assert feature(fine_wall, feature=7.0, wish=Wish("brick", size=0.5)) == pytest.approx(7.0)


def test_courses_of_the_height_that_is_told_are_drawn(fine_wall):
    ones = np.ones(len(fine_wall.vertices))
    found = target(
        fine_wall, Wish("brick"), Dimensions(feature=10.0), seed=0, thickness=10.0 * ones, inward=2.5 * ones, outward=10.0 * ones
    ).displacement
    front = fine_wall.vertex_normals[:, 1] > 0.9
    levels = np.unique(fine_wall.vertices[front, 2])
    profile = np.array([found[front & (fine_wall.vertices[:, 2] == level)].mean() for level in levels])
    courses = np.abs(np.fft.rfft(profile - profile.mean()))[1:].argmax() + 1
    assert courses == 6, "of 10 mm in 60"


def test_features_by_area_are_kept_where_faces_are_wide(holder):
    assert feature(holder) == pytest.approx(BRICK * Canvas(holder, 0).scale)


def test_two_features_lie_across_a_narrow_face():
    """A rod 4.4 mm thick and so long that its area alone asks for bricks of 4 mm."""
    rod = even(surface_of(manifold3d.Manifold.cube((600.0, 4.4, 4.4))), 8000)
    assert feature(rod, wall=4.4, nozzle=0.0) > 4.0
    assert feature(rod, wall=4.4, nozzle=0.2) == pytest.approx(0.5 * face_width(rod))
    assert 1.5 < 0.5 * face_width(rod) < 2.6


def test_features_are_small_enough_for_the_relief_a_thin_wall_bears(holder):
    assert feature(holder, wall=0.2) == pytest.approx(4.0)
    assert feature(holder, wall=0.7) == feature(holder, wall=1.2), "relief stands as high out of both"


def test_a_small_part_gets_no_features_finer_than_nozzles_unasked(sphere):
    small = sphere.displaced(np.full(len(sphere.vertices), -5.0))  # a ball of 5 mm radius
    assert feature(small) == pytest.approx(2.4)
    assert feature(small, nozzle=0.6) == pytest.approx(3.6)
    assert feature(small, nozzle=0.0) == pytest.approx(BRICK * Canvas(small, 0).scale)
    assert feature(small, wish=Wish("brick", size=0.5)) == pytest.approx(1.2), "tiny was asked for"


def test_what_is_too_fine_for_the_nozzle_is_said_with_its_size(sphere):
    canvas = Dimensions(feature=1.0).canvas(sphere, np.full(len(sphere.vertices), 20.0), Wish("brick"), seed=0)
    canvas.edge = 0.01  # the mesh would carry it
    canvas.unit("mortar joints", 3.0)
    assert canvas.notes == ["mortar joints of 0.3 mm are finer than a nozzle of 0.4 mm prints: ask for larger features"]
    canvas.notes.clear()
    canvas.unit("bricks", 4.5)
    assert canvas.notes == []


# --- walls ------------------------------------------------------------------------------------------------------


def test_thickness_that_jumps_becomes_gradual_and_never_more_than_measured(holder):
    operators = Operators(holder)
    z = holder.vertices[:, 2]
    measured = np.where(z > 50.0, 30.0, 2.0)
    gradual = gradual_thickness(operators, measured)
    assert np.all(gradual <= measured + 1e-9)
    length = np.linalg.norm(operators.edge_vectors, axis=1)
    assert np.all(np.abs(gradual[operators.head] - gradual[operators.tail]) <= 0.3 * length + 1e-9)
    assert np.allclose(gradual[z < 44.0], 2.0)
    assert gradual[z > 90.0].max() > 10.0


def test_one_wild_vertex_does_not_sway_the_thickness(holder):
    measured = np.full(len(holder.vertices), WALL)
    measured[[100, 2000]] = 0.0, 500.0
    assert np.allclose(gradual_thickness(Operators(holder), measured), WALL)
