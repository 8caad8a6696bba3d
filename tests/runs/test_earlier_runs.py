"""A run directory written by an earlier version opens, tells the same and goes on.

`data/earlier_run.zip` is a lane on a sheet with a branch at iteration 6, both finished, written before the modules were moved into rooms.
"""

import zipfile
from pathlib import Path

import msgspec
import numpy as np
import pytest

from mechstyle.records import Recipe
from mechstyle.records.earlier import translated
from mechstyle.records.material import LIBRARY
from mechstyle.runs.run import Run
from mechstyle.runs.stylizers import finished_relief
from mechstyle.simulation.part import Origin, Shape
from mechstyle.styling.dimensions import gradual_thickness
from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.folds import unfolded
from mechstyle.styling.library import style_named
from mechstyle.styling.prompt import read
from support.bench import Bench
from support.lanes import lane_on_a_sheet

EARLIER = Path(__file__).parent / "data" / "earlier_run.zip"


@pytest.fixture
def earlier(tmp_path) -> Path:
    """The directory, unpacked."""
    with zipfile.ZipFile(EARLIER) as packed:
        packed.extractall(tmp_path / "earlier")
    return tmp_path / "earlier"


def test_it_opens_with_its_lanes_verdict_and_summary(earlier):
    run, soft = Run.open(earlier), Run.open(f"{earlier}@soft")
    assert run.store.lanes() == ("main", "soft")
    assert (run.recipe.threshold, soft.recipe.control) == (0.5, "linear")
    assert run.finished
    assert run.verdict.outcome == run.summary.verdict == "VIABLE"
    assert run.summary.peak_stress == pytest.approx(run.verdict.as_placed.value)
    assert run.record.origin == Origin(model="gallery:pen_holder", vertices=4000)
    assert soft.history[6].digest == run.history[6].digest
    assert len(run.surface(7).vertices) == 64
    assert run.simulation().stress.shape == (64,)


def test_it_can_be_shown_reported_and_branched(earlier, tmp_path):
    run = Run.open(earlier)
    assert run.show(4).png.startswith(b"\x89PNG")
    assert "mechstyle run gallery:pen_holder" in run.report(tmp_path / "report.html").read_text(encoding="utf-8")
    branch = run.branch(3, lane="later", threshold=0.8)
    for _ in Bench(earlier, gain=200.0).engine(branch.recipe, "later").run():
        pass
    assert Run.open(f"{earlier}@later").history[-1].final


def test_what_its_settings_were_called_is_said_in_todays_words(earlier):
    run = Run.open(earlier)
    assert run.recipe.base == "protected"
    assert run.recipe.digest != run.store.lane("main").recipe, "it is stored as it was"
    assert run.finished


@pytest.mark.parametrize(("held", "base"), [(True, "protected"), (False, "free")])
def test_protection_of_the_resting_face_became_a_base(held, base):
    known = {"prompt": "brick", "side": "both", "delivered": None}
    assert translated({**known, "protect_resting_face": held}) == {**known, "base": base, "tilts": 0}
    assert translated({**known, "base": "level"}) == {**known, "base": "level"}


def test_a_relief_that_was_a_share_of_the_wall_stays_what_it_was(earlier):
    recipe = Run.open(earlier).recipe
    assert (recipe.relief, recipe.amplitude, recipe.side, recipe.feature, recipe.nozzle, recipe.inside) == (
        None, 0.15, "both", None, 0.0, "styled",
    )  # fmt: skip
    known = {"side": "auto", "nozzle": 0.4, "delivered": 50_000}
    assert translated(known) == known


def test_what_it_delivers_is_the_surface_of_its_checkpoints(earlier):
    run = Run.open(earlier)
    assert run.recipe.delivered == 0
    assert run.delivered() is None


def test_a_recipe_of_an_earlier_version_draws_the_very_relief_it_drew(sphere):
    """By the formula that was: height times amplitude times wall, without its mean, to both sides, features sized by area alone."""
    fields = {"surface": "", "tetrahedra": "", "prompt": "small deep brick", "material": msgspec.to_builtins(LIBRARY["PLA"])}
    old = msgspec.convert(translated({**fields, "amplitude": 0.15, "seed": 3, "base": "free", "control": "none"}), Recipe, strict=False)
    part = Shape(sphere, np.linspace(0.4, 1.0, len(sphere.vertices), dtype=np.float32))
    canvas, style, wish = Canvas(sphere, 3, 0.7), style_named("brick"), read(old.prompt).wishes[0]
    wall = gradual_thickness(canvas.operators, np.minimum(part.thickness.astype(float), style.feature_mm * canvas.scale))
    depth, height = 0.15 * wish.amount * wall, style.program(canvas).height
    weight = sphere.vertex_areas * depth
    free = depth * (height - (weight @ height) / weight.sum())
    expected = unfolded(canvas.operators, np.clip(free, -0.25 * part.thickness, part.thickness)).astype(np.float32)
    assert np.array_equal(finished_relief(part, old), expected)


def test_damping_in_milliseconds_is_not_read_as_a_share_of_critical_damping():
    assert "damping" not in translated({"protect_resting_face": True, "damping": 1e-4})
    assert translated({"base": "level", "damping": 0.05})["damping"] == 0.05


def test_an_unfinished_lane_goes_on_under_todays_recipe(earlier, monkeypatch):
    """Else it would write checkpoints that name a recipe nobody stored."""
    store = Run.open(earlier).store
    store.move("half", msgspec.structs.replace(store.lane("main"), head=store.find(4).digest))
    run = Run.open(f"{earlier}@half")
    monkeypatch.setattr(Run, "_engine", lambda self, _progress: (Bench(earlier, gain=200.0).engine(self.recipe, self.lane), ()))
    run.go()
    assert run.finished
    assert run.store.recipe(run.history[-1].recipe) == run.recipe
    assert run.history[4].digest == store.find(4).digest


def test_the_same_inputs_grow_the_same_relief_today(earlier, tmp_path):
    today, before = lane_on_a_sheet(tmp_path / "today", iterations=12, every=4, gain=200.0, threshold=0.5), Run.open(earlier)
    for ours, theirs in zip(today.history[:4], before.history[:4], strict=True):  # up to the first simulation
        assert (ours.iteration, ours.reason, ours.style_loss) == (theirs.iteration, theirs.reason, theirs.style_loss)
        one, other = today.store.checkpoint(ours.digest), before.store.checkpoint(theirs.digest)
        for name in ("displacement", "colour", "mask", "stress"):
            assert np.array_equal(getattr(one, name), getattr(other, name)), (ours.iteration, name)
