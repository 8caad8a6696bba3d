"""The rasteriser on torch tensors, on their device and without copies: which face a pixel sees, and which edge parts two pixels.

What it decides has no gradient: a renderer follows the faces and edges named here back to the positions. Both kernels are custom
operators, so that CUDA graphs and torch.compile can hold them.

Rows of a tensor are taken, blended and added up by index with sums that are the same bytes in whatever order a GPU adds. There the addends
are rounded to multiples of 2^-b of the largest of them, with b such that as many of them as there are fit an int64: whole numbers have the
same sum in every order, so that additions need not be sorted first. On a CPU the order is fixed anyway.
"""

from __future__ import annotations

from typing import Any

import torch
from torch.nn import functional

from mechstyle._warp import wp
from mechstyle.pictures import kernels

STEPS = 1 << 15
"""Grid steps per pixel: as fine as float32 coordinates in a picture of a few hundred pixels."""
GUARD = 1 << 13
"""Pixels beyond which a face is dropped: products of two coordinates must fit an int64."""
NOTHING = 2**63 - 1
_INDEX = 2**31 - 1


def nearest_faces(pixels: torch.Tensor, faces: torch.Tensor, height: int, width: int, *, cull: bool = True) -> torch.Tensor:
    """The z-buffer of several views of one surface, shape [views, height, width], int64; `face_of` reads it.

    The pixels are column and row, from the upper left corner, and 1 / depth of every point, shape [views, n, 3]; faces are int32,
    contiguous. With `cull`, faces that turn their back are skipped. Depth and face are packed into one number, smaller is nearer.
    """
    points, nearness = _snapped(pixels)
    buffer: torch.Tensor = _draw_op(points, [len(pixels), height, width], nearness, faces, cull)
    return buffer


def face_of(buffer: torch.Tensor) -> torch.Tensor:
    """The nearest face at every pixel, -1 for none, in the shape of the z-buffer, int64."""
    return torch.where(buffer == NOTHING, -1, buffer & _INDEX)


def parting_edges(pixels: torch.Tensor, edges: torch.Tensor, buffer: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
    """The outline's edges that pass between the centres of two neighbouring pixels, steep ones on rows and flat ones on columns.

    Gives the edge between each pixel and its neighbour to the right ([0]) and below ([1]), -1 for none, and whether that neighbour is the
    one inside the outline, both shape [2, views, height, width]. The edges are `edges_of` the faces, the buffer is that of the same points.
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


def _draw(points: torch.Tensor, shape: list[int], nearness: torch.Tensor, faces: torch.Tensor, cull: bool) -> torch.Tensor:
    views, height, width = shape
    buffer = torch.full(shape, NOTHING, dtype=torch.int64, device=points.device)
    size = wp.vec3i(len(points) // views, height, width)
    inputs = [*map(wp.from_torch, (points, nearness, faces)), size, wp.vec2d(float(STEPS), float(cull)), _flat(buffer)]
    _launch(kernels.draw, views * len(faces), inputs, points)
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


_BITS = 62
_LEAST = 1e-30  # of a largest addend, so that none is divided by zero


def taken(values: torch.Tensor, index: torch.Tensor) -> torch.Tensor:
    """Rows of values, shape [n, k], at an index of any shape: shape [*index, k]."""
    named = index.reshape(-1)
    # On a CPU torch's `embedding` says the same as `index_select`, but adds its gradient row by row, which takes three times as long.
    rows: torch.Tensor = _Taken.apply(values, named) if _unordered(values) else values.index_select(0, named)
    return rows.view(*index.shape, values.shape[1])


def blended(values: torch.Tensor, index: torch.Tensor, weights: torch.Tensor) -> torch.Tensor:
    """Sums of rows of values, shape [n, k], named by an index, times weights from 0 to 1, both shape [m, r]: shape [m, k]."""
    if not _unordered(values):
        return functional.embedding_bag(index, values, per_sample_weights=weights, mode="sum")
    sums: torch.Tensor = _Blended.apply(values, index, weights)
    return sums


def placed(rows: torch.Tensor, place: torch.Tensor, row: torch.Tensor) -> torch.Tensor:
    """Rows, shape [m, k], each at a place of its own among n, with zeros elsewhere: shape [n, k]; gradients reach the rows alone.

    Two indices, the place of every row and the row at every place (-1 for none), say the same both ways, so that gradients are looked up as
    values are; from one alone torch would add them up.
    """
    found: torch.Tensor = _Placed.apply(rows, place, row)
    return found


def added(rows: torch.Tensor, index: torch.Tensor, count: int) -> torch.Tensor:
    """Sums of the rows, shape [m, k], that share an index, shape [m], from 0 to count - 1: shape [count, k]."""
    if not _unordered(rows):
        return rows.new_zeros(count, rows.shape[1]).index_add(0, index, rows)
    sums: torch.Tensor = _Added.apply(rows, index, count)
    return sums


def whole_sums(rows: torch.Tensor, index: torch.Tensor, weights: torch.Tensor, count: int) -> torch.Tensor:
    """Every row of float32, shape [m, k], times its weights, added to the rows its index names, shape [m, r], in whole numbers."""
    largest = torch.linalg.vector_norm(rows, torch.inf).double().clamp(min=_LEAST)
    steps = 2.0 ** (_BITS - index.numel().bit_length()) / largest
    sums = torch.zeros(count, rows.shape[1], dtype=torch.int64, device=rows.device)
    stream = wp.stream_from_torch(torch.cuda.current_stream(rows.device)) if rows.is_cuda else None
    inputs = [wp.from_torch(part.detach().contiguous()) for part in (rows, index, weights, steps.view(1), sums)]
    wp.launch(kernels.add_rows, dim=rows.shape, inputs=inputs, device=wp.device_from_torch(rows.device), stream=stream)
    return (sums.double() / steps).to(rows.dtype)


def _unordered(values: torch.Tensor) -> bool:
    return values.is_cuda and values.dtype == torch.float32


def _alone(rows: torch.Tensor, index: torch.Tensor, count: int) -> torch.Tensor:
    return whole_sums(rows, index[:, None], rows.new_ones(len(rows), 1), count)


class _Taken(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, values: torch.Tensor, index: torch.Tensor) -> torch.Tensor:
        ctx.save_for_backward(index)
        ctx.count = len(values)
        return values.index_select(0, index)

    @staticmethod
    def backward(ctx: Any, slopes: torch.Tensor) -> tuple[torch.Tensor, None]:
        (index,) = ctx.saved_tensors
        return _alone(slopes, index, ctx.count), None


class _Blended(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, values: torch.Tensor, index: torch.Tensor, weights: torch.Tensor) -> torch.Tensor:
        ctx.save_for_backward(index, weights)
        ctx.count = len(values)
        return functional.embedding_bag(index, values, per_sample_weights=weights, mode="sum")

    @staticmethod
    def backward(ctx: Any, slopes: torch.Tensor) -> tuple[torch.Tensor, None, None]:
        index, weights = ctx.saved_tensors
        return whole_sums(slopes, index, weights, ctx.count), None, None


class _Placed(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, rows: torch.Tensor, place: torch.Tensor, row: torch.Tensor) -> torch.Tensor:
        ctx.save_for_backward(place, row)
        return torch.where((row < 0)[:, None], 0.0, rows.index_select(0, row.clamp(min=0)))

    @staticmethod
    def backward(ctx: Any, slopes: torch.Tensor) -> tuple[torch.Tensor, None, None]:
        place, row = ctx.saved_tensors
        used = row.index_select(0, place) == torch.arange(len(place), device=place.device)
        return torch.where(used[:, None], slopes.index_select(0, place), 0.0), None, None


class _Added(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, rows: torch.Tensor, index: torch.Tensor, count: int) -> torch.Tensor:
        ctx.save_for_backward(index)
        return _alone(rows, index, count)

    @staticmethod
    def backward(ctx: Any, slopes: torch.Tensor) -> tuple[torch.Tensor, None, None]:
        (index,) = ctx.saved_tensors
        return slopes.index_select(0, index), None, None
