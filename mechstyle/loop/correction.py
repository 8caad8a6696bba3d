"""Correction of a finished relief: lowered where a test does not pass for sure, then given back where there is room.

Around the stress that is too high the relief is lowered, and to nothing on the faces the part stands on: a gap under it carries no load,
however low it is. Until it passes it is only ever lowered, because raising some of it while lowering other places was seen to creep up to
the limit. If lowering here and there is not enough for a part that fails, the whole relief is halved and at last removed. Lowering begins
at all that the style asks for: masks hold back what half a relief overloads, and that is seldom what the finished one does. For the same
reason a relief that passes, of which they held much back, is exchanged for the whole, or for what lowering leaves of that, if it passes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.spatial import cKDTree

from mechstyle.records.mesh import Bools, Field, SurfaceMesh

AIM = 0.85
"""Utilisation to be reached; nearer to 1 it takes more rounds, because what is taken from one place is carried by the next."""
GAIN = 2.5
"""Share of the relief that is taken for a utilisation of one above the aim …"""
MOST = 0.6
"""… and the most that is taken at once."""
REACH = 3.0
"""How far around an overloaded vertex relief is lowered, and over what the lowering is smoothed [mm] …"""
EDGES = 2.0
"""… but never less than so many edges: on coarser triangles nothing but the overloaded vertex itself would be within reach."""
LOCAL_ROUNDS = 6
"""Lowerings here and there before the whole relief is lowered."""
PATCH_ROUNDS = 1
"""Of these, those that widen what the part stands on near an overload. Then it is laid flat: the impact goes from bump to bump, and what a
part stands on decides how it bends far from there."""
WHOLE = (0.6, 0.5, 0.0)
"""Factors on the whole relief after that."""
GIVE_BACK = 3
"""Times it is tried to give back some of what was held back or lowered."""
MIN_GAIN = 0.02
"""Share of the style's relief that giving back must promise to be worth a drop."""


class Finding(NamedTuple):
    """What a test of a relief found.

    Attributes:
        passes: Whether the part passed.
        utilisation: Stress over what passes for sure, in the tests that do not, shape [vertex_count]; None if all do, or it is not known.
        fails_by_drop: Whether a landing is among them: to what a load alone decides, what the part stands on is a place like any other.
    """

    passes: bool
    utilisation: Field | None = None
    fails_by_drop: bool = True


@dataclass
class Correction:
    """The search for the most of a finished relief with which a part passes for sure.

    Attributes:
        surface: The unstylized surface.
        wanted: The most that can be given back [mm], shape [vertex_count]: the target, or the finished relief if nothing was held back.
        kept: Share of the style's target that a relief keeps.
        standing: Whether a vertex belongs to the faces the part stands on, shape [vertex_count].
        sure: The most relief known to pass for sure [mm], shape [vertex_count]; None as long as none does.
        unsure: The least known not to [mm], shape [vertex_count]; None as long as none is.
        passed: Whether any relief passed.
    """

    surface: SurfaceMesh
    wanted: Field
    kept: Callable[[Field], float]
    standing: Bools
    sure: Field | None = None
    unsure: Field | None = None
    passed: bool = False
    _lowered: int = 0
    _given_back: int = 0

    def tested(self, relief: Field, found: Finding) -> tuple[Field, str] | None:
        """The relief to test next [mm] and why, in words, given what the test of one found; None if what was found so far will do."""
        self.passed |= found.passes
        if found.passes and found.utilisation is None:
            self.sure = relief
        else:
            self.unsure = relief
        if self.sure is not None:
            return self._more(self.sure, found)
        if found.utilisation is not None and self._lowered < LOCAL_ROUNDS:
            return self._lowered_locally(relief if self._lowered else self.wanted, found.utilisation, fails_by_drop=found.fails_by_drop)
        if self.passed:  # to be sure is worth some relief here and there, not half of all of it
            return None
        self._lowered = max(self._lowered, LOCAL_ROUNDS) + 1
        if self._lowered > LOCAL_ROUNDS + len(WHOLE):
            return None
        factor = WHOLE[self._lowered - LOCAL_ROUNDS - 1]
        # Adding zero turns -0 into 0: the same bytes as the unstylized part, whose simulation is remembered.
        return relief * np.float32(factor) + np.float32(0.0), "the whole relief lowered" if factor else "the relief removed"

    def _more(self, sure: Field, found: Finding) -> tuple[Field, str] | None:
        """What more than a relief that passes is to be tested, given what was just found; None if nothing is worth a test."""
        if self._given_back == GIVE_BACK:
            return None
        self._given_back += 1
        tries = []
        if self.unsure is None:
            tries.append((self.wanted, "all that was held back given back"))
        else:
            if found.utilisation is not None and self._lowered < LOCAL_ROUNDS:
                tries.append(self._lowered_locally(self.unsure, found.utilisation, fails_by_drop=found.fails_by_drop))
            # Half the way under the part would be a gap under all of it, and carry nothing.
            half = np.where(self.standing, sure, 0.5 * (sure + self.unsure)).astype(np.float32)
            tries.append((half, "half of what was too much given back"))
        return next((tried for tried in tries if self.kept(tried[0]) - self.kept(sure) >= MIN_GAIN), None)

    def _lowered_locally(self, relief: Field, used: Field, *, fails_by_drop: bool) -> tuple[Field, str]:
        self._lowered += 1
        taken = lowered_share(used, self._near)
        if fails_by_drop:
            patches = self.standing & (overload(used, self._near) > 0.0)
            taken[patches if self._lowered <= PATCH_ROUNDS else self.standing] = 1.0
        return (relief * (1.0 - taken)).astype(np.float32), f"relief lowered around {int((used >= 1.0).sum())} overloaded vertices"

    @cached_property
    def _near(self) -> csr_array:
        return neighbours(self.surface.vertices, max(REACH, EDGES * self.surface.edge_length))


def lowered_share(used: Field, near: csr_array) -> Field:
    """Share of the relief that is taken at each vertex, in [0, MOST], shape [vertex_count].

    min(GAIN o / (1 + 0.3 o), MOST) of the overload o within reach, smoothed over the reach; `near` is of `neighbours`.
    """
    around = overload(used, near)
    taken = np.minimum(GAIN * around / (1.0 + 0.3 * around), MOST)
    return np.asarray((near @ taken) / np.diff(near.indptr), np.float32)


def remaining_share(before: Field, after: Field) -> Field:
    """Share of a relief that was left at each vertex, in [0, 1], shape [vertex_count]; 1 where there was none or it was raised."""
    safe = np.where(before == 0.0, 1.0, before)
    return np.asarray(np.where(before == 0.0, 1.0, np.clip(after / safe, 0.0, 1.0)), np.float32)


def overload(used: Field, near: csr_array) -> Field:
    """The largest utilisation above the aim within reach of each vertex, 0 where there is none, shape [vertex_count].

    Where none exceeds the aim although a test does not pass, as the mean along the surface may be lower, it is nine tenths of the largest.
    `near` is of `neighbours`.
    """
    over = np.maximum(used - min(AIM, 0.9 * float(used.max())), 0.0)
    return np.asarray(np.maximum.reduceat(over[near.indices], near.indptr[:-1]), np.float32)


def neighbours(vertices: NDArray[np.float64], reach: float) -> csr_array:
    """Which vertices lie within `reach` [mm] of which, themselves included, shape [vertex_count, vertex_count]."""
    pairs, itself = cKDTree(vertices).query_pairs(reach, output_type="ndarray").astype(np.int32), np.arange(len(vertices), dtype=np.int32)
    rows, columns = np.concatenate([pairs[:, 0], pairs[:, 1], itself]), np.concatenate([pairs[:, 1], pairs[:, 0], itself])
    return coo_array((np.ones(len(rows), np.float32), (rows, columns)), shape=(len(vertices),) * 2).tocsr()
