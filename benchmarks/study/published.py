"""The published study (Faruqi et al. 2025) by its own rule: what is run, and its figures beside the published ones.

python -m benchmarks.study published --device cuda --jobs 12 --out study-published     runs it, or goes on
python -m benchmarks.study.published study-published docs/published-study.json          keeps its rows and prints its figures
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from scipy import stats

from benchmarks.study.cells import Row, read_table, write_table
from benchmarks.study.figures import wilson
from benchmarks.study.grids import FLOORS, Factors
from mechstyle.classroom import markdown
from mechstyle.errors import unknown

SIX = ("pen_holder", "phone_stand", "wall_hook", "vase", "drawer_knob", "tealight_holder")
"""Parts of the sensitivity and of the twelve ways; the latter in two styles."""


@dataclass(frozen=True)
class Part:
    """A part of the study: which grid, and what it crosses unless something else is asked for."""

    study: str
    models: Sequence[str] = ()
    styles: Sequence[str] = ()
    floors: Sequence[float] = ()
    settings: Mapping[str, Any] = field(default_factory=dict)


PARTS: Mapping[str, Part] = {
    "calibration": Part("calibration", floors=FLOORS),
    "free": Part("formative", floors=FLOORS),
    "ways": Part("evaluation", SIX, ("brick", "green")),
    "sensitivity": Part("sensitivity", SIX, ("brick", "cactus", "crochet")),
}
"""What is run, in this order: the floor is calibrated before any share is known."""


def factors_of(part: str, models: Sequence[str] | None, styles: Sequence[str] | None, **asked: Any) -> Factors:
    """What a part of the study crosses; BadInput for one that there is not. `asked` are fields of `Factors`."""
    if part not in PARTS:
        raise unknown("part of the study", part, PARTS)
    own = PARTS[part]
    factors = Factors(models=models or own.models, floors=own.floors, settings={"criterion": "paper", **own.settings}, **asked)
    return replace(factors, styles=styles or own.styles or factors.styles)


# --- statistics ---------------------------------------------------------------------------------------------------


def welch(groups: Mapping[str, Sequence[float]]) -> tuple[float, float]:
    """F and p of Welch's analysis of variance; NaN where a group has fewer than two values or they are all alike."""
    own = [values for values in groups.values() if len(values) > 1]
    if len(own) < 2 or any(np.ptp(values) == 0.0 for values in own):
        return np.nan, np.nan
    found = stats.f_oneway(*own, equal_var=False)
    return float(found.statistic), float(found.pvalue)


def games_howell(groups: Mapping[str, Sequence[float]]) -> Iterator[tuple[str, str, float, float]]:
    """Every pair of groups with the difference of their means and its p (Games and Howell 1976)."""
    names = [name for name, values in groups.items() if len(values) > 1]
    if len(names) > 1:
        found = stats.tukey_hsd(*(groups[name] for name in names), equal_var=False)
        for one, other in combinations(range(len(names)), 2):
            yield names[one], names[other], float(found.statistic[one, other]), float(found.pvalue[one, other])


# --- figures ------------------------------------------------------------------------------------------------------


def viable(rows: Sequence[Row], at: float | None = None) -> tuple[int, int]:
    """How many parts the largest stress leaves at or below the yield strength, of how many; `at` another floor than their own [N/mm]."""
    known = [(stress, row.strength) for row in rows if (stress := _stress(row, at)) is not None]
    return sum(stress <= strength for stress, strength in known), len(known)


def _stress(row: Row, at: float | None = None) -> float | None:
    """The largest stress of an element on a floor [MPa]; None where that was not dropped."""
    if at is None:
        return row.stress
    return next((styled for stiffness, styled, _ in row.floors if stiffness == at), None)


def shares(groups: Mapping[str, Sequence[Row]], at: float | None = None) -> str:
    """A table: how many of each group are viable, with Wilson's interval, how much of the style is kept, and how often it was simulated."""
    lines: list[tuple[str, ...]] = [
        ("", "viable", "95 % interval", "kept, median", "style loss, mean", "simulations, mean", "time, mean [s]")
    ]
    for name, rows in groups.items():
        count, total = viable(rows, at)
        if total:
            low, high = wilson(count, total)
            means = [np.mean([getattr(row, what) for row in rows]) for what in ("style_loss", "simulations", "seconds")]
            kept = f"{np.median([row.kept for row in rows]):.2f}"
            figures = (f"{means[0]:.4f}", f"{means[1]:.1f}", f"{means[2]:.0f}")
            lines.append((name, f"{count} of {total} ({count / total:.1%})", f"{low:.1%} to {high:.1%}", kept, *figures))
    return markdown(lines)


def by(rows: Sequence[Row], of: Callable[[Row], str]) -> dict[str, list[Row]]:
    """Rows in groups, in the order in which these come."""
    return {name: [row for row in rows if of(row) == name] for name in dict.fromkeys(map(of, rows))}


def floors_of(rows: Sequence[Row]) -> str:
    """A table: on every floor how many are viable, and the largest stress in the median, styled and plain."""
    lines: list[tuple[str, ...]] = [("floor [N/mm a node]", "viable", "styled, median [MPa]", "plain, median [MPa]")]
    for stiffness in dict.fromkeys(one[0] for row in rows for one in row.floors):
        own = [(styled, plain) for row in rows for at, styled, plain in row.floors if at == stiffness]
        count, total = viable([row for row in rows if row.floors], stiffness)
        styled, plain = np.median(own, axis=0)
        lines.append(
            (f"{stiffness:g}" if stiffness else "rigid", f"{count} of {total} ({count / total:.1%})", f"{styled:.1f}", f"{plain:.1f}")
        )
    return markdown(lines)


def page(rows: Mapping[str, Sequence[Row]]) -> Iterator[str]:
    """The figures of every part of the study that was run."""
    for name, own in rows.items():
        done = [row for row in own if row.status == "done"]
        yield f"## {name}: {len(done)} of {len(own)} runs\n"
        yield "".join(f"* {row.part} as {row.prompt}, {row.arm}: {row.status}, {row.refused}\n" for row in own if row.status != "done")
        if name == "calibration":
            lines: list[tuple[str, ...]] = [("cell", "tetrahedra", "floor [N/mm a node]", "styled [MPa]", "of yield", "plain [MPa]")]
            for row in done:
                cells = (
                    (f"{at:g}" if at else "rigid", f"{one:.1f}", f"{one / row.strength:.2f}", f"{plain:.1f}")
                    for at, one, plain in row.floors
                )
                lines += [(f"{row.part}, {row.prompt}", str(row.tetrahedra), *cell) for cell in cells]
            yield markdown(lines)
        elif name == "free":
            yield shares({"all": done, **by(done, lambda row: row.prompt)})
            yield floors_of(done)
        elif name == "sensitivity":
            yield shares(by(done, lambda row: row.arm))
        else:
            yield from _ways(done)


def _ways(done: Sequence[Row]) -> Iterator[str]:
    yield shares(by(done, lambda row: row.arm))
    ways = [row for row in done if " × " in row.arm]
    losses = {name: [row.style_loss for row in rows] for name, rows in by(ways, lambda row: row.arm).items()}
    yield "style loss over the ways, Welch: F = {:.2f}, p = {:.3g}\n".format(*welch(losses))
    times = {name: [row.seconds for row in rows] for name, rows in by(ways, lambda row: row.schedule).items()}
    yield "time over the schedules, Welch: F = {:.2f}, p = {:.3g}; Games–Howell:\n".format(*welch(times))
    pairs = [(one, other, f"{difference:.1f}", f"{p:.3g}") for one, other, difference, p in games_howell(times)]
    yield markdown([("schedule", "other", "difference of the means [s]", "p"), *pairs])


def main(folder: Path, table: Path) -> None:
    """Keep the rows of a study's folder, or of its table, as one table and print its figures."""
    if folder.is_dir():
        rows = {name: read_table(folder / name) for name in PARTS if (folder / name / "rows").is_dir()}
        for name, own in rows.items():
            write_table(own, table.with_name(f"{table.stem}-{name}"))
    else:
        tables = {name: table.with_name(f"{table.stem}-{name}.json") for name in PARTS}  # of what was run
        rows = {name: msgspec.json.decode(one.read_bytes(), type=list[Row]) for name, one in tables.items() if one.is_file()}
    print("\n".join(page(rows)))


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
