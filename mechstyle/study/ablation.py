"""What each mechanism is worth: the same parts and styles with mechanisms taken away one after the other, counted side by side."""

from __future__ import annotations

import io
import multiprocessing
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from queue import Empty
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np

from mechstyle._files import write_whole
from mechstyle.errors import MechStyleError, unknown
from mechstyle.gallery import load
from mechstyle.pictures.panels import Picture
from mechstyle.records import Judgement
from mechstyle.records.mesh import STANDARD_VERTICES
from mechstyle.runs.recipes import FREESTYLE
from mechstyle.runs.run import Run, stylize

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True)
class Arm:
    """A way to stylize with some of the mechanisms.

    Attributes:
        about: What is left, in words.
        settings: What its recipe has different from the default.
    """

    about: str
    settings: Mapping[str, Any]


ARMS: Mapping[str, Arm] = MappingProxyType(
    {
        "freestyle": Arm("the style alone", FREESTYLE),
        "static": Arm("base and walls bounded, no feedback", {"schedule": "never", "guarantee": False}),
        "masks": Arm("masks while the relief grows, no correction", {"guarantee": False}),
        "full": Arm("masks, then corrections", {}),
        "finish-first": Arm("no masks, corrections of the finished relief", {"schedule": "never"}),
    }
)
"""The arms by name; `static` is the twin without feedback of all that follow it."""

OUTCOMES = {"VIABLE": ("o", "#0072b2"), "FAILS": ("X", "#d55e00"), "UNKNOWN": ("s", "#7a7a80")}
"""Mark and colour of an outcome; told apart in grey by the mark."""


class Row(msgspec.Struct, frozen=True, kw_only=True):
    """One run.

    Attributes:
        part: The model.
        prompt: The style.
        amplitude: Half the relief's depth over local wall thickness; None for the depth that is the default.
        arm: One of `ARMS`.
        verdict: VIABLE, FAILS, UNKNOWN, or "" for a run that was refused.
        marginal: Whether a rule that counts is too close to its limit to be sure.
        as_placed: Stress as placed and under loads over its limit.
        tilted: Stress tilted a little over its limit, None if not run.
        all_orientations: Percentile over all orientations relative to the original, None if not run.
        kept: Share of the freestyle displacement that was kept.
        simulations: Simulations of the styled part.
        original: The original's stress as placed over the yield strength.
        refused: Why there is no run, "" if there is one.
    """

    part: str
    prompt: str
    amplitude: float | None
    arm: str
    verdict: str = ""
    marginal: bool = False
    as_placed: float = 0.0
    tilted: float | None = None
    all_orientations: float | None = None
    kept: float = 0.0
    simulations: int = 0
    original: float = 0.0
    refused: str = ""

    @property
    def a_holds(self) -> bool:
        """Whether the part holds as placed and under its loads."""
        return self.verdict != "UNKNOWN" and self.as_placed <= 1.0


class Cell(msgspec.Struct, frozen=True, kw_only=True):
    """One part, style and depth, for which all arms are run one after the other, so that they share mesh and original.

    Attributes:
        model: A file or `gallery:NAME`.
        prompt: The style.
        amplitude: Half the relief's depth over local wall thickness; None for the depth that is the default.
        arms: Names of `ARMS`.
        out: Folder of the runs.
        vertices: Vertices of the standardised surface.
        device: `auto`, `cpu` or `cuda`.
        settings: Fields of the recipe for all arms.
    """

    model: str
    prompt: str
    amplitude: float | None
    arms: tuple[str, ...]
    out: str
    vertices: int
    device: str
    settings: dict[str, Any]

    def rows(self) -> list[Row]:
        """Run the arms, or read what was run before."""
        return [self._row(arm) for arm in self.arms]

    def _row(self, arm: str) -> Row:
        part = Path(self.model.removeprefix("gallery:")).stem
        known: dict[str, Any] = {"prompt": self.prompt, "amplitude": self.amplitude, "arm": arm}
        folder = Path(self.out) / f"{part}-{'-'.join(self.prompt.split())}-{depth_of(self.amplitude)}" / arm
        deep = {} if self.amplitude is None else {"amplitude": self.amplitude}
        settings = {**self.settings, **deep, **ARMS[arm].settings}
        try:
            run = stylize(
                load(self.model), self.prompt, name=part, out=folder, vertices=self.vertices, device=self.device, **settings
            )
        except MechStyleError as error:
            return Row(part=part, **known, refused=str(error))
        return row_of(run, part=part, **known)


def depth_of(amplitude: float | None) -> str:
    """A depth in words: "default", or half of it over the wall."""
    return "default" if amplitude is None else f"{amplitude:g}"


def _depths(rows: Iterable[Row]) -> list[float | None]:
    """The depths of rows, the default first."""
    return sorted({row.amplitude for row in rows}, key=lambda amplitude: -1.0 if amplitude is None else amplitude)


def row_of(run: Run, **known: Any) -> Row:
    """The figures of a finished run."""
    verdict, summary = run.verdict, run.summary
    return Row(
        **known,
        verdict=verdict.outcome,
        marginal=verdict.marginal,
        as_placed=_use(verdict.as_placed),
        tilted=None if verdict.tilted is None else _use(verdict.tilted),
        all_orientations=None if verdict.all_orientations is None else verdict.all_orientations.value,
        kept=summary.kept,
        simulations=len(summary.simulations),
        original=summary.baseline.peak_stress / run.recipe.material.yield_strength,
    )


def _use(judgement: Judgement) -> float:
    return judgement.value / judgement.limit if judgement.limit else 0.0


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
    tell: Callable[[str], None] = lambda _: None,
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
        tell: Told of each part, style and depth that is done.
        settings: Fields of `Recipe` for all arms.

    Raises:
        BadInput: If there is no such arm.
    """
    chosen = tuple(arms)
    for arm in chosen:
        if arm not in ARMS:
            raise unknown("arm", arm, ARMS)
    shared = {"arms": chosen, "out": str(out), "vertices": vertices, "device": device, "settings": settings}
    cells = [
        Cell(model=model, prompt=prompt, amplitude=amplitude, **shared)  # type: ignore[arg-type]
        for model in models for prompt in prompts for amplitude in amplitudes
    ]  # fmt: skip
    rows = []
    for cell, found in _carried_out(cells, jobs):
        outcomes = ", ".join(f"{row.arm} {row.verdict or row.refused}" for row in found)
        tell(f"{cell.model} as {cell.prompt!r}, depth {depth_of(cell.amplitude)}: {outcomes}")
        rows += found
    depths = _depths(rows)
    return Ablation(sorted(rows, key=lambda row: (depths.index(row.amplitude), row.part, row.prompt, list(ARMS).index(row.arm))))


def _carried_out(cells: Sequence[Cell], jobs: int) -> Iterator[tuple[Cell, list[Row]]]:
    if jobs == 1:
        yield from ((cell, cell.rows()) for cell in cells)
        return
    context = multiprocessing.get_context("spawn")
    with context.Manager() as manager:
        places = manager.Queue()
        for place in range(jobs):
            places.put(place)
        with ProcessPoolExecutor(jobs, mp_context=context, initializer=_take_cores, initargs=(places, jobs)) as pool:
            waiting = {pool.submit(cell.rows): cell for cell in cells}
            yield from ((waiting[done], done.result()) for done in as_completed(waiting))


def _take_cores(places: Any, jobs: int) -> None:
    """Give this process its share of the cores, where the system lets it: threads of several processes on all cores are slower."""
    if not hasattr(os, "sched_setaffinity"):
        return
    try:
        place = places.get_nowait()
    except Empty:  # a process that replaces one that died runs anywhere
        return
    os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[place::jobs] or os.sched_getaffinity(0))


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
            points += [(place + shift, row.kept) for shift, row in zip(spread, of_arm, strict=True) if row.verdict == outcome]
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
