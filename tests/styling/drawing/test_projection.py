"""A picture on a part: upright and readable from outside wherever it lies, closed around what is turned, of the size it is told."""

import numpy as np
import pytest

from mechstyle.records.mesh import SurfaceMesh
from mechstyle.styling.drawing.projection import around_projection, box_projection, planar_projection
from styling.conftest import boxed


@pytest.fixture(scope="module")
def block() -> SurfaceMesh:
    """A box 40 x 32 x 24 mm."""
    return boxed((10, 8, 6), lambda *_: True)


def turned(mesh: SurfaceMesh, degrees: float, shift=(0.0, 0.0, 0.0)) -> SurfaceMesh:
    cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return mesh.moved(mesh.vertices @ np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]]) + shift)


def steps(projection, points, normals, direction, layer=0):
    """How u and v grow along a direction, in mm, on one layer."""
    one, other = (projection.layers(points + step * direction, normals)[layer] for step in (0.0, 0.01))
    width, height = projection.width, projection.width * projection.aspect
    return (other.u - one.u) / 0.01 * width, (other.v - one.v) / 0.01 * height


SEEN_FROM = {
    "front": (0, -1, 0), "back": (0, 1, 0), "right": (1, 0, 0), "left": (-1, 0, 0), "top": (0, 0, 1), "bottom": (0, 0, -1),
}  # fmt: skip


@pytest.mark.parametrize("end", SEEN_FROM)
@pytest.mark.parametrize("lay", ["box", "planar"])
def test_on_each_side_of_a_box_the_picture_is_upright_and_not_mirrored(block, end, lay):
    outwards = np.array(SEEN_FROM[end], float)
    projection = (
        box_projection(block, 10.0, 10.0, 0.5, repeated=True) if lay == "box"
        else planar_projection(block, 10.0, 10.0, 0.5, repeated=True, end=end)
    )  # fmt: skip
    points, normals = block.vertices, np.tile(outwards, (len(block.vertices), 1))
    layer = int(np.argmax([one.share[0] for one in projection.layers(points, normals)]))
    assert np.allclose(projection.layers(points, normals)[layer].share, 1.0)
    up = np.array([0.0, 0.0, 1.0] if outwards[2] == 0.0 else [0.0, 1.0, 0.0])
    for direction, expected in ((np.cross(up, outwards), (1.0, 0.0)), (up, (0.0, 1.0))):
        grown = steps(projection, points, normals, direction, layer)
        assert np.allclose(grown, np.array(expected)[:, None], atol=1e-6)


def test_one_picture_lies_in_the_middle_of_each_side_and_fits_it(block):
    projection = box_projection(block, None, 10.0, 1.0, repeated=False)
    assert projection.width == pytest.approx(0.6 * 24.0, rel=0.02)
    middle = np.array([[20.0, 0.0, 12.0]])
    front = next(layer for layer in projection.layers(middle, np.array([[0.0, -1.0, 0.0]])) if layer.share[0] > 0.5)
    assert np.allclose([front.u[0], front.v[0]], 0.0)


@pytest.mark.parametrize("asked", [7.0, 20.0, 33.0, 900.0])
def test_a_whole_number_of_pictures_goes_around_a_turned_part(holder, asked):
    projection = around_projection(holder, asked, asked, 1.0, repeated=True)
    times = 2.0 * np.pi * projection.radius / projection.width
    assert times == pytest.approx(round(times))
    assert round(times) == max(round(2.0 * np.pi * 40.0 / asked), 1)


def test_around_the_back_the_picture_meets_itself(holder):
    projection = around_projection(holder, 20.0, 20.0, 1.0, repeated=True)
    back = np.array([[s * 1e-4, 40.0, 50.0] for s in (-1.0, 1.0)])
    side = projection.layers(back, np.tile([0.0, 1.0, 0.0], (2, 1)))[0]
    assert abs(side.u[0] - side.u[1]) > 1.0
    assert side.u[0] - side.u[1] == pytest.approx(round(side.u[0] - side.u[1]), abs=1e-4)


def test_around_a_part_the_picture_is_read_to_the_right_outside_and_inside(holder):
    projection = around_projection(holder, 20.0, 20.0, 1.0, repeated=True)
    for outwards in (np.array([0.0, -1.0, 0.0]), np.array([0.0, 1.0, 0.0])):  # seen from in front, and from within looking to the front
        point = np.array([[0.0, -40.0, 50.0]])
        right = np.cross([0.0, 0.0, 1.0], outwards)
        across, up = steps(projection, point, outwards[None], right)
        assert across[0] == pytest.approx(1.0, rel=1e-3)
        assert up[0] == pytest.approx(0.0, abs=1e-6)
