"""The face visible in each pixel: a z-buffer in Warp, the same code on a CPU and on a CUDA device.

Vertices are snapped to a sub-pixel grid and edges are decided in whole numbers with the top-left rule (Pineda 1988), so that faces
sharing an edge neither leave a gap nor cover a pixel twice, and every device gives the same picture.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mechstyle._warp import without_native_stderr, wp
from mechstyle.errors import BadInput, MissingPiece
from mechstyle.pictures import kernels

SUBPIXELS = 1024  # grid steps per pixel
GUARD = 1 << 16  # pixels beyond which a face is dropped: products of two coordinates must fit an int64


@dataclass(frozen=True, eq=False)
class Visibility:
    """The visible face of each pixel, row 0 at the top."""

    face: NDArray[np.int32]  # index of the nearest face, -1 for none, shape [..., height, width], int32
    barycentrics: NDArray[np.float32]  # perspective-correct weights of its corners, zero for none, shape [..., height, width, 3], float32
    depth: NDArray[np.float32]  # depth there, infinite for none, shape [..., height, width], float32, in the unit of the input


def visible(points_ndc: ArrayLike, faces: ArrayLike, width: int, height: int, *, cull: bool = False, device: str = "cpu") -> Visibility:
    """The nearest face at every pixel centre.

    Args:
        points_ndc: x and y in [-1, 1] across the picture, y up, and the positive depth along the viewing axis, shape [..., n, 3];
            leading axes are views of the same faces.
        faces: Vertex indices, anticlockwise seen from outside, shape [face_count, 3].
        width: Columns of the picture.
        height: Rows of the picture.
        cull: Whether to skip faces seen from behind.
        device: Warp device, "cpu" or "cuda:0".

    Returns:
        Face, barycentric weights and depth per pixel. Faces with a corner behind the viewer are left out.

    Raises:
        BadInput: A size or array that cannot be drawn.
        MissingPiece: A device that is not there.
    """
    points = np.asarray(points_ndc, dtype=np.float64)
    triangles = np.ascontiguousarray(faces, dtype=np.int32)
    _check(points, triangles, width, height)
    views = points.shape[:-2]
    shape = (*views, height, width)
    ahead = np.isfinite(points).all(axis=-1) & (points[..., 2] > 0.0)
    inverse = np.divide(1.0, points[..., 2], out=np.zeros(points.shape[:-1]), where=ahead)
    near = 1.0 / max(float(inverse.max(initial=0.0)), np.finfo(np.float64).tiny)
    snapped, kept = _snapped(points, width, height)
    size = wp.vec3i(points.shape[-2], height, width)
    scale = wp.vec2d(float(SUBPIXELS), float(cull))
    with wp.ScopedDevice(_device(device)):
        nearest = wp.full(math.prod(shape), 2**63 - 1, dtype=wp.int64)
        seen, weights, depth = (wp.zeros(math.prod(shape), dtype=kind) for kind in (wp.int32, wp.vec3, wp.float32))
        corners: Any = wp.array(snapped, dtype=wp.int64)
        nearness: Any = wp.array((np.where(kept, inverse, 0.0) * near).ravel(), dtype=wp.float64)
        inputs: list[Any] = [corners, nearness, wp.array(triangles, dtype=wp.int32, ndim=2), size, scale, nearest]
        wp.launch(kernels.draw, dim=math.prod(views) * len(triangles), inputs=inputs)
        wp.launch(kernels.resolve, dim=math.prod(shape), inputs=[*inputs, seen, weights, depth])
        return Visibility(
            face=seen.numpy().reshape(shape), barycentrics=weights.numpy().reshape(*shape, 3),
            depth=(depth.numpy() * np.float32(near)).reshape(shape),
        )  # fmt: skip


def _device(name: str) -> Any:
    try:
        with without_native_stderr():
            return wp.get_device(name)
    except (ValueError, RuntimeError) as error:
        raise MissingPiece(f"pictures cannot be drawn on {name!r}, which is not there: use 'cpu'") from error


def _check(points: NDArray[np.float64], faces: NDArray[np.int32], width: int, height: int) -> None:
    if not (1 <= width <= GUARD // 4 and 1 <= height <= GUARD // 4):
        raise BadInput(f"a picture of {width} x {height} pixels cannot be drawn; choose 1 to {GUARD // 4} each way")
    if points.ndim < 2 or points.shape[-1] != 3 or faces.ndim != 2 or faces.shape[-1] != 3:
        raise BadInput(f"points must have shape (..., n, 3) and faces (m, 3), not {points.shape} and {faces.shape}")
    if faces.size and not 0 <= faces.min() <= faces.max() < points.shape[-2]:
        raise BadInput(f"faces must index the {points.shape[-2]} points")


def _snapped(points: NDArray[np.float64], width: int, height: int) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Sub-pixel positions (x right, y down), shape [views * n, 2], and which points lie within the guard band, shape [..., n]."""
    pixels = np.stack([(points[..., 0] + 1.0) * (0.5 * width), (1.0 - points[..., 1]) * (0.5 * height)], axis=-1)
    kept: NDArray[np.bool_] = np.all(np.abs(pixels) < GUARD, axis=-1)
    steps = np.rint(np.where(kept[..., None], pixels, 0.0) * SUBPIXELS)
    return steps.astype(np.int64).reshape(-1, 2), kept
