"""What a Studio of nothing opens on: a shipped run that is what the product makes now, shown at once and left as it is."""

from __future__ import annotations

import subprocess
import sys
from collections import Counter

import numpy as np
import pytest

from mechstyle import teaching
from mechstyle.fea.drop import DropTest
from mechstyle.loop.objects import Objects
from mechstyle.loop.store import Store
from mechstyle.records.recipe import DEFAULTS
from mechstyle.runs.run import Run
from mechstyle.runs.stylizers import finished_style
from mechstyle.simulation.simulator import DropSimulator
from mechstyle_widgets.panels.run_controls import NOT_RUNNING
from mechstyle_widgets.settings.prompt import PromptBox
from mechstyle_widgets.state import opening
from mechstyle_widgets.state.studio_state import FREE
from mechstyle_widgets.studio import Studio
from mechstyle_widgets.viewer.viewer import PartViewer
from support.told import assert_tells_one_truth


@pytest.fixture(scope="module")
def shipped() -> Run:
    return opening.opening()


def test_it_is_small_and_says_nothing_of_the_machine_it_was_made_on(shipped):
    assert opening.PACKED.stat().st_size < 1_000_000
    assert shipped.summary.files == {"run": str(shipped.summary.files["run"])}
    assert not str(shipped.summary.files["run"]).startswith("/")


def test_it_is_the_run_of_the_lesson_and_visibly_fails_when_free(shipped):
    free = Run(shipped.store, FREE)
    assert shipped.recipe == teaching.settled()
    assert free.recipe == teaching.settled(freely=True)
    assert (shipped.verdict.outcome, free.verdict.outcome) == ("HOLDS", "FAILS")
    assert free.verdict.deciding.permanent_set > 5.0 * shipped.verdict.deciding.permanent_set


@pytest.mark.slow
def test_its_tests_are_of_the_physics_there_is_now(shipped):
    """They are recalled, or dropped again where the physics is another, or where a processor moves tetrahedra by other last bits."""
    for run in (shipped, Run(shipped.store, FREE)):
        simulator, stored = DropSimulator(run.part, run.recipe, run.store.memo), run.verdict
        found = simulator.judge(simulator.simulate(run.checkpoint().displacement, thorough=True))
        assert (found.outcome, found.sure, len(found.rows)) == (stored.outcome, stored.sure, len(stored.rows))
        for row, before in zip(found.rows, stored.rows, strict=True):
            assert (row.landing, row.allowed) == (before.landing, before.allowed)
            assert row.permanent_set == pytest.approx(before.permanent_set, rel=0.02)


@pytest.mark.slow
def test_the_style_and_its_fall_are_those_of_the_code_there_is_now(shipped, tmp_path):
    free = Run(shipped.store, FREE)
    made, relief = free.checkpoint(), finished_style(free.part, free.recipe).relief
    assert np.corrcoef(made.displacement, relief)[0, 1] > 0.95
    again = DropSimulator(free.part, free.recipe, Store(tmp_path / "anew").memo).simulate(made.displacement, thorough=True)
    assert again.landings[0].permanent_set == pytest.approx(free.verdict.deciding.permanent_set, rel=0.05)


def test_a_studio_of_nothing_shows_it_beside_freestyle_and_computes_nothing(monkeypatch):
    monkeypatch.setattr("mechstyle.simulation.simulator.drop", lambda *_, **__: pytest.fail("something was dropped"))
    studio = Studio()
    state, viewer = studio.state, studio.viewer
    assert (state.session, state.status, state.layer, studio.previewer.awaited) == (None, "finished", "stays_bent", False)
    assert viewer.names == ("MechStyle", "Freestyle")
    assert "cracks" in viewer.badge._words.value
    assert [step.name for step in studio.next_steps.steps] == ["Make yours"]
    filled = [button.description for button in buttons(studio) if button.button_style == "primary"]
    assert filled == ["Make yours"]


def buttons(widget):
    for child in getattr(widget, "children", ()):
        if hasattr(child, "button_style") and hasattr(child, "click"):
            yield child
        yield from buttons(child)


def test_make_yours_waits_for_a_style_on_the_plain_part_and_one_gets_back():
    studio = Studio()
    studio.next_steps.press("Make yours")
    assert (studio.prompt_box.prompt, type(studio.viewer), studio.next_steps.steps) == ("", PartViewer, [])
    assert studio.state.another
    studio.back()
    assert studio.viewer.names == ("MechStyle", "Freestyle")


def test_between_its_tests_no_sentence_tells_of_its_end():
    """Over an iteration that nobody had dropped stood what stays bent of the end."""
    studio = Studio()
    at_the_end = studio.viewer.insight
    assert "stays bent" in at_the_end
    studio.state.iteration = 12
    assert studio.viewer.insight == ""
    assert_tells_one_truth(studio)
    studio.state.iteration = 40
    assert studio.viewer.insight == at_the_end


def test_a_branch_of_it_is_a_run_of_ones_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(Run, "events", lambda *_: iter(()))
    studio = Studio()
    before = studio.run.store.lanes()
    studio.controller.branch(20, "cautious", threshold=0.1)
    studio.state.session.wait(30)
    studio.state.pump()
    assert studio.run.store.place.is_relative_to(tmp_path)
    assert set(studio.run.store.lanes()) == {*before, "cautious"}
    assert opening.opening().store.lanes() == before
    assert studio.state.status in NOT_RUNNING


def test_another_part_is_not_judged_by_what_the_lesson_allows():
    studio = Studio()
    studio.schedule_selector.iterations = 30
    studio.part_picker.choose("gallery:phone_stand")
    assert (studio.drop_options.tolerance, studio.drop_options.nearly_flat, studio.prompt_box.side) == (0.2, True, "auto")
    assert studio.schedule_selector.iterations == 30, "somebody wanted so many"
    assert set(PromptBox.FIELDS) >= {"side"}
    assert DropTest().height == studio.drop_options.height


@pytest.mark.parametrize("leave", [lambda one: one.part_picker.choose("gallery:phone_stand"), Studio.make_yours], ids=["part", "style"])
def test_who_has_looked_at_the_free_one_of_it_has_not_asked_for_freestyle(leave):
    """The next part was run without feedback, with a styled underside."""
    studio = Studio()
    studio.state.lane = FREE
    assert studio.control_selector.freestyle
    leave(studio)
    asked = studio.state.settings
    assert (asked["control"], asked["base"], asked["guarantee"]) == tuple(DEFAULTS[name] for name in ("control", "base", "guarantee"))


def test_what_only_a_picture_or_a_run_needs_is_not_loaded_while_it_opens():
    """Loading matplotlib's figures and plotly's objects took as long as all the rest of the Studio."""
    slow = ("matplotlib.figure", "plotly.graph_objs", "plotly.subplots")
    asked = f"import sys\nfrom mechstyle_widgets import Studio\nStudio()\nprint([name for name in {slow} if name in sys.modules])"
    assert subprocess.run([sys.executable, "-c", asked], check=True, capture_output=True, text=True).stdout.strip() == "[]"


def test_every_iteration_is_read_a_few_times_however_many_parts_tell_of_it(monkeypatch):
    """Each note and each badge read the whole story anew: 24 times while a Studio was made, and 40 files for each iteration on the way."""
    read: list[str] = []
    get = Objects.get
    monkeypatch.setattr(Objects, "get", lambda objects, digest: read.append(digest) or get(objects, digest))
    studio = Studio()
    stored = {row.digest for rows in studio.state.histories.values() for row in rows}
    in_between = Counter(digest for digest in read if digest in stored - {studio.state.row().digest})
    assert in_between.total() < 4 * len(stored)
    read.clear()
    studio.state.iteration -= 5
    assert len(stored & set(read)) < 5
    studio.close()
