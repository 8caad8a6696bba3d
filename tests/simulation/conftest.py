"""A small block, what is remembered of its drops, and how many there were."""

from __future__ import annotations

import pytest
import trimesh

from mechstyle.geometry.remeshing.filling import fill
from mechstyle.loop.objects import Memo, Objects
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.simulation import simulator as module


@pytest.fixture(scope="session")
def block(cache):
    """A 30 × 20 × 10 mm block and its tetrahedra."""
    box = trimesh.creation.box((30.0, 20.0, 10.0))
    box.apply_translation((0, 0, 5.0))
    for _ in range(3):
        box = box.subdivide()
    surface = SurfaceMesh(box.vertices, box.faces)
    return surface, fill(surface, 600, cache=cache / "tets")


@pytest.fixture
def memo(tmp_path):
    return Memo(tmp_path / "memo", Objects(tmp_path / "objects"))


@pytest.fixture
def drops(monkeypatch):
    """Counts drop tests; each entry is the number of landings."""
    counted, real = [], module.drop

    def counting(tets, material, floor_normals, test, **options):
        counted.append(len(floor_normals))
        return real(tets, material, floor_normals, test, **options)

    monkeypatch.setattr(module, "drop", counting)
    return counted
