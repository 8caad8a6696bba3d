"""A style: its name, what it looks like, and the program that draws it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mechstyle.records.mesh import Floats
from mechstyle.styling.drawing.canvas import Canvas


class Relief(NamedTuple):
    """Relief and colours drawn by a style program."""

    height: Floats  # relief in about [-1, 1.2], inwards to outwards, shape [n]
    colour: Floats  # display RGB in [0, 1], shape [n, 3]
    # how much relief there is, 0 where the surface stays as it is, shape [n]; None for all of it everywhere. With it heights are in [-1,
    # 1], whatever of that range the part shows
    cover: Floats | None = None
    # whether the height is the displacement itself, as a share of the relief's depth: it stands on the surface around it, or is cut into
    # it
    stands: bool = False


class Proposal(NamedTuple):
    """Proposal of a stylizer, independent of what a mask held back."""

    displacement: NDArray[np.float32]  # along the original normals [mm], shape [n], float32
    colour: NDArray[np.float32]  # display RGB in [0, 1], shape [n, 3], float32


@dataclass(frozen=True)
class Style:
    """A style that needs no network weights."""

    name: str  # its name
    description: str  # what it looks like, in one sentence
    feature_mm: float  # size of the feature the eye reads (a course, a stone, a rib) on a part of 100 mm [mm]
    program: Callable[[Canvas], Relief]  # draws it on a canvas


def style(description: str, *, feature_mm: float) -> Callable[[Callable[[Canvas], Relief]], Style]:
    """Make a program the style of its name; what it takes is described at `Style`."""
    return lambda program: Style(program.__name__, description, feature_mm, program)
