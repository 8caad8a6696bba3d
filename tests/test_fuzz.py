"""A few of the cases of `make fuzz`, and those that were once wrong."""

import io
import json
import logging
import os
import struct
import subprocess
import sys
import zipfile
import zlib

import numpy as np
import pytest
import trimesh

from mechstyle.cli.console import escape, out
from mechstyle.errors import BadInput, DamagedStore
from mechstyle.geometry import claims
from mechstyle.geometry.files import read
from mechstyle.geometry.glb import glb_bytes
from mechstyle.loop import objects
from mechstyle.loop.objects import Objects
from mechstyle.records.load_cases import read_loads
from mechstyle.records.material import read_material
from support import ROOT
from support.hostile import MESHES, sound, tried
from support.part_files import PART, exported, put, refusal, threemf, xml_object

CASES = 500
ONCE_WRONG = (("part.3mf", 7), ("part.3mf", 301), ("part.obj", 366), ("store", 165), ("words.stl", 22), ("node.glb", 76), ("forged", 880),
              ("command line", 4_007_191), ("specks.obj", 2253), ("thin.obj", 2961),
              ("quantised.glb", 12_187), ("assembly.3mf", 2), ("solids.stl", 36), ("orca.3mf", 20))  # fmt: skip
"""Cases of the fuzzer that crashed, took a gigabyte or two minutes, or showed a traceback."""


@pytest.mark.slow
def test_five_hundred_hostile_files_and_command_lines_are_read_or_refused_in_a_sentence(tmp_path):
    """In a process of its own, as one of them may end it, and memory is told of a process as a whole."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), str(ROOT / "tests")])}
    command = [sys.executable, "-m", "support.hostile", str(tmp_path / "cases"), "0", str(CASES)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    told = json.loads(done.stdout.splitlines()[-1])
    assert told["wrong"] == []
    assert told["counts"]["read"] + told["counts"]["refused"] == CASES
    assert told["counts"]["read"] > CASES // 20, "cases that are all refused at their first byte try nothing"


@pytest.mark.parametrize("kind", [*MESHES, "material.toml", "material.json", "loads.toml"])
def test_what_is_damaged_was_sound(kind, tmp_path):
    """The loads once were not: every case was refused at the same word, and tried nothing behind it."""
    file = put(tmp_path, kind, sound(kind))
    {"mater": read_material, "loads": read_loads}.get(kind[:5], read)(file)


@pytest.mark.parametrize(("kind", "number"), ONCE_WRONG)
def test_what_was_wrong_once_is_wrong_no_more(kind, number, tmp_path):
    assert tried(kind, number, tmp_path) in ("read", "refused")


def test_what_the_parser_logs_is_shown_to_nobody_who_logs_nothing(capfd):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(logging.getLogger(), "handlers", [])
        trimesh.util.log.warning("failed to extract face_normals", exc_info=ValueError("inside the parser"))
    assert capfd.readouterr() == ("", "")


# --- claims: counted before anything is allocated -----------------------------------------------------------------


@pytest.fixture
def unread(monkeypatch):
    """No parser is asked: the claim alone has the file refused."""

    def parsed(*_args, **_options):
        pytest.fail("a parser was asked")

    monkeypatch.setattr(trimesh, "load_scene", parsed)


def glb(change):
    content = glb_bytes(PART, "part")
    length = struct.unpack_from("<I", content, 12)[0]
    document = json.loads(content[20 : 20 + length])
    change(document)
    words = json.dumps(document).encode()
    words += b" " * (-len(words) % 4)
    rest = content[20 + length :]
    return b"glTF" + struct.pack("<II", 2, 20 + len(words) + len(rest)) + struct.pack("<I", len(words)) + b"JSON" + words + rest


def test_a_header_that_claims_more_numbers_than_the_file_has_bytes(unread, tmp_path):
    faces = "element face 0\nproperty list uchar int vertex_indices\n"
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex 1000000000000\nproperty float x\n{faces}end_header\n"
    assert "claims 1000000000000 numbers, more than it can hold" in refusal(put(tmp_path, "part.ply", head.encode() + bytes(99)))
    huge = glb(lambda document: document["accessors"].append({"componentType": 5126, "type": "VEC3", "count": 10**9}))
    assert "claims 12000000000 bytes of numbers" in refusal(put(tmp_path, "part.glb", huge))


def test_one_mesh_that_is_used_too_often(unread, tmp_path):
    often = glb(lambda document: document.update(nodes=[{"mesh": 0}] * 20_000, scenes=[{"nodes": [0]}]))
    assert "made of more than 10000 pieces" in refusal(put(tmp_path, "part.glb", often))
    twice = '<object id="{}"><components><component objectid="{}"/><component objectid="{}"/></components></object>'
    layers = [twice.format(i, i - 1, i - 1) for i in range(2, 60)]
    bush = threemf(xml_object(1) + "".join(layers), '<item objectid="59"/>')
    assert "made of more than 10000 pieces" in refusal(put(tmp_path, "part.3mf", bush))


def test_an_object_that_is_part_of_itself(unread, tmp_path):
    one = '<object id="{}"><components><component objectid="{}"/></components></object>'
    circle = one.format(1, 2) + one.format(2, 1)
    assert "part of itself" in refusal(put(tmp_path, "part.3mf", threemf(circle, '<item objectid="1"/>')))


def test_a_package_that_unpacks_to_more_than_a_part_needs(unread, monkeypatch, tmp_path):
    monkeypatch.setattr(claims, "MOST_BYTES", 1_000_000)
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as package:
        package.writestr("3D/3dmodel.model", bytes(1_000_001))
    assert "unpacks to more than 1 MB" in refusal(put(tmp_path, "part.3mf", made.getvalue()))


def relabelled(content, **fields):
    """A package of one entry, whose directory says something else of it."""
    changed, directory = bytearray(content), content.rfind(b"PK\1\2")
    for name, value in fields.items():
        at, width = {"flags": (8, "<H"), "crc": (16, "<I"), "size": (24, "<I")}[name]
        struct.pack_into(width, changed, directory + at, value)
    return bytes(changed)


def packed(data, method=zipfile.ZIP_DEFLATED):
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w", method) as package:
        package.writestr("3D/3dmodel.model", data)
    return made.getvalue()


@pytest.mark.parametrize("told", [0, 1000, 99_999, 100_001])
def test_a_package_that_lies_about_its_size_is_not_unpacked(unread, tmp_path, told):
    """1.8 MB took 2.4 GB: parsers unpack all there is and keep as much as the directory says, whose checksum may be right for that."""
    lie = relabelled(packed(bytes(100_000)), size=told, crc=zlib.crc32(bytes(told)))
    assert "another size than it says" in refusal(put(tmp_path, "part.3mf", lie))


def test_a_package_that_is_packed_in_a_way_of_its_own(unread, tmp_path):
    """What LZMA and bzip2 unpack to has no bound, and no 3MF file may use them."""
    for method in (zipfile.ZIP_LZMA, zipfile.ZIP_BZIP2):
        assert "packed in a way that 3MF does not know" in refusal(put(tmp_path, "part.3mf", packed(b"x", method)))


def test_an_encrypted_package(unread, tmp_path):
    """It showed a traceback."""
    assert "is encrypted" in refusal(put(tmp_path, "part.3mf", relabelled(packed(b"x"), flags=1)))


@pytest.mark.parametrize("declared", ['<!DOCTYPE model [<!ENTITY a "aaaa">]>', '<!DOCTYPE model SYSTEM "file:///etc/passwd">'])
def test_a_model_that_declares_entities(unread, tmp_path, declared):
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w") as package:
        package.writestr("3D/3dmodel.model", f'<?xml version="1.0"?>{declared}<model><resources/></model>')
    assert "declares a document type" in refusal(put(tmp_path, "part.3mf", made.getvalue()))


def test_a_shape_in_other_files(unread, tmp_path):
    elsewhere = glb(lambda document: document["buffers"].append({"uri": "../../secret.bin", "byteLength": 8}))
    assert "keeps its shape in other files" in refusal(put(tmp_path, "part.glb", elsewhere))


def test_a_file_larger_than_any_part_is_not_read_at_all(monkeypatch, tmp_path):
    path = put(tmp_path, "part.stl", exported("stl"))
    monkeypatch.setattr("mechstyle.geometry.files.MOST_BYTES", path.stat().st_size - 1)
    monkeypatch.setattr(type(path), "read_bytes", lambda _: pytest.fail("it was read"))
    assert "simplify it" in refusal(path)


@pytest.mark.parametrize("name", ["part.stl", "words.stl", "part.obj"])
def test_too_many_faces_are_counted_before_they_are_parsed(unread, monkeypatch, tmp_path, name):
    monkeypatch.setattr(claims, "MOST_FACES", len(PART.faces) - 1)
    content = exported("stl_ascii" if name == "words.stl" else name[-3:])
    assert f"has {len(PART.faces)} faces" in refusal(put(tmp_path, name, content))


def test_textures_are_not_even_looked_at(tmp_path):
    """A picture of a few kilobytes can have a billion pixels."""

    def textured(document):
        document["images"] = [{"mimeType": "image/png", "bufferView": 0}]
        document["textures"] = [{"source": 0}]
        document["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("PIL.Image.open", lambda *_: pytest.fail("a picture was opened"))
        assert read(put(tmp_path, "part.glb", glb(textured))).mesh.is_closed


def test_an_obj_of_plane_points(tmp_path):
    assert "coordinates instead of 3" in refusal(put(tmp_path, "part.obj", b"v 0 0\nv 9 0\nv 0 9\nf 1 2 3\n"))


def test_a_part_too_far_away_to_have_details(tmp_path):
    """One 10^12 m away was meshed for two minutes, and its corners were not where they seemed."""
    assert "lies 1e+06 km from the origin" in refusal(put(tmp_path, "part.obj", exported("obj", PART.vertices + 1e12)))
    assert read(put(tmp_path, "near.obj", exported("obj", PART.vertices + 1e6))).mesh.is_closed


# --- objects of a store, and tables --------------------------------------------------------------------------------


def test_an_object_that_unpacks_to_too_much_is_damaged(tmp_path, monkeypatch):
    monkeypatch.setattr(objects, "MOST_BYTES", 100_000)
    store = Objects(tmp_path)
    fits, larger = (store.put(bytes(size)) for size in (100_000, 100_001))
    assert len(store.get(fits)) == 100_000
    with pytest.raises(DamagedStore, match="unreadable"):
        store.get(larger)


@pytest.mark.parametrize("shape", ["(10000000000,)", "(3,)", "(5,)", "(2, 2, 2)"])
def test_an_array_that_claims_other_numbers_than_it_holds_is_damaged(tmp_path, shape):
    made = io.BytesIO()
    np.save(made, np.zeros(4, np.float32))
    old, new = b"(4,), }", f"{shape}, }}".encode()
    content = made.getvalue().replace(old + b" " * (len(new) - len(old)), new)
    assert shape.encode() in content
    store = Objects(tmp_path)
    digest = store.put(content)
    with pytest.raises(DamagedStore, match="not an array"):
        store.get_array(digest)


@pytest.mark.parametrize("text", ["name = " + "9" * 5000, "name = " + "[" * 3000, "#" * 200_000, "name = '\ufffe\x01'"])
def test_tables_that_no_one_writes_are_one_sentence(tmp_path, text):
    path = tmp_path / "file.toml"
    path.write_text(text)
    for reader in (read_material, read_loads):
        with pytest.raises(BadInput, match=r"file\.toml") as refused:
            reader(path)
        assert len(str(refused.value)) < 1000
        assert "sys." not in str(refused.value), "advice for who writes Python"


# --- what is printed -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["x\\[/red].stl", "[bold]x", "[/]", "\\", "a[mm]\\"])
def test_names_are_printed_as_they_are(name):
    with out.capture() as printed:
        out.print(f"[dim]{escape(name)}[/]")
    assert printed.get().rstrip("\n").endswith(name)


def test_names_command_no_terminal():
    assert escape("a\x1b]0;title\x07b\x9bm\r") == "a�]0;title�b�m�"


def test_a_deflate_stream_that_was_cut_off_is_damaged(tmp_path):
    store = Objects(tmp_path)
    digest = store.put(b"x" * 1000)
    store.path(digest).write_bytes(zlib.compress(b"x" * 1000)[:-6])
    with pytest.raises(DamagedStore):
        store.get(digest)
