"""How far a style may go at each vertex, and what of an iteration is let through."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from mechstyle.loop import minimum_wall
from mechstyle.records import Recipe
from mechstyle.records.mesh import Bools, Field, Floats, SurfaceMesh


class Base(Protocol):
    """How a part stands: a relief is levelled there, and never goes below the floor."""

    @property
    def standing(self) -> Bools:
        """Whether a vertex belongs to the faces the part stands on, shape [vertex_count]."""

    def levelled(self, displacement: Field) -> Field:
        """A relief [mm], shape [vertex_count], shifted so that the part stands level."""

    def clipped(self, displacement: Field) -> Field:
        """A relief [mm], shape [vertex_count], less what would go below the floor."""


@dataclass(frozen=True, eq=False)
class Bounds:
    """Bounds of the style at each vertex.

    Attributes:
        thickness: Local wall thickness [mm], shape [vertex_count].
        inward: Largest displacement into the material [mm], shape [vertex_count].
        outward: Largest displacement out of it [mm], shape [vertex_count].
        freedom: Factor on the relief, 0 on the resting face and in protected regions, 1 away from them, shape [vertex_count].
        uncoloured: Share of its own colour that a vertex keeps, in [0, 1], shape [vertex_count, 1]; 0 for none, 1 whatever is proposed.
        base: What levels the relief under the part, None for nothing.
        plain: Whether a vertex is no part of the style, shape [vertex_count]; False for none. Its freedom is 0, too.
        seen: Share of the sky that a vertex sees, shape [vertex_count]: how much its relief counts; None where all counts alike.
    """

    thickness: Field
    inward: Field
    outward: Field
    freedom: Field
    uncoloured: Field | float = 0.0
    base: Base | None = None
    plain: NDArray[np.bool_] | bool = False
    seen: Field | None = None

    def seen_areas(self, surface: SurfaceMesh) -> Floats:
        """Vertex areas weighed by what can be seen of them [mm²], shape [vertex_count]; all of them where nothing can."""
        areas = surface.vertex_areas if self.seen is None else surface.vertex_areas * self.seen
        return areas if areas.any() else surface.vertex_areas

    @property
    def standing(self) -> Bools:
        """Whether a vertex belongs to the faces the part stands on, shape [vertex_count]; none where the base is free."""
        return np.zeros(len(self.thickness), bool) if self.base is None else self.base.standing

    def levelled(self, displacement: Field) -> Field:
        """A proposal [mm], shape [vertex_count], as the base lets it be."""
        return displacement if self.base is None else self.base.levelled(displacement)

    def clipped(self, displacement: Field) -> Field:
        """A relief [mm], shape [vertex_count], within the bounds and above the floor."""
        within = np.clip(displacement, -self.inward, self.outward)
        return within if self.base is None else self.base.clipped(within)


def advanced(displacement: Field, let_through: Field, increment: Field, bounds: Bounds, recipe: Recipe) -> Field:
    """The displacement after one iteration [mm], shape [vertex_count]: what of the increment is let through, within the bounds.

    `let_through` is mask times share; the recipe says whether walls are spared.
    """
    step = let_through * increment
    if recipe.restraint.feedback:
        step = minimum_wall.spared(step, bounds.thickness, displacement, recipe.delivery.minimum_wall)
    return bounds.clipped(displacement + step)


def unrestrained_relief(asked: Field, bounds: Bounds, recipe: Recipe) -> Field:
    """What comes of a finished proposal that no stress restrains [mm], shape [vertex_count].

    It is grown evenly over the iterations, because near the thinnest wall each step is slowed by those before it. `asked` is what the
    stylizer proposes in the end [mm], shape [vertex_count].
    """
    increment, grown = (bounds.levelled(asked) / recipe.schedule.iterations).astype(np.float32), np.zeros_like(bounds.thickness)
    for _ in range(recipe.schedule.iterations):
        grown = advanced(grown, bounds.freedom, increment, bounds, recipe)
    return grown
