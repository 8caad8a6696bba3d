"""The runs that were made here, newest first: a picture, what was asked, what came of it; open, compare, delete."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from html import escape
from pathlib import Path
from typing import Any, NamedTuple

import ipywidgets

from mechstyle.errors import MechStyleError
from mechstyle.records import Verdict, sentences
from mechstyle.runs.run import Run
from mechstyle_widgets.jupyter.language import said, word
from mechstyle_widgets.jupyter.looks import lean, sharing
from mechstyle_widgets.jupyter.throttle import LatestOnly
from mechstyle_widgets.panels.branches import said_of
from mechstyle_widgets.settings.section import WIDE, Section, Words, table
from mechstyle_widgets.settings.thumbnails import SIZE, png
from mechstyle_widgets.state.studio_state import StudioState, titled
from mechstyle_widgets.state.troubles import sentence

FOLDER = Path("mechstyle-runs")
"""Where runs are kept that were given no folder of their own."""
MOST = 12
"""Runs that are shown."""


class Found(NamedTuple):
    """A run as the list shows it; outcome and picture (PNG) are empty before there is one."""

    place: Path
    title: str
    outcome: str
    picture: bytes


class MyRuns(Section):
    """The list; it is read when it is opened, beside the event loop."""

    def __init__(self, state: StudioState, take: Callable[[Run], None]) -> None:
        """List the runs of this notebook; `take` shows one."""
        self._state, self._take = state, take
        self._rows, self._beside = lean(ipywidgets.VBox, []), lean(Words, layout=WIDE)
        self._newest: LatestOnly[list[Path], list[Found]] = LatestOnly(
            lambda places: [found for place in places if (found := read(place)) is not None], self._show, state.alert
        )
        self._sure: Path | None = None
        super().__init__([self._rows, self._beside])

    def close(self) -> None:
        """Close it; what is being read is not shown."""
        self._newest.cancel()
        super().close()

    def look(self) -> None:
        """Read the list anew."""
        self.note(word("Looking for runs …"))
        self._newest.ask(self.places())

    def places(self) -> list[Path]:
        """Folders of runs here, the newest first: those in `mechstyle-runs`, those beside the notebook, and the one on show."""
        here = [place for root in (FOLDER, Path()) if root.is_dir() for place in root.iterdir() if (place / "part.json").is_file()]
        shown = [] if self._state.run is None or not self._state.run.store.place.is_dir() else [self._state.run.store.place]
        known = {place.absolute(): place for place in (*here, *shown)}
        return sorted(known.values(), key=lambda place: (place / "part.json").stat().st_mtime, reverse=True)[:MOST]

    def _show(self, _places: Sequence[Path], found: Sequence[Found]) -> None:
        old = self._rows.children
        with sharing():
            self._rows.children = [self._row(one) for one in found]
        for row in old:
            row.close()
        self.note("" if found else word("No runs here yet: what you run is kept in mechstyle-runs."))

    def _row(self, one: Found) -> ipywidgets.HBox:
        picture = lean(ipywidgets.Image, value=one.picture, format="png", width=72, layout={"flex": "0 0 72px"})
        outcome = said(one.outcome or "not tested yet")
        words = f"<b>{escape(one.title)}</b><br>{escape(outcome)}<br><small>{escape(str(one.place))}</small>"
        acts = {
            "open": (self.show_run, "Show this run"), "compare": (self.compare, "What stays bent of it, and of the run on show"),
            "delete": (self.delete, "Delete its folder: press twice"),
        }  # fmt: skip
        buttons = []
        for name, (act, tooltip) in acts.items():
            button = lean(ipywidgets.Button, description=name, tooltip=tooltip, layout={"width": "auto"})
            button.on_click(lambda button, act=act: self._tried(partial(act, one.place, button)))
            buttons.append(button)
        row = lean(ipywidgets.HBox, buttons, layout={"flex_flow": "row wrap"})
        text = lean(ipywidgets.HTML, words)
        text.add_class("mechstyle-run-row")
        return lean(ipywidgets.HBox, [picture, lean(ipywidgets.VBox, [text, row], layout={"flex": "1 1 auto"})], layout=WIDE)

    def _tried(self, act: Callable[[], None]) -> None:
        self.complain("")
        try:
            act()
        except Exception as error:  # noqa: BLE001 — whatever it is, it is said
            self.complain(sentence(error))

    def show_run(self, place: Path, _button: Any = None) -> None:
        """Show a run."""
        if self._state.busy:
            self.complain(word("A run is going on: stop it before you open another."))
            return
        self._take(Run.open(place))

    def compare(self, place: Path, _button: Any = None) -> None:
        """Put what stays bent of a run beside what stays bent of the run on show."""
        run = self._state.run
        if run is None:
            self.complain(word("Nothing is on show to compare with: open a run first."))
            return
        other = Run.open(place)
        verdicts = [last_verdict(run), last_verdict(other)]
        if None in verdicts:
            self.complain(word("One of the two was not tested yet."))
            return
        judged = [verdict for verdict in verdicts if verdict is not None]
        heads = ("test", "plain", self._state.title, titled(other.record.name, other.recipe.style.prompt), "allowed")
        outcomes = ("outcome", "", *(said_of(verdict) for verdict in judged), "")
        self._beside.say(table(heads, [outcomes, *sentences.paired(judged)]))

    def delete(self, place: Path, button: Any = None) -> None:
        """Delete a run's folder at the second press."""
        if self._state.run is not None and place.absolute() == self._state.run.store.place:
            self.complain(word("This run is on show: open another one, then delete it."))
        elif self._sure != place:
            self._sure = place
            if button is not None:
                button.description = word("delete for good?")
        else:
            self._sure = None
            if (place / "part.json").is_file():  # a folder of something else is left alone
                shutil.rmtree(place)
            self.look()


def read(place: Path) -> Found | None:
    """What the list shows of a run's folder, in any thread; None for one that cannot be read."""
    from mechstyle.pictures.scene import Camera, render  # noqa: PLC0415 — what renders is loaded when the list is opened

    with suppress(MechStyleError, OSError):
        run = Run.open(place)
        history = run.history
        picture = b""
        if history:
            mesh = run.surface(history[-1].iteration)
            camera = Camera.named("three_quarter", mesh.vertices, aspect=SIZE[0] / SIZE[1])
            picture = png(render(mesh, camera=camera, width=SIZE[0], height=SIZE[1]))
        verdict = last_verdict(run)
        return Found(place, titled(run.record.name, run.recipe.style.prompt), "" if verdict is None else said_of(verdict), picture)
    return None


def last_verdict(run: Run) -> Verdict | None:
    """Newest verdict on what is styled, None before there is one."""
    return next((row.verdict for row in reversed(run.history) if row.verdict is not None and row.iteration > 0), None)
