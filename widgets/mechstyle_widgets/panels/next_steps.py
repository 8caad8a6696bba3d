"""What leads on from what is on show: from the shipped comparison to a part of one's own, from a part that fails to what helps it.

A cure says what it costs, worked out of the surface on show; whether it holds is for its own test to say.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import ipywidgets
import numpy as np

from mechstyle.records import sentences
from mechstyle.records.recipe import DEFAULTS
from mechstyle.records.regions import Sphere
from mechstyle.runs.recipes import FREESTYLE
from mechstyle.runs.run import Run
from mechstyle.simulation.part import bounds_for
from mechstyle_widgets.jupyter.language import said, word
from mechstyle_widgets.jupyter.looks import lean, show
from mechstyle_widgets.panels.mask_inspector import MaskInspector
from mechstyle_widgets.settings.drop import DropOptions
from mechstyle_widgets.state.controller import Controller
from mechstyle_widgets.state.on_show import OnShow, on_show, share_kept
from mechstyle_widgets.state.opening import shipped
from mechstyle_widgets.viewer.badge import worst_vertex

AROUND = 0.12
"""Radius of the ball around the worst place that a cure is about, as a share of the size of the part."""
THICKER = 1.5
"""By how much a part that fails without a style may be thickened [mm]."""


@dataclass(frozen=True)
class Step:
    """Something that leads on: what it is, what it costs as far as that is known, and what pressing it does."""

    name: str
    foreseen: str
    act: Callable[[], object]


class NextSteps(ipywidgets.HBox):  # type: ignore[misc]  # ipywidgets has no types
    """Buttons under the run controls, as long as something leads on from what is on show."""

    children: tuple[Any, ...]
    steps: list[Step]

    def __init__(self, controller: Controller, inspector: MaskInspector, drop: DropOptions, make_yours: Callable[[], object]) -> None:
        """Lead on from what a controller's state shows; `make_yours` leaves the shipped comparison."""
        self._controller, self._state, self._inspector, self._drop = controller, controller.state, inspector, drop
        self._make_yours = make_yours
        self._words = lean(ipywidgets.Label)
        super().__init__([self._words])
        self.add_class("mechstyle-next")
        self._state.observe(self._offer, ("checkpoint", "lane", "status", "another", "pinned", "run"))
        self._offer()

    def press(self, name: str) -> None:
        """Do what a button of that name does."""
        next(step for step in self.steps if step.name == name).act()

    def _offer(self, _change: object = None) -> None:
        words, self.steps = self._found()
        self._words.value = word(words)
        for button in self.children[1:]:
            button.close()
        buttons = []
        for step in self.steps:
            label = " · ".join(filter(None, (word(step.name), said(step.foreseen))))
            buttons.append(lean(ipywidgets.Button, description=label, tooltip=label, layout={"width": "auto"}))
            buttons[-1].on_click(lambda _, act=step.act: act())
        for button in buttons[:1]:
            button.button_style = "primary"
        self.children = (self._words, *buttons)
        show(self, buttons)

    def _found(self) -> tuple[str, list[Step]]:
        """What leads on, and what is said before it."""
        state, shown = self._state, on_show(self._state)
        if state.run is None or state.busy or state.another or shown is None:
            return "", []
        if shown.fails:
            return "What helps:", list(self._cures(state.run, shown))
        return ("An example of what this does:", [Step("Make yours", "", self._make_yours)]) if shipped(state.run) else ("", [])

    def _cures(self, run: Run, shown: OnShow) -> Iterator[Step]:
        """What may help a part that fails, the likeliest first: each but the last begins a branch."""
        if not shown.iteration:
            yield from self._thicker(run)
            return
        if run.recipe.restraint.feedback:
            yield from self._more_careful(run)
        else:
            yield self._held_back()
        yield from self._around_the_place(run, shown)
        plain = on_show(self._state, run.lane, 0)
        if plain is not None and plain.fails:
            yield from self._thicker(run)

    def _held_back(self) -> Step:
        """MechStyle instead of Freestyle: what it came to where that is known."""
        for branch in self._state.branches:
            end = on_show(self._state, branch.lane, branch.iterations)
            if end is None or end.kept is None or end.verdict is None or not branch.recipe.restraint.feedback:
                continue
            if end.verdict.passes:
                row = end.verdict.deciding
                found = "" if row is None else f"{sentences.found(row)} of {sentences.allowed(row)}, {end.kept:.0%} kept"
                return Step("MechStyle", found, partial(self._state.go_to, branch.lane))
        return Step("Hold it back", "", partial(self._branch, 0, **{name: DEFAULTS[name] for name in FREESTYLE}))

    def _branch(self, iteration: int, **changes: Any) -> None:
        self._controller.branch(iteration, **changes)

    def _more_careful(self, run: Run) -> Iterator[Step]:
        """Half the threshold, from the first test at which that makes a difference."""
        settings = {**self._inspector.in_force(run), "threshold": 0.5 * run.recipe.restraint.threshold}
        place = self._inspector.first_difference(run, settings)
        if place is not None:
            there = self._state.checkpoint_at(place)
            assert there is not None, "it was tested"
            held = 1.0 - float(self._inspector.mask(run, there, **settings).mean())
            now = 1.0 - float(there.mask.mean())
            yield Step("Hold back more", f"{held:.0%} of the movement instead of {now:.0%}", partial(self._branch, place, **settings))

    def _around_the_place(self, run: Run, shown: OnShow) -> Iterator[Step]:
        """Less relief around what stays bent: growing from nothing in its middle, or none at all."""
        checkpoint, surface, kept = self._state.checkpoint, run.part.surface, share_kept(run)
        if checkpoint is None or shown.verdict is None or kept is None:
            return
        reach = round(AROUND * surface.size, 1)
        vertex = worst_vertex(surface.displaced(checkpoint.displacement), checkpoint, shown.verdict)
        x, y, z = (round(float(value), 2) for value in surface.vertices[vertex])
        for name, ball in (
            ("Shallower there", Sphere((x, y, z), 0.1 * reach, ramp=reach)), ("Keep this place plain", Sphere((x, y, z), reach)),
        ):  # fmt: skip
            protect = (*run.recipe.restraint.protect, ball)
            left = self._left(run, checkpoint.displacement, protect)
            yield Step(name, f"about {left * kept:.0%} kept", partial(self._branch, 0, protect=protect))

    def _left(self, run: Run, relief: np.ndarray, protect: tuple[object, ...]) -> float:
        """Share of a relief that is left where more regions are protected."""
        now, then = (bounds_for(run.part, recipe)[0].freedom for recipe in (run.recipe, run.recipe.with_settings(protect=protect)))
        share = np.divide(then, now, out=np.zeros_like(then), where=now > 0.0)
        weight = np.abs(relief) * run.part.surface.vertex_areas
        return float((weight * share).sum() / weight.sum()) if weight.any() else 1.0

    def _thicker(self, run: Run) -> Iterator[Step]:
        """A part that fails without a style is thickened before it gets one, in a run of its own."""
        surface, most = run.part.surface, THICKER
        if run.part.mass_gained or surface.volume <= 0.0:
            return
        gained = run.recipe.test.material.density * most * float(surface.vertex_areas.sum())
        yield Step("Thicken", f"up to {most:g} mm, {gained:.0f} g", partial(self._thicken, most))

    def _thicken(self, most: float) -> None:
        self._drop.strengthen = most
        self._controller.run()
