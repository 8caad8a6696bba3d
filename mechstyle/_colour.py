"""Colours as a display shows them, as light, and as the eye tells them apart."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Colours = NDArray[np.float32]


def srgb_to_linear(colours: ArrayLike) -> Colours:
    """Light intensity of display colours, both in [0, 1] (IEC 61966-2-1)."""
    c = np.asarray(colours, dtype=np.float32)
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4).astype(np.float32)


def linear_to_srgb(intensities: ArrayLike) -> Colours:
    """Display colours of light intensities, both in [0, 1] (IEC 61966-2-1)."""
    c = np.clip(np.asarray(intensities, dtype=np.float32), 0.0, 1.0)
    return np.where(c <= 0.0031308, 12.92 * c, 1.055 * c ** (1 / 2.4) - 0.055).astype(np.float32)


def oklab(colours: ArrayLike) -> NDArray[np.float64]:
    """Perceptual coordinates (lightness, green-red, blue-yellow) of linear RGB, shape [..., 3] (Ottosson 2020)."""
    cones = np.cbrt(np.asarray(colours, dtype=np.float64) @ _RGB_TO_CONES.T)
    return np.asarray(cones @ _CONES_TO_OKLAB.T)


def from_oklab(places: ArrayLike) -> NDArray[np.float64]:
    """Linear RGB of perceptual coordinates, shape [..., 3]; out of [0, 1] where no display shows the colour."""
    cones = np.asarray(places, dtype=np.float64) @ np.linalg.inv(_CONES_TO_OKLAB).T
    return np.asarray(cones**3 @ np.linalg.inv(_RGB_TO_CONES).T)


_RGB_TO_CONES = np.array([
    [0.4122214708, 0.5363325363, 0.0514459929], [0.2119034982, 0.6806995451, 0.1073969566], [0.0883024619, 0.2817188376, 0.6299787005],
])  # fmt: skip
_CONES_TO_OKLAB = np.array([
    [0.2104542553, 0.7936177850, -0.0040720468], [1.9779984951, -2.4285922050, 0.4505937099], [0.0259040371, 0.7827717662, -0.8086757660],
])  # fmt: skip
