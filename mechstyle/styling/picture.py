"""A picture of the user's as a style: light stands out, dark is cut in, what is transparent stays as it is."""

from __future__ import annotations

import numpy as np

from mechstyle.errors import BadInput
from mechstyle.records import Recipe
from mechstyle.records.mesh import Floats, SurfaceMesh
from mechstyle.records.regions import End, Region
from mechstyle.styling.drawing.canvas import Canvas, scale_by_area
from mechstyle.styling.drawing.colours import NEUTRAL, mix
from mechstyle.styling.drawing.projection import PlacedPicture, Projection, around_projection, box_projection, planar_projection
from mechstyle.styling.drawing.raster import Raster
from mechstyle.styling.style import Relief, Style

NAME = "picture"
USUAL = 30.0
"""Width of a repeated picture on a part of 100 mm, by default [mm]."""
LARGEST_SHARE = 0.5
"""Of the part's longest side that a picture may be made wide unasked, so that its details can be printed."""
STEP = 0.3
"""Share of its depth by which the darkest of a picture with an outline stands above what is transparent around it, so that it is seen."""
_SEAM = 0.05  # jump of heights or colours from one tile to the next that is seen
_CARRIED = 2.0  # edges of the mesh that a detail must span


def picture(canvas: Canvas) -> Relief:
    """The picture as it lies on the part; around it the part is plain."""
    placed = canvas.picture
    assert placed is not None, "whoever asks for this style gives the picture"
    seen = placed.seen(canvas.points, canvas.mesh.vertex_normals, canvas.edge)
    tint, raster = _coloured(canvas, seen.colour, seen.cover), placed.raster
    if not placed.raised or not (raster.shaded or raster.clear):
        return Relief(np.zeros(len(seen.cover)), tint)
    if not raster.clear:
        return Relief(seen.height, tint, seen.cover)
    # The surface has no relief where the picture is transparent: heights in [-1, 1] become its distance from there, as shares of the depth.
    step = STEP if raster.shaded else 1.0
    if placed.side == "both":
        share = 0.5 * seen.height
    elif placed.side == "inwards":
        share = -step - (1.0 - step) * 0.5 * (1.0 - seen.height)
    else:
        share = step + (1.0 - step) * 0.5 * (1.0 + seen.height)
    return Relief(seen.cover * share, tint, stands=True)


def _coloured(canvas: Canvas, colours: Floats, cover: Floats) -> Floats:
    """The colours of a picture, or of a part that takes only its relief, and of what is plain around it, shape [n, 3]."""
    placed = canvas.picture
    body = np.full(3, NEUTRAL) if canvas.colour is None else np.array(canvas.colour)
    if placed is None or not placed.coloured:
        return np.tile(body, (len(cover), 1))
    return mix(np.tile(body, (len(cover), 1)), canvas.painted(colours), cover)


STYLE = Style(name=NAME, description="a picture of yours, as relief, as colours or as both", feature_mm=1.0, program=picture)
"""It belongs to no library: it draws nothing without a picture. Its feature is the usual width of light and dark in it."""


def placed_on(
    mesh: SurfaceMesh, raster: Raster, recipe: Recipe, width: float | None, size: float, where: tuple[Region, ...] = ()
) -> PlacedPicture:
    """A picture as a recipe asks for it on a part, of a width [mm] as prompt or recipe give it, times a size if neither does.

    One that is thrown from one side comes from the end that is among the places it is for.
    """
    repeated = recipe.style.image_layout == "tiled"
    printable = min(recipe.delivery.nozzle / raster.finest, LARGEST_SHARE * float(mesh.extents.max()))
    usual = max(USUAL * scale_by_area(mesh) * size, printable)
    ends = [region.end for region in where if isinstance(region, End)]
    projection: Projection
    if recipe.style.projection == "planar":
        projection = planar_projection(mesh, width, usual, raster.aspect, repeated=repeated, end=ends[0] if ends else "")
    else:
        lay = around_projection if recipe.style.projection == "around" else box_projection
        projection = lay(mesh, width, usual, raster.aspect, repeated=repeated)
    if projection.width > 10.0 * float(mesh.extents.max()):
        raise BadInput(f"a picture {projection.width:g} mm wide is more than ten times the part: ask for a smaller image size")
    style = recipe.style
    return PlacedPicture(raster, projection, repeated, style.image_as != "colour", style.side, style.image_as != "height")


def notes_on(placed: PlacedPicture, edge: float, nozzle: float) -> tuple[str, ...]:
    """What the user should know of a picture on a mesh with edges of a length [mm], printed with a nozzle [mm]."""
    raster, width = placed.raster, placed.projection.width
    notes = [f"the picture is {width:.3g} mm wide and {width * raster.aspect:.3g} mm high", *placed.projection.notes]
    if placed.repeated and raster.seam > _SEAM:
        notes.append("opposite edges of the picture do not meet, so its tiles show seams: give one that can be tiled, or have it placed")
    if not placed.raised:
        return tuple(notes)
    if not (raster.shaded or raster.clear):
        return (*notes, "the picture is of one shade and opaque: there is no relief in it")
    if raster.finest * width < nozzle:
        needed = nozzle / raster.finest
        fine = f"details of the picture of {raster.finest * width:.2g} mm are finer than a nozzle of {nozzle:g} mm prints"
        notes.append(f"{fine}: they come out from a width of {needed:.3g} mm on")
    if raster.detail * width < _CARRIED * edge:
        coarse = f"the mesh (edge {edge:.2g} mm) is too coarse for details of the picture of {raster.detail * width:.2g} mm"
        notes.append(f"{coarse}: they are blurred; ask for more vertices or a larger picture")
    return tuple(notes)
