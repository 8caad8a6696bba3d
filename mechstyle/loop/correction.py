"""When the finished relief is not viable: lower it where it is overloaded; when it is: give back what was held back on the way.

Where a rule's limit is nearly used up, the relief around is lowered, and to nothing on the faces the part stands on: a gap under it
carries no load, however low it is. Until it is viable it is only ever lowered, because raising some of it while lowering other places
was seen to creep up to the limit. If lowering here and there is not enough, the whole relief is halved and at last removed: no relief is
the original part, which is viable by definition. Lowering begins at all that the style asks for: masks hold back what half a relief
overloads, and that is seldom what the finished one does. For the same reason a viable relief of which they held much back is exchanged
for the whole, or for what lowering leaves of that, if it holds; the part that was viable last is what is delivered.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.spatial import cKDTree

from mechstyle.records.mesh import Bools, Field, SurfaceMesh

AIM = 0.85
"""Demand to be reached; nearer to 1 it takes more rounds, because what is taken from one place is carried by the next."""
GAIN = 2.5
"""Share of the relief that is taken for a demand of one above the aim …"""
MOST = 0.6
"""… and the most that is taken at once."""
REACH = 3.0
"""How far around an overloaded vertex relief is lowered, and over what the lowering is smoothed [mm] …"""
EDGES = 2.0
"""… but never less than so many edges: on coarser triangles nothing but the overloaded vertex itself would be within reach."""
LOCAL_ROUNDS = 4
"""Lowerings here and there before the whole relief is lowered."""
PATCH_ROUNDS = 1
"""Of these, those that widen what the part stands on near an overload. Then it is laid flat: the impact goes from bump to bump, and what a
part stands on decides how it bends far from there."""
WHOLE = (0.6, 0.5, 0.0)
"""Factors on the whole relief after that."""
GIVE_BACK = 3
"""Times it is tried to give back some of what was held back or lowered."""
WORTH = 0.02
"""Share of the style's relief that giving back must promise to be worth a drop."""


@dataclass
class Correction:
    """The search for the most of a finished relief with which a part is viable.

    Attributes:
        surface: The unstylized surface.
        wanted: What the style asks for within its bounds [mm], shape [vertex_count]; the finished relief if nothing held any of it back.
        kept: Share of it that a relief keeps.
        standing: Whether a vertex belongs to the faces the part stands on, shape [vertex_count].
        viable: The most relief known to be viable [mm], shape [vertex_count]; None as long as none is.
        failing: The least known not to be [mm], shape [vertex_count]; None as long as none is.
    """

    surface: SurfaceMesh
    wanted: Field
    kept: Callable[[Field], float]
    standing: Bools
    viable: Field | None = None
    failing: Field | None = None
    _lowered: int = 0
    _given_back: int = 0
    _near: list[csr_array] = field(default_factory=list, repr=False)

    def tested(self, relief: Field, *, viable: bool, demand: Field | None, landed: bool = True) -> tuple[Field, str] | None:
        """The relief to test next [mm] and why, in words; None if what was found so far will do.

        Args:
            relief: What was tested [mm], shape [vertex_count].
            viable: Whether the part was viable with it.
            demand: Demand of that test, shape [vertex_count]; None if it gave no field.
            landed: Whether a landing failed it: to what fails under a load alone, what the part stands on is a place like any other.
        """
        if viable:
            self.viable = relief
        else:
            self.failing = relief
        if self.viable is not None:
            return self._more(self.viable, None if viable else demand, landed=landed)
        if demand is not None and self._lowered < LOCAL_ROUNDS:
            return self._lowered_locally(relief if self._lowered else self.wanted, demand, landed=landed)
        self._lowered = max(self._lowered, LOCAL_ROUNDS) + 1
        if self._lowered > LOCAL_ROUNDS + len(WHOLE):
            return None
        factor = WHOLE[self._lowered - LOCAL_ROUNDS - 1]
        # Adding zero turns -0 into 0: the same bytes as the unstylized part, whose simulation is remembered.
        return relief * np.float32(factor) + np.float32(0.0), "the whole relief lowered" if factor else "the relief removed"

    def _more(self, viable: Field, failed: Field | None, *, landed: bool) -> tuple[Field, str] | None:
        """What more than a viable relief is to be tested, given the demand of what has just failed; None if nothing is worth a drop."""
        if self._given_back == GIVE_BACK:
            return None
        self._given_back += 1
        tries = []
        if self.failing is None:
            tries.append((self.wanted, "all that was held back given back"))
        else:
            if failed is not None and self._lowered < LOCAL_ROUNDS:
                tries.append(self._lowered_locally(self.failing, failed, landed=landed))
            # Half the way under the part would be a gap under all of it, and carry nothing.
            half = np.where(self.standing, viable, 0.5 * (viable + self.failing)).astype(np.float32)
            tries.append((half, "half of what was too much given back"))
        return next((tried for tried in tries if self.kept(tried[0]) - self.kept(viable) >= WORTH), None)

    def _lowered_locally(self, relief: Field, demand: Field, *, landed: bool) -> tuple[Field, str]:
        self._lowered += 1
        taken = lowering(demand, self._neighbours())
        if landed:
            patches = self.standing & (overload(demand, self._neighbours()) > 0.0)
            taken[patches if self._lowered <= PATCH_ROUNDS else self.standing] = 1.0
        return (relief * (1.0 - taken)).astype(np.float32), f"relief lowered around {int((demand >= 1.0).sum())} overloaded vertices"

    def _neighbours(self) -> csr_array:
        if not self._near:
            self._near.append(neighbours(self.surface.vertices, max(REACH, EDGES * self.surface.edge_length)))
        return self._near[0]


def lowering(demand: Field, near: csr_array) -> Field:
    """Share of the relief that is taken at each vertex, in [0, MOST], shape [vertex_count].

    min(GAIN o / (1 + 0.3 o), MOST) of the overload o within reach, smoothed over the reach.

    Args:
        demand: Demand, shape [vertex_count].
        near: Who lies within reach of whom, itself included, shape [vertex_count, vertex_count].
    """
    around = overload(demand, near)
    taken = np.minimum(GAIN * around / (1.0 + 0.3 * around), MOST)
    return np.asarray((near @ taken) / np.diff(near.indptr), np.float32)


def missing(relief: Field, wanted: Field) -> Field:
    """What a relief lacks of the one that is wanted [mm], shape [vertex_count]; nothing where it goes further or the other way already."""
    return np.where((relief * wanted >= 0.0) & (np.abs(wanted) > np.abs(relief)), wanted - relief, 0.0).astype(np.float32)


def left(before: Field, after: Field) -> Field:
    """Share of a relief that was left at each vertex, in [0, 1], shape [vertex_count]; 1 where there was none or it was raised.

    Args:
        before: The relief [mm], shape [vertex_count].
        after: What became of it [mm], shape [vertex_count].
    """
    safe = np.where(before == 0.0, 1.0, before)
    return np.asarray(np.where(before == 0.0, 1.0, np.clip(after / safe, 0.0, 1.0)), np.float32)


def given_back(before: Field, after: Field, wanted: Field) -> Field:
    """Share of what a relief lacked that it was given back at each vertex, in [0, 1], shape [vertex_count].

    Args:
        before: The relief [mm], shape [vertex_count].
        after: What became of it [mm], shape [vertex_count].
        wanted: What the style asks for [mm], shape [vertex_count].
    """
    lacked = missing(before, wanted)
    safe = np.where(lacked == 0.0, 1.0, lacked)
    return np.asarray(np.where(lacked == 0.0, 0.0, np.clip((after - before) / safe, 0.0, 1.0)), np.float32)


def overload(demand: Field, near: csr_array) -> Field:
    """The largest demand above the aim within reach of each vertex, 0 where there is none, shape [vertex_count].

    Where no demand exceeds the aim although a rule is broken, as a percentile may be, the aim is nine tenths of the largest.

    Args:
        demand: Demand, shape [vertex_count].
        near: Who lies within reach of whom, itself included, shape [vertex_count, vertex_count].
    """
    over = np.maximum(demand - min(AIM, 0.9 * float(demand.max())), 0.0)
    return np.asarray(np.maximum.reduceat(over[near.indices], near.indptr[:-1]), np.float32)


def neighbours(vertices: NDArray[np.float64], reach: float) -> csr_array:
    """Which vertices lie within `reach` [mm] of which, themselves included, shape [vertex_count, vertex_count]."""
    pairs, itself = cKDTree(vertices).query_pairs(reach, output_type="ndarray").astype(np.int32), np.arange(len(vertices), dtype=np.int32)
    rows, columns = np.concatenate([pairs[:, 0], pairs[:, 1], itself]), np.concatenate([pairs[:, 1], pairs[:, 0], itself])
    return coo_array((np.ones(len(rows), np.float32), (rows, columns)), shape=(len(vertices),) * 2).tocsr()


def nearness(vertices: NDArray[np.float64], selected: NDArray[np.bool_], radius: float) -> Field:
    """exp(−(d/radius)²) with d the distance to the nearest selected vertex [mm], shape [vertex_count]; zero if none is selected."""
    if not selected.any():
        return np.zeros(len(vertices), np.float32)
    distance, _ = cKDTree(vertices[selected]).query(vertices)
    return np.exp(-((distance / radius) ** 2)).astype(np.float32)
