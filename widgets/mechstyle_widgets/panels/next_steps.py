"""What leads on from what is on show: from the shipped comparison to a part of one's own, from a part that fails to what helps it.

A cure says what is foreseen of it, from the test that failed (`simulation.foresight`); whether it holds is for its own test to say.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property, partial
from html import escape
from typing import Any

import ipywidgets
import numpy as np

from mechstyle.errors import BadInput
from mechstyle.loop.bounds import Bounds
from mechstyle.loop.engine import retained_share
from mechstyle.records import Checkpoint, Simulation, Verdict, sentences
from mechstyle.records.mesh import Field
from mechstyle.records.recipe import DEFAULTS
from mechstyle.records.regions import Sphere
from mechstyle.runs.recipes import FREESTYLE
from mechstyle.runs.run import Run
from mechstyle.simulation import foresight
from mechstyle.simulation.part import bounds_for
from mechstyle_widgets.jupyter.language import said, word
from mechstyle_widgets.jupyter.looks import lean, show
from mechstyle_widgets.panels.mask_inspector import MaskInspector
from mechstyle_widgets.settings.drop import DropOptions
from mechstyle_widgets.state.controller import Controller
from mechstyle_widgets.state.on_show import OnShow, on_show
from mechstyle_widgets.state.opening import shipped

AROUND = 0.12
"""Radius of the ball around what yields that a cure is about, as a share of the size of the part."""
THICKER = 1.5
"""By how much a part that fails without a style may be thickened [mm]."""
LEAST = 1e-6
"""Relief [mm] and movement below which nothing is there that could be less."""
NOTHING_MORE = "at none of its tests would it have held anything back"


@dataclass(frozen=True)
class Step:
    """Something that leads on: its name, what is foreseen of it, what pressing it does, and why it would be of no use, if it would."""

    name: str
    foreseen: str
    act: Callable[[], object]
    useless: str = ""


class NextSteps(ipywidgets.HBox):  # type: ignore[misc]  # ipywidgets has no types
    """Buttons under the run controls, as long as something leads on from what is on show."""

    children: tuple[Any, ...]
    steps: list[Step]
    useless: list[Step]

    def __init__(self, controller: Controller, inspector: MaskInspector, drop: DropOptions, make_yours: Callable[[], object]) -> None:
        """Lead on from what a controller's state shows; `make_yours` leaves the shipped comparison."""
        self._controller, self._state, self._inspector, self._drop = controller, controller.state, inspector, drop
        self._make_yours = make_yours
        self._around: tuple[object, tuple[Step, ...]] = (None, ())
        self._words, self._not = lean(ipywidgets.Label), lean(ipywidgets.HTML)
        super().__init__([self._words, self._not])
        self.add_class("mechstyle-next")
        self._state.observe(self._offer, ("checkpoint", "lane", "status", "another", "pinned", "run"))
        self._offer()

    def press(self, name: str) -> None:
        """Do what a button of that name does."""
        next(step for step in self.steps if step.name == name).act()

    def _offer(self, _change: object = None) -> None:
        words, found = self._found()
        self.steps, self.useless = ([step for step in found if bool(step.useless) == of_no_use] for of_no_use in (False, True))
        self._words.value = word(words) if self.steps else ""
        for button in self.children[1:-1]:
            button.close()
        buttons = []
        for step in self.steps:
            label = " · ".join(filter(None, (word(step.name), said(step.foreseen))))
            buttons.append(lean(ipywidgets.Button, description=label, tooltip=label, layout={"width": "auto"}))
            buttons[-1].on_click(lambda _, act=step.act: act())
        for button in buttons[:1]:
            button.button_style = "primary"
        lines = (said(f"{step.name} would not help: {step.useless}.") for step in self.useless)
        self._not.value = "".join(f"<div>{escape(line)}</div>" for line in lines)
        show(self._not, self.useless)
        self.children = (self._words, *buttons, self._not)
        show(self, found)

    def _found(self) -> tuple[str, list[Step]]:
        """What leads on, and what is said before it."""
        state, shown = self._state, on_show(self._state)
        if state.run is None or state.busy or state.another or shown is None:
            return "", []
        if shown.fails:
            return "What helps:", list(self._cures(state.run, shown))
        return ("An example of what this does:", [Step("Make yours", "", self._make_yours)]) if shipped(state.run) else ("", [])

    def _cures(self, run: Run, shown: OnShow) -> Iterator[Step]:
        """What may help a part that fails, the likeliest first; each but the last begins a branch with the settings of the lane on show."""
        checkpoint, plain = self._state.checkpoint, self._state.checkpoint_at(0)
        if checkpoint is None or plain is None or shown.verdict is None or shown.verdict.deciding is None:
            return
        tests = (self._state.simulation(run.store, one) for one in (checkpoint, plain))
        failed = _Failed(run, checkpoint, shown.verdict, *tests)
        if not shown.iteration:
            yield from self._thicker(failed)
            return
        if run.recipe.restraint.feedback:
            yield from self._more_careful(failed)
        else:
            yield self._held_back(failed)
        row = self._state.row()
        key = ("" if row is None else row.digest, run.lane)
        if self._around[0] != key:  # a status or a pin changes nothing of it
            self._around = key, ()
            with suppress(BadInput):  # a region of the run holds nothing of its part, so that it cannot be branched
                self._around = key, tuple(self._around_the_place(failed))
        yield from self._around[1]
        unstyled = on_show(self._state, run.lane, 0)
        if unstyled is not None and unstyled.fails and unstyled.verdict is not None:
            yield from self._thicker(replace(failed, checkpoint=plain, verdict=unstyled.verdict, tested=failed.plain))

    def _held_back(self, failed: _Failed) -> Step:
        """MechStyle instead of Freestyle: what it came to where that is known, else what its correction comes down to."""
        for branch in self._state.branches:
            end = on_show(self._state, branch.lane, branch.iterations)
            if end is None or end.kept is None or end.verdict is None or not branch.recipe.restraint.feedback:
                continue
            if end.verdict.passes:
                row = end.verdict.deciding
                found = "" if row is None else f"{sentences.found(row)} of {sentences.allowed(row)}, {end.kept:.0%} kept"
                return Step("MechStyle", found, partial(self._state.go_to, branch.lane))
        words = f"{foresight.held_back(failed.verdict).words} stays bent, {foresight.certain_share(failed.verdict):.0%} or more kept"
        held = {name: DEFAULTS[name] for name in FREESTYLE}
        return Step("Hold it back", words, partial(self._branch, failed.run, 0, **held))

    def _branch(self, run: Run, iteration: int, **changes: Any) -> None:
        """Begin a branch of a lane: what was in force at the iteration may be that of the lane it comes from."""
        there = run.store.recipe(run.store.find(iteration, run.lane).recipe)
        own = {name: value for name, _, value in there.differences(run.recipe)}
        self._controller.branch(iteration, **{**own, **changes})

    def _more_careful(self, failed: _Failed) -> Iterator[Step]:
        """Half the threshold, from the first test at which that makes a difference."""
        run = failed.run
        settings = {**self._inspector.in_force(run), "threshold": 0.5 * run.recipe.restraint.threshold}
        place, end = self._inspector.first_difference(run, settings), failed.checkpoint
        if place is None or place >= end.iteration:
            yield Step("Hold back more", "", lambda: None, NOTHING_MORE)
            return
        numbers = [row.iteration for row in self._state.history if row.verdict is not None and place <= row.iteration < end.iteration]
        tests = [one for number in numbers if (one := self._state.checkpoint_at(number)) is not None]
        then = tests[0].displacement.copy()
        for test, after in zip(tests, [*tests[1:], end], strict=True):  # each holds back until the next
            then += (after.displacement - test.displacement) * _ratio(self._inspector.mask(run, test, **settings), test.mask)
        yield failed.step("Hold back more", _ratio(then, end.displacement), partial(self._branch, run, place, **settings))

    def _around_the_place(self, failed: _Failed) -> Iterator[Step]:
        """Less relief around what yields: growing from nothing in its middle, or none at all."""
        run, surface = failed.run, failed.run.part.surface
        reach = round(AROUND * surface.size, 1)
        vertex = foresight.hinge(failed.verdict, failed.tested, surface, reach)
        x, y, z = (round(float(value), 2) for value in surface.vertices[vertex])
        for name, ball in (
            ("Shallower there", Sphere((x, y, z), 0.1 * reach, ramp=reach)), ("Keep this place plain", Sphere((x, y, z), reach)),
        ):  # fmt: skip
            protect = (*run.recipe.restraint.protect, ball)
            then = bounds_for(run.part, run.recipe.with_settings(protect=protect))[0].freedom
            yield failed.step(name, _ratio(then, failed.bounds.freedom), partial(self._branch, run, 0, protect=protect))

    def _thicker(self, failed: _Failed) -> Iterator[Step]:
        """A part that fails without a style is thickened before it gets one, in a run of its own."""
        part, material = failed.run.part, failed.run.recipe.test.material
        if part.mass_gained or part.surface.volume <= 0.0:
            return
        gained = material.density * THICKER * float(part.surface.vertex_areas.sum())
        seen = foresight.thickened(failed.verdict, failed.tested, part.surface, part.thickness, THICKER)
        words = f"{seen.words} stays bent without a style, up to {THICKER:g} mm and {gained:.0f} g more"
        yield Step("Thicken", words, partial(self._thicken, THICKER))

    def _thicken(self, most: float) -> None:
        self._drop.strengthen = most
        self._controller.run()


@dataclass(frozen=True, eq=False)
class _Failed:
    """A tested surface that fails: its run, checkpoint, verdict and simulation, and the simulation of the part without a style."""

    run: Run
    checkpoint: Checkpoint
    verdict: Verdict
    tested: Simulation
    plain: Simulation

    @cached_property
    def bounds(self) -> Bounds:
        """How far its style may go."""
        return bounds_for(self.run.part, self.run.recipe)[0]

    def step(self, name: str, left: Field, act: Callable[[], object]) -> Step:
        """A cure that leaves a share of the relief, shape [vertex_count], with what is foreseen of it."""
        part = self.run.part
        masked = self.run.recipe.restraint.feedback
        seen = foresight.with_less_relief(self.verdict, self.tested, self.plain, part.surface, part.thickness, left, masked=masked)
        relief, areas = self.checkpoint.displacement, self.bounds.seen_areas(part.surface)
        kept = retained_share(relief * np.clip(left, 0.0, 1.0), relief, areas)
        return Step(name, f"{seen.words} stays bent, about {kept:.0%} of this relief", act, seen.why)


def _ratio(then: Field, now: Field) -> Field:
    """What is left of a field, shape [vertex_count]; all of it where there is nothing."""
    return np.clip(np.divide(then, now, out=np.ones_like(now), where=np.abs(now) > LEAST), 0.0, 1.0).astype(np.float32)
