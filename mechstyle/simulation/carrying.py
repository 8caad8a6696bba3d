"""Tetrahedra that carry a relief: made for half of it, and judged by how much of it they follow."""

from __future__ import annotations

from typing import NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from mechstyle._files import cache_folder
from mechstyle.geometry.level_base import LevelBase
from mechstyle.geometry.morph import Morph, Morphed
from mechstyle.geometry.tetrahedra import KEPT, VOLUME_ERROR, tetrahedralise
from mechstyle.records.mesh import Floats, SurfaceMesh, TetMesh

FEWEST_TETS = 3_000
TETS_PER_KEPT_VERTEX = 2.0
"""Asked for, with a relief and without: stresses are compared between meshes that are equally fine. Triangles that are kept alone make one
and a half."""
HALF = np.float32(0.5)
"""Share of the relief that tetrahedra are made for: from there the way to none and to all of it turns the fewest inside out."""
EXAGGERATED = np.float32(2.0)
"""Share of the relief by which triangles are chosen to be kept: as many then carry 0.915 instead of 0.90 of a pen holder's bricks."""
LEAST_CARRIED = 0.9
"""Share of a relief that tetrahedra must follow to judge it."""

MORPHED = "morphed"
AGAIN = "meshed again at half of this relief"
"""How the tetrahedra of a thorough test came about: those of the run, or others."""


AT_REST, MESH_FOR = "rest-", "mesh-for-"
"""What memos call the tetrahedra of an unstylized surface, and those made for a relief, before the digest of either."""


class KeptMesh(msgspec.Struct, frozen=True, kw_only=True):
    """Tetrahedra a test was run on besides those of the run, and what they were made for: digests of stored objects."""

    tets: str
    at: str


class Carried(NamedTuple):
    """How well tetrahedra have the shape of a styled surface.

    Attributes:
        whole: Share of the relief their boundary follows; 1 where there is none.
        base: The same on the faces the part stands on, None where there is none.
        volume: Volume over that inside the surface, less 1; of the styled or of the unstylized part, whichever is further off.
    """

    whole: float
    base: float | None
    volume: float

    @property
    def enough(self) -> bool:
        """Whether a verdict may rest on them."""
        shares = (self.whole, 1.0 if self.base is None else self.base)
        return all(share >= LEAST_CARRIED for share in shares) and abs(self.volume) <= VOLUME_ERROR

    @property
    def again(self) -> str:
        """How tetrahedra that were made anew came about, with what they carry where that is not enough."""
        return AGAIN if self.enough else f"{AGAIN}, but carrying {self.words}"

    @property
    def words(self) -> str:
        """Its figures, as they are told."""
        base = "" if self.base is None else f" ({self.base:.0%} under the part)"
        return f"{self.whole:.0%} of the relief{base}, volume {self.volume:+.1%}"


def carrying(surface: SurfaceMesh, relief: NDArray[np.float32]) -> tuple[TetMesh, NDArray[np.float32]]:
    """Tetrahedra that carry a relief [mm], shape [vertex_count], and the half of it they were made for; cached by content.

    Raises:
        SimulationFailed: If the surface with half of the relief cannot be meshed.
    """
    half, exaggerated = (HALF * relief).astype(np.float32), surface.displaced(EXAGGERATED * relief)
    return tetrahedralise(surface.displaced(half), _count(surface), keep=exaggerated, cache=cache_folder() / "tets"), half


def at_rest(surface: SurfaceMesh) -> TetMesh:
    """Even tetrahedra of a surface without relief; cached by content.

    Raises:
        SimulationFailed: If it cannot be meshed.
    """
    return tetrahedralise(surface, _count(surface), cache=cache_folder() / "tets")


def _count(surface: SurfaceMesh) -> int:
    return max(FEWEST_TETS, round(TETS_PER_KEPT_VERTEX * min(len(surface.vertices), KEPT // 2)))


def carried(morph: Morph, morphed: Morphed, base: LevelBase) -> Carried:
    """How well morphed tetrahedra have the shape of the surface they follow.

    The share is the slope of how far their boundary has gone on how far it was to go, by least squares over the surface; on the flat faces
    both are taken without their means, because a shift as a whole is carried by any mesh.
    """
    surface = morph.surface
    wanted, found = (base.contrast(field).astype(np.float64) for field in (morphed.displacement, morphed.followed))
    styled = surface.displaced(morphed.displacement)
    errors = (float(morphed.tets.volumes.sum()) / styled.volume - 1.0, morph.volume_without_relief / surface.volume - 1.0)
    under = base.resting * surface.vertex_areas
    whole = _slope(wanted, found, surface.vertex_areas)
    return Carried(1.0 if whole is None else whole, _slope(wanted, found, under), max(errors, key=abs))


def _slope(wanted: Floats, found: Floats, weights: Floats) -> float | None:
    """Σ w x y / Σ w x², None where there is nothing wanted."""
    total = float((weights * wanted**2).sum())
    return float((weights * wanted * found).sum()) / total if total > 0.0 else None
