"""A picture of one part, without a display or OpenGL."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import binary_dilation

from mechstyle._colour import linear_to_srgb, srgb_to_linear
from mechstyle.errors import BadInput
from mechstyle.pictures.camera import VIEWS, Camera
from mechstyle.pictures.colormap import ABSENT, LINE, PLAIN, STRIPE, Scale, hatch
from mechstyle.pictures.raster.visibility import Visibility, visible
from mechstyle.pictures.shading import FLATNESS, corner_normals, floor_shadow, hollows, lit
from mechstyle.records.mesh import SurfaceMesh

__all__ = ["BACKGROUND", "VIEWS", "Camera", "Field", "render"]

BACKGROUND = (0.965, 0.965, 0.96)  # sRGB


@dataclass(frozen=True, eq=False)
class Field:
    """Values over the vertices and how they are coloured.

    Attributes:
        values: The field [any unit], shape [vertex_count].
        scale: Its colours.
    """

    values: NDArray[np.floating]
    scale: Scale


def render(
    mesh: SurfaceMesh,
    *,
    camera: Camera,
    width: int = 480,
    height: int = 480,
    colours: ArrayLike | None = None,
    field: Field | None = None,
    supersampling: int = 3,
    device: str = "cpu",
) -> NDArray[np.uint8]:
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
