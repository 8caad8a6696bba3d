"""The mask of an iteration, and the mask another strategy or threshold would give, without running anything."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from typing import Any

import ipywidgets
import numpy as np
import traitlets

from mechstyle.loop import control
from mechstyle.pictures.fields import RESTRAINT
from mechstyle.records import Checkpoint, Recipe, Simulation
from mechstyle.records.checkpoint import restrained
from mechstyle.records.mesh import Field
from mechstyle.runs.run import Run
from mechstyle.simulation.part import bounds_for
from mechstyle_widgets.jupyter.frame import unseen
from mechstyle_widgets.jupyter.language import word
from mechstyle_widgets.jupyter.looks import lean, show, unheard
from mechstyle_widgets.jupyter.svg import Frame, drawing, shares
from mechstyle_widgets.jupyter.throttle import Throttled
from mechstyle_widgets.settings.control import ControlSelector
from mechstyle_widgets.settings.section import WIDE, Fold, Section, Words
from mechstyle_widgets.state.controller import Controller
from mechstyle_widgets.viewer.layers import Layer, layer_of

LAYER = "what_if"
"""Name of the viewer's layer that shows the mask that would be."""
BINS = 24
WIDEST = 2.0
"""Demands of so many thresholds and more share the last bar of their histogram, or the numbers around 1 would stand on each other."""
DECIDES = ("control", "normalisation", "threshold", "material")
"""Fields of a recipe that a mask depends on, besides what is protected."""


class MaskInspector(Section):
    """Demand and mask of the iteration on show, beside the mask that other settings would make of the same stress.

    Attributes:
        selector: Where the other settings are chosen; set its traits to choose them in Python.
        would_be: The mask they would make, shape [vertex_count]; None without a checkpoint.
    """

    would_be = traitlets.Any(None, allow_none=True)

    def __init__(self, controller: Controller) -> None:
        """Inspect what a controller's state shows."""
        self.controller, self.state = controller, controller.state
        self._freedom = lru_cache(maxsize=4)(_freedom)
        self._original = lru_cache(maxsize=4)(lambda run: run.store.objects.get_record(run.checkpoint(0).simulation, Simulation))
        self.selector = ControlSelector()
        self._plots = Words(layout=WIDE)
        self._show_layer = lean(
            ipywidgets.ToggleButton,
            description="show it",
            icon="eye",
            tooltip="Colour the part by the mask that would be",
            layout={"width": "50%"},
        )
        self._use = lean(
            ipywidgets.Button,
            description="use this",
            icon="code-fork",
            tooltip="Go on with these settings, in a branch",
            layout={"width": "50%"},
        )
        self._slider = unseen(lean(
            ipywidgets.FloatLogSlider,
            description="more careful or more style", base=10, min=-1.0, max=1.0, step=0.02, readout=False,
            tooltip="Strength used at which a place may move no further; less is more careful",
            layout={"flex": "1 1 80px", "width": "auto"},
        ))  # fmt: skip
        ends = (lean(ipywidgets.Label, word("more careful")), self._slider, lean(ipywidgets.Label, word("more style")))
        slider = lean(ipywidgets.HBox, ends, layout=WIDE)
        slider.add_class("mechstyle-careful")
        buttons = lean(ipywidgets.HBox, [self._show_layer, self._use], layout=WIDE)
        self._asked = lean(ipywidgets.VBox, [slider, buttons])
        super().__init__([self._asked])
        self._more = Fold("more of this", lean(ipywidgets.VBox, [self.selector, self._plots]))
        self.children = (*self.children, self._more)  # below what is said of it
        traitlets.link((self.selector, "threshold"), (self._slider, "value"))
        self._slider.observe(self._slid, "value")
        self._use.on_click(lambda _: self.use())
        self.state.observe(lambda _: self.complain(""), ("iteration", "lane", "run", "status"))
        self.selector.observe(lambda _: self.complain(""), ("freestyle", *DECIDES))
        self._show_layer.observe(self._switch, "value")
        self.state.observe(self._restore, "run")
        self._soon = Throttled(self._redraw, self.state.alert)
        self.state.observe(lambda _: self._soon(), "checkpoint")
        self.state.observe(self._follow_layer, "layer")
        self.selector.observe(self._redraw, ("freestyle", *DECIDES))
        self._restore()

    def close(self) -> None:
        """Close it; what was still to be drawn is not."""
        self._soon.cancel()
        super().close()

    @property
    def settings(self) -> dict[str, Any]:
        """The settings that are tried, as fields of a recipe."""
        tried = self.selector
        return {"control": "none" if tried.freestyle else tried.control, **{name: getattr(tried, name) for name in DECIDES[1:]}}

    def layer(self) -> Callable[[Run, Checkpoint], Layer]:
        """What makes the mask that would be with the settings tried now, as a layer for a viewer's `derived`, in any thread."""
        settings = self.settings

        def made(run: Run, checkpoint: Checkpoint) -> Layer:
            would_be = replace(
                RESTRAINT, name=LAYER, title="what if", label="movement held back, what if", note="1 = might not move any further"
            )
            return layer_of(would_be, would_be.made(self.mask(run, checkpoint, **settings)))

        return made

    def mask(self, run: Run, checkpoint: Checkpoint, **settings: Any) -> Field:
        """The mask that settings make of a checkpoint's stress, as a branch from there would begin with, shape [vertex_count]."""
        recipe, freedom = run.recipe.with_settings(**settings), self._freedom(run, run.recipe)
        tested, original = self.state.simulation(run.store, checkpoint), self._original(run)
        if tested.failure or original.failure:  # it restrains nothing without an answer
            return freedom
        demand = control.demand(tested, original, recipe)
        return control.mask(demand, recipe.restraint.control, recipe.restraint.threshold) * freedom

    def use(self) -> None:
        """Branch with the settings that are tried, from the iteration on show; at the end from the first test at which they matter."""
        run, state = self.state.run, self.state
        if run is None:
            return
        place = self._goes_on_from(run)
        if place is not None:
            self.controller.branch(place, "", self.complain, **self.settings)
        elif self._in_force(run):
            said = word("Nothing differs from {}: move the slider first, or try another strategy.")
            self.complain(said.format(state.called(state.lane)))
        else:
            self.complain(word("At none of the tests of this run would these settings have made a difference."))

    def _in_force(self, run: Run) -> bool:
        """Whether what is tried is what the lane on show has."""
        return self.in_force(run) == self.settings

    def in_force(self, run: Run) -> dict[str, Any]:
        """The same fields as a run has them."""
        settings = run.recipe.settings
        return {name: settings[name] for name in DECIDES}

    def _goes_on_from(self, run: Run) -> int | None:
        """Iteration from which a branch with the settings that are tried goes on, None for none."""
        if self._in_force(run):
            return None
        return self.state.iteration if self.state.iteration < self.state.length else self.first_difference(run, self.settings)

    def first_difference(self, run: Run, settings: dict[str, Any]) -> int | None:
        """Iteration of the first test of the lane on show after which settings would hold something back otherwise, None for none."""
        for row in self.state.history:
            there = self.state.checkpoint_at(row.iteration) if row.verdict is not None and row.iteration < self.state.length else None
            if there is not None and not np.allclose(self.mask(run, there, **settings), there.mask, atol=0.01):
                return row.iteration
        return None

    def _slid(self, _change: object) -> None:
        """Somebody tries another threshold: the mask it would make grows and shrinks on the part."""
        run = self.state.run
        if run is not None and self.state.checkpoint is not None and not self._in_force(run):
            self.selector.freestyle = False
            self.state.layer = LAYER

    def _restore(self, _change: object = None) -> None:
        """Try the settings in force, whenever another run or lane comes into view."""
        run = self.state.run
        if run is not None:
            self.selector.take(run.recipe)
        if run is not None and self.state.row(0) is not None:
            stress = self._original(run).stress
            self.selector.typical_stress, self.selector.peak_stress = float(np.median(stress)), float(stress.max())
        self._redraw()

    def _redraw(self, _change: object = None) -> None:
        run, checkpoint = self.state.run, self.state.checkpoint
        self._use.disabled = self._show_layer.disabled = run is None or checkpoint is None
        for widget in (self._asked, self._more):
            show(widget, not self._use.disabled)
        if run is None or checkpoint is None:
            self.would_be = None
            self._plots.say("")
            self.note(word("Nothing to try yet: run something first."))
            return
        self.would_be = self.mask(run, checkpoint, **self.settings)
        self._plots.say(plots(checkpoint, self.would_be, self.selector.threshold))
        place = None if self.state.busy else self._goes_on_from(run)
        begins = "" if place is None else " " + word("“Use this” goes on from iteration {}.").format(place)
        self.note(summary(checkpoint.mask, self.would_be) + begins)

    def _switch(self, change: dict[str, Any]) -> None:
        self.state.layer = LAYER if change["new"] else RESTRAINT.name

    def _follow_layer(self, change: dict[str, Any]) -> None:
        with unheard(self._show_layer, self._switch):
            self._show_layer.value = change["new"] == LAYER


def _freedom(run: Run, recipe: Recipe) -> Field:
    """Factor on all movement that protected regions leave, shape [vertex_count]."""
    return bounds_for(run.part, recipe)[0].freedom


def summary(now: Field, then: Field) -> str:
    """Share of the vertices that are held back by more than half, now and then."""
    is_now, would_be = (f"{float(restrained(mask).mean()):.1%}" for mask in (now, then))
    return word("Held back by more than half: {} of the part now, {} with this.").format(is_now, would_be)


def plots(checkpoint: Checkpoint, would_be: Field, threshold: float) -> str:
    """Histograms of demand and of the mask; bars are what is, outlines what would be."""
    largest = max(1.25, 1.1 * threshold, float(np.percentile(checkpoint.demand, 99.9)))
    top = min(largest, WIDEST * max(1.0, threshold))
    label = "demand" if top == largest else f"demand, {top:g} and more in the last bar"
    demand = np.sqrt(shares(checkpoint.demand, 0.0, top, BINS))  # the root lets the few that matter be seen beside the many at 0
    above = float((checkpoint.demand >= threshold).mean())
    first = Frame(0.0, top, top=max(float(demand.max()), 1e-3), height=96, left=10)
    limit = first.mark(threshold, f"{above:.1%} at or above {threshold:.2g}")
    one = [first.axes(label, (0.0, 0.5, 1.0)), first.bars(demand), limit]
    is_now, then = (np.sqrt(shares(mask, 0.0, 1.0, BINS)) for mask in (checkpoint.mask, would_be))
    second = Frame(0.0, 1.0, top=max(float(is_now.max()), float(then.max()), 1e-3), height=96, left=10)
    axis = second.axes("movement left: bars as it is, outlines as it would be", (0.0, 0.5, 1.0))
    two = [axis, second.bars(is_now), second.bars(then, hollow=True)]
    words = f"histogram of demand: {above:.1%} of the vertices at or above the threshold {threshold:.2g}"
    return drawing(first, one, words) + drawing(second, two, "histogram of the mask now and as it would be")
