"""Every model of the gallery on one page, as it stands, with its name and its size."""

from __future__ import annotations

import numpy as np

from mechstyle.gallery import make, names
from mechstyle.gallery.style_sheet import LINE, MARGIN, Pixels, lettered, png
from mechstyle.pictures.panels import Picture

SIDE, COLUMNS = 230, 6
"""Side of a picture [pixels], pictures beside each other."""
SHADES = 128
"""Levels of a channel: plain grey shows bands with fewer."""


def model_sheet() -> Picture:
    """A contact sheet of the models with their default measures."""
    from mechstyle.pictures.scene import BACKGROUND, Camera, render  # noqa: PLC0415 — matplotlib is loaded when a picture is wanted

    known = names()
    size = (-(-len(known) // COLUMNS) * (SIDE + LINE) + 2 * MARGIN, COLUMNS * SIDE + 2 * MARGIN)
    page: Pixels = np.broadcast_to(np.rint(255.0 * np.array(BACKGROUND)).astype(np.uint8), (*size, 3)).copy()
    places, labels = [], []
    for number, name in enumerate(known):
        row, column = divmod(number, COLUMNS)
        left, top = MARGIN + column * SIDE, MARGIN + row * (SIDE + LINE)
        mesh = make(name)
        camera = Camera.named("three_quarter", mesh.vertices)
        page[top + LINE : top + LINE + SIDE, left : left + SIDE] = render(mesh, camera=camera, width=SIDE, height=SIDE)
        places.append((left, top))
        labels.append((name.replace("_", " "), f"{mesh.extents.max():.0f} mm"))
    return Picture(png(lettered(page, places, labels), SHADES))
