"""What the picture of a checkpoint says about its stress, above all when a drop in the middle of a run gave none."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from mechstyle import teaching
from mechstyle.pictures.panels import bent_panel, exaggerated, exaggeration
from mechstyle.records.material import LIBRARY
from mechstyle.records.mesh import TetMesh
from mechstyle.runs import run as module
from mechstyle.runs.run import Draft
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
    run = Draft(recipe, part, folder=bench.root, device="cpu").begin()
    for event in bench.engine(recipe).run():
        if getattr(event, "iteration", 0) == 50:
            break
    return run


@pytest.fixture
def shown(run, monkeypatch):
    """The panels of an iteration."""

    def panels(iteration):
        taken = []
        monkeypatch.setattr(module, "picture", lambda panels, **_: taken.extend(panels))
        run.show(iteration)
        return taken

    return panels


@pytest.mark.parametrize(
    ("iteration", "titles", "note"),
    [
        (20, ("stress", "what stays bent"), "HOLDS a fall of 1.5 m"),
        (30, ("stress (iteration 20)", "what stays bent (iteration 20)"), ""),
        (40, ("stress (iteration 20)", "what stays bent (iteration 20)"), "UNKNOWN: this test gave no answer"),
        (45, ("stress (iteration 20)", "what stays bent (iteration 20)"), "UNKNOWN: the later test at iteration 40 gave no answer"),
    ],
)
def test_the_stress_of_an_older_drop_is_not_shown_as_that_of_a_failed_one(shown, iteration, titles, note):
    look, stress, bend, _ = shown(iteration)
    assert (stress.title, bend.title.removesuffix(", drawn × 100")) == titles
    assert look.note == note


def test_each_caption_is_of_its_own_picture(shown):
    """Below a picture of stress stood what the verdict compared, of another test."""
    _, stress, bend, _ = shown(20)
    assert stress.note == "flat: nothing yields at the surface"
    assert bend.note == "flat: 0.01 mm of 0.20 mm"
    assert (bend.unit, bend.threshold, bend.edge) == ("mm", 0.2, "allowed")


def test_a_bend_is_drawn_in_its_shape_so_large_that_it_can_be_seen(run):
    surface, simulation, row = run.surface(20), run.simulation(20), run.checkpoint(20).verdict.deciding
    panel = bent_panel(surface, simulation, row)
    assert panel.mesh.vertices == pytest.approx(surface.vertices + 100.0 * simulation.set_of(landing="flat"), abs=1e-4)


def test_parts_side_by_side_are_bent_by_one_factor(run, monkeypatch):
    """The plain part stood there bent more than the one that failed: × 100 beside × 10."""
    taken, row, (surface, simulation) = [], run.checkpoint(20).verdict.deciding, (run.surface(20), run.simulation(20))
    rows = [row, msgspec.structs.replace(row, permanent_set=0.3)]
    little, more = (exaggerated(surface, simulation, one) for one in rows)
    assert more < little
    monkeypatch.setattr(teaching, "picture", lambda panels, **_: taken.extend(panels))
    monkeypatch.setattr(teaching, "worst", lambda *_: rows.pop(0))
    teaching.bent({"little": (run, 20), "more": (run, 20)})
    assert [panel.title for panel in taken[2:]] == 2 * [f"what stays bent, drawn × {more}"]


def test_of_a_part_that_gives_way_the_caption_says_which_shape_is_shown(run):
    """The shape was the last that bore the load, and stood there as what the part comes to."""
    surface, simulation, row = run.surface(20), run.simulation(20), run.checkpoint(20).verdict.deciding
    gave_way = msgspec.structs.replace(row, collapses=True, outcome="FAILS")
    assert bent_panel(surface, simulation, gave_way).note.endswith("gives way of 0.20 mm; shown is the last shape that bore the load")
    assert "shown" not in bent_panel(surface, simulation, row).note


@pytest.mark.parametrize(("bend", "factor"), [(0.0, 1), (0.01, 100), (0.1, 50), (0.3, 20), (4.0, 1), (50.0, 1)])
def test_a_factor_is_round_and_never_makes_less_of_it(bend, factor):
    assert exaggeration(bend, 100.0) == factor
