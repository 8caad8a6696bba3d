"""Small pictures of models and styles, drawn in a process of their own the first time and kept in the cache folder."""

from __future__ import annotations

import io
import os
import threading
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mechstyle import __version__
from mechstyle.mesh import SurfaceMesh
from mechstyle.store import write_aside
from mechstyle.workpiece import cache_folder
from mechstyle_widgets.aside import Aside

DRAWING_VERSION = 1
"""Counts changes that alter the pictures, so that those of older code are not shown."""
SIZE = (96, 72)
"""Width and height [pixels]."""
PLATE = 60.0
"""Height of the plate a style is drawn on [mm] …"""
STEP = 0.75
"""… and the distance of its vertices [mm]."""


def model_picture(name: str) -> bytes:
    """A gallery model as PNG."""
    from mechstyle.gallery import make  # noqa: PLC0415 — a process that draws loads what it needs
    from mechstyle.pictures.scene import Camera, render  # noqa: PLC0415

    mesh = make(name)
    width, height = SIZE
    return _png(render(mesh, camera=Camera.named("three_quarter", mesh.vertices, aspect=width / height), width=width, height=height))


def style_picture(name: str) -> bytes:
    """A style on an upright plate, lit from the upper left, as PNG."""
    from mechstyle.styling.canvas import Canvas  # noqa: PLC0415
    from mechstyle.styling.library import style_named  # noqa: PLC0415

    plate, shape = _plate()
    relief = style_named(name).program(Canvas(plate, seed=0, size=2.4))
    height = 2.0 * np.asarray(relief.height).reshape(shape)  # [mm]
    slope_up, slope_right = np.gradient(height, STEP)
    light = np.clip((1.0 + 0.9 * (slope_right - slope_up)) / np.sqrt(1.0 + slope_up**2 + slope_right**2), 0.35, 1.35)
    picture = np.clip(np.asarray(relief.colour).reshape(*shape, 3) * light[..., None], 0.0, 1.0)
    return _png(np.rint(255.0 * picture[::-1]).astype(np.uint8))


DRAWN = {"model": model_picture, "style": style_picture}


def kept(kind: str, name: str) -> bytes | None:
    """The picture if it has been drawn before, else None."""
    path = _place(kind, name)
    return path.read_bytes() if path.is_file() else None


def draw(kind: str, name: str) -> bytes:
    """The picture, drawn if need be."""
    known = kept(kind, name)
    if known is None:
        known = DRAWN[kind](name)
        write_aside(_place(kind, name), known)
    return known


def draw_aside(kind: str, names: Iterable[str], arrived: Callable[[str, bytes], None]) -> Aside | None:
    """Draw what is missing in another process; `arrived` is called with name and picture, in a thread.

    Returns:
        The work, to be stopped by whoever no longer waits; None if nothing is missing.
    """
    missing = [name for name in names if kept(kind, name) is None]
    if not missing:
        return None
    work = Aside(_draw_all, kind, missing)

    def pass_on() -> None:
        for name, picture in work.said():
            arrived(name, picture)

    threading.Thread(target=pass_on, name="mechstyle-pictures", daemon=True).start()
    return work


def _draw_all(say: Callable[[tuple[str, bytes]], None], kind: str, names: list[str]) -> None:
    """What the other process does, out of the way of everything else."""
    os.nice(10)
    for name in names:
        say((name, draw(kind, name)))


def _place(kind: str, name: str) -> Path:
    return cache_folder() / "pictures" / f"{kind}-{name}-{__version__}-{DRAWING_VERSION}.png"


def _plate() -> tuple[SurfaceMesh, tuple[int, int]]:
    """An upright sheet that faces -y, and its rows (from below) and columns."""
    rows, columns = round(PLATE / STEP), round(PLATE * SIZE[0] / SIZE[1] / STEP)
    z, x = np.meshgrid(np.arange(rows) * STEP, np.arange(columns) * STEP, indexing="ij")
    number = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = (part.ravel() for part in (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]))
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return SurfaceMesh(np.stack([x.ravel(), np.zeros(x.size), z.ravel()], axis=1), faces), (rows, columns)


def _png(pixels: NDArray[np.uint8]) -> bytes:
    from matplotlib.image import imsave  # noqa: PLC0415

    buffer = io.BytesIO()
    imsave(buffer, pixels, format="png")
    return buffer.getvalue()
