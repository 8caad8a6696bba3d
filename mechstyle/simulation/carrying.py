"""Tetrahedra that carry a relief: made for half of it, and judged by how much of it they follow."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from mechstyle._files import cache_folder
from mechstyle.geometry.going_on import GoOn, regardless
from mechstyle.geometry.level_base import LevelBase
from mechstyle.geometry.morph import Morph, Morphed
from mechstyle.geometry.remeshing import fill as tetrahedralise
from mechstyle.geometry.remeshing.filling import KEPT
from mechstyle.records.mesh import Floats, SurfaceMesh, TetMesh
from mechstyle.records.simulation import LEAST_CARRIED, VOLUME_ERROR

FEWEST_TETS = 3_000
TETS_PER_KEPT_VERTEX = 2.0
"""Asked for, with a relief and without: stresses are compared between meshes that are equally fine. Triangles that are kept alone make one
and a half."""
HALF = np.float32(0.5)
"""Share of the relief that tetrahedra are made for: from there the way to none and to all of it turns the fewest inside out."""
EXAGGERATED = np.float32(2.0)
"""Share of the relief by which triangles are chosen to be kept: as many then carry 0.915 instead of 0.90 of a pen holder's bricks."""

MORPHED = "morphed"
AGAIN = "meshed again at half of this relief"
"""How the tetrahedra of a thorough test came about: those of the run, or others."""


class KeptMesh(msgspec.Struct, frozen=True, kw_only=True):
    """Tetrahedra a test was run on besides those of the run, and what they were made for: digests of stored objects."""

    tets: str
    at: str


class Carrier(msgspec.Struct, frozen=True, kw_only=True):
    """What a relief was tested on: the digest of the tetrahedra, and how they came about, in words."""

    mesh: str
    meshing: str


class Carried(NamedTuple):
    """How well tetrahedra have the shape of a styled surface.

    Attributes:
        whole: Share of the relief their boundary follows; 1 where there is none.
        base: The same on the faces the part stands on, None where there is none.
        volume: Volume over that inside the surface, less 1; of the styled or of the unstylized part, whichever is further off.
        stands: 1 less the share of the faces it stands on that the surface has on the floor and their boundary has not: where a deep relief
            is laid flat they may be unable to follow, and an impact would go through the few nodes that are.
    """

    whole: float
    base: float | None
    volume: float
    stands: float = 1.0

    @property
    def least(self) -> float:
        """The least of the shares."""
        return float(np.min([self.whole, 1.0 if self.base is None else self.base, self.stands]))

    @property
    def under(self) -> float | None:
        """The share under the part, of the relief or of what is on the floor, whichever is less; None where there is no relief."""
        if self.base is None:
            return None if self.stands >= LEAST_CARRIED else self.stands
        return min(self.base, self.stands)

    @property
    def enough(self) -> bool:
        """Whether a verdict may rest on them."""
        return self.least >= LEAST_CARRIED and abs(self.volume) <= VOLUME_ERROR

    def serves_instead_of(self, other: Carried) -> bool:
        """Whether these are taken rather than new ones made: no worse than others that are not enough, and standing as the surface does."""
        return self.stands >= LEAST_CARRIED and self.least >= other.least

    @property
    def again(self) -> str:
        """How tetrahedra that were made anew came about, with what they carry where that is not enough."""
        return AGAIN if self.enough else f"{AGAIN}, but carrying {self.words}"

    @property
    def words(self) -> str:
        """Its figures, as they are told."""
        base = "" if self.base is None else f" ({self.base:.0%} under the part)"
        stands = "" if self.stands >= LEAST_CARRIED else f", {1.0 - self.stands:.0%} of its base off the floor"
        return f"{self.whole:.0%} of the relief{base}{stands}, volume {self.volume:+.1%}"


def carrying(surface: SurfaceMesh, relief: NDArray[np.float32], go_on: GoOn = regardless) -> tuple[TetMesh, NDArray[np.float32]]:
    """Tetrahedra that carry a relief [mm], shape [vertex_count], and the half of it they were made for; cached by content.

    What `go_on` raises ends it.

    Raises:
        SimulationFailed: If the surface with half of the relief cannot be meshed.
    """
    half, exaggerated = (HALF * relief).astype(np.float32), surface.displaced(EXAGGERATED * relief)
    return tetrahedralise(surface.displaced(half), _count(surface), keep=exaggerated, cache=cache_folder() / "tets", go_on=go_on), half


def at_rest(surface: SurfaceMesh, go_on: GoOn = regardless) -> TetMesh:
    """Even tetrahedra of a surface without relief; cached by content. What `go_on` raises ends it.

    Raises:
        SimulationFailed: If it cannot be meshed.
    """
    return tetrahedralise(surface, _count(surface), cache=cache_folder() / "tets", go_on=go_on)


def _count(surface: SurfaceMesh) -> int:
    return max(FEWEST_TETS, round(TETS_PER_KEPT_VERTEX * min(len(surface.vertices), KEPT // 2)))


def carried(morph: Morph, morphed: Morphed, base: LevelBase, printed: Callable[[Floats], Floats]) -> Carried:
    """How well morphed tetrahedra have the shape of the surface they follow.

    The share is the slope of how far their boundary has gone on how far it was to go, by least squares over the surface; on the flat faces
    both are taken without their means, because a shift as a whole is carried by any mesh.

    Args:
        morph: What moves the tetrahedra.
        morphed: The tetrahedra and what they follow.
        base: What the part stands on.
        printed: A relief [mm], shape [vertex_count], as far as a nozzle could print it: what is finer does not count as missed.
    """
    surface = morph.surface
    wanted, found = (printed(base.contrast(field).astype(np.float64)) for field in (morphed.displacement, morphed.followed))
    styled = surface.displaced(morphed.displacement)
    errors = (float(morphed.tets.volumes.sum()) / styled.volume - 1.0, morph.volume_without_relief / surface.volume - 1.0)
    under = base.resting * surface.vertex_areas
    whole = slope(wanted, found, surface.vertex_areas)
    lifted = (base.share(morphed.displacement) or 0.0) - (base.share(morphed.followed) or 0.0)
    return Carried(1.0 if whole is None else whole, slope(wanted, found, under), max(errors, key=abs), 1.0 - max(lifted, 0.0))


def slope(wanted: Floats, found: Floats, weights: Floats) -> float | None:
    """Σ w x y / Σ w x² of a relief x that is wanted and y that is found of it [mm]; None where there is nothing wanted."""
    total = float((weights * wanted**2).sum())
    return float((weights * wanted * found).sum()) / total if total > 0.0 else None
