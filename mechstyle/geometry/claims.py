"""What a mesh file claims to hold, counted before a parser makes room for it.

A file of a few kilobytes can claim a trillion vertices, use one mesh a million times over, or unpack to gigabytes. The parsers believe
all of that; these counts are held against the size of the file and against what a part may have.
"""

from __future__ import annotations

import copy
import io
import json
import re
import struct
import zipfile
import zlib
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping
from typing import Any
from xml.parsers import expat

from mechstyle.errors import BadInput

MOST_FACES = 1_000_000
MOST_BYTES = 400_000_000
"""Of a file, and of what it unpacks to; a million faces take 280 MB as words of an STL file."""
MOST_PIECES = 10_000
"""Objects, components and nodes: a part is one body."""
MOST_MARKS = 16_000_000
"""Elements and attributes of XML; a million faces and their vertices take ten million."""
PIECE = 1_000_000
"""Bytes that are unpacked at a time."""
ENCRYPTED = 1
"""Of the flags of an entry of a ZIP package."""

WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
BYTES = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
"""Of glTF's component types."""


def check_claims(name: str, content: bytes, suffix: str) -> None:
    """Refuse a file that claims more than it can hold or a part can have, with BadInput; what is damaged otherwise its parser will say.

    Args:
        name: What to call the file.
        content: Its bytes.
        suffix: Its format, one of `files.FORMATS`.
    """
    try:
        faces = COUNTED[suffix](content)
    except _Beyond as error:
        raise BadInput(f"{name} {error}") from error
    except (ArithmeticError, EOFError, LookupError, RecursionError, TypeError, ValueError, AttributeError, NotImplementedError, OSError,
            struct.error, zipfile.BadZipFile, zlib.error, expat.ExpatError):  # fmt: skip
        return  # damaged in a way that the parser stumbles over as well
    if faces > MOST_FACES:
        raise BadInput(f"{name} has {faces} faces, more than {MOST_FACES}: simplify it in the program it was made with")


class _Beyond(Exception):
    """More than there can be; the sentence without the file's name."""


def _claims(what: str, count: int, most: int) -> None:
    if count > most:
        raise _Beyond(f"claims {what.format(count)}, more than it can hold: it is damaged or was made to do harm; export it again")


def _of_stl(content: bytes) -> int:
    count = struct.unpack_from("<I", content, 80)[0] if len(content) >= 84 else -1
    return count if len(content) == 84 + 50 * count else content.count(b"endfacet")


def _of_obj(content: bytes) -> int:
    return len(re.findall(rb"(?m)^[ \t]*f[ \t]", content))


def _of_ply(content: bytes) -> int:
    """Faces by the header; every element takes at least a byte for each of its properties."""
    head, _, body = content.partition(b"end_header")
    counts, properties, last = Counter[str](), Counter[str](), ""
    for line in head.decode("ascii", errors="replace").splitlines():
        words = line.split()
        if words[:1] == ["element"]:
            last = words[1]
            counts[last] = int(words[2])
        elif words[:1] == ["property"]:
            properties[last] += 1
    _claims("{} numbers", sum(count * max(properties[element], 1) for element, count in counts.items()), len(body))
    return counts["face"]


def _of_glb(content: bytes) -> int:
    """Faces of all meshes as often as nodes use them."""
    length = struct.unpack_from("<I", content, 12)[0]
    if length > len(content):
        return 0
    document = json.loads(content[20 : 20 + length])
    accessors = document.get("accessors", [])
    sizes = [accessor["count"] * WIDTHS[accessor["type"]] * BYTES[accessor["componentType"]] for accessor in accessors]
    if min(sizes, default=0) < 0:
        raise _Beyond("claims less than nothing: it is damaged; export it again")
    _claims("{} bytes of numbers", max(sizes, default=0), len(content))
    _claims("{} bytes of numbers", sum(sizes), MOST_BYTES)
    if any("uri" in buffer and not buffer["uri"].startswith("data:") for buffer in document.get("buffers", [])):
        raise _Beyond("keeps its shape in other files: export it again as one GLB file")
    nodes = document.get("nodes", [])
    _too_many(len(nodes) + sum(len(mesh.get("primitives", ())) for mesh in document.get("meshes", [])))
    faces = [sum(_corners(one, accessors) // 3 for one in mesh.get("primitives", ())) for mesh in document.get("meshes", [])]
    return sum(faces[node["mesh"]] for node in nodes if "mesh" in node)


def _corners(primitive: Mapping[str, Any], accessors: list[Any]) -> int:
    number = primitive.get("indices", primitive["attributes"]["POSITION"])
    return int(accessors[number]["count"]) * (3 if primitive.get("mode", 4) == 5 else 1)  # a strip has a face for each corner


def _of_3mf(content: bytes) -> int:
    """Faces of all objects as often as they are built."""
    with zipfile.ZipFile(io.BytesIO(content)) as package:
        entries = package.infolist()
        _too_many(len(entries))
        if sum(entry.file_size for entry in entries) > MOST_BYTES:
            raise _Beyond(f"unpacks to more than {MOST_BYTES / 1e6:.0f} MB: simplify it in the program it was made with")
        models = _Models()
        for entry in entries:
            _check_packing(package, entry)
            if entry.filename.lower().endswith(".model"):
                with package.open(entry) as model:
                    models.read("/" + entry.filename.lstrip("/"), model)
    return models.built()


def _check_packing(package: zipfile.ZipFile, entry: zipfile.ZipInfo) -> None:
    """Refuse an entry that does not unpack to the size that the package says: parsers unpack all of it, and keep no more than that."""
    if entry.flag_bits & ENCRYPTED:
        raise _Beyond("is encrypted: save it without a password")
    if entry.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):  # of others no piece has a bound
        raise _Beyond("is packed in a way that 3MF does not know: export it again")
    unbelieved = copy.copy(entry)
    unbelieved.file_size, unbelieved.CRC = MOST_BYTES + 1, None  # type: ignore[assignment]
    size = 0
    with package.open(unbelieved) as file:
        while size <= entry.file_size and (piece := file.read(PIECE)):
            size += len(piece)
    if size != entry.file_size:
        raise _Beyond("unpacks to another size than it says: it is damaged or was made to do harm; export it again")


def _of_built(uses: Mapping[str, Counter[str]], own: Mapping[str, int], start: str) -> Iterator[tuple[str, int]]:
    """Every object with how often it is used in all, from a start; circles end, as they are counted no deeper than there are objects."""
    level, pieces = Counter({start: 1}), 0
    for _ in range(len(uses) + len(own) + 1):
        if not level:
            return
        below = Counter[str]()
        for name, times in level.items():
            yield name, times
            for used, often in uses.get(name, {}).items():
                below[used] += times * often
        pieces += sum(below.values())
        _too_many(pieces)
        level = below
    raise _Beyond("has an object that is part of itself: it is damaged; export it again")


def _too_many(pieces: int) -> None:
    if pieces > MOST_PIECES:
        raise _Beyond(f"is made of more than {MOST_PIECES} pieces: a part is one body; merge them in the program it was made with")


class _Models:
    """Objects of the models of a 3MF package: their faces, and what they are made of."""

    def __init__(self) -> None:
        self.faces = Counter[str]()
        self.uses: defaultdict[str, Counter[str]] = defaultdict(Counter)
        self._marks = 0
        self._file = self._object = ""

    def read(self, name: str, file: Any) -> None:
        """Count the elements of a model, whose name in the package is given."""
        self._file, self._object = name, ""
        parser = expat.ParserCreate(namespace_separator=" ")
        parser.StartElementHandler = self._element
        parser.StartDoctypeDeclHandler = self._doctype
        parser.ParseFile(file)

    def built(self) -> int:
        """Faces of all that is built."""
        return sum(times * self.faces[name] for name, times in _of_built(self.uses, self.faces, "build"))

    def _doctype(self, *_: object) -> None:
        raise _Beyond("declares a document type, which no 3MF file may: it is something else, or was made to do harm; export it again")

    def _element(self, tag: str, attributes: dict[str, str]) -> None:
        self._marks += 1 + len(attributes)
        if self._marks > MOST_MARKS:
            raise _Beyond(f"holds more than {MOST_MARKS / 1e6:.0f} million elements: simplify it in the program it was made with")
        kind = tag.rpartition(" ")[2]
        if kind == "object":
            self._object = attributes.get("id", "")
        elif kind == "triangle":
            self.faces[self._object] += 1
            self.faces[self._file] += 1
        elif kind in ("component", "item"):
            user, used = self._object if kind == "component" else "build", attributes.get("objectid", "")
            path = next((value for name, value in attributes.items() if name.endswith("path")), "")
            self.uses[user]["/" + path.strip("/") if path else used] += 1  # of another model the parser reads the whole, each time


COUNTED = {"stl": _of_stl, "obj": _of_obj, "ply": _of_ply, "glb": _of_glb, "3mf": _of_3mf}
