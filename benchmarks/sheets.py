"""Contact sheets of styles and models, which pages show: run it for docs/styles.png.

python benchmarks/sheets.py --jobs 2     # a quarter of an hour of a core
"""

from __future__ import annotations

import argparse
import io
import multiprocessing
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

from mechstyle.gallery import entry, make
from mechstyle.gallery import names as models
from mechstyle.geometry.thickness import local_thickness
from mechstyle.pictures.colormap import PLAIN
from mechstyle.pictures.figure import DPI, FAINT, INK
from mechstyle.pictures.panels import Picture
from mechstyle.pictures.scene import BACKGROUND, Camera, render
from mechstyle.records.mesh import STANDARD_VERTICES, SurfaceMesh
from mechstyle.runs.recipes import recipe_for
from mechstyle.runs.stylizers import finished_style
from mechstyle.simulation.part import INWARD_SHARE, Shape, standardised
from mechstyle.styling.dimensions import Dimensions, outwards
from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawn import target
from mechstyle.styling.library import names, style_named
from mechstyle.styling.prompt import Wish

PARTS: Mapping[str, Mapping[str, float]] = MappingProxyType({"vase": {}})
"""Models with the measures [mm] that are not their own. One is enough for a page; a style is judged on several."""
CELL, LINE, MARGIN, GAP = 100, 26, 18, 28
"""Side of a picture, height of the line above a row, border of the page, way between its columns [pixels]."""
PICTURED = 25_000
"""Vertices of the parts on the page, whose edges are then about a pixel long: more would take four times as long, to look alike."""
SHADES, COLOURS = 36, 256
"""Levels of a channel, and colours in all: fewer than a screen has take two thirds off the file, and nobody sees it on a textured part."""

Pixels = NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class Specimen:
    """A part to draw styles on, without any simulation."""

    surface: SurfaceMesh  # the standardised surface
    thickness: NDArray[np.float64]  # local wall thickness [mm], shape [vertex_count]

    @classmethod
    def of(cls, mesh: SurfaceMesh, vertices: int = STANDARD_VERTICES) -> Specimen:
        """A closed surface [mm] made ready, from the cache if it was made ready before."""
        surface = standardised(mesh, vertices)
        return cls(surface, local_thickness(surface))

    @cached_property
    def _blank(self) -> Canvas:
        return Canvas(self.surface, 0)  # whose operators and chart all styles share

    def styled(self, wish: Wish) -> tuple[SurfaceMesh, tuple[str, ...]]:
        """The finished style on the part, freely, and what the user should know of the drawing."""
        limits = {"inward": INWARD_SHARE * self.thickness, "outward": outwards(self.thickness)}
        canvas = Dimensions().canvas(self.surface, self.thickness, wish, 0)
        canvas.share(self._blank)
        aim = target(self.surface, wish, Dimensions(), seed=0, thickness=self.thickness, canvas=canvas, **limits)
        return self.surface.displaced(aim.displacement).coloured(aim.colour), aim.notes


def contact_sheet(
    *, styles: Sequence[str] = (), parts: Mapping[str, Mapping[str, float]] = PARTS, vertices: int = PICTURED, columns: int = 4,
    jobs: int = 1,
) -> Picture:  # fmt: skip
    """A row for each style: on every part, coloured and in grey, which shows the relief alone.

    Args:
        styles: Their names; all by default.
        parts: Gallery models and their measures [mm] where they differ from the models' own.
        vertices: Vertices of the standardised surfaces.
        columns: Columns of rows, so that names are read at the width of a page.
        jobs: Processes side by side.
    """
    known = [style_named(name) for name in styles or names()]
    specimens = [Specimen.of(make(part, **measures), vertices) for part, measures in parts.items()]
    with ProcessPoolExecutor(jobs, mp_context=multiprocessing.get_context("spawn")) as pool:
        rows = list(pool.map(partial(_row, specimens), [style.name for style in known]))
    return Picture(_page(rows, [(style.name.replace("_", " "), "") for style in known], columns))


def _row(specimens: Sequence[Specimen], style: str) -> Pixels:
    """A style on every part, shape [CELL, 2 · CELL · parts, 3]."""
    return np.hstack([_pair(specimen.styled(Wish(style))[0]) for specimen in specimens])


def _pair(styled: SurfaceMesh) -> Pixels:
    """A styled part in its colours and, beside it, in plain grey, shape [CELL, 2 · CELL, 3]."""
    camera = Camera.named("three_quarter", styled.vertices)
    grey = np.broadcast_to(PLAIN, styled.vertices.shape)
    return np.hstack([render(styled, camera=camera, width=CELL, height=CELL, colours=colours) for colours in (None, grey)])


def _page(rows: Sequence[Pixels], labels: Sequence[tuple[str, str]], columns: int) -> bytes:
    """The rows below each other in columns, with name and description above each, as PNG."""
    wide, deep = rows[0].shape[1], -(-len(rows) // columns)
    size = (deep * (CELL + LINE) + 2 * MARGIN, min(columns, len(rows)) * (wide + GAP) - GAP + 2 * MARGIN)
    places = [(MARGIN + index // deep * (wide + GAP), MARGIN + index % deep * (CELL + LINE)) for index in range(len(rows))]
    return png(lettered(_placed(size, rows, places), places, labels))


def _placed(size: tuple[int, int], pictures: Sequence[Pixels], places: Sequence[tuple[int, int]], line: int = LINE) -> Pixels:
    """Pictures on a page of a height and width, each below a line [pixels] at its place (left, top)."""
    page: Pixels = np.broadcast_to(np.rint(255.0 * np.array(BACKGROUND)).astype(np.uint8), (*size, 3)).copy()
    for picture, (left, top) in zip(pictures, places, strict=True):
        page[top + line : top + line + picture.shape[0], left : left + picture.shape[1]] = picture
    return page


def lettered(page: Pixels, places: Sequence[tuple[int, int]], labels: Sequence[tuple[str, str]]) -> Figure:
    """The page as a figure of the same pixels, with a name and a description at each place."""
    height, width = page.shape[:2]
    sheet = Figure(figsize=(width / DPI, height / DPI), dpi=DPI)
    axes = sheet.add_axes((0, 0, 1, 1))
    axes.imshow(page, interpolation="none", extent=(0, width, height, 0), aspect="auto")
    axes.set_axis_off()
    for (left, top), (name, description) in zip(places, labels, strict=True):
        base = top + LINE - 8
        title = axes.text(left, base, name, size=11, weight="bold", color=INK)
        axes.annotate(description, (1, 0), xycoords=title, xytext=(9, 0), textcoords="offset points", size=9, color=FAINT, va="bottom")
    return sheet


def png(sheet: Figure) -> bytes:
    """A figure as a PNG of few shades, which packs well."""
    canvas: Any = FigureCanvasAgg(sheet)
    canvas.draw()
    step = 256 // SHADES
    pixels = np.minimum(np.asarray(canvas.buffer_rgba())[..., :3].astype(np.int16) + step // 2, 255) // step * step
    buffer = io.BytesIO()
    few = Image.fromarray(pixels.astype(np.uint8)).quantize(COLOURS, Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    few.save(buffer, "PNG", optimize=True)
    return buffer.getvalue()


SUITS: Mapping[str, str] = MappingProxyType({
    "pen_holder": "brick", "phone_stand": "carbon fibre", "tablet_stand": "herringbone", "spectacle_frame": "leopard",
    "pill_box": "honeycomb", "utensil_grip": "cork", "key_turner": "knurling", "bottle_opener": "hammered", "lampshade": "pleats",
    "vase": "fish scales", "planter": "cactus", "wall_hook": "dragon scales", "s_hook": "bark", "coat_hook": "wood",
    "shelf_bracket": "isogrid", "corner_bracket": "diamond plate", "cable_clip": "studs", "cable_winder": "circuit",
    "key_tag": "celtic knot", "soap_dish": "bubbles", "toothbrush_holder": "tiles", "bag_clip": "zebra", "bag_carrier": "leather",
    "drawer_knob": "crystal", "drawer_organiser": "basket weave", "napkin_ring": "knit", "coaster": "mandala",
    "book_end": "half-timbered", "door_stop": "stone", "tealight_holder": "lava",
})  # fmt: skip
"""A prompt for each model of the gallery, no two alike."""
SIDE, COLUMNS, NAMES = 206, 5, 46
"""Side of a picture, pictures in a row, and height of the two lines above each [pixels]: legible where a page shows them smaller."""


def model_sheet() -> Picture:
    """A contact sheet of the models with their own measures, each in a style that suits it, its suggested regions spared."""
    shown = [_suited(name) for name in models()]
    places = [(MARGIN + index % COLUMNS * SIDE, MARGIN + index // COLUMNS * (SIDE + NAMES)) for index in range(len(shown))]
    size = (-(-len(shown) // COLUMNS) * (SIDE + NAMES) + 2 * MARGIN, COLUMNS * SIDE + 2 * MARGIN)
    sheet = lettered(_placed(size, shown, places, NAMES), (), ())
    for (left, top), name in zip(places, models(), strict=True):
        sheet.axes[0].text(left, top + 16, name.replace("_", " "), size=13, weight="bold", color=INK)
        sheet.axes[0].text(left, top + 36, SUITS[name], size=12, color=FAINT)
    return Picture(png(sheet))


def _suited(name: str) -> Pixels:
    """A model of the gallery in its style, as a run aims at it, shape [SIDE, SIDE, 3]."""
    surface = standardised(make(name), PICTURED)
    shape = Shape(surface, local_thickness(surface).astype(np.float32))
    spared = [region for region in entry(name).protect if not region.startswith("inside")]  # which stays plain by itself, colour and all
    style = finished_style(shape, recipe_for(SUITS[name], protect=spared))
    assert style is not None, "a style that is drawn is known before it is run"
    styled = surface.displaced(style.relief).coloured(style.colour)
    return render(styled, camera=Camera.named("three_quarter", styled.vertices), width=SIDE, height=SIDE)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--jobs", type=int, default=1)
    contact_sheet(jobs=parser.parse_args().jobs).save(Path(__file__).parents[1] / "docs" / "styles.png")
