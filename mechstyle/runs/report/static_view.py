"""Static view of a run, a picture and a table, for notebooks on GitHub or nbviewer."""

from __future__ import annotations

import base64
from collections.abc import Sequence

from mechstyle.loop.history import Step, rows, standing, steps
from mechstyle.pictures.panels import Picture, picture
from mechstyle.records import sentences
from mechstyle.runs.report.markup import Markup, fill, joined, table
from mechstyle.runs.report.run_protocol import LaneOfRun


def mimebundle(run: LaneOfRun) -> dict[str, str]:
    """The forms a notebook chooses from; text only before the first checkpoint."""
    history = rows(run.store, run.lane)
    if not history:
        return {"text/plain": repr(run)}
    tests = steps(run.store, history)
    words = standing(history)[1].words
    return {"text/plain": as_text(run, tests, words), "text/html": as_html(run, tests, words)}


def as_text(run: LaneOfRun, tests: Sequence[Step], words: str) -> str:
    """The run, its verdict in words and its simulations, a line each."""
    lines = [f"{step.iteration:>5}  {_outcome(step):<19}  {_stress(step)}  {step.reason}" for step in tests]
    return "\n".join([repr(run), words, *lines])


def as_html(run: LaneOfRun, tests: Sequence[Step], words: str) -> str:
    """The same as a table under a picture; no style sheet and no script, which such places strip."""
    lines = [(step.iteration, step.reason, _outcome(step), _stress(step), f"{step.share:.0%}") for step in tests]
    return fill(
        "<p><strong>{name}</strong> as “{prompt}”</p>{picture}<p>{words}</p>{rows}",
        name=run.record.name, prompt=run.recipe.style.prompt, picture=still(run), words=words,
        rows=table(("iteration", "why it was simulated", "outcome", "stress", "held back"), lines, "Simulations"),
    )  # fmt: skip


def still(run: LaneOfRun) -> Markup:
    """The plain part, then styled, stressed and restrained, as images that carry their own bytes."""
    from mechstyle.pictures.figure import Panel  # noqa: PLC0415 — matplotlib is loaded when a picture is wanted

    return joined(
        [
            _image(picture([Panel(run.part.surface, "plain part")]), "The plain part"),
            _image(run.show(), f"The part as {run.recipe.style.prompt}, its stress and its restraint"),
        ]
    )


def _image(shown: Picture, words: str) -> Markup:
    data = Markup(base64.b64encode(shown.png).decode("ascii"))
    return fill('<img src="data:image/png;base64,{data}" alt="{words}">', data=data, words=words)


def _outcome(step: Step) -> str:
    return sentences.marked(step.outcome, sure=step.verdict.sure)


def _stress(step: Step) -> str:
    """The test that decides, its stress and its limit; a dash without an answer."""
    decides = step.verdict.deciding
    return "–" if decides is None else sentences.figures(decides)
