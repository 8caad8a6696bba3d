"""Metals as colours on any style: a polished one is darker in its hollows and brighter on its crests than a paint of its colour."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mechstyle.geometry.glb import Sheen
from mechstyle.records.mesh import Floats
from mechstyle.styling.drawing.colours import lightness, mix, rgb, shaded

_ALIKE = 1e-4  # by how much the shade of one channel may differ from that of the others


@dataclass(frozen=True)
class Finish:
    """A metal, or what became of one.

    Attributes:
        hollow: Its colour where the style is darkest, hexadecimal digits.
        crest: The same where it is lightest.
        sheen: How it reflects.
        mottled: How much lighter and darker it is from place to place.
    """

    hollow: str
    crest: str
    sheen: Sheen
    mottled: float = 0.0


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
    """A metal with the lights and darks of a style.

    Args:
        colours: Display RGB of the style, shape [n, 3].
        colour: Of the metal, shape [3].
        found: Its finish, and how light it is.
        cloud: Noise in about [-1, 1], shape [n], which mottles it.
    """
    (finish, shade), light = found, lightness(colours)
    hollow, crest = (shaded(rgb(code), shade) for code in (finish.hollow, finish.crest))
    light = light * (1.0 + finish.mottled * cloud)
    return mix(mix(hollow, colour, (light - 0.35) / 0.65), crest, (light - 1.0) / 0.8)
