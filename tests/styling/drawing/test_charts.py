import numpy as np
import pytest

from mechstyle.records.mesh import SurfaceMesh
from mechstyle.styling.drawing.charts import BoxChart, StripeChart, box_axes, chart_of, is_prismatic
from mechstyle.styling.drawing.operators import Operators


def turned(mesh: SurfaceMesh, degrees: float) -> SurfaceMesh:
    """The part turned about z."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return mesh.moved(mesh.vertices @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]))


@pytest.mark.parametrize("degrees", [0.0, 30.0, 77.0])
def test_a_part_of_flat_sides_is_prismatic_however_it_stands(stand, degrees):
    part = turned(stand, degrees)
    assert is_prismatic(part)
    facing = np.abs(part.face_normals @ box_axes(part).T).max(axis=1)
    assert facing.min() > 1.0 - 1e-9


def test_round_parts_are_not_prismatic(holder, sphere):
    assert not is_prismatic(holder)
    assert not is_prismatic(sphere)


def test_the_chart_follows_the_shape(holder_operators, stand):
    assert isinstance(chart_of(holder_operators), StripeChart)
    assert isinstance(chart_of(Operators(stand)), BoxChart)


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


def test_directions_of_a_chart_are_unit_and_across_each_other(stand, holder_operators):
    for chart in (BoxChart(stand), StripeChart(holder_operators)):
        assert np.abs(np.linalg.norm(chart.along, axis=1) - 1.0).max() < 1e-9
        assert np.abs(np.einsum("ij,ij->i", chart.along, chart.up)).max() < 1e-9


def test_seen_from_outside_rows_of_a_box_run_to_the_right_and_upwards(stand):
    chart = BoxChart(stand)
    flat = np.abs(stand.vertex_normals).max(axis=1) > 0.999
    assert np.allclose(np.cross(chart.along, chart.up)[flat], stand.vertex_normals[flat])
    assert (chart.up[np.abs(stand.vertex_normals[:, 2]) < 0.1, 2] == 1.0).all()


def test_rows_of_a_round_part_start_at_its_floor(holder, holder_operators, outside):
    rows = StripeChart(holder_operators).rows(10.0, 0.0)
    z = holder.vertices[outside, 2]
    error = rows[outside] - (z / 10.0 - 0.5)
    # Modulo two rows, so that the parity of the first is even.
    assert np.abs(error - 2.0 * np.round(error / 2.0)).max() < 0.1
