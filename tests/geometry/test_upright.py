"""Which way is up: every axis can be, handedness stays, and a part that lies on its side is noticed."""

import itertools

import numpy as np
import pytest
import trimesh

from mechstyle import gallery
from mechstyle.errors import BadInput
from mechstyle.geometry.files import read
from mechstyle.geometry.upright import UPS, axis, lying, on_edge, upright
from mechstyle.records.mesh import SurfaceMesh


def solid(mesh: trimesh.Trimesh) -> SurfaceMesh:
    return SurfaceMesh(mesh.vertices, mesh.faces)


CUP = solid(trimesh.creation.cylinder(20.0, 60.0, sections=48))
"""Stands on a flat base, and rolls on its side."""


@pytest.mark.parametrize("up", UPS)
def test_that_axis_points_up_by_a_rotation(up):
    turn = upright(up)
    assert np.allclose(turn @ axis(up), [0.0, 0.0, 1.0])
    assert np.allclose(turn @ turn.T, np.eye(3))
    assert np.linalg.det(turn) == pytest.approx(1.0)


def test_another_axis_is_refused():
    with pytest.raises(BadInput, match="axis for up 'w'"):
        upright("w")


@pytest.mark.parametrize(("suffix", "up"), [*itertools.product(["stl", "glb"], ["", *UPS])])
def test_a_file_is_read_with_that_axis_up(tmp_path, suffix, up):
    sizes = {"x": 10.0, "y": 20.0, "z": 30.0}
    scale = 1e-3 if suffix == "glb" else 1.0
    path = tmp_path / f"box.{suffix}"
    path.write_bytes(trimesh.creation.box([scale * size for size in sizes.values()]).export(file_type=suffix))
    mesh = read(path, up=up).mesh
    assert mesh.extents[2] == pytest.approx(sizes[up[-1] if up else "y" if suffix == "glb" else "z"], rel=1e-5)
    assert mesh.volume == pytest.approx(6000.0, rel=1e-4)


@pytest.mark.parametrize(("told", "held"), [*itertools.product(["z", "y", "-x"], UPS)])
def test_a_cup_on_its_side_is_told_how_it_would_stand(told, held):
    """The cup's own axis lies along `held` in a file that is read with `told` up."""
    in_file = SurfaceMesh(CUP.vertices @ upright(held), CUP.faces)
    as_read = SurfaceMesh(in_file.vertices @ upright(told).T, in_file.faces)
    better = lying(as_read, upright(told))
    if held[-1] == told[-1]:
        assert better == ""
    else:
        assert better[-1] == held[-1]


def test_a_ball_and_a_box_seem_to_lie_as_they_should():
    for mesh in (trimesh.creation.icosphere(3, 20.0), trimesh.creation.box((20.0, 30.0, 40.0))):
        assert lying(solid(mesh), np.eye(3)) == ""


def test_the_note_names_the_option(tmp_path):
    path = tmp_path / "cup.stl"
    path.write_bytes(trimesh.Trimesh(CUP.vertices @ upright("y"), CUP.faces).export(file_type="stl"))
    assert any("--up y sets it upright" in note or "--up -y sets it upright" in note for note in read(path).notes)
    assert not any("--up" in note for note in read(path, up="y").notes)


PLATE = solid(trimesh.creation.box((100.0, 60.0, 3.0)))
"""Lies flat."""


@pytest.mark.parametrize("told", UPS)
def test_a_plate_on_its_thin_edge_is_told_how_it_lies_flat(tmp_path, told):
    path = tmp_path / "plate.stl"
    path.write_bytes(trimesh.Trimesh(PLATE.vertices, PLATE.faces).export(file_type="stl"))
    notes = [note for note in read(path, up=told).notes if "thin edge" in note]
    if told[-1] == "z":
        assert not notes
    else:
        assert notes in ([f"it stands on its thin edge; --up {up} lays it flat"] for up in ("z", "-z"))


def test_no_part_of_the_gallery_is_thought_to_stand_on_an_edge():
    """Among them a book end and a phone stand, which are high and slender where they should be."""
    assert {name: on_edge(gallery.make(name), np.eye(3)) for name in gallery.names()} == dict.fromkeys(gallery.names(), "")
