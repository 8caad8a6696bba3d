"""Tetrahedra of a part: how well they follow a relief, how stress gets from them to the surface, and which of them serve a relief.

Those of the run serve most; the plain part has its own, and others are made for a relief that neither follows, and remembered.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from mechstyle.errors import MechStyleError
from mechstyle.fea.explicit import Progress, no_progress
from mechstyle.fea.permanent_set import quantile
from mechstyle.geometry.morph import Morph, Morphed
from mechstyle.geometry.transfer import SurfaceMean, Transfer
from mechstyle.loop.objects import LAST_MESH, MESH, MESH_FOR, TESTED_ON, UNDEFORMED, Memo, Memos
from mechstyle.records.mesh import Floats, TetMesh, digest_of
from mechstyle.records.recipe import Transfer as TransferName
from mechstyle.records.simulation import LEAST_GROUNDED, THICKER, VOLUME_ERROR
from mechstyle.simulation.part import Shape, mesh_for_relief, undeformed_mesh

THICKER_AREA = 4.0
"""Of the surface [mm²], on which a wall may be thicker: less than a groove of 0.4 mm around a stem of 3 mm."""


class Followed(NamedTuple):
    """How well tetrahedra have the shape of a styled surface.

    Attributes:
        whole: Share of the relief their boundary follows; 1 where there is none.
        volume: Volume over that inside the surface, less 1; of the styled or of the unstylized part, whichever is further off.
        grounded: 1 less the share of the base that the surface has on the floor and their boundary, which an impact goes through, has not.
        thicker: Share of what the relief leaves of a wall by which they are thicker, on all of the surface but THICKER_AREA.
    """

    whole: float
    volume: float
    grounded: float = 1.0
    thicker: float = 0.0

    @property
    def enough(self) -> bool:
        """Whether a verdict may rest on these tetrahedra."""
        return self.thicker <= THICKER and self.grounded >= LEAST_GROUNDED and abs(self.volume) <= VOLUME_ERROR

    def is_at_least_as_good_as(self, other: Followed) -> bool:
        """Whether these are taken rather than new ones made: no worse than others that are not enough, and on the floor as the surface."""
        return self.grounded >= LEAST_GROUNDED and self.thicker <= other.thicker

    @property
    def words(self) -> str:
        """Its figures in words."""
        grounded = "" if self.grounded >= LEAST_GROUNDED else f", {self.grounded:.0%} of the base on the floor in the mesh"
        thicker = "" if self.thicker <= THICKER else f", walls thicker by {self.thicker:.0%}"
        return f"{self.whole:.0%} of the relief{thicker}{grounded}, volume {self.volume:+.1%}"


@dataclass(frozen=True, eq=False)
class Body:
    """Tetrahedra of a part, `shape`, that a `nozzle` [mm] prints, and how their stress gets to its surface, `transfer`.

    They were made for its displacement `at` [mm], shape [vertex_count], None for none.
    """

    shape: Shape
    tets: TetMesh
    nozzle: float
    transfer: TransferName = "barycentric"
    at: NDArray[np.float32] | None = None

    @property
    def made_for_relief(self) -> bool:
        """Whether they were made for a styled surface."""
        return self.at is not None and bool(np.any(self.at))

    @cached_property
    def morph(self) -> Morph:
        """What moves the tetrahedra with the surface."""
        return Morph(self.shape.surface, self.tets, self.at)

    def followed(self, morphed: Morphed) -> Followed:
        """How well the moved tetrahedra have the shape of the surface they follow.

        The share is the slope of how far their boundary has gone on how far it was to go, by least squares over the surface, as far as the
        nozzle can print it; on the flat faces both are without their means, because any mesh follows a shift as a whole.
        """
        surface, base = self.shape.surface, self.shape.level_base
        wanted, found = (self._printed(base.contrast(field).astype(np.float64)) for field in (morphed.displacement, morphed.followed))
        styled, areas = surface.displaced(morphed.displacement), surface.vertex_areas
        errors = (float(morphed.tets.volumes.sum()) / styled.volume - 1.0, self.morph.volume_without_relief / surface.volume - 1.0)
        whole = slope(wanted, found, areas)
        lifted = (base.share(morphed.displacement) or 0.0) - (base.share(morphed.followed) or 0.0)
        standing = self._printed(np.maximum(morphed.followed - morphed.displacement, 0.0)) / self.shape.thinnest(morphed.displacement)
        thicker = quantile(standing[:, None], areas, THICKER_AREA) if morphed.displacement.any() else 0.0
        return Followed(1.0 if whole is None else max(whole, 0.0), max(errors, key=abs), 1.0 - max(lifted, 0.0), thicker)

    @cached_property
    def _printed(self) -> SurfaceMean:
        """What a nozzle leaves of a relief: a mean over its width."""
        return SurfaceMean(self.shape.surface, 0.5 * self.nozzle)

    @cached_property
    def _transfer(self) -> Transfer:
        return Transfer(self.shape.surface.displaced(self.morph.at), self.tets, self.transfer)

    def contact_at_surface(self, contact: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Whether vertices of the surface touch, from whether nodes do, shape [vertex_count]."""
        return self._transfer.to_surface(contact.astype(np.float64)) > 0.5

    def field_at_surface(self, nodal: Floats) -> NDArray[np.float32]:
        """Stress or strain at the nodes brought to the surface and averaged over 2 mm along it, shape [vertex_count]."""
        return self.shape.smooth(self._transfer.to_surface(nodal)).astype(np.float32)

    def displacement_at_surface(self, nodal: Floats) -> NDArray[np.float32]:
        """Displacement of the nodes [mm] brought to the surface, shape [vertex_count, 3]."""
        return np.stack([self._smooth_transfer.to_surface(nodal[:, axis]) for axis in range(3)], axis=1).astype(np.float32)

    @cached_property
    def _smooth_transfer(self) -> Transfer:
        """A displacement is interpolated, whatever the method of stress: steps in it would be steps in the surface."""
        smooth = Transfer(self.shape.surface.displaced(self.morph.at), self.tets)
        return self._transfer if self.transfer == smooth.method else smooth


def slope(wanted: Floats, found: Floats, weights: Floats) -> float | None:
    """Σ w x y / Σ w x² of a relief x that is wanted and y that is found of it [mm]; None where there is nothing wanted."""
    total = float((weights * wanted**2).sum())
    return float((weights * wanted * found).sum()) / total if total > 0.0 else None


MORPHED = "morphed"
AGAIN = "meshed again at half of this relief"
"""How the tetrahedra of a thorough test came about: those of the run, or others."""


class KeptMesh(msgspec.Struct, frozen=True, kw_only=True):
    """Tetrahedra a test was run on besides those of the run, and what they were made for: digests of stored objects."""

    tets: str
    at: str


class MeshFor(msgspec.Struct, frozen=True, kw_only=True):
    """Tetrahedra that a relief was tested on: their digest, and how they came about, in words."""

    mesh: str
    meshing: str


@dataclass(frozen=True, eq=False)
class Meshes:
    """The sets of tetrahedra of one part in one run.

    Attributes:
        first: Those of the run, made for its finished style where that was known.
        memo: Where the run remembers others.
        shared: Where those of the plain part are remembered for other runs too; None for nowhere.
        run: What names the run in its memo.
        progress: Called while tetrahedra are made; may raise to cancel.
    """

    first: Body
    memo: Memo
    shared: Memo | None = None
    run: str = ""
    progress: Progress = field(default=no_progress)

    @cached_property
    def plain(self) -> tuple[Body, Memos]:
        """Tetrahedra of the plain part, and the memos that hold results on them, the most trusted first.

        They are even ones of their own: on those of a relief a drop would take three times the steps, because their triangles are flattened
        on the way back. Other runs share them, and a run folder from another machine keeps those that it was made with.
        """
        if not self.first.made_for_relief:
            return self.first, Memos((self.memo,) if self.shared is None else (self.shared, self.memo))
        name = f"{UNDEFORMED}{self.first.shape.surface.digest}"
        own, known = self.memo.recall(name, str), None if self.shared is None else self.shared.recall(name, str)
        home = self.memo if self.shared is None or own not in (None, known) else self.shared
        kept = own or known or home.objects.put_mesh(undeformed_mesh(self.first.shape.surface, partial(self.progress, 0.0)))
        tets = (self.memo if own else home).objects.get_mesh(kept, TetMesh)
        for memo in (self.memo, home):
            memo.remember(name, memo.objects.put_mesh(tets))
        return replace(self.first, tets=tets, at=None), Memos((home,))

    def known(self, mesh: str) -> Body | None:
        """The tetrahedra of a digest, None if this run has none of it."""
        if mesh == self.first.tets.digest:
            return self.first
        kept = self.memo.recall(f"{MESH}{mesh}", KeptMesh)
        if kept is None:
            return None
        tets, at = self.memo.objects.get_mesh(kept.tets, TetMesh), self.memo.objects.get_array(kept.at)
        return replace(self.first, tets=tets, at=at) if tets.digest == mesh else None

    def mesh_for(self, displacement: NDArray[np.float32]) -> tuple[Body, str]:
        """Tetrahedra that follow a relief [mm], shape [vertex_count], and how these came about, in words; remembered.

        They are those of the run, those that were made last for such a relief, or new ones; meshing a third time was never seen to follow
        more. Asked again they are the same, whatever was meshed since.
        """
        if not np.any(displacement):
            return self.plain[0], MORPHED
        name = f"{TESTED_ON}{self.run}-{digest_of(displacement)}"
        chosen = self.memo.recall(name, MeshFor)
        if chosen is not None and (body := self.known(chosen.mesh)) is not None:
            return body, chosen.meshing
        body, meshing = self._that_follows(displacement)
        self.memo.remember(name, MeshFor(mesh=body.tets.digest, meshing=meshing), anew=True)
        return body, meshing

    def _that_follows(self, displacement: NDArray[np.float32]) -> tuple[Body, str]:
        here = self.first.followed(self.first.morph.morphed(displacement))
        if here.enough:
            return self.first, MORPHED
        last = self.memo.recall(f"{LAST_MESH}{self.run}", str)
        other = None if last is None else self.known(last)
        if other is not None and other is not self.first:
            there = other.followed(other.morph.morphed(displacement))
            if there.is_at_least_as_good_as(here):
                return other, AGAIN if there.enough else f"{AGAIN}, but following {there.words}"
        try:
            name, objects = f"{MESH_FOR}{digest_of(displacement)}", self.memo.objects
            kept = self.memo.recall(name, KeptMesh)
            if kept is None:
                made, half = mesh_for_relief(self.first.shape, displacement, partial(self.progress, 0.0))
                kept = KeptMesh(tets=objects.put_mesh(made), at=objects.put_array(half))
                self.memo.remember(name, kept)
            tets, at = objects.get_mesh(kept.tets, TetMesh), objects.get_array(kept.at)
            self.memo.remember(f"{MESH}{tets.digest}", kept)
            self.memo.remember(f"{LAST_MESH}{self.run}", tets.digest, anew=True)
            body = replace(self.first, tets=tets, at=at)
        except MechStyleError as error:
            return self.first, f"{MORPHED}, following {here.words}, as the part could not be meshed again: {error}"
        there = body.followed(body.morph.morphed(displacement))
        return body, AGAIN if there.enough else f"{AGAIN}, but following {there.words}"
