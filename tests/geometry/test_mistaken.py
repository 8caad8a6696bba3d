"""What is no mesh, or one of another format, is named for what it is."""

import gzip
import io
import zipfile

import pytest
import trimesh

from mechstyle.geometry.files import FORMATS, read
from mechstyle.geometry.mistaken import mistaken
from support.part_files import PART, ascii_ply, assert_is_part, exported, glb_with_node, put, refusal, threemf_in
from support.step_file import box_step


def packed(name, content):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        archive.writestr(name, content)
    return buffer.getvalue()


NO_MESH = {
    "pointer": (b"version https://git-lfs.github.com/spec/v1\noid sha256:" + b"0" * 64 + b"\nsize 12345\n", "is a Git LFS pointer"),
    "page": (b"\n<!DOCTYPE html>\n<html><title>Log in</title></html>", "is a web page"),
    "old page": (b"<HTML><body>moved</body></HTML>", "is a web page"),
    "archive": (packed("things/part.stl", exported("stl")), "is a ZIP archive: unpack it, and take 'part.stl' out of it"),
    "archive of texts": (packed("letter.txt", b"hello"), "is a ZIP archive: unpack it, and take the mesh out of it"),
    "packed": (gzip.compress(exported("stl")), "is a packed archive"),
    "document": (b"%PDF-1.7\n" + b"0" * 200, "is a picture or a document"),
    "old GLB": (b"glTF\x01\0\0\0" + b"0" * 200, "is glTF 1.0"),
    "points of a scan": (b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n", "is a cloud of points"),
    "points in text": (b"# scan\nv 0 0 0\nv 10 0 0\nv 0 10 20.5\n", "is a cloud of points"),
    "glTF": (b'{"asset": {"version": "2.0"}, "buffers": [{"uri": "part.bin"}]}', "is a glTF file in several parts"),
}
FILES = {
    "stl": [exported("stl"), exported("stl_ascii")],
    "obj": [exported("obj")],
    "ply": [exported("ply"), ascii_ply()],
    "glb": [glb_with_node()],
    "3mf": [threemf_in("millimeter", 1.0)],
    "step": [box_step((40.0, 30.0, 20.0)).encode()],
}


@pytest.mark.parametrize("suffix", ["stl", "obj", "ply"])
@pytest.mark.parametrize("what", NO_MESH)
def test_what_is_no_mesh_is_named(tmp_path, what, suffix):
    content, words = NO_MESH[what]
    assert words in refusal(put(tmp_path, f"part.{suffix}", content))


@pytest.mark.parametrize("suffix", FORMATS)
@pytest.mark.parametrize("true", FILES)
def test_a_mesh_with_the_suffix_of_another_is_named_and_read_once_it_is_renamed(tmp_path, true, suffix):
    for content in FILES[true]:
        if suffix == true:
            assert mistaken(content, suffix) == ""
        else:
            message = refusal(put(tmp_path, f"part.{suffix}", content))
            assert f"rename it to end in .{true}" in message
            found = read(put(tmp_path, f"part.{true}", content)).mesh
            assert found.is_closed


@pytest.mark.parametrize("kind", ["obj", "stl_ascii"])
def test_a_decimal_comma_is_named(tmp_path, kind):
    text = exported(kind).decode().replace(".5", ",5").replace(".0", ",0").replace("0 ", "0,0 ", 3)
    assert "," in text
    message = refusal(put(tmp_path, f"part.{kind[:3]}", text.encode()))
    assert "writes its numbers with a comma, such as " in message


def test_commas_elsewhere_are_nobodys_concern(tmp_path):
    words = b"# made on 3,5 axes, v 1,5\no part 1,2\n" + exported("obj")
    assert_is_part(read(put(tmp_path, "part.obj", words)).mesh)
    assert trimesh.load(io.BytesIO(words), file_type="obj").volume == pytest.approx(PART.volume)
