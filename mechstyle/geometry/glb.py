"""Binary glTF 2.0, written: one mesh in metres with y up, of one material, dull by default, colours at its vertices.

Colours at vertices are linear there (section 3.7.2.1 of the specification).
Other fields are application-specific attributes, whose names begin with an underscore (section 3.7.2.1).

Read, it is made plain for its parser: numbers as floats, triangles as lists, without primitives that have no surface (3.6.2, accessors:
normalised integers, sparse values; 3.7.2.1, modes of primitives). What is compressed is refused before, by `claims`.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mechstyle._colour import srgb_to_linear
from mechstyle.geometry.claims import MOST_FACES, WIDTHS, Beyond
from mechstyle.geometry.pieces import COLOURS_LEFT
from mechstyle.geometry.upright import upright
from mechstyle.records.mesh import Field, SurfaceMesh

METRES = 1e-3
PLAIN = 0.8
"""Linear reflectance of a part without colours."""

_FLOAT, _SHORT, _INT = 5126, 5123, 5125
_VERTICES, _INDICES = 34962, 34963


class Sheen(NamedTuple):
    """How a surface reflects, as glTF has it, both in [0, 1]; by default as a print does, which is no mirror and no metal."""

    metallic: float = 0.0
    roughness: float = 0.8


DULL = Sheen()
"""That of a print."""


def glb_bytes(mesh: SurfaceMesh, name: str, fields: Mapping[str, Field] = MappingProxyType({}), sheen: Sheen = DULL) -> bytes:
    """A GLB file of a part [mm], z up; the same mesh gives the same bytes.

    `fields` are finite values at its vertices by name, shape [vertex_count]: `stress` becomes the attribute `_STRESS`.
    """
    buffer = _Buffer()
    positions = np.asarray(mesh.vertices @ upright("y") * METRES, np.float32)
    limits = {"min": positions.min(axis=0).tolist(), "max": positions.max(axis=0).tolist()}
    attributes = {"POSITION": buffer.accessor(positions, _FLOAT, "VEC3", _VERTICES, **limits)}
    shaded: dict[str, Any] = {"metallicFactor": sheen.metallic, "roughnessFactor": sheen.roughness}
    document: dict[str, Any] = {"asset": {"version": "2.0", "generator": "MechStyle"}, "scene": 0}
    if mesh.colours is not None:
        opaque = np.column_stack([srgb_to_linear(np.clip(mesh.colours, 0.0, 1.0)), np.ones(len(mesh.colours))])
        linear = np.round(opaque * 65535.0).astype(np.uint16)  # in 8 bits dark colours would not differ
        attributes["COLOR_0"] = buffer.accessor(linear, _SHORT, "VEC4", _VERTICES, normalized=True)
    else:
        shaded["baseColorFactor"] = [PLAIN, PLAIN, PLAIN, 1.0]
    for called, values in fields.items():
        attributes[f"_{called.upper()}"] = buffer.accessor(values.astype(np.float32), _FLOAT, "SCALAR", _VERTICES)
    indices = buffer.accessor(mesh.faces.astype(np.uint32).ravel(), _INT, "SCALAR", _INDICES)
    document |= {
        "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0, "name": name}],
        "meshes": [{"name": name, "primitives": [{"attributes": attributes, "indices": indices, "material": 0, "mode": 4}]}],
        "materials": [{"name": "print", "pbrMetallicRoughness": shaded}], "accessors": buffer.accessors, "bufferViews": buffer.views,
        "buffers": [{"byteLength": len(buffer.content)}],
    }  # fmt: skip
    return _file(struct.pack("<4sI", b"glTF", 2), json.dumps(document, separators=(",", ":")), bytes(buffer.content))


class _Buffer:
    """The binary part of the file, and what says where in it everything is."""

    def __init__(self) -> None:
        self.content = bytearray()
        self.views: list[dict[str, int]] = []
        self.accessors: list[dict[str, Any]] = []

    def accessor(self, array: NDArray[Any], component: int, kind: str, target: int, **more: Any) -> int:
        """Add an array; the number of its accessor, and of its view."""
        data = np.ascontiguousarray(array).tobytes()
        self.views.append({"buffer": 0, "byteOffset": len(self.content), "byteLength": len(data), "target": target})
        self.content += _padded(data, b"\0")
        self.accessors.append({"bufferView": len(self.accessors), "componentType": component, "count": len(array), "type": kind, **more})
        return len(self.accessors) - 1


def _file(begin: bytes, document: str, binary: bytes) -> bytes:
    """A GLB file of what it begins with, its document and its numbers."""
    head, body = _padded(document.encode(), b" "), _padded(binary, b"\0")
    chunks = b"".join(struct.pack("<I4s", len(chunk), kind) + chunk for chunk, kind in ((head, b"JSON"), (body, b"BIN\0")))
    return begin + struct.pack("<I", 12 + len(chunks)) + chunks


def _padded(data: bytes, filler: bytes) -> bytes:
    return data + filler * (-len(data) % 4)


TRIANGLES, STRIP, FAN = 4, 5, 6
"""Modes of primitives that have a surface."""
TYPES = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
"""Of glTF's component types."""
POSED = "it is read as it was modelled: its skeleton and its morphs are not applied"


def plain(content: bytes) -> tuple[bytes, tuple[str, ...]]:
    """The same shape without normalised or sparse numbers, fans and primitives that have no surface; and what is to be known of it.

    Raises:
        Beyond: If the scene it shows is empty.
        ValueError, KeyError, IndexError, TypeError and their kind: If it is damaged.
    """
    length = struct.unpack_from("<I", content, 12)[0]
    document, rest = json.loads(content[20 : 20 + length]), content[20 + length :]
    binary = bytearray(rest[8 : 8 + struct.unpack_from("<I", rest)[0]]) if len(rest) >= 8 else bytearray()
    accessors, meshes = document.get("accessors", []), document.get("meshes", [])
    rewritten: dict[int, int] = {}
    coloured = any(map(_painted, document.get("materials", ())))
    for mesh in meshes:
        kept = []
        for primitive in mesh.get("primitives", ()):
            position = primitive.get("attributes", {}).get("POSITION")
            if position is None or not accessors[position]["count"] or primitive.get("mode", TRIANGLES) not in (TRIANGLES, STRIP, FAN):
                continue
            indices = primitive.get("indices")
            if indices is not None and not accessors[indices]["count"]:
                continue
            coloured |= "COLOR_0" in primitive["attributes"]
            primitive.pop("extensions", None)  # what they hold besides is not needed, or refused before
            primitive["attributes"] = {"POSITION": _dense_accessor(document, binary, position, rewritten)}
            if indices is not None:
                primitive["indices"] = _dense_accessor(document, binary, indices, rewritten)
            if primitive.get("mode") == FAN:
                around = np.arange(accessors[position]["count"]) if indices is None else _numbers(document, binary, indices).ravel()
                fan = np.stack([np.full(len(around) - 2, around[0]), around[1:-1], around[2:]], axis=1).astype("<u4")
                primitive |= {"mode": TRIANGLES, "indices": _added(document, binary, fan.reshape(-1, 1), "SCALAR", 5125)}
            kept.append(primitive)
        mesh["primitives"] = kept
    posed = _tidied(document)
    scenes = document.get("scenes", ())
    if scenes and not scenes[document.get("scene", 0)].get("nodes") and any("mesh" in node for node in document.get("nodes", ())):
        raise Beyond("has nothing in the scene that it shows: put the part into it in the program it was made with, and save it again")
    if document.get("buffers") and "uri" not in document["buffers"][0]:
        document["buffers"][0]["byteLength"] = len(binary)
    notes = ([POSED] if posed else []) + ([COLOURS_LEFT] if coloured else [])
    return _file(content[:8], json.dumps(document), bytes(binary)), tuple(notes)


def _tidied(document: dict[str, Any]) -> bool:
    """Whether skeletons or morphs move something; nodes without a surface lose their mesh, and are put in the order of the file.

    The parser takes siblings from their end.
    """
    meshes, nodes = document.get("meshes", []), document.get("nodes", [])
    posed = any("skin" in node or any(node.get("weights", ())) for node in nodes)
    posed |= any(any(mesh.get("weights", ())) for mesh in meshes)
    for node in nodes:
        if "mesh" in node and not meshes[node["mesh"]]["primitives"]:
            del node["mesh"]
        node.get("children", []).reverse()
    for scene in document.get("scenes", ()):
        scene.get("nodes", []).reverse()
    return posed


def _dense_accessor(document: dict[str, Any], binary: bytearray, number: int, rewritten: dict[int, int]) -> int:
    """An accessor of the same numbers, neither normalised nor sparse."""
    accessor = document["accessors"][number]
    if "sparse" not in accessor and not accessor.get("normalized"):
        return number
    if number not in rewritten:
        values = _numbers(document, binary, number)
        if accessor.get("normalized"):
            values = np.maximum(values / np.iinfo(values.dtype).max, -1.0).astype("<f4")
        kind = 5126 if values.dtype == np.float32 else accessor["componentType"]
        rewritten[number] = _added(document, binary, values, accessor["type"], kind)
    return rewritten[number]


def _numbers(document: Mapping[str, Any], binary: bytearray, number: int) -> NDArray[Any]:
    """The numbers of an accessor, sparse ones put in, shape [count, width]."""
    accessor = document["accessors"][number]
    kind, width, count = np.dtype(TYPES[accessor["componentType"]]), WIDTHS[accessor["type"]], int(accessor["count"])
    if not 0 <= count <= 3 * MOST_FACES:
        raise Beyond(f"claims {count} numbers, more than it can hold: it is damaged or was made to do harm; export it again")
    values = np.zeros((count, width), kind)
    if "bufferView" in accessor:
        values = _view(document, binary, accessor, kind, width, count).copy()
    if "sparse" in accessor:
        sparse = accessor["sparse"]
        changed = int(sparse["count"])
        if not 0 < changed <= count:
            raise Beyond("claims more changed numbers than it has: it is damaged; export it again")
        where = _view(document, binary, sparse["indices"], np.dtype(TYPES[sparse["indices"]["componentType"]]), 1, changed)
        values[where[:, 0].astype(np.int64)] = _view(document, binary, sparse["values"], kind, width, changed)
    return values


def _view(
    document: Mapping[str, Any], binary: bytearray, at: Mapping[str, Any], kind: np.dtype[Any], width: int, count: int
) -> NDArray[Any]:
    """Numbers as they lie in a buffer view, shape [count, width]."""
    view = document["bufferViews"][at["bufferView"]]
    if view["buffer"] != 0 or "uri" in document["buffers"][0]:
        raise Beyond("keeps sparse or normalised numbers outside its own bytes: export it again as one GLB file")
    start = int(view.get("byteOffset", 0)) + int(at.get("byteOffset", 0))
    row = kind.itemsize * width
    stride = int(view.get("byteStride", row))
    end = start + stride * (count - 1) + row
    if start < 0 or stride < row or end > len(binary):
        raise Beyond("has numbers beyond its end: it was cut off or is damaged; export it again")
    content = np.frombuffer(binary, np.uint8)[start:end]
    rows = np.lib.stride_tricks.as_strided(content, (count, row), (stride, 1), writeable=False)
    return np.ascontiguousarray(rows).view(kind)


def _added(document: dict[str, Any], binary: bytearray, values: NDArray[Any], kind: str, component: int) -> int:
    """A new accessor of numbers, which are added to the bytes of the file."""
    content = np.ascontiguousarray(values).tobytes()
    binary += bytes(-len(binary) % 4)
    document["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(content)})
    document["accessors"].append(
        {"bufferView": len(document["bufferViews"]) - 1, "componentType": component, "count": len(values), "type": kind}
    )
    binary += content
    return len(document["accessors"]) - 1


def _painted(material: Mapping[str, Any]) -> bool:
    """Whether a material has a texture, or a colour that is no grey, in any of the ways to give one."""
    looks = [material, material.get("pbrMetallicRoughness", {}), *material.get("extensions", {}).values()]
    words = {key: value for look in looks for key, value in look.items()}
    textures = any(f"{what}Texture" in words for what in ("baseColor", "diffuse", "emissive"))
    factors = [words.get(f"{what}Factor", (1, 1, 1))[:3] for what in ("baseColor", "diffuse", "emissive")]
    return textures or any(len(set(factor)) > 1 for factor in factors)
