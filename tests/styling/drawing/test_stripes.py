import numpy as np
import pytest

from mechstyle.styling.drawing.charts import horizontal_lines, stripes
from mechstyle.styling.drawing.operators import Operators


@pytest.fixture(scope="module")
def lines(holder_operators):
    return horizontal_lines(holder_operators)


def wrapped(cycles):
    return cycles - np.round(cycles)


def test_lines_are_level_on_walls_and_point_so_that_rows_grow_upwards(holder, lines, outside):
    up = np.cross(holder.vertex_normals, lines)
    middle = outside & (np.abs(holder.vertices[:, 2] - 50.0) < 40.0)
    assert np.abs(lines[middle, 2]).max() < 0.001
    assert up[outside, 2].min() > 0.99  # the floor pulls a little at the ring next to it


def test_rows_on_a_wall_are_level_and_of_the_period_asked_for(holder, holder_operators, lines, outside):
    up = np.cross(holder.vertex_normals, lines)
    middle = outside & (np.abs(holder.vertices[:, 2] - 50.0) < 40.0)
    wave = np.exp(2j * np.pi * stripes(holder_operators, up, 20.0)[middle])
    z = holder.vertices[middle, 2]
    levels = np.round(z, 6)
    for level in np.unique(levels):
        assert abs(wave[levels == level].mean()) > 0.998  # 1 % of the period, rms, around the holder
    heights = np.unique(levels)
    mean = np.unwrap([np.angle(wave[levels == level].mean()) for level in heights]) / (2.0 * np.pi)
    slope = np.polyfit(heights, mean, 1)[0]
    assert abs(1.0 / slope - 20.0) < 0.2


def test_columns_close_around_a_wall_without_a_seam(holder, holder_operators, lines, outside):
    phase = stripes(holder_operators, lines, 22.0)
    tail, head = holder_operators.tail, holder_operators.head
    wall = outside[tail] & outside[head]
    expected = np.einsum("ij,ij->i", holder_operators.edge_vectors, lines[tail] + lines[head]) / 44.0
    jump = wrapped(phase[head] - phase[tail] - expected)[wall]
    # 251 mm hold 11.4 periods of 22 mm; 11 that close stretch each by 4 %, less than 0.01 cycles an edge.
    assert np.abs(jump).max() < 0.015
    ring = np.flatnonzero(outside & (np.abs(holder.vertices[:, 2] - 48.0) < 1e-6))
    ring = ring[np.argsort(np.arctan2(holder.vertices[ring, 1], holder.vertices[ring, 0]))]
    assert abs(round(float(wrapped(np.diff(phase[ring], append=phase[ring[0]])).sum()))) in (11, 12)


def test_a_phase_jumps_nowhere_but_at_few_singular_faces_of_a_sphere(sphere, sphere_operators):
    lines = horizontal_lines(sphere_operators)
    phase = stripes(sphere_operators, np.cross(sphere.vertex_normals, lines), 4.0)
    tail, head = sphere_operators.tail, sphere_operators.head
    up = np.cross(sphere.vertex_normals, lines)
    same = np.einsum("ij,ij->i", sphere_operators.carried(up[tail]), up[head]) > 0.0
    expected = np.einsum("ij,ij->i", sphere_operators.edge_vectors, up[tail] + up[head]) / 8.0
    jump = np.abs(wrapped(phase[head] - phase[tail] - expected))[same]
    assert np.mean(jump > 0.05) < 0.01


def test_weak_grip_keeps_the_length_of_columns_where_the_part_narrows(hourglass):
    operators = Operators(hourglass)
    lines = horizontal_lines(operators)
    tail, head = operators.tail, operators.head
    along = np.einsum("ij,ij->i", operators.edge_vectors, lines[tail] + lines[head]) / 2.0
    waist = (np.abs(hourglass.vertices[tail, 2] - 50.0) < 15.0) & (along > 0.7 * np.linalg.norm(operators.edge_vectors, axis=1))

    def error(grip):
        phase = stripes(operators, lines, 20.0, grip=grip)
        return np.median(np.abs(wrapped(phase[head] - phase[tail]) * 20.0 / along - 1.0)[waist])

    # Half as many columns fit around the waist as around the ends.
    assert error(1.0) > 0.3
    assert error(0.1) < 0.6 * error(1.0)


def test_stripes_slide_to_where_they_are_wished(holder, holder_operators, lines, outside):
    up = np.cross(holder.vertex_normals, lines)
    for offset in (0.0, 0.3):
        wish = outside * np.exp(2j * np.pi * (holder.vertices[:, 2] / 20.0 + offset))
        phase = stripes(holder_operators, up, 20.0, start=wish)
        error = wrapped(phase - holder.vertices[:, 2] / 20.0 - offset)[outside]
        assert np.abs(error).max() < 0.05
