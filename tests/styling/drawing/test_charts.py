import numpy as np
import pytest

from mechstyle.records.mesh import SurfaceMesh
from mechstyle.styling.drawing.charts import BoxChart, box_axes, horizontal_lines, is_prismatic
from mechstyle.styling.drawing.operators import Operators


def turned(mesh: SurfaceMesh, degrees: float) -> SurfaceMesh:
    """The part turned about z."""
    return mesh.moved(mesh.vertices @ axes_turned(degrees))


def axes_turned(degrees: float) -> np.ndarray:
    """The axes turned about z, as rows."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


@pytest.mark.parametrize("degrees", [0.0, 30.0, 77.0])
def test_a_part_of_flat_sides_is_prismatic_however_it_stands(stand, degrees):
    part = turned(stand, degrees)
    assert is_prismatic(part)
    facing = np.abs(part.face_normals @ box_axes(part).T).max(axis=1)
    assert facing.min() > 1.0 - 1e-9


def test_round_parts_are_not_prismatic(holder, sphere):
    assert not is_prismatic(holder)
    assert not is_prismatic(sphere)


def test_rows_of_a_box_are_level_meet_around_corners_and_fill_its_height(stand):
    chart = BoxChart(stand)
    rows = chart.rows(10.0, 1.0)
    sides = np.abs(stand.vertex_normals[:, 2]) < 0.5
    z = stand.vertices[sides, 2]
    slope, start = np.polyfit(z, rows[sides], 1)
    # Eight rows of 10.25 mm between 1 mm under the floor and 1 mm over the top, one function of z on all four sides.
    assert np.abs(rows[sides] - slope * z - start).max() < 1e-9
    assert abs(1.0 / slope - 82.0 / 8.0) < 1e-9
    assert abs(start - (1.0 / 10.25 - 0.5)) < 1e-9


def test_columns_of_a_box_fill_it_with_whole_halves_and_start_half_a_length_later_on_every_other_side(stand):
    chart = BoxChart(stand)
    columns = chart.columns(20.0, 1.0, 1.0)
    front = stand.vertex_normals[:, 1] < -0.9
    flank = stand.vertex_normals[:, 0] > 0.9
    slope, start = np.polyfit(stand.vertices[front, 0], columns[front], 1)
    assert abs(slope - 3.0 / 62.0) < 1e-9
    assert abs(start - (3.0 / 62.0 - 0.5)) < 1e-9
    slope, start = np.polyfit(stand.vertices[flank, 1], columns[flank], 1)
    assert abs(slope - 2.5 / 50.0) < 1e-9
    assert abs(start - 2.5 / 50.0) < 1e-9


def test_seen_from_outside_rows_of_a_box_run_to_the_right_and_upwards(stand):
    chart = BoxChart(stand)
    flat = np.abs(stand.vertex_normals).max(axis=1) > 0.999
    assert np.allclose(np.cross(chart.along, chart.up)[flat], stand.vertex_normals[flat])
    assert (chart.up[np.abs(stand.vertex_normals[:, 2]) < 0.1, 2] == 1.0).all()


@pytest.mark.parametrize(("size", "longer"), [((20, 8, 6), 0), ((8, 20, 6), 1), ((12, 12, 6), 0)])
def test_lines_are_level_on_walls_and_run_along_the_longer_side_of_a_flat_top(slab, size, longer):
    part = slab(*size)
    lines, normal = horizontal_lines(Operators(part)), part.vertex_normals
    top, walls = normal[:, 2] > 0.999, np.abs(normal[:, 2]) < 0.001
    assert np.abs(lines[top, longer]).min() > 0.99
    assert lines[top, longer].min() > 0.0, "and all the same way"
    assert np.abs(lines[walls, 2]).max() < 0.05
    np.testing.assert_allclose(np.linalg.norm(lines, axis=1), 1.0)


def test_on_a_slope_of_45_degrees_lines_are_level_again_two_edges_away_from_a_flat_top():
    """What is left of the turn at the fold fades with the distance from it, by e over two edges of length: a solution in closed form."""
    along, across = np.meshgrid(np.arange(-15.0, 26.0), np.arange(-8.0, 9.0), indexing="ij")
    down = np.maximum(along, 0.0) * 0.5**0.5
    n = np.arange(along.size).reshape(along.shape)
    halves = ([n[:-1, :-1], n[1:, :-1], n[1:, 1:]], [n[:-1, :-1], n[1:, 1:], n[:-1, 1:]])
    faces = np.concatenate([np.stack(half, axis=-1).reshape(-1, 3) for half in halves])
    vertices = np.stack([np.minimum(along, 0.0) + down, across, -down], axis=-1).reshape(-1, 3)
    roof = turned(SurfaceMesh(vertices, faces), 30.0)  # so that lines of the top are neither along the fold nor across it
    lines = horizontal_lines(Operators(roof))[n[16:22, 8]]
    outwards, level, up = axes_turned(30.0)
    start = (level[0] + 1j * outwards[0]) ** 2  # of lines along x, the longer side
    now = (lines @ level + 1j * (lines @ (outwards - up)) / 2.0**0.5) ** 2  # along 1 + left (start − 1)
    left = now.imag / np.imag((start - 1.0) * np.conj(now))
    assert roof.edge_length * -np.diff(np.log(np.abs(left))) == pytest.approx(0.5, rel=0.08)
