"""Outlines that fade over the pixels they pass through, so that a picture changes smoothly as the outline moves.

Two neighbouring pixels that an outline parts are blended by where it crosses the line between their centres (Laine et al. 2020,
"Modular primitives for high-performance differentiable rendering"). The edges are those of the outline itself rather than of the
faces the pixels see: on a fine mesh a pixel rarely sees the very face that ends at the outline.
"""

from __future__ import annotations

import torch

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
    edge, second_inside = (part.view(-1) for part in parting_edges(pixels, edges, buffer))
    pair = torch.arange(len(edge), device=edge.device) if static else (edge >= 0).nonzero()[:, 0]
    count = views * height * width
    below, first = pair >= count, pair % count
    parted, inside_second = edge[pair] >= 0, second_inside[pair]
    second = first + torch.where(parted, torch.where(below, width, 1), 0)
    shown, before = torch.where(parted, edge[pair], pair % len(edges)), first // (height * width) * pixels.shape[1]
    ends = [edges[:, k].index_select(0, shown) + before for k in range(2)]
    crossing = _crossing(pixels.reshape(-1, 3)[:, :2], ends, first % (height * width), width, below)
    reach = torch.where(inside_second, 1.0 - crossing, crossing)
    inside, outside = torch.where(inside_second, second, first), torch.where(inside_second, first, second)
    step = picture.index_select(1, inside) - picture.index_select(1, outside)
    share = torch.where(parted, reach - 0.5, 0.0)  # of a pixel: what the inside covers of the outside, or the reverse if negative
    return picture.index_add(1, torch.where(share > 0, outside, inside), step * share)


def _crossing(points: torch.Tensor, ends: list[torch.Tensor], pixel: torch.Tensor, width: int, below: torch.Tensor) -> torch.Tensor:
    """Where edges cross the line from the centre of a pixel (0) to the centre of its neighbour (1), shape [pairs]."""
    (ax, ay), (bx, by) = (points.index_select(0, end).unbind(dim=1) for end in ends)
    x, y = (pixel % width).to(points) + 0.5, (pixel // width).to(points) + 0.5
    along_a, along_b = torch.where(below, ax - x, ay - y), torch.where(below, bx - x, by - y)
    across_a, across_b = torch.where(below, ay - y, ax - x), torch.where(below, by - y, bx - x)
    length = along_b - along_a
    share = -along_a / torch.where(length == 0, 1.0, length)
    return across_a + share * (across_b - across_a)
