"""What a mesh file claims to hold, counted before a parser makes room for it.

A file of a few kilobytes can claim a trillion vertices, use one mesh a million times over, or unpack to gigabytes. The parsers believe
all of that; these counts are held against the size of the file and against what a part may have. 3MF is counted while it is read.
"""

from __future__ import annotations

import json
import re
import struct
from collections import Counter
from collections.abc import Callable, Mapping
from typing import Any

from mechstyle.errors import BadInput

MOST_FACES = 1_000_000
MOST_BYTES = 400_000_000
"""Of a file, and of what it unpacks to; a million faces take 280 MB as words of an STL file."""
MOST_PIECES = 10_000
"""Objects, components and nodes: a part is one body."""
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
BYTES = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
"""Of glTF's component types."""
PACKED = {
    "draco": "is compressed with Draco", "meshopt": "is compressed with meshopt", "instancing": "places one shape many times over",
}  # fmt: skip
"""What extensions of glTF do to a shape, by a part of their names."""
HARMLESS = re.compile(r"[A-Z]+_(materials|texture|lights|mesh_quantization|xmp|animation|node|audio|collider|rigid|physics)", re.IGNORECASE)
"""Extensions that a file may need without its shape being another one."""


def check_claims(name: str, content: bytes, suffix: str) -> None:
    """Refuse a file that claims more than it can hold or a part can have, with BadInput; its parser says what else is damaged."""
    try:
        faces = COUNTED[suffix](content)
    except Beyond as error:
        raise BadInput(f"{name} {error}") from error
    except (ArithmeticError, LookupError, RecursionError, TypeError, ValueError, AttributeError, struct.error):
        return  # damaged in a way that the parser stumbles over as well
    if faces > MOST_FACES:
        raise BadInput(f"{name} has {faces} faces, more than {MOST_FACES}: simplify it in the program it was made with")


class Beyond(Exception):
    """More than there can be, or less than is needed; the sentence without the file's name."""


def _claims(what: str, count: int, most: int) -> None:
    if count > most:
        raise Beyond(f"claims {what.format(count)}, more than it can hold: it is damaged or was made to do harm; export it again")


def stl_length(content: bytes) -> int:
    """Bytes that the header and the triangles of a binary STL take, 0 if it holds none or is none.

    Words never are one by chance: their count, four letters, would be of gigabytes.
    """
    count = struct.unpack_from("<I", content, 80)[0] if len(content) >= 84 else 0
    return 84 + 50 * count if 0 < 84 + 50 * count <= len(content) and count else 0


def ply_faces(content: bytes) -> int:
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


def glb_faces(content: bytes) -> int:
    """Faces of all meshes as often as nodes use them."""
    length = struct.unpack_from("<I", content, 12)[0]
    if length > len(content):
        return 0
    document = json.loads(content[20 : 20 + length])
    _readable(document)
    accessors = document.get("accessors", [])
    sizes = [accessor["count"] * WIDTHS[accessor["type"]] * BYTES[accessor["componentType"]] for accessor in accessors]
    if min(sizes, default=0) < 0:
        raise Beyond("claims less than nothing: it is damaged; export it again")
    bound = [size for size, accessor in zip(sizes, accessors, strict=True) if "bufferView" in accessor or "sparse" not in accessor]
    _claims("{} bytes of numbers", max(bound, default=0), len(content))
    _claims("{} bytes of numbers", sum(sizes), MOST_BYTES)
    if any("uri" in buffer and not buffer["uri"].startswith("data:") for buffer in document.get("buffers", [])):
        raise Beyond("keeps its shape in other files: export it again as one GLB file")
    nodes = document.get("nodes", [])
    too_many(len(nodes) + sum(len(mesh.get("primitives", ())) for mesh in document.get("meshes", [])))
    faces = [sum(_corners(one, accessors) // 3 for one in mesh.get("primitives", ())) for mesh in document.get("meshes", [])]
    return sum(faces[node["mesh"]] for node in nodes if "mesh" in node)


def _readable(document: Mapping[str, Any]) -> None:
    """Refuse a glTF document whose shape is packed or made in a way that is not read here, by the name of that way."""
    asked = {str(name) for name in document.get("extensionsRequired", ())}
    buffers = document.get("buffers", ())
    for view in document.get("bufferViews", ()):
        if view["buffer"] > 0 and "uri" not in buffers[view["buffer"]]:  # of which a GLB file holds nothing
            asked |= set(view.get("extensions", ()))
    bare = {number for number, one in enumerate(document.get("accessors", ())) if "bufferView" not in one and "sparse" not in one}
    for mesh in document.get("meshes", ()):
        for primitive in mesh.get("primitives", ()):
            if not bare.isdisjoint(primitive.get("attributes", {}).values()):
                asked |= set(primitive.get("extensions", ()))
    asked |= {name for node in document.get("nodes", ()) for name in node.get("extensions", ())}
    for name in sorted(asked):
        if not HARMLESS.match(name):
            what = next((words for part, words in PACKED.items() if part in name.lower()), "needs an extension that is not read here")
            raise Beyond(f"{what} ({name[:60]}): export it without that, or as STL")


def _corners(primitive: Mapping[str, Any], accessors: list[Any]) -> int:
    number = primitive.get("indices", primitive.get("attributes", {}).get("POSITION"))
    return 0 if number is None else int(accessors[number]["count"]) * (1 if primitive.get("mode", 4) == 4 else 3)  # strips and fans


def too_many(pieces: int) -> None:
    """Refuse more pieces than a part has."""
    if pieces > MOST_PIECES:
        raise Beyond(f"is made of more than {MOST_PIECES} pieces: a part is one body; merge them in the program it was made with")


COUNTED: Mapping[str, Callable[[bytes], int]] = {
    "stl": lambda content: (stl_length(content) - 84) // 50 if stl_length(content) else content.count(b"endfacet"),
    "obj": lambda content: len(re.findall(rb"(?m)^[ \t]*f[ \t]", content)), "ply": ply_faces, "glb": glb_faces,
}  # fmt: skip
"""How many faces a file claims to have, by its format."""
