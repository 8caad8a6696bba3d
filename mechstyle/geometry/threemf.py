"""Writing 3MF with colours: a core 3MF package with one `m:colorgroup` (3MF Materials and Properties Extension 1.2.1).

Slicers map colours to filaments, so a file with thousands of them is useless; they are reduced to a few.
"""

from __future__ import annotations

import io
import warnings
import zipfile
from xml.sax.saxutils import escape

import numpy as np
from numpy.typing import NDArray
from scipy.cluster.vq import kmeans2

from mechstyle.records.mesh import SurfaceMesh

MOST_COLOURS = 48

_TYPES = (
    '<?xml version="1.0" encoding="UTF-8"?>\n'
    '<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">'
    '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
    '<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>'
)
_RELATIONS = (
    '<?xml version="1.0" encoding="UTF-8"?>\n'
    '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
    '<Relationship Target="/3D/3dmodel.model" Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>'
)


def threemf_bytes(mesh: SurfaceMesh, name: str = "part") -> bytes:
    """A 3MF package of the mesh in millimetres, its vertex colours reduced to at most MOST_COLOURS; the same mesh gives the same bytes.

    Args:
        mesh: The part.
        name: What slicers call it.
    """
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as package:
        for part, content in (("[Content_Types].xml", _TYPES), ("_rels/.rels", _RELATIONS), ("3D/3dmodel.model", _model(mesh, name))):
            package.writestr(zipfile.ZipInfo(part, (1980, 1, 1, 0, 0, 0)), content, zipfile.ZIP_DEFLATED)
    return buffer.getvalue()


def _model(mesh: SurfaceMesh, name: str) -> str:
    """The model part."""
    called = escape("".join(sign for sign in name if sign.isprintable()) or "part", {'"': "&quot;"})
    group, corner_colours = _colour_group(mesh)
    attributes = ' pid="2" pindex="0"' if group else ""
    vertices = "".join(f'<vertex x="{x:.9g}" y="{y:.9g}" z="{z:.9g}"/>' for x, y, z in mesh.vertices)
    if corner_colours is None:
        triangles = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in mesh.faces)
    else:
        triangles = "".join(
            f'<triangle v1="{a}" v2="{b}" v3="{c}" pid="2" p1="{p}" p2="{q}" p3="{r}"/>'
            for (a, b, c), (p, q, r) in zip(mesh.faces, corner_colours, strict=True)
        )
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<model unit="millimeter" xml:lang="en" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02" '
        'xmlns:m="http://schemas.microsoft.com/3dmanufacturing/material/2015/02">'
        f'<metadata name="Application">MechStyle</metadata><metadata name="Title">{called}</metadata><resources>{group}'
        f'<object id="1" type="model" name="{called}"{attributes}><mesh>'
        f"<vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh></object></resources>"
        '<build><item objectid="1"/></build></model>'
    )


def _colour_group(mesh: SurfaceMesh) -> tuple[str, NDArray[np.int64] | None]:
    """The colour group and the colour index of every face corner, shape [face_count, 3]; nothing for an uncoloured mesh."""
    if mesh.colours is None:
        return "", None
    palette, index = reduced_colours(mesh.colours)
    colours = "".join('<m:color color="#{:02X}{:02X}{:02X}"/>'.format(*rgb) for rgb in palette)
    return f'<m:colorgroup id="2">{colours}</m:colorgroup>', index[mesh.faces]


def reduced_colours(colours: NDArray[np.float32], most: int = MOST_COLOURS) -> tuple[NDArray[np.uint8], NDArray[np.int64]]:
    """A palette of at most `most` 8-bit colours, shape [k, 3], and the index of each vertex in it, shape [n]; k-means, seeded."""
    exact, index = np.unique(np.round(np.clip(colours, 0, 1) * 255).astype(np.uint8), axis=0, return_inverse=True)
    if len(exact) <= most:
        return exact, index.reshape(-1)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a cluster that ran empty is a colour less, no fault
        centres, label = kmeans2(np.asarray(colours, dtype=np.float64), most, iter=12, minit="++", seed=0, missing="warn")
    rounded = np.round(np.clip(centres, 0, 1) * 255).astype(np.uint8)
    palette, index = np.unique(rounded[label], axis=0, return_inverse=True)
    return palette, index.reshape(-1)
