"""Which tetrahedra serve a relief: they are remembered, taken for the next, and the same when they are asked for again."""

from __future__ import annotations

import pytest

from mechstyle.errors import SimulationFailed
from mechstyle.records.simulation import THICKER
from mechstyle.simulation import meshes
from mechstyle.simulation.meshes import Followed
from mechstyle.simulation.part import mesh_for_relief
from support.dropped_block import ripples, simulator


def test_the_tets_of_a_relief_are_taken_for_the_next_that_they_carry(block, memo, monkeypatch):
    asked, real = [], meshes.mesh_for_relief
    monkeypatch.setattr(meshes, "mesh_for_relief", lambda *given: asked.append(1) or real(*given))
    served = simulator(block, memo).meshes
    (first, _), (lower, _) = served.mesh_for(ripples(block)), served.mesh_for(0.8 * ripples(block))
    assert lower.tets.digest == first.tets.digest != block[1].digest
    assert len(asked) == 1


def test_asked_again_for_a_relief_the_tets_are_those_it_was_tested_on(block, memo, monkeypatch):
    """What is delivered may be an earlier correction: drawn after another was meshed, it was tested on that one's tetrahedra instead."""
    first, words = simulator(block, memo).meshes.mesh_for(ripples(block))
    with monkeypatch.context() as patch:
        patch.setattr(Followed, "is_at_least_as_good_as", lambda *_: False)
        patch.setattr(meshes, "mesh_for_relief", lambda *_: (first.tets.moved(first.tets.vertices + 1e-6), first.at))
        other, _ = simulator(block, memo).meshes.mesh_for(ripples(block, 0.25))
    assert other.tets.digest != first.tets.digest
    again, as_before = simulator(block, memo).meshes.mesh_for(ripples(block))
    assert (again.tets.digest, as_before) == (first.tets.digest, words)


def test_a_part_that_cannot_be_meshed_again_is_judged_as_it_is_and_says_so(block, memo, monkeypatch):
    def refuse(*_args, **_options):
        raise SimulationFailed("fTetWild gave up")

    monkeypatch.setattr(meshes, "mesh_for_relief", refuse)
    result = simulator(block, memo, orientations=1).simulate(ripples(block), thorough=True)
    assert result.meshing.startswith("morphed, following")
    assert "fTetWild gave up" in result.meshing


def test_a_run_on_tets_made_for_its_relief_needs_no_others(block, memo):
    surface = block[0]
    sim = simulator(block, memo)
    tets, at = mesh_for_relief(sim.part.shape, ripples(block))
    sim = simulator((surface, tets), memo, at=at, orientations=1)
    result = sim.simulate(ripples(block), thorough=True)
    assert (result.meshing, result.mesh) == ("morphed", tets.digest)
    assert result.thicker <= THICKER


def test_no_relief_asks_for_the_tetrahedra_of_the_plain_part(block, memo):
    sim = simulator(block, memo)
    body, words = sim.meshes.mesh_for(0.0 * ripples(block))
    assert (body.tets.digest, words) == (block[1].digest, meshes.MORPHED)


@pytest.mark.parametrize("mesh", ["0" * 64, ""])
def test_tetrahedra_that_nobody_made_are_not_known(block, memo, mesh):
    assert simulator(block, memo).meshes.known(mesh) is None
    sim = simulator(block, memo)
    assert sim.meshes.known(block[1].digest) is sim.meshes.first
