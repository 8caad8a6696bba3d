"""A part made ready for a run: standardised surface, tetrahedra, wall thickness and what it stands on, cached by content."""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Protocol

import msgspec
import numpy as np
from numpy.typing import NDArray

from mechstyle._files import cache_folder
from mechstyle.errors import BadInput, unknown
from mechstyle.fea.explicit import no_progress
from mechstyle.geometry.borders import Extent
from mechstyle.geometry.cancelling import CancelCheck, meanwhile, never_cancel
from mechstyle.geometry.inside_outside import is_inside, sky_seen
from mechstyle.geometry.level_base import LevelBase
from mechstyle.geometry.mating import mating_ends
from mechstyle.geometry.region_selection import inside, protection
from mechstyle.geometry.remeshing import even as standardise
from mechstyle.geometry.remeshing.filling import VERSION as TETRAHEDRA
from mechstyle.geometry.remeshing.filling import fill
from mechstyle.geometry.resting_face import resting_face
from mechstyle.geometry.subdivision import refined_to
from mechstyle.geometry.thickness import local_thickness
from mechstyle.geometry.transfer import SurfaceMean
from mechstyle.loop import minimum_wall as walls
from mechstyle.loop.bounds import Bounds
from mechstyle.loop.objects import Memo, Objects
from mechstyle.records import Recipe
from mechstyle.records.mesh import STANDARD_VERTICES, Floats, SurfaceMesh, TetMesh, check_vertices
from mechstyle.records.recipe import BASES
from mechstyle.records.regions import Inside, Outside, Region
from mechstyle.records.simulation import THICKER
from mechstyle.styling.dimensions import outwards
from mechstyle.styling.prompt import reading_of

PREPARATION_VERSION = 10
"""Counts changes that alter the prepared part, so that cached parts of older code are not reused."""

EVEN = 25_000
"""Vertices of a surface that is made even, at most; beyond that its faces are cut smaller, which is quick and moves nothing …"""
MOST_PARTS = 4
"""… every edge into so many parts at most …"""
EDGE = 0.6
"""… and none below about this length [mm], half again the width of a usual line of plastic."""

TETS = 8_000
"""Asked for of every part, whatever its surface has: 3 000 and 25 000 tell what stays bent within 0.02 mm or a tenth. A relief takes more
where they would be thicker than it leaves the wall."""
HALF = np.float32(0.5)
"""Share of the relief that tetrahedra are made for: from there the way to none and to all of it turns the fewest inside out."""

LEAST_WALL = 0.1
"""What is left of a wall at least [mm], where its measure is less than a relief goes in."""

INWARD_SHARE = 0.25
"""Relief may cut at most this share of the local wall …"""
BASE_SHARE = 0.5
"""… and under a levelled part this share of what the wall has above the minimum."""

PLAIN_RAMP = 2.0
"""Way from a plain inside, and from ends left plain, over which the relief grows to its full depth [mm]."""
LEAST_INSIDE = 0.005
"""Share of the surface from which a part has an inside."""
LEFT_PLAIN = "its inside is left plain, so that what belongs into it fits: --inside styled styles it as well"
MATING = "flat ends that may meet something else, as feet and rims do, are left plain: --inside styled styles them as well"
"""Said of a part with an inside, and of one with such ends."""

Stage = Callable[[str], None]

logger = logging.getLogger(__name__)


class Origin(msgspec.Struct, frozen=True, kw_only=True):
    """Origin of a part, as far as it is known: what is needed to prepare it again.

    Attributes:
        model: `gallery:NAME`, or the name of a file without its folder; "" for a mesh from memory.
        vertices: Vertices of the standardised surface asked for.
        scale: Factor on the file's coordinates, None for none.
        up: The axis of the file that points up, "" for its format's own.
        unit: The unit of the file's coordinates, "" for none that was said.
        size: Its longest side [mm], None for none that was said.
        body: Which of its bodies, by name or number, "" for the only one.
    """

    model: str = ""
    vertices: int = STANDARD_VERTICES
    scale: float | None = None
    up: str = ""
    unit: str = ""
    size: float | None = None
    body: str = ""

    @property
    def reading(self) -> dict[str, str | float]:
        """How its file is to be read, but for what is as by default: arguments of `load`, and options of the command line."""
        settings = {"scale": self.scale, "unit": self.unit, "size": self.size, "up": self.up, "body": self.body}
        return {name: value for name, value in settings.items() if value not in (None, "")}

    @classmethod
    def of(cls, mesh: SurfaceMesh, vertices: int) -> Origin:
        """The origin of a part that is prepared from a surface; of a surface that was not loaded only the vertices are known."""
        return msgspec.structs.replace(mesh.origin if isinstance(mesh, Model) else cls(), vertices=vertices)


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Model(SurfaceMesh):
    """A surface as it was loaded from a file or the gallery; what is made from it is a plain `SurfaceMesh` again.

    Attributes:
        name: Name of the gallery model, or of the file without folder and suffix.
        origin: Where it came from.
        notes: What was repaired or converted, one sentence each.
        tets: Tetrahedra that it brings, whose boundary it is: then neither is made anew. None for most.
    """

    name: str
    origin: Origin
    notes: tuple[str, ...] = ()
    tets: TetMesh | None = None


@dataclass(frozen=True, eq=False)
class Shape:
    """A part without style: its surface and walls, and what follows from these alone.

    Attributes:
        surface: Standardised surface M_0.
        thickness: Local wall thickness [mm], shape [vertex_count].
    """

    surface: SurfaceMesh
    thickness: NDArray[np.float32]

    @cached_property
    def level_base(self) -> LevelBase:
        """The flat faces it stands on."""
        return LevelBase(self.surface)

    @cached_property
    def inside(self) -> NDArray[np.bool_]:
        """Whether each vertex lies in a hollow or a bore, shape [vertex_count]; nowhere where these are next to nothing."""
        found, areas = is_inside(self.surface), self.surface.vertex_areas
        return found if areas[found].sum() >= LEAST_INSIDE * areas.sum() else np.zeros_like(found)

    @cached_property
    def mating(self) -> Extent:
        """The flat ends that may meet something else."""
        return mating_ends(self.surface)

    @cached_property
    def smooth(self) -> SurfaceMean:
        """A mean over 2 mm along the surface."""
        return SurfaceMean(self.surface)

    @cached_property
    def seen(self) -> NDArray[np.float32]:
        """Share of the sky that each vertex sees, shape [vertex_count]."""
        return sky_seen(self.surface)

    def thinnest(self, relief: NDArray[np.float32]) -> Floats:
        """What is left of each wall [mm], shape [vertex_count], if a relief [mm] cuts as deep into its other side."""
        return np.maximum(self.thickness + 2.0 * np.minimum(relief.astype(np.float64), 0.0), LEAST_WALL)

    def bounds(self, base: str, minimum_wall: float) -> Bounds:
        """Bounds of a style that may go everywhere, by what becomes of the base, one of BASES.

        Into the material a quarter of the wall, out of it as far as `styling.dimensions.outwards` says. A level base may go in by half of
        what the wall has above the minimum [mm], so that a relief that is shifted keeps its depth; a plain one has none. Under either
        nothing goes below the floor. BadInput if there is no such base.
        """
        if base not in BASES:
            raise unknown("base", base, BASES)
        quarter, whole = np.float32(INWARD_SHARE) * self.thickness, np.ones_like(self.thickness)
        if base == "free":
            return Bounds(self.thickness, quarter, self._outward, whole)
        if base == "plain":
            return Bounds(self.thickness, quarter, self._outward, np.where(self.level_base.standing, 0.0, whole), base=self.level_base)
        resting = self.level_base.resting
        spared = BASE_SHARE * np.maximum(self.thickness - minimum_wall, 0.0)
        inward = (resting * spared + (1.0 - resting) * quarter).astype(np.float32)
        return Bounds(self.thickness, inward, self._outward, whole, base=self.level_base)

    def too_thin(self, minimum: float) -> tuple[str, ...]:
        """One sentence if it has a wall below the minimum [mm] before any style is on it."""
        return walls.warnings(self.surface, self.thickness, np.zeros_like(self.thickness), minimum)

    @cached_property
    def _outward(self) -> NDArray[np.float32]:
        return outwards(self.thickness).astype(np.float32)


class Relief(Protocol):
    """The finished relief of a style."""

    def __call__(self, part: Shape, /, *, go_on: CancelCheck) -> NDArray[np.float32] | None:
        """That on a part [mm], shape [vertex_count], or None where it is not known beforehand; what `go_on` raises ends it."""


@dataclass(frozen=True, eq=False)
class Workpiece:
    """A part ready to be styled.

    Attributes:
        surface: Standardised surface M_0.
        tets: Tetrahedra of it displaced by `at`.
        thickness: Local wall thickness [mm], shape [vertex_count].
        stands: Whether it rests on a flat face.
        notes: What a user should know about it, one sentence each.
        at: Displacement its tetrahedra were made for [mm], shape [vertex_count]; None for none.
        mass_gained: What strengthening added to it [g].
    """

    surface: SurfaceMesh
    tets: TetMesh
    thickness: NDArray[np.float32]
    stands: bool
    notes: tuple[str, ...] = ()
    at: NDArray[np.float32] | None = None
    mass_gained: float = 0.0

    @cached_property
    def shape(self) -> Shape:
        """Surface and walls."""
        return Shape(self.surface, self.thickness)

    @cached_property
    def brought_tets(self) -> bool:
        """Whether it came with its tetrahedra: the boundary of those that are made here is never quite the surface."""
        return self.at is None and self.tets.boundary.digest == self.surface.digest


def cached_memo() -> Memo:
    """The user-wide memo: standardised surfaces, thickness and baseline simulations; a folder for each way of making tetrahedra."""
    return Memo(cache_folder() / f"memo-{TETRAHEDRA}", Objects(cache_folder() / "objects"))


def prepare(
    mesh: SurfaceMesh, *, vertices: int = STANDARD_VERTICES, stage: Stage = no_progress, relief: Relief | None = None,
    go_on: CancelCheck = never_cancel, measured: Callable[[Shape], None] = no_progress,
) -> Workpiece:  # fmt: skip
    """Standardise, tetrahedralise and measure a part, reusing what was done before for the same shape.

    Args:
        mesh: A closed surface [mm].
        vertices: Vertices of the standardised surface, ± 5 %; see `standardised`.
        stage: Called with what is being done, in words.
        relief: What it is prepared for: tetrahedra are made for half of it, so that they carry it. None for the part as it is.
        go_on: Asked in between whether to; what it raises ends the work.
        measured: Called with surface and walls, before the minutes that tetrahedra may take.

    Raises:
        BadInput: If it is no surface, or one that cannot be standardised or meshed, or brings tetrahedra of another.
        SimulationFailed: If meshing takes too long or fails.
    """
    if not isinstance(mesh, SurfaceMesh):  # a file's name, most likely
        raise BadInput(f"a part is a surface, not {mesh!r:.80}: open it with ms.load first, which takes a file or gallery:NAME")
    if not mesh.is_closed:
        raise BadInput(
            "the surface is not closed, so it has no inside to simulate: load it from a file, which repairs it, or close it first"
        )
    stage("standardising the surface")
    surface = standardised(mesh, vertices, go_on)
    stage("measuring its walls")
    shape = Shape(surface, local_thickness(surface).astype(np.float32))
    measured(shape)
    go_on()
    stands = resting_face(surface) is not None
    notes = () if stands else ("it has no flat face to stand on, so none of it is kept plain or level",)
    stage("filling it with tetrahedra")
    own = mesh.tets if isinstance(mesh, Model) else None
    if own is not None and own.boundary.digest != mesh.digest:
        raise BadInput("the tetrahedra that this part brings fill another surface: leave them out, and the part is meshed")
    whole = None if relief is None or own is not None else relief(shape, go_on=go_on)
    if own is not None:
        solid, half = own, None
    elif whole is None or not whole.any():
        solid, half = undeformed_mesh(surface, go_on), None
    else:
        with meanwhile(partial(undeformed_mesh, surface), go_on):  # the plain part is dropped as well, and takes its own from the cache
            solid, half = mesh_for_relief(shape, whole, go_on)
    part = Workpiece(surface, solid, shape.thickness, stands, notes, half)
    vars(part)["shape"] = shape  # what was worked out of it need not be again
    return part


Warn = Callable[[Sequence[str]], None]


def logged(sentences: Sequence[str]) -> None:
    """Warn where a program is to find it: in the log."""
    for sentence in sentences:
        logger.warning("%s", sentence)


def refilled(part: Workpiece, relief: Relief, stage: Stage = no_progress, go_on: CancelCheck = never_cancel) -> Workpiece:
    """A part with tetrahedra that carry another relief; as it is if that is not known, or if it came with its own, as in `prepare`.

    What `go_on` raises ends it.
    """
    if part.brought_tets:
        return part
    whole = relief(part.shape, go_on=go_on)
    if whole is None or not whole.any():
        return part
    stage("filling it with tetrahedra")
    tets, at = mesh_for_relief(part.shape, whole, go_on)
    return replace(part, tets=tets, at=at)


def standardised(mesh: SurfaceMesh, vertices: int, go_on: CancelCheck = never_cancel) -> SurfaceMesh:
    """The standardised surface of a part: its faces made even and then, beyond EVEN vertices, cut smaller; cached by content.

    Args:
        mesh: A closed surface [mm].
        vertices: Vertices wanted; of more than EVEN only as many as edges of EDGE need, as a small part has no use for others.
        go_on: Called in between; what it raises ends the work.

    Raises:
        BadInput: If the number of vertices is none that can be asked for, or the surface cannot be made even.
    """
    if isinstance(mesh, Model) and mesh.tets is not None:
        return SurfaceMesh(mesh.vertices, mesh.faces, mesh.colours)
    known = standardised_before(mesh, check_vertices(vertices))
    if known is not None:
        return known
    surface = standardise(mesh, min(vertices, EVEN), go_on=go_on)
    if vertices > EVEN:
        useful = round(float(surface.face_areas.sum()) / (0.5 * np.sqrt(3.0) * EDGE**2))
        surface = refined_to(surface, min(vertices, max(useful, EVEN)), most_parts=MOST_PARTS)
    memo = cached_memo()
    memo.remember(_standardised(mesh, vertices), memo.objects.put_mesh(surface))
    return surface


def standardised_before(mesh: SurfaceMesh, vertices: int) -> SurfaceMesh | None:
    """The surface that `standardised` has made of a part before, None if it has not."""
    memo = cached_memo()
    stored = memo.recall(_standardised(mesh, vertices), str)
    return None if stored is None else memo.objects.get_mesh(stored, SurfaceMesh)


def _standardised(mesh: SurfaceMesh, vertices: int) -> str:
    return hashlib.sha256(f"standardise {PREPARATION_VERSION} {vertices} {mesh.digest}".encode()).hexdigest()


def mesh_for_relief(shape: Shape, relief: NDArray[np.float32], go_on: CancelCheck = never_cancel) -> tuple[TetMesh, NDArray[np.float32]]:
    """Tetrahedra that carry a relief [mm], shape [vertex_count], and the half of it they were made for; cached by content.

    They are about TETS, or as many more as it takes that no wall is thicker than the relief leaves it by more than THICKER of that.
    What `go_on` raises ends it.

    Raises:
        SimulationFailed: If the surface with half of the relief cannot be meshed.
    """
    surface, half = shape.surface, (HALF * relief).astype(np.float32)
    proud = float(HALF) * THICKER * shape.thinnest(relief)  # what half of a relief is missed by, all of it is missed by twice
    styled, cache = surface.displaced(relief), cache_folder() / "tets"
    return fill(surface.displaced(half), TETS, keep=styled, proud=proud, cache=cache, go_on=go_on), half


def undeformed_mesh(surface: SurfaceMesh, go_on: CancelCheck = never_cancel) -> TetMesh:
    """Even tetrahedra of a surface without relief; cached by content. What `go_on` raises ends it.

    Raises:
        SimulationFailed: If it cannot be meshed.
    """
    return fill(surface, TETS, cache=cache_folder() / "tets", go_on=go_on)


def fitted(recipe: Recipe, part: Workpiece) -> Recipe:
    """A recipe for the very surface and tetrahedra of a part."""
    return recipe.on(surface=part.surface.digest, tetrahedra=part.tets.digest)


def bounds_for(part: Workpiece | Shape, recipe: Recipe) -> tuple[Bounds, tuple[str, ...]]:
    """Bounds of a recipe's style on a part, and notes for the user on what is protected."""
    shape = part if isinstance(part, Shape) else part.shape
    named = any(isinstance(region, Inside | Outside) for region in (*recipe.restraint.protect, *_places(recipe)))
    fits = not named and recipe.restraint.inside == "plain"
    hollow, mates = fits and shape.inside.any(), fits and shape.mating.holds.any()
    bounds = shape.bounds(recipe.restraint.base, recipe.delivery.minimum_wall)
    kept = [(held, note) for held, note, there in ((inside(shape.surface), LEFT_PLAIN, hollow), (shape.mating, MATING, mates)) if there]
    protected = protection(recipe.restraint.protect, part.surface, part.thickness, [(held, PLAIN_RAMP) for held, _ in kept])
    free = np.minimum(bounds.freedom, protected.freedom).astype(np.float32)
    plain = np.logical_or.reduce([held.holds for held, _ in kept]) if kept else np.zeros(len(free), bool)
    notes = (*protected.notes, *(note for _, note in kept))
    return replace(bounds, freedom=free, uncoloured=protected.uncoloured[:, None], plain=plain, seen=shape.seen), notes


def _places(recipe: Recipe) -> tuple[Region, ...]:
    """The places that a prompt names, if it is one that is read here."""
    if recipe.style.stylizer or recipe.style.guidance == "clip":
        return ()
    return tuple(region for wish in reading_of(recipe).wishes for region in (*wish.where, *wish.spared))
