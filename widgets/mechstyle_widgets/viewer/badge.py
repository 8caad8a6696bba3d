"""Badge above the view: what stays bent of the part, how much of the style is left, and where it is worst."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from html import escape

import ipywidgets
import numpy as np

from mechstyle.errors import MechStyleError
from mechstyle.loop.history import Row
from mechstyle.records import Checkpoint, Verdict, sentences
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.runs.summary import little_left
from mechstyle_widgets.jupyter.language import said
from mechstyle_widgets.jupyter.looks import lean, show
from mechstyle_widgets.jupyter.page_widget import static
from mechstyle_widgets.state.outcomes import DOUBT, LOOKS, UNTESTED, Look
from mechstyle_widgets.state.studio_state import StudioState

SHEET = f"<style>\n{static('viewer', 'viewer.css')}</style>"


class Badge(ipywidgets.VBox):  # type: ignore[misc]  # ipywidgets has no types
    """Verdict of the iteration on show; of a preview, that it was not tested."""

    def __init__(self) -> None:
        """Say nothing yet."""
        self._words = lean(ipywidgets.HTML, SHEET)
        tooltip = "Look at the place that stays bent most"
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
    head, tested = f"<small><b>{escape(whose)}</b></small>" if state.another else "", rows[-1].iteration
    when = f"tested at iteration {tested}" if tested < state.length else ""  # where that was not at the end
    kept, little = _kept(state)
    return head + judged(verdict, when, kept, aged=tested < state.iteration) + little, verdict


def in_full(verdict: Verdict) -> str:
    """How a part is judged, the outcome, every figure of the table and the doubt, a line each."""
    headings, rows = sentences.tabulated(verdict)
    lines = [f"{row[0]}: {', '.join(f'{name} {cell}' for name, cell in zip(headings[1:], row[1:], strict=True))}" for row in rows]
    return "\n".join(filter(None, (" ".join(sentences.EXPLANATION), verdict.head, *lines, verdict.doubt)))


def judged(verdict: Verdict, when: str = "", kept: str = "", *, aged: bool = False) -> str:
    """HTML for a verdict: its outcome, the figures of the test that decides, and how it was found where the mouse rests.

    `aged` says that it is of another iteration, so that its colour says nothing.
    """
    more = " · ".join(filter(None, (sentences.least(verdict), kept, when)))
    sign = _outcome(verdict, verdict.short, aged=aged)
    return f'<div title="{escape(said(in_full(verdict)))}">{sign}</div><small>{escape(said(more))}</small>'


def insight(words: str) -> str:
    """HTML for the sentence that stands over several panes."""
    return f'<div class="mechstyle-insight" role="status">{escape(said(words))}</div>'


def outcome(row: Row | None) -> str:
    """HTML for the outcome of an iteration; that it was not tested if it was not."""
    if row is None or row.verdict is None:
        return f"<small>{_sign(UNTESTED, sentences.NOT_TESTED)}</small>"
    figures, whole = escape(said(sentences.least(row.verdict))), escape(said(in_full(row.verdict)))
    return f'<small title="{whole}">{_outcome(row.verdict, row.verdict.outcome)}<br>{figures}</small>'


def worst_vertex(mesh: SurfaceMesh, checkpoint: Checkpoint, verdict: Verdict) -> int:
    """Vertex of a displaced part nearest to where it stays bent; of the largest stress in that test where it does not."""
    row = verdict.deciding
    if row is None or not row.place:
        return int(np.nanargmax(checkpoint.stress))
    return int(np.linalg.norm(mesh.vertices - np.asarray(row.where), axis=1).argmin())


def _outcome(verdict: Verdict, words: str, *, aged: bool = False) -> str:
    """The sign of a verdict, with an amber line around it and a word beside it where it is not sure."""
    look = LOOKS[verdict.outcome]
    shown = UNTESTED._replace(mark=look.mark) if aged else look
    if not verdict.doubts:
        return _sign(shown, words)
    sign = _sign(shown, words, "" if aged else f";outline:3px solid {DOUBT}")
    return f'{sign} <span class="mechstyle-unsure">{said(sentences.NOT_SURE)}</span>'


def _sign(look: Look, word: str, more: str = "") -> str:
    style = f"background:{look.fill};color:{look.ink}{more}"
    return f'<span class="mechstyle-outcome" style="{style}"><span aria-hidden="true">{look.mark}</span> {escape(said(word))}</span>'


def _kept(state: StudioState) -> tuple[str, str]:
    """How much of the style is left, which is known at the end, and HTML of what to try where that is little."""
    run = state.run
    with suppress(MechStyleError):  # there is no summary before the end
        if run is not None and state.iteration == state.iterations_done:
            little = little_left(run.summary.kept, run.recipe.style.side)
            warned = f'<div class="mechstyle-warning" role="status">{escape(said(little))}</div>' if little in run.summary.notes else ""
            return f"{run.summary.kept:.0%} of the relief kept", warned
    return "", ""
