"""Files: one body from every format, its unit and orientation; whole files or none. What cannot be read: `test_refused_files`."""

import os
import re
import stat
import zipfile
from xml.etree import ElementTree as ET

import manifold3d
import numpy as np
import pytest
import trimesh

from mechstyle.errors import BadInput
from mechstyle.geometry.files import FORMATS, read, save
from support.part_files import PART, ascii_ply, assert_is_part, exported, glb_with_node, put, refusal, threemf, threemf_in, xml_object


def obj_by_normals():
    """Every face with vertices and a normal of its own, as programs write flat shading; two groups, one material and comments."""
    lines = ["# part", "mtllib not_there.mtl", "o part"]
    for corners, normal in zip(PART.corners, PART.face_normals, strict=True):
        lines += [f"v {x} {y} {z}" for x, y, z in corners] + ["vn {} {} {}".format(*normal), "vt 0 0"]
    for number in range(len(PART.faces)):
        lines += {0: ["g front", "usemtl red"], len(PART.faces) // 2: ["g back", "usemtl blue"]}.get(number, [])
        lines.append("f " + " ".join(f"{3 * number + corner}/{number + 1}/{number + 1}" for corner in (1, 2, 3)))
    return "\n".join(lines).encode()


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
    assert notes[1:] == ()


WRITTEN = {
    "a byte-order mark": lambda text: "\ufeff" + text,
    "comments after what they are of": lambda text: text.replace("\n", " # of the house\n"),
    "tabs": lambda text: text.replace(" ", "\t"),
    "indented": lambda text: text.replace("\n", "\n   "),
    "lines of an old Mac": lambda text: text.replace("\n", "\r"),
    "lines of Windows": lambda text: text.replace("\n", "\r\n"),
    "weights": lambda text: re.sub(r"(?m)^(v .*)$", r"\1 1.0", text),
    "words set apart": lambda text: re.sub(r"(?m)end(loop|facet|solid)", r"end \1", text),
    "lines that go on": lambda text: re.sub(r"(?m)^(f \S+) ", r"\1 \\\n ", text),
}


@pytest.mark.parametrize("how", WRITTEN)
@pytest.mark.parametrize("kind", ["obj", "stl", "ply"])
def test_the_same_text_however_it_is_written(tmp_path, kind, how):
    box = trimesh.creation.box((40.0, 30.0, 20.0))
    text = {"obj": "".join(f"v {x} {y} {z}\n" for x, y, z in box.vertices) + "".join(f"f {a} {b} {c}\n" for a, b, c in box.faces + 1)}
    if kind != "obj":
        if how not in {"a byte-order mark", "tabs", "indented", "lines of an old Mac", "lines of Windows", "words set apart"}:
            return
        written = box.export(file_type="stl_ascii") if kind == "stl" else box.export(file_type="ply", encoding="ascii")
        text[kind] = written if isinstance(written, str) else written.decode()
    (tmp_path / f"box.{kind}").write_bytes(WRITTEN[how](text[kind]).encode())
    found = read(tmp_path / f"box.{kind}").mesh
    assert found.extents == pytest.approx((40.0, 30.0, 20.0))
    assert found.volume == pytest.approx(24_000.0)


def test_components_used_twice_are_two_bodies(tmp_path):
    """The second is a mirror image, so it is no copy."""
    item = '<item objectid="1" transform="{} 0 0 0 1 0 0 0 1 {} 0 0"/>'
    path = put(tmp_path, "twice.3mf", threemf(xml_object(1), item.format(1, 0) + item.format(-1, 40)))
    assert "holds 2 separate bodies" in refusal(path)
    overlapping = put(tmp_path, "touching.3mf", threemf(xml_object(1), item.format(1, 0) + item.format(1, 8)))
    assert "united 2 overlapping bodies" in read(overlapping).notes


def test_size_and_mass_are_said_first_and_then_what_was_done(tmp_path):
    size = "10 × 20 × 30 mm, 7.1 g in solid PLA"
    assert read(put(tmp_path, "a.ply", exported("ply"))).notes == (size,)
    assert read(put(tmp_path, "a.stl", exported("stl"))).notes == (size,)
    assert read(put(tmp_path, "a.3mf", threemf_in("inch", 25.4))).notes == (size, "converted to millimetres (times 25.4)")
    twice = "20 × 40 × 60 mm, 56 g in solid PLA"
    assert read(put(tmp_path, "a.obj", exported("obj")), scale=2.0).notes == (twice, "converted to millimetres (times 2)")


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.ply", ascii_ply().replace(b"element vertex", b"comment TextureFile wood.png\nelement vertex")),
        ("a.obj", exported("obj").replace(b"f ", b"usemtl red\nf ", 1)),
    ],
)
def test_colours_in_a_picture_or_a_material_are_said_to_be_left_out(tmp_path, name, content):
    assert "its colours are left out: a style brings its own" in read(put(tmp_path, name, content)).notes


def test_load_is_read_without_the_notes(tmp_path):
    path = put(tmp_path, "part.stl", exported("stl"))
    assert read(path, scale=2.0).mesh.digest == read(str(path), scale=2.0).mesh.digest


# --- units and sizes ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["stl", "obj", "ply"])
def test_scale_takes_the_coordinates_to_millimetres(tmp_path, kind):
    assert_is_part(read(put(tmp_path, f"inches.{kind}", exported(kind, PART.vertices / 25.4)), scale=25.4).mesh)


def test_a_unit_of_3mf_that_nobody_knows_is_refused_unless_a_scale_is_told(tmp_path):
    """A part in furlongs was taken as one in millimetres without a word."""
    path = put(tmp_path, "odd.3mf", threemf_in("furlong", 1.0))
    assert refusal(path) == "odd.3mf is in 'furlong', a unit that 3MF does not have: export it again, or say its unit with --unit"
    assert_is_part(read(path, scale=1.0).mesh)
    assert_is_part(read(path, unit="mm").mesh)


@pytest.mark.parametrize("unit", ["Millimeter", "millimeters", "MM"])
def test_other_spellings_of_a_unit_are_read(unit, tmp_path):
    assert_is_part(read(put(tmp_path, "part.3mf", threemf_in(unit, 1.0))).mesh)


def test_scale_replaces_the_unit_of_the_format(tmp_path):
    y_up = PART.vertices[:, [0, 2, 1]] * (1, 1, -1)
    assert_is_part(read(put(tmp_path, "millimetres.glb", exported("glb", y_up)), scale=1.0).mesh)
    assert_is_part(read(put(tmp_path, "inches.3mf", threemf_in("inch", 1.0)), scale=1.0).mesh)


@pytest.mark.parametrize("number", [0.0, -1.0, float("nan"), float("inf")])
@pytest.mark.parametrize("what", ["scale", "size"])
def test_a_scale_or_a_size_that_is_none_is_refused(tmp_path, what, number):
    with pytest.raises(BadInput, match=rf"^{what} is .*, but must be a positive number"):
        read(put(tmp_path, "part.stl", exported("stl")), **{what: number})


@pytest.mark.parametrize(
    ("factor", "size", "hint"),
    [
        (1 / 25.4, "1.18 mm", "say its unit, such as --unit in or --unit cm or --unit ft, or how long"),
        (1e-3, "0.03 mm", "say its unit, such as --unit m or --unit ft, or how long"),
        (1e3, "30000 mm", "say its unit, such as --unit um, or how long"),
        (100.0, "3000 mm", "1000 mm: say how long it is to be, such as --size 120 for 120 mm"),
        (1e-6, "3e-05 mm", "1000 mm: say how long it is to be, such as --size 120 for 120 mm"),
    ],
)
def test_sizes_that_nobody_prints_are_refused_with_a_guess(tmp_path, factor, size, hint):
    message = refusal(put(tmp_path, "part.stl", exported("stl", PART.vertices * factor)))
    assert f"is {size} long; parts must be 5 to 1000 mm" in message
    assert hint in message


def test_the_guess_can_be_taken_at_its_word(tmp_path):
    """Programs write glTF in millimetres against its standard; the unit offered is one of the file's coordinates."""
    path = put(tmp_path, "part.glb", exported("glb", PART.vertices[:, [0, 2, 1]] * (1, 1, -1)))
    message = refusal(path)
    assert "is 30000 mm long" in message
    assert "--unit mm" in message
    assert_is_part(read(path, unit="mm").mesh)


@pytest.mark.parametrize(
    ("unit", "millimetres"), [("cm", 10.0), ("in", 25.4), ("inches", 25.4), ("Metres", 1e3), ("µm", 1e-3), ("feet", 304.8)]
)
def test_a_unit_is_said_in_words(tmp_path, unit, millimetres):
    path = put(tmp_path, "part.ply", ascii_ply(PART.vertices / millimetres))
    assert_is_part(read(path, unit=unit).mesh)


def test_a_unit_that_there_is_not_and_a_scale_besides_it_are_refused(tmp_path):
    path = put(tmp_path, "part.stl", exported("stl"))
    with pytest.raises(BadInput, match=r"^unknown unit 'ell': known are cm, ft, in, m, mm, um$"):
        read(path, unit="ell")
    with pytest.raises(BadInput, match=r"^a scale and a size are given: one of them says it all$"):
        read(path, scale=2.0, size=9.0)


@pytest.mark.parametrize("factor", [1.0, 1e-3, 1e5])
def test_a_size_makes_a_part_of_any_unit_so_long(tmp_path, factor):
    """Meshes of data sets are normalised to one or two."""
    part = read(put(tmp_path, "part.obj", exported("obj", PART.vertices * factor)), size=60.0)
    assert part.mesh.extents == pytest.approx((20, 40, 60), rel=1e-4)
    assert part.notes[0].startswith("20 × 40 × 60 mm, 56 g")


def shell(outer, wall):
    """An open box with walls of one thickness."""
    x, y, z = outer
    body = manifold3d.Manifold.cube(outer) - manifold3d.Manifold.cube((x - 2 * wall, y - 2 * wall, z)).translate((wall, wall, wall))
    mesh = body.to_mesh64()
    return mesh.vert_properties, mesh.tri_verts.astype(int)


@pytest.mark.parametrize(
    ("part", "why", "answer"),
    [
        (shell((24, 24, 30), 0.24), "would be 24 × 24 × 30 mm with walls of 0.24 mm all over", "--unit cm (240 × 240 × 300 mm)"),
        (shell((3, 3, 4), 0.1), "", "--unit in"),
        (shell((5, 5, 6), 1.0), "would be 5 × 5 × 6 mm, which hardly", "--unit cm (50 × 50 × 60 mm)"),
        (shell((300, 300, 200), 0.2), "with walls of 0.2 mm all over", "--unit mm if it is so small"),
    ],
    ids=["a bottle in cm", "a box in inches", "a cup of 6 mm", "a wall no nozzle lays"],
)
def test_a_size_or_a_wall_that_no_print_has_is_asked_about(tmp_path, part, why, answer):
    path = put(tmp_path, "part.stl", exported("stl", *part))
    message = refusal(path)
    assert why in message
    assert answer in message
    if "hardly" in message:
        assert read(path, unit="mm").mesh.is_closed, "who says so is believed"


def test_an_inch_of_3mf_is_asked_about_in_its_own_unit(tmp_path):
    path = put(tmp_path, "part.3mf", threemf(xml_object(1, PART.vertices / 120), '<item objectid="1"/>', 'unit="inch"'))
    message = refusal(path)
    assert "--unit in if it is so small" in message
    assert "--unit mm" not in message


@pytest.mark.parametrize("longest", [5.0, 1000.0])
def test_the_smallest_and_the_largest_part_pass_whatever_the_rounding(tmp_path, longest):
    assert read(put(tmp_path, "part.ply", ascii_ply()), scale=longest / 30).mesh.extents.max() == pytest.approx(longest)


def test_vertices_without_faces_have_no_say_in_the_size(tmp_path):
    assert_is_part(read(put(tmp_path, "part.obj", exported("obj") + b"\nv 5000 0 0\n")).mesh)


def test_coinciding_vertices_have_no_size(tmp_path):
    assert "has no extent" in refusal(put(tmp_path, "part.ply", ascii_ply(PART.vertices * 0.0)))


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


@pytest.mark.parametrize("step", ["open", "chmod", "replace"])
@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_a_write_that_fails_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch, step, error):
    path = put(tmp_path, "part.ply", b"the old one")

    def fails(*_, **__):
        raise error

    expected = BadInput if isinstance(error, OSError) else KeyboardInterrupt
    with monkeypatch.context() as failing:
        failing.setattr(type(path), step, fails)
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
