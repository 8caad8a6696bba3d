"""The viewer without a browser: traits, buffers, the colour bar, and nothing left behind."""

import subprocess
import sys

import numpy as np
import pytest
from ipywidgets import Widget
from ipywidgets.widgets.widget import _instances as alive

from mechstyle.errors import BadInput
from mechstyle.mesh import SurfaceMesh
from mechstyle_widgets import Viewer
from mechstyle_widgets.viewer import BACKGROUNDS, PLASTIC


@pytest.fixture
def painted(sphere):
    """The sphere, red above the equator and blue below."""
    up = sphere.vertices[:, 2] > 0
    return sphere.coloured(np.where(up[:, None], [0.5, 0.0, 0.0], [0.0, 0.0, 0.5]))


@pytest.fixture
def height(sphere):
    """A field over the sphere: height above its lowest point [mm], 0 to 20."""
    return sphere.vertices[:, 2] + 10.0


@pytest.fixture(autouse=True)
def close_what_a_test_opened():
    yield
    Widget.close_all()


# --- buffers ------------------------------------------------------------------------------------------------------


def test_the_buffers_hold_the_part(sphere):
    viewer = Viewer(sphere)
    assert viewer._position.array.dtype == np.float32
    assert np.allclose(viewer._position.array, sphere.vertices, atol=1e-6)
    assert np.allclose(viewer._normal.array, sphere.vertices / 10.0, atol=0.01)
    assert viewer._index.array.dtype == np.uint32  # more than 65 535 vertices can be named
    assert np.array_equal(viewer._index.array.reshape(-1, 3), sphere.faces)


def test_the_colours_of_the_part_reach_the_screen_as_they_are(painted):
    """They are display colours already."""
    assert np.array_equal(Viewer(painted)._colour.array, painted.colours)


def test_a_part_without_colours_looks_like_plain_plastic(sphere):
    assert np.allclose(Viewer(sphere)._colour.array, PLASTIC)


def test_new_values_reuse_the_buffer_that_is_there(sphere, height):
    """Replacing a buffer leaks in the browser."""
    viewer = Viewer(sphere, height)
    before, buffer, colours = len(alive), viewer._geometry.attributes["color"], viewer._colour.array
    viewer.values = height[::-1]
    viewer.layer = "style"
    viewer.mesh = sphere.displaced(np.ones(len(height)))
    assert viewer._geometry.attributes["color"] is buffer
    assert not np.array_equal(buffer.array, colours)
    assert len(alive) == before


def test_the_part_moves_with_its_normals(sphere):
    stretched = sphere.moved(sphere.vertices * [1.0, 1.0, 3.0])
    viewer = Viewer(sphere)
    viewer.mesh = stretched
    assert np.allclose(viewer._position.array, stretched.vertices, atol=1e-5)
    assert np.allclose(viewer._normal.array, stretched.vertex_normals, atol=1e-6)


def test_the_part_is_looked_at_in_its_centre_and_is_whole_in_view(sphere):
    """The controls orbit about the origin, so the part's centre is moved there."""
    moved = sphere.moved(sphere.vertices + np.array([100.0, -50.0, 7.0]))
    scene = Viewer(moved)._scene
    part, camera = scene.children[:2]
    assert np.allclose(part.position, [-100.0, 50.0, -7.0])
    distance = np.linalg.norm(camera.position)
    assert camera.near < distance - 10.0
    assert distance + 10.0 < camera.far
    assert np.degrees(np.arcsin(10.0 / distance)) < camera.fov / 2


# --- the field ----------------------------------------------------------------------------------------------------


def test_values_are_shown_first_if_there_are_any(sphere, height):
    assert Viewer(sphere).layer == "style"
    assert Viewer(sphere, height).layer == "field"


def test_a_field_runs_from_the_pale_to_the_dark_end(sphere, height):
    viewer = Viewer(sphere, height)
    low, middle, high = (viewer._colour.array[np.argmin(np.abs(height - at))].sum() for at in (0.0, 10.0, 20.0))
    assert low > middle > high
    assert (viewer.scale.low, viewer.scale.high) == pytest.approx((0.0, 20.0))


def test_given_limits_hold_whatever_the_values(sphere, height):
    """Two iterations can be compared only on one scale."""
    viewer = Viewer(sphere, height, limits=(0.0, 100.0))
    before = viewer._colour.array
    assert (viewer.scale.low, viewer.scale.high) == (0.0, 100.0)
    viewer.values = np.where(height > 19.9, 80.0, height)
    assert np.array_equal(viewer._colour.array[height < 19.9], before[height < 19.9])


def test_what_is_not_a_number_is_grey_and_does_not_spoil_the_scale(sphere, height):
    holes = height.copy()
    holes[:100] = np.nan
    viewer = Viewer(sphere, holes)
    assert np.ptp(viewer._colour.array[:100], axis=1).max() < 1e-6
    assert viewer.scale.high == pytest.approx(np.nanmax(holes))


@pytest.mark.parametrize("value", [0.0, 3.0, np.nan])
def test_a_constant_field_can_be_shown(sphere, value):
    assert "field" in repr(Viewer(sphere, np.full(len(sphere.vertices), value)))


def test_the_threshold_is_counted_in_area_and_set_apart(sphere, height):
    """A cap of a sphere has the share of its area that its height has of the diameter (Archimedes): 5 mm of 20 mm."""
    viewer = Viewer(sphere, height, "height", "mm", threshold=15.0)
    share = float(viewer._bar.value.split("%")[0].rsplit(" ", 1)[1])
    assert share == pytest.approx(25.0, abs=1.0)  # to a ring of vertices
    above = viewer._colour.array[height > 15.0]
    assert np.all(above == above[0])
    assert not np.any(np.all(viewer._colour.array[height < 15.0] == above[0], axis=1))


def test_the_colour_bar_says_what_is_shown_and_in_which_unit(sphere, height):
    bar = Viewer(sphere, height, "von Mises <stress>", "MPa")._bar.value
    assert "von Mises &lt;stress&gt; [MPa]" in bar
    assert ">0<" in bar
    assert ">20<" in bar


def test_the_colour_bar_goes_with_the_field(painted, height):
    viewer = Viewer(painted, height, "height", "mm")
    viewer.layer = "style"
    assert viewer._bar.value == ""
    assert np.array_equal(viewer._colour.array, painted.colours)
    viewer.values = None
    assert viewer.layer == "style"


def test_the_buttons_and_the_trait_are_one(painted, height):
    viewer = Viewer(painted, height)
    viewer._choice.value = "style"
    assert viewer.layer == "style"
    viewer.layer = "field"
    assert viewer._choice.value == "field"


def test_the_buttons_are_there_only_if_there_is_a_choice(painted, sphere, height):
    assert Viewer(painted, height)._choice.layout.display == ""
    assert Viewer(painted)._choice.layout.display == "none"
    assert Viewer(sphere, height)._choice.layout.display == "none"


def test_the_background_follows_the_theme(sphere):
    viewer = Viewer(sphere)
    assert viewer._scene.background == BACKGROUNDS["light"]
    viewer.theme = "dark"
    assert viewer._scene.background == BACKGROUNDS["dark"]


# --- refusals -----------------------------------------------------------------------------------------------------


def test_a_wrong_number_of_values_is_refused_and_the_old_ones_stay(sphere, height):
    viewer = Viewer(sphere, height)
    with pytest.raises(BadInput, match="one value for each of the 4098 vertices, but got an array of shape \\(3,\\)"):
        viewer.values = [1.0, 2.0, 3.0]
    assert np.array_equal(viewer.values, height.astype(np.float32))


def test_another_part_is_refused(sphere, cube):
    with pytest.raises(BadInput, match="other faces"):
        Viewer(sphere).mesh = cube


def test_a_field_that_is_not_there_is_refused(sphere):
    with pytest.raises(BadInput, match="set `values` first"):
        Viewer(sphere).layer = "field"


@pytest.mark.parametrize("wrong", [{"limits": (2.0, 1.0)}, {"threshold": float("nan")}, {"values": [1.0]}])
def test_a_refused_viewer_leaves_nothing_behind(sphere, height, wrong):
    before = set(alive)
    with pytest.raises(BadInput):
        Viewer(sphere, **{"values": height, **wrong})
    assert set(alive) == before


# --- closing ------------------------------------------------------------------------------------------------------


def test_closing_leaves_nothing_behind(painted, height):
    before = set(alive)
    viewer = Viewer(painted, height, threshold=5.0)
    assert len(alive) > len(before) + 10
    viewer.close()
    assert set(alive) == before
    viewer.close()


def test_closing_one_viewer_leaves_the_other(painted, height):
    kept, gone = Viewer(painted, height), Viewer(painted, height)
    gone.close()
    kept.values = height[::-1]
    assert kept._colour.comm is not None
    assert kept._bar.comm is not None


def test_repr_never_prints_arrays(painted, height):
    assert repr(Viewer(painted, height)) == "Viewer(SurfaceMesh(4098 vertices, 8192 faces, 20.0 x 20.0 x 20.0 mm), layer='field')"


def test_a_part_of_a_single_point_can_be_shown():
    assert Viewer(SurfaceMesh([(1.0, 1.0, 1.0)] * 3, [(0, 1, 2)])).layer == "style"


def test_without_the_extra_the_import_says_what_to_install():
    program = "import sys; sys.modules['pythreejs'] = None; import mechstyle_widgets"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert "the notebook widgets need pythreejs, which is not installed: pip install 'mechstyle[jupyter]'" in done.stderr
