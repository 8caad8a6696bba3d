"""Pictures of styles and models: contact sheets, and the list of styles, each on a small plate drawn once and kept in the cache folder."""

from __future__ import annotations

import base64
import hashlib
import html
import io
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mechstyle import styling
from mechstyle._files import cache_folder, write_whole
from mechstyle.fea.explicit import no_progress
from mechstyle.gallery import make
from mechstyle.gallery import names as models
from mechstyle.geometry.thickness import local_thickness
from mechstyle.pictures.panels import Picture
from mechstyle.records.mesh import STANDARD_VERTICES, SurfaceMesh
from mechstyle.simulation.part import INWARD_SHARE, Stage, standardised
from mechstyle.styling.dimensions import Dimensions, outwards
from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawn import target
from mechstyle.styling.library import library, names, style_named
from mechstyle.styling.prompt import Wish
from mechstyle.styling.style import Style
from mechstyle.styling.vocabulary import called

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PARTS: Mapping[str, Mapping[str, float]] = MappingProxyType({
    "vase": {}, "phone_stand": {}, "lampshade": {"wall": 1.5}, "utensil_grip": {},
    "pen_holder": {"diameter": 30.0, "height": 30.0, "wall": 1.2, "base": 1.2},
})  # fmt: skip
"""Models with the measures [mm] that are not their own: a curved, a prismatic, a thin, an organic and a small part."""
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
    *, styles: Sequence[str] = (), parts: Mapping[str, Mapping[str, float]] = PARTS, vertices: int = PICTURED, columns: int = 2,
    stage: Stage = no_progress,
) -> Picture:  # fmt: skip
    """A row for each style: on every part, coloured and in grey, which shows the relief alone.

    Args:
        styles: Their names; all by default.
        parts: Gallery models and their measures [mm] where they differ from the models' own.
        vertices: Vertices of the standardised surfaces.
        columns: Columns of rows, so that the page is not a ribbon.
        stage: Called with what is being drawn.

    Raises:
        BadInput: An unknown style or model.
    """
    known = [style_named(name) for name in styles or names()]
    specimens = []
    for part, measures in parts.items():
        stage(f"preparing {part}")
        specimens.append(Specimen.of(make(part, **measures), vertices))
    rows = []
    for style in known:
        stage(style.name)
        rows.append(np.hstack([_pair(specimen.styled(Wish(style.name))[0]) for specimen in specimens]))
    return Picture(_page(rows, [(style.name.replace("_", " "), style.description) for style in known], columns))


def _pair(styled: SurfaceMesh) -> Pixels:
    """A styled part in its colours and, beside it, in plain grey, shape [CELL, 2 · CELL, 3]."""
    from mechstyle.pictures.colormap import PLAIN  # noqa: PLC0415 — matplotlib is loaded when a picture is wanted
    from mechstyle.pictures.scene import Camera, render  # noqa: PLC0415 — as above

    camera = Camera.named("three_quarter", styled.vertices)
    grey = np.broadcast_to(PLAIN, styled.vertices.shape)
    return np.hstack([render(styled, camera=camera, width=CELL, height=CELL, colours=colours) for colours in (None, grey)])


def _page(rows: Sequence[Pixels], labels: Sequence[tuple[str, str]], columns: int) -> bytes:
    """The rows below each other in columns, with name and description above each, as PNG."""
    wide, deep = rows[0].shape[1], -(-len(rows) // columns)
    size = (deep * (CELL + LINE) + 2 * MARGIN, min(columns, len(rows)) * (wide + GAP) - GAP + 2 * MARGIN)
    places = [(MARGIN + index // deep * (wide + GAP), MARGIN + index % deep * (CELL + LINE)) for index in range(len(rows))]
    return _laid_out(size, rows, places, labels, SHADES)


def _laid_out(
    size: tuple[int, int], pictures: Sequence[Pixels], places: Sequence[tuple[int, int]], labels: Sequence[tuple[str, str]], shades: int
) -> bytes:
    """Pictures on a page of a height and width, each below its label at a place (left, top), as PNG."""
    from mechstyle.pictures.scene import BACKGROUND  # noqa: PLC0415 — as above

    page: Pixels = np.broadcast_to(np.rint(255.0 * np.array(BACKGROUND)).astype(np.uint8), (*size, 3)).copy()
    for picture, (left, top) in zip(pictures, places, strict=True):
        page[top + LINE : top + LINE + picture.shape[0], left : left + picture.shape[1]] = picture
    return png(lettered(page, places, labels), shades)


def lettered(page: Pixels, places: Sequence[tuple[int, int]], labels: Sequence[tuple[str, str]]) -> Figure:
    """The page as a figure of the same pixels, with a name and a description at each place."""
    from matplotlib.figure import Figure  # noqa: PLC0415 — as above

    from mechstyle.pictures.figure import DPI, FAINT, INK  # noqa: PLC0415

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


def png(sheet: Figure, shades: int = SHADES) -> bytes:
    """A figure as a PNG of few shades, which packs well."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415 — as above
    from PIL import Image  # noqa: PLC0415

    canvas: Any = FigureCanvasAgg(sheet)
    canvas.draw()
    step = 256 // shades
    pixels = np.minimum(np.asarray(canvas.buffer_rgba())[..., :3].astype(np.int16) + step // 2, 255) // step * step
    buffer = io.BytesIO()
    few = Image.fromarray(pixels.astype(np.uint8)).quantize(COLOURS, Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    few.save(buffer, "PNG", optimize=True)
    return buffer.getvalue()


SIDE, COLUMNS = 230, 6
"""Side of a picture [pixels], pictures beside each other."""
GREYS = 128
"""Levels of a channel: plain grey shows bands with fewer."""


def model_sheet() -> Picture:
    """A contact sheet of the models with their default measures."""
    from mechstyle.pictures.scene import Camera, render  # noqa: PLC0415 — matplotlib is loaded when a picture is wanted

    size = (-(-len(models()) // COLUMNS) * (SIDE + LINE) + 2 * MARGIN, COLUMNS * SIDE + 2 * MARGIN)
    pictures, places, labels = [], [], []
    for number, name in enumerate(models()):
        row, column = divmod(number, COLUMNS)
        places.append((MARGIN + column * SIDE, MARGIN + row * (SIDE + LINE)))
        mesh = make(name)
        pictures.append(render(mesh, camera=Camera.named("three_quarter", mesh.vertices), width=SIDE, height=SIDE))
        labels.append((name.replace("_", " "), f"{mesh.extents.max():.0f} mm"))
    return Picture(_laid_out(size, pictures, places, labels, GREYS))


PLATE_ROWS, PLATE_COLUMNS = 80, 107
"""Vertices of the plate from below and from the left, and pixels of its picture."""
PLATE_STEP = 0.75
"""Distance of neighbouring vertices [mm]."""
PLATE_SIZE, PLATE_HEIGHT = 2.4, 2.0
"""Factor on the size of features, which suit a part of 100 mm, and what a relief of 1 stands for [mm]."""


@dataclass(frozen=True)
class Styles:
    """The offline styles, with their pictures in a notebook."""

    known: tuple[Style, ...]  # the styles by name

    def __iter__(self) -> Iterator[Style]:
        """The styles in order."""
        return iter(self.known)

    def __len__(self) -> int:
        """Number of styles."""
        return len(self.known)

    def __repr__(self) -> str:
        """A line for each."""
        wide = max(len(style.name) for style in self.known)
        return "\n".join(f"{style.name:<{wide}}  {style.description}" for style in self.known)

    def _repr_html_(self) -> str:
        head = "".join(f'<th scope="col" style="text-align:left">{title}</th>' for title in ("", "style", "also called", "what it is"))
        return f"<table><thead><tr>{head}</tr></thead><tbody>{''.join(map(_row, self.known))}</tbody></table>"


def styles() -> Styles:
    """The offline styles; as the last expression of a notebook cell they are shown with pictures, which takes seconds the first time.

    Example:
        >>> ms.styles()
        art_deco       overlapping fans of golden rays on black
        bamboo         upright green canes side by side, with rings at their joints
        ...
    """
    return Styles(tuple(library().values()))


def _row(style: Style) -> str:
    picture = base64.b64encode(swatch(style.name)).decode()
    words = ", ".join(word.replace("_", " ") for word in called(style.name))
    size = f'width="{PLATE_COLUMNS}" height="{PLATE_ROWS}"'
    image = f'<img alt="{html.escape(style.name)}" {size} src="data:image/png;base64,{picture}">'
    cells = (image, f"<b>{html.escape(style.name)}</b>", html.escape(words), html.escape(style.description))
    return "<tr>" + "".join(f'<td style="text-align:left">{cell}</td>' for cell in cells) + "</tr>"


def swatch(name: str) -> bytes:
    """A style on an upright plate as PNG: drawn now, or as it was drawn before by the same code.

    Raises:
        BadInput: If there is no such style.
    """
    path = cache_folder() / "pictures" / f"swatch-{name}-{_code()[:16]}.png"
    if not path.is_file():
        write_whole(path, _drawn(style_named(name)))
    return path.read_bytes()


@cache
def _code() -> str:
    """Digest of what draws styles, so that a picture of older code is not shown."""
    folder = Path(styling.__path__[0])
    digest = hashlib.sha256(Path(__file__).read_bytes())
    for path in sorted(folder.rglob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _drawn(style: Style) -> bytes:
    """The plate seen from the front, lit from the upper left."""
    from matplotlib.image import imsave  # noqa: PLC0415 — loaded when a picture is wanted

    relief = style.program(Canvas(_plate(), seed=0, size=PLATE_SIZE))
    slope_up, slope_right = np.gradient(PLATE_HEIGHT * relief.height.reshape(PLATE_ROWS, PLATE_COLUMNS), PLATE_STEP)
    light = (1.0 + 0.9 * (slope_right - slope_up)) / np.sqrt(1.0 + slope_up**2 + slope_right**2)
    pixels = np.clip(relief.colour.reshape(PLATE_ROWS, PLATE_COLUMNS, 3) * np.clip(light, 0.35, 1.35)[..., None], 0.0, 1.0)
    buffer = io.BytesIO()
    imsave(buffer, np.rint(255.0 * pixels[::-1]).astype(np.uint8), format="png")
    return buffer.getvalue()


def _plate() -> SurfaceMesh:
    """An upright sheet that faces -y, its vertices row by row from below."""
    z, x = (PLATE_STEP * grid for grid in np.mgrid[:PLATE_ROWS, :PLATE_COLUMNS])
    number = np.arange(PLATE_ROWS * PLATE_COLUMNS).reshape(PLATE_ROWS, PLATE_COLUMNS)
    a, b, c, d = (part.ravel() for part in (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]))
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return SurfaceMesh(np.stack([x.ravel(), np.zeros(x.size), z.ravel()], axis=1), faces)
