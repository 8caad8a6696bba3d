"""The rasteriser on torch tensors, on their device and without copies: which face a pixel sees, and which edge parts two pixels.

What it decides has no gradient: a renderer follows the faces and edges named here back to the positions. Both kernels are custom
operators, so that CUDA graphs and torch.compile can hold them.
"""

from __future__ import annotations

from typing import Any

import torch

from mechstyle._warp import wp
from mechstyle.pictures import kernels

STEPS = 1 << 15
"""Grid steps per pixel: as fine as float32 coordinates in a picture of a few hundred pixels."""
GUARD = 1 << 13
"""Pixels beyond which a face is dropped: products of two coordinates must fit an int64."""
NOTHING = 2**63 - 1
_INDEX = 2**31 - 1


def nearest_faces(
    pixels: torch.Tensor, faces: torch.Tensor, height: int, width: int, *, cull: bool = True, hidden: torch.Tensor | None = None
) -> torch.Tensor:
    """The z-buffer of several views of one surface; `face_of` reads it.

    Args:
        pixels: Column and row, counted from the upper left corner, and 1 / depth of every point, shape [views, n, 3], float.
        faces: Shape [face_count, 3], int32, contiguous.
        height: Rows.
        width: Columns.
        cull: Whether to skip faces that turn their back.
        hidden: Faces to skip in each view, shape [views, face_count], bool.

    Returns:
        Depth and face packed into one number, smaller is nearer, shape [views, height, width], int64.
    """
    points, nearness = _snapped(pixels)
    skipped = faces.new_empty(0, dtype=torch.bool) if hidden is None else hidden.reshape(-1)
    buffer: torch.Tensor = _draw_op(points, [len(pixels), height, width], nearness, faces, skipped, cull)
    return buffer


def face_of(buffer: torch.Tensor) -> torch.Tensor:
    """The nearest face at every pixel, -1 for none, in the shape of the z-buffer, int64."""
    return torch.where(buffer == NOTHING, -1, buffer & _INDEX)


def parting_edges(pixels: torch.Tensor, edges: torch.Tensor, buffer: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
    """The outline's edges that pass between the centres of two neighbouring pixels, steep ones on rows and flat ones on columns.

    Args:
        pixels: As for `nearest_faces`.
        edges: `edges_of` the faces, int32, contiguous.
        buffer: The z-buffer of the same points.

    Returns:
        Edge between each pixel and its neighbour to the right ([0]) and below ([1]), -1 for none, and whether that neighbour is the one
        inside the outline, both shape [2, views, height, width], int64 and bool.
    """
    points, nearness = _snapped(pixels)
    parting = _part_op(buffer, points, nearness, edges)
    counts = (parting != NOTHING) & (parting & 2 != 0)
    return torch.where(counts, (parting >> 2) & _INDEX, -1), (parting & 1) == 1


def edges_of(faces: torch.Tensor) -> torch.Tensor:
    """Every edge once: its two ends and the third corners of its faces, -1 for a missing second face, shape [edge_count, 4], int32.

    Where more than two faces meet at an edge, the first and the last of them count.
    """
    ends = faces.long()[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).sort(dim=1).values
    third = faces.long()[:, [2, 0, 1]].reshape(-1)
    unique, which = torch.unique(ends, dim=0, return_inverse=True)
    order = which.argsort(stable=True)
    count = torch.bincount(which, minlength=len(unique))
    last = count.cumsum(dim=0) - 1
    first = last - count + 1
    second = torch.where(count > 1, third[order[last]], -1)
    return torch.column_stack([unique, third[order[first]], second]).to(torch.int32).contiguous()


def _snapped(pixels: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
    """Grid positions, shape [views · n, 2], int64, and nearness from 0 for points not to be drawn to 1, shape [views · n], float64."""
    place, inverse = pixels.detach()[..., :2], pixels.detach()[..., 2].double()
    usable = (place.abs() < GUARD).all(dim=-1) & (inverse > 0.0) & inverse.isfinite()
    steps = torch.where(usable[..., None], place * STEPS, 0.0).round().long()
    kept = torch.where(usable, inverse, 0.0)
    return steps.view(-1, 2), (kept / kept.max().clamp(min=1e-300)).view(-1)


def _draw(
    points: torch.Tensor, shape: list[int], nearness: torch.Tensor, faces: torch.Tensor, hidden: torch.Tensor, cull: bool
) -> torch.Tensor:
    views, height, width = shape
    buffer = torch.full(shape, NOTHING, dtype=torch.int64, device=points.device)
    size = wp.vec3i(len(points) // views, height, width)
    inputs = [*map(wp.from_torch, (points, nearness, faces)), size, wp.vec2d(float(STEPS), float(cull)), _flat(buffer)]
    _launch(kernels.draw, views * len(faces), [*inputs, wp.from_torch(hidden)], points)
    return buffer


def _part(buffer: torch.Tensor, points: torch.Tensor, nearness: torch.Tensor, edges: torch.Tensor) -> torch.Tensor:
    views, height, width = buffer.shape
    parting = torch.full((2, *buffer.shape), NOTHING, dtype=torch.int64, device=points.device)
    size = wp.vec3i(len(points) // views, height, width)
    inputs = [*map(wp.from_torch, (points, nearness, edges)), size, wp.int64(STEPS), _flat(buffer), wp.from_torch(parting.view(2, -1))]
    _launch(kernels.part, views * len(edges), inputs, points)
    return parting


def _flat(buffer: torch.Tensor) -> Any:
    return wp.from_torch(buffer.view(-1))


def _launch(kernel: Any, threads: int, inputs: list[Any], beside: torch.Tensor) -> None:
    """Queue a kernel where torch queues its own work."""
    stream = wp.stream_from_torch(torch.cuda.current_stream(beside.device)) if beside.is_cuda else None
    wp.launch(kernel, dim=threads, inputs=inputs, device=wp.device_from_torch(beside.device), stream=stream)


_draw_op = torch.library.custom_op("mechstyle::nearest_faces", _draw, mutates_args=())
_part_op = torch.library.custom_op("mechstyle::parting_edges", _part, mutates_args=())
_draw_op.register_fake(lambda points, shape, *_: points.new_empty(shape))
_part_op.register_fake(lambda buffer, *_: buffer.new_empty((2, *buffer.shape)))
