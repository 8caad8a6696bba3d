"""Light on a surface: corner normals that keep creases, lamps that show relief, and the shadow a part throws on the floor."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, map_coordinates

from mechstyle.pictures.camera import Camera
from mechstyle.pictures.raster.visibility import visible
from mechstyle.records.mesh import SurfaceMesh

Image = NDArray[np.float32]

# Lamps in camera axes (right, up, towards the viewer) and their intensities; a face turned to the key gets about 1.
KEY, KEY_LIGHT = (-0.55, 0.65, 0.52), 0.72
FILL, FILL_LIGHT = (0.85, 0.05, 0.52), 0.22
SKY_LIGHT, GROUND_LIGHT = 0.26, 0.12
FLATNESS = 0.35  # share of the light on a coloured field that does not depend on the shape, so that colours stay near their legend


def corner_normals(mesh: SurfaceMesh, crease: float = 40.0, faces: NDArray[np.integer] | None = None) -> NDArray[np.float64]:
    """Unit normals per face corner, shape [face_count, 3, 3].

    Each is the angle-weighted mean over the faces around the vertex that turn by less than `crease` [degrees] against the corner's own
    face, so that smooth parts shade smoothly and edges stay crisp.

    Args:
        mesh: The surface.
        crease: From which turn on an edge is one [degrees].
        faces: Those whose corners are wanted, shape [k]: a picture shows a third of them. All by default.
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
    weighted = np.repeat(normals, 3, axis=0) * _corner_angles(mesh).reshape(-1, 1)
    total = np.stack([np.bincount(place, weighted[other, axis], len(wanted)) for axis in range(3)], axis=1)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    unit = np.divide(total, length, out=normals[wanted // 3], where=length > 1e-12)
    return unit.reshape(-1, 3, 3)


def _corner_angles(mesh: SurfaceMesh) -> NDArray[np.float64]:
    """Inner angles of the faces [rad], shape [face_count, 3]."""
    ahead = np.roll(mesh.corners, -1, axis=1) - mesh.corners
    behind = np.roll(mesh.corners, 1, axis=1) - mesh.corners
    sine = np.linalg.norm(np.cross(ahead, behind), axis=2)
    return np.asarray(np.arctan2(sine, np.einsum("ijk,ijk->ij", ahead, behind)))


def lit(normals: Image, camera: Camera) -> Image:
    """Light that surfaces with these unit normals send to the camera, about 0.2 to 1, shape [n]."""
    right, up, back = camera.axes
    lamps = np.array([KEY, FILL]) @ np.stack([right, up if camera.elevation >= 0 else -up, back])  # what faces down is lit from below
    lamps /= np.linalg.norm(lamps, axis=1, keepdims=True)
    facing = np.clip(normals @ lamps.T.astype(np.float32), 0.0, None)
    sky = GROUND_LIGHT + (SKY_LIGHT - GROUND_LIGHT) * (0.5 + 0.5 * normals[:, 2])
    return np.asarray(sky + facing @ np.array([KEY_LIGHT, FILL_LIGHT], np.float32), dtype=np.float32)


def hollows(depth: Image, size: float) -> Image:
    """Darkening of places that lie behind their surroundings, in [0, 1] (unsharp-masked depth; Luft et al. 2006).

    Args:
        depth: Depth per pixel [mm], infinite for background, shape [height, width].
        size: Size of the part [mm].
    """
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
    dark = _footprint(mesh, middle, half, floor)
    cells = ((spots - middle) / half + 1.0) * (0.5 * len(dark)) - 0.5
    shadow = map_coordinates(dark, [cells[..., 1], cells[..., 0]], order=1, cval=0.0, prefilter=False)
    # Falling to nothing over the outer tenth of the picture, so that it never ends at its border.
    across, down = (np.clip(5.0 - np.abs(np.linspace(-5.0, 5.0, count)), 0.0, 1.0) for count in (width, height))
    return np.asarray(shadow * np.outer(down, across).astype(np.float32), dtype=np.float32)


def _footprint(mesh: SurfaceMesh, middle: NDArray[np.float64], half: float, floor: float, cells: int = 160) -> Image:
    """Darkness of the floor in a square of half-width `half` [mm] around `middle`, shape [cells, cells], row 0 at low y."""
    away = 1e3 * mesh.size  # seen from so far below that the view is parallel
    plane = (mesh.vertices[:, :2] - middle) / half
    seen = visible(np.column_stack([plane[:, 0], -plane[:, 1], mesh.vertices[:, 2] - floor + away]), mesh.faces, cells, cells)
    height = seen.depth - away
    cover = np.exp(-np.maximum(height, 0.0) / (0.12 * mesh.size))
    cell = 2 * half / cells
    near, wide = (gaussian_filter(cover, share * mesh.size / cell, mode="constant") for share in (0.012, 0.06))
    return np.asarray(0.30 * near + 0.32 * wide, dtype=np.float32)
