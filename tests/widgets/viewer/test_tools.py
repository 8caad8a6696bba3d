"""The tools of a view: cut, projection, measure, places, and the keys that stand for each."""

from __future__ import annotations

import csv
import io
from dataclasses import replace

import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.records.mesh import SurfaceMesh
from mechstyle_widgets.viewer.layers import Layer
from mechstyle_widgets.viewer.probe import struck
from mechstyle_widgets.viewer.shaders import HIDDEN, MAXIMUM, MOST_PINS, PIN, WHOLE
from mechstyle_widgets.viewer.viewer import Viewer
from support.models import alive


@pytest.fixture
def stress(sphere):
    """A field that rises along x, from 20 MPa."""
    return Layer("stress", 20.0 + sphere.vertices[:, 0], unit="MPa")


@pytest.fixture
def viewer(sphere, stress):
    return Viewer(sphere, [stress, Layer("stays_bent", 45.0 / stress.values)])


@pytest.fixture
def painted_sphere(sphere):
    return sphere.coloured(np.full((len(sphere.vertices), 3), 0.5))


def click(viewer, place):
    """Click on the face that is nearest to a place [mm], as the browser tells it, whatever is cut off."""
    mesh = viewer.subject.mesh
    face = int(np.linalg.norm(mesh.corners.mean(axis=1) - place, axis=1).argmin())
    viewer._pick(tuple(np.asarray(place) - viewer._orbit.home.target), face)


def told(viewer):
    """What the shader of the part is told to cut off."""
    uniforms = viewer._scenes[0].part.material.uniforms
    return uniforms["cut"]["value"], uniforms["filled"]["value"]


# --- the cut ------------------------------------------------------------------------------------------------------


def test_the_cut_opens_towards_the_eye_and_closes_again(viewer):
    viewer.key("x")
    assert viewer.section.on
    nearest = viewer._orbit.seen.eye
    assert not viewer.section.keeps(nearest)
    assert viewer.section.keeps(-nearest)
    assert told(viewer) == (list(viewer.section.plane), 1.0)
    viewer.key("Escape")
    assert told(viewer)[0] == list(WHOLE)


def test_the_plane_moves_along_its_axis_and_never_leaves_the_part(viewer):
    viewer.section.on, viewer.section.axis = True, "z"
    assert viewer.section.at == pytest.approx(0.0, abs=1e-6)
    viewer.key("PageUp")
    assert viewer.section.at == pytest.approx(1.0, abs=1e-6)
    for _ in range(30):
        viewer.key("PageDown")
    assert viewer.section.at == pytest.approx(-10.0, abs=1e-5)
    assert viewer.section.keeps([(0.0, 0.0, -10.1), (0.0, 0.0, 1.0)]).tolist() == [True, False]
    viewer.section.flipped = True
    assert viewer.section.keeps([(0.0, 0.0, -10.1), (0.0, 0.0, 1.0)]).tolist() == [False, True]


def test_the_part_is_cut_and_textures_keep_their_names(viewer):
    viewer.section.on = True
    material = viewer._scenes[0].part.material
    assert material.uniforms["cut"]["value"] == list(viewer.section.plane)
    assert list(material.uniforms)[-1] == "ramp", "pythreejs gives a texture the name of whichever uniform comes last"


def test_a_marker_on_what_is_cut_off_goes_with_it(viewer):
    viewer.layer = "stress"
    viewer.section.on, viewer.section.axis = True, "x"
    assert viewer._scenes[0]._kinds.array[0] == HIDDEN, "the greatest value lies at x = 10"
    viewer.section.flipped = True
    assert viewer._scenes[0]._kinds.array[0] == MAXIMUM


def test_a_click_into_the_opening_means_what_lies_behind_it(viewer):
    viewer.fit("front")  # towards +y
    viewer.section.axis, viewer.section.flipped, viewer.section.filled, viewer.section.on = "y", True, False, True
    click(viewer, (0.0, -10.0, 0.0))
    assert viewer.subject.mesh.vertices[viewer.probed] == pytest.approx((0.0, 10.0, 0.0), abs=0.6)


def test_on_a_solid_cut_one_measures_in_its_plane(viewer):
    viewer.fit("front")
    viewer.section.axis, viewer.section.flipped, viewer.section.on, viewer.tool = "y", True, True, "measure"
    for place in ((-3.0, -9.5, 0.0), (3.0, -9.5, 0.0)):
        click(viewer, place)
    ends = np.array(viewer.measured)
    assert np.abs(ends[:, 1]).max() < 1e-6
    assert ends[1, 0] - ends[0, 0] > 6.0, "the plane is farther away than where the mouse would have met the sphere"


def test_the_picture_is_cut_open_as_the_view_is(viewer, painted_sphere):
    viewer.section.on, viewer.section.axis, viewer.section.at = True, "x", 2.0
    mesh, values = viewer.section.applied(painted_sphere, painted_sphere.vertices[:, 0])
    assert mesh.vertices[:, 0].max() == pytest.approx(2.0)
    assert values == pytest.approx(mesh.vertices[:, 0], abs=1e-6), "values between vertices are between theirs"
    assert mesh.face_areas.sum() == pytest.approx(0.6 * painted_sphere.face_areas.sum(), rel=0.002)  # of a sphere areas go by height
    assert mesh.colours.shape == mesh.vertices.shape
    whole = viewer.picture().png
    viewer.section.on = False
    assert viewer.picture().png != whole


@pytest.mark.parametrize("painted", [False, True])
def test_a_cut_that_leaves_but_the_corners_in_its_plane_leaves_all_of_the_part_in_a_picture(cube, painted):
    """At the end of its slider the plane lies in a face: nothing is beyond it, and the picture of the notebook could not be drawn."""
    mesh = cube.coloured(np.full((len(cube.vertices), 3), 0.5)) if painted else cube
    values = mesh.vertices[:, 0]
    viewer = Viewer(mesh, [Layer("stress", values)])
    viewer.section.axis, viewer.section.on = "z", True
    for at, flipped in ((mesh.vertices[:, 2].min(), False), (mesh.vertices[:, 2].max(), True)):
        viewer.section.at, viewer.section.flipped = float(at), flipped
        assert viewer.section.keeps(mesh.vertices).any()
        found, shown = viewer.section.applied(mesh, values)
        assert len(found.faces) == len(mesh.faces) == len(shown[mesh.faces])


def test_a_line_of_sight_meets_the_nearest_face_that_is_left():
    cube = SurfaceMesh([(x, y, z) for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)],
                       [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4),
                        (1, 5, 7), (1, 7, 3)])  # fmt: skip
    eye, along = np.array([0.3, -2.0, 0.4]), np.array([0.0, 1.0, 0.0])
    where, face = struck(cube, eye, along, lambda points: np.ones(len(points), bool))
    assert where == pytest.approx((0.3, 0.0, 0.4))
    assert face in (4, 5)
    where, _ = struck(cube, eye, along, lambda points: points[:, 1] > 0.5)
    assert where == pytest.approx((0.3, 1.0, 0.4))
    assert struck(cube, eye, -along, lambda points: np.ones(len(points), bool)) is None


# --- projection ---------------------------------------------------------------------------------------------------


def test_in_parallel_what_is_far_is_as_large_as_what_is_near(viewer):
    ends = np.array([(-5.0, -10.0, 0.0), (5.0, -10.0, 0.0), (-5.0, 10.0, 0.0), (5.0, 10.0, 0.0)])
    viewer.fit("front")
    scale = viewer._orbit.pixels_per_mm(400)

    def near_over_far():
        x = viewer._orbit.seen.project(ends)[:, 0]
        return (x[1] - x[0]) / (x[3] - x[2])

    assert near_over_far() > 1.2
    viewer.key("o")
    assert near_over_far() == pytest.approx(1.0, abs=0.02)
    assert viewer._orbit.pixels_per_mm(400) == pytest.approx(scale), "what is in the middle stays as large as it is"
    viewer.fit()
    assert viewer.parallel
    assert viewer._orbit.three.near < viewer._orbit.seen.distance - 10.0
    viewer.parallel = False
    assert near_over_far() > 1.2


# --- measure ------------------------------------------------------------------------------------------------------


def test_two_clicks_measure_and_a_third_begins_anew(viewer):
    heard = []
    viewer.on_click(heard.append)
    viewer.key("m")
    click(viewer, (0.0, 0.0, 10.0))
    assert "a second place" in viewer._said.value
    click(viewer, (0.0, 0.0, -10.0))
    assert "<b>20.00 mm</b>" in viewer._said.value
    assert "z -20.00" in viewer._said.value
    assert viewer._scenes[0]._ruler.visible
    bar = viewer._scenes[0]._bar.array
    assert np.ptp(bar[:, 2]) == pytest.approx(20.0)
    assert 0.1 < np.ptp(bar[:, 0]) < 0.5, "a line is a pixel wide, whatever width it is given"
    click(viewer, (10.0, 0.0, 0.0))
    assert len(viewer.measured) == 1
    assert not viewer._scenes[0]._ruler.visible
    assert (heard, viewer.probed) == ([], None), "a click that measures neither paints nor asks"


@pytest.mark.parametrize("tip", [(0.0, 0.0, 30.0), (0.0, 0.0, -10.0), (25.0, 0.0, 10.0), (0.0, 0.0, 10.0)])
def test_an_arrow_ends_in_a_head_at_its_tip(viewer, tip):
    foot = (0.0, 0.0, 10.0)
    viewer.arrow = (foot, tip)
    bar, along = viewer._scenes[0]._bar.array.astype(np.float64), np.subtract(tip, foot)
    length = float(np.linalg.norm(along))
    places = (bar - foot) @ along / max(length, 1e-12)
    assert np.isfinite(bar).all()
    assert (places.min(), places.max()) == pytest.approx((0.0, length), abs=1e-4)
    if length:
        off = np.linalg.norm(bar - foot - np.outer(places, along / length), axis=1)
        assert off[places < 0.4 * length].max() < 0.5 * off.max(), "the shaft is thinner than the head"


def test_escape_leaves_the_tool_then_the_measure_then_the_cut(viewer):
    viewer.key("x")
    viewer.key("m")
    viewer._pick((0.0, 10.0, 0.0), 0)
    steps = []
    for _ in range(3):
        viewer.key("Escape")
        steps.append((viewer.tool, len(viewer.measured), viewer.section.on))
    assert steps == [("", 1, True), ("", 0, True), ("", 0, False)]


def test_enter_is_a_click_in_the_middle(viewer):
    viewer.fit("top")
    viewer.key("Enter")
    assert viewer.subject.mesh.vertices[viewer.probed] == pytest.approx((0.0, 0.0, 10.0), abs=0.8)


# --- places -------------------------------------------------------------------------------------------------------


def test_places_stay_in_a_list_with_their_values(viewer, stress):
    viewer.key("a")
    for place in ((10.0, 0.0, 0.0), (-10.0, 0.0, 0.0), (10.0, 0.0, 0.0)):
        click(viewer, place)
    assert len(viewer.places) == 2, "a place that is there already is not kept twice"
    assert [row[1:] for row in viewer._list.rows] == [["30", "1.5", "–"], ["10", "4.5", "–"]]
    assert viewer._scenes[0]._kinds.array[5:8].tolist() == [PIN + 1, PIN + 2, HIDDEN]
    viewer.put(replace(stress, values=stress.values + 15.0))
    assert [row[1] for row in viewer._list.rows] == ["45", "25"], "they are those of what is on show"


def test_the_table_holds_all_that_is_known_of_each_place(viewer, sphere, stress):
    viewer.places = (3, 70)
    table = list(csv.DictReader(io.StringIO(viewer._list.table)))
    for row, vertex in zip(table, (3, 70), strict=True):
        assert [float(row[f"{axis} [mm]"]) for axis in "xyz"] == pytest.approx(sphere.vertices[vertex].tolist(), rel=1e-5, abs=1e-9)
        assert float(row["stress [MPa]"]) == pytest.approx(stress.values[vertex], rel=1e-5)
    viewer.put(replace(stress, values=np.full_like(stress.values, np.nan)))
    assert next(csv.DictReader(io.StringIO(viewer._list.table)))["stress [MPa]"] == ""


def test_a_place_is_flown_to_taken_away_and_the_list_cleared(viewer):
    viewer.places = (3, 70, 200)
    lines = viewer._list._lines
    lines[1][0].click()
    assert viewer.probed == 70
    lines[1][-1].click()
    assert viewer.places == (3, 200)
    lines[2][-1].click()  # a click that comes late, on a line that is gone
    assert viewer.places == (3, 200)
    viewer.places = (3, 200, 5)
    assert len(viewer._list._lines) == 3, "lines are used again"
    viewer._list.children[0].children[2].click()
    assert (viewer.places, viewer._list.rows, viewer._list.table, viewer._list.layout.display) == ((), [], "", "none")


def test_a_viewer_with_places_leaves_nothing_behind(sphere):
    before = alive()
    viewer = Viewer(sphere)
    viewer.places = (1, 2, 3)
    viewer.places = (1,)
    viewer.close()
    assert alive() == before


def test_there_are_no_more_places_than_numbers_and_none_off_the_part(viewer):
    viewer.places = tuple(range(MOST_PINS + 5))
    assert viewer.places == tuple(range(5, MOST_PINS + 5))
    with pytest.raises(BadInput, match="there is no vertex 5000"):
        viewer.places = (5000,)


def test_a_view_can_be_chosen_again_once_the_part_was_turned(viewer):
    """The menu went on showing the view that was chosen before, and a browser does not tell of a choice that changes nothing."""
    menu = viewer._toolbar._view
    menu.value = "front"
    seen = viewer._orbit.three.position
    viewer.key("ArrowLeft")
    assert viewer._orbit.three.position != pytest.approx(seen)
    menu.value = "front"
    assert viewer._orbit.three.position == pytest.approx(seen)


def test_the_buttons_and_the_keys_are_one(viewer):
    viewer._toolbar._tools["measure"].value = True
    assert viewer.tool == "measure"
    viewer._toolbar._tools["places"].value = True
    assert (viewer.tool, viewer._toolbar._tools["measure"].value) == ("places", False)
    viewer.key("a")
    assert (viewer.tool, viewer._toolbar._tools["places"].value) == ("", False)
    viewer._toolbar._cut.value = True
    assert viewer.section.on
    viewer.key("x")
    assert not viewer._toolbar._cut.value
    viewer.key("l")
    assert viewer.layer == viewer._toolbar.choice.value == "stays_bent"
    viewer.key("l")
    assert viewer.layer == "style"
