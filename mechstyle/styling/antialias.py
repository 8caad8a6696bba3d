"""Outlines that fade over the pixels they pass through, so that a picture changes smoothly as the outline moves.

Two neighbouring pixels that an outline parts are blended by where it crosses the line between their centres (Laine et al. 2020,
"Modular primitives for high-performance differentiable rendering"). The edges are those of the outline itself rather than of the
faces the pixels see: on a fine mesh a pixel rarely sees the very face that ends at the outline.
"""

from __future__ import annotations

import torch
from torch.nn import functional

from mechstyle.raster.rows import taken
from mechstyle.raster.tensors import parting_edges


def antialiased(picture: torch.Tensor, pixels: torch.Tensor, edges: torch.Tensor, buffer: torch.Tensor, *, static: bool) -> torch.Tensor:
    """The picture with faded outlines.

    Args:
        picture: Values per pixel, shape [channels, views · height · width].
        pixels: Column, row and 1 / depth of every vertex, shape [views, n, 3]; gradients reach them.
        edges: Of `raster.tensors.edges_of`, int32.
        buffer: The z-buffer, shape [views, height, width].
        static: Whether to handle all pairs of neighbours, so that no shape depends on the picture.
    """
    views, height, width = buffer.shape
    edge = parting_edges(pixels, edges, buffer)[0].view(-1)
    pair = torch.arange(len(edge), device=edge.device) if static else (edge >= 0).nonzero()[:, 0]
    count = views * height * width
    below, first, parted = pair >= count, pair % count, edge[pair] >= 0
    shown, before = torch.where(parted, edge[pair], pair % len(edges)), first // (height * width) * pixels.shape[1]
    ends = edges[:, :2].T.index_select(1, shown) + before
    crossing = _crossing(pixels.reshape(-1, 3), ends, first % (height * width), width, below)
    # The two pixels meet half way: an edge beyond spreads the colour of the first into the second, one before it the reverse.
    beyond = torch.where(parted, crossing - 0.5, 0.0)
    if static:
        return _spread(picture.view(-1, views, height, width), *beyond.view(2, views, height, width)).view_as(picture)
    second = first + torch.where(below, width, 1)
    step = picture.index_select(1, second) - picture.index_select(1, first)
    return picture.index_add(1, torch.where(beyond > 0, second, first), -step * beyond)


def _spread(picture: torch.Tensor, right: torch.Tensor, below: torch.Tensor) -> torch.Tensor:
    """The picture, shape [channels, views, height, width], with every two neighbours blended, in shifted copies of all of it.

    On a GPU, additions to chosen pixels would have to be sorted first to be repeatable.
    """
    across, down = picture.diff(dim=3), picture.diff(dim=2)
    right, below = right[..., :-1], below[:, :-1]
    picture = picture - functional.pad(across * right.clamp(max=0.0), (0, 1)) - functional.pad(across * right.clamp(min=0.0), (1, 0))
    return picture - functional.pad(down * below.clamp(max=0.0), (0, 0, 0, 1)) - functional.pad(down * below.clamp(min=0.0), (0, 0, 1, 0))


def _crossing(points: torch.Tensor, ends: torch.Tensor, pixel: torch.Tensor, width: int, below: torch.Tensor) -> torch.Tensor:
    """Where edges cross the line from the centre of a pixel (0) to the centre of its neighbour (1), shape [pairs]."""
    (ax, ay, _), (bx, by, _) = (end.unbind(dim=1) for end in taken(points, ends))
    x, y = (pixel % width).to(points) + 0.5, (pixel // width).to(points) + 0.5
    along_a, along_b = torch.where(below, ax - x, ay - y), torch.where(below, bx - x, by - y)
    across_a, across_b = torch.where(below, ay - y, ax - x), torch.where(below, by - y, bx - x)
    length = along_b - along_a
    share = -along_a / torch.where(length == 0, 1.0, length)
    return across_a + share * (across_b - across_a)
