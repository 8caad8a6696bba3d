"""Shared by all commands: errors in one sentence, JSON on stdout and nothing else, progress on stderr."""

from __future__ import annotations

import functools
import json
import sys
import threading
import time
import unicodedata
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn, ParamSpec, TypeVar

import msgspec
from rich import markup
from rich.console import Console, ConsoleOptions, RenderResult
from rich.measure import Measurement
from rich.progress import BarColumn, MofNCompleteColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.table import Table
from rich.text import Text

from mechstyle.errors import MechStyleError
from mechstyle.records import Verdict, sentences

if TYPE_CHECKING:
    from mechstyle.loop.engine import Event

P = ParamSpec("P")
R = TypeVar("R")

EXIT_BAD_INPUT = 2
EXIT_INTERRUPTED = 130

out = Console(highlight=False, soft_wrap=True)
err = Console(stderr=True, highlight=False, soft_wrap=True)

UNBOUNDED = 10_000
"""More characters than any line of a table has."""
COLOURS = {"HOLDS": "green", "NO WORSE": "cyan", "FAILS": "red", "UNKNOWN": "yellow"}
"""Of each outcome; a doubt has that of UNKNOWN."""


def print_json(value: object) -> None:
    """Print one JSON object on stdout; signs that its encoding lacks, as cp1252 does ρ, are escaped, so that it stays the same JSON."""
    text = msgspec.json.format(msgspec.json.encode(value, enc_hook=str), indent=2).decode() + "\n"
    try:
        text.encode(sys.stdout.encoding or "utf-8")
    except UnicodeEncodeError:
        text = json.dumps(json.loads(text), indent=2) + "\n"
    sys.stdout.write(text)


def command(function: Callable[P, R]) -> Callable[P, R]:
    """Turn the errors a user can cause into one sentence and a non-zero exit; with --json the sentence is JSON as well."""

    @functools.wraps(function)
    def wrapped(*args: P.args, **kwargs: P.kwargs) -> R:
        as_json = bool(kwargs.get("as_json"))
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # third-party warnings say nothing a user of the command line can act on
                return function(*args, **kwargs)
        except MechStyleError as error:
            fail(str(error), EXIT_BAD_INPUT, as_json=as_json)
        except OSError as error:
            what = f"{error.filename or 'a file'}: {error.strerror or error}"
            fail(f"{what}; check the path, the rights and the free space", EXIT_BAD_INPUT, as_json=as_json)
        except KeyboardInterrupt as interrupt:
            fail(str(interrupt) or "interrupted; what was saved is kept", EXIT_INTERRUPTED, as_json=as_json)

    return wrapped


def fail(sentence: str, code: int, *, as_json: bool) -> NoReturn:
    """Say what is wrong and leave."""
    if as_json:
        print_json({"error": sentence})
    else:
        err.print(f"[bold red]error:[/] {escape(sentence)}")
    raise SystemExit(code)


def escape(text: str) -> str:
    """Text that rich prints as it is; signs that would command a terminal, as names in somebody else's file can hold them, become �."""
    return markup.escape("".join("�" if unicodedata.category(sign) == "Cc" and sign not in "\n\t" else sign for sign in text))


def verdict_text(outcome: str, *, sure: bool = True) -> str:
    """The outcome in its colour, and in amber that it is not sure."""
    doubt = sentences.marked(outcome, sure=sure).removeprefix(outcome)
    return f"[bold {COLOURS[outcome]}]{outcome}[/]" + (f"[{COLOURS['UNKNOWN']}]{doubt}[/]" if doubt else "")


def headline(verdict: Verdict) -> str:
    """The head of a verdict with its outcome in its colour."""
    return f"{verdict_text(verdict.outcome)}{escape(verdict.head.removeprefix(verdict.outcome))}"


def in_colour(cell: str) -> str:
    """The cell of a table, with the outcome that it ends with in its colour."""
    outcome = next((known for known in COLOURS if cell.endswith(known)), "")
    return f"{escape(cell.removesuffix(outcome))}{verdict_text(outcome)}" if outcome else escape(cell)


def report_verdict(verdict: Verdict, *, details: bool = False) -> None:
    """Print a verdict: its head, the table of tests, and what is in doubt; with details every landing has a row."""
    out.print(headline(verdict))
    if verdict.rows:
        headings, rows = sentences.tabulated(verdict, briefly=not details)
        made = table(*headings)
        shown = verdict.rows if details else [row for row, _ in sentences.worst_of_each(verdict)]
        for row, cells in zip(shown, rows, strict=True):
            made.add_row(*map(escape, cells[:-1]), verdict_text(row.outcome, sure=row.sure))
        out.print(made)
    if verdict.doubt:
        out.print(f"[{COLOURS['UNKNOWN']}]{escape(verdict.doubt)}[/]")


def say_once(sentences: Iterable[str], said: set[str], console: Console = err, form: str = "[dim]{}[/]") -> None:
    """Print the sentences that are not among those that were said, and add them."""
    if not console.quiet:
        for sentence in dict.fromkeys(sentences):
            if sentence not in said:
                console.print(form.format(escape(sentence)))
                said.add(sentence)


def warn_once(sentences: Iterable[str], said: set[str], console: Console = err) -> None:
    """Print sentences as warnings, as `say_once` does."""
    say_once(sentences, said, console, "[yellow]warning:[/] {}")


class FittingTable(Table):
    """A table that is a list, with a line for each cell, on a terminal too narrow for its longest words."""

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """The table as rich draws it, where it is too wide with a line for each word of long headings, or the list."""
        if Measurement.get(console, options.update(width=UNBOUNDED), self).maximum > options.max_width:
            for column in self.columns:
                if all(Text.from_markup(str(cell)).cell_len < len(str(column.header)) for cell in column.cells):
                    column.header = "\n".join(str(column.header).split())
        if Measurement.get(console, options.update(width=UNBOUNDED), self).minimum <= options.max_width:
            yield from super().__rich_console__(console, options)
            return
        if self.title:
            yield self.title
        headings = [str(column.header).replace("\n", " ") for column in self.columns]
        for row in zip(*(column.cells for column in self.columns), strict=True):
            listed = Table.grid(padding=(0, 2, 0, 0))
            for heading, cell in zip(headings, row, strict=True):
                listed.add_row(f"[bold]{heading}[/]", cell)
            yield listed
            yield ""


def table(*columns: str, title: str = "", width: int | None = None) -> Table:
    """A table in the house style; where it does not fit, headings take a line for each word, many columns stand closer: no word is broken.

    Args:
        columns: Headings, which are plain text: [mm] is a unit.
        title: What stands above it.
        width: Width of the terminal [characters], by default that of standard output.
    """
    many = len(columns) > 8
    gap = 1 if many and (out.width if width is None else width) < 120 else 2
    made = FittingTable(title=title or None, title_justify="left", header_style="bold", box=None, pad_edge=False, padding=(0, gap, 0, 0))
    for column in columns:
        made.add_column(escape(column), overflow="fold")
    return made


LINE_EVERY = 10.0
"""Time between two looks at what is being done, where no bar can be shown [s]."""
LONG = 6
"""Looks after which a stage that goes on is named again."""


class ProgressDisplay:
    """Shows what a run is doing: a bar over the iterations, the stage in hand, time left, a line per simulation."""

    def __init__(self, progress: Progress, iterations: int, said: set[str]) -> None:
        """Start the bar; sentences that are said once are kept in `said`."""
        self._progress = progress
        self._task = progress.add_task("preparing", total=iterations)
        self._what, self._done = "preparing", 0.0
        self._begun = time.monotonic()
        self._named, self._looks = "", 0
        self.said = said

    def shown(self, path: Path) -> None:
        """Where a picture of the finished style is, which nothing has tested yet."""
        self._progress.console.print(f"[dim]the style, not tested yet: {escape(str(path))}[/]")

    def stage(self, what: str) -> None:
        """Say what is being done."""
        self._what, self._done = what, 0.0
        self._progress.update(self._task, description=what)

    def step(self, what: str) -> None:
        """Say what is being done, the one before being done."""
        self.stage(what)
        self._progress.advance(self._task)

    def fraction(self, done: float) -> None:
        """Say how far the stage in hand is, of whose drops each begins anew: what was said is never taken back."""
        self._done = max(self._done, done)
        self._progress.update(self._task, description=f"{self._what} {self._done:4.0%}")

    def line(self) -> None:
        """Print what is being done, for who sees no bar: once for each stage, and again where it takes long."""
        self._looks = self._looks + 1 if self._named == self._what else 0
        if self._looks % LONG:
            return
        self._named = self._what
        task = self._progress.tasks[self._task]
        done = f", {task.completed:.0f} of {task.total:.0f}" if task.total and task.total > 1 else ""
        self._progress.console.print(f"[dim]{time.monotonic() - self._begun:4.0f} s: {escape(task.description)}{done}[/]")

    def warn(self, sentences: Iterable[str]) -> None:
        """Say what is to be known before the end, each sentence once, however often a part is prepared."""
        warn_once(sentences, self.said, self._progress.console)

    def say(self, sentences: Iterable[str]) -> None:
        """Say sentences that have not been said yet."""
        say_once(sentences, self.said, self._progress.console)

    def event(self, event: Event) -> None:
        """Show an event."""
        from mechstyle.loop.engine import Corrected, Finished, Simulated, SimulationStarted, Stylized  # noqa: PLC0415 — with scipy

        if isinstance(event, Stylized):
            self._progress.update(self._task, completed=event.iteration, description="stylizing")
        elif isinstance(event, SimulationStarted):
            self.stage(f"drop test at {event.iteration}")
            self._progress.update(self._task, completed=event.iteration)
        elif isinstance(event, Simulated):
            row = event.verdict.deciding
            outcome = verdict_text(event.verdict.outcome, sure=event.verdict.sure)
            figures = "" if row is None else f"{escape(sentences.figures(row))}  "
            self._progress.console.print(f"  {event.iteration:>4}  {outcome}  {figures}[dim]{escape(event.reason)}[/]")
        elif isinstance(event, Corrected):
            self._progress.console.print(f"        [dim]correction: {escape(event.step)}[/]")
        elif isinstance(event, Finished):
            self.stage("done")


def lines(say: Callable[[], None], over: Callable[[float], bool]) -> None:
    """Say something every LINE_EVERY seconds until it is over, which is asked with the seconds to wait for that."""
    while not over(LINE_EVERY):
        say()


@contextmanager
def progress_shown(iterations: int, *, quiet: bool, said: set[str] | None = None) -> Iterator[ProgressDisplay]:
    """Progress on stderr while the block runs, none if `quiet`; what it says of the part and the style is added to `said`."""
    shown, times = (SpinnerColumn(), BarColumn(30), MofNCompleteColumn()), (TimeElapsedColumn(), TextColumn("left"), TimeRemainingColumn())
    bar = Progress(*shown, TextColumn("{task.description}"), *times, console=err, disable=quiet, transient=True)
    with bar as progress:
        if quiet:
            progress.console.quiet = True
        teller, over = ProgressDisplay(progress, iterations, set() if said is None else said), threading.Event()
        if not (quiet or progress.console.is_terminal):  # a log file, a notebook's cell or a job shows no bar, and a mesh takes minutes
            threading.Thread(target=lines, args=(teller.line, over.wait), name="mechstyle-lines", daemon=True).start()
        try:
            yield teller
        finally:
            over.set()
            progress.console.quiet = False
