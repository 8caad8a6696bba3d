"""When the finished relief is not viable: lower it where it is overloaded, and give back what was lowered too far.

Every vertex has a share of the finished relief. Where a rule's limit is nearly used up, the shares around are lowered, and to nothing
on the faces the part stands on: a gap under it carries no load, however low it is. Once the part is viable, half of the last lowering is
given back, as often as that is worth a drop. The shares are only ever lowered in between, because raising some while lowering others
was seen to creep up to the limit. If lowering here and there is not enough, the whole relief is halved and at last removed: no relief is
the original part, which is viable by definition.
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
GIVE_BACK = 2
"""Times half of the last lowering is tried again."""
WORTH = 0.01
"""Share of the relief that giving back must promise to be worth a drop."""


@dataclass
class Correction:
    """The search for the shares of a finished relief with which a part is viable.

    Attributes:
        surface: The unstylized surface.
        kept: Share of the relief that given shares of it keep.
        standing: Whether a vertex belongs to the faces the part stands on, shape [vertex_count].
        viable: The largest shares known to be viable, shape [vertex_count]; None as long as none are.
        failing: The smallest shares known not to be, shape [vertex_count]; None as long as none are.
    """

    surface: SurfaceMesh
    kept: Callable[[Field], float]
    standing: Bools
    viable: Field | None = None
    failing: Field | None = None
    _lowered: int = 0
    _given_back: int = 0
    _near: list[csr_array] = field(default_factory=list, repr=False)

    def tested(self, share: Field, *, viable: bool, demand: Field | None, landed: bool = True) -> tuple[Field, str] | None:
        """The shares to test next and why, in words; None if those found so far will do.

        Args:
            share: What was tested, shape [vertex_count].
            viable: Whether the part was viable with it.
            demand: Demand of that test, shape [vertex_count]; None if it gave no field.
            landed: Whether a landing failed it: to what fails under a load alone, what the part stands on is a place like any other.
        """
        if viable:
            self.viable = share
        else:
            self.failing = share
        if self.viable is not None:
            return self._half_back()
        if demand is not None and self._lowered < LOCAL_ROUNDS:
            self._lowered += 1
            return self._lowered_locally(share, demand, landed=landed)
        self._lowered = max(self._lowered, LOCAL_ROUNDS) + 1
        if self._lowered > LOCAL_ROUNDS + len(WHOLE):
            return None
        factor = WHOLE[self._lowered - LOCAL_ROUNDS - 1]
        # Adding zero turns -0 into 0: the same bytes as the unstylized part, whose simulation is remembered.
        return share * np.float32(factor) + np.float32(0.0), "the whole relief lowered" if factor else "the relief removed"

    def _half_back(self) -> tuple[Field, str] | None:
        if self.failing is None or self.viable is None or self._given_back == GIVE_BACK:
            return None
        half = np.where(self.standing, self.viable, 0.5 * (self.viable + self.failing)).astype(np.float32)
        if self.kept(half) - self.kept(self.viable) < WORTH:
            return None
        self._given_back += 1
        return half, "half of the last lowering given back"

    def _lowered_locally(self, share: Field, demand: Field, *, landed: bool) -> tuple[Field, str]:
        taken = lowering(demand, self._neighbours())
        if landed:
            patches = self.standing & (overload(demand, self._neighbours()) > 0.0)
            taken[patches if self._lowered <= PATCH_ROUNDS else self.standing] = 1.0
        return (share * (1.0 - taken)).astype(np.float32), f"relief lowered around {int((demand >= 1.0).sum())} overloaded vertices"

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
