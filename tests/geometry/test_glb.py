"""Binary glTF as the specification has it: linear colours, a dull material, metres with y up, a texture in the file."""

import io
import json
import struct
from itertools import pairwise

import meshio
import numpy as np
import pytest
import trimesh
from PIL import Image

from mechstyle.errors import BadInput
from mechstyle.geometry.files import save
from mechstyle.geometry.glb import glb_bytes, linear
from mechstyle.geometry.texture import Atlas
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


@pytest.mark.parametrize(("display", "light"), [(0.0, 0.0), (0.04045, 0.0031308), (0.5, 0.2140), (1.0, 1.0)])
def test_light_is_linear(display, light):
    assert linear(np.array([display])) == pytest.approx(light, abs=1e-4)


def test_colours_at_vertices_are_linear_light_in_sixteen_bits(cube):
    document, array = parsed(glb_bytes(cube.coloured(colours(cube)), "cube"))
    accessor = document["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"]
    assert document["accessors"][accessor]["normalized"] is True
    assert np.allclose(array(accessor) / 65535.0, np.column_stack([linear(colours(cube)), np.ones(8)]), atol=1e-5)


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


@pytest.mark.parametrize("painted", [False, True])
def test_fields_are_attributes_with_an_underscore_at_every_vertex_and_of_a_kind_the_specification_allows(cube, painted):
    document, array = parsed(glb_bytes(cube, "cube", textured(cube) if painted else None, FIELDS))
    attributes = document["meshes"][0]["primitives"][0]["attributes"]
    assert {name for name in attributes if name.startswith("_")} == {"_STRESS", "_SAFETY_FACTOR"}
    accessors = [document["accessors"][number] for number in attributes.values()]
    assert len({accessor["count"] for accessor in accessors}) == 1
    for name, values in FIELDS.items():
        accessor = document["accessors"][attributes[f"_{name.upper()}"]]
        assert (accessor["componentType"], accessor["type"]) == (5126, "SCALAR")
        assert np.array_equal(array(attributes[f"_{name.upper()}"])[:, 0], values[cube.faces.ravel()] if painted else values)
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


# --- textures -----------------------------------------------------------------------------------------------------


def textured(mesh: SurfaceMesh, parts: int = 4):
    """A texture that shows, everywhere on a part, the place there as a colour."""
    atlas = Atlas(len(mesh.faces), parts)
    texels = atlas.texels
    return atlas.painted(np.einsum("ij,ijk->ik", texels.weights, colours(mesh)[mesh.faces[texels.face]]))


def looked_up(texture, uv):
    """Colours of a texture, averaged between its four nearest texels as viewers do."""
    height, width = texture.pixels.shape[:2]
    x, y = uv[:, 0] * width - 0.5, (1.0 - uv[:, 1]) * height - 0.5
    left, top = np.floor(x).astype(int), np.floor(y).astype(int)
    pixel = texture.pixels.astype(float) / 255.0
    across, down = (x - left)[:, None], (y - top)[:, None]
    rows = [pixel[top + k, left] * (1.0 - across) + pixel[top + k, left + 1] * across for k in (0, 1)]
    return rows[0] * (1.0 - down) + rows[1] * down


@pytest.mark.parametrize("parts", [1, 2, 5, 8])
def test_everywhere_on_every_face_the_texture_shows_the_colour_of_that_place(sphere, parts):
    mesh = SurfaceMesh(sphere.vertices, sphere.faces[:77])
    texture = textured(mesh, parts)
    weights = np.random.default_rng(0).dirichlet((0.4, 0.4, 0.4), (77, 40))
    places = np.einsum("fnk,fkc->fnc", weights, texture.uv).reshape(-1, 2)
    expected = np.einsum("fnk,fkc->fnc", weights, colours(mesh)[mesh.faces]).reshape(-1, 3)
    assert np.abs(looked_up(texture, places) - expected).max() < 0.0045


def test_places_of_faces_do_not_overlap_and_a_texture_keeps_to_its_largest_size():
    for count in (1, 2, 7, 50):
        atlas = Atlas(count, 3)
        shown = atlas.painted(np.tile(atlas.texels.face[:, None] / 200.0, (1, 3))).pixels[..., 0]
        written = np.round(np.arange(count) / 200.0 * 255.0)
        assert {value: int(np.sum(shown == value)) for value in written} == dict.fromkeys(written, 26), "ten texels and a rim of sixteen"
    assert Atlas(400_000).parts < Atlas(50_000).parts == 8
    assert Atlas(400_000).parts > 1


def test_a_glb_carries_its_texture_inside(cube, tmp_path):
    texture = textured(cube)
    path = save(cube, tmp_path / "cube.glb", texture=texture)
    document, array = parsed(path.read_bytes())
    primitive = document["meshes"][0]["primitives"][0]
    assert "COLOR_0" not in primitive["attributes"], "which would darken the texture"
    uv = array(primitive["attributes"]["TEXCOORD_0"])
    assert np.allclose(uv, texture.uv.reshape(-1, 2) * [1, -1] + [0, 1], atol=1e-6), "v grows downwards"
    back = trimesh.load(path, force="mesh", process=False)
    assert np.array_equal(np.asarray(back.visual.material.baseColorTexture), texture.pixels)
    there = back.visual.to_color().vertex_colors[:, :3] / 255.0
    assert np.abs(there - colours(cube)[cube.faces].reshape(-1, 3)).max() < 0.02


def test_an_obj_names_its_material_and_its_picture(cube, tmp_path):
    texture = textured(cube)
    save(cube, tmp_path / "my cube.obj", name="my cube", texture=texture)
    assert {path.name for path in tmp_path.iterdir()} == {"my cube.obj", "my_cube.mtl", "my_cube-texture.png"}
    assert np.array_equal(np.asarray(Image.open(tmp_path / "my_cube-texture.png")), texture.pixels)
    back = trimesh.load(tmp_path / "my cube.obj", force="mesh", process=False)
    assert back.volume == pytest.approx(1000.0)
    assert np.abs(back.visual.to_color().vertex_colors[:, :3] / 255.0 - back.vertices / 10.0).max() < 0.02


@pytest.mark.parametrize("suffix", ["stl", "ply", "3mf"])
def test_other_formats_hold_no_texture(cube, tmp_path, suffix):
    with pytest.raises(BadInput, match="holds no texture; use glb or obj"):
        save(cube, tmp_path / f"cube.{suffix}", texture=textured(cube))


def test_an_object_of_3mf_has_the_name_of_the_part(cube, tmp_path):
    path = save(cube, tmp_path / "cube.3mf", name='Ann\'s <"cup"> & saucer\n\x07')
    assert list(trimesh.load(io.BytesIO(path.read_bytes()), file_type="3mf").geometry) == ['Ann\'s <"cup"> & saucer']
