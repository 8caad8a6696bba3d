"""Files: one body from every format, its unit and orientation; refusals in one sentence; whole files or none."""

import io
import json
import os
import re
import stat
import struct
import warnings
import zipfile
import zlib
from xml.etree import ElementTree as ET

import manifold3d
import numpy as np
import pytest
import trimesh

from mechstyle.errors import BadInput
from mechstyle.geometry import files
from mechstyle.geometry.files import FORMATS, read, save
from mechstyle.records.mesh import SurfaceMesh

CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"


def stepped():
    """A block of 10 x 20 x 30 mm with one corner cut out: no rotation or reflection maps it onto itself."""
    body = manifold3d.Manifold.cube((10, 20, 30)) - manifold3d.Manifold.cube((4, 7, 11))
    mesh = body.to_mesh64()
    return SurfaceMesh(mesh.vert_properties, mesh.tri_verts)


PART = stepped()
VOLUME = 6000.0 - 4 * 7 * 11


def sorted_rows(points):
    return np.array(sorted(np.round(points, 3).tolist()))


def assert_is_part(mesh, *, scale=1.0):
    """The same corners in the same places, and the same volume."""
    assert mesh.is_closed
    assert mesh.volume == pytest.approx(VOLUME * scale**3, rel=1e-6)
    assert np.allclose(sorted_rows(mesh.vertices), sorted_rows(PART.vertices * scale), atol=2e-3)  # of rounding before sorting


def exported(kind, vertices=PART.vertices, faces=PART.faces):
    content = trimesh.Trimesh(vertices, faces, process=False).export(file_type=kind)
    return content.encode() if isinstance(content, str) else content


def ascii_ply(vertices=PART.vertices, faces=PART.faces):
    head = f"ply\nformat ascii 1.0\nelement vertex {len(vertices)}\nproperty float x\nproperty float y\nproperty float z\n"
    head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    rows = [" ".join(map(str, vertex)) for vertex in vertices] + [" ".join(map(str, (3, *face))) for face in faces]
    return (head + "\n".join(rows) + "\n").encode()


def obj_by_normals():
    """Every face with vertices and a normal of its own, as programs write flat shading; two groups, one material and comments."""
    lines = ["# part", "mtllib not_there.mtl", "o part"]
    for corners, normal in zip(PART.corners, PART.face_normals, strict=True):
        lines += [f"v {x} {y} {z}" for x, y, z in corners] + ["vn {} {} {}".format(*normal), "vt 0 0"]
    for number in range(len(PART.faces)):
        lines += {0: ["g front", "usemtl red"], len(PART.faces) // 2: ["g back", "usemtl blue"]}.get(number, [])
        lines.append("f " + " ".join(f"{3 * number + corner}/{number + 1}/{number + 1}" for corner in (1, 2, 3)))
    return "\n".join(lines).encode()


def glb_with_node():
    """In metres and y up, moved and turned by the transformation of its node; PART once that is applied."""
    y_up = PART.vertices[:, [0, 2, 1]] * (1, 1, -1) / 1000
    node = trimesh.transformations.euler_matrix(0.3, 0.5, 0.7)
    node[:3, 3] = 0.1, 0.2, 0.3
    local = (y_up - node[:3, 3]) @ node[:3, :3]
    scene = trimesh.Scene()
    scene.add_geometry(trimesh.Trimesh(local, PART.faces, process=False), transform=node)
    return scene.export(file_type="glb")


def threemf(resources, build, unit='unit="millimeter"'):
    model = f'<?xml version="1.0"?><model {unit} xmlns="{CORE}"><resources>{resources}</resources><build>{build}</build></model>'
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as package:
        package.writestr("3D/3dmodel.model", model)
    return buffer.getvalue()


def xml_object(number, vertices=PART.vertices, faces=PART.faces):
    points = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in vertices)
    triangles = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in faces)
    return f'<object id="{number}" type="model"><mesh><vertices>{points}</vertices><triangles>{triangles}</triangles></mesh></object>'


def threemf_in(unit, millimetres):
    attribute = f'unit="{unit}"' if unit else ""
    return threemf(xml_object(1, PART.vertices / millimetres), '<item objectid="1"/>', attribute)


def threemf_of_components():
    """A component moved by 5 mm in x in an item moved by -5 mm, both as 3 x 4 matrices in rows."""
    shift = "1 0 0 0 1 0 0 0 1 {} 0 0"
    group = f'<object id="2" type="model"><components><component objectid="1" transform="{shift.format(5)}"/></components></object>'
    return threemf(xml_object(1) + group, f'<item objectid="2" transform="{shift.format(-5)}"/>')


def threemf_turned():
    """A quarter turn about z in the item: the matrix of 3MF stands to the right of a row of coordinates."""
    x, y, z = PART.vertices.T
    return threemf(xml_object(1, np.stack([y, -x, z], axis=1)), '<item objectid="1" transform="0 1 0 -1 0 0 0 0 1 0 0 0"/>')


GOOD = {
    "binary.stl": lambda: exported("stl"),
    "ascii.stl": lambda: exported("stl_ascii"),
    "capital.STL": lambda: exported("stl"),
    "plain.obj": lambda: exported("obj"),
    "normals.obj": obj_by_normals,
    "binary.ply": lambda: exported("ply"),
    "ascii.ply": ascii_ply,
    "node.glb": glb_with_node,
    "millimetre.3mf": lambda: threemf_in("millimeter", 1.0),
    "unsaid.3mf": lambda: threemf_in("", 1.0),
    "micron.3mf": lambda: threemf_in("micron", 0.001),
    "centimetre.3mf": lambda: threemf_in("centimeter", 10.0),
    "inch.3mf": lambda: threemf_in("inch", 25.4),
    "foot.3mf": lambda: threemf_in("foot", 304.8),
    "metre.3mf": lambda: threemf_in("meter", 1000.0),
    "components.3mf": threemf_of_components,
    "turned.3mf": threemf_turned,
}


def put(folder, name, content):
    path = folder / name
    path.write_bytes(content)
    return path


def refusal(path, **options):
    with pytest.raises(BadInput) as caught:
        read(path, **options)
    message = str(caught.value)
    assert path.name in message
    assert "\n" not in message
    return message


# --- every format -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", GOOD)
def test_every_format_gives_the_same_body_without_a_word(tmp_path, capfd, name):
    assert_is_part(read(put(tmp_path, name, GOOD[name]())).mesh)
    assert capfd.readouterr() == ("", "")


def test_quads_are_read(tmp_path):
    corners = [(x, y, z) for x in (0, 10) for y in (0, 10) for z in (0, 10)]
    sides = [(1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4)]
    lines = ["v {} {} {}".format(*corner) for corner in corners] + ["f {} {} {} {}".format(*side) for side in sides]
    mesh, notes = read(put(tmp_path, "quads.obj", "\n".join(lines).encode()))
    assert mesh.volume == pytest.approx(1000)
    assert notes == ()


def test_components_used_twice_are_two_bodies(tmp_path):
    item = '<item objectid="1" transform="1 0 0 0 1 0 0 0 1 {} 0 0"/>'
    path = put(tmp_path, "twice.3mf", threemf(xml_object(1), item.format(0) + item.format(40)))
    assert "holds 2 separate bodies" in refusal(path)
    overlapping = put(tmp_path, "touching.3mf", threemf(xml_object(1), item.format(0) + item.format(8)))
    assert "united 2 overlapping bodies" in read(overlapping).notes


def test_what_was_done_is_said(tmp_path):
    assert read(put(tmp_path, "a.ply", exported("ply"))).notes == ()
    corners = 3 * len(PART.faces)
    assert read(put(tmp_path, "a.stl", exported("stl"))).notes == (f"welded {corners - len(PART.vertices)} duplicate vertices",)
    assert read(put(tmp_path, "a.3mf", threemf_in("inch", 25.4))).notes == ("converted to millimetres (times 25.4)",)
    assert read(put(tmp_path, "a.obj", exported("obj")), scale=2.0).notes == ("converted to millimetres (times 2)",)


def test_load_is_read_without_the_notes(tmp_path):
    path = put(tmp_path, "part.stl", exported("stl"))
    assert read(path, scale=2.0).mesh.digest == read(str(path), scale=2.0).mesh.digest


# --- units and sizes ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["stl", "obj", "ply"])
def test_scale_takes_the_coordinates_to_millimetres(tmp_path, kind):
    assert_is_part(read(put(tmp_path, f"inches.{kind}", exported(kind, PART.vertices / 25.4)), scale=25.4).mesh)


def test_scale_replaces_the_unit_of_the_format(tmp_path):
    y_up = PART.vertices[:, [0, 2, 1]] * (1, 1, -1)
    assert_is_part(read(put(tmp_path, "millimetres.glb", exported("glb", y_up)), scale=1.0).mesh)
    assert_is_part(read(put(tmp_path, "inches.3mf", threemf_in("inch", 1.0)), scale=1.0).mesh)


@pytest.mark.parametrize("scale", [0.0, -1.0, float("nan"), float("inf")])
def test_a_scale_that_is_none_is_refused(tmp_path, scale):
    with pytest.raises(BadInput, match=r"^scale is .*, but must be a positive number"):
        read(put(tmp_path, "part.stl", exported("stl")), scale=scale)


@pytest.mark.parametrize(
    ("factor", "size", "hint"),
    [
        (1 / 25.4, "1.18 mm", "inches (--scale 25.4) or centimetres (--scale 10)"),
        (1e-3, "0.03 mm", "if its coordinates are metres (--scale 1000), say so"),
        (1e3, "30000 mm", "if its coordinates are micrometres (--scale 0.001), say so"),
        (100.0, "3000 mm", "give a factor with --scale"),
        (1e-6, "3e-05 mm", "give a factor with --scale"),
    ],
)
def test_sizes_that_nobody_prints_are_refused_with_a_guess(tmp_path, factor, size, hint):
    message = refusal(put(tmp_path, "part.stl", exported("stl", PART.vertices * factor)))
    assert f"is {size} long; parts must be 5 to 1000 mm" in message
    assert hint in message


def test_the_guess_can_be_taken_at_its_word(tmp_path):
    """Programs write glTF in millimetres against its standard; the factor offered is one from the file's coordinates."""
    path = put(tmp_path, "part.glb", exported("glb", PART.vertices[:, [0, 2, 1]] * (1, 1, -1)))
    message = refusal(path)
    assert "is 30000 mm long" in message
    assert "millimetres (--scale 1)" in message
    assert_is_part(read(path, scale=1.0).mesh)


@pytest.mark.parametrize("longest", [5.0, 1000.0])
def test_the_smallest_and_the_largest_part_pass_whatever_the_rounding(tmp_path, longest):
    assert read(put(tmp_path, "part.ply", ascii_ply()), scale=longest / 30).mesh.extents.max() == pytest.approx(longest)


def test_vertices_without_faces_have_no_say_in_the_size(tmp_path):
    assert_is_part(read(put(tmp_path, "part.obj", exported("obj") + b"\nv 5000 0 0\n")).mesh)


def test_coinciding_vertices_have_no_size(tmp_path):
    assert "has no extent" in refusal(put(tmp_path, "part.ply", ascii_ply(PART.vertices * 0.0)))


# --- what cannot be read ------------------------------------------------------------------------------------------

RAW = {
    "part.stl": lambda: exported("stl"),
    "ascii.stl": lambda: exported("stl_ascii"),
    "part.obj": lambda: exported("obj"),
    "part.ply": lambda: exported("ply"),
    "ascii.ply": ascii_ply,
    "part.glb": glb_with_node,
    "part.3mf": lambda: threemf_in("millimeter", 1.0),
}
RUBBISH = {
    "words": b"this is a letter\nand not a mesh\n",
    "noise": np.random.default_rng(0).bytes(600),
    "zeros": bytes(400),
    "picture": b"\x89PNG\r\n\x1a\n" + b"IHDR" * 40,
    "page": b"<!DOCTYPE html><html><body>404 not found</body></html>",
    "zip": threemf("", "")[:60],
}


@pytest.mark.parametrize("suffix", FORMATS)
def test_a_missing_file_is_refused(tmp_path, capfd, suffix):
    assert "does not exist; check the path" in refusal(tmp_path / f"gone.{suffix}")
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("suffix", FORMATS)
def test_an_empty_file_is_refused(tmp_path, suffix):
    assert "is empty" in refusal(put(tmp_path, f"part.{suffix}", b""))


@pytest.mark.parametrize("suffix", FORMATS)
@pytest.mark.parametrize("rubbish", RUBBISH)
def test_what_is_no_mesh_is_refused(tmp_path, capfd, suffix, rubbish):
    message = refusal(put(tmp_path, f"part.{suffix}", RUBBISH[rubbish]))
    assert re.search("holds no triangles|cannot be read as", message)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("name", RAW)
@pytest.mark.parametrize("share", [0.05, 0.3, 0.5, 0.7, 0.9])
def test_a_truncated_file_is_refused(tmp_path, capfd, name, share):
    content = RAW[name]()
    refusal(put(tmp_path, name, content[: int(share * len(content))]))
    assert capfd.readouterr() == ("", "")


def test_a_file_of_points_is_refused(tmp_path):
    points = "\n".join("v {} {} {}".format(*vertex) for vertex in PART.vertices)
    refusal(put(tmp_path, "part.obj", points.encode()))
    refusal(put(tmp_path, "part.ply", ascii_ply(faces=np.empty((0, 3), int))))
    refusal(put(tmp_path, "part.3mf", threemf(xml_object(1, faces=[]), '<item objectid="1"/>')))


def test_an_object_that_is_not_built_is_no_part(tmp_path):
    refusal(put(tmp_path, "part.3mf", threemf(xml_object(1), "")))


@pytest.mark.parametrize("index", [10_000, -10_000])
@pytest.mark.parametrize("name", ["part.ply", "part.3mf", "part.obj"])
def test_a_face_with_vertices_that_are_not_there_is_refused(tmp_path, name, index):
    faces = PART.faces.copy()
    faces[3, 1] = index
    content = {
        "part.ply": lambda: ascii_ply(faces=faces),
        "part.3mf": lambda: threemf(xml_object(1, faces=faces), '<item objectid="1"/>'),
        "part.obj": lambda: exported("obj") + f"\nf 1 2 {index}\n".encode(),
    }[name]()
    refusal(put(tmp_path, name, content))


@pytest.mark.parametrize("value", [np.nan, np.inf])
@pytest.mark.parametrize("name", ["part.stl", "part.obj", "part.ply", "part.glb", "part.3mf"])
def test_coordinates_that_are_not_finite_are_refused(tmp_path, capfd, name, value):
    vertices = PART.vertices.copy()
    vertices[2, 1] = value
    content = threemf(xml_object(1, vertices), '<item objectid="1"/>') if name == "part.3mf" else None
    with np.errstate(all="ignore"):
        assert "not finite numbers" in refusal(put(tmp_path, name, content or exported(name[-3:], vertices)))
    assert capfd.readouterr() == ("", "")


def test_remarks_of_the_reader_go_no_further(tmp_path, monkeypatch):
    path, reader = put(tmp_path, "part.stl", exported("stl")), trimesh.load_scene

    def remarks(*args, **options):
        warnings.warn("something deprecated", DeprecationWarning, stacklevel=1)
        return reader(*args, **options)

    monkeypatch.setattr(trimesh, "load_scene", remarks)
    assert_is_part(read(path).mesh)


PARSERS_RAISE = [
    ValueError("chunk was not expected length!"), KeyError("count"), IndexError("13"), TypeError("data type '' not understood"),
    AttributeError("'str' object has no attribute 'get'"), UnboundLocalError("access"), AssertionError(), StopIteration(), OverflowError(),
    NotImplementedError("only glTF 2"), RuntimeError("encrypted"), RecursionError(), MemoryError(), EOFError(), OSError("no picture"),
    SyntaxError("XML"), struct.error("unpack"), zlib.error("invalid distance"), zipfile.BadZipFile(),
]  # fmt: skip
"""One of each kind that trimesh, lxml and zipfile raised at damaged files of every format."""


@pytest.mark.parametrize("error", PARSERS_RAISE, ids=lambda error: type(error).__name__)
def test_whatever_a_parser_raises_is_one_sentence_on_the_file(tmp_path, monkeypatch, error):
    def parser(*_args, **_options):
        raise error

    monkeypatch.setattr(trimesh, "load_scene", parser)
    assert "damaged, was cut off, or is something else" in refusal(put(tmp_path, "part.stl", exported("stl")))


def read_by(monkeypatch, tmp_path, reader):
    monkeypatch.setattr(trimesh, "load_scene", reader)
    return read(put(tmp_path, "part.stl", exported("stl")))


def test_what_we_call_wrongly_is_not_said_of_the_file(tmp_path, monkeypatch):
    """An older trimesh without a function, or with other arguments or results, would have every file said to be damaged."""
    with monkeypatch.context() as patched, pytest.raises(TypeError, match="unexpected keyword"):
        read_by(patched, tmp_path, lambda _file: None)
    with monkeypatch.context() as patched, pytest.raises(AttributeError, match="to_mesh"):
        read_by(patched, tmp_path, lambda *_args, **_options: object())
    path = put(tmp_path, "part.stl", exported("stl"))
    monkeypatch.delattr(trimesh, "load_scene")
    with pytest.raises(AttributeError, match="load_scene"):
        read(path)


@pytest.mark.parametrize("error", [ModuleNotFoundError("lxml"), NameError("a typing error")])
def test_what_no_file_can_cause_is_not_said_of_the_file(tmp_path, monkeypatch, error):
    def broken(*_args, **_options):
        raise error

    with pytest.raises(type(error)):
        read_by(monkeypatch, tmp_path, broken)


def gltf(document):
    """A GLB of any JSON."""
    words = json.dumps(document).encode()
    words += b" " * (-len(words) % 4)
    return b"glTF" + struct.pack("<II", 2, 20 + len(words)) + struct.pack("<I", len(words)) + b"JSON" + words


@pytest.mark.parametrize("document", [[], {"meshes": "x"}, {"nodes": [1]}, {"accessors": [{"count": 10**20}]}, {"bufferViews": {}}])
def test_a_sound_container_of_something_else_is_refused(tmp_path, capfd, document):
    refusal(put(tmp_path, "part.glb", gltf({"asset": {"version": "2.0"}, **document} if isinstance(document, dict) else document)))
    assert capfd.readouterr() == ("", "")


def test_words_for_coordinates_are_refused(tmp_path):
    refusal(put(tmp_path, "part.3mf", threemf(xml_object(1, [("a", "b", "c"), *PART.vertices[1:]]), '<item objectid="1"/>')))


def test_a_million_faces_are_the_limit(tmp_path, monkeypatch):
    path = put(tmp_path, "part.ply", exported("ply"))
    monkeypatch.setattr(files, "MOST_FACES", len(PART.faces))
    assert_is_part(read(path).mesh)
    monkeypatch.setattr(files, "MOST_FACES", len(PART.faces) - 1)
    assert f"has {len(PART.faces)} faces, more than {len(PART.faces) - 1}: simplify it" in refusal(path)


@pytest.mark.parametrize("name", ["part.step", "part", "part.stl.gz"])
def test_unknown_suffixes_are_refused_with_the_known_ones(tmp_path, name):
    message = refusal(put(tmp_path, name, exported("stl")))
    assert "convert it to stl, obj, ply, glb, 3mf" in message


def test_a_folder_is_refused(tmp_path):
    (tmp_path / "part.stl").mkdir()
    assert "is not a file" in refusal(tmp_path / "part.stl")


def test_a_file_that_cannot_be_opened_is_refused(tmp_path, monkeypatch):
    path = put(tmp_path, "part.stl", exported("stl"))

    def denied(_self):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(type(path), "read_bytes", denied)
    assert "cannot be opened: Permission denied; check its permissions" in refusal(path)


def test_the_repair_names_the_file(tmp_path):
    top = PART.face_normals[:, 2] < 0.5
    assert "open.stl is open and cannot be closed" in refusal(put(tmp_path, "open.stl", exported("stl", faces=PART.faces[top])))


# --- writing ------------------------------------------------------------------------------------------------------


def colours():
    """8-bit colours, all different, as floats."""
    return (np.arange(3 * len(PART.vertices)).reshape(-1, 3) * 5 / 255).astype(np.float32)


@pytest.mark.parametrize("suffix", [*FORMATS, "PLY"])
@pytest.mark.parametrize("coloured", [False, True])
def test_what_is_written_is_read_back(tmp_path, capfd, suffix, coloured):
    mesh = PART.coloured(colours()) if coloured else PART
    path = tmp_path / f"part.{suffix}"
    assert save(mesh, str(path)) == path
    assert_is_part(read(path).mesh)
    assert capfd.readouterr() == ("", "")


def colours_by_place(points, rgb):
    return {tuple(place): tuple(colour) for place, colour in zip(np.round(points, 3).tolist(), rgb.tolist(), strict=True)}


@pytest.mark.parametrize("suffix", ["obj", "ply"])
def test_colours_come_back_to_eight_bits(tmp_path, suffix):
    path = save(PART.coloured(colours()), tmp_path / f"part.{suffix}")
    back = trimesh.load_scene(path, process=False).to_mesh()
    assert colours_by_place(back.vertices + 0.0, back.visual.vertex_colors[:, :3]) == colours_by_place(
        PART.vertices + 0.0, np.round(colours() * 255).astype(int)
    )


def test_colours_of_3mf_come_back_as_its_palette(tmp_path):
    path = save(PART.coloured(colours()), tmp_path / "part.3mf")
    with zipfile.ZipFile(path) as package:
        group = ET.fromstring(package.read("3D/3dmodel.model")).find(".//{*}colorgroup")
    written = {tuple(bytes.fromhex(colour.get("color")[1:])) for colour in group}
    assert written == {tuple(rgb) for rgb in np.round(colours() * 255).astype(int).tolist()}


def test_colours_out_of_range_are_clipped(tmp_path):
    path = save(PART.coloured(np.full_like(colours(), 2.0)), tmp_path / "part.ply")
    assert (trimesh.load_mesh(path, process=False).visual.vertex_colors == 255).all()


def test_glb_is_written_in_metres_with_y_up(tmp_path):
    path = save(PART, tmp_path / "part.glb")
    assert trimesh.load_scene(path).extents == pytest.approx((0.010, 0.030, 0.020))


@pytest.mark.parametrize("suffix", FORMATS)
def test_the_same_mesh_gives_the_same_file(tmp_path, suffix):
    mesh = PART.coloured(colours())
    assert save(mesh, tmp_path / f"a.{suffix}").read_bytes() == save(mesh, tmp_path / f"b.{suffix}").read_bytes()


def test_folders_are_made_and_nothing_else_is_left(tmp_path):
    path = save(PART, tmp_path / "new" / "deep" / "part.ply")
    assert list(path.parent.iterdir()) == [path]


@pytest.mark.skipif(os.name != "posix", reason="rights are those of POSIX")
def test_others_may_read_what_is_written(tmp_path):
    assert stat.S_IMODE(save(PART, tmp_path / "part.ply").stat().st_mode) == 0o644


@pytest.mark.parametrize("name", ["part.step", "part"])
def test_unknown_suffixes_are_not_written(tmp_path, name):
    with pytest.raises(BadInput, match=rf"^{name}: cannot write .*; use stl, obj, ply, glb, 3mf$"):
        save(PART, tmp_path / name)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("step", ["fdopen", "chmod", "replace"])
@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_a_write_that_fails_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch, step, error):
    path = put(tmp_path, "part.ply", b"the old one")

    def fails(*_, **__):
        raise error

    monkeypatch.setattr(os if step == "fdopen" else type(path), step, fails)
    expected = BadInput if isinstance(error, OSError) else KeyboardInterrupt
    with pytest.raises(expected) as caught:
        save(PART, path)
    if expected is BadInput:
        assert str(caught.value) == f"cannot write {path}: No space left on device; choose another place, or make room"
    assert path.read_bytes() == b"the old one"
    assert list(tmp_path.iterdir()) == [path]


def test_a_folder_is_not_written_over(tmp_path):
    (tmp_path / "part.ply").mkdir()
    with pytest.raises(BadInput, match=r"^cannot write .*part\.ply: "):
        save(PART, tmp_path / "part.ply")
    assert list(tmp_path.iterdir()) == [tmp_path / "part.ply"]


def test_a_folder_that_is_a_file_is_refused(tmp_path):
    put(tmp_path, "results", b"")
    with pytest.raises(BadInput, match=r"^cannot write .*part\.ply: "):
        save(PART, tmp_path / "results" / "part.ply")
