"""All validation cases by name, and what they come to as a table, a page and a picture."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from functools import partial
from pathlib import Path

import msgspec

from mechstyle._warp import wp
from mechstyle.fea.explicit import cores
from validation import gyroids, impacts, infill, statics, yielding
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
        Case("rod", "Ansys VM265: a rod on a wall, when and how fast it leaves", impacts.rod),
        Case("bar_calculix", "The stress wave in a bar in CalculiX's explicit dynamics", impacts.bar_calculix, slow=True),
        Case(
            "contact",
            "A bracket on its corner in CalculiX's explicit dynamics, one element thick",
            partial(impacts.bracket_of_calculix, "contact", 4.0, 0.15),
            slow=True,
        ),
        Case("contact_fine", "The same bracket in two layers", partial(impacts.bracket_of_calculix, "contact_fine", 2.0, 0.1), slow=True),
        Case("sphere", "A ball on the floor: Hertz's contact", impacts.sphere, slow=True),
        Case("plastic_bar", "A bar that yields: the elastic-plastic wave", yielding.plastic_bar),
        Case("taylor_copper", "Taylor's bar of copper at 227 m/s", yielding.taylor_copper),
        Case("taylor_aluminium", "Taylor's bar of aluminium at 478 m/s in CalculiX", yielding.taylor_aluminium, slow=True),
        Case("collapse", "Loads that a cantilever and a strut carry: plastic hinge and Euler", yielding.collapse),
        Case("groove", "A grooved bar in CalculiX with plasticity", yielding.groove, slow=True),
        Case("neck", "A neck in CalculiX with plasticity", yielding.neck, slow=True),
        Case("infill_bars", "Solid skins and walls around infill: beam theory and the rule of mixtures", infill.bars),
        Case("infill_cell", "The cell of a gyroid, voxel by voxel", infill.cell, slow=True),
        Case("infill", "Parts with walls and infill meshed line by line, and the same smeared out", infill.grids, slow=True),
        Case("gyroids", "Gallery parts with each sheet of their gyroid meshed, and the same smeared out", gyroids.gyroids, slow=True),
        Case("energy", "Energy balance of undamped drops", impacts.energy),
        Case("precision", "Single against double precision over an impact", impacts.precision),
        Case("instructions", "Another processor's instructions against this one's", impacts.instructions),
        Case("devices", "CUDA against CPU", impacts.devices),
    )
}
"""In their order on the page."""


class Figures(msgspec.Struct, frozen=True):
    """What a case came to, and on which machine."""

    machine: str
    results: list[Result]

    @property
    def ran(self) -> list[Result]:
        """The figures that were measured."""
        return [result for result in self.results if result.passed is not None]


Found = Mapping[str, Figures]
"""Figures of cases by their names."""


def read(path: Path) -> Found:
    """Figures that were measured before, here or on another machine; none where there is no file."""
    return msgspec.json.decode(path.read_bytes(), type=dict[str, Figures]) if path.exists() else {}


def write(path: Path, found: Found) -> Path:
    """Keep figures in a file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(msgspec.json.format(msgspec.json.encode(found)) + b"\n")
    return path


def merged(before: Found, after: Found) -> Found:
    """All of them in the order of the page; the later ones count, unless they could not be run."""
    new = {name: one for name, one in after.items() if one.ran or name not in before}
    both = {**before, **new}
    return {name: both[name] for name in CASES if name in both}


def write_page(path: Path, found: Found) -> Path:
    """The figures as a Markdown page that says what each was measured on."""
    lines = [
        "# Validation",
        "",
        "The simulation compared with theory, with CalculiX, with finer meshes and with other arithmetic.",
        "Written by `python benchmarks/validate.py --page`.",
        "",
        "`python benchmarks/validate.py --case NAME` runs one again; `validation.json` keeps every figure, its machine and its reference.",
        "",
        "| case | what | figures | passed | largest error over its limit |",
        "|---|---|---|---|---|",
        *(_summary(CASES[name], one) for name, one in found.items()),
        "",
        "## The figure nearest to its limit in each case",
        "",
        "Errors are relative. A dash stands for a figure that is an error itself or was not run.",
        "",
        *_table({CASES[name].name: max(one.results, key=_share) for name, one in found.items()}),
        *(f"\n`{name}`: {CASES[name].fault}" for name in found if CASES[name].fault),
    ]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def _summary(case: Case, found: Figures) -> str:
    """A row on a case: its figures, how many passed, and how near the worst came to its limit."""
    ran = found.ran
    passed = sum(bool(result.passed) for result in ran)
    worst = f"{max(map(_share, ran)):.2f}" if ran else "–"
    verdict = str(passed) if passed == len(ran) else f"{passed}, a known limit" if case.fault else f"**{passed}**"
    return f"| `{case.name}` | {case.title} | {len(ran) or '–'} | {verdict if ran else 'not run'} | {worst} |"


def _share(result: Result) -> float:
    """An error over its limit, which is below 1 where it passes."""
    return result.error / result.limit if result.limit else result.error


def machine() -> str:
    """The machine the figures were measured on, in words, without its name."""
    devices = "".join(f", {device.name}" for device in wp.get_cuda_devices()[:1])
    return f"{platform.system()} {platform.machine()}, {cores()} cores{devices}, Python {platform.python_version()}"


def _table(results: dict[str, Result]) -> list[str]:
    """A row for each case with one of its figures."""
    rows = ["| case | figure | measured | reference | error | limit | | against |", "|---|---|---|---|---|---|---|---|"]
    for case, result in results.items():
        mark = {True: "passed", False: "**failed**", None: "not run"}[result.passed]
        name = result.case.partition(": ")[2] or result.case
        known = result.reference != 0.0
        measured, reference = (f"{value:.4g} {result.unit}".strip() if known else "–" for value in (result.measured, result.reference))
        error, limit = (f"{value:.2g}" if result.passed is not None else "–" for value in (result.error, result.limit))
        rows.append(f"| `{case}` | {name} | {measured} | {reference} | {error} | {limit} | {mark} | {result.note} |")
    return rows
