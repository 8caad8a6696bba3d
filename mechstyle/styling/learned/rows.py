"""Rows of a tensor taken, blended and added up by index, with sums that are the same bytes in whatever order a GPU adds.

There the addends are rounded to multiples of 2^-b of the largest of them, with b such that as many of them as there are fit an int64:
whole numbers have the same sum in every order, so that additions need not be sorted first. On a CPU the order is fixed anyway.
"""

from __future__ import annotations

from typing import Any

import torch
from torch.nn import functional

from mechstyle._warp import wp
from mechstyle.pictures import kernels

_BITS = 62
_LEAST = 1e-30  # of a largest addend, so that none is divided by zero


def taken(values: torch.Tensor, index: torch.Tensor) -> torch.Tensor:
    """Rows of values, shape [n, k], at an index of any shape: shape [*index, k]."""
    named = index.reshape(-1)
    # On a CPU torch's `embedding` says the same as `index_select`, but adds its gradient row by row, which takes three times as long.
    rows: torch.Tensor = _Taken.apply(values, named) if _unordered(values) else values.index_select(0, named)
    return rows.view(*index.shape, values.shape[1])


def blended(values: torch.Tensor, index: torch.Tensor, weights: torch.Tensor) -> torch.Tensor:
    """Weighted sums of rows of values, shape [n, k]: shape [m, k].

    Args:
        values: Gradients reach these alone.
        index: The rows of each sum, shape [m, r].
        weights: Their weights from 0 to 1, of the type of the values, shape [m, r].
    """
    if not _unordered(values):
        return functional.embedding_bag(index, values, per_sample_weights=weights, mode="sum")
    sums: torch.Tensor = _Blended.apply(values, index, weights)
    return sums


def placed(rows: torch.Tensor, place: torch.Tensor, row: torch.Tensor) -> torch.Tensor:
    """Rows, shape [m, k], each at a place of its own among n, with zeros elsewhere: shape [n, k].

    Two indices say the same both ways, so that gradients are looked up as values are; from one alone torch would add them up.

    Args:
        rows: Gradients reach these alone.
        place: Of every row, shape [m]; what stands there for a row that is at no place is of no account.
        row: At every place, -1 for none, shape [n].
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
