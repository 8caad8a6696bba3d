"""Correction of a finished relief: the most of it with which a part passes, found by tests that look at their own effect.

Where the part yields in a test that fails, the relief is lowered. A cut weakens a section and a raised place strengthens it, so cuts are
filled first and raised places lowered second; a step that made more stay bent is undone and the other way is taken. Beside that one
factor on the whole relief is tried. Of all that passes the relief that keeps most is taken.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
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
LOCAL_ROUNDS = 5
"""Lowerings here and there that are tried."""
NEAREST = 1.0 / 16.0
"""How near to the largest factor on the whole relief that passes the bisection comes."""
REFINEMENTS = 2
"""Halves of what a lowering here and there took that are put back."""
MIN_GAIN = 0.02
"""Share of the style's relief that a try must promise to be worth a test."""

REASON = "correction: "
"""How the reason of a test of one of them begins."""

Try = tuple[Field, str]
"""A relief to be tested [mm], shape [vertex_count], and why, in words."""


class Finding(NamedTuple):
    """What a test of a relief found.

    Attributes:
        passes: Whether the part passed.
        worst: Share used of what is allowed in the worst test, above 1 where it fails; infinite if it is not known.
        overload: Of `control.overload` in the tests that fail, shape [vertex_count]; None if all pass, or it is not known.
    """

    passes: bool
    worst: float = float("inf")
    overload: Field | None = None


@dataclass(frozen=True)
class Correction:
    """The search for the most of a finished relief with which a part passes.

    Attributes:
        surface: The unstylized surface.
        wanted: The most that can be had [mm], shape [vertex_count]: the target, or the finished relief if nothing was held back.
        kept: Share of the style's target that a relief keeps.
        standing: Whether a vertex belongs to the faces the part stands on, shape [vertex_count].
    """

    surface: SurfaceMesh
    wanted: Field
    kept: Callable[[Field], float]
    standing: Bools

    def tries(self, finished: Field, found: Finding) -> Generator[Try, Finding, None]:
        """The reliefs to test, one after the other, none twice; what each test found is sent back.

        Args:
            finished: The finished relief [mm], shape [vertex_count].
            found: What its test found.
        """
        tested, search = {finished.tobytes(): found}, self._wanted_tries(finished, found)
        wanted = next(search, None)
        while wanted is not None:
            relief = wanted[0].tobytes()
            if relief not in tested:
                tested[relief] = yield wanted
            try:
                wanted = search.send(tested[relief])
            except StopIteration:
                return

    def _wanted_tries(self, finished: Field, found: Finding) -> Generator[Try, Finding, None]:
        """Those of `tries`, some perhaps twice."""
        passed = finished if found.passes else None
        failed: Field | None = None
        if self.kept(self.wanted) - self.kept(finished) >= MIN_GAIN:  # masks hold back what half a relief overloads, not the finished one
            whole = yield self.wanted, "all of the held-back relief put back"
            if whole.passes:
                return
            failed, found = self.wanted, whole
        elif passed is None:
            failed = finished
        if failed is None:
            return
        local = yield from self._lowered_here_and_there(failed, found)
        if local is not None and (passed is None or self.kept(local) > self.kept(passed)):
            passed = local
        scaled = yield from self._lowered_as_a_whole(failed, passed)
        if scaled is not None:
            passed = scaled
        if passed is None:
            yield failed * np.float32(0.0) + np.float32(0.0), "the relief removed"  # plus zero: -0 would be other bytes than 0
        elif local is passed:
            yield from self._between(passed, failed)

    def _lowered_here_and_there(self, relief: Field, found: Finding) -> Generator[Try, Finding, Field | None]:
        """Lowered where it yields, cuts first; the first relief that passes, None if none does."""
        fill, undone = bool((relief < 0.0).any()), 0
        for _ in range(LOCAL_ROUNDS):
            if found.overload is None or undone == 2:
                return None
            taken = lowered_share(found.overload, self._near)
            taken[self.standing & (overload(found.overload, self._near) > 0.0)] = 1.0  # a gap under it carries no load, however low it is
            taken = np.where((relief < 0.0) == fill, taken, 0.0)
            lowered = (relief * (1.0 - taken)).astype(np.float32)
            if self.kept(relief) - self.kept(lowered) < LEAST_TAKEN:
                fill, undone = not fill, undone + 1
                continue
            what = "cuts filled" if fill else "relief lowered"
            result = yield lowered, f"{what} around {int((found.overload >= 1.0).sum())} places that yield"
            if result.passes:
                return lowered
            if result.worst >= found.worst:  # that made it no better: undone, and the other way is taken
                fill, undone = not fill, undone + 1
            else:
                relief, found, undone = lowered, result, 0
        return None

    def _lowered_as_a_whole(self, relief: Field, passed: Field | None) -> Generator[Try, Finding, Field | None]:
        """One factor on all of the relief, as large as passes; None if none passes that keeps more than what is known to.

        Halved as by who tries nothing else, so that no less is kept even where less relief is no better; what keeps no more is not tested.
        """
        known = 0.0 if passed is None else self.kept(passed) / max(self.kept(relief), 1e-9)
        low, high, best = 0.0, 1.0, None
        while high - low > NEAREST:
            factor = 0.5 * (low + high)
            if factor <= known:
                low = factor
                continue
            lowered = relief * np.float32(factor) + np.float32(0.0)
            result = yield lowered, f"{factor:.0%} of the whole relief"
            if result.passes:
                best, low = lowered, factor
            else:
                high = factor
        return best

    def _between(self, passed: Field, failed: Field) -> Generator[Try, Finding, None]:
        """Half of what was taken put back, and half of that."""
        for _ in range(REFINEMENTS):
            half = np.where(self.standing, passed, 0.5 * (passed + failed)).astype(np.float32)
            if self.kept(half) - self.kept(passed) < MIN_GAIN:
                return
            result = yield half, "half of the removed relief put back"
            passed, failed = (half, failed) if result.passes else (passed, half)

    @cached_property
    def _near(self) -> csr_array:
        return neighbours(self.surface.vertices, max(REACH, EDGES * self.surface.edge_length))


LEAST_TAKEN = 0.002
"""Share of the style's relief below which a lowering changes nothing."""


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
