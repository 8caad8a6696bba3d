"""Which tetrahedra serve a relief: those of the run, of the plain part, or others that are made for that relief and remembered."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import msgspec
import numpy as np
from numpy.typing import NDArray

from mechstyle._files import cache_folder
from mechstyle.errors import MechStyleError
from mechstyle.fea.explicit import Progress, no_progress
from mechstyle.geometry.cancelling import CancelCheck, never_cancel
from mechstyle.geometry.remeshing.filling import KEPT, fill
from mechstyle.loop.objects import AT_REST, CARRIER, LAST_MESH, MESH, MESH_FOR, Memo
from mechstyle.records.mesh import SurfaceMesh, TetMesh, digest_of
from mechstyle.simulation.body import Body

FEWEST_TETS = 3_000
TETS_PER_KEPT_VERTEX = 2.0
"""Asked for, with a relief and without: stresses are compared between meshes that are equally fine. Triangles that are kept alone make one
and a half."""
HALF = np.float32(0.5)
"""Share of the relief that tetrahedra are made for: from there the way to none and to all of it turns the fewest inside out."""
EXAGGERATED = np.float32(2.0)
"""Share of the relief by which triangles are chosen to be kept: as many then follow 0.915 instead of 0.90 of a pen holder's bricks."""

MORPHED = "morphed"
AGAIN = "meshed again at half of this relief"
"""How the tetrahedra of a thorough test came about: those of the run, or others."""


class KeptMesh(msgspec.Struct, frozen=True, kw_only=True):
    """Tetrahedra a test was run on besides those of the run, and what they were made for: digests of stored objects."""

    tets: str
    at: str


class Carrier(msgspec.Struct, frozen=True, kw_only=True):
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
    def plain(self) -> tuple[Body, tuple[Memo, ...]]:
        """Tetrahedra of the plain part, and the memos that hold results on them, the most trusted first.

        They are even ones of their own: on those of a relief a drop would take three times the steps, because their triangles are flattened
        on the way back. Other runs share them, and a run folder from another machine keeps those that it was made with.
        """
        if not self.first.made_for_relief:
            return self.first, (self.memo,) if self.shared is None else (self.shared, self.memo)
        name = f"{AT_REST}{self.first.skin.surface.digest}"
        own, known = self.memo.recall(name, str), None if self.shared is None else self.shared.recall(name, str)
        home = self.memo if self.shared is None or own not in (None, known) else self.shared
        kept = own or known or home.objects.put_mesh(at_rest(self.first.skin.surface, partial(self.progress, 0.0)))
        tets = (self.memo if own else home).objects.get_mesh(kept, TetMesh)
        for memo in (self.memo, home):
            memo.remember(name, memo.objects.put_mesh(tets))
        return replace(self.first, tets=tets, at=None), (home,)

    def known(self, mesh: str) -> Body | None:
        """The tetrahedra of a digest, None if this run has none of it."""
        if mesh == self.first.tets.digest:
            return self.first
        kept = self.memo.recall(f"{MESH}{mesh}", KeptMesh)
        if kept is None:
            return None
        tets, at = self.memo.objects.get_mesh(kept.tets, TetMesh), self.memo.objects.get_array(kept.at)
        return replace(self.first, tets=tets, at=at) if tets.digest == mesh else None

    def carrier(self, displacement: NDArray[np.float32]) -> tuple[Body, str]:
        """Tetrahedra that follow a relief [mm], shape [vertex_count], and how these came about, in words; remembered.

        They are those of the run, those that were made last for such a relief, or new ones; meshing a third time was never seen to follow
        more. Asked again they are the same, whatever was meshed since.
        """
        if not np.any(displacement):
            return self.plain[0], MORPHED
        name = f"{CARRIER}{self.run}-{digest_of(displacement)}"
        chosen = self.memo.recall(name, Carrier)
        if chosen is not None and (body := self.known(chosen.mesh)) is not None:
            return body, chosen.meshing
        body, meshing = self._that_follows(displacement)
        self.memo.remember(name, Carrier(mesh=body.tets.digest, meshing=meshing), anew=True)
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
            body = self._made_for(displacement)
        except MechStyleError as error:
            return self.first, f"{MORPHED}, following {here.words}, as the part could not be meshed again: {error}"
        there = body.followed(body.morph.morphed(displacement))
        return body, AGAIN if there.enough else f"{AGAIN}, but following {there.words}"

    def _made_for(self, displacement: NDArray[np.float32]) -> Body:
        """Tetrahedra made for half of a relief, which are kept for the next."""
        name, objects = f"{MESH_FOR}{digest_of(displacement)}", self.memo.objects
        kept = self.memo.recall(name, KeptMesh)
        if kept is None:
            made, half = carrying(self.first.skin.surface, displacement, partial(self.progress, 0.0))
            kept = KeptMesh(tets=objects.put_mesh(made), at=objects.put_array(half))
            self.memo.remember(name, kept)
        tets, at = objects.get_mesh(kept.tets, TetMesh), objects.get_array(kept.at)
        self.memo.remember(f"{MESH}{tets.digest}", kept)
        self.memo.remember(f"{LAST_MESH}{self.run}", tets.digest, anew=True)
        return replace(self.first, tets=tets, at=at)


def carrying(surface: SurfaceMesh, relief: NDArray[np.float32], go_on: CancelCheck = never_cancel) -> tuple[TetMesh, NDArray[np.float32]]:
    """Tetrahedra that carry a relief [mm], shape [vertex_count], and the half of it they were made for; cached by content.

    What `go_on` raises ends it.

    Raises:
        SimulationFailed: If the surface with half of the relief cannot be meshed.
    """
    half, exaggerated = (HALF * relief).astype(np.float32), surface.displaced(EXAGGERATED * relief)
    return fill(surface.displaced(half), _count(surface), keep=exaggerated, cache=cache_folder() / "tets", go_on=go_on), half


def at_rest(surface: SurfaceMesh, go_on: CancelCheck = never_cancel) -> TetMesh:
    """Even tetrahedra of a surface without relief; cached by content. What `go_on` raises ends it.

    Raises:
        SimulationFailed: If it cannot be meshed.
    """
    return fill(surface, _count(surface), cache=cache_folder() / "tets", go_on=go_on)


def _count(surface: SurfaceMesh) -> int:
    return max(FEWEST_TETS, round(TETS_PER_KEPT_VERTEX * min(len(surface.vertices), KEPT // 2)))
