"""Writes docs/why-these-defaults.md and its rows from what `python -m benchmarks.study ablation` and `ablation_parts.py` measured.

python -m benchmarks.defaults ablation12 ablation3 load12 deep12 --machine "NVIDIA H100"   # folders of rows
python -m benchmarks.defaults docs/why-these-defaults.json                                  # the page alone
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path
from statistics import mean, median

import msgspec

from benchmarks.study.cells import Row, read_table
from benchmarks.study.grids import ARMS, CONDITIONS
from mechstyle.classroom import markdown

DOCS = Path(__file__).parent.parent / "docs"
WORTH_TELLING = 0.9
"""Share of the style below which a run that passes is listed."""
HEAD = """\
# Why these defaults

What each mechanism is worth, measured by taking it away. Made by `python -m benchmarks.defaults` of rows that
`python -m benchmarks.study ablation --models … --styles …` measured.

| arm | what is left |
|---|---|
| freestyle | the style alone |
| static | plain base and thinnest wall, nothing simulated before the end: the twin without feedback |
| one-factor | as static, then one factor on the whole relief, the largest that passes |
| finish-first | no masks; the finished relief is dropped and corrected where it fails: the default |
| masks | masks while the relief grows, then corrections (`--schedule stress`): the default of the Studio |

## The grid

"""
CHOICE = """\
A run finishes first unless a control is asked for. The Studio grows a style under masks, because that is what one watches there.
"""


def tests(rows: Sequence[Row]) -> list[tuple[str, int]]:
    """Conditions with their vertices, the finest first."""
    order = list(CONDITIONS)
    found = {(row.condition, row.vertices) for row in rows}
    return sorted(found, key=lambda one: (order.index(one[0]), -one[1]))


def of(rows: Sequence[Row], test: tuple[str, int], arm: str) -> list[Row]:
    """The runs of an arm under a condition."""
    return [row for row in rows if (row.condition, row.vertices, row.arm) == (*test, arm)]


def grid(rows: Sequence[Row]) -> str:
    """How many pass of each arm under each condition."""
    lines: list[tuple[str, ...]] = [
        ("test", "vertices", "arm", "runs", "passes", "HOLDS", "sure", "kept, median", "kept, least", "style loss, median", "simulations")
    ]
    for test in tests(rows):
        for arm in ARMS:
            if runs := of(rows, test, arm):
                counts = (len(runs), *(sum(map(has, runs)) for has in (_passes, _holds, _sure)))
                kept, loss = ([getattr(row, of) for row in runs] for of in ("kept", "style_loss"))
                shares = (f"{median(kept):.2f}", f"{min(kept):.2f}", f"{median(loss):.2f}", f"{mean(row.simulations for row in runs):.1f}")
                lines.append((test[0], str(test[1]), arm, *map(str, counts), *shares))
    return markdown(lines)


def follows(rows: Sequence[Row]) -> Iterator[str]:
    """What the grid says, a sentence for each condition, and for what masks add."""
    for test in tests(rows):
        words = f"{test[0]}, {test[1]} vertices"
        passed = {arm: f"{sum(map(_passes, runs))} of {len(runs)}" for arm in ARMS if (runs := of(rows, test, arm))}
        worth = against_one_factor(rows, test)
        first, masks = of(rows, test, "finish-first"), of(rows, test, "masks")
        if first and masks:
            kept, times = ([f(runs) for runs in (masks, first)] for f in (_kept, _simulations))
            worth += f"\n  Masks keep {kept[0]:.2f} in the median and finishing first {kept[1]:.2f}, "
            worth += f"with {times[0]:.1f} and {times[1]:.1f} simulations."
        yield f"* **{words}**: {', '.join(f'{arm} {count}' for arm, count in passed.items())} pass.{worth}"


def against_one_factor(rows: Sequence[Row], test: tuple[str, int]) -> str:
    """What feedback keeps beyond one factor where a plain base alone fails, in a sentence; "" where it fails nowhere."""
    three = ("static", "one-factor", "finish-first")
    by_arm = [{(row.part, row.prompt, row.tolerance): row for row in of(rows, test, arm)} for arm in three]
    static, whole, fed = by_arm
    more = [fed[one].kept - whole[one].kept for one in static if not static[one].passes and one in whole and one in fed and fed[one].passes]
    if not more:
        return ""
    return (
        f"\n  Where a plain base alone fails, {len(more)} runs, feedback keeps {median(more):.2f} more of the style than one factor"
        f" in the median, {min(more):.2f} at least."
    )


def given_up(rows: Sequence[Row]) -> Iterator[str]:
    """Runs of the default that do not pass, are not sure, or keep less than WORTH_TELLING."""
    for row in rows:
        if row.arm == "finish-first" and not (row.passes and row.sure and row.kept >= WORTH_TELLING):
            bent = "" if row.permanent_set is None else f", {row.permanent_set:.2f} of {row.allowed:.2f} mm, {row.decides}"
            words = f"{row.part.replace('_', ' ')} in {row.prompt}, {row.condition}, {row.vertices} vertices"
            yield f"* {words}: {row.outcome}{'' if row.sure else ' (not sure)'}{bent}, keeps {row.kept:.2f}."


def page(rows: Sequence[Row], machine: str) -> str:
    """The page of these rows."""
    parts, styles = (list(dict.fromkeys(getattr(row, of) for row in rows)) for of in ("part", "prompt"))
    named = ", ".join(part.replace("_", " ") for part in parts)
    about = "".join(f"* *{name}*: {CONDITIONS[name].about}.\n" for name in dict.fromkeys(test for test, _ in tests(rows)))
    allowed = " and ".join(f"{one:g}" for one in sorted({row.tolerance for row in rows}))
    intro = f"{len(parts)} parts in {' and '.join(styles)}: {named}. Solid PLA, a fall of 1.5 m, tolerances of {allowed} mm. {machine}\n\n"
    rest = "\nRows: [why-these-defaults.json](why-these-defaults.json).\n"
    rest += "*Passes* counts HOLDS and NO WORSE. *Kept* counts what can be seen.\n"
    lines = list(given_up(rows))
    lost = "\n\n".join(lines) if lines else f"Nothing: all pass for sure and keep {WORTH_TELLING:g} at least."
    return (
        f"{HEAD}{intro}{about}{rest}\n{grid(rows)}\n## What follows\n\n" + "\n\n".join(follows(rows))
        + f"\n\n{CHOICE}\n## What finishing first gives up\n\n{lost}\n\n"
        + "How more of a style may be kept: [when a part fails](how-mechstyle-judges.md#when-a-part-fails).\n"
    )  # fmt: skip


def _passes(row: Row) -> bool:
    return row.passes


def _holds(row: Row) -> bool:
    return row.outcome == "HOLDS"


def _sure(row: Row) -> bool:
    return row.sure


def _kept(rows: Sequence[Row]) -> float:
    return median(row.kept for row in rows)


def _simulations(rows: Sequence[Row]) -> float:
    return mean(row.simulations for row in rows)


def main() -> None:
    """Read rows, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sources", type=Path, nargs="+", help="folders of ablations, or tables made of them")
    parser.add_argument("--machine", default="", help="where they ran, for the page")
    given = parser.parse_args()
    found = {(row.recipe, row.part, row.vertices, row.arm, row.condition): row for path in given.sources for row in read_table(path)}
    order = list(ARMS)
    rows = sorted(found.values(), key=lambda row: (row.condition, -row.vertices, row.part, row.prompt, order.index(row.arm)))
    for row in rows:
        if row.status != "done":
            print(f"{row.part} in {row.prompt}, {row.arm}: {row.status}, {row.refused}")
    done = [row for row in rows if row.status == "done"]
    (DOCS / "why-these-defaults.json").write_bytes(b"[\n" + b",\n".join(map(msgspec.json.encode, done)) + b"\n]\n")
    (DOCS / "why-these-defaults.md").write_text(page(done, f"Run on {given.machine}." if given.machine else ""), encoding="utf-8")


if __name__ == "__main__":
    main()
