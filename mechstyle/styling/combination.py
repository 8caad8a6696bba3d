"""Several styles on one part: each place gets its own relief and colours, and they pass into each other without a step."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from mechstyle.errors import BadInput
from mechstyle.geometry.region_selection import selected
from mechstyle.records.mesh import Bools, Floats, SurfaceMesh
from mechstyle.styling.drawing.colours import NEUTRAL, smoothstep
from mechstyle.styling.drawing.operators import Operators, unfolded
from mechstyle.styling.drawn import Target
from mechstyle.styling.prompt import Reading, Wish

BLEND = 1.0
"""Half of the way over which one style passes into the next [mm]; an edge of the surface where that is longer."""
_TAIL = 0.1, 0.9  # diffused shares that count as none, and as all


class Places(NamedTuple):
    """Where each wish of a prompt is drawn."""

    shares: Floats  # how much of each wish there is at a vertex, in [0, 1]; what is missing to 1 is plain, shape [wish_count, vertex_count]
    notes: tuple[str, ...]  # a sentence on each place


def places(reading: Reading, surface: SurfaceMesh, thickness: ArrayLike) -> Places:
    """The shares of the wishes of a prompt; where several meet, the one of the smaller place counts.

    Thickness in mm, shape [n]. BadInput if a place holds nothing of this part, or none is left of it.
    """
    wishes = reading.wishes
    if len(wishes) == 1 and not wishes[0].place:
        return Places(np.ones((1, len(surface.vertices))), ())
    areas = surface.vertex_areas / surface.vertex_areas.sum()
    held = [_held(wish, surface, thickness) for wish in wishes]
    owner = np.full(len(surface.vertices), -1)
    for index in sorted(range(len(wishes)), key=lambda index: -float(areas @ held[index])):
        owner[held[index]] = index
    covered = [float(areas @ (owner == index)) for index in range(len(wishes))]
    if not any(covered):
        raise BadInput("the places named in the prompt leave nothing of the part to style")
    where = [wish.place or "everywhere else" for wish in wishes]
    shares = [f"{share:.0%} of the surface" if share else "nothing: smaller or later places cover it all" for share in covered]
    notes = [f"{place}: {wish.words}, {share}" for place, wish, share in zip(where, wishes, shares, strict=True)]
    # Smooth transitions of about BLEND to both sides, between owners of whom -1 is none.
    operators = Operators(surface)
    sharp = (owner[:, None] == np.arange(-1, len(wishes))).astype(np.float64)
    diffused = operators.diffused(sharp, max(BLEND, operators.mesh.edge_length))
    ended = smoothstep(*_TAIL, diffused)  # a diffused share falls off exponentially, and never ends
    total = ended.sum(axis=1, keepdims=True)
    return Places(np.where(total > 0.0, ended / np.maximum(total, 1e-12), sharp)[:, 1:].T, tuple(notes))


def _held(wish: Wish, surface: SurfaceMesh, thickness: ArrayLike) -> Bools:
    """Whether a wish is for each vertex, shape [n]."""
    held = np.ones(len(surface.vertices), bool)
    if wish.where:
        held = np.logical_or.reduce([selected(region, surface, thickness) for region in wish.where])
    for region in wish.spared:
        held &= ~selected(region, surface, thickness)
    return held


def combined(surface: SurfaceMesh, targets: Sequence[Target], shares: Floats) -> Target:
    """Targets of wishes, each drawn all over a surface, as one by their shares, without a step or a fold where they meet."""
    if len(targets) == 1 and (shares == 1.0).all():
        return targets[0]
    relief = np.einsum("ij,ij->j", shares, np.stack([target.displacement for target in targets]), dtype=np.float64)
    plain = (1.0 - shares.sum(axis=0))[:, None] * NEUTRAL
    colour = np.einsum("ij,ijk->jk", shares, np.stack([target.colour for target in targets])) + plain
    notes = dict.fromkeys(note for target in targets for note in target.notes)
    relief, colour = unfolded(Operators(surface), relief).astype(np.float32), np.clip(colour, 0.0, 1.0).astype(np.float32)
    return Target(relief, colour, tuple(notes), max(target.enlarged for target in targets))
