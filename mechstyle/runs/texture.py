"""The colours of a surface that leaves a run, finer than its vertices: as fine as the style, or the picture, can be drawn.

What the run made of the colours stays: a texture shows those of the vertices, and between them by how much the drawing is another one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from mechstyle.geometry.subdivision import Subdivided, subdivided
from mechstyle.geometry.texture import Atlas, Texture
from mechstyle.loop.engine import STYLE_FIELDS
from mechstyle.loop.store import Entry, Store
from mechstyle.records.mesh import Floats, SurfaceMesh
from mechstyle.runs.stylizers import drawing_of
from mechstyle.simulation.part import Workpiece, bounds_for
from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.fine_canvas import FineCanvas
from mechstyle.styling.drawn import approached, tinted
from mechstyle.styling.library import style_named
from mechstyle.styling.picture import seen_at
from mechstyle.styling.prompt import Wish, reading_of

FINER = 2
"""Parts of an edge at whose ends a drawn style is drawn anew …"""
MOST_DRAWN = 1_000_000
"""… if that takes no more vertices; else it is interpolated."""


class Delivered(NamedTuple):
    """A surface that leaves a run.

    Attributes:
        cut: The unstylized part in its faces; None for those of the run.
        styled: The styled, coloured surface.
    """

    cut: Subdivided | None
    styled: SurfaceMesh


def texture_of(store: Store, part: Workpiece, entry: Entry, delivered: Delivered) -> Texture:
    """The texture of a surface of a run.

    Args:
        store: The run.
        part: Its part.
        entry: The checkpoint the surface is of.
        delivered: The surface.
    """
    recipe, mesh = store.recipe(entry.recipe), delivered.styled
    assert mesh.colours is not None, "what leaves a run is coloured"
    if recipe.stylizer or recipe.guidance == "clip" or recipe.field == "network" or entry.iteration == 0:
        atlas = Atlas(len(mesh.faces), FINER)
        return atlas.painted(_between(atlas, mesh, mesh.colours))
    reading, bounds = reading_of(recipe), bounds_for(part, recipe)[0]
    coarse = drawing_of(part, bounds, recipe, reading, store.objects)
    count = len(part.surface.vertices)
    cut = delivered.cut or Subdivided(part.surface, sp.csr_array(sp.eye_array(count)))
    free = (1.0 - np.broadcast_to(bounds.uncoloured, (count, 1))) * (1.0 - np.broadcast_to(bounds.plain, count).astype(np.float64))[:, None]
    gain = approached(_iterations_of_the_style(store, entry)) * (cut.interpolation @ (free * coarse.shares.T))
    canvases = [FineCanvas(cut.mesh, cut.interpolation, canvas) for canvas in coarse.canvases]
    atlas = Atlas(len(mesh.faces)) if any(canvas.picture for canvas in canvases) else Atlas(len(mesh.faces), FINER)
    colours = _between(atlas, mesh, mesh.colours)
    for wish, canvas, share in zip(reading.wishes, canvases, gain.T, strict=True):
        finer = _drawn_finer(atlas, wish, canvas)
        if finer is not None:
            known = tinted(style_named(wish.style).program(canvas), wish)
            colours += _between(atlas, cut.mesh, share[:, None]) * (finer - _between(atlas, cut.mesh, known))
    return atlas.painted(colours)


def _between(atlas: Atlas, mesh: SurfaceMesh, values: NDArray[np.floating]) -> Floats:
    """Values at the vertices of a mesh, shape [n, k], at the texels, shape [texel_count, k]."""
    texels = atlas.texels
    corners = mesh.faces[texels.face]
    return np.asarray(sum(texels.weights[:, [k]] * values[corners[:, k]] for k in range(3)))


def _drawn_finer(atlas: Atlas, wish: Wish, canvas: Canvas) -> Floats | None:
    """Colours of a wish at the texels, shape [texel_count, 3]; None where they are known at the vertices only."""
    mesh = canvas.mesh
    if canvas.picture is not None:
        normals = _between(atlas, mesh, mesh.vertex_normals)
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
        return tinted(seen_at(canvas, _between(atlas, mesh, mesh.vertices), normals, canvas.edge / atlas.parts), wish)
    if not wish.style or atlas.parts != FINER or len(mesh.vertices) * FINER**2 > MOST_DRAWN:
        return None
    finer = subdivided(mesh, FINER)
    colours = tinted(style_named(wish.style).program(FineCanvas(finer.mesh, finer.interpolation, canvas)), wish)
    nearest: Floats = cKDTree(finer.mesh.vertices).query(_between(atlas, mesh, mesh.vertices))[1]
    return colours[nearest]


def _iterations_of_the_style(store: Store, entry: Entry) -> int:
    """Iterations since the style of a checkpoint was begun, maybe from the surface that another had left."""
    style = _style(store, entry)
    first = entry
    while first.parent and _style(store, store.entry(first.parent)) == style:
        first = store.entry(first.parent)
    return entry.iteration - (store.entry(first.parent).iteration if first.parent else 0)


def _style(store: Store, entry: Entry) -> tuple[object, ...]:
    recipe = store.recipe(entry.recipe)
    return tuple(getattr(recipe, name) for name in STYLE_FIELDS)
