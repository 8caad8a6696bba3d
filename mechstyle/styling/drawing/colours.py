"""Arithmetic of shapes and colours that every style program uses."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mechstyle.records.mesh import Floats

NEUTRAL = 0.75
"""The light grey of an uncoloured part, display value."""
_LUMA = np.array([0.2126, 0.7152, 0.0722])  # Rec. 709


def smoothstep(low: float, high: float, values: ArrayLike) -> Floats:
    """0 below `low`, 1 above `high`, a smooth cubic between; falling if `low` > `high`."""
    t = np.clip((np.asarray(values, dtype=np.float64) - low) / (high - low), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def rgb(code: str) -> Floats:
    """Display RGB in [0, 1] from six hexadecimal digits, shape [3]."""
    return np.array([int(code[k : k + 2], 16) for k in (0, 2, 4)]) / 255.0


def mix(first: ArrayLike, second: ArrayLike, share: Floats) -> Floats:
    """`first` where `share` is 0, `second` where it is 1; colours [3] or [n, 3], share [n]; gives [n, 3]."""
    t = np.clip(share, 0.0, 1.0)[:, None]
    return np.asarray(first) * (1.0 - t) + np.asarray(second) * t


def ramp(colours: list[str], place: Floats) -> Floats:
    """Colours along an evenly spaced list of hexadecimal codes, for places in [0, 1], shape [n, 3]."""
    table = np.array([rgb(code) for code in colours])
    stops = np.linspace(0.0, 1.0, len(table))
    return np.stack([np.interp(place, stops, table[:, channel]) for channel in range(3)], axis=1)


def luminance(colours: Floats) -> Floats:
    """Weighted sum of the channels (Rec. 709), shape [n]."""
    return np.asarray(colours @ _LUMA)


def shaded(colours: ArrayLike, shade: float) -> Floats:
    """Colours of any shape made darker by scaling (`shade` < 1), lighter by mixing with white (`shade` > 1)."""
    given = np.asarray(colours, dtype=np.float64)
    return given * shade if shade <= 1.0 else given + (1.0 - given) * (shade - 1.0)


def in_recesses(colours: Floats, height: Floats, second: ArrayLike) -> Floats:
    """Colours, shape [n, 3], with another one, shape [3], where a relief, shape [n], is nearer to its lowest than to its highest."""
    low, high = np.quantile(height, [0.02, 0.98])
    share = smoothstep(0.4 * low + 0.6 * high, 0.6 * low + 0.4 * high, height) if high > low else np.zeros_like(height)
    deep = share > 0.0
    painted = colours.copy()
    painted[deep] = mix(colours[deep], recoloured(colours[deep], second), share[deep])
    return painted


def lightness(colours: Floats) -> Floats:
    """How light colours, shape [n, 3], are over their mean, in [0.35, 1.8], shape [n]."""
    light = luminance(colours)
    return np.clip(light / max(float(light.mean()), 1e-6), 0.35, 1.8)


def recoloured(colours: Floats, wish: ArrayLike) -> Floats:
    """Another colour, shape [3], with the lights and darks of `colours`, display RGB, shape [n, 3]."""
    shade = lightness(colours)[:, None]
    target = np.asarray(wish, dtype=np.float64)
    # Darker than the mean by scaling, lighter by mixing towards white: a light blue is not a clipped one.
    return np.asarray(np.where(shade <= 1.0, target * shade, target + (1.0 - target) * (shade - 1.0) * 0.6))
