"""What is on show: a branch, an iteration, and what is known of that very surface. All that speaks of it prints this."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache

from mechstyle.errors import MechStyleError
from mechstyle.loop.store import Lane, Store
from mechstyle.records import Verdict, sentences
from mechstyle.runs.run import Run
from mechstyle.runs.summary import Summary
from mechstyle_widgets.jupyter.language import said, word
from mechstyle_widgets.state.outcomes import LOOKS, UNTESTED, Look
from mechstyle_widgets.state.studio_state import StudioState, titled


@dataclass(frozen=True)
class OnShow:
    """The surface of a branch at an iteration; a style that was not run has no branch.

    Attributes:
        title: Its part and its style.
        branch: What people call the branch, "" for a style that was not run.
        iteration: Iteration of it, `end` the last that it is to have.
        verdict: Verdict on this very surface, None if it was not tested.
        tested_at: Iteration of the last test before, None if there was none.
        kept: Share of the relief that is left, None before the end.
    """

    title: str
    branch: str = ""
    iteration: int = 0
    end: int = 0
    verdict: Verdict | None = None
    tested_at: int | None = None
    kept: float | None = None

    @property
    def look(self) -> Look:
        """Colours and mark of its outcome."""
        return UNTESTED if self.verdict is None else LOOKS[self.verdict.outcome]

    @property
    def outcome(self) -> str:
        """Its outcome in a few words, or that it was not tested."""
        return sentences.NOT_TESTED if self.verdict is None else self.verdict.short

    @property
    def fails(self) -> bool:
        """Whether its own test found that it fails."""
        return self.verdict is not None and self.verdict.outcome == "FAILS"

    @property
    def words(self) -> str:
        """Its outcome, whether that is sure, or since when it was not tested."""
        if self.verdict is None:
            return sentences.untested(self.tested_at)
        return sentences.marked(self.outcome, sure=self.verdict.sure)

    @property
    def pane(self) -> str:
        """What it is called beside another branch: its iteration is named where that is not the end."""
        return self.branch if self.iteration == self.end else word("{}, iteration {}").format(self.branch, self.iteration)

    @property
    def caption(self) -> str:
        """What stands under a picture of it, in the language spoken."""
        return f"{self.title}: {said(self.words)}"


def on_show(state: StudioState, lane: str = "", iteration: int | None = None) -> OnShow | None:
    """What a state shows, or an iteration of another lane; None while there is no such iteration."""
    lane = lane or state.lane
    row = state.row(iteration, lane)
    if row is None or state.run is None:
        return None
    run, end = Run(state.run.store, lane, state.run.device), state.end_of(lane)
    tested = [one.iteration for one in state.histories[lane] if one.iteration <= row.iteration and one.verdict is not None]
    style = run.recipe.style.prompt if row.iteration else "plain"
    title, last = titled(run.record.name, style), tested[-1] if tested else None
    return OnShow(title, state.called(lane), row.iteration, end, row.verdict, last, share_kept(run) if row.iteration == end else None)


def share_kept(run: Run) -> float | None:
    """Share of the relief that is left at the end of a lane, which its summary knows; None before the end."""
    with suppress(MechStyleError):
        return summary_of(run).kept
    return None


def summary_of(run: Run) -> Summary:
    """The summary of a lane, read once as long as neither it nor the lane is written anew; BadInput before the end."""
    store, lane = run.store, run.lane
    with suppress(OSError):  # there is none before, which the run itself says
        written = (store.root / "summaries" / f"{lane}.json").stat()
        return _summary(store, lane, store.lane(lane), (written.st_mtime_ns, written.st_size))
    return run.summary


@lru_cache(maxsize=64)
def _summary(store: Store, name: str, _ends: Lane, _written: tuple[int, int]) -> Summary:
    return Run(store, name).summary  # which reads every checkpoint, and is asked for forty times while a Studio is made
