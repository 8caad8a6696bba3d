"""Arithmetic of shapes and colours that every style program uses, and metals as colours on any style.

A polished metal is darker in its hollows and brighter on its crests than a paint of its colour.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mechstyle.geometry.glb import Sheen
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
    """Colours along an evenly spaced list of hexadecimal codes, the first up to place 0 and the last from 1 on, shape [n, 3]."""
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


_ALIKE = 1e-4  # by how much the shade of one channel may differ from that of the others


@dataclass(frozen=True)
class Finish:
    """A metal, or what became of one."""

    hollow: str  # its colour where the style is darkest, hexadecimal digits
    crest: str  # the same where it is lightest
    sheen: Sheen  # how it reflects
    mottled: float = 0.0  # how much lighter and darker it is from place to place


FINISHES: Mapping[str, Finish] = {
    "c99a2e": Finish("3f2c09", "fbe7a6", Sheen(1.0, 0.25)),  # gold
    "b46a3c": Finish("3a1c0f", "f6c7a2", Sheen(1.0, 0.30)),  # copper
    "8a6236": Finish("2b1c0b", "d9b57c", Sheen(1.0, 0.40), 0.10),  # bronze
    "b5933f": Finish("3a2c0e", "f0dc98", Sheen(1.0, 0.30)),  # brass
    "c98f83": Finish("44241d", "f9dccf", Sheen(1.0, 0.25)),  # rose gold
    "b9bcc0": Finish("363b42", "f7f8f9", Sheen(1.0, 0.25)),  # silver
    "c6cace": Finish("262b31", "ffffff", Sheen(1.0, 0.05)),  # chrome
    "cfcecb": Finish("3e3d3a", "fbfaf7", Sheen(1.0, 0.20)),  # platinum
    "50565c": Finish("17191c", "a9b0b7", Sheen(1.0, 0.35)),  # gunmetal
    "9c4a22": Finish("30160c", "d98a4a", Sheen(0.0, 1.0), 0.35),  # rust
}
"""The finishes by the colour that words for them stand for; no paint has the same."""


def finish_of(colour: ArrayLike | None) -> tuple[Finish, float] | None:
    """The finish of a display RGB, and how light it is to be, as `shaded` has it; None for what is no metal."""
    if colour is None:
        return None
    wanted = np.asarray(colour, np.float64)
    for code, finish in FINISHES.items():
        own = rgb(code)
        darker, lighter = wanted / own, 2.0 - (1.0 - wanted) / (1.0 - own)
        for shade in (darker, lighter):
            if np.ptp(shade) < _ALIKE and (shade[0] <= 1.0 if shade is darker else shade[0] >= 1.0):
                return finish, float(shade[0])
    return None


def cast(colours: Floats, colour: ArrayLike, found: tuple[Finish, float], cloud: Floats) -> Floats:
    """A metal's colour, shape [3], with the lights and darks of a style's, shape [n, 3], mottled by a cloud in about [-1, 1], shape [n]."""
    (finish, shade), light = found, lightness(colours)
    hollow, crest = (shaded(rgb(code), shade) for code in (finish.hollow, finish.crest))
    light = light * (1.0 + finish.mottled * cloud)
    return mix(mix(hollow, colour, (light - 0.35) / 0.65), crest, (light - 1.0) / 0.8)
