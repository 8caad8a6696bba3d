"""What a file holds before it is one body: triangles by name, what is cut out of them, and what is no material at all."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mechstyle.records.mesh import Floats

COLOURS_LEFT = "its colours are left out: a style brings its own"
"""Said of a file that comes coloured."""


class Piece(NamedTuple):
    """Triangles of one name."""

    name: str  # what its file calls it, "" if it does not
    vertices: Floats  # positions [file units], shape [n, 3]
    faces: NDArray[np.int64]  # vertex indices, shape [m, 3]

    @property
    def corners(self) -> Floats:
        """Positions that its faces use, shape [k, 3]."""
        return self.vertices[self.faces].reshape(-1, 3)

    def submesh(self, faces: NDArray[np.int64], name: str = "") -> Piece:
        """Some of its faces, and the vertices that they use."""
        used, index = np.unique(faces, return_inverse=True)
        return Piece(name or self.name, self.vertices[used], index.reshape(-1, 3))


class Thing(NamedTuple):
    """An object of a file."""

    name: str  # what its file calls it, "" if it does not
    pieces: tuple[Piece, ...]  # what it is made of; each may be open, as long as all together are closed
    cuts: tuple[Piece, ...] = ()  # closed shapes whose inside is taken away from it


class Unprinted(NamedTuple):
    """A piece of a file that is not printed."""

    role: str  # what it is instead, in words
    piece: Piece  # its shape

    def words(self, matrix: Floats) -> str:
        """Its name, role and size, turned and scaled to mm by a matrix for columns, shape [3, 3]."""
        return f"{quoted_name(self.piece.name) + ', ' if self.piece.name else ''}{self.kind} of {size_words(self.piece.corners @ matrix.T)}"

    @property
    def kind(self) -> str:
        """Its role with its article."""
        return f"{'an' if self.role[0] in 'aeiou' else 'a'} {self.role}"


class Held(NamedTuple):
    """All that a file holds."""

    things: tuple[Thing, ...]  # what is printed
    unit: str  # the unit of its coordinates
    unprinted: tuple[Unprinted, ...] = ()  # what is not printed
    notes: tuple[str, ...] = ()  # what else is to be known of it, one sentence each


def quoted_name(name: str) -> str:
    """A name of a file as a sentence quotes it: short, and without signs that are none."""
    plain = "".join(sign for sign in name if sign.isprintable()).strip()
    return f"'{plain[:40]}…'" if len(plain) > 41 else f"'{plain}'"


def size_words(points: Floats) -> str:
    """The box around points [mm] in words, shape [n, 3]."""
    return " × ".join(f"{side:.2g}" if side < 1.0 else f"{round(side, 1):g}" for side in np.ptp(points, axis=0).tolist()) + " mm"
