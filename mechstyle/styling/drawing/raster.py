"""A picture of the user's as heights and colours that can be looked up at any scale.

PNG and JPEG files, and arrays, become the pixels a run keeps: grey in 8 or 16 bits, or colours in 8, with alpha where there is any.
"""

from __future__ import annotations

import io
import struct
import warnings
import zlib
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageOps, UnidentifiedImageError
from scipy import ndimage

from mechstyle.errors import BadInput, absent
from mechstyle.records.mesh import Bools, Floats
from mechstyle.styling.drawing.colours import luminance

_SHADES = {1: 0.02, 2: 0.001}  # range of grey, by bytes, below which a picture is of one shade, and its outline is what counts
_AVERAGED = 0.4  # deviation of the Gaussian over which is averaged, over what one place stands for
_MEASURED = 512  # pixels along the longer side at which widths are measured
_LOST = 0.1  # of its light or dark area a picture may lose where it is finer than what is measured with
_RADII = (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 32.0)


class Sample(NamedTuple):
    """What a picture shows at some places."""

    height: Floats  # in [-1, 1] from its darkest to its lightest, shape [n]
    colour: Floats  # display RGB in [0, 1], shape [n, 3]
    cover: Floats  # how much of the picture there is, 0 where it is transparent, shape [n]


class Raster:
    """Heights and colours of a picture.

    Attributes:
        aspect: Height over width.
        shaded: Whether there is light and dark in it; else its outline is all of its relief.
        clear: Whether it is transparent somewhere.
    """

    def __init__(self, pixels: NDArray[np.uint8] | NDArray[np.uint16]) -> None:
        """Take the pixels as `pixels_of` makes them, shape [height, width, 1 to 4]."""
        levels = pixels.astype(np.float32) / np.float32(np.iinfo(pixels.dtype).max)
        self.clear = pixels.shape[2] in (2, 4)
        cover = levels[..., -1] if self.clear else np.ones(levels.shape[:2], np.float32)
        colour = levels[..., :-1] if self.clear else levels
        colour = np.repeat(colour, 3, axis=2) if colour.shape[2] == 1 else colour
        grey = luminance(colour.astype(np.float64))
        low, high = float(grey[cover > 0.0].min()), float(grey[cover > 0.0].max())
        self.shaded = high - low >= _SHADES[pixels.dtype.itemsize]
        height = 2.0 * (grey - low) / (high - low) - 1.0 if self.shaded else np.ones_like(grey)
        self.aspect = levels.shape[0] / levels.shape[1]
        premultiplied = np.concatenate([height[..., None], colour], axis=2) * cover[..., None]
        self._layers = np.concatenate([premultiplied, cover[..., None]], axis=2).astype(np.float32)
        self._softened = lru_cache(maxsize=4)(self._soften)

    def at(self, u: Floats, v: Floats, footprint: float, *, repeated: bool) -> Sample:
        """What the picture shows at places across and up it, in its widths and heights from its middle, shape [n].

        Detail finer than `footprint`, in widths, is averaged. Unless it is repeated without end there is nothing beside it.
        """
        rows, columns = self._layers.shape[:2]
        layers, margin = self._softened(round(_AVERAGED * footprint * columns, 2), repeated)
        down, right = (0.5 - v) * rows - 0.5 + margin, (0.5 + u) * columns - 0.5 + margin
        mode = "grid-wrap" if repeated else "constant"
        found = np.stack([ndimage.map_coordinates(layer, [down, right], order=1, mode=mode) for layer in np.moveaxis(layers, 2, 0)], axis=1)
        cover = np.clip(found[:, 4], 0.0, 1.0)
        shown = found[:, :4] / np.maximum(cover, 1e-6)[:, None]
        return Sample(np.clip(shown[:, 0], -1.0, 1.0), np.clip(shown[:, 1:], 0.0, 1.0), cover)

    def _soften(self, sigma: float, repeated: bool) -> tuple[NDArray[np.float32], int]:
        """The layers averaged over a Gaussian of so many pixels, and the margin that was put around them."""
        margin = 0 if repeated else int(np.ceil(3.0 * sigma)) + 1
        layers = np.pad(self._layers, ((margin, margin), (margin, margin), (0, 0)))
        if sigma < 0.3:
            return layers, margin
        mode = "grid-wrap" if repeated else "constant"
        return np.asarray(ndimage.gaussian_filter(layers, (sigma, sigma, 0.0), mode=mode, truncate=3.0), np.float32), margin

    @cached_property
    def detail(self) -> float:
        """Usual width of light and dark in it, in its widths: twice its area over the length of its contours, weighed by contrast."""
        height = self._solid
        down, right = (np.roll(height, -1, axis) - height for axis in (0, 1))
        slope = float(np.hypot(down, right).mean())
        return min(2.0 / (max(slope, 1e-9) * height.shape[1]), 1.0)

    @cached_property
    def finest(self) -> float:
        """Width of its finest parts, in its widths: a disc that wide does not reach a tenth of its light or its dark area."""
        light = self._solid > 0.0
        least = min(int(light.sum()), int((~light).sum()))
        if least == 0:
            return 1.0
        for radius in _RADII:
            if _unreached(light, radius) + _unreached(~light, radius) > _LOST * least:
                return 2.0 * radius / light.shape[1]
        return 2.0 * _RADII[-1] / light.shape[1]

    @cached_property
    def seam(self) -> float:
        """How much more heights and colours jump from one edge to the opposite one than between any two lines within, in [0, 2]."""
        layers = self._layers
        jumps = (float(np.abs(layers.take(0, axis) - layers.take(-1, axis)).mean()) for axis in (0, 1))
        within = (float(np.abs(np.diff(layers, axis=axis)).mean(axis=(1 - axis, 2)).max()) for axis in (0, 1))
        return max(jump - largest for jump, largest in zip(jumps, within, strict=True))

    @cached_property
    def _solid(self) -> Floats:
        """The heights, lowest where there is nothing, few enough to be measured."""
        step = max(int(np.ceil(max(self._layers.shape[:2]) / _MEASURED)), 1)
        height = self._layers[..., 0] - (1.0 - self._layers[..., 4])
        whole = height[: height.shape[0] // step * step, : height.shape[1] // step * step]
        return np.asarray(whole.reshape(whole.shape[0] // step, step, whole.shape[1] // step, step).mean(axis=(1, 3)))


def _unreached(mask: Bools, radius: float) -> int:
    """Pixels of a mask that no disc within it reaches; the mask goes on as it is beyond its edges."""
    around = int(np.ceil(2.0 * radius)) + 1
    wide = np.pad(mask, around, mode="edge")
    distance: Any = ndimage.distance_transform_edt(wide)
    centres = distance > radius
    reached = ndimage.distance_transform_edt(~centres) <= radius if centres.any() else np.zeros_like(wide)
    return int((wide & ~reached)[around:-around, around:-around].sum())


Pixels = NDArray[np.uint8] | NDArray[np.uint16]
"""Rows from the top, shape [height, width, channels]: grey, grey and alpha, RGB, or RGB and alpha; 16 bits for grey alone."""

LARGEST_FILE = 64 * 2**20
"""Bytes."""
MOST_PIXELS = 64_000_000
"""Of a file, by what its header says: more are never decoded …"""
LONGEST = 2048
"""… and of these so many are kept along the longer side, the rest averaged: a print of 200 mm shows no tenth of a millimetre."""
READABLE = "give a PNG or JPEG file"
_HEAD = 4096  # bytes of a file in which an SVG drawing says that it is one
_DAMAGED = (
    OSError, SyntaxError, ValueError, TypeError, KeyError, IndexError, EOFError, OverflowError, MemoryError, struct.error, zlib.error,
)  # fmt: skip


def pixels_of(image: str | Path | bytes | NDArray[Any]) -> Pixels:
    """The pixels of a picture: a PNG or JPEG file, its content, or an array; BadInput for one that cannot be used.

    An array is grey [h, w] or has 1 to 4 channels [h, w, c], of integers of 8 or 16 bits, or numbers in [0, 1].
    """
    if isinstance(image, np.ndarray):
        return _checked(_compact(_of_array(image)), "the picture")
    if isinstance(image, bytes):
        return _checked(_compact(_decoded(image, "the picture")), "the picture")
    file = Path(image)
    return _checked(_compact(_decoded(_content(file), file.name)), file.name)


def png_of(pixels: Pixels) -> bytes:
    """A PNG file with these very pixels."""
    buffer = io.BytesIO()
    plain = pixels[..., 0] if pixels.shape[2] == 1 else pixels
    Image.fromarray(plain).save(buffer, "png")
    return buffer.getvalue()


def _content(file: Path) -> bytes:
    """The bytes of a file that is there, not empty, and not huge."""
    try:
        if not file.is_file():
            raise BadInput(f"the picture {file} is not a file; check the path") if file.exists() else absent(file, "the picture")
        if file.stat().st_size > LARGEST_FILE:
            raise BadInput(f"{file.name} is larger than {LARGEST_FILE >> 20} MiB: scale the picture down")
        content = file.read_bytes()
    except (OSError, ValueError) as error:  # ValueError: a null character in a path
        why = getattr(error, "strerror", None) or error
        raise BadInput(f"the picture {file} cannot be opened: {why}; check its path and permissions") from error
    if not content:
        raise BadInput(f"{file.name} is empty; save the picture again")
    return content


def _decoded(content: bytes, name: str) -> Pixels:
    """The pixels of a PNG or JPEG file; of an animated one the first picture."""
    if len(content) > LARGEST_FILE:
        raise BadInput(f"{name} is larger than {LARGEST_FILE >> 20} MiB: scale the picture down")
    if name.lower().endswith((".svg", ".svgz")) or b"<svg" in content[:_HEAD]:
        raise BadInput(f"{name} is an SVG drawing, which is not read: save it as PNG from your drawing program")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a reader's remarks; the number of pixels is checked here before any is decoded
            with Image.open(io.BytesIO(content), formats=("PNG", "JPEG")) as image:
                _check_count(image.width, image.height, name)
                return _reduced(ImageOps.exif_transpose(image))
    except Image.DecompressionBombError as error:
        raise BadInput(f"{name} has more than {MOST_PIXELS / 1e6:.0f} million pixels: scale it down") from error
    except UnidentifiedImageError as error:
        raise BadInput(f"{name} is no picture that can be read, or is damaged: {READABLE}") from error
    except _DAMAGED as error:
        raise BadInput(f"{name} cannot be read: it is damaged or was cut off; save the picture again") from error


def _check_count(width: int, height: int, name: str) -> None:
    if width * height > MOST_PIXELS:
        raise BadInput(f"{name} has {width} x {height} pixels, more than {MOST_PIXELS / 1e6:.0f} million: scale it down")


def _reduced(image: Image.Image) -> Pixels:
    """The pixels of a picture, at most LONGEST along the longer side."""
    size = _fitting(image.width, image.height)
    if image.mode.startswith(("I", "F")):  # 16 bits of grey; Pillow knows no others
        return _resized_grey(np.clip(np.asarray(image), 0, 65535).astype(np.uint16), size)
    clear = "transparency" in image.info or image.mode in {"LA", "PA", "RGBA", "La", "RGBa"}
    grey = image.mode in {"1", "L", "LA", "La"}
    mode = {(True, True): "LA", (True, False): "L", (False, True): "RGBA", (False, False): "RGB"}[grey, clear]
    converted = image if image.mode == mode else image.convert(mode)
    kept = converted if size == converted.size else converted.resize(size, Image.Resampling.BOX)
    return np.atleast_3d(np.asarray(kept, np.uint8))


def _resized_grey(grey: NDArray[np.uint16], size: tuple[int, int]) -> Pixels:
    if size == grey.shape[::-1]:
        return grey[..., None]
    reduced = Image.fromarray(grey.astype(np.float32)).resize(size, Image.Resampling.BOX)
    return np.round(np.asarray(reduced)).astype(np.uint16)[..., None]


def _fitting(width: int, height: int) -> tuple[int, int]:
    share = min(1.0, LONGEST / max(width, height))
    return max(round(share * width), 1), max(round(share * height), 1)


def _of_array(array: NDArray[Any]) -> Pixels:
    """An array as pixels."""
    shape = array.shape
    if array.ndim not in (2, 3) or (array.ndim == 3 and not 1 <= shape[2] <= 4) or 0 in shape:
        raise BadInput(f"a picture has shape [height, width] or [height, width, 1 to 4], not {list(shape)}")
    _check_count(shape[1], shape[0], "the picture")
    many = array if array.ndim == 3 else array[..., None]
    if many.dtype == np.uint16 or not np.issubdtype(many.dtype, np.integer):
        if not np.isfinite(many).all():
            raise BadInput("the picture has values that are not finite numbers")
        share = np.clip(many / 65535.0 if many.dtype == np.uint16 else many.astype(np.float64), 0.0, 1.0)
        bits: Any = np.uint16 if many.shape[2] == 1 else np.uint8
        many = np.round(share * np.iinfo(bits).max).astype(bits)
    if many.dtype == np.uint16:
        return _resized_grey(many[..., 0], _fitting(shape[1], shape[0]))
    whole = np.clip(many, 0, 255).astype(np.uint8)
    return _reduced(Image.fromarray(whole[..., 0] if whole.shape[2] == 1 else whole))


def _compact(pixels: Pixels) -> Pixels:
    """The same without alpha where all is opaque, and as grey where all is grey: one picture has one digest, however it was saved."""
    if pixels.shape[2] in (2, 4) and (pixels[..., -1] == 255).all():
        pixels = pixels[..., :-1]
    if pixels.shape[2] >= 3 and (pixels[..., :1] == pixels[..., 1:3]).all():
        pixels = pixels[..., [0, *range(3, pixels.shape[2])]]
    return pixels.copy(order="C")


def _checked(pixels: Pixels, name: str) -> Pixels:
    height, width, channels = pixels.shape
    if min(height, width) < 2:
        raise BadInput(f"{name} has {width} x {height} pixels: a picture has at least 2 x 2")
    if channels in (2, 4) and not pixels[..., -1].any():
        raise BadInput(f"{name} is transparent all over: there is nothing to see in it")
    return pixels
