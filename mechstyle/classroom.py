"""A class on one set of parts and styles: everything slow is done before, and the reports that are handed in become one table."""

from __future__ import annotations

import csv
import io
import shlex
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from mechstyle._files import file_stem, write_whole
from mechstyle.errors import BadInput, MechStyleError
from mechstyle.fea.explicit import no_progress
from mechstyle.gallery import load
from mechstyle.records import sentences
from mechstyle.records.written import written
from mechstyle.runs.recipes import recipe_for
from mechstyle.runs.report.reproduce import options, settings_for
from mechstyle.runs.report.result import Result, read_result
from mechstyle.runs.run import Draft

VERTICES, ITERATIONS = 3000, 60
"""Of a part in class: a run then takes about a minute on two cores."""
COLUMNS = ("place", "who", "part", "style", "outcome", "stays bent", "in the test", "style kept", "tests")
MOST = 1000
"""Reports of a class at most."""
ESCAPED = str.maketrans({sign: f"\\{sign}" for sign in "\\|<>[]`*_"})
"""What would end a cell of a Markdown table, or be read as markup."""


@dataclass(frozen=True)
class Task:
    """One part, a file or gallery:NAME, and style of a class, and what a pupil types."""

    model: str
    prompt: str
    command: str


def markdown(lines: Sequence[tuple[str, ...]]) -> str:
    """A table of headings and lines."""
    ruled = [lines[0], tuple("---" for _ in lines[0]), *lines[1:]]
    return "".join(f"| {' | '.join(line)} |\n" for line in ruled)


def prepare(
    models: Sequence[str], prompts: Sequence[str], settings: dict[str, Any], *,
    vertices: int = VERTICES, folder: Path, device: str = "auto", stage: Callable[[str], None] = no_progress,
) -> list[Task]:  # fmt: skip
    """Fill the cache for every part in every style, so that a class waits for its own drops only, and write `commands.md`.

    Meshes and the drop of each plain part are kept in the cache folder; a class on other machines sets `MECHSTYLE_CACHE` to a copy of it.
    `settings` are fields of `Recipe` that all runs share.

    Raises:
        MechStyleError: If a part or a setting cannot be used; what was prepared before stays.
    """
    settings = {"iterations": ITERATIONS, **settings}
    wanted = {prompt: recipe_for(prompt, **settings) for prompt in prompts}  # refuses a style before minutes are spent
    parts = {model: load(model) for model in models}
    if not (wanted and parts):
        raise BadInput("a class needs at least one part and one style")
    tasks = []
    for model, part in parts.items():
        for prompt, recipe in wanted.items():
            label, own = f"{part.name}, {prompt}", file_stem(f"{part.name}-{prompt}")
            asked = Draft(recipe, part, vertices, part.name, folder / "prepared" / own, device)
            run = asked.ready(stage=partial(lambda label, what: stage(f"{label}: {what}"), label)).begin()
            stage(f"{label}: dropping the plain part")
            _ = run.simulator(run.recipe).baseline
            given = options({"prompt": prompt, **settings_for(recipe, partial(recipe_for, prompt))})
            words = ["mechstyle", "run", model, *dict.fromkeys(given), "--vertices", str(vertices), "--out", f"runs/{own}"]
            tasks.append(Task(model, prompt, shlex.join(words)))
    lines = ["# What to type\n", "Each run takes about a minute. Afterwards write your report and hand in the file.\n"]
    for model in dict.fromkeys(task.model for task in tasks):
        lines += [f"## {model}\n", "```sh", *(task.command for task in tasks if task.model == model), "```\n"]
    first = shlex.split(tasks[0].command)[-1]
    lines += [f"Hand in, here that of {first}:\n", "```sh", f'mechstyle report {shlex.quote(first)} --out "YOUR NAME.html"', "```\n"]
    write_whole(folder / "commands.md", "\n".join(lines).encode())
    return tasks


@dataclass(frozen=True)
class Handed:
    """The reports of a class.

    Attributes:
        ranked: Who and result of those that were asked for this fall: what passes first, most style kept first.
        others: Those of another fall.
        refused: A sentence for each file that is no report.
    """

    ranked: tuple[tuple[str, Result], ...]
    others: tuple[tuple[str, Result], ...]
    refused: tuple[str, ...]

    @property
    def lines(self) -> list[tuple[str, ...]]:
        """The table: headings, then a line for each report; what fails, or is of another fall, has no place."""
        placed = [(str(place) if _passes(one) else "–", *_cells(who, one)) for place, (who, one) in enumerate(self.ranked, 1)]
        apart = [("–", *_cells(f"{who}, of a fall of {written(one.fall)}", one)) for who, one in self.others]
        return [COLUMNS, *placed, *apart]


def collect(files: Sequence[str | Path], fall: float) -> Handed:
    """The reports that a class handed in, as one table: who keeps most style and still passes a fall [mm]?

    The name of a file, without its suffix, says who. BadInput if none of them is a report.
    """
    if len(files) > MOST:
        raise BadInput(f"{len(files)} reports are more than the {MOST} of the largest class: collect them in several tables")
    found, refused = list[tuple[str, Result]](), list[str]()
    for file in sorted(map(Path, files), key=lambda path: path.name):
        try:
            found.append((file.stem[:60], read_result(file)))
        except (MechStyleError, OSError) as error:
            refused.append(str(error))
    if not found:
        raise BadInput(f"there is no report to collect: {refused[0]}" if refused else "there is no report to collect: name some")
    ours = [one for one in found if abs(one[1].fall - fall) < 1e-6 * fall]
    ours.sort(key=lambda one: (not _passes(one[1]), -one[1].kept))
    return Handed(tuple(ours), tuple(one for one in found if one not in ours), tuple(refused))


def _passes(result: Result) -> bool:
    return result.outcome in ("HOLDS", "NO WORSE")


def _cells(who: str, result: Result) -> tuple[str, ...]:
    outcome = sentences.marked(result.outcome, sure=result.sure)
    bent = "–" if result.permanent_set is None else sentences.bend(result.permanent_set)
    return who, result.part, result.prompt, outcome, bent, result.worst, f"{result.kept:.0%}", str(result.simulations)


def as_file(handed: Handed, path: Path) -> Path:
    """Write the table as Markdown or CSV, by the suffix of the file; BadInput for any other."""
    if path.suffix.lower() == ".csv":
        text = io.StringIO()
        # no spreadsheet takes a cell for a formula that begins with a quote
        harmless = ([f"'{cell}" if cell[:1] in ("=", "+", "-", "@", "\t", "\r") else cell for cell in line] for line in handed.lines)
        csv.writer(text).writerows(harmless)
        write_whole(path, text.getvalue().encode("utf-8-sig"))  # the mark without which spreadsheets misread an umlaut
    elif path.suffix.lower() == ".md":
        lines = [tuple(" ".join(cell.split()).translate(ESCAPED) for cell in line) for line in handed.lines]
        write_whole(path, f"# Who keeps most style?\n\n{markdown(lines)}".encode())
    else:
        raise BadInput(f"a table is written as .md or .csv, not as {path.name}")
    return path
