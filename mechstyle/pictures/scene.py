"""A picture of one part, without a display or OpenGL.

Light on it: corner normals that keep creases, lamps that show relief, and the shadow a part throws on the floor.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import binary_dilation, gaussian_filter, map_coordinates

from mechstyle._colour import linear_to_srgb, srgb_to_linear
from mechstyle.errors import BadInput
from mechstyle.pictures.camera import VIEWS, Camera
from mechstyle.pictures.colormap import ABSENT, LINE, PLAIN, STRIPE, Scale, hatch
from mechstyle.pictures.visibility import Visibility, visible
from mechstyle.records.mesh import SurfaceMesh

__all__ = ["BACKGROUND", "VIEWS", "Camera", "Field", "render"]

BACKGROUND = (0.965, 0.965, 0.96)  # sRGB


@dataclass(frozen=True, eq=False)
class Field:
    """Values over the vertices and how they are coloured."""

    values: NDArray[np.floating]  # the field [any unit], shape [vertex_count]
    scale: Scale  # its colours


def render(
    mesh: SurfaceMesh, *, camera: Camera, width: int = 480, height: int = 480, colours: ArrayLike | None = None, field: Field | None = None,
    supersampling: int = 3, device: str = "cpu",
) -> NDArray[np.uint8]:  # fmt: skip
    """A shaded picture of a surface, row 0 at the top.

    Args:
        mesh: The surface; both sides of its faces are drawn.
        camera: Where from; its aspect should be width / height.
        width: Columns.
        height: Rows.
        colours: Display RGB in [0, 1], shape [vertex_count, 3]; the surface's own colours by default, plain grey if it has none.
        field: A field to show instead of colours, mapped per pixel, with an isoline at its threshold and a hatch above it.
        supersampling: Samples per pixel and direction.
        device: Warp device of the visibility, "cpu" or "cuda:0".

    Returns:
        sRGB, shape [height, width, 3], uint8.

    Raises:
        BadInput: Colours or values that do not fit the surface.
    """
    columns, rows = width * supersampling, height * supersampling
    seen = visible(camera.project(mesh.vertices), mesh.faces, columns, rows, device=device)
    hit = seen.face >= 0
    light = lit(_normals(mesh, seen, hit, camera), camera)[:, None]
    if field is None:
        if colours is None:
            colours = mesh.colours if mesh.colours is not None else np.broadcast_to(PLAIN, mesh.vertices.shape)
        given = np.asarray(colours, dtype=np.float32)
        if given.shape != mesh.vertices.shape:
            raise BadInput(f"colours must have one RGB row for each of the {len(mesh.vertices)} vertices, not shape {given.shape}")
        paint = _across(mesh, seen, hit, srgb_to_linear(np.clip(given, 0.0, 1.0)))
    else:
        paint = _field_paint(mesh, seen, hit, field, supersampling)
        light = FLATNESS + (1 - FLATNESS) * light
    samples = np.zeros((rows, columns, 3), np.float32)
    samples[hit] = paint * light
    part, cover = _averaged(samples, supersampling), _averaged(hit[..., None].astype(np.float32), supersampling)
    depth = seen.depth[supersampling // 2 :: supersampling, supersampling // 2 :: supersampling]
    part *= (1.0 - hollows(depth, mesh.size) * (1.0 if field is None else 1 - FLATNESS))[..., None]
    floor = srgb_to_linear(BACKGROUND) * (1.0 - floor_shadow(mesh, camera, width, height))[..., None]
    return np.rint(linear_to_srgb(part + (1.0 - cover) * floor) * 255.0).astype(np.uint8)


def _across(mesh: SurfaceMesh, seen: Visibility, hit: NDArray[np.bool_], values: NDArray[np.float32]) -> NDArray[np.float32]:
    """Vertex values [vertex_count, k] interpolated at the pixels that hit the surface, shape [hit_count, k]."""
    corners = mesh.faces[seen.face[hit]]
    weights = seen.barycentrics[hit]
    return np.asarray(sum(values[corners[:, k]] * weights[:, k, None] for k in range(3)), dtype=np.float32)


def _normals(mesh: SurfaceMesh, seen: Visibility, hit: NDArray[np.bool_], camera: Camera) -> NDArray[np.float32]:
    """Unit shading normals at the pixels that hit the surface, on the side that is seen, shape [hit_count, 3]."""
    faces, face = np.unique(seen.face[hit], return_inverse=True)
    away = np.einsum("ij,ij->i", mesh.face_normals[faces], mesh.corners[faces, 0] - camera.eye) > 0
    normals = (corner_normals(mesh, faces=faces) * np.where(away, -1.0, 1.0)[:, None, None]).astype(np.float32)
    weights = seen.barycentrics[hit]
    blend = np.asarray(sum(normals[face, k] * weights[:, k, None] for k in range(3)), dtype=np.float32)
    return np.asarray(blend / np.maximum(np.linalg.norm(blend, axis=1, keepdims=True), 1e-6))


def _field_paint(mesh: SurfaceMesh, seen: Visibility, hit: NDArray[np.bool_], field: Field, supersampling: int) -> NDArray[np.float32]:
    """Linear RGB of the field at the pixels that hit the surface, shape [hit_count, 3].

    Hatched and outlined above the threshold; grey, hatched in a darker grey, where the field has no value.
    """
    values = np.asarray(field.values, dtype=np.float32)
    if values.shape != (len(mesh.vertices),):
        raise BadInput(f"a field must have one value for each of the {len(mesh.vertices)} vertices, not shape {values.shape}")
    here = _across(mesh, seen, hit, values[:, None])[:, 0]
    paint = field.scale.colours(here)
    above = np.zeros(hit.shape, bool)
    above[hit] = field.scale.beyond(here)
    paint[(above & hatch(hit.shape[0], hit.shape[1], 9 * supersampling))[hit]] = srgb_to_linear(STRIPE)
    absent = np.zeros(hit.shape, bool)
    absent[hit] = np.isnan(here)
    paint[(absent & hatch(hit.shape[0], hit.shape[1], 7 * supersampling))[hit]] = srgb_to_linear(ABSENT)
    edge = binary_dilation(above, iterations=supersampling) & ~above
    paint[edge[hit]] = srgb_to_linear(LINE)
    return paint


def _averaged(samples: NDArray[np.float32], count: int) -> NDArray[np.float32]:
    """Means over squares of count x count samples."""
    rows, columns, channels = samples.shape
    blocks = samples.reshape(rows // count, count, columns // count, count, channels)
    return np.asarray(blocks.mean(axis=(1, 3)), dtype=np.float32)


Image = NDArray[np.float32]
CELLS = 160  # of the floor on each side of the square that a shadow falls on

# Lamps in camera axes (right, up, towards the viewer) and their intensities; a face turned to the key gets about 1.
KEY, KEY_LIGHT = (-0.55, 0.65, 0.52), 0.72
FILL, FILL_LIGHT = (0.85, 0.05, 0.52), 0.22
SKY_LIGHT, GROUND_LIGHT = 0.26, 0.12
FLATNESS = 0.35  # share of the light on a coloured field that does not depend on the shape, so that colours stay near their legend


def corner_normals(mesh: SurfaceMesh, crease: float = 40.0, faces: NDArray[np.integer] | None = None) -> NDArray[np.float64]:
    """Unit normals per corner of all faces, or of some: a picture shows a third of them; shape [face_count, 3, 3].

    Each is the angle-weighted mean over the faces around the vertex that turn by less than `crease` [degrees] against the corner's own
    face, so that smooth parts shade smoothly and edges stay crisp.
    """
    vertex = mesh.faces.ravel()
    order = np.argsort(vertex, kind="stable")
    degree = np.bincount(vertex, minlength=len(mesh.vertices))
    start = np.cumsum(degree) - degree
    wanted = np.arange(len(vertex)) if faces is None else (3 * faces[:, None] + np.arange(3)).ravel()
    count = degree[vertex[wanted]]
    place = np.repeat(np.arange(len(wanted)), count)
    corner = wanted[place]
    within = np.arange(len(corner)) - np.repeat(np.cumsum(count) - count, count)
    other = order[start[vertex[corner]] + within]
    normals = mesh.face_normals
    smooth = np.einsum("ij,ij->i", normals[corner // 3], normals[other // 3]) > math.cos(math.radians(crease))
    place, other = place[smooth], other[smooth]
    ahead, behind = np.roll(mesh.corners, -1, axis=1) - mesh.corners, np.roll(mesh.corners, 1, axis=1) - mesh.corners
    angles = np.arctan2(np.linalg.norm(np.cross(ahead, behind), axis=2), np.einsum("ijk,ijk->ij", ahead, behind))
    weighted = np.repeat(normals, 3, axis=0) * angles.reshape(-1, 1)
    total = np.stack([np.bincount(place, weighted[other, axis], len(wanted)) for axis in range(3)], axis=1)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    unit = np.divide(total, length, out=normals[wanted // 3], where=length > 1e-12)
    return unit.reshape(-1, 3, 3)


def lit(normals: Image, camera: Camera) -> Image:
    """Light that surfaces with these unit normals send to the camera, about 0.2 to 1, shape [n]."""
    right, up, back = camera.axes
    lamps = np.array([KEY, FILL]) @ np.stack([right, up if camera.elevation >= 0 else -up, back])  # what faces down is lit from below
    lamps /= np.linalg.norm(lamps, axis=1, keepdims=True)
    facing = np.clip(normals @ lamps.T.astype(np.float32), 0.0, None)
    sky = GROUND_LIGHT + (SKY_LIGHT - GROUND_LIGHT) * (0.5 + 0.5 * normals[:, 2])
    return np.asarray(sky + facing @ np.array([KEY_LIGHT, FILL_LIGHT], np.float32), dtype=np.float32)


def hollows(depth: Image, size: float) -> Image:
    """Darkening of places behind their surroundings by depth per pixel [mm], in [0, 1] (unsharp-masked depth; Luft et al. 2006)."""
    seen = np.isfinite(depth)
    dark = np.zeros_like(depth)
    for share, strength in ((0.008, 14.0), (0.035, 5.0)):
        blur = share * max(depth.shape)
        weight = gaussian_filter(seen.astype(np.float32), blur)
        mean = gaussian_filter(np.where(seen, depth, 0.0), blur) / np.maximum(weight, 1e-3)
        dark += np.clip(np.where(seen, depth - mean, 0.0) * (strength / size), 0.0, 0.22)
    return dark


def floor_shadow(mesh: SurfaceMesh, camera: Camera, width: int, height: int) -> Image:
    """Darkness of the part's shadow on the floor it stands on, in [0, 1], shape [height, width]; zero for a camera that is not above it."""
    floor = float(mesh.vertices[:, 2].min())
    drop = camera.eye[2] - floor
    rays = camera.directions(width, height)
    if camera.elevation <= 0 or drop <= 0:
        return np.zeros((height, width), np.float32)
    reach = np.divide(drop, -rays[..., 2], out=np.full((height, width), np.nan), where=rays[..., 2] < -1e-6)
    spots = camera.eye[:2] + reach[..., None] * rays[..., :2]
    middle = 0.5 * (mesh.vertices.min(axis=0) + mesh.vertices.max(axis=0))[:2]
    half = 0.9 * float(mesh.extents[:2].max()) + 0.15 * mesh.size
    # Darkness of the floor in a square around the part, seen from so far below that the view is parallel; row 0 at low y.
    away, cell, plane = 1e3 * mesh.size, 2 * half / CELLS, (mesh.vertices[:, :2] - middle) / half
    seen = visible(np.column_stack([plane[:, 0], -plane[:, 1], mesh.vertices[:, 2] - floor + away]), mesh.faces, CELLS, CELLS)
    cover = np.exp(-np.maximum(seen.depth - away, 0.0) / (0.12 * mesh.size))
    near, wide = (gaussian_filter(cover, share * mesh.size / cell, mode="constant") for share in (0.012, 0.06))
    dark = np.asarray(0.30 * near + 0.32 * wide, dtype=np.float32)
    cells = ((spots - middle) / half + 1.0) * (0.5 * len(dark)) - 0.5
    shadow = map_coordinates(dark, [cells[..., 1], cells[..., 0]], order=1, cval=0.0, prefilter=False)
    # Falling to nothing over the outer tenth of the picture, so that it never ends at its border.
    across, down = (np.clip(5.0 - np.abs(np.linspace(-5.0, 5.0, count)), 0.0, 1.0) for count in (width, height))
    return np.asarray(shadow * np.outer(down, across).astype(np.float32), dtype=np.float32)
