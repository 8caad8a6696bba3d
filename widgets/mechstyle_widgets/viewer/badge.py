"""Badge above the view: what the part survives, how much of the style is left, and where it is hardest pressed."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from html import escape

import ipywidgets
import numpy as np

from mechstyle.errors import MechStyleError
from mechstyle.loop.history import Row
from mechstyle.records import Checkpoint, Verdict, sentences
from mechstyle_widgets.jupyter.language import said
from mechstyle_widgets.jupyter.looks import lean, show
from mechstyle_widgets.state.outcomes import DOUBT, LOOKS, UNTESTED, Look
from mechstyle_widgets.state.studio_state import StudioState

SHEET = """<style>
.mechstyle-stage { position: relative; overflow: hidden; margin-top: 4px; border-radius: 4px;
  border: 1px solid var(--jp-border-color2, #ddd); }
.mechstyle-badge { width: auto; min-height: 44px; padding: 4px 10px; box-sizing: border-box; gap: 2px 16px; overflow: visible;
  display: flex !important; flex-flow: row wrap; align-items: center; justify-content: space-between;
  background: var(--jp-layout-color0, #fff); border-bottom: 1px solid var(--jp-border-color2, #ddd);
  color: var(--jp-ui-font-color1, #222); }
.mechstyle-titles { display: flex; gap: 4px; padding: 2px 0; font-size: 12px; line-height: 18px; background: var(--jp-layout-color0, #fff);
  border-bottom: 1px solid var(--jp-border-color2, #ddd); }
.mechstyle-titles .mechstyle-outcome { padding: 0 6px; border-radius: 3px; font-weight: 600; }
.mechstyle-badge[style*="none"] { display: none !important; }
.mechstyle-badge .widget-html, .mechstyle-badge .widget-html-content { height: auto; margin: 0; line-height: 1.45; font-size: 13px;
  white-space: normal; }
.mechstyle-badge .mechstyle-outcome { display: inline-block; padding: 1px 8px; border-radius: 3px; font-weight: 600; }
.mechstyle-unsure { font-weight: 600; margin-left: 6px; }
.mechstyle-badge small { font-size: 12px; }
.mechstyle-badge > .widget-html:has(.mechstyle-insight) { flex: 1 1 0; min-width: 0; }
.mechstyle-titles { font-weight: 600; }
.mechstyle-titles small { font-weight: normal; }
.mechstyle-badge .mechstyle-insight { font-size: 18px; line-height: 24px; font-weight: 600; padding: 4px 0; }
.mechstyle-badge .widget-button { width: auto; height: 24px; line-height: 22px; margin: 0; padding: 0 8px;
  font-size: 12px; }
.mechstyle-viewer.widget-vbox { flex-flow: row wrap; align-content: flex-start; }
.mechstyle-viewer > * { flex: 1 1 100%; min-width: 0; }
.mechstyle-viewer > .mechstyle-toolbar { flex: 0 1 auto; order: -2; }
.mechstyle-viewer > .mechstyle-player-start { flex: 0 0 auto; order: -1; width: auto; }
.mechstyle-viewer .mechstyle-toolbar :is(.widget-toggle-button, .widget-button) { padding: 0 6px; margin: 2px 1px; }
.mechstyle-toolbar :is(.widget-toggle-button, .widget-button) .fa { margin-right: 0; }
.mechstyle-toolbar .mechstyle-worded .fa { margin-right: 4px; }
.mechstyle-toolbar select { field-sizing: content; }
.mechstyle-section-plane { display: flex; flex-flow: row wrap; align-items: center; gap: 0 8px; }
.mechstyle-section-plane > .widget-toggle-button { width: auto; padding: 0 10px; flex: 0 0 auto; overflow: visible; }
.mechstyle-section-plane > .widget-toggle-buttons { width: auto; flex: 0 0 auto; }
.mechstyle-section-plane .widget-toggle-buttons > div { flex-wrap: nowrap; }
.mechstyle-section-plane > .widget-label { width: auto; min-width: 0; }
.mechstyle-places { margin: 4px 8px; }
.mechstyle-places .widget-html, .mechstyle-places .widget-html-content { height: auto; margin: 0; line-height: 28px; font-size: 13px; }
.mechstyle-places .widget-gridbox { align-items: center; gap: 0 8px; font-variant-numeric: tabular-nums; }
.mechstyle-places .widget-gridbox .widget-html-content { text-align: right; width: 100%; white-space: nowrap; }
.mechstyle-places .mechstyle-place-head .widget-html-content { line-height: 1.3; font-size: 12px; white-space: normal; }
.mechstyle-places .widget-gridbox > * { min-width: 0; width: auto; }
.mechstyle-places .widget-button { height: 26px; line-height: 24px; margin: 1px 0 1px 8px; padding: 0 6px; }
.mechstyle-places a { font-size: 13px; margin-left: 12px; text-decoration: underline; }
.mechstyle-places .mechstyle-pin { width: 26px; margin: 1px 0; padding: 0; border-radius: 13px; background: #171717; color: #fff;
  font-weight: 700; border: 1px solid #fff; }
.mechstyle-seen { position: relative; overflow: hidden; }
.mechstyle-over { position: absolute; left: 8px; bottom: 8px; width: auto; max-width: calc(100% - 120px); gap: 4px; align-items: flex-start;
  pointer-events: none; overflow: visible; }
.mechstyle-scale { position: absolute; right: 8px; bottom: 8px; width: auto; pointer-events: none; }
:is(.mechstyle-over, .mechstyle-scale) :is(.widget-html, .widget-html-content), .mechstyle-scale.widget-html { height: auto; margin: 0; }
:is(.mechstyle-over .widget-html, .mechstyle-scale) .widget-html-content > div { margin: 0 !important; padding: 2px 6px; border-radius: 4px;
  background: color-mix(in srgb, var(--jp-layout-color0, #fff) 82%, transparent); }
.mechstyle-said { width: auto; max-width: 100%; padding: 4px 8px;
  border-radius: 4px; pointer-events: none; background: var(--jp-layout-color0, #fff); border: 1px solid var(--jp-border-color2, #ddd); }
.mechstyle-said.widget-html, .mechstyle-said .widget-html-content { height: auto; margin: 0; line-height: 1.45; font-size: 13px;
  color: var(--jp-ui-font-color1, #222); }
.mechstyle-said:not(:has(.widget-html-content > *)) { display: none; }
.mechstyle-stage .widget-hbox > * { position: relative; }
.mechstyle-stage .widget-hbox > :has(canvas:focus-visible)::after { content: "+"; position: absolute; inset: 0; display: grid;
  place-items: center; pointer-events: none; font: 22px/1 monospace; color: #000; text-shadow: 0 0 2px #fff, 0 0 2px #fff; }
</style>"""


class Badge(ipywidgets.VBox):  # type: ignore[misc]  # ipywidgets has no types
    """Verdict of the iteration on show; of a preview, that it was not tested."""

    def __init__(self) -> None:
        """Say nothing yet."""
        self._words = lean(ipywidgets.HTML, SHEET)
        tooltip = "Look at the place where most is asked of it"
        self._worst = lean(ipywidgets.Button, description="worst place", icon="crosshairs", tooltip=tooltip)
        self._fly: Callable[[], None] = lambda: None
        self._worst.on_click(lambda _: self._fly())
        super().__init__([self._words, self._worst])
        self.add_class("mechstyle-badge")
        self.say("")

    def say(self, html: str, fly: Callable[[], None] | None = None) -> None:
        """Show a few words, and a button that flies somewhere if there is anywhere to fly to; nothing for ""."""
        self._words.value = SHEET + html
        self._fly = fly or (lambda: None)
        show(self._worst, fly is not None)
        show(self, html)


def untested(name: str, more: str) -> str:
    """HTML for what was not tested."""
    return f"<div>{escape(said(name))} {_sign(UNTESTED, sentences.NOT_TESTED)}</div><small>{escape(said(more))}</small>"


def of_state(state: StudioState) -> tuple[str, Verdict | None]:
    """HTML for the iteration a state shows, and its verdict: its own, or that of the last test before it."""
    rows = [row for row in state.history if row.iteration <= state.iteration and row.verdict is not None]
    if not rows or state.run is None:
        return "", None
    verdict = rows[-1].verdict
    assert verdict is not None
    whose = said(f"{'This' if state.busy else 'Last'} run: {state.title}")
    head = f"<small><b>{escape(whose)}</b></small>" if state.another else ""
    kept, little = _kept(state)
    return head + judged(verdict, _when(state, rows[-1]), kept, aged=rows[-1].iteration < state.iteration) + little, verdict


def judged(verdict: Verdict, when: str = "", kept: str = "", *, aged: bool = False) -> str:
    """HTML for a verdict: its outcome, the figures of the test with the least reserve, and how it was found where the mouse rests.

    Args:
        verdict: The verdict.
        when: When it was tested, "" for on show.
        kept: How much of the style is left, "" if that is not known.
        aged: Whether it is of another iteration, so that its colour says nothing.
    """
    more = " · ".join(filter(None, (sentences.least(verdict), kept, when)))
    sign = _outcome(verdict, verdict.short, aged=aged)
    return f'<div title="{escape(said(sentences.in_full(verdict)))}">{sign}</div><small>{escape(said(more))}</small>'


def insight(words: str) -> str:
    """HTML for the sentence that stands over several panes."""
    return f'<div class="mechstyle-insight" role="status">{escape(said(words))}</div>'


def outcome(row: Row | None) -> str:
    """HTML for the outcome of an iteration; that it was not tested if it was not."""
    if row is None or row.verdict is None:
        return f"<small>{_sign(UNTESTED, sentences.NOT_TESTED)}</small>"
    figures, whole = escape(said(sentences.least(row.verdict))), escape(said(sentences.in_full(row.verdict)))
    return f'<small title="{whole}">{_outcome(row.verdict, row.verdict.outcome)}<br>{figures}</small>'


def worst_vertex(checkpoint: Checkpoint) -> int:
    """Vertex of the largest stress in the test with the least reserve: that which is ringed where stress is on show."""
    return int(np.nanargmax(checkpoint.stress))


def _outcome(verdict: Verdict, words: str, *, aged: bool = False) -> str:
    """The sign of a verdict, with an amber line around it and a word beside it where it is not sure."""
    look = LOOKS[verdict.outcome]
    shown = replace(UNTESTED, mark=look.mark) if aged else look
    if not verdict.doubts:
        return _sign(shown, words)
    sign = _sign(shown, words, "" if aged else f";outline:3px solid {DOUBT}")
    return f'{sign} <span class="mechstyle-unsure">{said(sentences.NOT_SURE)}</span>'


def _sign(look: Look, word: str, more: str = "") -> str:
    style = f"background:{look.fill};color:{look.ink}{more}"
    return f'<span class="mechstyle-outcome" style="{style}"><span aria-hidden="true">{look.mark}</span> {escape(said(word))}</span>'


def _when(state: StudioState, row: Row) -> str:
    """When it was tested, where that was not at the end."""
    return sentences.tested_at(row.iteration) if state.run is not None and row.iteration < state.length else ""


def _kept(state: StudioState) -> tuple[str, str]:
    """How much of the style is left, which is known at the end, and HTML of what to try where that is little."""
    run = state.run
    with suppress(MechStyleError):  # there is no summary before the end
        if run is not None and state.iteration == state.iterations_done:
            little = sentences.little_left(run.summary.kept, run.recipe.style.side)
            warned = f'<div class="mechstyle-warning" role="status">{escape(said(little))}</div>' if little in run.summary.notes else ""
            return f"{run.summary.kept:.0%} of the relief kept", warned
    return "", ""
