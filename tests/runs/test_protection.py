"""What regions hold, looked at before a run."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from mechstyle.errors import BadInput
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.records.regions import Box
from mechstyle.runs.protection import protect


@pytest.fixture(scope="module")
def block() -> SurfaceMesh:
    box = trimesh.creation.box((30.0, 20.0, 12.0))
    return SurfaceMesh(box.vertices, box.faces)


def test_it_shows_what_a_run_would_keep(block, tmp_path, monkeypatch):
    monkeypatch.setenv("MECHSTYLE_CACHE", str(tmp_path))
    found = protect(block, ["above 3", Box((10, -20, -20), (20, 20, 20), ramp=2)], vertices=800)
    points = found.surface.vertices
    assert np.array_equal(found.frozen, (points[:, 2] >= 3) | (points[:, 0] >= 10))
    areas = found.surface.vertex_areas
    assert found.share == pytest.approx(areas[found.frozen].sum() / areas.sum())
    assert found.show().png.startswith(b"\x89PNG")
    words = [note.split(",")[0] for note in found.protection.notes]
    assert words == ["protected: above 3", "protected: box 10 -20 -20 20 20 20 ramp 2"]


def test_a_bad_region_is_refused_before_anything_slow_is_done(block):
    with pytest.raises(BadInput, match="did you mean 'inside'"):
        protect(SurfaceMesh(np.zeros((0, 3)), np.zeros((0, 3), int)), "insid")
