"""3MF packages: valid against what the specification asks of a mesh, exact, deterministic, in few colours, painted for slicers."""

import io
import json
import os
import zipfile
from collections import Counter
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.geometry.bodies import shell_and_rest
from mechstyle.geometry.filaments import MOST, Painted, clustered, display, nearest
from mechstyle.geometry.threemf import SLICERS, Body, bodies_bytes, threemf_bytes
from support.painting import decoded, state_at
from support.slicer import FOUR_FILAMENTS, prusa_slicer, tools_by_height

CORE = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"
MATERIAL = "{http://schemas.microsoft.com/3dmanufacturing/material/2015/02}"
PRUSA = "{http://schemas.slic3r.org/3mf/2017/06}mmu_segmentation"
FOUR = ("#111111", "#F4F1E8", "#C0392B", "#2980B9")


def rainbow(count):
    """`count` different colours, shape [count, 3]."""
    return np.random.default_rng(4).random((count, 3)).astype(np.float32)


def model_in(content):
    with zipfile.ZipFile(io.BytesIO(content)) as package:
        return ET.fromstring(package.read("3D/3dmodel.model"))


def model_of(mesh):
    return model_in(threemf_bytes(mesh))


def written_colours(model):
    """The colour of every face corner as in the file, shape [face_count, 3, 3], uint8."""
    group = model.find(f"{CORE}resources/{MATERIAL}colorgroup")
    palette = np.array([list(bytes.fromhex(colour.get("color")[1:])) for colour in group], dtype=np.uint8)
    triangles = model.findall(f".//{CORE}triangle")
    assert {triangle.get("pid") for triangle in triangles} == {group.get("id")}
    return palette[[[int(triangle.get(p)) for p in ("p1", "p2", "p3")] for triangle in triangles]]


def sectors(mesh):
    """The mesh in four filaments around its axis, borders and meeting points included."""
    x, y, _ = mesh.vertices.T
    return Painted(mesh, FOUR, (2 * (x > 0.0) + (y > 0.0)).astype(np.int32))


def two_bodies(sphere):
    shell, rest = shell_and_rest(sphere, sphere, sphere.vertices[:, 2] > 0.0, np.full(len(sphere.vertices), 20.0))
    return [Body("styled <shell>", shell, 1), Body("rest", rest, 0)]


# --- the package --------------------------------------------------------------------------------------------------


def test_the_package_has_its_three_parts_and_they_refer_to_each_other(cube):
    with zipfile.ZipFile(io.BytesIO(threemf_bytes(cube))) as package:
        assert package.testzip() is None
        assert package.namelist() == ["[Content_Types].xml", "_rels/.rels", "3D/3dmodel.model"]
        types = ET.fromstring(package.read("[Content_Types].xml"))
        relations = ET.fromstring(package.read("_rels/.rels"))
        assert {entry.get("Extension") for entry in types} == {"rels", "model"}
        assert [relation.get("Target").lstrip("/") for relation in relations] == ["3D/3dmodel.model"]
        assert relations[0].get("Type") == "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"


@pytest.mark.parametrize("coloured", [False, True])
def test_the_model_is_in_millimetres_and_builds_its_one_object(cube, coloured):
    model = model_of(cube.coloured(rainbow(8)) if coloured else cube)
    assert model.tag == f"{CORE}model"
    assert model.get("unit") == "millimeter"
    objects, items = model.findall(f"{CORE}resources/{CORE}object"), model.findall(f"{CORE}build/{CORE}item")
    assert [item.get("objectid") for item in items] == [thing.get("id") for thing in objects]
    ids = [resource.get("id") for resource in model.find(f"{CORE}resources")]
    assert len(ids) == len(set(ids)) == 1 + coloured
    assert ids.index(objects[0].get("id")) == coloured  # a resource stands before what refers to it
    assert objects[0].get("pid") == (ids[0] if coloured else None)


def test_vertices_and_faces_are_exact_to_nine_digits(sphere):
    turned = sphere.moved(sphere.vertices @ np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0] + 80.0)
    model = model_of(turned)
    vertices = np.array([[float(vertex.get(axis)) for axis in "xyz"] for vertex in model.iter(f"{CORE}vertex")])
    faces = np.array([[int(triangle.get(corner)) for corner in ("v1", "v2", "v3")] for triangle in model.iter(f"{CORE}triangle")])
    assert np.abs(vertices - turned.vertices).max() <= 5e-8  # half a unit of the ninth digit of 10 to 100 mm
    assert np.array_equal(faces, turned.faces)


def test_an_uncoloured_mesh_has_no_colours(cube):
    model = model_of(cube)
    assert model.find(f".//{MATERIAL}colorgroup") is None
    assert all(set(triangle.attrib) == {"v1", "v2", "v3"} for triangle in model.iter(f"{CORE}triangle"))


def test_few_colours_are_written_to_every_corner_exactly(cube):
    colours = rainbow(8)
    assert np.array_equal(written_colours(model_of(cube.coloured(colours))), np.round(colours * 255).astype(np.uint8)[cube.faces])


def test_many_colours_are_written_as_sixteen(sphere):
    colours = 0.5 + 0.05 * sphere.vertices.astype(np.float32)
    palette = clustered(colours, MOST)
    model = model_of(sphere.coloured(colours))
    assert len(model.find(f".//{MATERIAL}colorgroup")) == len(palette) <= MOST
    written = np.round(display(palette)[nearest(colours, palette)] * 255).astype(np.uint8)
    assert np.array_equal(written_colours(model), written[sphere.faces])


def test_the_same_mesh_gives_the_same_bytes(sphere):
    mesh = sphere.coloured(rainbow(len(sphere.vertices)))
    assert threemf_bytes(mesh) == threemf_bytes(mesh)


# --- painted for slicers ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("slicer", SLICERS)
def test_the_words_of_a_painted_file_give_each_corner_its_filament(sphere, slicer):
    paint = sectors(sphere)
    model = model_in(threemf_bytes(sphere, paint=paint, slicer=slicer))
    key, other = (PRUSA, "paint_color") if slicer in ("standard", "prusa") else ("paint_color", PRUSA)
    triangles = model.findall(f".//{CORE}triangle")
    trees = [decoded(triangle.get(key)) for triangle in triangles]
    found = [[state_at(tree, place) for place in np.eye(3)] for tree in trees]
    assert np.array_equal(found, paint.filament[sphere.faces] + 1)
    assert not any(triangle.get(other) for triangle in triangles)
    assert np.array_equal(written_colours(model), np.round(display(FOUR) * 255)[paint.filament][sphere.faces])
    assert [entry.text for entry in model.findall(f"{CORE}metadata") if entry.get("name") == "Application"] == ["MechStyle"]


def test_two_names_of_a_slicer_are_one_file(cube):
    made = {slicer: threemf_bytes(cube, paint=sectors(cube), slicer=slicer) for slicer in SLICERS}
    assert made["standard"] == made["prusa"] != made["bambu"] == made["orca"]


def test_settings_name_the_filaments_and_never_claim_to_be_another_program(cube):
    with zipfile.ZipFile(io.BytesIO(threemf_bytes(cube, 'a "part"', paint=sectors(cube), slicer="orca", filament_type="PETG"))) as package:
        project = json.loads(package.read("Metadata/project_settings.config"))
        objects = ET.fromstring(package.read("Metadata/model_settings.config"))
        assert b"BambuStudio" not in b"".join(package.read(name) for name in package.namelist())
    assert project["filament_colour"] == [f"{colour}FF" for colour in FOUR]
    assert project["filament_type"] == ["PETG"] * 4
    facts = {fact.get("key"): fact.get("value") for fact in objects.find("object")}
    assert facts == {"name": 'a "part"', "extruder": "1"}


def test_an_unknown_slicer_is_refused(cube):
    with pytest.raises(BadInput, match="cura"):
        threemf_bytes(cube, slicer="cura")


def test_two_bodies_are_stretches_of_one_object_for_prusaslicer(sphere):
    bodies = two_bodies(sphere)
    content = bodies_bytes(bodies, FOUR, slicer="prusa")
    colours = written_colours(model_in(content))
    with zipfile.ZipFile(io.BytesIO(content)) as package:
        volumes = ET.fromstring(package.read("Metadata/Slic3r_PE_model.config")).findall("object/volume")
    for body, volume in zip(bodies, volumes, strict=True):
        facts = {fact.get("key"): fact.get("value") for fact in volume}
        stretch = colours[int(volume.get("firstid")) : int(volume.get("lastid")) + 1]
        assert len(stretch) == len(body.mesh.faces)
        assert facts == {"name": body.name, "extruder": str(body.filament + 1)}
        assert (stretch == np.round(display(FOUR) * 255)[body.filament]).all()


def test_two_bodies_are_components_of_one_object_for_the_others(sphere):
    bodies = two_bodies(sphere)
    content = bodies_bytes(bodies, FOUR, slicer="bambu")
    model = model_in(content)
    whole = model.find(f"{CORE}build/{CORE}item").get("objectid")
    objects = {thing.get("id"): thing for thing in model.iter(f"{CORE}object")}
    parts = [entry.get("objectid") for entry in objects[whole].iter(f"{CORE}component")]
    assert [objects[part].get("pindex") for part in parts] == ["1", "0"]
    with zipfile.ZipFile(io.BytesIO(content)) as package:
        named = ET.fromstring(package.read("Metadata/model_settings.config")).find("object")
    assert named.get("id") == whole
    found = {part.get("id"): part.find("metadata[@key='extruder']").get("value") for part in named.findall("part")}
    assert found == dict(zip(parts, ("2", "1"), strict=True))


# --- as others read it --------------------------------------------------------------------------------------------


def read_by_lib3mf(path, *, strict):
    """Warnings by their number, and whether each mesh is manifold and oriented, as the 3MF Consortium's own reader has it."""
    if os.environ.get("MECHSTYLE_SKIP_NOTHING") is None:
        pytest.importorskip("lib3mf", reason="NO LIB3MF: files were NOT read in its strict mode; pip install lib3mf")
    from lib3mf import get_wrapper  # noqa: PLC0415 — see above

    model = get_wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(strict)
    reader.ReadFromFile(str(path))
    meshes = model.GetMeshObjects()
    sound = []
    while meshes.MoveNext():
        sound.append(meshes.GetCurrentMeshObject().IsManifoldAndOriented())
    return Counter(reader.GetWarning(number)[0] for number in range(reader.GetWarningCount())), sound


def test_a_painted_file_is_strict(sphere, tmp_path):
    (tmp_path / "part.3mf").write_bytes(threemf_bytes(sphere, paint=sectors(sphere)))
    assert read_by_lib3mf(tmp_path / "part.3mf", strict=True) == ({}, [True])


def test_a_file_of_two_bodies_is_strict(sphere, tmp_path):
    for slicer, objects in (("prusa", 1), ("bambu", 2)):
        (tmp_path / "part.3mf").write_bytes(bodies_bytes(two_bodies(sphere), FOUR, slicer=slicer))
        assert read_by_lib3mf(tmp_path / "part.3mf", strict=True) == ({}, [True] * objects)


def test_the_file_for_bambu_studio_departs_from_the_standard_in_its_painting_alone(sphere, tmp_path):
    """Number 32935: an attribute that is not in the namespace."""
    (tmp_path / "part.3mf").write_bytes(threemf_bytes(sphere, paint=sectors(sphere), slicer="bambu"))
    assert read_by_lib3mf(tmp_path / "part.3mf", strict=False) == ({32935: len(sphere.faces)}, [True])


def test_prusaslicer_gives_our_words_back(sphere, tmp_path):
    (tmp_path / "part.3mf").write_bytes(threemf_bytes(sphere, paint=sectors(sphere)))
    prusa_slicer("--export-3mf", "-o", tmp_path / "back.3mf", tmp_path / "part.3mf")
    ours, theirs = (
        [triangle.get(PRUSA) for triangle in model_in((tmp_path / name).read_bytes()).iter(f"{CORE}triangle")]
        for name in ("part.3mf", "back.3mf")
    )
    assert ours == theirs


def test_prusaslicer_prints_each_layer_with_the_filaments_that_are_there(cube, tmp_path):
    """One vertex of the cube below and one above are of other filaments: cut at the middles of the sides, they begin at half the height."""
    filament = np.zeros(8, dtype=np.int32)
    filament[[0, 7]] = 1, 2  # the corners (0, 0, 0) and (10, 10, 10)
    (tmp_path / "part.3mf").write_bytes(threemf_bytes(cube, paint=Painted(cube, FOUR, filament)))
    prusa_slicer("--export-gcode", *FOUR_FILAMENTS, "-o", tmp_path / "part.gcode", tmp_path / "part.3mf")
    found = tools_by_height((tmp_path / "part.gcode").read_text())
    assert set().union(*(tools for height, tools in found.items() if 1.0 < height < 4.5)) == {0, 1}
    assert set().union(*(tools for height, tools in found.items() if 5.5 < height < 9.0)) == {0, 2}


def test_prusaslicer_prints_two_bodies_with_two_filaments(cube, tmp_path):
    shell, rest = shell_and_rest(cube, cube, np.ones(8, dtype=bool), np.full(8, 10.0))
    (tmp_path / "part.3mf").write_bytes(bodies_bytes([Body("shell", shell, 1), Body("rest", rest, 0)], FOUR))
    prusa_slicer("--export-gcode", *FOUR_FILAMENTS, "-o", tmp_path / "part.gcode", tmp_path / "part.3mf")
    found = tools_by_height((tmp_path / "part.gcode").read_text())
    assert found[min(found)] == {1}
    assert all(tools == {0, 1} for height, tools in found.items() if 2.0 < height < 8.0)
