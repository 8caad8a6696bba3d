"""Outlines that fade over the pixels they pass through, so that a picture changes smoothly as the outline moves.

Two neighbouring pixels that an outline parts are blended by where it crosses the line between their centres (Laine et al. 2020,
"Modular primitives for high-performance differentiable rendering"), with two departures:

* The edges are those of the outline itself rather than of the faces the pixels see: on a fine mesh a pixel rarely sees the very face that
  ends at the outline.
* Where the near surface reaches into the pixel outside, it does so with its look at the outline, not at the centre of the pixel inside.
  A round surface turns away so fast there that its light differs much between the two. The picture would jump by half that difference
  whenever the outline passes a centre, which no gradient knows of: on a torus that was some 4 % of what a shift does to the picture and
  20 % of what growing does.
"""

from __future__ import annotations

from collections.abc import Callable

import torch

from mechstyle.styling.learned.tensors import parting_edges, placed, taken

MOST_PARTED = 8
"""One in so many pairs of neighbours may be parted where shapes may not depend on the picture; of a lampshade at 224² one in 87 is."""

Look = Callable[[torch.Tensor, torch.Tensor, torch.Tensor], torch.Tensor]
"""Values, shape [k, channels], of points between vertices, from the vertices' 1 / depth and what stands beside it in the surface, shape
[r, k, columns], from their weights in the picture, shape [r, k], and from the views, shape [k]."""


def antialiased(
    picture: torch.Tensor, surface: torch.Tensor, edges: torch.Tensor, buffer: torch.Tensor, look: Look, *, static: bool
) -> torch.Tensor:
    """The picture, shape [channels, views · height · width], with faded outlines.

    Args:
        picture: Values per pixel.
        surface: Column, row, 1 / depth and whatever `look` needs of every vertex, shape [views, n, 3 or more]; gradients reach them.
        edges: Of `tensors.edges_of`, int32.
        buffer: The z-buffer, shape [views, height, width].
        look: How the surface looks at its outline.
        static: Whether no shape may depend on the picture. Outlines beyond an eighth of all pairs would stay hard.
    """
    views, height, width = buffer.shape
    edge, second_inside = (of_pair.view(-1) for of_pair in parting_edges(surface[..., :3], edges, buffer))
    parted, slot = edge >= 0, None
    if static:  # the pair in every slot, any where a slot is not used, and the slot of every pair, -1 for none
        slots = len(edge) // MOST_PARTED + 1
        slot = torch.where(parted, parted.cumsum(dim=0) - 1, -1)
        pair, slot = torch.nonzero_static(parted, size=slots, fill_value=0)[:, 0], torch.where(slot < slots, slot, -1)
    else:
        pair = parted.nonzero()[:, 0]
    count = views * height * width
    below, first = pair >= count, pair % count
    view = first // (height * width)
    ends = taken(surface.flatten(0, 1), edges[:, :2].T.index_select(1, edge[pair].clamp(min=0)) + view * surface.shape[1])
    place, beside = ends.split([2, ends.shape[-1] - 2], dim=-1)
    # Where edges cross the line from the centre of a pixel to that of its neighbour: their share of the edge and of that line, from 0 to 1.
    pixel, ((ax, ay), (bx, by)) = first % (height * width), (end.unbind(dim=1) for end in place)
    x, y = (pixel % width).to(place) + 0.5, (pixel // width).to(place) + 0.5
    along_a, along_b = torch.where(below, ax - x, ay - y), torch.where(below, bx - x, by - y)
    across_a, across_b = torch.where(below, ay - y, ax - x), torch.where(below, by - y, bx - x)
    length = along_b - along_a
    share = -along_a / torch.where(length == 0, 1.0, length)
    crossing = across_a + share * (across_b - across_a)
    # The two pixels meet half way: an edge beyond spreads the surface of the first into the second, one before it the reverse.
    beyond = crossing - 0.5
    at_outline = look(beside, torch.stack([1.0 - share, share]), view)
    if slot is not None:
        outline = placed(torch.cat([at_outline, beyond[:, None]], dim=1), pair, slot).T.contiguous()
        return _spread(picture.view(-1, views, height, width), outline, second_inside).flatten(1)
    outward = (beyond > 0) != second_inside[pair]
    second = first + torch.where(below, width, 1)
    into, out_of = torch.where(beyond > 0, second, first), torch.where(beyond > 0, first, second)
    source = torch.where(outward, at_outline.T, picture.index_select(1, out_of))
    return picture.index_add(1, into, beyond.abs() * (source - picture.index_select(1, into)))


def _spread(picture: torch.Tensor, outline: torch.Tensor, second_inside: torch.Tensor) -> torch.Tensor:
    """The picture, shape [channels, views, height, width], with every two neighbours blended, in shifted copies of all of it.

    On a GPU, additions to chosen pixels would have to be sorted first to be repeatable. The last pixel of a line is shifted to its other
    end, but no outline parts it from a neighbour. The last row of `outline`, shape [channels + 1, pairs], is how far beyond half way it
    passes.
    """
    blended, shape = picture, (2, *picture.shape[1:])
    for axis, own, inner in zip((3, 2), outline.unflatten(1, shape).unbind(1), second_inside.view(shape), strict=True):  # right, below
        look, beyond = own[:-1], own[-1]
        neighbour, outward = picture.roll(-1, axis), (beyond > 0) != inner
        into_first = beyond.clamp(max=0.0) * (picture - torch.where(outward, look, neighbour))
        into_second = beyond.clamp(min=0.0) * (torch.where(outward, look, picture) - neighbour)
        blended = blended + into_first + into_second.roll(1, axis)
    return blended
