"""One set of tetrahedra of a part: moved with the surface, judged by how well it follows, and its stress brought to the surface."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mechstyle.fea.stressed_volume import Walls
from mechstyle.geometry.level_base import LevelBase
from mechstyle.geometry.morph import Morph, Morphed
from mechstyle.geometry.thickness import local_thickness
from mechstyle.geometry.transfer import SurfaceMean, Transfer
from mechstyle.records.chapters import Transfer as TransferName
from mechstyle.records.mesh import Floats, SurfaceMesh, TetMesh
from mechstyle.records.simulation import LEAST_CARRIED, VOLUME_ERROR

SEEN = 0.01
"""Relief below which a place has none [mm]: no printer shows it."""

SAME_PART = 0.02
"""Relief that tetrahedra may keep on the way back to the plain part, over its local wall: what is bent then reads 4 % more or less."""


@dataclass(frozen=True, eq=False)
class Skin:
    """The standardised surface without style. `known_thickness` [mm] is [vertex_count], None to work it out; `nozzle` is in mm."""

    surface: SurfaceMesh
    nozzle: float
    known_thickness: NDArray[np.floating] | None = None

    @cached_property
    def base(self) -> LevelBase:
        """The flat faces the part stands on."""
        return LevelBase(self.surface)

    @cached_property
    def smooth(self) -> SurfaceMean:
        """A mean over 2 mm along the surface."""
        return SurfaceMean(self.surface)

    @cached_property
    def printed(self) -> SurfaceMean:
        """What a nozzle leaves of a relief: a mean over its width."""
        return SurfaceMean(self.surface, 0.5 * self.nozzle)

    @cached_property
    def walls(self) -> Walls:
        """Walls of the unstylized part, by which small volumes of thin members count."""
        known = self.known_thickness
        return Walls(self.surface.vertices, local_thickness(self.surface) if known is None else known)


class Followed(NamedTuple):
    """How well tetrahedra have the shape of a styled surface.

    Attributes:
        whole: Share of the relief their boundary follows; 1 where there is none.
        base: The same on the faces the part stands on, None where there is none.
        volume: Volume over that inside the surface, less 1; of the styled or of the unstylized part, whichever is further off.
        grounded: 1 less the share of the base that the surface has on the floor and their boundary, which an impact goes through, has not.
    """

    whole: float
    base: float | None
    volume: float
    grounded: float = 1.0

    @property
    def least(self) -> float:
        """The least of the shares."""
        return float(np.min([self.whole, 1.0 if self.base is None else self.base, self.grounded]))

    @property
    def under(self) -> float | None:
        """The share under the part, of the relief or of what is on the floor, whichever is less; None where there is no relief."""
        if self.base is None:
            return None if self.grounded >= LEAST_CARRIED else self.grounded
        return min(self.base, self.grounded)

    @property
    def enough(self) -> bool:
        """Whether a verdict may rest on these tetrahedra."""
        return self.least >= LEAST_CARRIED and abs(self.volume) <= VOLUME_ERROR

    def is_at_least_as_good_as(self, other: Followed) -> bool:
        """Whether these are taken rather than new ones made: no worse than others that are not enough, and on the floor as the surface."""
        return self.grounded >= LEAST_CARRIED and self.least >= other.least

    @property
    def words(self) -> str:
        """Its figures in words."""
        base = "" if self.base is None else f" ({self.base:.0%} under the part)"
        grounded = "" if self.grounded >= LEAST_CARRIED else f", {1.0 - self.grounded:.0%} of its base off the floor"
        return f"{self.whole:.0%} of the relief{base}{grounded}, volume {self.volume:+.1%}"


@dataclass(frozen=True, eq=False)
class Body:
    """Tetrahedra of a part, `skin`, and how their stress gets to its surface, `transfer`.

    They were made for its displacement `at` [mm], shape [vertex_count], None for none.
    """

    skin: Skin
    tets: TetMesh
    transfer: TransferName = "barycentric"
    at: NDArray[np.float32] | None = None

    @property
    def made_for_relief(self) -> bool:
        """Whether they were made for a styled surface."""
        return self.at is not None and bool(np.any(self.at))

    @cached_property
    def morph(self) -> Morph:
        """What moves the tetrahedra with the surface."""
        return Morph(self.skin.surface, self.tets, self.at)

    @cached_property
    def is_the_plain_part(self) -> bool:
        """Whether without relief they have the shape of the plain part: its volume, and so little left that no wall is another.

        What is left is averaged over 2 mm, as over less there is no volume that counts.
        """
        back = self.morph.morphed(np.zeros(len(self.skin.surface.vertices), np.float32))
        left = self.skin.smooth(np.abs(back.followed).astype(np.float64)) / self.skin.walls.thickness
        return bool(left.max() <= SAME_PART) and self.followed(back).enough

    def followed(self, morphed: Morphed) -> Followed:
        """How well the moved tetrahedra have the shape of the surface they follow.

        The share is the slope of how far their boundary has gone on how far it was to go, by least squares over the surface, as far as the
        nozzle can print it; on the flat faces both are without their means, because any mesh follows a shift as a whole.
        """
        skin, base = self.skin, self.skin.base
        wanted, found = (skin.printed(base.contrast(field).astype(np.float64)) for field in (morphed.displacement, morphed.followed))
        styled, areas = skin.surface.displaced(morphed.displacement), skin.surface.vertex_areas
        errors = (float(morphed.tets.volumes.sum()) / styled.volume - 1.0, self.morph.volume_without_relief / skin.surface.volume - 1.0)
        whole = slope(wanted, found, areas)
        lifted = (base.share(morphed.displacement) or 0.0) - (base.share(morphed.followed) or 0.0)
        # What a nozzle leaves of a relief beside the base reaches over its edge, where there is none to be followed.
        under = slope(wanted, found, base.resting * areas * (np.abs(morphed.displacement) > SEEN))
        shares = (1.0 if whole is None else max(whole, 0.0), None if under is None else max(under, 0.0))
        return Followed(*shares, max(errors, key=abs), 1.0 - max(lifted, 0.0))

    @cached_property
    def _transfer(self) -> Transfer:
        return Transfer(self.skin.surface.displaced(self.morph.at), self.tets, self.transfer)

    def contact_at_surface(self, contact: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Whether vertices of the surface touch, from whether nodes do, shape [vertex_count]."""
        return self._transfer.to_surface(contact.astype(np.float64)) > 0.5

    def stress_at_surface(self, nodal: Floats) -> NDArray[np.float32]:
        """Stress at the nodes brought to the surface and averaged over 2 mm along it [MPa], shape [vertex_count]."""
        return self.skin.smooth(self._transfer.to_surface(nodal)).astype(np.float32)


def slope(wanted: Floats, found: Floats, weights: Floats) -> float | None:
    """Σ w x y / Σ w x² of a relief x that is wanted and y that is found of it [mm]; None where there is nothing wanted."""
    total = float((weights * wanted**2).sum())
    return float((weights * wanted * found).sum()) / total if total > 0.0 else None
