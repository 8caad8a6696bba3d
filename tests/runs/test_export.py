"""What leaves a run as a file: the surface, what is known of that very surface beside it, and its fields."""

from __future__ import annotations

import json
import logging
from tempfile import TemporaryDirectory

import meshio
import msgspec
import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from mechstyle.geometry.glb import DULL, Sheen
from mechstyle.geometry.print_quality import quality
from mechstyle.pictures.fields import stays_bent
from mechstyle.records import Doubt
from mechstyle.runs.export import Exported, of_the_test, sheen_of, sidecar, unsimulated
from support.bench import Bench
from support.lanes import lane_on_a_sheet
from support.records import row, verdict


def test_what_is_known_of_the_surface_lies_beside_the_file(run, tmp_path):
    path = run.export(tmp_path / "part.stl")
    kept = msgspec.json.decode(sidecar(path).read_bytes(), type=Exported)
    assert sidecar(path).name == "part.stl.json"
    assert (kept.file, kept.lane, kept.iteration) == ("part.stl", "main", 6)
    assert kept.recipe == run.recipe.digest
    assert kept.verdict == run.verdict
    assert kept.quality.volume == pytest.approx(run.surface().volume)


def test_a_surface_that_was_not_simulated_has_no_verdict_and_says_so(run, tmp_path, caplog):
    with caplog.at_level(logging.WARNING):
        run.export(tmp_path / "part.obj", 4)
    assert "NOT TESTED since iteration 3: this surface was not dropped" in caplog.text
    assert json.loads(sidecar(tmp_path / "part.obj").read_text())["verdict"] is None


def test_what_a_corrected_run_delivers_is_exported_with_its_verdict(cube, tmp_path, monkeypatch):
    """The best correction, which is delivered, was tested, though it was not the last that was."""
    run = lane_on_a_sheet(tmp_path / "run", gain=150.0, schedule="never", iterations=60)
    *_, last, delivered = run.history
    assert delivered.final
    assert run.store.checkpoint(last.digest).displacement.max() != run.checkpoint().displacement.max(), "or the best would be the last"
    monkeypatch.setattr("mechstyle.runs.export.quality", lambda *_: quality(cube, cube, 1e-3))  # that of a sheet, which encloses nothing
    written = run.exported(tmp_path / "part.stl")
    assert written.verdict == run.verdict
    assert written.verdict.passes
    assert not any("not simulated" in warning for warning in written.warnings)
    assert not any(unsimulated(entry) for entry in run.history if entry.reason), "every correction was"


@settings(max_examples=12)
@given(
    gain=st.sampled_from([10.0, 60.0, 150.0, 400.0]), height=st.sampled_from([0.2, 1.0, 2.0]), tilt=st.sampled_from([0.5, 1.4]),
    broken=st.sampled_from([0.7, np.inf]), schedule=st.sampled_from(["never", "every"]),
)  # fmt: skip
def test_whatever_comes_of_it_a_finished_run_delivers_the_verdict_on_its_very_surface(gain, height, tilt, broken, schedule):
    with TemporaryDirectory() as folder:
        bench = Bench(folder, height=height, gain=gain, tilt=tilt, broken_above=broken)
        engine = bench.engine(bench.recipe(schedule=schedule, every=5, iterations=20))
        *_, finished = engine.run()
        entry = engine.store.find(None)
        delivered = engine.store.checkpoint(entry.digest)
        assert unsimulated(entry) == ""
        again = engine.simulator.judge(engine.simulator.simulate(delivered.displacement, thorough=True))
        assert finished.verdict == delivered.verdict == entry.verdict == again


def test_a_file_with_fields_holds_what_the_test_of_that_very_surface_says(run, tmp_path, dropless):
    written = run.exported(tmp_path / "part.ply", fields=True)
    found, last = meshio.read(tmp_path / "part.ply").point_data, run.simulation()
    worst = run.verdict.deciding
    assert np.array_equal(found["stress"], last.stress_of(landing=worst.landing)), "the worst test"
    assert np.array_equal(found["stress_flat"], last.landing_stress[0])
    assert np.array_equal(found["stays_bent"], stays_bent(worst).values_in(last))
    assert np.array_equal(found["displacement"], last.displacement)
    assert np.allclose(found["restraint"], 1.0 - run.checkpoint().mask, atol=1e-6)
    assert written.fields["stress"] == f"von Mises stress at the surface [MPa]; {worst.landing}"
    assert written.fields["stays_bent"] == f"what stays bent [mm]; {worst.landing}"
    assert set(written.fields) == set(found) - {"red", "green", "blue", "alpha"}


def test_the_fields_of_an_iteration_that_was_not_simulated_say_their_age(run, tmp_path):
    written = run.exported(tmp_path / "part.ply", 4, fields=True)
    found, state = meshio.read(tmp_path / "part.ply").point_data, run.checkpoint(4)
    assert np.array_equal(found["stress"], state.stress)
    assert np.array_equal(found["demand"], state.demand)
    assert written.fields["stress"].endswith(f"; {run.store.verdict(state).deciding.landing}, simulated at iteration 3")


@pytest.mark.parametrize(
    ("prompt", "metallic"),
    [("gold brick", 1.0), ("dark gold brick", 1.0), ("outside: copper brick; rim: copper studs", 1.0), ("gold brick; rim: plain", 1.0),
     ("rust brick", 0.0), ("blue brick", 0.0), ("brick", 0.0), ("gold brick; rim: studs", 0.0), ("gold brick; rim: silver studs", 0.0)],
)  # fmt: skip
def test_a_part_all_in_one_metal_reflects_like_it(run, prompt, metallic):
    recipe = run.recipe.with_settings(prompt=prompt)
    assert sheen_of(recipe).metallic == metallic
    assert (sheen_of(recipe) == DULL) == (metallic == 0.0 and "rust" not in prompt)
    assert sheen_of(recipe.with_settings(stylizer="mine")) == DULL


def test_a_glb_says_how_it_reflects(run, tmp_path, monkeypatch):
    monkeypatch.setattr("mechstyle.runs.export.sheen_of", lambda _: Sheen(1.0, 0.25))
    for iteration, metallic in ((6, 1.0), (0, 0.0)):
        run.export(tmp_path / "part.glb", iteration)
        assert trimesh.load_mesh(tmp_path / "part.glb", process=False).visual.material.metallicFactor == metallic


def test_a_file_warns_of_what_fails_and_of_what_is_in_doubt():
    doubt = Doubt(about="relief", value=0.81)
    sure, doubtful, failed = verdict(row()), verdict(row(), doubts=(doubt,)), verdict(row(0.5))
    assert of_the_test(sure) == of_the_test(None) == ()
    assert of_the_test(doubtful) == (doubtful.doubt,)
    assert of_the_test(failed) == (failed.head,)
