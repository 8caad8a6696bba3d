"""When to simulate: the schedule with its parameters, and a preview of where it would."""

from __future__ import annotations

from typing import Any

import ipywidgets
import numpy as np
import traitlets

from mechstyle.material import LIBRARY
from mechstyle.records import SCHEDULES, Recipe
from mechstyle.schedule import Progress, due
from mechstyle_widgets.drawing import Frame, drawing, line
from mechstyle_widgets.section import NARROW_LABEL, WIDE, Section

APPROACH = 40.0
"""Iterations in which the style comes nearer to its target by a factor of e."""
RELIEF = 1.2
"""Highest relief of a style over amplitude and wall thickness."""
SUPPOSED_DEMAND = 0.5
"""What a preview of the stress schedule takes for the demand of the vertex that moves most."""
WHAT = {
    "every": "every k iterations",
    "quadratic": "at 1, 4, 9, 16 …",
    "exponential": "at 2, 4, 8, 16 …",
    "geometry": "when a vertex has moved a share of its wall",
    "stress": "as geometry, sooner where stress is high",
    "never": "only at the end",
    "always": "every iteration",
}


class ScheduleSelector(Section):
    """Schedule, its parameters, and how many iterations there are.

    Attributes:
        schedule: One of SCHEDULES.
        every: Interval of `every` [iterations].
        travel: Displacement over wall thickness that triggers `geometry` and `stress`.
        iterations: Iterations of the run.
        amplitude: Height of the relief over wall thickness; the preview needs it.
    """

    FIELDS = ("schedule", "every", "travel", "iterations")

    schedule = traitlets.Enum(SCHEDULES, "stress")
    every = traitlets.Int(20, min=1, max=100_000)
    travel = traitlets.Float(0.1, min=1e-3, max=10.0)
    iterations = traitlets.Int(200, min=1, max=100_000)
    amplitude = traitlets.Float(0.15, min=0.0, max=2.0)

    def __init__(self, **traits: Any) -> None:
        """Offer the schedules; `traits` are any of the attributes."""
        look = {"style": NARROW_LABEL, "layout": WIDE}
        options = [(f"{name} – {WHAT[name]}", name) for name in SCHEDULES]
        self._choice = ipywidgets.Dropdown(options=options, description="simulate", **look)
        self._every = ipywidgets.BoundedIntText(description="k", min=1, max=100_000, **look)
        self._travel = ipywidgets.BoundedFloatText(description="share of wall", min=0.001, max=10.0, step=0.01, **look)
        self._iterations = ipywidgets.BoundedIntText(description="iterations", min=1, max=100_000, **look)
        self._plot = ipywidgets.HTML(layout=WIDE)
        super().__init__([self._iterations, self._choice, self._every, self._travel, self._plot])
        for name, value in traits.items():
            setattr(self, name, value)
        pairs = (("schedule", self._choice), ("every", self._every), ("travel", self._travel), ("iterations", self._iterations))
        for name, widget in pairs:
            traitlets.link((self, name), (widget, "value"))
        self.observe(self._redraw, (*self.FIELDS, "amplitude"))
        self._redraw()

    def take(self, recipe: Recipe) -> None:
        """Choose what a recipe has."""
        super().take(recipe)
        self.amplitude = recipe.amplitude

    @property
    def depends_on_the_run(self) -> bool:
        """Whether where it simulates is known only once the surface moves."""
        return self.schedule in ("geometry", "stress")

    def preview(self) -> list[int]:
        """Iterations that would be simulated, for a vertex that nothing holds back; the last one always is.

        The rules are the engine's own, asked about one vertex whose relief approaches its full height exponentially.
        """
        recipe = Recipe(surface="", tetrahedra="", prompt="", material=LIBRARY["PLA"], **self.settings)
        demand = np.full(1, SUPPOSED_DEMAND if self.schedule == "stress" else 0.0, np.float32)
        found, anchor, wall = [0], 0.0, np.ones(1, np.float32)
        for iteration in range(1, self.iterations):
            height = RELIEF * self.amplitude * (1.0 - np.exp(-iteration / APPROACH))
            moved = np.full(1, height - anchor, np.float32)
            if due(recipe, Progress(iteration, found[-1], moved, wall, demand)):
                found.append(iteration)
                anchor = height
        return [*found[1:], self.iterations]

    def _redraw(self, _change: object = None) -> None:
        self._every.layout.display = "" if self.schedule == "every" else "none"
        self._travel.layout.display = "" if self.depends_on_the_run else "none"
        places = self.preview()
        about = "about " if self.depends_on_the_run else ""
        count = f"{about}{len(places)} simulation{'s' if len(places) > 1 else ''}"
        guess = "; an estimate, the run decides" if self.depends_on_the_run else ""
        self.note(f"{count}, the last one in all orientations{guess}")
        self._plot.value = self._picture(places, count)

    def _picture(self, places: list[int], count: str) -> str:
        frame = Frame(0.0, float(self.iterations), height=48, left=10)
        marks = [line(frame.x(place), 6, frame.x(place), frame.floor, "var(--jp-brand-color1, #1565c0)") for place in places]
        ticks = (0.0, float(self.iterations // 2), float(self.iterations)) if self.iterations > 1 else (0.0, 1.0)
        return drawing(frame, [frame.axes("iteration", ticks), *marks], f"{self.schedule}: {count} of {self.iterations} iterations")
