"""The folder of a run: the one that was asked for or one next to it, and the prepared part that it keeps."""

from __future__ import annotations

import itertools
import logging
import re
import shlex
from pathlib import Path

import msgspec
import numpy as np

from mechstyle._files import exclusive, file_stem
from mechstyle.errors import BadInput, DamagedStore
from mechstyle.loop.objects import Objects
from mechstyle.loop.store import Store
from mechstyle.records import Recipe
from mechstyle.records.mesh import SurfaceMesh, TetMesh
from mechstyle.simulation.part import Origin, Workpiece

BEGUN = re.compile(r"objects|picture-[0-9a-f]{8}\.png|styled\.png|part\.json|\.new-.*")
"""What a run leaves that is stopped while it begins, before it has a lane."""

logger = logging.getLogger(__name__)


def default_folder(recipe: Recipe) -> Path:
    """`mechstyle-runs/PROMPT-RECIPE`: the same request finds its run again, with whatever tetrahedra it was begun."""
    slug = re.sub(r"[^a-z0-9]+", "-", recipe.style.prompt.lower()).strip("-")[:40] or "run"
    return Path("mechstyle-runs") / f"{slug}-{recipe.on(tetrahedra='').digest[:8]}"


def folder_for(out: Path, recipe: Recipe, *, beside: bool) -> Path:
    """The run directory of a recipe: `out` if it is free or holds that very run, else the first of `out-2`, `out-3`, … that is.

    Tetrahedra do not count: a part that was meshed anew has others, and nothing else. Another folder is logged, and taken only if
    `beside`: people who named a folder on a command line look for the run there.

    Raises:
        BadInput: If `out` holds no run but something else, or another run and `beside` is False.
    """
    _check_kind(out)
    if _takes(out, recipe):
        return out
    if not beside:
        raise _taken(out, recipe)
    named = out if out.name not in ("", "..") else out.resolve()
    numbered = (named.with_name(f"{named.name}-{number}") for number in itertools.count(2))
    found = next(place for place in numbered if not _holds_something_else(place) and _takes(place, recipe))
    logger.warning("%s holds a run with other settings: this one is in %s", out, found)
    return found


def check_free(out: Path, recipe: Recipe, *, beside: bool) -> None:
    """Refuse what `folder_for` would refuse, before the minutes that a part takes to be made ready; meshes not known yet do not count.

    Also refused is a run directory that another process is carrying on.
    """
    _check_kind(out)
    if (lock := out / "locks" / "main.lock").is_file():
        with exclusive(lock, f"lane 'main' of {out}"):
            pass
    if not (beside or _takes(out, recipe)):
        raise _taken(out, recipe)


def _check_kind(out: Path) -> None:
    if _holds_something_else(out):
        raise BadInput(f"{out} exists and is not a run directory: choose another --out")


def _taken(out: Path, recipe: Recipe) -> BadInput:
    """The error for a folder that holds another run."""
    if _takes(out, recipe.on(surface="")):
        return BadInput(f"{out} holds a run of another part: choose another --out")
    command = f"mechstyle branch {shlex.quote(f'{out}@ITERATION')}"
    return BadInput(f"{out} holds a run with other settings: choose another --out, or branch it with `{command}`")


def _holds_something_else(place: Path) -> bool:
    """Whether what is there is neither empty nor a run directory, be it one that was hardly begun."""
    if "main" in Store(place).lanes() or (place / "part.json").exists():
        return False
    return place.exists() and (not place.is_dir() or not all(BEGUN.fullmatch(file.name) for file in place.iterdir()))


def _takes(place: Path, recipe: Recipe) -> bool:
    """Whether a run of this recipe is there, or none at all; of a recipe without a surface, on any part."""
    store, specimen = Store(place), recipe.test.specimen
    if "main" not in store.lanes():
        return True
    kept = store.recipe(store.lane().recipe).on(tetrahedra=specimen.tetrahedra)
    return (kept if specimen.surface else kept.on(surface="")) == recipe


class PartRecord(msgspec.Struct, frozen=True, kw_only=True):
    """The prepared part as a run directory keeps it: digests of stored meshes and arrays, "" for an `at` of nothing."""

    name: str
    surface: str
    tets: str
    thickness: str
    stands: bool
    notes: tuple[str, ...]
    origin: Origin = Origin()
    at: str = ""
    mass_gained: float = 0.0

    @classmethod
    def kept(cls, part: Workpiece, name: str, origin: Origin, objects: Objects) -> PartRecord:
        """The record of a part whose meshes and arrays are stored with it."""
        return cls(
            name=name, surface=objects.put_mesh(part.surface), tets=objects.put_mesh(part.tets), stands=part.stands, notes=part.notes,
            thickness=objects.put_array(part.thickness), at="" if part.at is None else objects.put_array(part.at),
            origin=origin, mass_gained=part.mass_gained,
        )  # fmt: skip

    @property
    def stem(self) -> str:
        """The name as the first part of the name of a file."""
        return file_stem(self.name)

    def part(self, objects: Objects, file: Path) -> Workpiece:
        """The part, read from its objects; DamagedStore, naming the record's file, if they are not of one part."""
        surface, tets = objects.get_mesh(self.surface, SurfaceMesh), objects.get_mesh(self.tets, TetMesh)
        thickness, at = objects.get_array(self.thickness), objects.get_array(self.at) if self.at else None
        for values in (thickness, thickness if at is None else at):
            if values.shape != (len(surface.vertices),) or not np.issubdtype(values.dtype, np.floating):
                raise DamagedStore(f"{file} has walls of another part: restore it from a copy, or start the run again")
        return Workpiece(surface, tets, thickness, self.stands, self.notes, at, self.mass_gained)

    @staticmethod
    def droppable(part: Workpiece, file: Path) -> Workpiece:
        """The part; DamagedStore, naming the record's file, if it encloses nothing, as no part does that was loaded to be styled."""
        if not part.surface.volume > 0.0:
            raise DamagedStore(f"{file} has a part that encloses nothing: restore it from a copy, or start the run again")
        return part
