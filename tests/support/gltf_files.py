"""GLB files as programs export them: a rod in metres, y up, as a document of glTF and its bytes."""

import json
import struct

import numpy as np
import trimesh


def rod():
    """A rod of 40 mm by 90 mm: document, positions and faces."""
    mesh = trimesh.creation.cylinder(0.02, 0.09, sections=24)
    points, faces = mesh.vertices.astype("<f4"), mesh.faces.astype("<u4")
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "rod"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3"},
            {"bufferView": 1, "componentType": 5125, "count": faces.size, "type": "SCALAR"},
        ],
        "bufferViews": [],
        "buffers": [{"byteLength": 0}],
    }
    return document, points, faces


def glb(document, *arrays):
    """The bytes of a document whose first buffer views are these arrays, one after the other."""
    data = b""
    for number, array in enumerate(arrays):
        content = array.tobytes()
        view = {"buffer": 0, "byteOffset": len(data), "byteLength": len(content)}
        if number < len(document["bufferViews"]):
            document["bufferViews"][number] |= view
        else:
            document["bufferViews"].append(view)
        data += content + bytes(-len(content) % 4)
    document["buffers"][0]["byteLength"] = len(data)
    words = json.dumps(document).encode()
    words += b" " * (-len(words) % 4)
    head = struct.pack("<4sII", b"glTF", 2, 28 + len(words) + len(data))
    return head + struct.pack("<I4s", len(words), b"JSON") + words + struct.pack("<I4s", len(data), b"BIN\0") + data


def quantised(kind="<i2", *, normalised=True):
    """Positions as integers, which the node's scale takes back to metres."""
    document, points, faces = rod()
    largest = np.iinfo(kind).max
    reach = float(np.abs(points).max())
    whole = np.round(points / reach * largest).astype(kind)
    padded = np.zeros((len(whole), 4), kind)
    padded[:, :3] = whole
    document["bufferViews"] = [{"byteStride": padded.itemsize * 4}]
    component = {"<i2": 5122, "<i1": 5120}[kind]
    document["accessors"][0] |= {"componentType": component, "normalized": normalised}
    document["nodes"][0]["scale"] = [reach if normalised else reach / largest] * 3
    document["extensionsRequired"] = ["KHR_mesh_quantization"]
    return glb(document, padded, faces)


def sparse(*, based=True):
    """Positions of which some, or all, are listed apart."""
    document, points, faces = rod()
    wrong = points.copy()
    changed = np.arange(0, len(points), 3 if based else 1).astype("<u2")
    wrong[changed] = 0.0
    listed = {"bufferView": 2, "componentType": 5123}
    document["accessors"][0]["sparse"] = {"count": len(changed), "indices": listed, "values": {"bufferView": 3}}
    if not based:
        del document["accessors"][0]["bufferView"]
    return glb(document, wrong, faces, changed, points[changed])


def fans():
    """The two caps of a rod as fans, its side as a strip."""
    document, _, _ = rod()
    n = 24
    around = 2 * np.pi * np.arange(n) / n
    ring = np.stack([np.cos(around), np.sin(around)], axis=1) * 0.02
    points = np.concatenate([np.column_stack([ring, np.full(n, z)]) for z in (-0.045, 0.045)]).astype("<f4")
    below = np.arange(n)[::-1].astype("<u4")
    above = np.arange(n, 2 * n).astype("<u4")
    strip = np.array([[n + k % n, k % n] for k in range(n + 1)]).ravel().astype("<u4")
    document["accessors"] = [{"bufferView": 0, "componentType": 5126, "count": 2 * n, "type": "VEC3"}]
    document["accessors"] += [
        {"bufferView": view, "componentType": 5125, "count": len(one), "type": "SCALAR"}
        for view, one in enumerate((below, above, strip), 1)
    ]
    document["meshes"][0]["primitives"] = [
        {"attributes": {"POSITION": 0}, "indices": number, "mode": mode} for number, mode in ((1, 6), (2, 6), (3, 5))
    ]
    return glb(document, points, below, above, strip)


def packed(extension, *, view=False):
    """A rod whose numbers are packed by an extension, at its primitive or its buffer views."""
    document, _, _ = rod()
    content = np.arange(50, dtype="<u1")
    document["extensionsRequired"] = document["extensionsUsed"] = [extension]
    if view:
        document["buffers"].append({"byteLength": 9999, "extensions": {extension: {"fallback": True}}})
        packing = {extension: {"buffer": 0, "byteOffset": 0, "byteLength": 50, "byteStride": 12, "count": 50, "mode": "ATTRIBUTES"}}
        document["bufferViews"] = [{}, {"buffer": 1, "byteLength": 9999, "extensions": packing}]
    else:
        for accessor in document["accessors"]:
            del accessor["bufferView"]
        document["meshes"][0]["primitives"][0]["extensions"] = {extension: {"bufferView": 0, "attributes": {"POSITION": 0}}}
    return glb(document, content)


def besides():
    """A good mesh with an empty primitive, one of lines, and one of no vertices beside it."""
    document, points, faces = rod()
    document["accessors"].append({"componentType": 5126, "count": 0, "type": "VEC3"})
    for primitive in ({"attributes": {}}, {"attributes": {"POSITION": 0}, "mode": 1}, {"attributes": {"POSITION": 2}}):
        document["meshes"].append({"primitives": [primitive]})
        document["nodes"].append({"mesh": len(document["meshes"]) - 1})
    document["scenes"][0]["nodes"] = list(range(len(document["nodes"])))
    return glb(document, points, faces)
