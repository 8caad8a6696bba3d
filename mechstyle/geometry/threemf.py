"""Writing 3MF with colours, for viewers and for slicers that paint.

A core 3MF package with one `m:colorgroup` (3MF Materials and Properties Extension 1.2.1), which viewers show and slicers pass over. What
these read is a word a triangle: PrusaSlicer in a namespace of its own, which the standard allows, so that one file is for both; Bambu
Studio and OrcaSlicer without one, which it does not, so that theirs is another file.

The words are PrusaSlicer's (`TriangleSelector::serialize`), which Bambu Studio and OrcaSlicer took over: a stream of 4-bit numbers, written
in reverse as hexadecimal digits. A number `xxyy` with yy = 0 is a whole triangle of state xx, or for xx = 11 of the next number plus 3;
with yy = 2 or 3 its corner xx is cut off, or all of them are, at the middles of the sides, and its 3 or 4 parts follow, the last first.
State n is filament n; state 0 would be the object's own.
"""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Mapping, Sequence
from itertools import chain
from typing import NamedTuple
from xml.sax.saxutils import escape

import numpy as np

from mechstyle.errors import unknown
from mechstyle.geometry.filaments import MOST, Painted, Palette, clustered, painted
from mechstyle.records.mesh import Indices, SurfaceMesh

SLICERS = ("standard", "prusa", "bambu", "orca")
"""Whose file it is; the first two are one file, and so are the last two."""

_TYPES = (
    '<?xml version="1.0" encoding="UTF-8"?>\n'
    '<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">'
    '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
    '<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>{}</Types>'
)
_SETTINGS = '<Default Extension="config" ContentType="application/octet-stream"/>'
_RELATIONS = (
    '<?xml version="1.0" encoding="UTF-8"?>\n'
    '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
    '<Relationship Target="/3D/3dmodel.model" Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>'
)
_GROUP = 100
"""Identifier of the group of colours; those of objects are below."""


class Body(NamedTuple):
    """A body of a part that is printed of one filament."""

    name: str  # what slicers call it
    mesh: SurfaceMesh  # its closed surface [mm]
    filament: int  # place of its filament in the palette


def check_slicer(slicer: str) -> None:
    """Refuse the name of a slicer nobody knows, with BadInput."""
    if slicer not in SLICERS:
        raise unknown("slicer", slicer, SLICERS)


def threemf_bytes(
    mesh: SurfaceMesh, name: str = "part", *, paint: Painted | None = None, slicer: str = "standard", filament_type: str = "PLA"
) -> bytes:
    """A 3MF package of the mesh in millimetres; the same mesh gives the same bytes.

    Args:
        mesh: The part.
        name: What slicers call it.
        paint: Its filaments, which slicers read; without it the vertex colours are reduced to MOST, for viewers only.
        slicer: One of SLICERS.
        filament_type: What the filaments are, as Bambu Studio and OrcaSlicer call it.
    """
    check_slicer(slicer)
    called = _attribute(name)
    shown = paint
    if shown is None and mesh.colours is not None:
        shown = painted(mesh, clustered(mesh.colours, MOST), line=0.0)
    painting = paint is not None and len(paint.palette) > 1  # of one filament nothing is painted, and any printer takes the file
    key = "" if not painting else "slic3rpe:mmu_segmentation" if _strict(slicer) else "paint_color"
    attributes = [""] * len(mesh.faces) if shown is None else _coloured(shown.filament[mesh.faces], key)
    palette = () if shown is None else shown.palette
    thing = _object(1, called, mesh, attributes, 0 if palette else None)
    settings = {} if paint is None or _strict(slicer) else _bambu_settings(called, palette, filament_type, 1, [])
    return _package(_model(called, palette, thing, 1, painting=painting and _strict(slicer)), settings)


def bodies_bytes(
    bodies: Sequence[Body], palette: Palette, name: str = "part", *, slicer: str = "standard", filament_type: str = "PLA"
) -> bytes:
    """A 3MF package of one part made of bodies, each of one filament, which slicers read without painting; else as `threemf_bytes`."""
    check_slicer(slicer)
    called = _attribute(name)
    if _strict(slicer):  # PrusaSlicer takes components apart, and knows bodies as stretches of one object's triangles
        whole = together(bodies, palette)
        thing = _object(1, called, whole.mesh, _coloured(whole.filament[whole.mesh.faces]), bodies[0].filament)
        volumes, first = "", 0
        for body in bodies:
            last = first + len(body.mesh.faces) - 1
            kept = (("name", _attribute(body.name)), ("extruder", body.filament + 1))
            facts = "".join(f'<metadata type="volume" key="{key}" value="{value}"/>' for key, value in kept)
            volumes += f'<volume firstid="{first}" lastid="{last}">{facts}</volume>'
            first = last + 1
        config = f'<?xml version="1.0" encoding="UTF-8"?>\n<config><object id="1" instances_count="1">{volumes}</object></config>'
        return _package(_model(called, palette, thing, 1, painting=False), {"Slic3r_PE_model.config": config})
    last, no_words = len(bodies) + 1, [[""] * len(body.mesh.faces) for body in bodies]
    things = [_object(k, _attribute(body.name), body.mesh, no_words[k - 1], body.filament) for k, body in enumerate(bodies, 1)]
    parts = "".join(f'<component objectid="{number}"/>' for number in range(1, last))
    things.append(f'<object id="{last}" type="model" name="{called}"><components>{parts}</components></object>')
    settings = _bambu_settings(called, palette, filament_type, last, bodies)
    return _package(_model(called, palette, "".join(things), last, painting=False), settings)


def together(bodies: Sequence[Body], palette: Palette) -> Painted:
    """The surfaces of all bodies, one after the other, each in the colour of its filament."""
    counts = [len(body.mesh.vertices) for body in bodies]
    faces = [body.mesh.faces + start for body, start in zip(bodies, np.cumsum([0, *counts[:-1]]), strict=True)]
    mesh = SurfaceMesh(np.concatenate([body.mesh.vertices for body in bodies]), np.concatenate(faces))
    return Painted(mesh, palette, np.repeat([body.filament for body in bodies], counts).astype(np.int32))


def _strict(slicer: str) -> bool:
    """Whether the file for a slicer keeps to the standard."""
    return slicer in ("standard", "prusa")


def _attribute(name: str) -> str:
    """A name that can stand in an attribute."""
    return escape("".join(sign for sign in name if sign.isprintable()) or "part", {'"': "&quot;"})


def _package(model: str, settings: Mapping[str, str]) -> bytes:
    """The archive of a model and of what slicers keep beside it, by name."""
    parts = {"[Content_Types].xml": _TYPES.format(_SETTINGS if settings else ""), "_rels/.rels": _RELATIONS, "3D/3dmodel.model": model}
    parts |= {f"Metadata/{name}": content for name, content in settings.items()}
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as package:
        for part, content in parts.items():
            package.writestr(zipfile.ZipInfo(part, (1980, 1, 1, 0, 0, 0)), content, zipfile.ZIP_DEFLATED)
    return buffer.getvalue()


def _model(name: str, palette: Palette, things: str, built: int, *, painting: bool) -> str:
    """The model part: colours, objects, and which of them is built."""
    colours = "".join(f'<m:color color="{colour}"/>' for colour in palette)
    group = f'<m:colorgroup id="{_GROUP}">{colours}</m:colorgroup>' if palette else ""
    space = ' xmlns:slic3rpe="http://schemas.slic3r.org/3mf/2017/06"' if painting else ""
    version = '<metadata name="slic3rpe:MmPaintingVersion">1</metadata>' if painting else ""
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<model unit="millimeter" xml:lang="en" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02" '
        f'xmlns:m="http://schemas.microsoft.com/3dmanufacturing/material/2015/02"{space}>'
        f'<metadata name="Application">MechStyle</metadata><metadata name="Title">{name}</metadata>{version}'
        f'<resources>{group}{things}</resources><build><item objectid="{built}"/></build></model>'
    )


def _object(number: int, name: str, mesh: SurfaceMesh, attributes: Sequence[str], colour: int | None) -> str:
    """An object of one mesh, with attributes of each triangle and the colour of those that have none."""
    own = "" if colour is None else f' pid="{_GROUP}" pindex="{colour}"'
    # One template for all is filled in three times as fast as one for each.
    vertices = '<vertex x="%.9g" y="%.9g" z="%.9g"/>' * len(mesh.vertices) % tuple(mesh.vertices.ravel().tolist())
    corners = zip(*mesh.faces.T.tolist(), attributes, strict=True)
    triangles = '<triangle v1="%d" v2="%d" v3="%d"%s/>' * len(mesh.faces) % tuple(chain.from_iterable(corners))
    whole = f"<vertices>{vertices}</vertices><triangles>{triangles}</triangles>"
    return f'<object id="{number}" type="model" name="{name}"{own}><mesh>{whole}</mesh></object>'


def _coloured(corners: Indices, key: str = "") -> list[str]:
    """Attributes that give each corner its colour, shape [face_count, 3]; with a key, the word that slicers paint by as well."""
    kinds, which = distinct(corners)
    table = [f' pid="{_GROUP}" p1="{p}" p2="{q}" p3="{r}"' for p, q, r in kinds]
    if key:
        table = [f'{colour} {key}="{word}"' for colour, word in zip(table, paint_codes(kinds), strict=True)]
    return [table[kind] for kind in which.tolist()]


def _bambu_settings(name: str, palette: Palette, filament_type: str, whole: int, bodies: Sequence[Body]) -> dict[str, str]:
    """Settings of OrcaSlicer, of which Bambu Studio reads the objects' only: filaments and, of several bodies, which has which."""
    parts = "".join(
        f'<part id="{number}" subtype="normal_part"><metadata key="name" value="{_attribute(body.name)}"/>'
        f'<metadata key="extruder" value="{body.filament + 1}"/></part>'
        for number, body in enumerate(bodies, 1)
    )
    facts = f'<metadata key="name" value="{name}"/><metadata key="extruder" value="1"/>'
    objects = f'<?xml version="1.0" encoding="UTF-8"?>\n<config><object id="{whole}">{facts}{parts}</object></config>'
    project = {
        "from": "project", "name": "project_settings", "filament_colour": [f"{colour}FF" for colour in palette],
        "filament_type": [filament_type] * len(palette), "filament_settings_id": [f"Generic {filament_type}"] * len(palette),
    }  # fmt: skip
    return {"model_settings.config": objects, "project_settings.config": json.dumps(project, indent=1)}


_LONG = 3
"""States from here on take a second number."""


def paint_codes(filament: Indices) -> list[str]:
    """The word of each triangle by the filament of each corner, from 0, shape [face_count, 3], cut where these do not agree.

    One corner of another colour is cut off at the middles of its sides; where all three differ each gets its own, the middle the first one.
    """
    kinds, which = distinct(filament)
    table = [_paint_code(*(int(corner) + 1 for corner in kind)) for kind in kinds]
    return [table[kind] for kind in which.tolist()]


def distinct(filament: Indices) -> tuple[Indices, Indices]:
    """The triples that occur, shape [kind_count, 3], and places in them, shape [face_count]: as `np.unique`, but counted."""
    base = int(filament.max(initial=0)) + 1
    name = np.ravel_multi_index(tuple(filament.T), (base, base, base))
    occurs = np.bincount(name, minlength=base**3) > 0
    kinds = np.stack(np.unravel_index(np.flatnonzero(occurs), (base, base, base)), axis=1)
    return kinds.astype(np.int32), (np.cumsum(occurs) - 1)[name].astype(np.int32)


def _paint_code(a: int, b: int, c: int) -> str:
    """The word of a triangle with these states at its corners."""
    if a == b == c:
        stream = _whole(a)
    elif a != b != c != a:
        stream = [0b0011, *_whole(min(a, b, c)), *_whole(c), *_whole(b), *_whole(a)]
    else:
        odd = 0 if b == c else 1 if a == c else 2
        cut, rest = (a, b, c)[odd], (a, b, c)[odd - 1]
        stream = [odd << 2 | 0b10, *_whole(rest), *_whole(rest), *_whole(cut)]
    return "".join(f"{number:X}" for number in reversed(stream))


def _whole(state: int) -> list[int]:
    """The numbers of a triangle of one state."""
    return [state << 2] if state < _LONG else [0b1100, state - _LONG]
