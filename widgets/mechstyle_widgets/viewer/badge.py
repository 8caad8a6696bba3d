"""Badge above the view: what stays bent of the part, how much of the style is left, and where it is worst."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from html import escape

import ipywidgets
import numpy as np

from mechstyle.pictures.fields import most_bent
from mechstyle.records import Checkpoint, Simulation, Verdict, sentences
from mechstyle.records.mesh import SurfaceMesh
from mechstyle_widgets.jupyter.language import said
from mechstyle_widgets.jupyter.looks import lean, show
from mechstyle_widgets.jupyter.page_widget import static
from mechstyle_widgets.state.on_show import OnShow
from mechstyle_widgets.state.outcomes import DOUBT, UNTESTED, Look

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


def in_full(verdict: Verdict) -> str:
    """How a part is judged, the outcome, every figure of the table and the doubt, a line each."""
    headings, rows = sentences.tabulated(verdict)
    lines = [f"{row[0]}: {', '.join(f'{name} {cell}' for name, cell in zip(headings[1:], row[1:], strict=True))}" for row in rows]
    return "\n".join(filter(None, (" ".join(sentences.EXPLANATION), verdict.head, *lines, verdict.doubt)))


def of_several(panes: Sequence[OnShow], *, last: str = "", little: str = "") -> str:
    """HTML over several panes, each of which has its own outcome: what is left of the style in each; other arguments as of `of`."""
    kept = [f"{one.branch} {one.kept:.0%}" for one in panes if one.kept is not None]
    more = f"Of the relief kept: {', '.join(kept)}" if kept else ""
    return f"{_head(last)}<small>{escape(said(more))}</small>{_warned(little)}"


def of(shown: OnShow, *, last: str = "", little: str = "") -> str:
    """HTML for what is on show: its outcome, the figures of the test that decides, and how it was found where the mouse rests.

    `last` says whose it is where another run is asked for, `little` what to try where little is left of the style.
    """
    kept = "" if shown.kept is None else f"{shown.kept:.0%} of the relief kept"
    figures, whole = ("", "") if shown.verdict is None else (sentences.least(shown.verdict), in_full(shown.verdict))
    if shown.verdict is None:
        figures = f"since iteration {shown.tested_at}" if shown.tested_at else "so far only the plain part was dropped"
    more = " · ".join(filter(None, (figures, kept)))
    title = f' title="{escape(said(whole))}"' if whole else ""
    return f"{_head(last)}<div{title}>{_outcome(shown)}</div><small>{escape(said(more))}</small>{_warned(little)}"


def _head(last: str) -> str:
    return f"<small><b>{escape(said(last))}</b></small>" if last else ""


def _warned(little: str) -> str:
    return f'<div class="mechstyle-warning" role="status">{escape(said(little))}</div>' if little else ""


def insight(words: str) -> str:
    """HTML for the sentence that stands over several panes."""
    return f'<div class="mechstyle-insight" role="status">{escape(said(words))}</div>'


def of_pane(shown: OnShow) -> str:
    """HTML for the outcome of one of several panes."""
    if shown.verdict is None:
        return f"<small>{_sign(shown.look, shown.words)}</small>"
    figures, whole = escape(said(sentences.least(shown.verdict))), escape(said(in_full(shown.verdict)))
    return f'<small title="{whole}">{_outcome(shown, shown.verdict.outcome)}<br>{figures}</small>'


def worst_vertex(mesh: SurfaceMesh, checkpoint: Checkpoint, simulation: Simulation, verdict: Verdict) -> int:
    """Vertex of a displaced part at which it counts as most bent; of the largest stress in that test where nothing stays bent."""
    row = verdict.deciding
    if row is None or not row.place:
        return int(np.nanargmax(checkpoint.stress))
    return most_bent(mesh.vertices, row, simulation)


def _outcome(shown: OnShow, words: str = "") -> str:
    """The sign of an outcome, with an amber line around it and a word beside it where it is not sure."""
    words = words or shown.outcome
    if shown.verdict is None or not shown.verdict.doubts:
        return _sign(shown.look, words)
    sign = _sign(shown.look, words, f";outline:3px solid {DOUBT}")
    return f'{sign} <span class="mechstyle-unsure">{said(sentences.NOT_SURE)}</span>'


def _sign(look: Look, word: str, more: str = "") -> str:
    style = f"background:{look.fill};color:{look.ink}{more}"
    return f'<span class="mechstyle-outcome" style="{style}"><span aria-hidden="true">{look.mark}</span> {escape(said(word))}</span>'
