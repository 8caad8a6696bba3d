"""Run, pause, step, stop; and how far it is."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from html import escape
from typing import Any

import ipywidgets
import traitlets

from mechstyle.errors import MechStyleError
from mechstyle.simulation.estimate import duration
from mechstyle_widgets.jupyter.language import said, word
from mechstyle_widgets.jupyter.looks import lean, show
from mechstyle_widgets.settings.section import WIDE, Section
from mechstyle_widgets.state.controller import Controller

BUTTONS = {
    "run": ("play", "Run", "84px", "Run to the end, or go on"),
    "both": ("columns", "Both", "76px", "MechStyle to the end, then Freestyle beside it"),
    "pause": ("pause", "", "44px", "Pause after the iteration in hand"),
    "step": ("step-forward", "", "44px", "One iteration, then pause"),
    "step_to_simulation": ("fast-forward", "", "44px", "On to the next simulation, then pause"),
    "stop": ("stop", "", "44px", "Stop; what was made is kept"),
}
"""Icon, words, width and tooltip of each button, by the method of the controller it calls."""
MAY = {
    "run": ("idle", "paused", "stopped", "finished", "failed"),
    "both": ("idle", "stopped", "finished", "failed"),
    "pause": ("running",),
    "step": ("idle", "paused", "stopped", "failed"),
    "step_to_simulation": ("idle", "paused", "stopped", "failed"),
    "stop": ("preparing", "running", "paused"),
}
"""In which states each button does something."""
GOES_ON = ("paused", "stopped", "failed")
"""In which states running is going on, unless the settings ask for another run."""
NOT_RUNNING = ("idle", "stopped", "finished", "failed")
"""In which states nothing is in hand."""
FOLLOWED = (
    "status", "pausing", "stage", "step", "fraction", "seconds_left", "message", "alarming", "iterations_done", "run", "settings",
    "another", "outlook",
)  # fmt: skip
"""Traits of the state they tell of."""


class RunControls(Section):
    """Buttons for a controller, a bar and a line that says what is being done and how long it will take.

    Attributes:
        words: The line under the bar.
        title: What stands before it in bold, part and style; may be empty.
    """

    words = traitlets.Unicode("")
    title = traitlets.Unicode("")

    def __init__(self, controller: Controller, back: Callable[[], object] = lambda: None) -> None:
        """Bind the buttons to a controller; `back` asks for the last run again."""
        self.controller, self.state = controller, controller.state
        self._buttons = {
            name: lean(ipywidgets.Button, icon=icon, description=words, tooltip=tooltip, layout={"width": width})
            for name, (icon, words, width, tooltip) in BUTTONS.items()
        }
        self._buttons["run"].button_style = "primary"
        for name, button in self._buttons.items():
            button.on_click(lambda _, name=name: getattr(self.controller, name)())
        self._bar = lean(ipywidgets.FloatProgress, min=0.0, max=1.0, layout=WIDE)
        self._line = lean(ipywidgets.HTML)
        what = "Part and settings of the last run again"
        self._back = lean(ipywidgets.Button, description="Back to the last run", icon="undo", tooltip=what, layout={"width": "auto"})
        self._back.on_click(lambda _: back())
        super().__init__([lean(ipywidgets.HBox, [*self._buttons.values(), self._back]), self._line, self._bar])
        self.add_class("mechstyle-run")
        for wide in (self._note, self._trouble):
            wide.add_class("mechstyle-wide")
        self.state.observe(self._show, FOLLOWED)
        self.observe(self._show, "title")
        self._show()

    def emphasise(self, filled: bool) -> None:
        """Fill the run button, or leave that to another; what it reads follows a part that was chosen, too."""
        self._buttons["run"].button_style = "primary" if filled else ""
        self._name()

    def _name(self) -> None:
        """Let the run button read what pressing it does."""
        goes_on = self.state.status in GOES_ON and self.state.run is not None
        with suppress(MechStyleError):  # nothing is begun; what is wrong is said where it is set
            goes_on = goes_on and not self.controller.asks_for_another()
        self._buttons["run"].description = word("Go on" if goes_on else "Run")

    def _show(self, _change: Any = None) -> None:
        state = self.state
        for name, button in self._buttons.items():
            button.disabled = state.status not in MAY[name] or (name == "pause" and state.pausing)
        self._name()
        show(self._back, state.another and state.status in NOT_RUNNING)
        over = state.another and state.status in NOT_RUNNING
        self._bar.value, self._bar.bar_style = 0.0 if over else state.fraction, "info"  # green, amber and red belong to verdicts
        (self._bar.add_class if state.status == "preparing" else self._bar.remove_class)("mechstyle-preparing")
        self.words = line_of(state)
        title = f'<span class="mechstyle-title"><b>{escape(self.title)}</b> · </span>' if self.title else ""
        about = escape(said(state.stage))
        # what is made is not read out every time
        spoken = f'<span role="status" aria-live="polite" title="{about}">{escape(said(self.words))}</span>'
        self._line.value = f'<div class="mechstyle-note">{title}{spoken}</div>'
        self.complain(state.message if state.alarming else "")
        self.note(state.message if not state.alarming else "")


def line_of(state: Any) -> str:
    """Status of a run, in one line."""
    parts = ["ready" if state.status == "idle" else state.status]
    if state.run is not None and state.status != "preparing":
        parts = [f"{state.status}, iteration {state.iterations_done} of {state.length}"]
    if state.status == "idle" or (state.another and state.status in NOT_RUNNING):
        parts = ["ready", *([state.outlook] if state.outlook else [])]
    if state.pausing:
        parts.append(f"pausing … when this {'drop test' if state.stage.startswith('drop test') else 'iteration'} has ended")
    if state.stage:
        what, _, why = state.stage.partition(": ")  # why it is dropped takes two lines: it is read under the mouse
        parts.append(f"{what}, {state.step:.0%}" if what == "drop test" and state.step > 0 else what if why else state.stage)
    if state.seconds_left is not None:
        parts.append(f"about {duration(state.seconds_left)} left")
    return " · ".join(parts)
