"""The prepared part as a run directory keeps it."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np

from mechstyle._files import file_stem
from mechstyle.errors import DamagedStore
from mechstyle.loop.objects import Objects
from mechstyle.records.mesh import SurfaceMesh, TetMesh
from mechstyle.simulation.part import Origin, Workpiece


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
            name=name,
            surface=objects.put_mesh(part.surface),
            tets=objects.put_mesh(part.tets),
            thickness=objects.put_array(part.thickness),
            stands=part.stands,
            notes=part.notes,
            origin=origin,
            at="" if part.at is None else objects.put_array(part.at),
            mass_gained=part.mass_gained,
        )

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
