"""The list of the offline styles in a notebook, each drawn once on a small plate, which is kept in the cache folder."""

from __future__ import annotations

import base64
import hashlib
import html
import io
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from mechstyle import styling
from mechstyle._files import cache_folder, write_whole
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.library import library, style_named
from mechstyle.styling.style import Style
from mechstyle.styling.vocabulary import called

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
