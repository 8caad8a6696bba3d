"""What leaves a run: the file, what is known of that very surface, and the same drawn finer and dropped again."""

from __future__ import annotations

import json
import logging
from dataclasses import replace
from itertools import pairwise

import msgspec
import numpy as np
import pytest
import trimesh

from mechstyle.errors import BadInput
from mechstyle.geometry.subdivision import quartered
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.runs import refine as module
from mechstyle.runs.export import Exported, sidecar, unsimulated
from mechstyle.runs.run import Run, stylize

QUICK = {"vertices": 900, "iterations": 6, "orientations": 1, "tilts": 0, "window": 0.2, "element": "tet4", "schedule": "every", "every": 3}


@pytest.fixture(scope="module")
def run(tmp_path_factory) -> Run:
    folder = tmp_path_factory.mktemp("export")
    box = trimesh.creation.box((40.0, 30.0, 20.0))
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MECHSTYLE_CACHE", str(folder / "cache"))
        mesh = SurfaceMesh(box.vertices, box.faces)
        yield stylize(mesh, "marble", out=folder / "run", protect="above 9.9 colour", amplitude=0.3, device="cpu", **QUICK)


def test_what_is_known_of_the_surface_lies_beside_the_file(run, tmp_path):
    path = run.export(tmp_path / "part.stl")
    kept = msgspec.json.decode(sidecar(path).read_bytes(), type=Exported)
    assert sidecar(path).name == "part.stl.json"
    assert (kept.file, kept.lane, kept.iteration, kept.fine) == ("part.stl", "main", 6, False)
    assert kept.recipe == run.recipe.digest
    assert kept.verdict == run.verdict
    assert kept.quality.volume == pytest.approx(run.surface().volume)


def test_a_surface_that_was_not_simulated_has_no_verdict_and_says_so(run, tmp_path, caplog):
    with caplog.at_level(logging.WARNING):
        run.export(tmp_path / "part.obj", 4)
    assert "this iteration was not simulated; the last simulation was at 3" in caplog.text
    assert json.loads(sidecar(tmp_path / "part.obj").read_text())["verdict"] is None


def test_a_relief_reduced_after_its_simulation_has_no_verdict(run):
    """Retraction changes the share, and with it the surface, once the drop has been judged."""
    state = run.checkpoint(3)
    reduced = replace(state, share=state.share * np.float32(0.5), parent=run.store.find(3).digest)
    assert unsimulated(run.store, run.store.entry(run.store.put_checkpoint(reduced))).startswith("the relief was reduced right after")
    assert unsimulated(run.store, run.store.find(3)) == ""


@pytest.fixture(scope="module")
def finer(run, tmp_path_factory):
    path = tmp_path_factory.mktemp("fine") / "part.ply"
    seen = {}

    def kept(*arguments, **options):
        seen["refined"] = module.refined(*arguments, **options)
        return seen["refined"]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("mechstyle.runs.export.refined", kept)
        return path, run.exported(path, fine=True), seen["refined"]


def test_the_fine_file_has_four_times_the_faces_and_the_verdict_is_its_own(run, finer):
    path, written, found = finer
    mesh = trimesh.load(path, process=False)
    assert len(mesh.faces) == 4 * len(run.part.surface.faces)
    assert np.allclose(mesh.vertices, found.styled.vertices, atol=1e-4)
    assert written.fine
    assert written.verdict == found.verdict
    assert np.array_equal(found.original.displaced(found.simulation.displacement).vertices, found.styled.vertices)
    assert found.verdict.deciding.value != run.verdict.deciding.value, "it was dropped, not copied"


def test_the_fine_relief_follows_the_coarse_one(run, finer):
    _, _, found = finer
    coarse = run.checkpoint().displacement
    here = found.simulation.displacement[: len(coarse)]
    assert np.corrcoef(coarse, here)[0, 1] > 0.9
    colours = run.checkpoint().colour.astype(np.float32)
    assert np.corrcoef(colours.ravel(), found.styled.colours[: len(coarse)].ravel())[0, 1] > 0.9


def test_what_is_protected_stays_protected_in_the_fine_file(run, finer):
    _, _, found = finer
    frozen = quartered(run.part.surface).interpolation @ (run.part.surface.vertices[:, 2] >= 9.9).astype(float) == 1.0
    assert frozen.any()
    assert np.all(found.simulation.displacement[frozen] == 0.0)
    grey = found.styled.colours[frozen]
    assert np.allclose(grey, grey[0], atol=2e-3), "it keeps the part's own colour"
    assert np.ptp(found.styled.colours[~frozen], axis=0).max() > 0.03


def test_a_twin_on_the_same_surface_repeats_the_run(run, monkeypatch):
    """If quartering did nothing and the style drew the same, the replay would give the run's own displacement."""
    import scipy.sparse as sp  # noqa: PLC0415 — used here only

    from mechstyle.geometry.subdivision import Quartered  # noqa: PLC0415

    surface = run.part.surface
    count = len(surface.vertices)
    same = Quartered(surface, np.repeat(np.arange(count), 2).reshape(-1, 2), sp.eye_array(count, format="csr"))
    monkeypatch.setattr(module, "quartered", lambda _: same)
    monkeypatch.setattr(module, "FineCanvas", lambda *made_from: made_from[-1])
    twin, past = module._Twin(run.part), module._past(run.store, run.store.lane().head)
    assert [entry.iteration for entry in past][:7] == list(range(7))
    for before, after in pairwise(run.store.checkpoint(entry.digest) for entry in past):
        twin.follow(before, after, run.recipe)
        assert np.allclose(twin.displacement, after.displacement, atol=1e-6)


def test_what_was_taken_back_is_taken_back_from_the_twin(run):
    """A correction repeats its iteration with less relief: here with half of it in front, and none behind."""
    twin = module._Twin(run.part)
    start, first = run.checkpoint(0), run.checkpoint(1)
    twin.follow(start, first, run.recipe)
    grown, front = twin.displacement.copy(), run.part.surface.vertices[:, 1] > 0.0
    twin.follow(first, replace(first, displacement=first.displacement * np.where(front, 0.5, 0.0).astype(np.float32)), run.recipe)
    y = run.part.surface.vertices[twin._cut.parents][:, :, 1]
    moved = np.all(first.displacement[twin._cut.parents] != 0.0, axis=1)
    assert np.allclose(twin.displacement[(y > 0).all(axis=1) & moved], 0.5 * grown[(y > 0).all(axis=1) & moved])
    assert not twin.displacement[(y <= 0).all(axis=1) & moved].any()
    assert grown[(y <= 0).all(axis=1) & moved].any()


def test_the_unstylized_part_cannot_be_drawn_finer(run, tmp_path):
    with pytest.raises(BadInput, match="no style to draw finer"):
        run.export(tmp_path / "part.stl", 0, fine=True)
    assert list(tmp_path.iterdir()) == []


LEARNT = {"network": {"field": "network"}, "clip": {"guidance": "clip", "crops": 1}}


@pytest.fixture(scope="module", params=LEARNT)
def learnt(request, run, tiny_clip) -> Run:
    """Two iterations of a learnt style, after the drawn ones."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MECHSTYLE_CLIP", str(tiny_clip))
        yield run.branch(4, lane=request.param, iterations=6, guarantee=False, **LEARNT[request.param]).go()


def test_a_learnt_style_is_interpolated_and_said_to_be(learnt, tmp_path, monkeypatch):
    seen = {}
    monkeypatch.setattr("mechstyle.runs.export.refined", lambda *a, **k: seen.setdefault("refined", module.refined(*a, **k)))
    written = learnt.exported(tmp_path / "part.ply", fine=True)
    found = seen["refined"]
    assert len(trimesh.load(tmp_path / "part.ply", process=False).faces) == 4 * len(learnt.part.surface.faces)
    assert written.verdict == found.verdict
    assert module.INTERPOLATED in written.warnings
    interpolated = quartered(learnt.part.surface).interpolation @ learnt.checkpoint().colour.astype(np.float32)
    assert found.styled.colours == pytest.approx(interpolated, abs=1e-6)


def test_what_was_drawn_before_a_learnt_style_stays_as_fine_as_it_was(learnt):
    """What is learnt adds, between the vertices too, the mean of what it added at the two ends of the edge."""
    twin, past = module._Twin(learnt.part), module._past(learnt.store, learnt.store.lane(learnt.lane).head)
    states = [learnt.store.checkpoint(entry.digest) for entry in past]
    drawn, spread = states[4].displacement, twin._cut.interpolation
    for before, after in pairwise(states):
        if before.iteration == 4 and after.iteration == 5:
            at_branch = twin.displacement
        twin.follow(before, after, learnt.store.recipe(after.recipe))
    assert np.abs(at_branch - spread @ drawn).max() > 1e-3, "the drawing knows more between the vertices than their mean"
    added = spread @ (states[-1].displacement - drawn)
    assert np.abs(added).max() > 1e-4
    wanted, bounds = at_branch + added, twin._fine_bounds
    free = (wanted > 0.01 - bounds.inward) & (wanted < np.minimum(bounds.outward - 0.01, twin._base.ceiling - 0.1))
    assert free.mean() > 0.5
    assert twin.displacement[free] == pytest.approx(wanted[free], abs=1e-5)
