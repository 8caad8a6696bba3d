"""A style drawn again on a subdivided surface is the same style, finer."""

from __future__ import annotations

import numpy as np
import pytest

from mechstyle.geometry.subdivision import subdivided
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.charts import BoxChart
from mechstyle.styling.drawing.fine_canvas import FineCanvas
from mechstyle.styling.library import style_named


def canvases(mesh: SurfaceMesh, seed: int = 3) -> tuple[Canvas, FineCanvas]:
    cut, coarse = subdivided(mesh), Canvas(mesh, seed)
    return coarse, FineCanvas(cut.mesh, cut.interpolation, coarse)


@pytest.fixture(scope="module")
def ball(sphere):
    """Large enough that features are several edges wide."""
    return canvases(sphere)


@pytest.fixture(scope="module")
def block(cube):
    mesh = cube
    for _ in range(5):
        mesh = subdivided(mesh).mesh
    return canvases(mesh)


PATTERNS = ("stone", "brick", "voronoi", "fish_scales", "marble", "wood", "studs", "hammered", "crystal", "celtic_knot", "topographic")


@pytest.mark.parametrize("name", PATTERNS)
@pytest.mark.parametrize("shape", ["ball", "block"])
def test_the_pattern_lies_where_it_lay(request, shape, name):
    """Drawn afresh on the finer mesh, cells and rows would lie elsewhere and the two would have nothing to do with each other."""
    coarse, fine = request.getfixturevalue(shape)
    before, after = (style_named(name).program(canvas) for canvas in (coarse, fine))
    count = len(coarse.points)
    assert np.corrcoef(before.height, after.height[:count])[0, 1] > 0.8
    assert np.corrcoef(before.colour.ravel(), after.colour[:count].ravel())[0, 1] > 0.8


def test_a_pattern_gets_steeper_edges(ball):
    """What 25k vertices soften, four times as many carry."""
    coarse, fine = ball
    steepest = [np.quantile(canvas.operators.slope(style_named("brick").program(canvas).height), 0.95) for canvas in (coarse, fine)]
    assert steepest[1] > 1.3 * steepest[0]


def test_sizes_and_places_are_those_of_the_coarse_surface(ball):
    coarse, fine = ball
    assert fine.edge < 0.6 * coarse.edge
    assert fine.unit("joints", 0.01) == coarse.unit("joints", 0.01)
    assert np.array_equal(fine.scattered(4.0, "x", room=2.0), coarse.scattered(4.0, "x", room=2.0))


def test_a_piece_keeps_its_identity(ball):
    coarse, fine = ball
    up = fine.points[:, 2]
    inside, count = np.abs(up) > 3.0, len(coarse.points)
    before, after = coarse.pieces(inside[:count]), fine.pieces(inside)
    assert len(set(after[inside])) == 2
    assert np.array_equal(after[:count][inside[:count]], before[inside[:count]])


def test_phases_between_vertices_are_half_way_the_shorter_way_round(ball):
    coarse, fine = ball
    assert not isinstance(fine.chart, BoxChart)
    edges = coarse.mesh.edges
    sign = np.where(np.einsum("ij,ij->i", *coarse.chart.along[edges].transpose(1, 0, 2)) < 0.0, -1.0, 1.0)
    for phase, period in ((fine.chart.rows(3.0, 0.0), 2.0), (fine.chart.columns(3.0, 0.0, 1.0), 1.0)):
        between = phase[len(coarse.points) :]
        steps = [np.abs((phase[edges[:, k]] * (sign if k else 1.0) - between + period / 2) % period - period / 2) for k in (0, 1)]
        assert np.allclose(steps[0], steps[1], atol=1e-6)
    assert np.allclose(np.linalg.norm(fine.chart.along, axis=1), 1.0)
    assert np.allclose(np.einsum("ij,ij->i", fine.chart.along, fine.mesh.vertex_normals), 0.0, atol=1e-6)
