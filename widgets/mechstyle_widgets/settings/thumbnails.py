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
from mechstyle._files import cache_folder, write_whole
from mechstyle_widgets.jupyter.worker_process import WorkerProcess

DRAWING_VERSION = 2
"""Counts changes that alter the pictures, so that those of older code are not shown."""
SIZE = (96, 72)
"""Width and height of the picture of a model [pixels]."""


def model_picture(name: str) -> bytes:
    """A gallery model as PNG."""
    from mechstyle.gallery import make  # noqa: PLC0415 — a process that draws loads what it needs
    from mechstyle.pictures.scene import Camera, render  # noqa: PLC0415

    mesh = make(name)
    width, height = SIZE
    return png(render(mesh, camera=Camera.named("three_quarter", mesh.vertices, aspect=width / height), width=width, height=height))


def style_picture(name: str) -> bytes:
    """A style on an upright plate as PNG."""
    from mechstyle.gallery.swatches import swatch  # noqa: PLC0415 — as above

    return swatch(name)


DRAWN = {"model": model_picture, "style": style_picture}


def cached(kind: str, name: str) -> bytes | None:
    """The picture if it has been drawn before, else None."""
    path = _place(kind, name)
    return path.read_bytes() if path.is_file() else None


def draw(kind: str, name: str) -> bytes:
    """The picture, drawn if need be."""
    known = cached(kind, name)
    if known is None:
        known = DRAWN[kind](name)
        write_whole(_place(kind, name), known)
    return known


def draw_in_worker(kind: str, names: Iterable[str], arrived: Callable[[str, bytes], None]) -> WorkerProcess | None:
    """Draw what is missing in another process; `arrived` is called with name and picture, in a thread.

    Returns:
        The work, to be stopped by whoever stops waiting; None if nothing is missing.
    """
    missing = [name for name in names if cached(kind, name) is None]
    if not missing:
        return None
    work = WorkerProcess(_draw_all, kind, missing)

    def pass_on() -> None:
        for name, picture in work.said():
            arrived(name, picture)

    threading.Thread(target=pass_on, name="mechstyle-pictures", daemon=True).start()
    return work


def _draw_all(say: Callable[[tuple[str, bytes]], None], kind: str, names: list[str]) -> None:
    """Work of the other process: draw all thumbnails."""
    os.nice(10)
    for name in names:
        say((name, draw(kind, name)))


def _place(kind: str, name: str) -> Path:
    return cache_folder() / "pictures" / f"{kind}-{name}-{__version__}-{DRAWING_VERSION}.png"


def png(pixels: NDArray[np.uint8]) -> bytes:
    """Pixels as PNG."""
    from matplotlib.image import imsave  # noqa: PLC0415

    buffer = io.BytesIO()
    imsave(buffer, pixels, format="png")
    return buffer.getvalue()
