"""Files that cannot be read: each is refused in one sentence that names it, and nothing is said besides."""

from __future__ import annotations

import json
import re
import struct
import warnings
import zipfile
import zlib

import numpy as np
import pytest
import trimesh

from mechstyle.geometry import files
from mechstyle.geometry.files import FORMATS, read
from support.part_files import PART, ascii_ply, assert_is_part, exported, glb_with_node, put, refusal, threemf, threemf_in, xml_object

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
    assert re.search("holds no triangles|cannot be read as|is a picture or a document|is a web page|is a ZIP archive", message)
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


def test_an_absurd_size_is_told_in_few_signs(tmp_path):
    """Once in 308 digits."""
    path = put(tmp_path, "part.obj", exported("obj", PART.vertices * 1e300))
    assert len(refusal(path)) < 120


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
    with monkeypatch.context() as patched, pytest.raises(AttributeError, match="graph"):
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


@pytest.mark.parametrize("name", ["part.iges", "part", "part.stl.gz"])
def test_unknown_suffixes_are_refused_with_the_known_ones(tmp_path, name):
    message = refusal(put(tmp_path, name, exported("stl")))
    assert "export it as stl, obj, ply, glb, 3mf" in message


def test_a_folder_is_refused(tmp_path):
    (tmp_path / "part.stl").mkdir()
    assert "is a folder, not a file" in refusal(tmp_path / "part.stl")


def test_a_file_that_cannot_be_opened_is_refused(tmp_path, monkeypatch):
    path = put(tmp_path, "part.stl", exported("stl"))

    def denied(_self):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(type(path), "read_bytes", denied)
    assert "cannot be opened: Permission denied; check its permissions" in refusal(path)


def test_the_repair_names_the_file(tmp_path):
    top = PART.face_normals[:, 2] < 0.5
    assert "open.stl is open and cannot be closed" in refusal(put(tmp_path, "open.stl", exported("stl", faces=PART.faces[top])))
