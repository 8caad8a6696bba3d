"""Systems of two numbers a vertex: what stays of a grid, what is interpolated, and what comes out beside a direct solution."""

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from mechstyle.styling.drawing import charts, multigrid
from mechstyle.styling.drawing.charts import horizontal_lines, stripes, turning
from mechstyle.styling.drawing.multigrid import Grids, interpolation
from mechstyle.styling.drawing.operators import Operators


@pytest.fixture(scope="module")
def wave(holder_operators):
    """A phase that grows along x, the matrix in which its wave costs nothing, and masses."""
    operators, mesh = holder_operators, holder_operators.mesh
    phase = 0.9 * mesh.vertices[:, 0]
    matrix = turning(operators, operators.weights, phase[operators.head] - phase[operators.tail])
    return np.concatenate([np.cos(phase), np.sin(phase)]), matrix, np.tile(mesh.vertex_areas, 2)


def test_a_mirrored_wave_is_interpolated_mirrored(holder_operators, wave):
    """Arrows of a line field may point against each other across an edge: phases are compared with their negatives there."""
    known, _, _ = wave
    operators, count = holder_operators, len(known) // 2
    turned = np.random.default_rng(0).random(count) < 0.5
    phase = np.where(turned, -1.0, 1.0) * 0.9 * operators.mesh.vertices[:, 0]
    sign = np.where(turned[operators.tail] == turned[operators.head], 1.0, -1.0)
    matrix = turning(operators, operators.weights, sign * phase[operators.head] - phase[operators.tail], sign)
    mirrored = np.concatenate([np.cos(phase), np.sin(phase)])
    assert np.abs(matrix @ mirrored).max() < 1e-9
    finer = interpolation(matrix)
    there = np.flatnonzero(np.diff(finer.indptr)[:count] == 1)
    stays = there[np.argsort(finer[there].indices)]
    assert finer @ mirrored[np.concatenate([stays, stays + count])] == pytest.approx(mirrored, abs=1e-9)


def test_on_grids_a_system_is_solved_as_directly(wave, monkeypatch):
    _, matrix, mass = wave
    system = sp.csr_array(matrix + 0.05 * sp.diags_array(mass))
    right = mass * np.random.default_rng(0).normal(size=len(mass))
    monkeypatch.setattr(multigrid, "FEWEST", 200)
    grids = Grids(system)
    assert len(grids.matrices) > 2
    direct = spsolve(system.tocsc(), right)
    assert np.linalg.norm(grids.solved(right) - direct) < 0.01 * np.linalg.norm(direct)


@pytest.mark.parametrize("grip", [1.0, 0.1])
def test_on_grids_stripes_are_as_smooth_as_solved_as_they_are(fine_wall, monkeypatch, grip):
    """Half bricks, and rows of bricks that hold little on their neighbours: each row is a system nearly of its own."""
    operators = Operators(fine_wall)
    along, systems = horizontal_lines(operators), []
    energies = []
    for fewest in (100_000, 800):
        monkeypatch.setattr(multigrid, "FEWEST", fewest)
        monkeypatch.setattr(charts, "Grids", lambda matrix: systems.append(Grids(matrix)) or systems[-1])
        phase = 2.0 * np.pi * stripes(operators, along, 11.0, grip=grip)
        wave, mass = np.concatenate([np.cos(phase), np.sin(phase)]), np.tile(fine_wall.vertex_areas, 2)
        energies.append(wave @ (systems[-1].matrices[0] @ wave) / (wave @ (mass * wave)))
    assert len(systems[0].matrices) == 1
    assert len(systems[1].matrices) > 2
    assert energies[1] < 1.05 * energies[0]
