"""All validation cases by name, and what they come to as a table, a page and a picture."""

from __future__ import annotations

import platform
import re
from collections.abc import Iterable
from functools import partial
from pathlib import Path

from mechstyle.fea.explicit import cores
from validation import impacts, statics
from validation.cases import Case, Result

CASES = {
    case.name: case
    for case in (
        Case("patch", "Patch test: an affine displacement is reproduced without forces inside", statics.patch),
        Case("rigid", "Rigid motion: a large rotation gives no force", statics.rigid),
        Case("frame", "Frame indifference: forces turn with the body", statics.frame),
        Case("plate", "A 2 mm plate one element thick against beam theory and finer meshes", statics.plate, slow=True),
        Case("cantilever", "A cantilever in CalculiX, C3D4 and C3D10", statics.cantilever),
        Case("bar", "Pressure under a bar that lands on its end: ρ c v", impacts.bar),
        Case("bar_calculix", "The stress wave in a bar in CalculiX's explicit dynamics", impacts.bar_calculix, slow=True),
        Case(
            "contact",
            "A bracket on its corner in CalculiX's explicit dynamics, one element thick",
            partial(impacts.bracket_of_calculix, "contact", 4.0, 0.15),
            slow=True,
        ),
        Case("contact_fine", "The same bracket in two layers", partial(impacts.bracket_of_calculix, "contact_fine", 2.0, 0.1), slow=True),
        Case("sphere", "A ball on the floor: Hertz's contact", impacts.sphere, slow=True),
        Case("energy", "Energy balance of undamped drops", impacts.energy),
        Case("precision", "Single against double precision over an impact", impacts.precision),
        Case("instructions", "Another processor's instructions against this one's", impacts.instructions),
        Case("devices", "CUDA against CPU", impacts.devices),
    )
}
"""In their order on the page."""


def write_page(path: Path, found: Iterable[tuple[Case, list[Result]]]) -> Path:
    """The figures as a Markdown page that says what they were measured on."""
    found = list(found)
    lines = [
        "# Validation",
        "",
        "The simulation compared with theory, with CalculiX, with finer meshes and with other arithmetic.",
        f"Written by `python benchmarks/validate.py --page` on {machine()}.",
        "",
        "| case | figures | passed | largest error over its limit |",
        "|---|---|---|---|",
        *(_summary(case, results) for case, results in found),
        "",
        "Below, errors are relative. A dash stands for a figure that is an error itself or was not run.",
    ]
    for case, results in found:
        fault = [case.fault, ""] if case.fault else []
        lines += ["", f"## {case.title}", "", f"`python benchmarks/validate.py --case {case.name}`", "", *fault, *_table(results)]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def _summary(case: Case, results: list[Result]) -> str:
    """A row on a case: its figures, how many passed, and how near the worst came to its limit."""
    ran = [result for result in results if result.passed is not None]
    passed, place = sum(bool(result.passed) for result in ran), re.sub(r"[^\w\- ]", "", case.title.lower()).replace(" ", "-")
    worst = f"{max(result.error / result.limit if result.limit else result.error for result in ran):.2f}" if ran else "–"
    verdict = str(passed) if passed == len(ran) else f"{passed}, a known limit" if case.fault else f"**{passed}**"
    return f"| [{case.title}](#{place}) | {len(ran) or '–'} | {verdict if ran else 'not run'} | {worst} |"


def machine() -> str:
    """The machine the figures were measured on, in words, without its name."""
    return f"{platform.system()} {platform.machine()}, {cores()} cores, Python {platform.python_version()}"


def _table(results: list[Result]) -> list[str]:
    rows = ["| figure | measured | reference | error | limit | | against |", "|---|---|---|---|---|---|---|"]
    for result in results:
        mark = {True: "passed", False: "**failed**", None: "not run"}[result.passed]
        name = result.case.partition(": ")[2] or result.case
        known = result.reference != 0.0
        measured, reference = (f"{value:.4g} {result.unit}".strip() if known else "–" for value in (result.measured, result.reference))
        error, limit = (f"{value:.2g}" if result.passed is not None else "–" for value in (result.error, result.limit))
        rows.append(f"| {name} | {measured} | {reference} | {error} | {limit} | {mark} | {result.note} |")
    return rows


def draw(path: Path, found: Iterable[tuple[Case, list[Result]]]) -> Path:
    """Error over limit of every figure on a logarithmic axis: what lies left of the line passes."""
    from matplotlib.figure import Figure  # noqa: PLC0415 - half a second, for pictures only

    figures = [result for _, results in found for result in results if result.passed is not None]
    shares = [max(result.error / result.limit, 1e-10) if result.limit else float(result.error > 0.0) + 1e-10 for result in figures]
    figure = Figure(figsize=(9.0, 0.9 + 0.22 * len(figures)), layout="constrained")
    axes = figure.add_subplot()
    colours = ["#2b6ca3" if result.passed else "#c2410c" for result in figures]
    axes.scatter(shares, range(len(figures)), c=colours, s=22, zorder=3)
    axes.axvline(1.0, color="#333333", linewidth=1.0)
    axes.set(xscale="log", xlabel="error over its limit: left of the line passes", ylim=(len(figures) - 0.5, -0.5))
    axes.set_yticks(range(len(figures)), [result.case for result in figures], fontsize=8)
    axes.grid(axis="x", color="#dddddd", linewidth=0.6)
    axes.spines[["top", "right"]].set_visible(False)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)
    return path
