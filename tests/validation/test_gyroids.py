"""Sheets of a gyroid that are meshed: they are where a slicer lays them, and fill what infill says."""

import manifold3d
import numpy as np
import pytest

from mechstyle.records.mesh import SurfaceMesh
from mechstyle.records.recipe import Printed
from validation import gyroids

PRINTED = Printed(infill=0.15)
WALL, TOP, BOTTOM = PRINTED.walls * PRINTED.line_width, PRINTED.top * PRINTED.layer_height, PRINTED.bottom * PRINTED.layer_height
PERIOD = gyroids.AREA * PRINTED.line_width / PRINTED.infill


def test_sheets_of_one_line_fill_the_share_of_an_infill():
    axis = PERIOD * (np.arange(40) + 0.5) / 40
    points = np.stack(np.meshgrid(axis, axis, axis), axis=-1).reshape(-1, 3)
    share = np.mean(gyroids.sheet_distance(points, PRINTED) < 0.5 * PRINTED.line_width)
    assert share == pytest.approx(PRINTED.infill, rel=0.15)


def test_voids_of_a_block_leave_its_walls_its_layers_and_the_share_of_its_sheets():
    """A block around one cell of the gyroid."""
    across, high = PERIOD + 2.0 * WALL, PERIOD + TOP + BOTTOM
    block = manifold3d.Manifold.cube((across, across, high)).to_mesh64()
    voids = gyroids.voids(SurfaceMesh(block.vert_properties, block.tri_verts), PRINTED)
    sheets = PERIOD**3 - voids.volume()
    assert sheets == pytest.approx(PRINTED.infill * PERIOD**3, rel=0.15)
    inside = np.array([[WALL, WALL, BOTTOM], [across - WALL, across - WALL, high - TOP]])
    assert np.abs(np.reshape(voids.bounding_box(), (2, 3)) - inside).max() < gyroids.EDGE
