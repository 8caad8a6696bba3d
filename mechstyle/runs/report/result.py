"""The result of a run as a report carries it for programs: a small JSON that other people's files are read by, and no more."""

from __future__ import annotations

import math
import re
from pathlib import Path

import msgspec

from mechstyle.errors import BadInput
from mechstyle.records import Verdict, sentences
from mechstyle.runs.report.markup import Markup, script_json
from mechstyle.runs.report.run_protocol import LaneOfRun

MOST_BYTES = 64_000_000
"""Larger than any report."""
ELEMENT = re.compile(rb'<script type="application/json" id="result">([^<]{2,20000})</script>')
OUTCOMES = ("HOLDS", "NO WORSE", "FAILS", "UNKNOWN")


class Result(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A finished run in a line: as in `Summary`, and what was asked of the part.

    Attributes:
        fall: Height of the fall asked for [mm].
        tolerance: The most that may stay bent [mm].
        permanent_set: What stays bent in the worst test [mm]; None by the published rule, or where nothing was tested.
        worst: Name of the worst test, "" where nothing was tested.
        recipe: Digest of the recipe.
    """

    part: str
    prompt: str
    material: str
    outcome: str
    sure: bool
    fall: float
    tolerance: float
    permanent_set: float | None
    worst: str
    kept: float
    simulations: int
    vertices: int
    recipe: str


def result_element(run: LaneOfRun, verdict: Verdict) -> Markup:
    """The element that holds the result of a lane, "" for one that is not finished."""
    if not run.finished:
        return Markup("")
    summary, decides = run.summary, verdict.deciding
    result = Result(
        part=run.record.name, prompt=run.recipe.style.prompt, material=run.recipe.test.material.label,
        outcome=verdict.outcome, sure=verdict.sure, fall=run.recipe.test.height,
        tolerance=verdict.tolerance, permanent_set=None if decides is None or decides.stress is not None else decides.permanent_set,
        worst="" if decides is None else sentences.label(decides), kept=summary.kept,
        simulations=len(summary.simulations), vertices=len(run.part.surface.vertices),
        recipe=run.recipe.digest,
    )  # fmt: skip
    return Markup(f'<script type="application/json" id="result">{script_json(msgspec.to_builtins(result))}</script>\n')


def read_result(file: str | Path) -> Result:
    """The result in a report that somebody handed in; nothing else of the file is looked at.

    BadInput if it is no report, one of an unfinished run or of an older version, or holds what no run comes to.
    """
    path = Path(file)
    if not path.is_file():
        raise BadInput(f"{path} is no file: give the .html files that `mechstyle report` wrote")
    if path.stat().st_size > MOST_BYTES:
        raise BadInput(f"{path} has more than {MOST_BYTES // 1_000_000} MB, which no report has: ask for it again")
    found = ELEMENT.findall(path.read_bytes())
    if len(found) != 1:
        raise BadInput(f"{path} is no report of a finished run: let the run end, then write it again with `mechstyle report`")
    try:
        result = msgspec.json.decode(found[0], type=Result)
    except (msgspec.MsgspecError, RecursionError, UnicodeDecodeError) as error:
        raise BadInput(f"{path} holds a damaged result: write the report again with `mechstyle report`") from error
    lengths = [len(result.part), len(result.prompt), len(result.material), len(result.recipe), len(result.worst)]
    numbers = [result.fall, result.kept, result.tolerance, result.permanent_set or 0.0]
    possible = result.outcome in OUTCOMES and max(lengths) <= 500
    possible = possible and all(math.isfinite(one) and one >= 0.0 for one in numbers) and result.kept <= 1.5
    if not (possible and result.fall > 0.0 and result.simulations >= 1 and result.vertices >= 4):
        raise BadInput(f"{path} holds a result that no run comes to: write the report again with `mechstyle report`")
    return result
