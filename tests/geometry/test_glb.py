"""Binary glTF as the specification has it: linear colours, a dull material, metres with y up."""

import io
import json
import struct
from itertools import pairwise

import meshio
import numpy as np
import pytest
import trimesh

from mechstyle._colour import srgb_to_linear
from mechstyle.errors import BadInput
from mechstyle.geometry.files import save
from mechstyle.geometry.glb import glb_bytes
from mechstyle.records.mesh import SurfaceMesh

KINDS = {5126: np.float32, 5123: np.uint16, 5125: np.uint32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


def parsed(content: bytes):
    """The document and a function from an accessor's number to its array."""
    magic, version, length = struct.unpack_from("<4sII", content)
    assert (magic, version, length) == (b"glTF", 2, len(content))
    size = struct.unpack_from("<I4s", content, 12)[0]
    document = json.loads(content[20 : 20 + size])
    binary = content[28 + size :]

    def array(number):
        accessor = document["accessors"][number]
        view, kind, width = document["bufferViews"][accessor["bufferView"]], KINDS[accessor["componentType"]], WIDTHS[accessor["type"]]
        assert view["byteOffset"] % 4 == 0
        return np.frombuffer(binary, kind, accessor["count"] * width, view["byteOffset"]).reshape(-1, width)

    return document, array


def colours(mesh: SurfaceMesh) -> np.ndarray:
    return np.clip((mesh.vertices - mesh.vertices.min(axis=0)) / np.ptp(mesh.vertices, axis=0), 0.0, 1.0)


def test_colours_at_vertices_are_linear_light_in_sixteen_bits(cube):
    document, array = parsed(glb_bytes(cube.coloured(colours(cube)), "cube"))
    accessor = document["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"]
    assert document["accessors"][accessor]["normalized"] is True
    assert np.allclose(array(accessor) / 65535.0, np.column_stack([srgb_to_linear(colours(cube)), np.ones(8)]), atol=1e-5)


@pytest.mark.parametrize("coloured", [True, False])
def test_the_material_is_no_metal_and_no_mirror(cube, coloured):
    document, _ = parsed(glb_bytes(cube.coloured(colours(cube)) if coloured else cube, "cube"))
    shaded = document["materials"][document["meshes"][0]["primitives"][0]["material"]]["pbrMetallicRoughness"]
    assert shaded["metallicFactor"] == 0.0
    assert 0.5 <= shaded["roughnessFactor"] <= 1.0
    assert ("baseColorFactor" in shaded) is not coloured, "which would darken the colours"


def test_positions_are_metres_with_y_up_their_limits_told_and_the_part_named(cube):
    tall = cube.moved(cube.vertices * (1.0, 2.0, 3.0))
    document, array = parsed(glb_bytes(tall, "a cup"))
    position = document["meshes"][0]["primitives"][0]["attributes"]["POSITION"]
    assert np.allclose(np.ptp(array(position), axis=0), [0.01, 0.03, 0.02])
    assert document["accessors"][position]["max"] == array(position).max(axis=0).tolist()
    assert document["accessors"][position]["min"] == array(position).min(axis=0).tolist()
    assert document["nodes"][0]["name"] == "a cup"


def test_a_viewer_finds_the_same_solid(cube, tmp_path):
    back = trimesh.load(save(cube.coloured(colours(cube)), tmp_path / "cube.glb"), force="mesh")
    assert back.is_watertight
    assert back.volume == pytest.approx(1e-6)


# --- fields over the surface --------------------------------------------------------------------------------------


FIELDS = {"stress": np.arange(8, dtype=np.float32) * 1.5, "safety_factor": np.linspace(10.0, 0.0, 8, dtype=np.float32)}


def test_fields_are_attributes_with_an_underscore_at_every_vertex_and_of_a_kind_the_specification_allows(cube):
    document, array = parsed(glb_bytes(cube, "cube", FIELDS))
    attributes = document["meshes"][0]["primitives"][0]["attributes"]
    assert {name for name in attributes if name.startswith("_")} == {"_STRESS", "_SAFETY_FACTOR"}
    accessors = [document["accessors"][number] for number in attributes.values()]
    assert len({accessor["count"] for accessor in accessors}) == 1
    for name, values in FIELDS.items():
        accessor = document["accessors"][attributes[f"_{name.upper()}"]]
        assert (accessor["componentType"], accessor["type"]) == (5126, "SCALAR")
        assert np.array_equal(array(attributes[f"_{name.upper()}"])[:, 0], values)
    views = document["bufferViews"]
    assert all(one["byteOffset"] + one["byteLength"] <= two["byteOffset"] for one, two in pairwise(views))


def test_programs_read_the_fields_back(cube, tmp_path):
    there = trimesh.load(save(cube, tmp_path / "cube.glb", fields=FIELDS), force="mesh", process=False)
    assert np.array_equal(there.vertex_attributes["_STRESS"][:, 0], FIELDS["stress"])
    back = meshio.read(save(cube.coloured(colours(cube)), tmp_path / "cube.ply", fields=FIELDS))
    assert np.allclose(back.points, cube.vertices)
    assert all(np.array_equal(back.point_data[name], values) for name, values in FIELDS.items())
    assert "red" in back.point_data


@pytest.mark.parametrize("suffix", ["stl", "obj", "3mf"])
def test_other_formats_hold_no_fields(cube, tmp_path, suffix):
    with pytest.raises(BadInput, match="holds no fields; use glb or ply"):
        save(cube, tmp_path / f"cube.{suffix}", fields=FIELDS)
    assert list(tmp_path.iterdir()) == []


def test_an_object_of_3mf_has_the_name_of_the_part(cube, tmp_path):
    path = save(cube, tmp_path / "cube.3mf", name='Ann\'s <"cup"> & saucer\n\x07')
    assert list(trimesh.load(io.BytesIO(path.read_bytes()), file_type="3mf").geometry) == ['Ann\'s <"cup"> & saucer']
