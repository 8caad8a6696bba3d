"""Load a MechStyle run folder into Blender: shape, colours, and stress, demand and restraint as attributes of its vertices.

In Blender's Scripting tab set FOLDER and run this; or, from a terminal:

    blender --python docs/blender.py -- runs/cup [LANE] [ITERATION]

The stress is shown by a material of its own; other fields are in the Spreadsheet editor and in the Attribute node. Lengths are in mm.
This needs Blender 3.4 or newer and nothing else: it reads the folder itself, and writes nothing.
"""

import hashlib
import io
import json
import sys
import zlib
from pathlib import Path
from typing import Any

import numpy as np

FOLDER = ""
FIELDS = {"stress": "stress_MPa", "demand": "demand", "mask": "mask", "displacement": "displacement_mm"}
"""Fields of a checkpoint, and what they are called in Blender."""
MOST_BYTES = 256_000_000


def stored(root: Path, digest: str) -> bytes:
    """An object of a run folder, verified."""
    if len(digest) != 64 or set(digest) - set("0123456789abcdef"):
        raise ValueError(f"{digest[:80]!r} is no digest")
    content = zlib.decompressobj().decompress((root / "objects" / digest[:2] / digest[2:]).read_bytes(), MOST_BYTES)
    if hashlib.sha256(content).hexdigest() != digest:
        raise ValueError(f"object {digest} is damaged")
    return content


def record(root: Path, digest: str) -> dict:
    """A stored record."""
    return json.loads(stored(root, digest))


def array(root: Path, digest: str) -> np.ndarray:
    """A stored array."""
    return np.load(io.BytesIO(stored(root, digest)), allow_pickle=False)


def loaded(root: Path, lane: str = "main", iteration: int | None = None) -> dict:
    """Vertices [mm], faces, colours and fields of an iteration, the last unless told.

    Raises:
        ValueError: If the lane never reached it, or something is damaged.
    """
    part = json.loads((root / "part.json").read_text(encoding="utf-8"))
    surface = record(root, part["surface"])
    vertices, faces = array(root, surface["vertices"]).astype(np.float64), array(root, surface["cells"])
    state = record(root, json.loads((root / "lanes" / f"{lane}.json").read_text(encoding="utf-8"))["head"])
    while iteration is not None and state["iteration"] != iteration:
        if not state["parent"]:
            raise ValueError(f"lane {lane!r} never reached iteration {iteration}")
        state = record(root, state["parent"])
    fields = {name: array(root, state[field]).astype(np.float32) for field, name in FIELDS.items()}
    along = fields["displacement_mm"].astype(np.float64)[:, None] * vertex_normals(vertices, faces)
    return {
        "name": part["name"],
        "vertices": vertices + along,
        "faces": faces,
        "fields": fields,
        "colours": array(root, state["colour"]).astype(np.float32),
        "iteration": state["iteration"],
    }


def vertex_normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Unit normals, weighted by the angles of the faces, as MechStyle displaces along, shape [vertex_count, 3]."""
    corners = vertices[faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(cross, axis=1, keepdims=True)
    unit = cross / np.where(lengths > 0, lengths, 1.0)
    summed = np.zeros_like(vertices)
    for corner in range(3):
        ahead = corners[:, (corner + 1) % 3] - corners[:, corner]
        back = corners[:, (corner + 2) % 3] - corners[:, corner]
        angles = np.arctan2(np.linalg.norm(np.cross(ahead, back), axis=1), (ahead * back).sum(axis=1))
        np.add.at(summed, faces[:, corner], unit * angles[:, None])
    lengths = np.linalg.norm(summed, axis=1, keepdims=True)
    return summed / np.where(lengths > 0, lengths, 1.0)


def show(found: dict) -> None:
    """Make an object of it, with the colours and the fields as attributes, and a material that shows the stress."""
    import bpy  # noqa: PLC0415 — only Blender has it

    mesh = bpy.data.meshes.new(found["name"])
    mesh.from_pydata(found["vertices"].tolist(), [], found["faces"].tolist())
    for name, values in found["fields"].items():
        mesh.attributes.new(name, "FLOAT", "POINT").data.foreach_set("value", values)
    opaque = np.column_stack([found["colours"], np.ones(len(found["colours"]), np.float32)])
    mesh.color_attributes.new("style", "BYTE_COLOR", "POINT").data.foreach_set("color_srgb", opaque.ravel())
    mesh.materials.append(stress_material(bpy, float(found["fields"]["stress_MPa"].max()) or 1.0))
    mesh.update()
    item = bpy.data.objects.new(f"{found['name']}, iteration {found['iteration']}", mesh)
    item.scale = (0.001,) * 3  # Blender's unit is the metre
    bpy.context.collection.objects.link(item)


def stress_material(bpy: Any, top: float) -> Any:
    """A material that is blue where there is no stress, yellow where there is most [MPa]."""
    made = bpy.data.materials.new("stress")
    if made.node_tree is None:  # before Blender 5
        made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    field, ramp, scale = nodes.new("ShaderNodeAttribute"), nodes.new("ShaderNodeValToRGB"), nodes.new("ShaderNodeMapRange")
    field.attribute_name = "stress_MPa"
    scale.inputs["From Max"].default_value = top
    ramp.color_ramp.elements[0].color = (0.0, 0.02, 0.2, 1.0)
    ramp.color_ramp.elements[1].color = (1.0, 0.75, 0.05, 1.0)
    links.new(field.outputs["Fac"], scale.inputs["Value"])
    links.new(scale.outputs["Result"], ramp.inputs["Fac"])
    links.new(ramp.outputs["Color"], nodes["Principled BSDF"].inputs["Base Color"])
    return made


if __name__ == "__main__":
    given = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else [FOLDER]
    show(loaded(Path(given[0]), *given[1:2], *map(int, given[2:3])))
