"""A picture of the user's as heights and colours that can be looked up at any scale."""

from __future__ import annotations

from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from mechstyle.records.mesh import Bools, Floats
from mechstyle.styling.drawing.colours import luminance

_SHADES = {1: 0.02, 2: 0.001}  # range of grey, by bytes, below which a picture is of one shade, and its outline is what counts
_AVERAGED = 0.4  # deviation of the Gaussian over which is averaged, over what one place stands for
_MEASURED = 512  # pixels along the longer side at which widths are measured
_LOST = 0.1  # of its light or dark area a picture may lose where it is finer than what is measured with
_RADII = (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 32.0)


class Sample(NamedTuple):
    """What a picture shows at some places.

    Attributes:
        height: In [-1, 1] from its darkest to its lightest, shape [n].
        colour: Display RGB in [0, 1], shape [n, 3].
        cover: How much of the picture there is, 0 where it is transparent, shape [n].
    """

    height: Floats
    colour: Floats
    cover: Floats


class Raster:
    """Heights and colours of a picture.

    Attributes:
        aspect: Height over width.
        shaded: Whether there is light and dark in it; else its outline is all of its relief.
        clear: Whether it is transparent somewhere.
    """

    def __init__(self, pixels: NDArray[np.uint8] | NDArray[np.uint16]) -> None:
        """Take the pixels as `image_files` makes them, shape [height, width, 1 to 4]."""
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
        """What the picture shows.

        Args:
            u: Place across it, to the right, in its widths from its middle, shape [n].
            v: Place up it, in its heights from its middle, shape [n].
            footprint: What one place stands for, in widths of the picture: finer detail is averaged.
            repeated: Whether it is repeated without end; else there is nothing beside it.
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
