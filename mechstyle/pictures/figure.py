"""Parts side by side: titles, one colour bar per field with its threshold, and where the largest value is."""

from __future__ import annotations

import io
import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.text import Text
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import Bbox
from numpy.typing import NDArray

from mechstyle._colour import linear_to_srgb
from mechstyle.errors import BadInput
from mechstyle.pictures.camera import Camera
from mechstyle.pictures.colormap import STRIPE, Scale, hatch
from mechstyle.pictures.scene import BACKGROUND, Field, render
from mechstyle.pictures.visibility import visible
from mechstyle.records.mesh import SurfaceMesh

DPI = 100.0
INK, FAINT = "#1c1c1e", "#5f5f66"
GAP, MARGIN, TITLE, PANEL_TITLE, NOTE, BAR = 14, 18, 44, 30, 20, 102  # heights and gaps [pixels]
BAR_WIDTH, BAR_HEIGHT = 360, 13
FieldKey = tuple[str, str, tuple[float, float] | None, float | None, str]
"""Label, unit, limits, threshold and its name of a field."""


@dataclass(frozen=True, eq=False)
class Panel:
    """One picture of a figure."""

    mesh: SurfaceMesh  # the part; shown in its own colours unless there are values
    title: str = ""  # what it shows
    values: NDArray[np.floating] | None = None  # a field over the vertices [unit], shape [vertex_count], or None
    unit: str = ""  # unit of the field, "" for a pure number, whose extremes are not marked
    label: str = ""  # name of the field; panels of the same label, unit, limits and threshold share one colour bar
    # ends of the colour bar, None for zero (or the least value) to the greatest value of the panels that share it
    limits: tuple[float, float] | None = None
    threshold: float | None = None  # values above it are hatched and outlined, None for no threshold
    view: str | Camera = "three_quarter"  # one of `camera.VIEWS`, or the very camera
    note: str = ""  # a line under the picture
    edge: str = "limit"  # what the threshold is
    marked: bool = True  # whether the extremes of a field that has a unit are marked
    said: Callable[[float], str] | None = None  # how a value at one place is written; as a figure with its unit if None
    peak: int | None = None  # vertex at which the greatest value is marked, None for the first that has it

    @property
    def field(self) -> FieldKey | None:
        """What panels of one colour bar share; None without values."""
        return None if self.values is None else (self.label, self.unit, self.limits, self.threshold, self.edge)


def figure(
    panels: Sequence[Panel], *, columns: int | None = None, title: str = "", panel_size: tuple[int, int] = (480, 480), device: str = "cpu"
) -> Figure:
    """Panels in rows, as a matplotlib figure that depends on no global state.

    Panels of one view whose parts fill nearly the same box share one camera, so that sizes compare.

    Args:
        panels: At least one.
        columns: Panels per row; all in one row up to four by default.
        title: Over all panels.
        panel_size: Width and height of each picture [pixels].
        device: Warp device, "cpu" or "cuda:0".

    Raises:
        BadInput: No panels, an unknown view, or values that do not fit their part.
    """
    if not panels:
        raise BadInput("a figure needs at least one panel")
    across = min(columns or 4, len(panels))
    scales: dict[FieldKey, Scale] = {}  # one for all panels that show a field
    for panel in panels:
        if panel.field is not None and panel.field not in scales:
            shown = [np.ravel(other.values) for other in panels if other.values is not None and other.field == panel.field]
            scales[panel.field] = _scale(np.concatenate(shown), panel.limits, panel.threshold)
    page = _Page.of(len(panels), across, len(scales), panel_size, bool(title), any(panel.note for panel in panels))
    sheet = Figure(figsize=(page.width / DPI, page.height / DPI), dpi=DPI, facecolor=BACKGROUND)
    FigureCanvasAgg(sheet)
    if title:
        sheet.text(MARGIN / page.width, 1 - (MARGIN + 12) / page.height, title, size=13, weight="bold", color=INK, va="center")
    for index, (panel, camera) in enumerate(zip(panels, _cameras(panels, panel_size), strict=True)):
        scale = None if panel.field is None else scales[panel.field]
        axes = page.picture_axes(sheet, index)
        width, height = _pixels(axes)
        shows = None if panel.values is None or scale is None else Field(panel.values, scale)
        picture = render(panel.mesh, camera=camera, width=width, height=height, field=shows, device=device)
        axes.imshow(picture, interpolation="none", extent=(0, width, height, 0), aspect="auto")
        axes.set_axis_off()
        _shorten(axes.text(0, -10, panel.title, size=11, weight="bold", color=INK, va="bottom"), width)
        _shorten(axes.text(0, height + 4, panel.note, size=9.5, color=FAINT, va="top"), width)
        if shows is not None and panel.unit and panel.marked:
            _mark_extremes(axes, panel, camera)
    for index, (field, scale) in enumerate(scales.items()):
        _draw_bar(page.bar_axes(sheet, index), field[0], field[1], scale, field[-1])
    return sheet


def figure_png(panels: Sequence[Panel], **layout: Any) -> bytes:
    """The figure as the bytes of a PNG file; arguments and errors as for `figure`."""
    return png_of(figure(panels, **layout))


def png_of(sheet: Figure) -> bytes:
    """A figure as the bytes of a PNG file."""
    buffer = io.BytesIO()
    sheet.savefig(buffer, format="png", dpi=DPI, facecolor=sheet.get_facecolor(), metadata={"Software": "MechStyle"})
    return buffer.getvalue()


@dataclass(frozen=True)
class _Page:
    """Layout of the sheet [pixels, from the top left]."""

    width: int
    height: int
    columns: int
    top: int
    size: tuple[int, int]
    step: int
    bars_top: int

    @classmethod
    def of(cls, panels: int, columns: int, bars: int, size: tuple[int, int], title: bool, notes: bool) -> _Page:
        rows = -(-panels // columns)
        step = PANEL_TITLE + size[1] + (NOTE if notes else 0) + GAP
        top = MARGIN + (TITLE if title else 0)
        width = max(columns * size[0] + (columns - 1) * GAP, min(bars, 1) * BAR_WIDTH) + 2 * MARGIN
        bars_top = top + rows * step
        bars_across = max((width - 2 * MARGIN) // (BAR_WIDTH + GAP), 1)
        return cls(width, bars_top + BAR * -(-bars // bars_across) + (0 if bars else GAP // 2), columns, top, size, step, bars_top)

    def axes(self, sheet: Figure, left: float, top: float, width: float, height: float) -> Axes:
        return sheet.add_axes((left / self.width, 1 - (top + height) / self.height, width / self.width, height / self.height))

    def picture_axes(self, sheet: Figure, index: int) -> Axes:
        row, column = divmod(index, self.columns)
        left = MARGIN + column * (self.size[0] + GAP)
        return self.axes(sheet, left, self.top + row * self.step + PANEL_TITLE, *self.size)

    def bar_axes(self, sheet: Figure, index: int) -> Axes:
        row, column = divmod(index, max((self.width - 2 * MARGIN) // (BAR_WIDTH + GAP), 1))
        return self.axes(sheet, MARGIN + 8 + column * (BAR_WIDTH + GAP), self.bars_top + row * BAR + 40, BAR_WIDTH - 24, BAR_HEIGHT)


def _scale(values: NDArray[np.floating], limits: tuple[float, float] | None, threshold: float | None) -> Scale:
    if limits is not None:
        return Scale(*limits, threshold)
    known = values[np.isfinite(values)]
    low = min(float(known.min(initial=np.inf)), 0.0) if len(known) else 0.0
    high = float(known.max(initial=-np.inf)) if len(known) else 1.0
    if threshold is not None:
        high = max(high, threshold + 0.05 * abs(threshold - low))
    return Scale(low, high if high > low else low + 1.0, threshold)


def _cameras(panels: Sequence[Panel], size: tuple[int, int]) -> list[Camera]:
    """A camera per panel; panels of one view with nearly the same bounds get the same one."""
    boxes = [np.stack([panel.mesh.vertices.min(axis=0), panel.mesh.vertices.max(axis=0)]) for panel in panels]
    cameras = []
    for panel, box in zip(panels, boxes, strict=True):
        if isinstance(panel.view, Camera):
            cameras.append(replace(panel.view, aspect=size[0] / size[1]))
            continue
        near = [np.abs(others - box).max() <= 0.05 * panel.mesh.size for others in boxes]
        alike = [other.mesh.vertices for other, same in zip(panels, near, strict=True) if same and other.view == panel.view]
        cameras.append(Camera.named(panel.view, np.concatenate(alike), aspect=size[0] / size[1]))
    return cameras


def _shorten(text: Text, width: int) -> None:
    """Leave out words from the end, or letters of the first, until the drawn text is as narrow as `width` [pixels]."""
    words = text.get_text()
    for letters in range(len(words), 0, -1):
        if text.get_window_extent().width <= width:
            return
        cut = textwrap.shorten(words, letters, placeholder=" …")
        text.set_text(cut if cut.strip(" …") else words[:letters] + "…")


def _pixels(axes: Axes) -> tuple[int, int]:
    box = axes.get_window_extent()
    return round(box.width), round(box.height)


def _mark_extremes(axes: Axes, panel: Panel, camera: Camera) -> None:
    """A ring with the value where a measured field is greatest, a triangle where it is least; words say if that is on the far side."""
    values = np.asarray(panel.values, dtype=np.float64)
    if not np.isfinite(values).any() or np.nanmin(values) == np.nanmax(values):
        return
    width, height = _pixels(axes)
    points = camera.project(panel.mesh.vertices)
    depth = visible(points, panel.mesh.faces, width, height).depth
    taken: list[Bbox] = []
    greatest = int(np.nanargmax(values)) if panel.peak is None else panel.peak
    for kind, marker, vertex in (("max", "o", greatest), ("min", "v", int(np.nanargmin(values)))):
        x, y = (points[vertex, 0] + 1) * width / 2, (1 - points[vertex, 1]) * height / 2
        around = depth[max(int(y) - 2, 0) : int(y) + 3, max(int(x) - 2, 0) : int(x) + 3]
        hidden = not (points[vertex, 2] <= around + 0.004 * panel.mesh.size).any()
        size = 9.0 if kind == "max" else 5.0
        faint = 0.5 if hidden else 1.0
        for edge, wide in (("white", 3.2), (INK, 1.4)):
            axes.plot(x, y, marker, ms=size + 2, mfc="none", mec=edge, mew=wide, alpha=faint)
        value = float(values[vertex])
        words = f"{kind} {f'{value:.3g} {panel.unit}'.rstrip() if panel.said is None else panel.said(value)}"
        words += " (far side)" if hidden else ""
        # Next to the mark, towards the middle of the panel and clear of other words if they can be.
        right, inwards = x < width / 2, -1 if y < height / 2 else 1
        label = axes.annotate(words, (x, y), xytext=(0, 0), textcoords="offset points", size=9, color=INK)
        label.set(weight="bold" if kind == "max" else "normal", horizontalalignment="left" if right else "right")
        label.set_path_effects([withStroke(linewidth=3.0, foreground="white", alpha=0.85)])
        for up in (7 * inwards, -7 * inwards, 22 * inwards, -22 * inwards):
            label.set_verticalalignment("bottom" if up > 0 else "top")
            label.xyann = (9 if right else -9, up)
            box: Bbox = label.get_window_extent()
            if not any(box.overlaps(other) for other in taken):
                break
        taken.append(box)


def _draw_bar(axes: Axes, label: str, unit: str, scale: Scale, edge: str) -> None:
    width, height = _pixels(axes)
    values = np.tile(np.linspace(scale.low, scale.high, width), (height, 1))
    colours = linear_to_srgb(scale.colours(values))
    colours[scale.beyond(values) & hatch(height, width, 9)] = STRIPE
    axes.imshow(colours, extent=(scale.low, scale.high, 0, 1), aspect="auto", interpolation="none")
    axes.set_yticks([])
    axes.xaxis.set_major_locator(MaxNLocator(6))
    axes.tick_params(labelsize=9, length=3, color=FAINT, labelcolor=INK)
    for side in axes.spines.values():
        side.set_visible(False)
    name = f"{label} [{unit}]" if unit else label
    axes.text(0, 2.6, name, transform=axes.transAxes, size=9.5, color=INK, va="bottom")
    if scale.split:
        axes.axvline(scale.top, ymin=-0.3, ymax=1.35, color=INK, linewidth=1.4, clip_on=False)
        place = (scale.top - scale.low) / (scale.high - scale.low)
        axes.text(
            min(place, 1.0),
            1.35,
            f"{edge} {scale.top:.3g}",
            transform=axes.transAxes,
            size=9.5,
            weight="bold",
            color=INK,
            va="bottom",
            ha="right" if place > 0.5 else "left",
        )
