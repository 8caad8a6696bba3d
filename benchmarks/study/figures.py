"""Figures of a study for print: static, colour-safe, marks beside colours, n in every panel, the published value as an open diamond."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from scipy import stats

from benchmarks.study.cells import Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INK, PASSES, FAILS, UNKNOWN = "#202020", "#0072b2", "#d55e00", "#7a7a80"
OUTCOMES = {"HOLDS": ("✓", PASSES), "NO WORSE": ("≈", "#009e73"), "FAILS": ("✗", FAILS)}
"""Mark and colour of an outcome."""
MARKS = {"linear": ("o", "#0072b2"), "exponential": ("s", "#009e73"), "frozen": ("^", "#cc79a7"), "none": ("D", "#7a7a80")}
"""Mark and colour of a control (Okabe and Ito), each with a mark of its own in grey."""
WIDE, DPI = 7.0, 200
"""Width of a figure across two columns [inch], dots per inch."""


def wilson(count: int, total: int) -> tuple[float, float]:
    """Wilson's score interval of a proportion at 95 % (Wilson 1927)."""
    found = stats.binomtest(count, total).proportion_ci(0.95, method="wilson")
    return float(found.low), float(found.high)


def matrix(rows: Sequence[Row], title: str) -> bytes:
    """Every part in every style: what stays bent in the worst test [mm], with a mark and a colour for the outcome, as PNG."""
    from matplotlib.patches import Rectangle  # noqa: PLC0415 — loaded when a picture is wanted

    parts, styles = (list(dict.fromkeys(values)) for values in ([row.part for row in rows], [row.prompt for row in rows]))
    page, axes = _sheet(WIDE, 0.9 + 0.24 * len(parts))
    place = {(row.part, row.prompt): row for row in rows}
    for (y, part), (x, style) in ((one, other) for one in enumerate(parts) for other in enumerate(styles)):
        row = place.get((part, style))
        text, colour = ("–", UNKNOWN) if row is None else _cell(row)
        axes.add_patch(Rectangle((x - 0.48, y - 0.46), 0.96, 0.92, facecolor=colour, alpha=0.28, linewidth=0))
        axes.text(x, y, text, ha="center", va="center", size=7.5, color=INK)
    axes.set_xlim(-0.5, len(styles) - 0.5)
    axes.set_ylim(len(parts) - 0.5, -0.5)
    axes.set_xticks(range(len(styles)), styles, size=8)
    axes.xaxis.tick_top()
    axes.set_yticks(range(len(parts)), [part.replace("_", " ") for part in parts], size=8)
    axes.tick_params(length=0)
    axes.set_title(f"{title}, n = {sum(row.status == 'done' for row in rows)}", size=9, loc="left", weight="bold", pad=18)
    for side in axes.spines.values():
        side.set_visible(False)
    return _png(page)


def passing(rows: Sequence[Row], published: dict[str, float]) -> bytes:
    """Share of the runs of each arm that pass, with Wilson's interval, and the published value where there is one, as PNG."""
    arms = list(dict.fromkeys(row.arm for row in rows))
    page, axes = _sheet(WIDE, 0.9 + 0.26 * len(arms))
    for y, arm in enumerate(arms):
        done = [row for row in rows if row.arm == arm and row.status == "done"]
        if not done:
            continue
        count = sum(row.passes for row in done)
        low, high = wilson(count, len(done))
        mark, colour = MARKS.get(done[0].control, ("o", INK))
        axes.plot([100 * low, 100 * high], [y, y], color=colour, linewidth=1.4)
        axes.plot(100 * count / len(done), y, marker=mark, color=colour, markersize=5)
        if arm in published:
            axes.plot(published[arm], y, marker="D", markersize=7, markerfacecolor="none", markeredgecolor=INK)
        axes.text(102, y, f"{count} of {len(done)}", va="center", size=7.5)
    _named(axes, arms)
    axes.set_xlim(-2, 100)
    axes.set_xlabel("passes [%], 95 % Wilson interval; open diamond: published", size=8)
    return _png(page)


def spread(rows: Sequence[Row], field: str, label: str, *, log: bool = False) -> bytes:
    """Every run of each arm as a point over a field of its row, the median as a bar, as PNG."""
    from matplotlib.ticker import LogLocator  # noqa: PLC0415 — loaded when a picture is wanted

    arms = list(dict.fromkeys(row.arm for row in rows))
    page, axes = _sheet(WIDE, 0.9 + 0.26 * len(arms))
    for y, arm in enumerate(arms):
        done = [row for row in rows if row.arm == arm and row.status == "done"]
        values = np.sort([float(getattr(row, field)) for row in done])
        if not len(values):
            continue
        mark, colour = MARKS.get(done[0].control, ("o", INK))
        shift = 0.3 * (np.arange(len(values)) % 3 - 1) if len(values) > 1 else 0.0
        axes.scatter(values, y + np.asarray(shift), marker=mark, s=12, facecolor=colour, edgecolor="white", linewidth=0.3)
        axes.plot([np.median(values)] * 2, [y - 0.4, y + 0.4], color=INK, linewidth=1.2)
        axes.text(1.01, y, f"n = {len(values)}", va="center", size=7.5, transform=axes.get_yaxis_transform())
    _named(axes, arms)
    if log:
        axes.set_xscale("log")
        axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axes.xaxis.set_major_formatter("{x:g}")
        axes.xaxis.set_minor_formatter("")
    axes.set_xlabel(f"{label}; bar: median", size=8)
    return _png(page)


def _cell(row: Row) -> tuple[str, str]:
    """Text and colour of a run: its mark stands in brackets where the outcome is not sure."""
    if row.status != "done":
        return row.status, UNKNOWN
    mark, colour = OUTCOMES.get(row.outcome, ("?", UNKNOWN))
    bend = "–" if row.permanent_set is None else f"{row.permanent_set:.2f}"
    return f"{bend} {mark}" if row.sure or mark == "?" else f"{bend} ({mark})", colour


def _sheet(width: float, height: float) -> tuple[Figure, Axes]:
    """A white sheet [inch] with axes."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415 — as above
    from matplotlib.figure import Figure  # noqa: PLC0415

    page = Figure(figsize=(width, height), dpi=DPI, facecolor="white", layout="constrained")
    FigureCanvasAgg(page)
    return page, page.subplots()


def _named(axes: Axes, arms: Sequence[str]) -> None:
    axes.set_yticks(range(len(arms)), arms, size=8)
    axes.set_ylim(len(arms) - 0.4, -0.6)
    axes.tick_params(axis="x", labelsize=8)
    axes.grid(axis="x", color="#e4e4e2", linewidth=0.7)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def _png(page: Figure) -> bytes:
    """A sheet as PNG."""
    buffer = io.BytesIO()
    page.savefig(buffer, format="png", metadata={"Software": "MechStyle"})
    return buffer.getvalue()
