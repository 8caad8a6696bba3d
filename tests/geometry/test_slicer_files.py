"""3MF as slicers write it: what is no material is left out or cut out by its role, and said; one of several bodies is chosen."""

import io
import zipfile

import pytest
import trimesh

from mechstyle.geometry import claims, threemf_reader
from mechstyle.geometry.files import bodies, read
from support.part_files import put, refusal
from support.slicer_files import (
    BESIDE,
    PLATE,
    SIDES,
    TOWER,
    assembly,
    components,
    cura,
    mesh,
    model,
    named_obj,
    named_stl,
    orca,
    orca_apart,
    package,
    prusa,
    thing,
)

OF_ORCA = {"modifier": "modifier_part", "negative": "negative_part", "blocker": "support_blocker", "enforcer": "support_enforcer"}
OF_PRUSA = {"modifier": "ParameterModifier", "negative": "NegativeVolume", "blocker": "SupportBlocker", "enforcer": "SupportEnforcer"}
WRITTEN = {"orca": (orca, OF_ORCA), "orca apart": (orca_apart, OF_ORCA), "prusa": (prusa, OF_PRUSA)}


def volume_of(path, **how):
    return read(path, **how).mesh.volume


@pytest.mark.parametrize("role", ["modifier", "blocker", "enforcer"])
@pytest.mark.parametrize("slicer", WRITTEN)
def test_what_is_no_material_is_left_out_and_said(tmp_path, slicer, role):
    """A plate with a modifier was styled and dropped as a plate with a tower."""
    write, words = WRITTEN[slicer]
    part = read(put(tmp_path, "part.3mf", write(words[role])))
    assert part.mesh.volume == pytest.approx(16000)
    named = "" if slicer == "orca apart" else "'tower', "
    kind = {"modifier": "a modifier", "blocker": "a support blocker", "enforcer": "a support enforcer"}[role]
    assert f"left out {named}{kind} of 10 × 10 × 30 mm" in part.notes


@pytest.mark.parametrize("slicer", WRITTEN)
def test_a_negative_volume_is_cut_out_and_said(tmp_path, slicer):
    write, words = WRITTEN[slicer]
    part = read(put(tmp_path, "part.3mf", write(words["negative"])))
    assert part.mesh.volume == pytest.approx(16000 - 1000)
    assert any(note.startswith("cut out the negative volume") and note.endswith("of 10 × 10 × 30 mm") for note in part.notes)


def test_a_part_of_the_usual_kind_is_united_and_both_are_named(tmp_path):
    part = read(put(tmp_path, "part.3mf", orca("normal_part")))
    assert part.mesh.volume == pytest.approx(16000 + 2000)
    assert "united 2 overlapping bodies ('plate', 'tower')" in part.notes


def test_a_modifier_as_it_was_written_before_there_were_types(tmp_path):
    assert volume_of(put(tmp_path, "part.3mf", prusa("1", key="modifier"))) == pytest.approx(16000)


def test_a_kind_of_volume_that_nobody_knows_is_no_material(tmp_path):
    part = read(put(tmp_path, "part.3mf", prusa("SeamPainter")))
    assert part.mesh.volume == pytest.approx(16000)
    assert "left out 'tower', a volume of the kind 'SeamPainter' of 10 × 10 × 30 mm" in part.notes


def test_triangles_that_no_range_holds_are_material(tmp_path):
    half = '<config><object id="1"><volume firstid="0" lastid="11"/><volume firstid="500" lastid="900"/></object></config>'
    path = put(tmp_path, "part.3mf", package(model(thing(1, mesh(PLATE, TOWER)), '<item objectid="1"/>'), Slic3r_PE_model=half))
    assert volume_of(path) == pytest.approx(18000)


def test_a_negative_volume_takes_from_its_own_object_only(tmp_path):
    """The cutter reaches into the post of another object, which stays whole."""
    resources = thing(1, mesh(PLATE)) + thing(2, mesh(((90, 10, 30), (15, 15, 0)))) + components(3, 'objectid="1"', 'objectid="2"')
    settings = '<config><object id="3"><part id="1" subtype="normal_part"/><part id="2" subtype="negative_part"/></object></config>'
    post = thing(4, mesh(((30, 30, 30), (60, 0, 0))), 'type="model" name="post"')
    content = package(model(resources + post, '<item objectid="3"/><item objectid="4"/>'), model_settings=settings)
    assert volume_of(put(tmp_path, "part.3mf", content), body="post") == pytest.approx(27000)


def test_nothing_left_where_negative_volumes_are_cut_out(tmp_path):
    resources = thing(1, mesh(TOWER)) + thing(2, mesh(((90, 90, 90), (-9, -9, -9)))) + components(3, 'objectid="1"', 'objectid="2"')
    settings = '<config><object id="3"><part id="1" subtype="normal_part"/><part id="2" subtype="negative_part"/></object></config>'
    path = put(tmp_path, "part.3mf", package(model(resources, '<item objectid="3"/>'), model_settings=settings))
    assert "has nothing left where its negative volumes are cut out" in refusal(path)


@pytest.mark.parametrize("kind", ["support", "solidsupport", "other", "surface"])
def test_objects_of_another_type_are_no_part(tmp_path, kind):
    both = thing(1, mesh(PLATE)) + thing(2, mesh(BESIDE), f'type="{kind}" name="pillar"')
    part = read(put(tmp_path, "part.3mf", package(model(both, '<item objectid="1"/><item objectid="2"/>'))))
    assert part.mesh.volume == pytest.approx(16000)
    assert any("left out 'pillar', a" in note for note in part.notes)


def test_an_item_that_is_not_to_be_printed_is_left_out(tmp_path):
    both = thing(1, mesh(PLATE)) + thing(2, mesh(BESIDE), 'type="model" name="jig"')
    part = read(put(tmp_path, "part.3mf", package(model(both, '<item objectid="1"/><item objectid="2" printable="0"/>'))))
    assert part.mesh.volume == pytest.approx(16000)
    assert "left out 'jig', an object that is not to be printed of 10 × 10 × 30 mm" in part.notes


# --- what else slicers and plug-ins do ---------------------------------------------------------------------------


def within(content, number, transform="0 1 0 -1 0 0 0 0 1 100 50 0"):
    """A package whose object lies, turned, in one more that is built in its place."""
    wrapped = content.replace("</resources>", components(9, f'objectid="{number}" transform="{transform}"') + "</resources>")
    return wrapped.replace(f'<item objectid="{number}"/>', '<item objectid="9"/>')


@pytest.mark.parametrize("slicer", ["orca", "prusa"])
@pytest.mark.parametrize("role", ["negative", "modifier"])
def test_what_is_said_of_an_object_holds_wherever_it_is_put(tmp_path, monkeypatch, slicer, role):
    """A plug-in or an assembly puts another object around it; its settings were those of the outermost only."""
    write, words = WRITTEN[slicer]
    number = 3 if slicer == "orca" else 1
    monkeypatch.setattr("support.slicer_files.package", lambda main, **others: package(within(main, number), **others))
    part = read(put(tmp_path, "part.3mf", write(words[role])))
    assert part.mesh.volume == pytest.approx(15000 if role == "negative" else 16000)


def test_a_negative_volume_in_an_assembly_takes_from_its_own_object_only(tmp_path):
    resources = thing(1, mesh(PLATE)) + thing(2, mesh(((90, 10, 30), (15, 15, 0)))) + components(3, 'objectid="1"', 'objectid="2"')
    settings = '<config><object id="3"><part id="1" subtype="normal_part"/><part id="2" subtype="negative_part"/></object></config>'
    beside = thing(4, mesh(((30, 40, 10), (40, 0, 0)))) + components(5, 'objectid="3"', 'objectid="4"')
    content = package(model(resources + beside, '<item objectid="5"/>'), model_settings=settings)
    assert volume_of(put(tmp_path, "part.3mf", content)) == pytest.approx(16000 - 25 * 10 * 10 + 12000)


@pytest.mark.parametrize(("depth", "bodies_left"), [(60, 2), (30, 1)])
def test_a_part_that_a_negative_volume_cuts_in_two_is_two_bodies(tmp_path, depth, bodies_left):
    """Both halves were taken for one body, and dropped as one."""
    cut = thing(1, mesh(PLATE, ((10, depth, 30), (10, -5, -5))))
    path = put(tmp_path, "part.3mf", package(model(cut, '<item objectid="1"/>'), Slic3r_PE_model=DRILLED))
    assert len(bodies(path)) == bodies_left


DRILLED = (
    '<config><object id="1"><volume firstid="0" lastid="11"/><volume firstid="12" lastid="23">'
    '<metadata type="volume" key="volume_type" value="NegativeVolume"/></volume></object></config>'
)
CURA = "http://software.ultimaker.com/xml/cura/3mf/2015/10"


@pytest.mark.parametrize("written", ["now", "before"])
@pytest.mark.parametrize(
    ("key", "kind"),
    [("anti_overhang_mesh", "support blocker"), ("infill_mesh", "modifier"), ("cutting_mesh", "modifier"), ("support_mesh", "support")],
)
def test_what_cura_says_within_an_object(tmp_path, written, key, kind):
    before = f'<c:settings xmlns:c="{CURA}"><c:setting c:key="{key}">{{}}</c:setting></c:settings>'
    for word, volume in (("True", 16000), ("False", 18000)):
        tower = thing(2, before.format(word) + mesh(TOWER), 'type="model" name="tower"')
        older = package(model(thing(1, mesh(PLATE)) + tower, '<item objectid="1"/><item objectid="2"/>'))
        content = cura(key, word) if written == "now" else older
        part = read(put(tmp_path, "part.3mf", content))
        assert part.mesh.volume == pytest.approx(volume)
        assert (f"left out 'tower', a {kind} of 10 × 10 × 30 mm" in part.notes) is (word == "True")


@pytest.mark.parametrize("extruder", ["1", "2"])
@pytest.mark.parametrize("slicer", ["orca", "prusa"])
def test_filaments_given_to_parts_are_colours_that_are_left_out(tmp_path, monkeypatch, slicer, extruder):
    write, _ = WRITTEN[slicer]
    fact = f'<metadata key="extruder" value="{extruder}"/></object>'
    monkeypatch.setattr(
        "support.slicer_files.package",
        lambda main, **others: package(main, **{name: text.replace("</object>", fact) for name, text in others.items()}),
    )
    notes = read(put(tmp_path, "part.3mf", write("ModelPart" if slicer == "prusa" else "normal_part"))).notes
    assert ("its colours are left out: a style brings its own" in notes) is (extruder == "2")


def test_an_encrypted_part_is_refused_as_one(tmp_path):
    content = package(model(components(2, 'p:path="/3D/a.model" objectid="1"'), '<item objectid="2"/>'))
    held = io.BytesIO(content)
    with zipfile.ZipFile(held, "a") as archive:
        archive.writestr("3D/a.model", b"%3McF\x00 sealed")
        archive.writestr("Secure/keystore.xml", "<keystore/>")
    assert "is encrypted: save it without a password" in refusal(put(tmp_path, "part.3mf", held.getvalue()))


# --- several model parts ------------------------------------------------------------------------------------------


def in_two_files(second, *, lacking=False):
    """A plate and a post on it in an object file each; 60 × 40 × 55 mm."""
    post = f'p:path="/3D/Objects/B.model" objectid="{second}" transform="1 0 0 0 1 0 0 0 1 25 15 5"'
    top = components(2, 'p:path="/3D/Objects/a.model" objectid="1"', post)
    parts = {"a": model(thing(1, mesh(((60, 40, 10), (0, 0, 0))))), "b": model(thing(second, mesh(((10, 10, 50), (0, 0, 0)))))}
    return package(model(top, '<item objectid="2"/>'), objects={name: part for name, part in parts.items() if not lacking or name == "a"})


@pytest.mark.parametrize(("kind", "volume"), [("normal_part", 18000), ("negative_part", 15000), ("modifier_part", 16000)])
def test_a_model_part_is_in_its_own_unit(tmp_path, kind, volume):
    assert volume_of(put(tmp_path, "part.3mf", assembly(kind))) == pytest.approx(volume)


@pytest.mark.parametrize("second", [1, 2, 7])
def test_numbers_of_objects_are_unique_in_a_model_part_only(tmp_path, second):
    """Geometry of both was put in both places."""
    part = read(put(tmp_path, "part.3mf", in_two_files(second)))
    assert part.mesh.extents == pytest.approx((60, 40, 55))
    assert part.mesh.volume == pytest.approx(60 * 40 * 10 + 10 * 10 * 45)


def test_the_package_says_where_it_begins(tmp_path):
    other = {"other": model(thing(1, mesh(BESIDE)), '<item objectid="1"/>')}
    content = package(model(thing(1, mesh(PLATE)), '<item objectid="1"/>'), start="/3D/start.model", objects=other)
    assert volume_of(put(tmp_path, "part.3mf", content)) == pytest.approx(16000)


def test_a_mirrored_object_with_a_cavity_keeps_it(tmp_path):
    turned = mesh(PLATE, ((10, 10, 5), (5, 5, 2)))  # the inner box has to face inwards
    for a, b, c in SIDES:
        turned = turned.replace(f'v1="{8 + a}" v2="{8 + b}" v3="{8 + c}"', f'v1="{8 + a}" v2="{8 + c}" v3="{8 + b}"')
    item = '<item objectid="1" transform="-1 0 0 0 1 0 0 0 1 2 0 0"/>'
    assert volume_of(put(tmp_path, "part.3mf", package(model(thing(1, turned), item)))) == pytest.approx(16000 - 500)


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (in_two_files(7, lacking=True), "lacks '/3d/objects/b.model', of which its part is made: it is incomplete"),
        (package(model(components(2, 'objectid="5"'), '<item objectid="2"/>')), "lacks the object '5' in /3d/3dmodel.model"),
        (package(model(thing(1, mesh(PLATE)) * 2, '<item objectid="1"/>')), "has two objects '1' in /3d/3dmodel.model"),
        (package(model()), "has nothing on its plate"),
        (package(model(thing(1, mesh(PLATE)))), "has nothing on its plate"),
        (package(model(thing(1, mesh()), '<item objectid="1"/>')), "holds no triangles: its objects are empty"),
        (
            package(model(thing(1, mesh(PLATE), 'type="support" name="raft"'), '<item objectid="1"/>')),
            "holds nothing that is printed ('raft' is a support)",
        ),
    ],
)
def test_a_package_without_a_part_is_refused_by_what_is_wrong_with_it(tmp_path, content, says):
    assert says in refusal(put(tmp_path, "part.3mf", content))


@pytest.mark.parametrize(
    ("shape", "word"),
    [
        ('<b:beamlattice radius="2" minlength="0.001"><b:beams><b:beam v1="0" v2="1"/></b:beams></b:beamlattice>', "a beam lattice"),
        ("<b:booleanshape/>", "a boolean of other objects"),
        ("<b:levelset/>", "an implicit shape"),
    ],
)
def test_a_shape_of_an_extension_is_refused_by_its_name_or_said_besides_triangles(tmp_path, shape, word):
    bare = thing(1, mesh().replace("</mesh>", f"{shape}</mesh>"), 'type="model" name="lattice"')
    message = refusal(put(tmp_path, "part.3mf", package(model(bare, '<item objectid="1"/>'))))
    assert f"holds 'lattice' as {word}, and no triangles: export it as a mesh" in message
    both = thing(1, mesh(PLATE).replace("</mesh>", f"{shape}</mesh>"))
    notes = read(put(tmp_path, "both.3mf", package(model(both, '<item objectid="1"/>')))).notes
    assert f"its triangles are read, and {word} that it holds besides is left out" in notes


# --- which of several bodies --------------------------------------------------------------------------------------


def plate_of(*boxes):
    """Objects beside each other, each with its name."""
    resources = "".join(thing(number, mesh(box), f'type="model" name="{name}"') for number, (name, box) in enumerate(boxes, 1))
    return package(model(resources, "".join(f'<item objectid="{number}"/>' for number in range(1, len(boxes) + 1))))


LID = ((40, 40, 3), (60, 0, 0))


def test_several_bodies_are_listed_by_name_number_and_size_and_one_is_chosen(tmp_path):
    path = put(tmp_path, "part.3mf", plate_of(("box", PLATE), ("lid", LID)))
    assert "holds 2 separate bodies, 1 'box' (40 × 40 × 10 mm), 2 'lid' (40 × 40 × 3 mm)" in refusal(path)
    assert [(one.number, one.name, one.copies) for one in bodies(path)] == [(1, "box", 1), (2, "lid", 1)]
    assert bodies(path)[1].volume == pytest.approx(4800)
    assert bodies(path)[1].extents == pytest.approx((40, 40, 3))
    assert volume_of(path, body="Lid") == pytest.approx(4800)
    part = read(path, body=2)
    assert part.mesh.volume == pytest.approx(4800)
    assert part.notes[-1] == "read body 2 'lid' (40 × 40 × 3 mm), and left out 1 'box' (40 × 40 × 10 mm)"


def test_a_body_that_there_is_not_is_refused_with_those_there_are(tmp_path):
    path = put(tmp_path, "part.3mf", plate_of(("box", PLATE), ("lid", LID)))
    for wrong in ("cup", "3", "0"):
        assert f"holds no body '{wrong}': it has 1 'box' (40 × 40 × 10 mm), 2 'lid' (40 × 40 × 3 mm)" in refusal(path, body=wrong)
    single = put(tmp_path, "one.3mf", plate_of(("box", PLATE)))
    assert volume_of(single, body="box") == volume_of(single, body=1) == pytest.approx(16000)
    assert "holds no body 'lid': it has 1 'box'" in refusal(single, body="lid")


def test_bodies_of_one_name_are_chosen_by_number(tmp_path):
    path = put(tmp_path, "part.3mf", plate_of(("Cube", PLATE), ("Cube", LID)))
    assert "holds 2 bodies of the name 'cube': choose one by its number" in refusal(path, body="cube")
    assert "choose it with --body 1, or join them" in refusal(path)
    assert volume_of(path, body=1) == pytest.approx(16000)


def test_equal_copies_are_read_as_one(tmp_path):
    turned = "0 1 0 -1 0 0 0 0 1 {} 0 0"
    items = [f'<item objectid="1" transform="{turned.format(50 * place)}"/>' for place in range(4)]
    items.append('<item objectid="1" transform="1 0 0 0 1 0 0 0 1 0 60 0"/>')
    part = read(put(tmp_path, "part.3mf", package(model(thing(1, mesh(PLATE)), "".join(items)))))
    assert part.mesh.volume == pytest.approx(16000)
    assert part.notes[-1] == "read one of 5 equal copies"


@pytest.mark.parametrize("gap", [0.0, 1e-5, 0.01, 0.09])
def test_equal_blocks_that_a_slicer_prints_as_one_are_one_part(tmp_path, gap):
    """Red before: a bar of two blocks was read as one of two copies, half of it."""
    block = trimesh.creation.box((30.0, 20.0, 10.0))
    other = block.copy()
    other.apply_translation((30.0 + gap, 0.0, 0.0))
    path = put(tmp_path, "bar.stl", trimesh.util.concatenate([block, other]).export(file_type="stl"))
    part = read(path)
    assert part.mesh.volume == pytest.approx(12000.0, rel=0.005)
    assert not any("copies" in note for note in part.notes)


@pytest.mark.parametrize("shift", [(30.0, 20.0, 0.0), (30.0, 20.0, 10.0), (30.02, 20.0, 0.0)])
def test_equal_blocks_that_touch_in_an_edge_or_a_corner_are_no_copies(tmp_path, shift):
    block = trimesh.creation.box((30.0, 20.0, 10.0))
    other = block.copy()
    other.apply_translation(shift)
    path = put(tmp_path, "bar.stl", trimesh.util.concatenate([block, other]).export(file_type="stl"))
    assert "holds 2 separate bodies" in refusal(path)
    assert volume_of(path, body="2") == pytest.approx(6000.0)


def test_a_body_of_a_broken_plate_is_read_all_the_same(tmp_path):
    """What is asked for by its name is mended alone: another object, which is open, is nobody's concern."""
    broken = thing(2, mesh(LID).replace('<triangle  v1="0" v2="1" v3="3"/>', "").replace('<triangle  v1="0" v2="3" v3="2"/>', ""))
    whole = thing(1, mesh(PLATE), 'type="model" name="box"')
    path = put(tmp_path, "part.3mf", package(model(whole + broken, '<item objectid="1"/><item objectid="2"/>')))
    assert "is open" in refusal(path)
    assert volume_of(path, body="box") == pytest.approx(16000)


BOXES = ("box", PLATE), ("lid", LID)


@pytest.mark.parametrize(
    ("name", "content"),
    [("part.obj", named_obj("o", BOXES)), ("part.obj", named_obj("g", BOXES)), ("part.stl", named_stl(BOXES))],
    ids=["objects", "groups", "solids"],
)
def test_names_of_other_formats_are_names_of_bodies(tmp_path, name, content):
    path = put(tmp_path, name, content)
    assert [one.name for one in bodies(path)] == ["box", "lid"]
    assert volume_of(path, body="lid") == pytest.approx(4800)


@pytest.mark.parametrize(("name", "content"), [("part.stl", named_stl((("", PLATE), ("", LID)))), ("part.obj", named_obj("#", BOXES))])
def test_bodies_without_names_are_given_none(tmp_path, name, content):
    """A parser's word for what has no name, geometry_1, was shown as the file's."""
    assert [one.name for one in bodies(put(tmp_path, name, content))] == ["", ""]


# --- nothing for nothing ------------------------------------------------------------------------------------------


def test_ranges_that_take_the_same_triangles_again_and_again_are_counted(tmp_path, monkeypatch):
    volumes = '<volume firstid="0" lastid="23"/>' * 50
    settings = f'<config><object id="1">{volumes}</object></config>'
    path = put(tmp_path, "part.3mf", package(model(thing(1, mesh(PLATE, TOWER)), '<item objectid="1"/>'), Slic3r_PE_model=settings))
    monkeypatch.setattr(claims, "MOST_FACES", 600)
    assert "has more than 600 faces" in refusal(path)


def test_settings_count_among_the_elements_of_a_package(tmp_path, monkeypatch):
    monkeypatch.setattr(threemf_reader, "MOST_MARKS", 200)
    settings = "<config>" + "<object/>" * 300 + "</config>"
    path = put(tmp_path, "part.3mf", package(model(thing(1, mesh(PLATE)), '<item objectid="1"/>'), Slic3r_PE_model=settings))
    assert "million elements" in refusal(path)


def test_settings_that_declare_entities_are_refused(tmp_path):
    settings = '<!DOCTYPE config [<!ENTITY a "aaaa">]><config/>'
    path = put(tmp_path, "part.3mf", package(model(thing(1, mesh(PLATE)), '<item objectid="1"/>'), model_settings=settings))
    assert "declares a document type" in refusal(path)
