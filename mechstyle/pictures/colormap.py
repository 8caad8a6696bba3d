"""Colours for a field over a surface: readable on white, in grey and by the colour-blind, with a threshold set apart."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib import colormaps
from numpy.typing import ArrayLike, NDArray

from mechstyle._colour import Colours, oklab, srgb_to_linear
from mechstyle.errors import BadInput

ABOVE = (0.98, 0.36, 0.20)  # sRGB over-colour of values above the threshold: far from the dark end of the ramp in lightness and in hue
STRIPE = (0.48, 0.0, 0.05)  # sRGB hatch over it, so that colour alone need not show it
LINE = (0.05, 0.05, 0.06)  # sRGB isoline at the threshold
UNKNOWN = (0.66, 0.66, 0.66)  # sRGB of a value that is not a number
ABSENT = (0.42, 0.42, 0.42)  # sRGB hatch over it
PLAIN = (0.80, 0.80, 0.79)  # sRGB of a part without colours: unpainted, neither light nor dark
STEPS = 256


@dataclass(frozen=True)
class Scale:
    """A colour scale: from values to colours."""

    low: float  # value at the pale end [unit of the field]
    high: float  # value at the dark end, or at the top of the scale where a threshold lies before it
    threshold: float | None = None  # values above it are set apart, None for none

    def __post_init__(self) -> None:
        """Refuse a scale without extent."""
        if not (np.isfinite([self.low, self.high]).all() and self.low < self.high):
            raise BadInput(f"a colour scale needs two different ends, the smaller first, but they are {self.low:g} and {self.high:g}")
        if self.threshold is not None and not np.isfinite(self.threshold):
            raise BadInput(f"the threshold of a colour scale must be a number, not {self.threshold}")

    @property
    def top(self) -> float:
        """Value at which the ramp ends: the threshold if it lies inside the scale, else `high`."""
        return float(self.threshold) if self.split and self.threshold is not None else self.high

    @property
    def split(self) -> bool:
        """Whether the threshold lies inside the scale."""
        return self.threshold is not None and self.low < self.threshold < self.high

    def beyond(self, values: ArrayLike) -> NDArray[np.bool_]:
        """Whether values lie above the threshold, same shape."""
        given = np.asarray(values)
        if self.threshold is None:
            return np.zeros(given.shape, bool)
        return np.asarray(given > self.threshold)

    def colours(self, values: ArrayLike) -> Colours:
        """Linear RGB in [0, 1], to be lit, of values of any shape, shape [..., 3]; grey where a value is not a number."""
        given = np.asarray(values, dtype=np.float64)
        place = np.clip((given - self.low) / (self.top - self.low), 0.0, 1.0)
        known = np.isfinite(place)
        colours = np.array(_RAMP[np.rint(np.where(known, place, 0.0) * (STEPS - 1)).astype(np.intp)])
        colours[self.beyond(given)] = srgb_to_linear(ABOVE)
        colours[~known] = srgb_to_linear(UNKNOWN)
        return colours


def hatch(rows: int, columns: int, period: int) -> NDArray[np.bool_]:
    """Diagonal stripes a third of `period` pixels wide, shape [rows, columns]."""
    diagonal = np.arange(rows)[:, None] + np.arange(columns)[None, :]
    return np.asarray(diagonal % period < period // 3)


def _even_ramp() -> Colours:
    """ColorBrewer's YlGnBu without its palest tenth, in steps that look equal (equal distances in Oklab), as linear RGB [STEPS, 3]."""
    fine = srgb_to_linear(colormaps["YlGnBu"].resampled(4096)(np.linspace(0.1, 1.0, 4096))[:, :3])
    travelled = np.concatenate([[0.0], np.linalg.norm(np.diff(oklab(fine), axis=0), axis=1).cumsum()])
    places = np.interp(np.linspace(0.0, travelled[-1], STEPS), travelled, np.arange(len(fine)))
    return np.stack([np.interp(places, np.arange(len(fine)), fine[:, channel]) for channel in range(3)], axis=1).astype(np.float32)


_RAMP = _even_ramp()
_RAMP.setflags(write=False)
