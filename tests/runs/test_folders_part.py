"""The prepared part in a run directory: it comes back as it was, and parts of different parts are refused."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from mechstyle.errors import DamagedStore
from mechstyle.loop.objects import Objects
from mechstyle.records.mesh import SurfaceMesh, TetMesh
from mechstyle.runs.folders import PartRecord
from mechstyle.simulation.part import Origin, Workpiece

FILE = Path("run/part.json")


@pytest.fixture
def objects(tmp_path):
    return Objects(tmp_path / "objects")


@pytest.fixture
def prepared(cube):
    """A part whose tetrahedra were made for a relief; they need not fill it."""
    tets = TetMesh(np.vstack([np.zeros(3), 10.0 * np.eye(3)]), [[0, 1, 2, 3]])
    at = np.linspace(0.0, 0.5, 8, dtype=np.float32)
    return Workpiece(cube, tets, np.linspace(1.0, 9.0, 8, dtype=np.float32), True, ("a note",), at, 1.5)


def test_a_part_comes_back_as_it_was(prepared, objects):
    record = PartRecord.kept(prepared, "cube", Origin(model="cube.stl"), objects)
    again = msgspec.json.decode(msgspec.json.encode(record), type=PartRecord).part(objects, FILE)
    assert (again.surface.digest, again.tets.digest) == (prepared.surface.digest, prepared.tets.digest)
    assert np.array_equal(again.thickness, prepared.thickness)
    assert np.array_equal(again.at, prepared.at)
    assert (again.stands, again.notes, again.mass_gained) == (True, ("a note",), 1.5)


def test_a_part_without_a_relief_has_none_when_it_comes_back(prepared, objects):
    plain = Workpiece(prepared.surface, prepared.tets, prepared.thickness, stands=True)
    record = PartRecord.kept(plain, "cube", Origin(), objects)
    assert record.at == ""
    assert record.part(objects, FILE).at is None


@pytest.mark.parametrize("field", ["thickness", "at"])
@pytest.mark.parametrize("wrong", [np.ones(7, "f4"), np.ones((8, 1), "f4"), np.ones(8, "i4")], ids=["short", "wide", "whole numbers"])
def test_walls_or_a_relief_of_another_part_are_refused_with_the_file(prepared, objects, field, wrong):
    record = PartRecord.kept(prepared, "cube", Origin(), objects)
    forged = msgspec.structs.replace(record, **{field: objects.put_array(wrong)})
    with pytest.raises(DamagedStore, match=r"part\.json has walls of another part"):
        forged.part(objects, FILE)


@pytest.mark.parametrize("faces", [[[0, 1, 2]], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]], ids=["open", "inside out"])
def test_what_encloses_nothing_is_not_dropped(prepared, faces):
    """The unsafe side: such a part has no weight, and survives every fall."""
    corners = np.vstack([np.zeros(3), 10.0 * np.eye(3)])
    surface = SurfaceMesh(corners, np.array(faces) if len(faces) == 1 else np.array(faces)[:, ::-1])
    hollow = Workpiece(surface, prepared.tets, np.ones(4, np.float32), stands=True)
    with pytest.raises(DamagedStore, match="encloses nothing"):
        PartRecord.droppable(hollow, FILE)
    assert PartRecord.droppable(prepared, FILE) is prepared


def test_the_name_of_a_file_made_of_it_leads_nowhere_else(prepared, objects):
    assert "/" not in PartRecord.kept(prepared, "../../away", Origin(), objects).stem
