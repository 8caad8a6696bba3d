"""A file of a run, simulated again beside its plain part, comes to what its run came to."""

import numpy as np
import pytest
import trimesh

from mechstyle.gallery import load
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.runs.run import stylize
from mechstyle.simulation.part_test import simulate

SETTINGS = {"vertices": 500, "window": 0.08, "orientations": 2, "nearly_flat": False, "device": "cpu"}
"""The window leaves out later impacts, of which both would see the same."""


@pytest.fixture(scope="module")
def plain():
    """A block of 20 × 16 × 10 mm."""
    block = trimesh.creation.box((20.0, 16.0, 10.0)).apply_translation((0.0, 0.0, 5.0))
    return SurfaceMesh(np.asarray(block.vertices), np.asarray(block.faces))


@pytest.mark.slow
def test_a_file_comes_to_the_outcome_of_its_run(plain, tmp_path):
    run = stylize(plain, "brick", iterations=2, out=tmp_path / "run", **SETTINGS)
    again = simulate(load(str(run.export(tmp_path / "block.3mf"))), original=plain, **SETTINGS)
    assert np.abs(again.relief - run.checkpoint().displacement).max() < 0.05, "it is read as the relief that it is"
    assert run.checkpoint().displacement.any()
    assert again.verdict.outcome == run.verdict.outcome
    for row in again.verdict.rows:
        other = run.verdict.row(landing=row.landing)
        assert row.permanent_set == pytest.approx(other.permanent_set, rel=0.3, abs=0.03), "on so few tetrahedra made anew"
        assert row.plain_permanent_set == pytest.approx(other.plain_permanent_set), "the plain part is the same"
