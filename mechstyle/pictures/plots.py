"""Quantities over time, one above the other, in the look of the figures."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from mechstyle.errors import BadInput
from mechstyle.pictures.figure import DPI, FAINT, INK, png_of
from mechstyle.pictures.scene import BACKGROUND

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#7a7a80")
"""Different to colour-blind people, too (Okabe and Ito 2008)."""

DASHES = ("-", "--", "-.", ":", "-")
WIDTH, HEIGHT = 9.0, 2.35
"""Of a plot, without title and note [inch]."""


@dataclass(frozen=True, eq=False)
class Curve:
    """A line in a plot."""

    label: str  # what it is
    x: ArrayLike  # where it is known, ascending, shape [points]
    y: ArrayLike  # its values, shape [points]
    stepped: bool = False  # whether a value holds from the point before up to its own, as a maximum since then does


@dataclass(frozen=True, eq=False)
class Plot:
    """Curves over one axis."""

    title: str  # what is shown
    unit: str  # unit of the values
    curves: Sequence[Curve]  # at least one
    limit: tuple[float, str] | None = None  # a value to be marked across, with its name; None for none
    mark: tuple[float, float] | None = None  # a point to be marked, as x and y; None for none
    words: str = ""  # what there is to say about it, after the title


def plots_png(plots: Sequence[Plot], *, x_label: str, title: str = "", note: str = "") -> bytes:
    """Plots, at least one, above each other over a common axis with a title and a note below, as the bytes of a PNG file."""
    if not plots:
        raise BadInput("a figure needs at least one plot")
    sheet = Figure(figsize=(WIDTH, HEIGHT * len(plots) + 1.1), dpi=DPI, facecolor=BACKGROUND, layout="constrained")
    FigureCanvasAgg(sheet)
    if title:
        sheet.suptitle(title, size=13, weight="bold", color=INK, x=0.01, ha="left")
    rows = sheet.subplots(len(plots), 1, sharex=True, squeeze=False)[:, 0]
    for axes, plot in zip(rows, plots, strict=True):
        _draw(axes, plot)
    rows[-1].set_xlabel(x_label, size=10, color=INK)
    if note:
        sheet.supxlabel(textwrap.fill(note, 120), size=9.5, color=FAINT, x=0.01, ha="left")
    return png_of(sheet)


def _draw(axes: Axes, plot: Plot) -> None:
    axes.set_facecolor("white")
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    axes.grid(axis="y", color="#e4e4e2", linewidth=0.8)
    axes.tick_params(labelsize=9, color=FAINT, labelcolor=INK)
    axes.set_title(f"{plot.title} [{plot.unit}]", size=10.5, weight="bold", color=INK, loc="left")
    axes.set_title(plot.words, size=9.5, color=INK, loc="right")
    for index, curve in enumerate(plot.curves):
        how: dict[str, Any] = {"color": COLOURS[index % 5], "linestyle": DASHES[index % 5], "linewidth": 1.6, "label": curve.label}
        if curve.stepped:
            axes.step(np.asarray(curve.x), np.asarray(curve.y), where="pre", **how)
        else:
            axes.plot(np.asarray(curve.x), np.asarray(curve.y), **how)
    if plot.limit is not None:
        value, name = plot.limit
        axes.axhline(value, color=INK, linewidth=1.2, linestyle=(0, (6, 3)))
        axes.annotate(
            name,
            (1.0, value),
            xycoords=("axes fraction", "data"),
            xytext=(-2, 3),
            textcoords="offset points",
            ha="right",
            size=9,
            weight="bold",
            color=INK,
        )
    if plot.mark is not None:
        x, y = plot.mark
        axes.plot([x], [y], marker="o", markersize=6, markerfacecolor="white", markeredgecolor=INK, linestyle="none")
    axes.margins(x=0.01)
    axes.set_ylim(bottom=min(axes.get_ylim()[0], 0.0), top=1.08 * axes.get_ylim()[1])
    if len(plot.curves) > 1:
        axes.legend(fontsize=9, frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)
