"""What leads on from a part that fails: at most four buttons, each with what it costs, each one press from a branch."""

from __future__ import annotations

import re
import shutil

import numpy as np
import pytest

from mechstyle.loop.engine import retained_share
from mechstyle.loop.store import Store
from mechstyle.records import sentences
from mechstyle.records.regions import Sphere
from mechstyle.runs.recipes import changed
from mechstyle.runs.run import Run
from mechstyle.simulation import foresight
from mechstyle.simulation.part import bounds_for
from mechstyle_widgets.state.studio_state import FREE
from mechstyle_widgets.studio import Studio


@pytest.fixture
def failed(monkeypatch):
    """The shipped comparison, with Freestyle in front; what is branched is noted."""
    studio, begun = Studio(), []
    studio.state.lane = FREE
    monkeypatch.setattr(studio.controller, "branch", lambda iteration, **changes: begun.append((iteration, changes)))
    studio.begun = begun
    return studio


FORESEEN = re.compile(r"(?P<least>\d\.\d\d) to (?P<most>\d\.\d\d) mm stays bent, about (?P<kept>\d+)% of this relief")


def offered(studio):
    return {step.name: step.foreseen for step in studio.next_steps.steps}


def test_a_part_that_fails_is_led_on_with_figures_of_its_own(failed):
    held = failed.state.row(40, "main").verdict.deciding
    assert list(offered(failed)) == ["MechStyle", "Shallower there", "Keep this place plain"]
    assert offered(failed)["MechStyle"].startswith(f"{sentences.found(held)} of {sentences.allowed(held)}, ")
    read = {name: FORESEEN.fullmatch(offered(failed)[name]) for name in ("Shallower there", "Keep this place plain")}
    shallow, plain = (float(read[name]["kept"]) for name in read)
    assert 0.0 < plain < shallow < 100.0, "a relief that grows from nothing loses less than one that is away"
    worst = failed.state.row().verdict.deciding
    for found in read.values():
        assert round(worst.plain_permanent_set, 2) == float(found["least"]) < float(found["most"]) <= 1.1 * worst.permanent_set


def test_what_is_known_already_is_shown_by_one_press(failed):
    failed.next_steps.press("MechStyle")
    assert (failed.state.lane, failed.begun) == ("main", [])
    assert failed.viewer.names == ("MechStyle", "Freestyle"), "what failed stands beside it from now on"


def test_a_place_that_is_kept_plain_is_the_one_that_yields(failed):
    """It was the one that is off most: of a stem that bends at its foot that is the head, and nothing changed."""
    failed.next_steps.press("Keep this place plain")
    ((iteration, changes),) = failed.begun
    (ball,) = changes["protect"]
    assert (iteration, type(ball)) == (0, Sphere)
    surface, strain = failed.run.part.surface, Run(failed.run.store, FREE).simulation().landing_strain[0]
    there = np.linalg.norm(surface.vertices - ball.centre, axis=1) <= ball.radius
    flow = strain * surface.vertex_areas
    assert flow[there].sum() > 0.5 * flow.sum()


@pytest.mark.parametrize("name", ["Keep this place plain", "Shallower there"])
def test_a_cure_changes_nothing_else(failed, name):
    """A branch of Freestyle at its beginning went on with the settings of the lane it came from, MechStyle."""
    failed.next_steps.press(name)
    ((iteration, changes),) = failed.begun
    free = Run(failed.run.store, FREE)
    recipe = changed(free.store.recipe(free.store.find(iteration, FREE).recipe), changes)
    assert [name for name, *_ in free.recipe.differences(recipe)] == ["protect"]


def test_a_cure_that_cannot_help_is_not_offered_and_says_why(failed, monkeypatch):
    monkeypatch.setattr(foresight, "hinge", lambda *_: int(failed.run.part.surface.vertices[:, 2].argmax()))
    failed.next_steps._around = (None, ())
    failed.next_steps._offer()
    assert "Keep this place plain" not in offered(failed)
    assert "Keep this place plain would not help: hardly any relief goes where it bends, landing flat." in failed.next_steps._not.value


def test_where_nothing_is_known_of_mechstyle_it_is_offered_with_what_its_correction_comes_down_to(failed):
    failed.state.branches = [one for one in failed.state.branches if one.lane == FREE]
    failed.next_steps._offer()
    row = failed.state.row().verdict.deciding
    assert offered(failed)["Hold it back"].startswith(f"{row.plain_permanent_set:.2f} to {row.allowed:.2f} mm stays bent, ")
    failed.next_steps.press("Hold it back")
    assert failed.begun[0][1]["control"] != "none"


def test_the_file_of_a_part_that_fails_says_so(failed):
    assert failed.take_away.main.description == "3MF, take it anyway"
    assert failed.take_away.main.button_style == ""
    failed.state.lane = "main"
    assert failed.take_away.main.description == "3MF"


def test_a_part_that_holds_leads_to_nothing(tmp_path, fake_run):
    made = fake_run(tmp_path / "run")
    made.go()
    studio = Studio(made.run)
    assert studio.next_steps.steps == []
    assert studio.next_steps.layout.display == "none"


def test_one_looks_at_what_stays_bent_from_above_the_floor(failed):
    failed.state.layer = "style"
    failed.viewer._orbit.turn(0.0, -120.0)
    failed._lead_to_worst()
    assert failed.state.layer == "stays_bent"
    assert failed.viewer._orbit.seen.elevation >= 7.9


@pytest.mark.slow
@pytest.mark.parametrize("name", ["Keep this place plain", "Shallower there"])
def test_what_comes_of_a_cure_lies_where_it_was_foreseen(failed, tmp_path, name):
    foreseen = FORESEEN.fullmatch(offered(failed)[name])
    failed.next_steps.press(name)
    ((iteration, changes),) = failed.begun
    copied = shutil.copytree(failed.run.store.place, tmp_path / "run")
    free = Run(Store.open(copied), FREE, "cpu")
    cured = free.branch(iteration, **changes).go()
    assert float(foreseen["least"]) <= cured.verdict.deciding.permanent_set <= float(foreseen["most"])
    areas, relief = bounds_for(free.part, free.recipe)[0].seen_areas(free.part.surface), free.checkpoint().displacement
    assert retained_share(cured.checkpoint().displacement, relief, areas) == pytest.approx(0.01 * float(foreseen["kept"]), abs=0.02)
