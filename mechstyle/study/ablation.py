"""What each mechanism is worth: the same parts and styles with mechanisms taken away one after the other, counted side by side."""

from __future__ import annotations

import io
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np

from mechstyle._files import write_whole
from mechstyle.errors import unknown
from mechstyle.gallery import load
from mechstyle.pictures.panels import Picture
from mechstyle.records.mesh import STANDARD_VERTICES
from mechstyle.runs.recipes import draft
from mechstyle.study.cells import Cell, Row
from mechstyle.study.grids import ARMS
from mechstyle.study.walk import Tell, walk

if TYPE_CHECKING:
    from matplotlib.axes import Axes


OUTCOMES = {"VIABLE": ("o", "#0072b2"), "MARGINAL": ("^", "#f5b82e"), "FAILS": ("X", "#d55e00"), "UNKNOWN": ("s", "#7a7a80")}
"""Mark and colour of an outcome, MARGINAL of one that is not sure; told apart in grey by the mark."""


def depth_of(amplitude: float | None) -> str:
    """A depth in words: "default", or half of it over the wall."""
    return "default" if amplitude is None else f"{amplitude:g}"


def _depths(rows: Iterable[Row]) -> list[float | None]:
    """The depths of rows, the default first."""
    return sorted({row.amplitude for row in rows}, key=lambda amplitude: -1.0 if amplitude is None else amplitude)


@dataclass(frozen=True)
class Ablation:
    """All runs of an ablation.

    Attributes:
        rows: One for each part, style, depth and arm.
    """

    rows: Sequence[Row]

    def summary(self) -> list[tuple[str, ...]]:
        """Headings, then a line for each depth and arm: how many hold under which rule, and what is kept of the style."""
        lines: list[tuple[str, ...]] = [
            ("depth", "arm", "runs", "viable", "as placed", "tilted", "all orientations", "marginal", "kept", "least", "simulations")
        ]
        for amplitude in _depths(self.rows):
            for arm in ARMS:
                told = [row for row in self.rows if (row.amplitude, row.arm) == (amplitude, arm) and not row.refused]
                if told:
                    lines.append((depth_of(amplitude), arm, *_counted(told)))
        return lines

    def table(self) -> str:
        """The summary, then every run, as Markdown."""
        single: list[tuple[str, ...]] = [
            ("part", "style", "depth", "arm", "verdict", "as placed", "tilted", "all orientations", "kept", "simulations")
        ]
        single += [_line(row) for row in self.rows]
        return f"{_markdown(self.summary())}\n{_markdown(single)}"

    def show(self) -> Picture:
        """What is kept of every style, arm by arm, and whether the part survives."""
        from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415 — loaded when a picture is wanted
        from matplotlib.figure import Figure  # noqa: PLC0415

        depths = _depths(self.rows)
        sheet = Figure(figsize=(2.0 + 4.2 * len(depths), 4.4), dpi=110, facecolor="white", layout="constrained")
        FigureCanvasAgg(sheet)
        for axes, depth in zip(sheet.subplots(1, len(depths), sharey=True, squeeze=False)[0], depths, strict=True):
            title = "default relief" if depth is None else f"relief {depth:g} of the wall"
            _draw(axes, [row for row in self.rows if row.amplitude == depth and not row.refused], title)
        buffer = io.BytesIO()
        sheet.savefig(buffer, format="png", metadata={"Software": "MechStyle"})
        return Picture(buffer.getvalue())

    def save(self, folder: Path) -> dict[str, str]:
        """Write `ablation.md`, `ablation.json` and `ablation.png`; what each file is, and its path."""
        write_whole(folder / "ablation.md", self.table().encode())
        write_whole(folder / "ablation.json", msgspec.json.format(msgspec.json.encode(list(self.rows)), indent=1))
        picture = self.show().save(folder / "ablation.png")
        return {"table": str(folder / "ablation.md"), "rows": str(folder / "ablation.json"), "picture": str(picture)}


def ablation(
    models: Iterable[str],
    prompts: Iterable[str],
    out: str | Path,
    *,
    amplitudes: Iterable[float | None] = (None,),
    arms: Iterable[str] = tuple(ARMS),
    vertices: int = STANDARD_VERTICES,
    device: str = "auto",
    jobs: int = 1,
    tell: Tell = lambda _: None,
    **settings: Any,
) -> Ablation:
    """Run every arm on every part, style and depth; what was run before in the folder is not run again.

    Args:
        models: Files or `gallery:NAME`.
        prompts: Styles, in words.
        out: Folder for the runs.
        amplitudes: Half the relief's depth over local wall thickness, for each depth; None is the depth that is the default.
        arms: Names of `ARMS`.
        vertices: Vertices of the standardised surface.
        device: `auto`, `cpu` or `cuda`.
        jobs: Processes side by side.
        tell: Told of each row that is there.
        settings: Fields of `Recipe` for all arms.

    Raises:
        BadInput: If there is no such arm, or a model cannot be used.
    """
    models, cells = list(models), []
    for model in dict.fromkeys(models):
        load(model)  # one that cannot be used is refused before hours are spent on the others
    for model, prompt, amplitude, arm in product(models, prompts, amplitudes, arms):
        if arm not in ARMS:
            raise unknown("arm", arm, ARMS)
        deep = {} if amplitude is None else {"amplitude": amplitude}
        recipe = draft(prompt, **{**settings, **deep, **ARMS[arm].settings})
        cell = Cell(model=model, arm=arm, recipe=recipe, vertices=vertices, device=device)
        folder = f"{cell.part}-{'-'.join(prompt.split())}-{depth_of(amplitude)}/{arm}"
        cells.append(msgspec.structs.replace(cell, folder=folder))
    rows = walk(cells, out, jobs=jobs, tell=tell)
    depths = _depths(rows)
    return Ablation(sorted(rows, key=lambda row: (depths.index(row.amplitude), row.part, row.prompt, list(ARMS).index(row.arm))))


def _counted(told: Sequence[Row]) -> tuple[str, ...]:
    kept = np.array([row.kept for row in told])
    tilted = [row.tilted for row in told if row.tilted is not None]
    turned = [row.all_orientations for row in told if row.all_orientations is not None]
    viable = sum(row.verdict == "VIABLE" for row in told)
    return (
        str(len(told)),
        f"{viable / len(told):.0%}",
        f"{sum(row.a_holds for row in told) / len(told):.0%}",
        f"{sum(use <= 1.0 for use in tilted) / len(tilted):.0%}" if tilted else "–",
        f"median {np.median(turned):.2f}" if turned else "–",
        str(sum(row.marginal for row in told)),
        f"{np.median(kept):.2f}",
        f"{kept.min():.2f}",
        f"{np.mean([row.simulations for row in told]):.1f}",
    )


def _line(row: Row) -> tuple[str, ...]:
    known = (row.part, row.prompt, depth_of(row.amplitude), row.arm)
    if row.refused:
        return (*known, f"refused: {row.refused}", "", "", "", "", "")
    tilted, turned = (("–" if value is None else f"{value:.2f}") for value in (row.tilted, row.all_orientations))
    outcome = row.verdict + (", marginal" if row.marginal else "")
    return (*known, outcome, f"{row.as_placed:.2f}", tilted, turned, f"{row.kept:.2f}", str(row.simulations))


def _word(row: Row) -> str:
    """The outcome of a run in one word, a key of OUTCOMES."""
    return "MARGINAL" if row.marginal else row.verdict


def _markdown(lines: Sequence[tuple[str, ...]]) -> str:
    ruled = [lines[0], tuple("---" for _ in lines[0]), *lines[1:]]
    return "".join(f"| {' | '.join(line)} |\n" for line in ruled)


def _draw(axes: Axes, rows: Sequence[Row], title: str) -> None:
    """Kept over arm, a mark for each run, those of one arm spread by their order."""
    shown = [arm for arm in ARMS if any(row.arm == arm for row in rows)]
    for outcome, (mark, colour) in OUTCOMES.items():
        points = []
        for place, arm in enumerate(shown):
            of_arm = sorted((row for row in rows if row.arm == arm), key=lambda row: row.kept)
            spread = np.linspace(-0.3, 0.3, len(of_arm)) if len(of_arm) > 1 else [0.0]
            points += [(place + shift, row.kept) for shift, row in zip(spread, of_arm, strict=True) if _word(row) == outcome]
        if points:
            x, y = zip(*points, strict=True)
            axes.scatter(x, y, marker=mark, s=34, facecolor=colour, edgecolor="white", linewidth=0.6, label=outcome.lower())
    axes.set_xticks(range(len(shown)), shown, fontsize=9)
    axes.set_title(title, fontsize=10.5, weight="bold", loc="left")
    axes.set_ylim(-0.02, 1.08)
    axes.set_ylabel("style kept")
    axes.grid(axis="y", color="#e4e4e2", linewidth=0.8)
    axes.legend(fontsize=9, frameon=False, loc="lower left")
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
