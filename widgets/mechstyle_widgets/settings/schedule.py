"""When to simulate: the schedule with its parameters, and a preview of where it would."""

from __future__ import annotations

from typing import Any

import ipywidgets
import traitlets

from mechstyle.records import SCHEDULES, Recipe
from mechstyle.runs.recipes import MASKED
from mechstyle.simulation.estimate import Plan, plan
from mechstyle_widgets.jupyter.language import word
from mechstyle_widgets.jupyter.looks import lean, show
from mechstyle_widgets.jupyter.svg import Frame, drawing, line
from mechstyle_widgets.settings.section import WIDE, Section, linked, setting

WHAT = {
    "every": "every k iterations",
    "quadratic": "at 1, 4, 9, 16 …",
    "exponential": "at 2, 4, 8, 16 …",
    "geometry": "as the shape changes",
    "stress": "by shape, sooner at high stress",
    "never": "only at the end",
}


class ScheduleSelector(Section):
    """Schedule, its parameters, and how many iterations there are.

    Attributes:
        schedule: One of SCHEDULES.
        every: Interval of `every` [iterations].
        travel: Displacement over wall thickness that triggers `geometry` and `stress`.
        iterations: Iterations of the run.
        relief: Depth of the relief [mm]; the preview needs it.
        amplitude: Half the depth of the relief over wall thickness, as far as that decides; likewise.
    """

    SEEN = ("relief", "amplitude")

    schedule = traitlets.Enum(SCHEDULES, MASKED)  # the Studio is where people watch the mask grow
    every = setting("every")
    travel = setting("travel")
    iterations = setting("iterations")
    relief = setting("relief")
    amplitude = setting("amplitude")

    def __init__(self, **traits: Any) -> None:
        """Offer the schedules; `traits` are any of the attributes."""
        iterations = linked(self, "iterations", ipywidgets.BoundedIntText, "iterations")
        self._choice = linked(self, "schedule", ipywidgets.Dropdown, "tested", options=[(WHAT[name], name) for name in SCHEDULES])
        self._every = linked(self, "every", ipywidgets.BoundedIntText, "k")
        self._travel = linked(self, "travel", ipywidgets.BoundedFloatText, "share of wall", step=0.01)
        self._plot = lean(ipywidgets.HTML, layout=WIDE)
        super().__init__([iterations, self._choice, self._every, self._travel, self._plot])
        for name, value in traits.items():
            setattr(self, name, value)
        self.observe(self._redraw, (*self.FIELDS, *self.SEEN))
        self._redraw()

    def take(self, recipe: Recipe) -> None:
        """Choose what a recipe has."""
        super().take(recipe)
        self.relief, self.amplitude = recipe.style.relief, recipe.style.amplitude

    @property
    def brief(self) -> str:
        """How many iterations, and when they are simulated."""
        often = word("every {}").format(self.every) if self.schedule == "every" else word(WHAT[self.schedule])
        return f"{self.iterations} {word('iterations')}, {often}"

    @property
    def plan(self) -> Plan:
        """Iterations it would simulate."""
        return plan(self.schedule, self.every, self.travel, self.iterations, self.relief, self.amplitude)

    def _redraw(self, _change: object = None) -> None:
        show(self._every, self.schedule == "every")
        show(self._travel, not self.plan.certain)
        guess = "" if self.plan.certain else "; an estimate, the run decides"
        self.note(f"{self.plan.count}, the last one in all landings{guess}")
        frame = Frame(0.0, float(self.iterations), height=48, left=10)
        places = [frame.x(place) for place in self.plan.places]
        marks = [line(x, 6, x, frame.floor, "var(--jp-brand-color1, #1565c0)") for x in places]
        ticks = (0.0, float(self.iterations // 2), float(self.iterations)) if self.iterations > 1 else (0.0, 1.0)
        words = f"{WHAT[self.schedule]}: {self.plan.count} of {self.iterations} iterations"
        self._plot.value = drawing(frame, [frame.axes("iteration", ticks), *marks], words)
