"""What is on show: the verdict on that very surface, and nothing said of any other."""

from types import SimpleNamespace

import numpy as np
import pytest

from mechstyle.pictures.fields import STAYS_BENT
from mechstyle.pictures.panels import bent_panel
from mechstyle.records import sentences
from mechstyle.runs.run import Run
from mechstyle_widgets.panels.result import Result
from mechstyle_widgets.state.on_show import OnShow, on_show
from mechstyle_widgets.state.outcomes import UNTESTED
from mechstyle_widgets.state.studio_state import FREE, StudioState
from mechstyle_widgets.studio import Studio
from mechstyle_widgets.viewer import legend
from mechstyle_widgets.viewer.run_viewer import RunViewer
from support.told import outcomes


def test_every_iteration_says_the_outcome_of_its_own_surface_or_that_it_was_not_tested(done):
    state, store = StudioState(done), done.store
    for lane in store.lanes():
        for row in state.histories[lane]:
            shown = on_show(state, lane, row.iteration)
            own = store.checkpoint(row.digest).verdict
            assert shown.verdict == own
            assert shown.words == (sentences.untested(shown.tested_at) if own is None else sentences.marked(own.short, sure=own.sure))
            assert (shown.look is UNTESTED) == (own is None)


def test_what_was_not_tested_says_since_when(done):
    state = StudioState(done)
    state.iteration = 6
    assert on_show(state).words == "NOT TESTED since iteration 4"
    state.iteration = 3
    assert on_show(state).words == "NOT TESTED", "the plain part is another"


def test_the_plain_part_is_called_plain(done):
    state = StudioState(done)
    assert on_show(state).title == "sheet, brick"
    assert on_show(state, "main", 0).title == "sheet, plain"


def test_there_is_nothing_on_show_before_a_run_and_no_iteration_that_is_not_there(done):
    assert on_show(StudioState()) is None
    assert on_show(StudioState(done), "main", 99) is None
    assert OnShow("sheet, moss").caption == "sheet, moss: NOT TESTED"


@pytest.mark.parametrize("iteration", [0, 3, 4, 6, 12])
def test_badge_result_and_picture_say_the_same(done, iteration):
    state = StudioState(done)
    viewer, result = RunViewer(state), Result(state)
    state.iteration = iteration
    shown = on_show(state)
    for told in (viewer.badge._words.value, result.value, viewer._heading):
        said = outcomes(told)
        assert said == {shown.verdict.outcome if shown.verdict else sentences.NOT_TESTED}, told
    assert viewer._heading == shown.caption


def test_panes_have_captions_of_their_own(done):
    state = StudioState(done)
    viewer = RunViewer(state)
    state.iteration = 6
    viewer.compared = ("soft", 9)
    assert viewer.captions == tuple(on_show(state, *place).caption for place in (("main", 6), ("soft", 9)))
    assert viewer.names == tuple(on_show(state, *place).pane for place in (("main", 6), ("soft", 9)))


def test_the_relief_that_is_left_is_known_at_the_end_alone(done, monkeypatch):
    monkeypatch.setattr(type(done), "summary", property(lambda _run: SimpleNamespace(kept=0.8, notes=())))
    state = StudioState(done)
    assert on_show(state).kept == 0.8
    assert on_show(state, "main", 6).kept is None


@pytest.mark.slow
def test_whatever_tells_how_much_stays_bent_tells_the_figure_of_the_verdict(tmp_path):
    """The legend said 0.54 mm, the largest of the surface, beside a verdict of 0.53 mm, of all that a small volume exceeds."""
    studio = Studio()
    studio.state.lane = FREE
    state, viewer, run = studio.state, studio.viewer, Run(studio.run.store, FREE)
    row, simulation = on_show(state).verdict.deciding, run.simulation()
    figure, lengths = sentences.bend_in(row, row.permanent_set), np.linalg.norm(simulation.set_of(landing=row.landing), axis=1)
    assert figure != sentences.bend(lengths.max()), "so that the test can tell them apart"
    bent = viewer.subject.layer(STAYS_BENT)
    assert (bent.text_at(bent.extremes()[0]), bent.scale.beyond(bent.values).any()) == (figure, True)
    assert bent.values.max() == np.float32(row.permanent_set)
    viewer.fly_to_worst()
    viewer.places = (viewer.probed,)
    brief = [viewer._said.value, viewer.outcomes[0], viewer._list.rows[0][2] + " mm", studio._result.value]
    told = [*brief, legend.colour_bar(bent, viewer.subject.mesh), bent_panel(run.surface(), simulation, row).note]
    written = run.exported(tmp_path / "part.3mf")
    told += [*written.warnings, run.report(tmp_path / "part.html").read_text(encoding="utf-8")]
    assert [figure in one for one in told] == [True] * len(told)
