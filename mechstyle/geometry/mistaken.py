"""What a file is that is not what its suffix says: recognised by its first bytes, and named, so that people know what to do."""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Callable
from pathlib import Path

from mechstyle.geometry.claims import stl_length
from mechstyle.geometry.pieces import quoted_name

MESHES = (".stl", ".obj", ".ply", ".glb", ".3mf", ".step", ".stp")
START = 1 << 16
"""Bytes of a text that are looked at."""
NUMBER = rb"[-+]?[\d.]+(?:[eE][-+]?\d+)?"
VERTEX = re.compile(rb"(?m)^\s*v\s+%b\s+%b\s+%b" % (NUMBER, NUMBER, NUMBER))
COMMA = re.compile(rb"(?m)^\s*(?:v|vertex)\s+(?:\S+\s+)*?([-+]?\d+,\d+)(?=\s)")
"""The first number of a vertex in OBJ or STL that has a comma for its point."""
DRAWN = re.compile(rb"(?m)^\s*(?:f|fo|l|curv|curv2|surf)\s")
"""What OBJ draws between its vertices."""
CLOUD = "is a cloud of points without faces between them: make a surface of it first, such as with MeshLab"


def mistaken(content: bytes, suffix: str) -> str:
    """What a file with a suffix is instead and what to do, as the end of a sentence that began with its name; "" where nothing is seen.

    Args:
        content: All of it.
        suffix: Its suffix in small letters, without the dot.
    """
    for own, is_it, what in KINDS:
        if own != suffix and is_it(content):
            return what(content) if callable(what) else what
    if suffix in {"obj", "stl"} and b"\0" not in content[:START] and (found := COMMA.search(content[:START])):
        return f"writes its numbers with a comma, such as {found[1].decode()}: export it with points, in a program set to English"
    return ""


def _starts(*signs: bytes) -> Callable[[bytes], bool]:
    return lambda content: content.startswith(signs)


def _says(pattern: bytes) -> Callable[[bytes], bool]:
    return lambda content: re.search(pattern, content[:START]) is not None


def _rename(kind: str, suffix: str) -> str:
    return f"is {kind}, whatever its name says: rename it to end in .{suffix}"


def _archive(content: bytes) -> str:
    """What is in a ZIP archive."""
    try:
        names = zipfile.ZipFile(io.BytesIO(content)).namelist()
    except (zipfile.BadZipFile, ValueError, OSError, NotImplementedError):
        names = []
    if any(name.lower().replace("\\", "/").endswith("3d/3dmodel.model") for name in names):
        return _rename("a 3MF file", "3mf")
    within = next((Path(name).name for name in names if name.lower().endswith(MESHES)), "")
    return f"is a ZIP archive: unpack it, and take {quoted_name(within) if within else 'the mesh'} out of it"


KINDS: tuple[tuple[str, Callable[[bytes], bool], str | Callable[[bytes], str]], ...] = (
    (
        "",
        _starts(b"version https://git-lfs"),
        "is a Git LFS pointer, which only stands for the file: get the file itself with `git lfs pull`, or download it from its page",
    ),
    (
        "",
        _says(rb"(?i)\A(?:\xef\xbb\xbf)?\s*<(?:!doctype html|html)\b"),
        "is a web page, such as one that asks to log in: download the file itself",
    ),
    ("3mf", _starts(b"PK\x03\x04", b"PK\x05\x06"), _archive),
    ("", _starts(b"\x1f\x8b", b"Rar!", b"7z\xbc\xaf\x27\x1c"), "is a packed archive: unpack it, and take the mesh out of it"),
    ("", _starts(b"%PDF", b"\x89PNG", b"\xff\xd8\xff", b"GIF8"), "is a picture or a document: it holds no shape"),
    ("step", _starts(b"ISO-10303-21"), _rename("a STEP file", "step")),
    ("", _starts(b"glTF\x01\0\0\0"), "is glTF 1.0, which came before the glTF of today: export it again as glTF 2.0"),
    ("glb", _starts(b"glTF"), _rename("a GLB file", "glb")),
    ("", _says(rb"\Aply\r?\n(?:(?!element\s+face|end_header).*\n)*end_header"), CLOUD),
    ("ply", _starts(b"ply\n", b"ply\r"), _rename("a PLY file", "ply")),
    ("stl", lambda content: stl_length(content) == len(content) > 0, _rename("an STL file", "stl")),
    ("stl", _says(rb"(?i)\A\s*solid\b[^\n]*\n\s*facet\s+normal\b"), _rename("an STL file", "stl")),
    ("obj", lambda content: len(VERTEX.findall(content[:START])) >= 3 and b"\nf " in content, _rename("an OBJ file", "obj")),
    ("", lambda content: VERTEX.search(content[:START]) is not None and not DRAWN.search(content), CLOUD),
    (
        "",
        _says(rb'\A\s*\{[^{}]{0,400}"(?:asset|scenes?|accessors|buffers)"\s*:'),
        "is a glTF file in several parts: export it as one GLB file",
    ),
)
"""Suffix that it would be right for, how it is recognised, and what is said of it."""
