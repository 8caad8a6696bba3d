"""Writing binary glTF 2.0: one mesh in metres with y up, of one material, dull by default, colours at its vertices.

Colours at vertices are linear there (section 3.7.2.1 of the specification).
Other fields are application-specific attributes, whose names begin with an underscore (section 3.7.2.1).
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
    """A GLB file; the same mesh gives the same bytes.

    Args:
        mesh: The part [mm], z up.
        name: What it is called in the scene.
        fields: Finite values at its vertices by name, shape [vertex_count]: `stress` becomes the attribute `_STRESS`.
        sheen: How it reflects.
    """
    buffer = _Buffer()
    positions = np.asarray(mesh.vertices @ upright("y") * METRES, np.float32)
    limits = {"min": positions.min(axis=0).tolist(), "max": positions.max(axis=0).tolist()}
    attributes = {"POSITION": buffer.accessor(positions, _FLOAT, "VEC3", _VERTICES, **limits)}
    shaded: dict[str, Any] = {"metallicFactor": sheen.metallic, "roughnessFactor": sheen.roughness}
    document: dict[str, Any] = {"asset": {"version": "2.0", "generator": "MechStyle"}, "scene": 0}
    if mesh.colours is not None:
        attributes["COLOR_0"] = buffer.accessor(_linear(mesh.colours), _SHORT, "VEC4", _VERTICES, normalized=True)
    else:
        shaded["baseColorFactor"] = [PLAIN, PLAIN, PLAIN, 1.0]
    for called, values in fields.items():
        attributes[f"_{called.upper()}"] = buffer.accessor(values.astype(np.float32), _FLOAT, "SCALAR", _VERTICES)
    indices = buffer.accessor(mesh.faces.astype(np.uint32).ravel(), _INT, "SCALAR", _INDICES)
    document |= {
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": name}],
        "meshes": [{"name": name, "primitives": [{"attributes": attributes, "indices": indices, "material": 0, "mode": 4}]}],
        "materials": [{"name": "print", "pbrMetallicRoughness": shaded}],
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{"byteLength": len(buffer.content)}],
    }
    head, body = _padded(json.dumps(document, separators=(",", ":")).encode(), b" "), _padded(bytes(buffer.content), b"\0")
    chunks = b"".join(struct.pack("<I4s", len(chunk), kind) + chunk for chunk, kind in ((head, b"JSON"), (body, b"BIN\0")))
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def _linear(colours: NDArray[np.floating]) -> NDArray[np.uint16]:
    """Colours as linear 16-bit RGBA: in 8 bits dark ones would not differ."""
    opaque = np.column_stack([srgb_to_linear(np.clip(colours, 0.0, 1.0)), np.ones(len(colours))])
    return np.round(opaque * 65535.0).astype(np.uint16)


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


def _padded(data: bytes, filler: bytes) -> bytes:
    return data + filler * (-len(data) % 4)
