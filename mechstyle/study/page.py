"""The page of a study: what was run, how much survives, what the tests say, and where that stands beside the published figures."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from mechstyle._files import write_whole
from mechstyle.errors import BadInput
from mechstyle.study import figures
from mechstyle.study.cells import Row
from mechstyle.study.statistics import (
    Equivalence,
    bootstrap_over,
    cochran,
    equivalence,
    friedman,
    games_howell,
    holm,
    mcnemar,
    welch_anova,
    wilcoxon,
    wilson,
)  # fmt: skip
from mechstyle.study.tables import write_table

FREE = "freestyle"
MARGIN = 5.0
"""Style losses are called equal within this share of freestyle's [%], fixed before anything was measured."""
LEAST = 5
"""Fewer blocks than these are told, but not tested."""
PUBLISHED = {FREE: 25.55}
"""Viable in the published study [%] (Faruqi et al. 2025)."""
NUMBERS = "Numbers are the stress as placed over its limit; ✗ beside one below 1: another landing fails."
SLIPS = """\
* Free stylization: 25.55 % is 46 of 180 (25.56 %, cut off).
* The worst way, 80.2 %, is no share of 180 (144 are 80.0 %, 145 are 80.6 %): its count must differ, or it is a slip. Only that and three
  ways with 100 % are given in the text: non-linear × frozen, stress × exponential, stress × frozen.
* One comparison of run times is given twice with T = 6.74, once with p < .0001 and once with p > .05; it is not repeated here.
* Its models are not listed and its code is not published, so the models here are others, and its criterion is one of two shown here: the
  literal maximum within the yield strength, beside the verdict that decides here.
"""


def write_page(rows: Sequence[Row], page: Path, *, note: str = "") -> dict[str, str]:
    """Write the page, its figures and the table it is made from beside it; what each file is, and its path.

    Args:
        rows: Of one or several studies; the same run counts once.
        page: The Markdown file.
        note: A sentence on where the runs come from.

    Raises:
        BadInput: If no run of these is finished.
    """
    own = sorted({(row.recipe, row.part, row.vertices, row.arm): row for row in rows}.values(), key=_order)
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
    made = f"Made of [{table.name}]({table.name}) (rows {digest}) by `mechstyle study page {table.name} --out {page.name}`."
    parts = ["# Study", "\n".join(filter(None, (note, made))), _what(own, done), _free(done, pictures), _ways(done, pictures)]
    parts += [_times(done, pictures), _losses(done, pictures), _arms(done, pictures)]
    parts.append(f"## Beside the published study\n\n{_beside(done)}{SLIPS}")
    write_whole(page, ("\n\n".join(part.rstrip() for part in parts if part) + "\n").encode())
    return files


def _order(row: Row) -> tuple[str, ...]:
    return row.part, row.prompt, row.arm, str(row.amplitude), str(row.loaded), str(row.seed)


def _freely(done: Sequence[Row]) -> list[Row]:
    """The style alone where it was run finest; coarser ones stand beside the ways that were run as coarse, and would count a part twice."""
    free = [row for row in done if row.arm == FREE]
    finest = max((row.vertices for row in free), default=0)
    return [row for row in free if row.vertices == finest]


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
        made["freestyle"] = lambda: figures.matrix(free, "Stress as placed over its limit; ✗ below 1: another landing fails")
    if ways:
        made["viable"] = lambda: figures.viability([*beside, *ways], PUBLISHED)
        made["time"] = lambda: figures.spread(_alike(ways)[0], "cpu_seconds", "processor time of a run [s]", log=True)
        found = _equivalences(done)
        if found:
            made["loss"] = lambda: figures.losses(found, {arm: len(_pairs(done, arm)) for arm in found})
    if arms:
        told = [msgspec.structs.replace(row, arm=_arm_name(row)) for row in arms]
        made["arms"] = lambda: figures.viability(told, {})
        made["kept"] = lambda: figures.spread(told, "kept", "share of the style that is kept")
    return made


def _what(own: Sequence[Row], done: Sequence[Row]) -> str:
    """What was run, in one paragraph and a list of what was not."""
    models, styles = ({getattr(row, field) for row in done} for field in ("part", "prompt"))
    sizes, seeds = sorted({row.tetrahedra for row in done}), len({row.seed for row in done})
    tetrahedra = str(sizes[0]) if len(sizes) == 1 else f"{sizes[0]} to {sizes[-1]}"
    iterations, vertices = (_either(sorted({getattr(row, field) for row in done})) for field in ("iterations", "vertices"))
    hours = sum(row.cpu_seconds for row in done) / 3600.0
    text = (
        f"{len(done)} runs: {len(models)} models in {len(styles)} styles, {iterations} iterations, {vertices} vertices, "
        f"{tetrahedra} tetrahedra, {'one seed' if seeds == 1 else f'{seeds} seeds'}, {hours:.1f} hours of processor time."
    )
    lost = [f"* {row.part} as {row.prompt!r}, {row.arm}: {row.status}, {row.refused}" for row in own if row.status != "done"]
    return text + ("\n\nNot run:\n\n" + "\n".join(lost) if lost else "")


def _free(done: Sequence[Row], pictures: dict[str, str]) -> str:
    free = _freely(done)
    if not free:
        return ""
    lines = [("rule", "viable", "95 % Wilson interval", "drawn over models")]
    for rule, holds in (("the verdict here", [row.viable for row in free]), ("published rule", [row.literally_viable for row in free])):
        low, high = wilson(sum(holds), len(holds))
        over = bootstrap_over([row.part for row in free], np.array(holds, float))
        lines.append((rule, _share(sum(holds), len(holds)), _range(100 * low, 100 * high, "%"), _range(100 * over[0], 100 * over[1], "%")))
    shown = f"![{len(free)} runs, part by style]({pictures['freestyle']})"
    return f"## The style alone\n\n{_markdown(lines)}\n{_by_style(free)}{shown}\n\n{NUMBERS}"


def _by_style(free: Sequence[Row]) -> str:
    """What each style alone leaves whole, where there are several."""
    styles = {style: [row for row in free if row.prompt == style] for style in dict.fromkeys(row.prompt for row in free)}
    if len(styles) < 2:
        return ""
    lines = [("style", "viable", "95 % Wilson interval", "holds as placed", "stress as placed over its limit, median")]
    for style, told in styles.items():
        viable, holding = (sum(getattr(row, of) for row in told) for of in ("viable", "a_holds"))
        stress = f"{np.median([row.as_placed for row in told]):.2f}"
        lines.append((style, _share(viable, len(told)), _interval(viable, len(told)), _share(holding, len(told)), stress))
    return f"{_markdown(lines)}\n"


def _ways(done: Sequence[Row], pictures: dict[str, str]) -> str:
    """Viability of every control with every schedule, tested in pairs."""
    ways = _grouped([row for row in done if _is_way(row)])
    if not ways:
        return ""
    lines: list[tuple[str, ...]] = [
        ("schedule × control", "viable", "95 % Wilson interval", "published rule", "kept, median", "simulations, mean")
    ]
    for arm, told in ways.items():
        viable = sum(row.viable for row in told)
        interval = _interval(viable, len(told))
        literal = _share(sum(row.literally_viable for row in told), len(told))
        kept, times = np.median([row.kept for row in told]), np.mean([row.simulations for row in told])
        lines.append((arm, _share(viable, len(told)), interval, literal, f"{kept:.2f}", f"{times:.1f}"))
    words = "\n".join([_cochran_words(ways), *_mcnemar_words(done, ways)])
    return f"## Control and schedule\n\n{_markdown(lines)}\n![viable, way by way]({pictures['viable']})\n\n{words}"


def _cochran_words(ways: dict[str, list[Row]]) -> str:
    table = _blocks(ways, lambda row: float(row.viable))
    if len(table) < LEAST:
        return f"* {len(table)} blocks of part and style have every way: too few for a test."
    found = cochran(table)
    if found is None:
        return "* In no block of part and style do the ways differ in whether the part survives."
    return f"* Cochran's Q over {len(table)} blocks of part and style: {found[0]:.2f}, p {_p(found[1])}."


def _mcnemar_words(done: Sequence[Row], ways: dict[str, list[Row]]) -> list[str]:
    """Every way against the style alone, in pairs, adjusted after Holm."""
    tested = []
    for arm in ways:
        pairs = _pairs(done, arm)
        if len(pairs) >= LEAST:
            tested.append((arm, len(pairs), mcnemar([free.viable for free, _ in pairs], [fed.viable for _, fed in pairs])))
    adjusted = holm([p for _, _, p in tested])
    told = zip(tested, adjusted, strict=True)
    return [f"* {arm} against the style alone, {n} pairs, exact McNemar after Holm: p {_p(p)}." for (arm, n, _), p in told]


def _times(done: Sequence[Row], pictures: dict[str, str]) -> str:
    """Processor time, as published (Welch, Games and Howell over schedules) and by blocks."""
    ways, where = _alike([row for row in done if _is_way(row)])
    if not ways:
        return ""
    groups = {name: [row.cpu_seconds for row in ways if row.schedule == name] for name in sorted({row.schedule for row in ways})}
    lines = [("schedule", "runs", "processor time, mean [s]", "deviation [s]")]
    for name, own in groups.items():
        lines.append((name, str(len(own)), f"{np.mean(own):.0f}", f"{np.std(own, ddof=1):.0f}" if len(own) > 1 else "–"))
    words, found = [], welch_anova(list(groups.values()))
    if found is not None:
        words.append(f"* Welch: F({found.between:.0f}, {found.within:.1f}) = {found.statistic:.2f}, p {_p(found.p)}.")
        for pair in games_howell(groups):
            limits = _range(pair.low, pair.high, "s")
            words.append(f"* {pair.first} less {pair.second}: {pair.difference:.0f} s ({limits}), Games–Howell p {_p(pair.p)}.")
    table = _blocks(_grouped(ways), lambda row: row.cpu_seconds)
    blocked = friedman(table) if len(table) >= LEAST else None
    if blocked is not None:
        words.append(f"* Friedman over {len(table)} blocks of part and style: {blocked[0]:.2f}, p {_p(blocked[1])}.")
    shown = f"![processor time, way by way]({pictures['time']})"
    head = f"## Time\n\nProcessor time, since wall time on shared machines says little{where}."
    return f"{head}\n\n{_markdown(lines)}\n{shown}\n\n" + "\n".join(words)


def _alike(rows: Sequence[Row]) -> tuple[list[Row], str]:
    """Those of blocks without a run on a GPU, which works for its processor, and that in words where there are others; all if none is."""
    there = {_block(row) for row in rows if row.device.startswith("cuda")}
    plain = [row for row in rows if _block(row) not in there]
    if len(plain) in (0, len(rows)):
        return list(rows), ""
    return plain, f"; of the {len(plain)} runs of {len(rows)} whose part and style were simulated without a GPU in every way"


def _losses(done: Sequence[Row], pictures: dict[str, str]) -> str:
    """Style loss in pairs with the style alone, against the margin."""
    found = _equivalences(done)
    if not found:
        return ""
    lines = [
        ("schedule × control", "pairs", "loss less freestyle's", "90 % interval", f"within ±{MARGIN:g} %", "over models", "Wilcoxon p")
    ]
    for arm, one in found.items():
        pairs = _pairs(done, arm)
        over = bootstrap_over([free.part for free, _ in pairs], _differences(pairs))
        p = wilcoxon([fed.style_loss for _, fed in pairs], [free.style_loss for free, _ in pairs])
        shown = f"shown, p {_p(one.p)}" if one.shown else "not shown"
        lines.append((arm, str(len(pairs)), f"{one.difference:+.1f} %", _range(one.low, one.high, "%"), shown, _range(*over, "%"), _p(p)))
    words = "That no difference is found would not show that there is none; two one-sided tests against a margin fixed beforehand do."
    return f"## Style loss\n\n{words}\n\n{_markdown(lines)}\n![differences in style loss]({pictures['loss']})"


def _arms(done: Sequence[Row], pictures: dict[str, str]) -> str:
    """What each mechanism is worth, by depth and load."""
    groups: dict[str, list[Row]] = {}
    for row in done:
        if _is_arm(row):
            groups.setdefault(_arm_name(row), []).append(row)
    if not groups:
        return ""
    lines = [("arm", "viable", "95 % Wilson interval", "kept, median", "simulations, mean")]
    for arm, told in groups.items():
        viable = sum(row.viable for row in told)
        interval = _interval(viable, len(told))
        kept, times = np.median([row.kept for row in told]), np.mean([row.simulations for row in told])
        lines.append((arm, _share(viable, len(told)), interval, f"{kept:.2f}", f"{times:.1f}"))
    shown = f"![viable, arm by arm]({pictures['arms']})\n\n![style kept, arm by arm]({pictures['kept']})"
    return f"## What each mechanism is worth\n\n{_markdown(lines)}\n{shown}"


def _beside(done: Sequence[Row]) -> str:
    """Our shares and the published ones, where both are."""
    lines = [("", "here", "here, published rule", "published")]
    free = _freely(done)
    if free:
        here, literal = (_share(count, len(free)) for count in (sum(r.viable for r in free), sum(r.literally_viable for r in free)))
        lines.append((f"viable, {FREE}", here, literal, f"{PUBLISHED[FREE]:g} % (46 of 180)"))
    worst = [(sum(row.viable for row in told) / len(told), arm, told) for arm, told in _grouped([r for r in done if _is_way(r)]).items()]
    if worst:
        _, arm, told = min(worst, key=lambda one: one[:2])
        literal = _share(sum(row.literally_viable for row in told), len(told))
        lines.append((f"viable, worst way ({arm})", _share(sum(row.viable for row in told), len(told)), literal, "80.2 %"))
    return _markdown(lines) + "\n" if len(lines) > 1 else ""


def _grouped(rows: Sequence[Row]) -> dict[str, list[Row]]:
    return {arm: [row for row in rows if row.arm == arm] for arm in dict.fromkeys(row.arm for row in rows)}


def _blocks(ways: dict[str, list[Row]], value: Callable[[Row], float]) -> list[list[float]]:
    """A value for each block that has every way, one for each way."""
    tables = [{_block(row): value(row) for row in told} for told in ways.values()]
    shared = [block for block in tables[0] if all(block in table for table in tables)]
    return [[table[block] for table in tables] for block in shared]


def _pairs(done: Sequence[Row], arm: str) -> list[tuple[Row, Row]]:
    """The same block, freely and under an arm."""
    free = {_block(row): row for row in done if row.arm == FREE}
    told = [row for row in done if row.arm == arm]
    return [(free[_block(row)], row) for row in told if _block(row) in free]


def _block(row: Row) -> tuple[Any, ...]:
    """What rows that are compared have in common: part, style, depth, loads, seed and resolution."""
    return row.part, row.prompt, row.amplitude, row.loaded, row.seed, row.vertices, row.iterations


def _differences(pairs: Sequence[tuple[Row, Row]]) -> np.ndarray:
    """Style loss less freestyle's [% of freestyle's]."""
    return np.array([100.0 * (fed.style_loss / free.style_loss - 1.0) for free, fed in pairs if free.style_loss > 0.0])


def _equivalences(done: Sequence[Row]) -> dict[str, Equivalence]:
    """Paired differences of every way that has enough of them."""
    found = {}
    for arm in _grouped([row for row in done if _is_way(row)]):
        pairs = [pair for pair in _pairs(done, arm) if pair[0].style_loss > 0.0]
        one = equivalence(_differences(pairs), MARGIN) if len(pairs) >= LEAST else None
        if one is not None:
            found[arm] = one
    return found


def _arm_name(row: Row) -> str:
    depth = "default depth" if row.amplitude is None else f"depth {row.amplitude:g}"
    return f"{row.arm}, {depth}, {'drop and load' if row.loaded else 'drop'}"


def _either(values: Sequence[int]) -> str:
    """Such as "40 or 200"."""
    *others, last = map(str, values)
    return f"{', '.join(others)} or {last}" if others else last


def _interval(count: int, total: int) -> str:
    low, high = wilson(count, total)
    return _range(100 * low, 100 * high, "%")


def _share(count: int, total: int) -> str:
    return f"{count} of {total} ({100 * count / total:.1f} %)"


def _range(low: float, high: float, unit: str) -> str:
    return f"{low:.1f} to {high:.1f} {unit}"


def _p(value: float) -> str:
    return "< .0001" if value < 1e-4 else f"= {value:.4f}"


def _markdown(lines: Sequence[tuple[str, ...]]) -> str:
    ruled = [lines[0], tuple("---" for _ in lines[0]), *lines[1:]]
    return "".join(f"| {' | '.join(line)} |\n" for line in ruled)
