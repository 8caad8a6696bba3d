"""The viewer without a browser: traits, buffers, the legend, the probe, and nothing left behind."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.pictures.colormap import PLAIN
from mechstyle.records.mesh import SurfaceMesh
from mechstyle_widgets.viewer.layers import Layer, Subject
from mechstyle_widgets.viewer.scene import BACKGROUNDS
from mechstyle_widgets.viewer.shaders import HIDDEN, MAXIMUM, MINIMUM, NOTHING, OPEN, OWN, PICKED
from mechstyle_widgets.viewer.viewer import Viewer
from support.models import alive


@pytest.fixture
def painted(sphere):
    """The sphere, red above the equator and blue below."""
    up = sphere.vertices[:, 2] > 0
    return sphere.coloured(np.where(up[:, None], [0.5, 0.0, 0.0], [0.0, 0.0, 0.5]))


@pytest.fixture
def height(sphere):
    """A field over the sphere: height above its lowest point [mm], 0 to 20."""
    return Layer("height", sphere.vertices[:, 2] + 10.0, "height <above> the floor", "mm")


def scene(viewer):
    return viewer._scenes[0]


# --- buffers ------------------------------------------------------------------------------------------------------


def test_the_buffers_hold_the_part(sphere):
    buffers = scene(Viewer(sphere))._geometry.attributes
    assert buffers["position"].array.dtype == np.float32
    assert np.allclose(buffers["position"].array, sphere.vertices, atol=1e-6)
    assert np.allclose(buffers["normal"].array, sphere.vertices / 10.0, atol=0.01)
    assert buffers["index"].array.dtype == np.uint32  # more than 65 535 vertices can be named
    assert np.array_equal(buffers["index"].array.reshape(-1, 3), sphere.faces)


def test_the_colours_of_the_part_reach_the_screen_as_they_are(painted, sphere):
    """They are display colours already."""
    assert np.array_equal(scene(Viewer(painted))._colours.array, painted.colours)
    assert np.allclose(scene(Viewer(sphere))._colours.array, PLAIN)


def test_new_fields_and_shapes_reuse_the_buffers_that_are_there(sphere, height):
    """Replacing a buffer leaks in the browser."""
    viewer = Viewer(sphere, [height])
    before, buffers = len(alive()), dict(scene(viewer)._geometry.attributes)
    stretched = sphere.moved(sphere.vertices * [1.0, 1.0, 3.0])
    viewer.subject = Subject(stretched, (replace(height, values=height.values[::-1]),))
    assert all(scene(viewer)._geometry.attributes[name] is buffer for name, buffer in buffers.items())
    assert np.allclose(buffers["position"].array, stretched.vertices, atol=1e-5)
    assert np.allclose(buffers["normal"].array, stretched.vertex_normals, atol=1e-6)
    assert np.allclose(buffers["place"].array, OPEN + height.values[::-1] / 20.0, atol=1e-6)
    assert len(alive()) == before


def test_the_middle_of_the_view_is_what_one_orbits_about(sphere):
    """The controls orbit about the origin of the scene, so the part is moved there; floor and part are in view."""
    moved = sphere.moved(sphere.vertices + np.array([100.0, -50.0, 7.0]))
    viewer = Viewer(moved)
    assert np.allclose(scene(viewer).three.children[0].position, -np.array(viewer._orbit.home.target))
    across = np.abs(viewer._orbit.seen.project(moved.vertices)[:, :2])
    assert across.max() < 1.0
    assert across.max() > 0.6  # and it is no dot


# --- layers -------------------------------------------------------------------------------------------------------


def test_the_first_field_is_shown_first(sphere, height):
    assert Viewer(sphere).layer == "style"
    assert Viewer(sphere, [height]).layer == "height"


def test_a_field_is_painted_by_its_place_on_the_scale(sphere, height):
    viewer = Viewer(sphere, [height])
    assert np.allclose(scene(viewer)._places.array, OPEN + height.values / 20.0, atol=1e-6)
    viewer.layer = "style"
    assert np.all(scene(viewer)._places.array == OWN)


def test_the_ramp_ends_at_the_threshold_and_beyond_it_is_above_one(sphere, height):
    viewer = Viewer(sphere, [replace(height, threshold=15.0)])
    places = scene(viewer)._places.array
    assert np.array_equal(places > 1.0, height.values > 15.0)
    assert places[np.abs(height.values - 15.0).argmin()] == pytest.approx(1.0, abs=0.05)


def test_without_a_threshold_the_end_of_the_scale_is_not_painted_as_a_threshold_reached(sphere, height):
    """The shader outlines and hatches from 1 on."""
    reached = scene(Viewer(sphere, [replace(height, limits=(0.0, 20.0), threshold=10.0)]))._places.array
    for limits in ((0.0, 10.0), (0.0, 20.0)):
        places = scene(Viewer(sphere, [replace(height, limits=limits)]))._places.array
        assert places.max() < 0.0 < reached.min() + 1e-6


def test_what_is_not_a_number_is_told_apart_and_does_not_spoil_the_scale(sphere, height):
    holes = height.values.copy()
    holes[:100] = np.nan
    places = scene(Viewer(sphere, [replace(height, values=holes)]))._places.array
    assert np.all(places[:100] == NOTHING)
    assert places.max() == OPEN + 1.0


@pytest.mark.parametrize("value", [0.0, 3.0, np.nan])
def test_a_constant_field_can_be_shown_and_has_no_extremes(sphere, value):
    viewer = Viewer(sphere, [Layer("flat", np.full(len(sphere.vertices), value))])
    assert np.all(scene(viewer)._kinds.array == HIDDEN)


def test_a_layer_can_be_put_in_the_place_of_another(sphere, height):
    viewer = Viewer(sphere, [height])
    viewer.put(Layer("depth", -height.values))
    viewer.put(replace(height, limits=(0.0, 40.0)))
    assert [layer.name for layer in viewer.subject.layers] == ["height", "depth"]
    assert [name for _, name in viewer._toolbar.choice.options] == ["style", "height", "depth"]
    assert viewer.layer == "height"
    assert scene(viewer)._places.array.max() == pytest.approx(OPEN + 0.5)


def test_the_menu_and_the_trait_are_one(sphere, height):
    viewer = Viewer(sphere, [height])
    viewer._toolbar.choice.value = "style"
    assert viewer.layer == "style"
    viewer.layer = "height"
    assert viewer._toolbar.choice.value == "height"


def test_a_subject_without_the_layer_on_show_shows_the_style(sphere, height):
    viewer = Viewer(sphere, [height])
    viewer.subject = Subject(sphere)
    assert viewer.layer == "style"


# --- markers and the probe ----------------------------------------------------------------------------------------


def test_the_extremes_are_marked_where_they_are(sphere, height):
    spots, kinds = scene(Viewer(sphere, [height]))._spots, scene(Viewer(sphere, [height]))._kinds
    assert np.allclose(spots.array[:2], [(0.0, 0.0, 10.0), (0.0, 0.0, -10.0)], atol=1e-5)
    assert kinds.array[:3].tolist() == [MAXIMUM, MINIMUM, HIDDEN]


def test_the_markers_can_be_put_away(sphere, height):
    viewer = Viewer(sphere, [height])
    viewer.markers = False
    assert np.all(scene(viewer)._kinds.array == HIDDEN)


def test_a_click_asks_about_the_nearest_corner_of_the_face(painted, height):
    """The vertices that pythreejs names are wrong ones, so the face and the point say which."""
    viewer = Viewer(painted, [height])
    face, wanted = 5, int(painted.faces[5, 1])
    viewer._picker.three.faceIndex = face
    viewer._picker.three.point = tuple(painted.vertices[wanted] - viewer._orbit.home.target + 0.01)
    assert viewer.probed == wanted
    told = viewer._table.value
    assert viewer.probed == wanted
    assert f"{height.values[wanted]:.4g} mm" in told
    assert "height &lt;above&gt;" in told
    assert scene(viewer)._kinds.array[2] == PICKED
    assert np.allclose(scene(viewer)._spots.array[2], painted.vertices[wanted], atol=1e-5)


def test_the_end_of_a_drag_is_no_click(sphere):
    viewer = Viewer(sphere)
    viewer._orbit.three.position = (30.0, 30.0, 30.0)
    viewer._picker.three.faceIndex = 5
    viewer._picker.three.point = (1.0, 2.0, 3.0)
    assert viewer.probed is None


def test_a_rounded_camera_position_is_no_drag(sphere):
    """The browser sends one with the first click of all."""
    viewer = Viewer(sphere)
    viewer._orbit.three.position = tuple(x * (1 + 1e-12) for x in viewer._orbit.three.position)
    viewer._picker.three.faceIndex = 5
    viewer._picker.three.point = (1.0, 2.0, 3.0)
    assert viewer.probed is not None


def test_every_click_is_told_with_its_place_be_it_the_same_again(sphere):
    viewer, told = Viewer(sphere), []
    viewer.on_click(told.append)
    place = sphere.corners[5].mean(axis=0)
    for _ in range(2):
        viewer._picker.three.faceIndex = 5
        viewer._picker.three.point = tuple(place - viewer._orbit.home.target)
    assert len(told) == 2
    assert np.allclose(told, place, atol=1e-9)


def test_what_is_protected_is_hatched_and_told(sphere):
    viewer = Viewer(sphere)
    assert "protected" not in viewer._legend.value
    viewer.protected = sphere.vertices[:, 2] > 0
    assert np.array_equal(scene(viewer)._protected.array, viewer.protected)
    assert "stays plain: 4" in viewer._legend.value  # nearly one half: the equator is not
    viewer.protected = None
    assert not scene(viewer)._protected.array.any()
    with pytest.raises(BadInput, match="has shape"):
        viewer.protected = np.zeros(3, bool)


def test_a_drawing_that_fails_says_so_until_one_does_not(sphere, monkeypatch):
    """It is drawn by the event loop, which keeps errors to its log."""
    viewer = Viewer(sphere)
    with monkeypatch.context() as patch:
        patch.setattr(scene(viewer), "band", lambda _bands: 1 / 0)
        viewer.stepped = True
    assert "This did not work, by an unexpected ZeroDivisionError" in viewer._said.value
    viewer.stepped = False
    assert viewer._said.value == ""


def test_an_unknown_vertex_is_refused(sphere):
    with pytest.raises(BadInput, match="there is no vertex 4098: the part has 4098"):
        Viewer(sphere).probed = 4098


# --- the legend ---------------------------------------------------------------------------------------------------


def test_the_legend_says_what_is_shown_and_in_which_unit(sphere, height):
    bar = Viewer(sphere, [height])._legend.value
    for text in ("height &lt;above&gt; the floor [mm]", ">0<", ">20<", "max 20 mm", "min 0 mm"):
        assert text in bar


def test_the_threshold_is_counted_in_area(sphere, height):
    """A cap of a sphere has the share of its area that its height has of the diameter (Archimedes): 5 mm of 20 mm."""
    bar = Viewer(sphere, [replace(height, threshold=15.0)])._legend.value
    share = float(bar.split("% of")[0].rsplit(">", 1)[1])
    assert share == pytest.approx(25.0, abs=1.0)  # to a ring of vertices
    assert "above the limit of 15 mm" in bar
    assert "nothing is above" in Viewer(sphere, [replace(height, threshold=25.0)])._legend.value


def test_the_legend_goes_with_the_field(painted, height):
    viewer = Viewer(painted, [height])
    viewer.layer = "style"
    assert viewer._legend.value == ""


def test_the_scale_bar_is_as_long_as_it_says(sphere):
    """Seen from the fitted distance a bar in the middle spans its length over the height of the view there."""
    viewer = Viewer(sphere, height=400)
    camera = viewer._orbit.seen
    length, pixels = (float(viewer._scale.value.split(mark)[1].split(end)[0]) for mark, end in (("scale bar of ", " mm"), ("width:", "px")))
    ends = camera.project([camera.target, camera.target + length * camera.axes[1]])
    assert pixels == pytest.approx((ends[1, 1] - ends[0, 1]) * 200, abs=0.6)


# --- cameras ------------------------------------------------------------------------------------------------------


def test_fitting_keeps_the_direction_and_a_view_changes_it(sphere):
    viewer = Viewer(sphere)
    viewer._orbit.three.position = (0.0, -500.0, 0.0)
    viewer.fit()
    assert (viewer._orbit.seen.azimuth, viewer._orbit.seen.elevation) == pytest.approx((0.0, 0.0), abs=1e-6)
    assert viewer._orbit.seen.distance < 200.0
    viewer.fit("below")
    assert viewer._orbit.seen.elevation == pytest.approx(-38.0)
    with pytest.raises(BadInput, match="unknown view 'bottom'"):
        viewer.fit("bottom")


def test_the_original_beside_it_shares_the_camera(painted, sphere, height):
    viewer = Viewer(painted, [height], original=Subject(sphere, (height,)))
    viewer.beside = True
    one, other = viewer._stage.children
    assert one.camera is other.camera
    assert one.scene is not other.scene
    assert (one.width, other.width) == (320, 320)
    assert one.camera.aspect == pytest.approx(320 / 440)
    viewer.beside = False
    assert viewer._stage.children == (one,)
    assert (one.width, one.camera.aspect) == (640, pytest.approx(640 / 440))


def test_without_an_original_nothing_can_stand_beside(sphere):
    viewer = Viewer(sphere)
    assert viewer._toolbar.both.layout.display == "none"
    viewer.beside = True
    assert len(viewer._stage.children) == 1


def test_the_background_follows_the_theme(sphere):
    viewer = Viewer(sphere)
    viewer.theme = "dark"
    assert scene(viewer).three.background == BACKGROUNDS["dark"]


def test_the_picture_is_a_png_of_what_is_shown(sphere, height):
    viewer = Viewer(sphere, [height], original=Subject(sphere, (height,)))
    one = viewer.picture()
    viewer.beside = True
    assert one.png.startswith(b"\x89PNG")
    assert viewer.picture().png != one.png


# --- refusals -----------------------------------------------------------------------------------------------------


def test_a_wrong_number_of_values_is_refused(sphere):
    with pytest.raises(BadInput, match="layer 'height' has 3 values, but the part has 4098 vertices"):
        Viewer(sphere, [Layer("height", [1.0, 2.0, 3.0])])


def test_another_part_is_refused(sphere, cube):
    with pytest.raises(BadInput, match="other faces"):
        Viewer(sphere).subject = Subject(cube)


def test_an_original_of_another_part_is_refused_before_anything_is_made(sphere, cube):
    before = alive()
    with pytest.raises(BadInput, match="other faces"):
        Viewer(sphere, original=Subject(cube))
    assert alive() == before


def test_a_layer_that_is_not_there_is_refused(sphere):
    with pytest.raises(BadInput, match="unknown layer 'stress': did you mean 'style'"):
        Viewer(sphere).layer = "stress"


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"limits": (1.0, 1.0)}, "two different ends"),
        ({"threshold": float("nan")}, "must be a number"),
        ({"name": "style"}, "the part's own look"),
        ({"values": np.zeros((2, 2))}, "one value for each vertex"),
    ],
)
def test_a_wrong_layer_is_refused(height, wrong, words):
    with pytest.raises(BadInput, match=words):
        replace(height, **wrong)


def test_two_layers_of_one_name_are_refused(sphere, height):
    with pytest.raises(BadInput, match="two layers are called 'height'"):
        Subject(sphere, (height, height))


@pytest.mark.parametrize("wrong", [{"theme": "pink"}, {"layers": [Layer("x", [1.0])]}])
def test_a_refused_viewer_leaves_nothing_behind(sphere, wrong):
    before = alive()
    with pytest.raises(BadInput):
        Viewer(sphere, **wrong)
    assert alive() == before


# --- closing ------------------------------------------------------------------------------------------------------


def test_ten_viewers_opened_and_closed_leave_nothing_behind(cube):
    before, layer = alive(), Layer("x", np.arange(8.0))
    for _ in range(10):
        viewer = Viewer(cube, [layer], original=Subject(cube))
        viewer.beside = True
        viewer.beside = False
        viewer.close()
    assert alive() == before
    viewer.close()


def test_a_closed_viewer_draws_nothing_whatever_it_still_hears(cube):
    """It made renderers anew from what was closed, which failed, and what it had made stayed in the kernel."""
    before, viewer = alive(), Viewer(cube, original=Subject(cube))
    viewer.close()
    viewer.beside, viewer.probed = True, 3
    assert alive() == before


def test_closing_one_viewer_leaves_the_other(painted, height):
    kept, gone = Viewer(painted, [height]), Viewer(painted, [height])
    gone.close()
    kept.layer = "style"
    assert scene(kept)._places.comm is not None
    assert kept._legend.comm is not None


def test_repr_never_prints_arrays(painted, height):
    said = "Viewer(SurfaceMesh(4098 vertices, 8192 faces, 20.0 x 20.0 x 20.0 mm), layer='height')"
    assert repr(Viewer(painted, [height])) == said


def test_a_part_of_a_single_point_can_be_shown():
    assert Viewer(SurfaceMesh([(1.0, 1.0, 1.0)] * 3, [(0, 1, 2)])).layer == "style"


def test_without_the_extra_the_import_says_what_to_install():
    program = "import sys; sys.modules['pythreejs'] = None; from mechstyle_widgets import Viewer"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert "the notebook widgets need pythreejs, which is not installed: pip install 'mechstyle[jupyter]'" in done.stderr
