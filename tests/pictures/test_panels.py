"""What the picture of a checkpoint says about its stress, above all when a drop in the middle of a run gave none."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.pictures.panels import Picture
from mechstyle.records.material import LIBRARY
from mechstyle.records.mesh import TetMesh
from mechstyle.runs import run as module
from mechstyle.runs.run import begin
from mechstyle.simulation.part import Workpiece

TETS = TetMesh(np.eye(4, 3), [[0, 1, 2, 3]])


@pytest.fixture
def material():
    return LIBRARY["PLA"]


@pytest.fixture
def settings():
    return {}


@pytest.fixture
def run(bench, material, settings):
    """The drops at 20 and 60 give an answer, the one at 40 does not, as it alone finds a relief above 0.9 mm."""
    bench.gain, bench.broken_above = 1.0, 0.95
    part = Workpiece(bench.surface, TETS, np.full(64, 4.0, np.float32), stands=False)
    recipe = bench.recipe(schedule="every", every=20, control="none", material=material, **settings)
    run = begin(part, recipe, bench.root, device="cpu")
    for event in bench.engine(recipe).run():
        if getattr(event, "iteration", 0) == 50:
            break
    return run


@pytest.fixture
def shown(run, monkeypatch):
    """The stress panel of an iteration."""

    def stress(iteration):
        taken = []
        monkeypatch.setattr(module, "picture", lambda panels, **_: taken.extend(panels))
        run.show(iteration)
        return taken[1]

    return stress


@pytest.mark.parametrize(
    ("iteration", "title", "note"),
    [
        (20, "stress", "HOLDS a fall of 1.5 m; flat: 20.9 of 45.6 MPa"),
        (30, "stress (iteration 20)", "flat: 20.9 of 45.6 MPa"),
        (40, "stress (iteration 20)", "UNKNOWN: this test gave no answer"),
        (45, "stress (iteration 20)", "UNKNOWN: the later test at iteration 40 gave no answer"),
    ],
)
def test_the_stress_of_an_older_drop_is_not_shown_as_that_of_a_failed_one(shown, iteration, title, note):
    panel = shown(iteration)
    assert (panel.title, panel.note) == (title, note)


@pytest.mark.parametrize("settings", [{"nearly_flat": False}])
@pytest.mark.parametrize("material", [msgspec.structs.replace(LIBRARY["PLA"], yield_strength=15.0)])
def test_between_drops_the_limit_is_that_of_the_last_verdict(run, shown):
    """The plain part itself reaches 20 MPa, so the styled part may reach a little more: that of 0.9 of its height."""
    limit = run.checkpoint(20).verdict.deciding.limit
    assert limit == pytest.approx(20.0 / 0.9**0.5)
    assert shown(30).threshold == limit


def test_a_picture_can_be_made_of_a_failed_drop(run, tmp_path):
    assert run.show(40).save(tmp_path / "failed.png").read_bytes()[:4] == b"\x89PNG"


def test_other_fields_are_shown_instead_if_they_are_asked_for(run, monkeypatch):
    panels = []
    monkeypatch.setattr(module, "picture", lambda shown, **_: panels.extend(shown))
    run.show(20, fields=["safety_factor", "thickness"])
    assert [panel.title for panel in panels[1:]] == ["safety factor", "wall thickness"]
    factor = panels[1]
    assert (factor.limits, factor.threshold) == ((4.0, 0.0), 1.0)
    assert factor.values.min() == pytest.approx(run.checkpoint(20).verdict.safety_factor, rel=1e-5)
    with pytest.raises(BadInput, match="unknown field 'safety'"):
        run.show(20, fields=["safety"])


def test_a_picture_says_its_size_and_not_its_bytes():
    """What a notebook keeps of a picture besides the picture was three times as large."""
    assert repr(Picture(b"\x89" * 226_400)) == "Picture(226 kB)"
