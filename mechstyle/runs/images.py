"""Pictures of the user's as a run keeps them: pixels named by their digest, first among cached objects, then in the run directory.

A recipe names a picture by its digest only. The file it came from is read once; a run that is carried on, branched, refined or opened
elsewhere takes the pixels from its own objects.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechstyle._files import write_whole
from mechstyle.errors import BadInput, DamagedStore
from mechstyle.loop.objects import Objects
from mechstyle.loop.store import Store
from mechstyle.records import Recipe
from mechstyle.simulation.part import cached_memo
from mechstyle.styling.drawing.raster import LONGEST, Raster, pixels_of, png_of


def digest_of(image: str | Path | bytes | NDArray[Any]) -> str:
    """The digest of a picture, whose pixels are cached: of a file, its content, an array, or pixels that are cached; "" for "".

    BadInput if it cannot be used.
    """
    if isinstance(image, str) and re.fullmatch("[0-9a-f]{64}", image):
        _pixels(image, _cached())
        return image
    if isinstance(image, str) and not image:
        return ""
    if not isinstance(image, str | Path | bytes | np.ndarray):
        raise BadInput(f"a picture is a file, its bytes or an array, not {type(image).__name__}")
    return _cached().put_array(pixels_of(image))


def raster_of(recipe: Recipe, objects: Objects | None = None) -> Raster | None:
    """The picture of a recipe, None if it has none; from the objects of a run, or cached ones.

    DamagedStore if it is not there, or is no picture.
    """
    return Raster(_pixels(recipe.style.image, objects or _cached())) if recipe.style.image else None


def keep(recipe: Recipe, store: Store) -> None:
    """Put the picture of a recipe into a run directory, also as a file for people: `picture-DIGEST.png`."""
    if not recipe.style.image:
        return
    file = store.root / file_name(recipe.style.image)
    if not (store.objects.path(recipe.style.image).is_file() and file.is_file()):
        pixels = _pixels(recipe.style.image, store.objects if store.objects.path(recipe.style.image).is_file() else _cached())
        store.objects.put_array(pixels)
        write_whole(file, png_of(pixels))


def remember(recipe: Recipe, store: Store) -> None:
    """Cache the picture of a run, so that another run with it can be asked for here."""
    if recipe.style.image:
        _cached().put_array(_pixels(recipe.style.image, store.objects))


def thumbnail(image: str, longest: int = 128) -> bytes:
    """A small PNG of a cached picture, by its digest."""
    pixels = _pixels(image, _cached())
    step = -(-max(pixels.shape[:2]) // longest)
    return png_of(pixels[::step, ::step])


def file_name(image: str) -> str:
    """Name of the file of a picture in a run directory."""
    return f"picture-{image[:8]}.png"


def _cached() -> Objects:
    return cached_memo().objects


def _pixels(digest: str, objects: Objects) -> NDArray[np.uint8] | NDArray[np.uint16]:
    """The pixels of a digest; DamagedStore if they are not there or are none."""
    pixels = objects.get_array(digest)
    channels = {np.dtype(np.uint8): (1, 2, 3, 4), np.dtype(np.uint16): (1,)}.get(pixels.dtype, ())
    if pixels.ndim != 3 or pixels.shape[2] not in channels or not 2 <= min(pixels.shape[:2]) <= max(pixels.shape[:2]) <= LONGEST:
        raise DamagedStore(f"{objects.path(digest)} is no picture: restore it from a copy, or start the run again")
    if pixels.shape[2] in (2, 4) and not pixels[..., -1].any():
        raise DamagedStore(f"{objects.path(digest)} is a picture with nothing in it: restore it from a copy, or start the run again")
    return pixels
