"""Painted triangles as slicers write them: one word a triangle, in which a triangle may be cut into four.

The words are PrusaSlicer's (`TriangleSelector::serialize`), which Bambu Studio and OrcaSlicer took over: a stream of 4-bit numbers, written
in reverse as hexadecimal digits. A number `xxyy` with yy = 0 is a whole triangle of state xx, or for xx = 11 of the next number plus 3;
with yy = 2 or 3 its corner xx is cut off, or all of them are, at the middles of the sides, and its 3 or 4 parts follow, the last first.
State n is filament n; state 0 would be the object's own.
"""

from __future__ import annotations

import numpy as np

from mechstyle.records.mesh import Indices

_LONG = 3
"""States from here on take a second number."""


def words(filament: Indices) -> list[str]:
    """The word of each triangle: whole where its corners agree, cut at the middles of its sides where they do not.

    One corner of another colour is cut off; where all three differ each gets its own, and the middle the one that comes first.

    Args:
        filament: Filament of each corner, counted from 0, shape [face_count, 3].
    """
    kinds, which = distinct(filament)
    table = [_word(*(int(corner) + 1 for corner in kind)) for kind in kinds]
    return [table[kind] for kind in which.tolist()]


def distinct(filament: Indices) -> tuple[Indices, Indices]:
    """The triples that occur, in order, and which of them each triangle is: as `np.unique` has it, but counted instead of sorted.

    Args:
        filament: Filament of each corner, counted from 0, shape [face_count, 3].

    Returns:
        The triples, shape [kind_count, 3], and places in them, shape [face_count].
    """
    base = int(filament.max(initial=0)) + 1
    name = np.ravel_multi_index(tuple(filament.T), (base, base, base))
    occurs = np.bincount(name, minlength=base**3) > 0
    kinds = np.stack(np.unravel_index(np.flatnonzero(occurs), (base, base, base)), axis=1)
    return kinds.astype(np.int32), (np.cumsum(occurs) - 1)[name].astype(np.int32)


def _word(a: int, b: int, c: int) -> str:
    """The word of a triangle with these states at its corners."""
    if a == b == c:
        stream = _whole(a)
    elif a != b != c != a:
        stream = [0b0011, *_whole(min(a, b, c)), *_whole(c), *_whole(b), *_whole(a)]
    else:
        odd = 0 if b == c else 1 if a == c else 2
        cut, rest = (a, b, c)[odd], (a, b, c)[odd - 1]
        stream = [odd << 2 | 0b10, *_whole(rest), *_whole(rest), *_whole(cut)]
    return "".join(f"{number:X}" for number in reversed(stream))


def _whole(state: int) -> list[int]:
    """The numbers of a triangle of one state."""
    return [state << 2] if state < _LONG else [0b1100, state - _LONG]
