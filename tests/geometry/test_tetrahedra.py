"""Tetrahedra: the right number of good ones inside the part, or a reason; kept by content, killed in time."""

from __future__ import annotations

import os
import subprocess

import numpy as np
import pytest

from mechstyle.errors import BadInput, SimulationFailed
from mechstyle.geometry import tetrahedra as module
from mechstyle.geometry import tetwild as worker
from mechstyle.geometry.tetrahedra import tetrahedralise
from mechstyle.mesh import SurfaceMesh


def test_they_fill_the_part(cup, cup_tets):
    assert 0.5 * 3000 <= len(cup_tets.tets) <= 2.0 * 3000
    assert cup_tets.volumes.min() > 0
    assert cup_tets.volumes.sum() == pytest.approx(cup.volume, rel=0.03)
    assert SurfaceMesh(cup_tets.vertices, cup_tets.boundary_faces).is_closed


def test_they_are_well_shaped(cup_tets):
    assert np.percentile(cup_tets.quality, 1) > 0.2
    assert cup_tets.quality.mean() > 0.6


def test_the_base_lies_in_its_plane(cup, cup_tets):
    low = cup_tets.vertices[:, 2] < cup.vertices[:, 2].min() + 0.04
    assert low.sum() > 20
    assert np.all(cup_tets.vertices[low, 2] == cup.vertices[:, 2].min())


def test_neighbours_in_space_are_neighbours_in_memory(cup_tets):
    spread = np.ptp(cup_tets.tets, axis=1)
    assert np.median(spread) < 0.25 * len(cup_tets.vertices)


def test_a_kept_mesh_is_used_again_to_the_byte(block, tmp_path, monkeypatch):
    first = tetrahedralise(block, 600, cache=tmp_path)
    monkeypatch.setattr(module, "tetwild", None)
    assert tetrahedralise(block, 600, cache=tmp_path).digest == first.digest


def test_a_damaged_cache_entry_is_not_used(block, tmp_path, monkeypatch):
    tetrahedralise(block, 600, cache=tmp_path)
    (entry,) = tmp_path.glob("*.npz")
    entry.write_bytes(entry.read_bytes()[:-200])
    asked = []
    real = module.tetwild
    monkeypatch.setattr(module, "tetwild", lambda *args, **options: asked.append(1) or real(*args, **options))
    tetrahedralise(block, 600, cache=tmp_path)
    assert asked


def test_running_out_of_time_is_said_and_leaves_no_process(cup):
    with pytest.raises(SimulationFailed, match="stopped after"):
        tetrahedralise(cup, 100_000, timeout=0.5)
    # Only a zombie or a living child would be waited for; there is none left.
    with pytest.raises(ChildProcessError):
        os.waitpid(-1, os.WNOHANG)


def test_a_worker_that_dies_is_named(block, monkeypatch):
    real = subprocess.run

    def dying(command, **options):
        return real([command[0], "-c", "import sys; print('out of luck', file=sys.stderr); sys.exit(3)"], **options)

    monkeypatch.setattr(worker.subprocess, "run", dying)
    with pytest.raises(SimulationFailed, match=r"exit code 3.*out of luck"):
        tetrahedralise(block, 1000)


def test_nothing_is_left_in_the_working_directory(block, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    tetrahedralise(block, 600)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("target", [0, 499, 10**7])
def test_targets_out_of_range_are_refused(block, target):
    with pytest.raises(BadInput, match="500 to 400000"):
        tetrahedralise(block, target)


@pytest.mark.parametrize(
    "broken",
    [
        lambda cup: SurfaceMesh(cup.vertices, cup.faces[:-1]),
        lambda cup: SurfaceMesh(cup.vertices, cup.faces[:, ::-1]),
        lambda cup: SurfaceMesh(np.where(np.arange(len(cup.vertices))[:, None] == 7, np.nan, cup.vertices), cup.faces),
        lambda _: SurfaceMesh(np.zeros((0, 3)), np.zeros((0, 3), int)),
    ],
    ids=["open", "inside out", "nan", "empty"],
)
def test_what_would_crash_or_fool_the_mesher_is_refused(cup, broken):
    with pytest.raises(BadInput):
        tetrahedralise(broken(cup), 1000)
