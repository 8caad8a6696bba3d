"""Hundreds of actions in any order, as browsers send them: state, picture and controls agree after each, and nothing is said in the log."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from typing import Any

import ipywidgets
import numpy as np
import pytest
from ipywidgets.widgets.widget_int import _BoundedInt

from mechstyle.pictures.fields import STAYS_BENT
from mechstyle_widgets.jupyter.looks import family
from mechstyle_widgets.panels.run_controls import NOT_RUNNING
from mechstyle_widgets.panels.take_away import TakeAway
from mechstyle_widgets.settings.thumbnail_buttons import PictureChoice
from mechstyle_widgets.state.studio_state import StudioState
from mechstyle_widgets.studio import Studio
from mechstyle_widgets.viewer.run_viewer import RunViewer
from support.sheet_studio import without_physics
from support.told import assert_tells_one_truth

PATIENCE = 30.0
ACTIONS = 200
PROMPTS = ("brick", "small wood", "outside: stone; rim: gold studs", "nonsense", "", "5 mm bricks, blue")
REGIONS = ("", "inside", "box 0 0 0 10 10 10", "sphere 900 0 0 1", "a circle", "below 5\nbox 0 0 0 5 5 5 ramp 2")
SMALL = {"iterations": (6, 12)}
"""What a run of no time can have."""
SOLID = "thicken [mm]"
"""What asks for a drop test before a run begins: a sheet has no volume."""
CHOICES = (ipywidgets.Dropdown, ipywidgets.ToggleButtons, ipywidgets.Select, ipywidgets.SelectionSlider)
Action = tuple[str, Callable[[], None]]


@pytest.fixture
def studio(tmp_path, monkeypatch, cube) -> Iterator[Studio]:
    monkeypatch.chdir(tmp_path)
    without_physics(monkeypatch)
    monkeypatch.setattr(TakeAway, "_begin", lambda *_: None)  # a sheet has no volume; what is made is tested elsewhere
    made = Studio(cube, prompt="brick", schedule="every", every=4, iterations=12, vertices=64)
    for group in made._groups:
        group.unfolded = True
    yield made
    made.close()


def send(widget: ipywidgets.Widget, value: Any) -> None:
    """A value as a browser sends it."""
    key = "index" if hasattr(widget, "index") and "index" in widget.keys else "value"
    widget.set_state({key: value})


def text_for(widget: Any, rng: random.Random) -> str:
    words = f"{widget.description} {widget.placeholder}"
    known = {"small blue stones": PROMPTS, "region": REGIONS, "new lane": ("", "soft", "../away", "hard")}
    return rng.choice(next((texts for sign, texts in known.items() if sign in words), ("", "nowhere.stl", "nowhere.toml")))


def action_on(widget: Any, rng: random.Random) -> Action | None:
    """What the mouse or the keyboard may do to a control; None for what is none, or is out of reach."""
    if getattr(widget, "disabled", False) or isinstance(widget, ipywidgets.FileUpload) or getattr(widget, "description", "") == SOLID:
        return None
    name = f"{type(widget).__name__} {getattr(widget, 'description', '') or getattr(widget, 'tooltip', '')}"
    if isinstance(widget, PictureChoice):
        picture = rng.choice(list(widget.names))
        return f"press the picture of {picture}", lambda: widget.press(picture)
    if isinstance(widget, ipywidgets.Button):
        return f"press {name}", widget.click
    if isinstance(widget, ipywidgets.ToggleButton | ipywidgets.Checkbox):
        return f"switch {name}", lambda: send(widget, not widget.value)
    if isinstance(widget, CHOICES) and widget.options:
        chosen = rng.randrange(len(widget.options))
        return f"choose {chosen} of {name}", lambda: send(widget, chosen)
    given = value_for(widget, rng)
    return None if given is None else (f"set {name} to {given!r}", lambda: send(widget, given))


def value_for(widget: Any, rng: random.Random) -> Any:
    """A text or a number that a control may be given; None for what takes neither."""
    if isinstance(widget, ipywidgets.Text | ipywidgets.Textarea):
        return text_for(widget, rng)
    return number_for(widget, rng) if hasattr(widget, "min") and hasattr(widget, "step") else None


def number_for(widget: Any, rng: random.Random) -> float:
    if isinstance(widget, ipywidgets.FloatLogSlider):
        return widget.base ** rng.uniform(widget.min, widget.max)
    if isinstance(widget, _BoundedInt):
        return rng.choice(SMALL.get(widget.description, (widget.min, rng.randint(widget.min, min(widget.max, 40)))))
    return round(rng.uniform(widget.min, min(widget.max, 2000.0)), 2)


def within_reach(widget: Any) -> Iterator[Any]:
    """The widget and what is in it, but for what is hidden."""
    look = getattr(widget, "layout", None)
    if isinstance(look, ipywidgets.Layout) and look.display != "none" and not isinstance(widget, ipywidgets.FloatProgress):
        yield widget
        for child in getattr(widget, "children", ()):
            yield from within_reach(child)


def controls(studio: Studio) -> list[Any]:
    """All that can be pressed, chosen or written now."""
    return list(within_reach(studio))


def events(studio: Studio, rng: random.Random) -> list[Action]:
    """What else may happen: a click on the part or the timeline, time going by, a page that asks for all of it anew."""
    state, viewer = studio.state, studio._viewer

    def click() -> None:
        corner = viewer.undeformed.vertices[rng.randrange(len(viewer.undeformed.vertices))]
        viewer._clicks(tuple(corner.tolist()))

    def wait() -> None:
        if state.session is not None and studio.controller.busy:
            state.session.wait(PATIENCE)
        state.pump()

    def look_at(iteration: int, lane: str) -> None:
        state.lane = lane
        studio._timeline.iteration = iteration

    lanes = [branch.lane for branch in state.branches] or ["main"]
    iteration, lane = rng.randint(0, 12), rng.choice(lanes)
    return [
        ("click on the part", click),
        ("wait", wait),
        ("wait", wait),
        ("news", state.pump),
        (f"look at {iteration} of {lane}", lambda: look_at(iteration, lane)),
        ("reload", lambda: [one.get_state() for one in family(studio)]),
    ]


def assert_agrees(studio: Studio) -> None:
    """What is shown is what the state holds."""
    state, viewer, timeline = studio.state, studio._viewer, studio._timeline
    assert studio._middle.children[0] is viewer
    assert timeline.iteration == timeline._curves.head == state.iteration <= state.iterations_done
    assert timeline.lane == studio.branches.lane == state.lane
    over = state.another and state.status in NOT_RUNNING  # what is asked for has not begun
    assert studio.run_controls._bar.value == (0.0 if over else state.fraction)
    closed = [type(one).__name__ for one in family(studio) if one.comm is None]
    assert closed == [], "a page that is loaded anew does not find what refers to them"
    if state.run is None:
        assert state.checkpoint is None
        return
    assert state.run.lane == state.lane
    assert {branch.lane for branch in state.branches} == set(state.histories)
    if state.checkpoint is None:
        return
    assert state.checkpoint.iteration == state.iteration
    assert state.row().digest == state.history[state.iteration].digest
    if isinstance(viewer, RunViewer):
        assert_shows_the_iteration(viewer, state)
        assert_tells_one_truth(studio)
        assert studio.mask_inspector.would_be.shape == state.checkpoint.displacement.shape


def assert_shows_the_iteration(viewer: RunViewer, state: StudioState) -> None:
    surface = state.run.part.surface
    assert viewer.layer == state.layer
    np.testing.assert_array_equal(viewer.subject.mesh.faces, surface.faces)
    np.testing.assert_allclose(viewer.subject.layer("stress").values, state.checkpoint.stress)
    if viewer.player.impact is None:
        bend = 0.0 if viewer.layer != STAYS_BENT else viewer.player.exaggeration * viewer.subject.bend
        undeformed = surface.displaced(state.checkpoint.displacement).vertices
        np.testing.assert_allclose(viewer.subject.mesh.vertices, undeformed + bend, rtol=1e-6)
        np.testing.assert_allclose(viewer._scenes[0]._vertices.array, viewer.subject.mesh.vertices, atol=1e-4)


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_whatever_is_pressed_in_whatever_order(studio, caplog, capsys, seed):
    rng, done = random.Random(seed), []
    for _ in range(ACTIONS // 2):
        happenings = events(studio, rng)
        made = rng.choice(happenings) if rng.random() < 0.3 else None
        while made is None:
            made = action_on(rng.choice(controls(studio)), rng)
        name, act = made
        done.append(name)
        try:
            act()
            studio.state.pump()
            if not studio.controller.busy or studio.state.session.state == "paused":
                studio.state.pump()
                assert_agrees(studio)
        except Exception as error:
            error.add_note("after " + "; ".join(done[-12:]))
            raise
    studio.controller.stop()
    if studio.state.session is not None:
        studio.state.session.wait(PATIENCE)
    studio.state.pump()
    assert_agrees(studio)
    assert [record.getMessage() for record in caplog.records if "holds a run with other settings" not in record.getMessage()] == []
    assert capsys.readouterr().err == ""
