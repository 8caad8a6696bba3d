"""Colours finer than a mesh: a picture with a place of its own for every face, two to a block.

The points of a face on a lattice of n parts an edge are texels. Those on an edge lie in both of its faces at the same places, so that no
seam shows; a rim of one more texel around each face keeps its neighbours in the picture out of it when a viewer averages.
"""

from __future__ import annotations

import io
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from mechstyle.records.mesh import Floats, Indices

LARGEST = 4096
"""Texels along a side of a texture: more are not drawn by every viewer."""
MOST_PARTS = 8
"""Parts of an edge, where there is room."""


class Texture(NamedTuple):
    """A picture and where each face lies in it.

    Attributes:
        pixels: Display RGB, rows from the top, shape [height, width, 3].
        uv: Place of each corner of each face, from the lower left corner, in [0, 1], shape [face_count, 3, 2].
    """

    pixels: NDArray[np.uint8]
    uv: Floats


class Texels(NamedTuple):
    """Points of the faces that a texture shows.

    Attributes:
        face: The face each lies on, shape [texel_count].
        weights: Of its three corners, adding up to 1, shape [texel_count, 3].
    """

    face: Indices
    weights: Floats


class Atlas:
    """A place in a picture for every face of a mesh.

    Attributes:
        parts: Parts that an edge is cut into.
    """

    def __init__(self, face_count: int, parts: int = MOST_PARTS) -> None:
        """Lay out the faces, their edges cut into `parts`, or fewer where the picture would get larger than LARGEST."""
        self._count = face_count
        fits = [one for one in range(parts, 0, -1) if self._columns(one)]
        self.parts = fits[0] if fits else 1
        self._across = self._columns(self.parts) or int(np.ceil(np.sqrt(face_count / 2.0)))

    @cached_property
    def texels(self) -> Texels:
        """The points shown, on a lattice on every face."""
        weights = np.column_stack([self.parts - self._lattice.sum(axis=1), self._lattice]) / self.parts
        faces = np.repeat(np.arange(self._count, dtype=np.int32), len(weights))
        return Texels(faces, np.tile(weights, (self._count, 1)))

    def painted(self, colours: NDArray[np.floating]) -> Texture:
        """The texture that shows colours, display RGB in [0, 1], at the texels, shape [texel_count, 3]."""
        down = -(-self._count // (2 * self._across))
        height, width = down * self._high, self._across * self._wide
        pixels = np.full((height, width, 3), 128, np.uint8)
        around, reach = self._with_rim
        whole = np.einsum("rl,flc->frc", reach, np.asarray(colours, np.float32).reshape(self._count, -1, 3))
        column, row = self._places(np.tile(around, (self._count, 1)), np.repeat(np.arange(self._count), len(around)))
        pixels[row, column] = np.round(np.clip(whole, 0.0, 1.0) * 255.0).reshape(-1, 3)
        corners = np.tile([[0, 0], [self.parts, 0], [0, self.parts]], (self._count, 1))
        u, v = self._places(corners, np.repeat(np.arange(self._count), 3))
        uv = np.column_stack([(u + 0.5) / width, 1.0 - (v + 0.5) / height])
        return Texture(pixels, uv.reshape(-1, 3, 2))

    @cached_property
    def _lattice(self) -> Indices:
        """Steps along the first and the second edge from a face's first corner, shape [texels_per_face, 2]."""
        return np.array([(i, j) for i in range(self.parts + 1) for j in range(self.parts + 1 - i)], np.int32)

    @cached_property
    def _with_rim(self) -> tuple[Indices, NDArray[np.float32]]:
        """Lattice and rim, shape [k, 2], and what each takes of the lattice's colours, shape [k, texels_per_face].

        The rim is as the edge next to it. Only beyond the edge between second and third corner colours go on as they change there: what a
        viewer averages along that edge takes them in.
        """
        number = {(i, j): at for at, (i, j) in enumerate(self._lattice.tolist())}
        around = [(i, j) for i in range(-1, self.parts + 2) for j in range(-1, self.parts + 2) if i + j <= self.parts + 1]
        reach = np.zeros((len(around), len(number)), np.float32)
        for row, (i, j) in zip(reach, around, strict=True):
            if i + j == self.parts + 1 and min(i, j) >= 1:
                row[[number[i - 1, j], number[i, j - 1]]] = 1.0
                row[number[i - 1, j - 1]] = -1.0
            else:
                x, y = max(i, 0), max(j, 0)
                beyond = max(x + y - self.parts, 0)
                row[number[(x - beyond, y) if x >= y else (x, y - beyond)]] = 1.0
        return np.array(around, np.int32), reach

    @property
    def _wide(self) -> int:
        return self.parts + 5

    @property
    def _high(self) -> int:
        return self.parts + 4

    def _columns(self, parts: int) -> int:
        """Blocks beside each other in a nearly square picture, 0 if it would be too large."""
        blocks = -(-self._count // 2)
        across = min(int(np.ceil(np.sqrt(blocks * (parts + 4) / (parts + 5)))), LARGEST // (parts + 5))
        return across if -(-blocks // max(across, 1)) * (parts + 4) <= LARGEST else 0

    def _places(self, lattice: Indices, face: Indices) -> tuple[Indices, Indices]:
        """Column and row in the picture of places of faces; of each second face turned by half a turn."""
        block, odd = face // 2, face % 2 == 1
        column = np.where(odd, self._wide - 2 - lattice[:, 0], lattice[:, 0] + 1)
        row = np.where(odd, self._high - 2 - lattice[:, 1], lattice[:, 1] + 1)
        return column + block % self._across * self._wide, row + block // self._across * self._high


def png(pixels: NDArray[np.uint8]) -> bytes:
    """Pixels as a PNG file."""
    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, "png")
    return buffer.getvalue()
