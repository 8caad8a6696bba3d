"""The page of a study: what was run, how much of it passes, and the published figures beside it."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from benchmarks.study import figures
from benchmarks.study.cells import Row, write_table
from benchmarks.study.grids import CONDITIONS
from mechstyle._files import write_whole
from mechstyle.classroom import markdown
from mechstyle.errors import BadInput
from mechstyle.records.sentences import EXPLANATION, MEANINGS, bend
from mechstyle.records.written import written

FREE = "freestyle"
PUBLISHED = {FREE: 25.55}
"""Runs that pass in the published study [%] (Faruqi et al. 2025)."""
NUMBERS = (
    "Numbers are what stays bent in the worst test in mm; ✓ holds, ≈ no worse than the plain part, ✗ fails. A mark in brackets is not sure."
    " ✗ with a number below the tolerance: it cracks there."
)
MEASURE = (
    "Measure of the table: what stays bent in the worst test (columns `permanent_set`, `plain_permanent_set` and `allowed`, in mm), and the"
    " plastic strain in tension beside the material's elongation at break (`plastic_strain`)."
)
SLIPS = """\
* Free stylization: 25.55 % is 46 of 180 (25.56 %, cut off).

* The worst way, 80.2 %, is no share of 180 (144 are 80.0 %, 145 are 80.6 %): its count must differ, or it is a slip. Only that and three
  ways with 100 % are given in the text: non-linear × frozen, stress × exponential, stress × frozen.

* One comparison of run times is given twice with T = 6.74, once with p < .0001 and once with p > .05; it is not repeated here.

* Its models are not listed and its code is not published, so the models here are others. Its criterion is the largest stress at a point
  within the yield strength; here it decides only with `--criterion paper`.
* It compares losses of style with those of free stylization. Here a style alone arrives at its target and its loss is 0, so that *kept*
  says what is given up.
"""


def write_page(rows: Sequence[Row], page: Path, *, note: str = "") -> dict[str, str]:
    """Write the page, its figures and the table it is made from beside it; what each file is, and its path.

    The same run counts once. `note` is a sentence on where the runs come from.

    Raises:
        BadInput: If no run of these is finished.
    """
    own = sorted(
        {(row.recipe, row.part, row.vertices, row.arm, row.condition): row for row in rows}.values(),
        key=lambda row: (row.part, row.prompt, row.arm, row.condition, str(row.amplitude), str(row.seed)),
    )
    done = [row for row in own if row.status == "done"]
    if not done:
        raise BadInput("none of these runs is finished, so there is nothing to make a page of: run the study to its end")
    stem = page.with_suffix("")
    table = write_table(own, stem)
    files, pictures = {"page": str(page), "table": str(table)}, dict[str, str]()
    for name, picture in _pictures(done).items():
        path = stem.with_name(f"{stem.name}-{name}.png")
        write_whole(path, picture())
        pictures[name], files[name] = path.name, str(path)
    digest = hashlib.sha256(msgspec.json.encode(own)).hexdigest()[:12]
    made = f"Made of [{table.name}]({table.name}) (rows {digest}) by `python -m benchmarks.study page {table.name} --out {page.name}`."
    meanings = "\n".join(f"* **{outcome}**: {meaning}" for outcome, meaning in MEANINGS.items())
    parts = ["# Study", _found(done), "\n".join(filter(None, (note, made))), _what(own, done)]
    parts += ["## How to read it", " ".join(EXPLANATION[:3]), " ".join(EXPLANATION[3:]), meanings]
    parts.append(f"A run passes if it HOLDS or is NO WORSE. {MEASURE}")
    parts += [_free(done, pictures), _ways(done, pictures)]
    parts += [_times(done, pictures), _arms(done, pictures)]
    parts.append(f"## Compared with the published study\n\n{_beside(done)}{SLIPS}")
    write_whole(page, ("\n\n".join(part.rstrip() for part in parts if part) + "\n").encode())
    return files


def _freely(done: Sequence[Row]) -> list[Row]:
    """The style alone at the vertices of most runs; others stand beside the ways that were run as coarse, and would count a part twice."""
    free = [row for row in done if row.arm == FREE]
    counts = Counter(row.vertices for row in free)
    usual = max(counts, key=lambda vertices: (counts[vertices], vertices), default=0)
    return [row for row in free if row.vertices == usual]


def _is_way(row: Row) -> bool:
    return " × " in row.arm


def _is_arm(row: Row) -> bool:
    return row.arm != FREE and not _is_way(row)


def _pictures(done: Sequence[Row]) -> dict[str, Callable[[], bytes]]:
    """The figures there is something to show in, not yet drawn."""
    free, (ways, arms) = _freely(done), ([row for row in done if of(row)] for of in (_is_way, _is_arm))
    blocks = {_block(row) for row in ways}
    beside = [row for row in done if row.arm == FREE and _block(row) in blocks]
    made: dict[str, Callable[[], bytes]] = {}
    if free:
        made["freestyle"] = lambda: figures.matrix(free, "What stays bent in the worst test [mm]")
    if ways:
        made["passes"] = lambda: figures.passing([*beside, *ways], PUBLISHED)
        made["time"] = lambda: figures.spread(_alike(ways)[0], "cpu_seconds", "processor time of a run [s]", log=True)
    if arms:
        named = [msgspec.structs.replace(row, arm=f"{row.arm}, {row.condition}") for row in arms]
        made["arms"] = lambda: figures.passing(named, {})
        made["kept"] = lambda: figures.spread(named, "kept", "share of the style that is kept")
    return made


def _what(own: Sequence[Row], done: Sequence[Row]) -> str:
    """What was run, in one paragraph and a list of what was not."""
    models, styles = ({getattr(row, field) for row in done} for field in ("part", "prompt"))
    sizes, seeds = sorted({row.tetrahedra for row in done}), len({row.seed for row in done})
    tetrahedra = str(sizes[0]) if len(sizes) == 1 else f"{sizes[0]} to {sizes[-1]}"
    iterations, vertices = (_either(sorted({getattr(row, field) for row in done})) for field in ("iterations", "vertices"))
    falls, sure = " and ".join(written(height) for height in sorted({row.fall for row in done})), sum(row.sure for row in done)
    hours = sum(row.cpu_seconds for row in done) / 3600.0
    text = (
        f"{len(done)} runs: {len(models)} models in {len(styles)} styles, {iterations} iterations, {vertices} vertices, "
        f"{tetrahedra} tetrahedra, {'one seed' if seeds == 1 else f'{seeds} seeds'}, {hours:.1f} hours of processor time. "
        f"Asked for is a fall of {falls}. {sure} of {len(done)} outcomes are sure."
    )
    lost = [f"* {row.part} as {row.prompt!r}, {row.arm}: {row.status}, {row.refused}" for row in own if row.status != "done"]
    return text + ("\n\nNot run:\n\n" + "\n\n".join(lost) if lost else "")


def _found(done: Sequence[Row]) -> str:
    """What was asked and found, before how it was run: a line for the style alone, for the ways of feedback and for each arm."""
    asked = "How many parts survive their fall with a style alone, and how many with feedback?"
    lines, free = list[str](), _freely(done)
    if free:
        theirs = f"Published: {PUBLISHED[FREE]:g} % (46 of 180), by the largest stress at a point."
        lines.append(f"* **The style alone**: {_counted(free)}. {theirs}")
    ways = [row for row in done if _is_way(row)]
    if ways:
        lines.append(f"* **Control and schedule**, no corrections at the end: {_counted(ways)}; {_extremes(ways)}.")
    arms: dict[tuple[str, str], list[Row]] = {}
    for row in filter(_is_arm, done):
        arms.setdefault((row.condition, row.arm), []).append(row)
    for (condition, arm), rows in sorted(arms.items()):
        lines.append(f"* **{arm}, {condition}**: {_counted(rows)}, kept {np.median([row.kept for row in rows]):.2f} in the median.")
    return "\n\n".join([asked, *lines])


def _counted(rows: Sequence[Row]) -> str:
    """How many pass, how many of these hold, and how many outcomes leave a doubt."""
    passes, holds, doubts = (sum(of) for of in zip(*((row.passes, row.outcome == "HOLDS", not row.sure) for row in rows), strict=True))
    sure = "1 outcome is not sure" if doubts == 1 else f"{doubts} outcomes are not sure"
    return f"{_share(passes, len(rows))} pass, {holds} of them hold by themselves; {sure}"


def _extremes(ways: Sequence[Row]) -> str:
    shares = sorted((sum(row.passes for row in rows) / len(rows), arm) for arm, rows in _grouped(ways).items())
    (least, worst), (most, best) = shares[0], shares[-1]
    return f"from {100 * least:.0f} % ({worst}) to {100 * most:.0f} % ({best})"


def _free(done: Sequence[Row], pictures: dict[str, str]) -> str:
    free = _freely(done)
    if not free:
        return ""
    lines: list[tuple[str, ...]] = [("style", "passes", "95 % Wilson interval", "sure", "stays bent, median", "plain part, median")]
    styles = {style: [row for row in free if row.prompt == style] for style in dict.fromkeys(row.prompt for row in free)}
    for style, rows in {"all": free, **(styles if len(styles) > 1 else {})}.items():
        medians = (_median([getattr(row, of) for row in rows]) for of in ("permanent_set", "plain_permanent_set"))
        lines.append((style, *_passing(sum(row.passes for row in rows), len(rows)), str(sum(row.sure for row in rows)), *medians))
    shown = f"![{len(free)} runs, part by style]({pictures['freestyle']})"
    return f"## The style alone\n\n{markdown(lines)}\n{shown}\n\n{NUMBERS}"


def _median(lengths: Sequence[float | None]) -> str:
    """Median of the lengths that are known [mm], in words; a dash without any."""
    known = [one for one in lengths if one is not None]
    return bend(float(np.median(known))) if known else "–"


def _ways(done: Sequence[Row], pictures: dict[str, str]) -> str:
    """How often every control with every schedule passes."""
    ways = _grouped([row for row in done if _is_way(row)])
    if not ways:
        return ""
    lines: list[tuple[str, ...]] = [("schedule × control", "passes", "95 % Wilson interval", "sure", "kept, median", "simulations, mean")]
    for arm, rows in ways.items():
        passes, sure = (sum(getattr(row, of) for row in rows) for of in ("passes", "sure"))
        kept, times = np.median([row.kept for row in rows]), np.mean([row.simulations for row in rows])
        lines.append((arm, *_passing(passes, len(rows)), str(sure), f"{kept:.2f}", f"{times:.1f}"))
    return f"## Control and schedule\n\n{markdown(lines)}\n![share that passes, way by way]({pictures['passes']})"


def _times(done: Sequence[Row], pictures: dict[str, str]) -> str:
    """Processor time of each schedule."""
    ways, where = _alike([row for row in done if _is_way(row)])
    if not ways:
        return ""
    groups = {name: [row.cpu_seconds for row in ways if row.schedule == name] for name in sorted({row.schedule for row in ways})}
    lines = [("schedule", "runs", "processor time, mean [s]", "deviation [s]")]
    for name, own in groups.items():
        lines.append((name, str(len(own)), f"{np.mean(own):.0f}", f"{np.std(own, ddof=1):.0f}" if len(own) > 1 else "–"))
    shown = f"![processor time, way by way]({pictures['time']})"
    head = f"## Time\n\nProcessor time, since wall time on shared machines says little{where}."
    return f"{head}\n\n{markdown(lines)}\n{shown}"


def _alike(rows: Sequence[Row]) -> tuple[list[Row], str]:
    """Those of blocks without a run on a GPU, which works for its processor, and that in words where there are others; all if none is."""
    there = {_block(row) for row in rows if row.device.startswith("cuda")}
    plain = [row for row in rows if _block(row) not in there]
    if len(plain) in (0, len(rows)):
        return list(rows), ""
    return plain, f"; of the {len(plain)} runs of {len(rows)} whose part and style were simulated without a GPU in every way"


def _arms(done: Sequence[Row], pictures: dict[str, str]) -> str:
    arms = [row for row in done if _is_arm(row)]
    if not arms:
        return ""
    groups: dict[tuple[str, str], list[Row]] = {}
    for row in sorted(arms, key=lambda row: (row.condition, row.arm)):
        groups.setdefault((row.condition, row.arm), []).append(row)
    lines: list[tuple[str, ...]] = [
        ("condition", "arm", "passes", "95 % Wilson interval", "fails", "sure", "kept, median", "kept, least", "simulations, mean")
    ]
    for names, rows in groups.items():
        passes, sure, fails = sum(row.passes for row in rows), sum(row.sure for row in rows), sum(row.outcome == "FAILS" for row in rows)
        kept, times = [row.kept for row in rows], np.mean([row.simulations for row in rows])
        counts = (*_passing(passes, len(rows)), str(fails), str(sure))
        lines.append((*names, *counts, f"{np.median(kept):.2f}", f"{min(kept):.2f}", f"{times:.1f}"))
    asked = "".join(f"* **{name}**: {one.about}.\n" for name, one in CONDITIONS.items() if any(row.condition == name for row in arms))
    shown = f"![share that passes, arm by arm]({pictures['arms']})\n\n![style kept, arm by arm]({pictures['kept']})"
    return f"## What each mechanism is worth\n\n{asked}\n{markdown(lines)}\n{shown}"


def _beside(done: Sequence[Row]) -> str:
    """Our shares and the published ones, where both are."""
    lines = [("", "here", "published")]
    free = _freely(done)
    if free:
        lines.append((f"passes, {FREE}", _share(sum(row.passes for row in free), len(free)), f"{PUBLISHED[FREE]:g} % (46 of 180)"))
    worst = [(sum(row.passes for row in rows) / len(rows), arm, rows) for arm, rows in _grouped([r for r in done if _is_way(r)]).items()]
    if worst:
        _, arm, rows = min(worst, key=lambda one: one[:2])
        lines.append((f"passes, worst way ({arm})", _share(sum(row.passes for row in rows), len(rows)), "80.2 %"))
    return markdown(lines) + "\n" if len(lines) > 1 else ""


def _grouped(rows: Sequence[Row]) -> dict[str, list[Row]]:
    return {arm: [row for row in rows if row.arm == arm] for arm in dict.fromkeys(row.arm for row in rows)}


def _block(row: Row) -> tuple[Any, ...]:
    """What rows that are compared have in common: part, style, condition, depth, seed and resolution."""
    return row.part, row.prompt, row.condition, row.amplitude, row.seed, row.vertices, row.iterations


def _either(values: Sequence[int]) -> str:
    """Such as "40 or 200"."""
    *others, last = map(str, values)
    return f"{', '.join(others)} or {last}" if others else last


def _passing(count: int, total: int) -> tuple[str, str]:
    """How many pass, with its share and its interval."""
    low, high = figures.wilson(count, total)
    return _share(count, total), f"{100 * low:.1f} to {100 * high:.1f} %"


def _share(count: int, total: int) -> str:
    return f"{count} of {total} ({100 * count / total:.1f} %)"
