"""What leads on from a part that fails: at most four buttons, each with what it costs, each one press from a branch."""

from __future__ import annotations

import numpy as np
import pytest

from mechstyle.records import sentences
from mechstyle.records.regions import Sphere
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


def offered(studio):
    return {step.name: step.foreseen for step in studio.next_steps.steps}


def test_a_part_that_fails_is_led_on_with_figures_of_its_own(failed):
    held = failed.state.row(40, "main").verdict.deciding
    assert list(offered(failed)) == ["MechStyle", "Shallower there", "Keep this place plain"]
    assert offered(failed)["MechStyle"].startswith(f"{sentences.found(held)} of {sentences.allowed(held)}, ")
    shallow, plain = (float(offered(failed)[name].split()[1].rstrip("%")) for name in ("Shallower there", "Keep this place plain"))
    assert 0.0 < plain < shallow < 93.0, "a relief that grows from nothing loses less than one that is away"


def test_what_is_known_already_is_shown_by_one_press(failed):
    failed.next_steps.press("MechStyle")
    assert (failed.state.lane, failed.begun) == ("main", [])
    assert failed.viewer.names == ("MechStyle", "Freestyle"), "what failed stands beside it from now on"


def test_a_place_that_is_kept_plain_is_the_one_that_stays_bent(failed):
    failed.next_steps.press("Keep this place plain")
    ((iteration, changes),) = failed.begun
    (ball,) = changes["protect"]
    assert (iteration, type(ball)) == (0, Sphere)
    assert np.linalg.norm(np.subtract(ball.centre, failed.state.row().verdict.deciding.where)) < 5.0


def test_where_nothing_is_known_of_mechstyle_it_is_offered_without_figures(failed):
    failed.state.branches = [one for one in failed.state.branches if one.lane == FREE]
    failed.next_steps._offer()
    assert offered(failed)["Hold it back"] == ""
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
