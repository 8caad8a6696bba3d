"""What a run delivers: its surface drawn finer by the twin, which follows what the loop did, and dropped again."""

from __future__ import annotations

import shutil
from dataclasses import replace
from itertools import pairwise

import msgspec
import numpy as np
import pytest
import trimesh
from manifold3d import CrossSection, Manifold

from mechstyle.geometry.print_quality import untangled
from mechstyle.geometry.remeshing.crossings import crossings
from mechstyle.geometry.remeshing.evening import surface_of
from mechstyle.geometry.subdivision import Subdivided, subdivided
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.runs import refine as module
from mechstyle.runs.refine import INTERPOLATED, MOST_PARTS
from mechstyle.runs.run import Run, stylize
from mechstyle.runs.twin import Twin
from mechstyle.styling.drawn import ProceduralStylizer, Target
from support.records import landing, simulation


def test_the_delivered_file_is_the_surface_that_was_dropped_last_with_the_verdict_of_the_run(run, finer, tmp_path, dropless):
    written = run.exported(tmp_path / "part.ply")
    mesh = trimesh.load(tmp_path / "part.ply", process=False)
    assert len(mesh.vertices) >= 3500
    assert np.allclose(mesh.vertices, finer.styled.vertices, atol=1e-4)
    assert written.fine
    assert written.verdict == run.verdict == run.checkpoint().verdict
    assert run.verdict.deciding.stress == finer.simulation.flat.stress
    assert np.array_equal(finer.displacement, finer.simulation.displacement)
    assert finer.original.displaced(finer.displacement).volume == pytest.approx(finer.styled.volume)


def test_the_loop_keeps_its_own_vertices(run, finer):
    """Only the delivered surface is large: a checkpoint holds the relief of its own vertices, and the test's fields around them."""
    count, state = len(run.part.surface.vertices), run.checkpoint()
    assert len(state.displacement) == count
    assert np.array_equal(state.stress, run.simulation().stress)
    assert state.stress.max() == finer.simulation.stress.max()
    assert np.all(state.stress >= finer.simulation.stress[:count])
    assert np.array_equal(run.simulation().contact, finer.simulation.contact[:count])


def test_what_was_delivered_is_drawn_once(run, monkeypatch, dropless):
    monkeypatch.setattr(module, "Twin", lambda *_: pytest.fail("it was drawn again"))
    again = Run.open(run.store.root, "cpu")
    assert np.array_equal(again.delivered().styled.vertices, run.delivered().styled.vertices)
    assert run.delivered(4) is None, "before the end nothing is delivered"


def test_it_can_be_made_again_from_recipe_and_checkpoints(run, finer, tmp_path, dropless):
    """Whoever was interrupted, or throws away what was kept, gets the same bytes, and the test of them is remembered."""
    root = tmp_path / "copy"
    shutil.copytree(run.store.root, root)
    for kept in (root / "memo").glob("delivered-*"):
        kept.unlink()
    again = Run.open(root, "cpu")
    written = again.exported(tmp_path / "part.stl")
    assert written.verdict == run.verdict
    found = again.delivered()
    assert np.array_equal(found.displacement, finer.displacement)
    assert np.array_equal(found.styled.colours, finer.styled.colours)


def test_a_run_that_ended_before_it_delivered_goes_on_to_the_same(run, finer, tmp_path):
    shutil.copytree(run.store.root, tmp_path / "copy")
    again = Run.open(tmp_path / "copy", "cpu")
    lane = again.store.lane()
    again.store.move("main", msgspec.structs.replace(lane, head=again.store.entry(lane.head).parent))
    assert not again.finished
    again.go()
    assert again.store.lane() == lane
    assert np.array_equal(again.delivered().displacement, finer.displacement)


def test_a_run_that_delivers_its_own_surface_can_be_drawn_finer_and_dropped_later(coarse, tmp_path):
    assert coarse.delivered() is None
    written = coarse.exported(tmp_path / "part.stl", fine=True)
    assert written.verdict is not None
    assert written.verdict.deciding.stress != coarse.verdict.deciding.stress, "it was dropped, not copied"
    assert len(trimesh.load(tmp_path / "part.stl").faces) == MOST_PARTS**2 * len(coarse.part.surface.faces)


def test_a_relief_that_was_removed_is_the_unstylized_part(run, dropless):
    found = run._refinement(run.simulator(run.recipe))
    state = run.checkpoint()
    removed = found.tested(replace(state, displacement=np.zeros_like(state.displacement), parent=run.store.lane().head))
    original = run.simulator(run.recipe).baseline
    assert removed.landings == original.landings
    assert np.array_equal(removed.stress, original.stress)


def test_the_fine_relief_follows_the_coarse_one(run, finer):
    found, coarse = finer, run.checkpoint().displacement
    here = found.displacement[: len(coarse)]
    assert np.corrcoef(coarse, here)[0, 1] > 0.9
    colours = run.checkpoint().colour.astype(np.float32)
    assert np.corrcoef(colours.ravel(), found.styled.colours[: len(coarse)].ravel())[0, 1] > 0.9


def test_what_is_protected_stays_protected_in_the_fine_file(run, finer):
    found = finer
    frozen = found.cut.interpolation @ (run.part.surface.vertices[:, 2] >= 9.9).astype(float) == 1.0
    assert frozen.any()
    assert np.all(found.simulation.displacement[frozen] == 0.0)
    grey = found.styled.colours[frozen]
    assert np.allclose(grey, grey[0], atol=2e-3), "it keeps the part's own colour"
    assert np.ptp(found.styled.colours[~frozen], axis=0).max() > 0.03


def test_a_twin_on_the_same_surface_repeats_the_run(run, monkeypatch):
    """If subdivision did nothing and the style drew the same, the replay would give the run's own displacement."""
    import scipy.sparse as sp  # noqa: PLC0415 — used here only

    surface = run.part.surface
    monkeypatch.setattr("mechstyle.runs.twin.FineCanvas", lambda *made_from: made_from[-1])
    twin, past = Twin(run.part, Subdivided(surface, sp.eye_array(len(surface.vertices), format="csr"))), run.history
    assert [entry.iteration for entry in past][:7] == list(range(7))
    for before, after in pairwise(run.store.checkpoint(entry.digest) for entry in past):
        twin.follow(before, after, run.recipe)
        assert np.allclose(twin.displacement, after.displacement, atol=1e-6)


def test_what_was_taken_back_is_taken_back_from_the_twin(run):
    """A correction repeats its iteration with less relief: here with half of it in front, and none behind."""
    twin = Twin(run.part, subdivided(run.part.surface))
    start, first = run.checkpoint(0), run.checkpoint(1)
    twin.follow(start, first, run.recipe)
    grown, front = twin.displacement.copy(), run.part.surface.vertices[:, 1] > 0.0
    twin.follow(first, replace(first, displacement=first.displacement * np.where(front, 0.5, 0.0).astype(np.float32)), run.recipe)
    of, moved = twin.cut.interpolation @ front.astype(float), twin.cut.interpolation @ (first.displacement != 0.0).astype(float) == 1.0
    assert np.allclose(twin.displacement[(of == 1.0) & moved], 0.5 * grown[(of == 1.0) & moved])
    assert not twin.displacement[(of == 0.0) & moved].any()
    assert grown[(of == 0.0) & moved].any()


def test_what_is_laid_flat_under_the_part_is_flat_between_the_vertices_too(run):
    """Of a level base the highest areas have no relief in the loop; between them the finer drawing has, and it stayed."""
    twin, recipe = Twin(run.part, subdivided(run.part.surface)), msgspec.structs.replace(run.recipe, base="level")
    standing, everywhere = run.part.shape.level_base.standing, np.ones(len(run.part.surface.vertices), np.float32)
    start, first = (replace(run.checkpoint(number), mask=everywhere, share=everywhere) for number in (0, 1))
    twin.follow(start, first, recipe)
    grown = twin._grown[0]
    assert grown[standing].any(), "it has a relief under it"
    level = np.where(standing & (np.arange(len(standing)) % 3 == 0), np.float32(0.0), grown)
    twin._grown = level, twin._grown[1]
    twin.follow(first, replace(first, displacement=level), recipe)
    between = twin.cut.interpolation @ standing.astype(np.float32) > 0.999
    assert twin.displacement[between].any()
    twin.follow(first, replace(first, displacement=np.where(standing, np.float32(0.0), level)), recipe)
    assert not twin.displacement[between].any()
    assert twin.displacement[~between].any()


def test_what_was_given_back_is_given_back_to_the_twin_as_it_would_have_been_drawn(run):
    """Held back to a quarter and given all of it back, the twin is what it is without restraint, between the loop's vertices, too."""
    free, held = (Twin(run.part, subdivided(run.part.surface)) for _ in range(2))
    start, first = run.checkpoint(0), run.checkpoint(1)
    free.follow(start, first, run.recipe)
    quarter = replace(first, displacement=np.float32(0.25) * first.displacement)
    held.follow(replace(start, mask=np.float32(0.25) * start.mask), quarter, run.recipe)
    assert np.ptp(held.displacement) < 0.5 * np.ptp(free.displacement)
    held.follow(quarter, first, run.recipe)
    assert np.ptp(free.displacement) > 0.01
    assert np.allclose(held.displacement, free.displacement, atol=1e-6)


def ribs(surface, bounds, _recipe):
    """A plug-in that draws: ribs, 2.5 mm apart."""
    relief = np.clip(0.3 * np.sin(0.8 * np.pi * surface.vertices[:, 2]), -bounds.inward, bounds.outward).astype(np.float32)
    return ProceduralStylizer(surface, Target(relief, np.full((len(relief), 3), 0.5, np.float32), ()))


class Unknowable:
    """A stylizer like another, whose target nobody knows."""

    def __init__(self, other):
        self._other = other

    def __getattr__(self, name):
        return getattr(self._other, name)


def opaque(surface, bounds, recipe):
    """A plug-in that is known at its vertices only."""
    return Unknowable(ribs(surface, bounds, recipe))


def test_a_plug_in_with_a_target_is_drawn_at_the_new_vertices_too(run):
    plugged = run.branch(4, lane="ribs", iterations=8, guarantee=False, stylizer=ribs).go()
    found, before, after = plugged.delivered(), plugged.checkpoint(4).displacement, plugged.checkpoint().displacement
    grown = found.displacement - (found.cut.interpolation @ before)
    wall = (np.abs(found.original.vertex_normals[:, 2]) < 0.1) & (np.abs(found.original.vertices[:, 2]) < 7.0)
    drawn = np.sin(0.8 * np.pi * found.original.vertices[:, 2])
    apart = [np.corrcoef(field[wall], drawn[wall])[0, 1] for field in (grown, found.cut.interpolation @ (after - before))]
    assert apart[0] > apart[1] + 0.03
    assert INTERPOLATED not in plugged.summary.notes


LEARNT = {"network": {"field": "network"}, "clip": {"guidance": "clip", "crops": 1}, "plugged": {"stylizer": opaque}}


@pytest.fixture(scope="module", params=LEARNT)
def learnt(request, run, tiny_clip) -> Run:
    """Two iterations of a learnt style, after the drawn ones."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MECHSTYLE_CLIP", str(tiny_clip))
        yield run.branch(4, lane=request.param, iterations=6, guarantee=False, **LEARNT[request.param]).go()


def test_a_learnt_style_is_interpolated_and_said_to_be(learnt, tmp_path):
    written, found = learnt.exported(tmp_path / "part.ply"), learnt.delivered()
    assert len(trimesh.load(tmp_path / "part.ply", process=False).vertices) >= 3500
    assert written.verdict == learnt.verdict
    assert INTERPOLATED in written.warnings
    assert INTERPOLATED in learnt.summary.notes
    interpolated = found.cut.interpolation @ learnt.checkpoint().colour.astype(np.float32)
    assert found.styled.colours == pytest.approx(interpolated, abs=1e-3)  # kept in half precision


def test_what_was_drawn_before_a_learnt_style_stays_as_fine_as_it_was(learnt):
    """What is learnt adds, between the vertices too, the mean of what it added at the two ends of the edge."""
    twin = Twin(learnt.part, subdivided(learnt.part.surface))
    states = [learnt.store.checkpoint(entry.digest) for entry in learnt.history]
    drawn, spread = states[4].displacement, twin.cut.interpolation
    for before, after in pairwise(states):
        if before.iteration == 4 and after.iteration == 5:
            at_branch = twin.displacement
        twin.follow(before, after, learnt.store.recipe(after.recipe))
    assert np.abs(at_branch - spread @ drawn).max() > 1e-3, "the drawing knows more between the vertices than their mean"
    added = spread @ (states[-1].displacement - drawn)
    assert np.abs(added).max() > 1e-4
    wanted, bounds = at_branch + added, twin.bounds
    free = (wanted > 0.01 - bounds.inward) & (wanted < np.minimum(bounds.outward - 0.01, twin._base.ceiling - 0.1))
    assert free.mean() > 0.5
    assert twin.displacement[free] == pytest.approx(wanted[free], abs=1e-5)


def test_leading_a_surface_through_a_run_can_be_stopped_at_every_iteration(run, finer):
    """A run of hundreds of iterations is led through again for tens of seconds: Stop has to reach into it."""
    heard = []
    simulator = replace(run.simulator(run.recipe), progress=heard.append)
    refinement = module.Refinement(run.store, run.part, simulator, 3500)
    refinement._led_to(run.checkpoint())
    assert len(heard) >= run.recipe.iterations

    def stop(_fraction):
        raise InterruptedError

    stopped = module.Refinement(run.store, run.part, replace(simulator, progress=stop), 3500)
    with pytest.raises(InterruptedError):
        stopped._led_to(run.checkpoint())


def test_the_smaller_faces_of_a_part_are_made_once(run, finer):
    simulator = run.simulator(run.recipe)
    first, again, others = (module.Refinement(run.store, run.part, simulator, count) for count in (3500, 3500, 9000))
    assert again.cut is first.cut
    assert len(others.cut.mesh.vertices) > len(first.cut.mesh.vertices)


def finely_tested(flat, nearly, load, contact):
    """A test on a finer surface with these fields."""
    landings = (landing(), landing("tilted", way="nearly flat"))
    return simulation(
        displacement=np.zeros(len(flat)), contact=contact, landings=landings, landing_stress=np.stack([flat, nearly]),
        load_stress=load[None],
    )  # fmt: skip


@pytest.fixture(scope="module")
def cut():
    box = trimesh.creation.box((40.0, 30.0, 20.0))
    return subdivided(SurfaceMesh(box.vertices, box.faces), 4)


def test_a_peak_between_the_vertices_of_the_loop_is_lowered_where_it_is(cut):
    """A correction saw no overloaded vertex where the delivered surface of a tealight holder had 49.5 of 45.6 MPa."""
    stress = np.full(len(cut.mesh.vertices), 10.0, np.float32)
    stress[-1] = 50.0
    found = module._of_the_loop(finely_tested(stress, stress, stress, stress > 20.0), np.zeros(8, np.float32), cut)
    assert found.stress.max() == 50.0
    assert np.flatnonzero(found.stress > 20.0).tolist() == [cut.nearest[-1]]
    assert not found.contact.any()


def test_the_stress_of_each_landing_and_of_each_load_goes_to_the_loop_and_back_by_itself(cut):
    count = len(cut.mesh.vertices)
    peak = np.zeros(count, np.float32)
    peak[-1] = 50.0
    fine = finely_tested(peak, 2.0 * peak, 3.0 * peak, np.zeros(count, bool))
    found = module._of_the_loop(fine, np.zeros(8, np.float32), cut)
    assert (found.landings, found.loads) == (fine.landings, fine.loads)
    assert [one.max() for one in (*found.landing_stress, *found.load_stress)] == [50.0, 100.0, 150.0]
    spread = module._spread_out(found, cut)
    assert spread.landing_stress.shape == (2, count)
    assert np.allclose(spread.landing_stress[1], 2.0 * spread.landing_stress[0])
    assert np.allclose(spread.load_stress[0], 3.0 * spread.landing_stress[0])


def test_what_is_delivered_does_not_pass_through_itself(tmp_path, monkeypatch):
    """Drawn finely, bricks on both sides of an edge or an inner corner reach into each other."""
    monkeypatch.setenv("MECHSTYLE_CACHE", str(tmp_path / "cache"))
    crossed = []

    def told(surface, relief, go_on):
        crossed.append(crossings(surface.displaced(relief)).pairs)
        return untangled(surface, relief, go_on)

    monkeypatch.setattr(module, "untangled", told)
    profile = CrossSection([[(0.0, 0.0), (20.0, 0.0), (20.0, 4.0), (4.0, 4.0), (4.0, 20.0), (0.0, 20.0)]])
    angle = surface_of(Manifold.extrude(profile, 12.0))
    drop = {"orientations": 1, "nearly_flat": False, "window": 0.2, "element": "tet4"}
    free = {**drop, "vertices": 1500, "iterations": 40, "schedule": "never", "control": "none", "guarantee": False}
    run = stylize(angle, "brick", relief=1.0, feature=5.0, out=tmp_path / "run", device="cpu", delivered=15_000, **free)
    assert crossed[-1] > 10
    found = run.exported(tmp_path / "part.stl")
    assert found.fine
    assert (found.quality.crossings, found.quality.folds) == (0, 0)
