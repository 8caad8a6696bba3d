"""Sheets of a gyroid that are meshed: they are where a slicer lays them, and fill what infill says."""

import re

import manifold3d
import numpy as np
import pytest

from mechstyle.gallery import make, names
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.records.recipe import Printed
from mechstyle.records.verdict import SMEARED
from support import ROOT
from validation import gyroids, suite

PRINTED = Printed(infill=0.15)
WALL, TOP, BOTTOM = PRINTED.walls * PRINTED.line_width, PRINTED.top * PRINTED.layer_height, PRINTED.bottom * PRINTED.layer_height
ROWS = ("", r"each sheet meshed \[mm\]", r"as the weaker material \[mm\]")
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


def bends():
    """What stays bent of each part [mm], as measured: with its sheets meshed and smeared out."""
    results = suite.read(ROOT / "docs/validation.json")["gyroids"].results
    return {one.case.removeprefix("gyroids: ").partition(",")[0]: (one.reference, one.measured) for one in results if one.unit == "mm"}


def test_the_parts_are_the_lightest_of_the_gallery_and_all_were_measured():
    volumes = {name: make(name).volume for name in names()}
    lightest = sorted(volumes, key=volumes.__getitem__)[: len(gyroids.PARTS)]
    assert sorted(gyroids.PARTS) == sorted(lightest) == sorted(bends())


def test_a_verdict_on_a_print_allows_for_what_smearing_lost_at_most():
    assert max(meshed / smeared for meshed, smeared in bends().values()) <= SMEARED


def test_the_page_has_what_was_measured():
    page = (ROOT / "docs/printing.md").read_text()
    heads, meshed, smeared = (re.findall(rf"^\| ?{row} \|(.*) \|$", page, re.MULTILINE)[0].split("|") for row in ROWS)
    for name, *figures in zip(heads, meshed, smeared, strict=True):
        assert [f"{one:.3f}" for one in bends()[name.strip().replace(" ", "_")]] == [one.strip() for one in figures]
