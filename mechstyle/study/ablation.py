"""What each mechanism is worth: the same parts and styles with mechanisms taken away, counted side by side."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np

from mechstyle._files import write_whole
from mechstyle.pictures.panels import Picture
from mechstyle.records.mesh import STANDARD_VERTICES
from mechstyle.records.sentences import length
from mechstyle.study import figures
from mechstyle.study.cells import Row
from mechstyle.study.grids import ARMS, CONDITIONS, Factors, cells_of
from mechstyle.study.walk import Tell, walk

if TYPE_CHECKING:
    from matplotlib.axes import Axes

OUTCOMES = {"HOLDS": ("o", "#0072b2"), "NO WORSE": ("^", "#009e73"), "FAILS": ("X", "#d55e00"), "UNKNOWN": ("s", "#7a7a80")}
"""Mark and colour of an outcome (Okabe and Ito), each with a mark of its own in grey; one that is not filled is not sure."""

COUNTED = ("runs", "passes", "HOLDS", "FAILS", "sure", "kept", "least", "simulations", "seconds")
SINGLE = (
    "part", "style", "condition", "arm", "outcome", "sure", "flat: σ_V [MPa]", "flat: plain", "flat", "nearly flat: σ_V [MPa]",
    "nearly flat: plain", "nearly flat", "load factor", "safety factor", "kept", "simulations", "seconds",
)  # fmt: skip
"""Headings of the table of runs; lengths are critical drop heights."""


@dataclass(frozen=True)
class Ablation:
    """All runs of an ablation, one row for each part, style, condition and arm."""

    rows: Sequence[Row]

    def summary(self) -> list[tuple[str, ...]]:
        """Headings, then a line for each condition and arm: how many pass, how many of these are sure, and what is kept of the style."""
        lines: list[tuple[str, ...]] = [("condition", "arm", *COUNTED)]
        for condition in dict.fromkeys(row.condition for row in self.rows):
            lines += [(condition, arm, *counted(runs)) for arm in ARMS if (runs := self._done(condition, arm))]
        return lines

    def against_the_twin(self) -> list[str]:
        """What feedback adds to its static twin, one sentence for each condition and arm that has both for some part and style."""
        sentences = []
        for condition in dict.fromkeys(row.condition for row in self.rows):
            twins = {_block(row): row for row in self._done(condition, "static")}
            for arm in ("finish-first", "masks"):
                pairs = [(twins[_block(row)], row) for row in self._done(condition, arm) if _block(row) in twins]
                if pairs:
                    before, after = (sum(pair[side].passes for pair in pairs) for side in (0, 1))
                    points = 100.0 * (after - before) / len(pairs)
                    sentences.append(
                        f"{condition}: {arm} passes in {after} of {len(pairs)}, its static twin in {before} of {len(pairs)}"
                        f" ({points:+.0f} points)."
                    )
        return sentences

    def table(self) -> str:
        """The summary, then every run, as Markdown."""
        about = "".join(f"* **{name}**: {CONDITIONS[name].about}.\n" for name in dict.fromkeys(row.condition for row in self.rows))
        about += "".join(f"* **{name}**: {arm.about}.\n" for name, arm in ARMS.items() if any(row.arm == name for row in self.rows))
        twin = "".join(f"* {sentence}\n" for sentence in self.against_the_twin())
        return "\n".join(filter(None, (markdown(self.summary()), twin, about, markdown([SINGLE, *map(_line, self.rows)]))))

    def show(self) -> Picture:
        """What is kept of every style, arm by arm, and whether the part passes."""
        conditions = list(dict.fromkeys(row.condition for row in self.rows)) or ["drop"]
        page, columns = figures.sheet(2.0 + 4.2 * len(conditions), 4.4, 110, len(conditions))
        for axes, name in zip(columns, conditions, strict=True):
            _draw(axes, [row for row in self.rows if row.condition == name and row.status == "done"], name)
        return Picture(figures.png(page))

    def save(self, folder: Path) -> dict[str, str]:
        """Write `ablation.md`, `ablation.json` and `ablation.png`; what each file is, and its path."""
        write_whole(folder / "ablation.md", self.table().encode())
        write_whole(folder / "ablation.json", msgspec.json.format(msgspec.json.encode(list(self.rows)), indent=1))
        picture = self.show().save(folder / "ablation.png")
        return {"table": str(folder / "ablation.md"), "rows": str(folder / "ablation.json"), "picture": str(picture)}

    def _done(self, condition: str, arm: str) -> list[Row]:
        return [row for row in self.rows if (row.condition, row.arm, row.status) == (condition, arm, "done")]


def ablation(
    models: Iterable[str], prompts: Iterable[str], out: str | Path, *,
    conditions: Iterable[str] = ("drop",), arms: Iterable[str] = tuple(ARMS), vertices: int = STANDARD_VERTICES, device: str = "auto",
    jobs: int = 1, tell: Tell = lambda _: None, **settings: Any,
) -> Ablation:  # fmt: skip
    """Run every arm on every part and style under every condition; what was run before in the folder is not run again.

    Under the condition "load" parts that carry nothing are left out; `loads` among the settings take the place of those of a model's use.

    Raises:
        BadInput: If there is no such arm or condition, or a model cannot be used.
    """
    order, shown = {arm: number for number, arm in enumerate(ARMS)}, list(conditions)
    factors = Factors(
        models=list(dict.fromkeys(models)), styles=list(prompts), arms=list(arms), conditions=shown, vertices=vertices, device=device,
        settings=settings,
    )  # fmt: skip
    rows = walk(cells_of("ablation", factors), out, jobs=jobs, tell=tell)
    return Ablation(sorted(rows, key=lambda row: (shown.index(row.condition), row.part, row.prompt, order.get(row.arm, len(order)))))


def counted(runs: Sequence[Row]) -> tuple[str, ...]:
    """Runs in figures, under COUNTED: passes are HOLDS and NO WORSE, kept is the median and the least, the last two are means."""
    kept = np.array([row.kept for row in runs])
    return (
        str(len(runs)),
        str(sum(row.passes for row in runs)),
        str(sum(row.outcome == "HOLDS" for row in runs)),
        str(sum(row.outcome == "FAILS" for row in runs)),
        str(sum(row.sure for row in runs)),
        f"{np.median(kept):.2f}",
        f"{kept.min():.2f}",
        f"{np.mean([row.simulations for row in runs]):.1f}",
        f"{np.mean([row.seconds for row in runs]):.0f}",
    )


def markdown(lines: Sequence[tuple[str, ...]]) -> str:
    """A table of headings and lines."""
    ruled = [lines[0], tuple("---" for _ in lines[0]), *lines[1:]]
    return "".join(f"| {' | '.join(line)} |\n" for line in ruled)


def _block(row: Row) -> tuple[str, str, int]:
    return row.part, row.prompt, row.seed


def _line(row: Row) -> tuple[str, ...]:
    known = (row.part, row.prompt, row.condition, row.arm)
    if row.status != "done":
        return (*known, f"{row.status}: {row.refused}", *("" for _ in SINGLE[5:]))
    heights = (row.plain_flat_height, row.flat_height), (row.plain_nearly_height, row.nearly_height)
    flat, nearly = ([length(height) if height is not None else "–" for height in pair] for pair in heights)
    return (
        *known, row.outcome, "yes" if row.sure else "no", _figure(row.flat_stress, 1), *flat, _figure(row.nearly_stress, 1), *nearly,
        _figure(row.load_factor), _figure(row.safety_factor), f"{row.kept:.2f}", str(row.simulations), f"{row.seconds:.0f}",
    )  # fmt: skip


def _figure(value: float | None, digits: int = 2) -> str:
    """A figure, a dash where it is not known."""
    return "–" if value is None else f"{value:.{digits}f}"


def _draw(axes: Axes, rows: Sequence[Row], title: str) -> None:
    """Kept over arm, a mark for each run, those of one arm spread by their order."""
    shown = [arm for arm in ARMS if any(row.arm == arm for row in rows)]
    for (outcome, (mark, colour)), sure in ((one, sure) for one in OUTCOMES.items() for sure in (True, False)):
        points = []
        for place, arm in enumerate(shown):
            of_arm = sorted((row for row in rows if row.arm == arm), key=lambda row: row.kept)
            spread = np.linspace(-0.3, 0.3, len(of_arm)) if len(of_arm) > 1 else [0.0]
            both = zip(spread, of_arm, strict=True)
            points += [(place + shift, row.kept) for shift, row in both if (row.outcome, row.sure) == (outcome, sure)]
        if points:
            x, y = zip(*points, strict=True)
            label = outcome if sure or outcome == "UNKNOWN" else f"{outcome}, not sure"
            axes.scatter(x, y, marker=mark, s=34, facecolor=colour if sure else "white", edgecolor=colour, linewidth=0.9, label=label)
    axes.set_xticks(range(len(shown)), shown, fontsize=9)
    axes.set_title(title, fontsize=10.5, weight="bold", loc="left")
    axes.set_ylim(-0.02, 1.08)
    axes.set_ylabel("style kept")
    axes.grid(axis="y", color="#e4e4e2", linewidth=0.8)
    if rows:
        axes.legend(fontsize=9, frameon=False, loc="lower left")
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
