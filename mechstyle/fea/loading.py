"""A load that is put on slowly: shapes of a body that flows in which it balances more and more of it, and where it gives way.

In balance the inner forces of a shape, after the flow to it from the last one, are those of the load. Flow by the return to the yield
surface is the minimum of an energy over one step (Ortiz and Stainier 1999), and the shape is sought as that: with the changes of force
along the last steps (BFGS, Matthies and Strang 1979; in the form of Nocedal 1980), which begin with the stiffness of the elastic body.
So a slender body takes as long as a stout one, and a shape that is unstable is not found.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from mechstyle.fea.discretisation import Discretisation
from mechstyle.fea.drop import body_on
from mechstyle.fea.elasticity import law_named
from mechstyle.fea.explicit import FLOW, RECORD_EVERY, STRAIN, TENSION, Progress, Scheme, Shaped
from mechstyle.fea.permanent_set import Measured, Springback, measured
from mechstyle.records.mesh import Floats

MOST = 3.0
"""Times the load to which a body is loaded at most."""
GROWS = 1.25
"""By how much a load is raised at a time once something yields."""
CLOSE = 1.03
"""How close together the loads that a body bears and does not bear are sought."""
FAR = 0.2
"""Share of its size by which a body moves when it gives way: it buckles, or a hinge forms."""
TILTED = 1.0 / 500.0
"""Angle by which a load is turned [rad], since none is put on quite straight: a strut that is pressed so would not know where to go."""
LEAST = 0.01
"""Share of a load below which it does not matter whether a body bears it."""

ENOUGH = 1e-3
"""Error of a shape in the norm of energy over the work of the load, at which it balances the load."""
ROUNDS, MEMORY = 150, 12
"""Steps after which a shape is not sought any longer, 10 to 45 were counted up to collapse; and those that are remembered."""
TAKEN, TRIES = 0.5, 8
"""A step is as long as leaves no more than this share of the force along it (Matthies and Strang 1979), or as found in so many tries."""


@dataclass(frozen=True, eq=False)
class Held:
    """A body on supports.

    Attributes:
        body: The body, without added mass.
        basis: Z of the nodal displacements u = Z q that the supports allow, x, y, z of a node adjacent, nodes in the order of `body.mesh`,
            shape [3 node_count, free_count].
        nearly: About (Zᵀ K Z)⁻¹ times a vector, shape [free_count].
        across: Normal of printed layers over their share of the strength.
    """

    body: Discretisation
    basis: sparse.csc_array
    nearly: Callable[[Floats], Floats]
    across: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def shaped(self) -> Shaped:
        """The body before anything flows, on the CPU: the kernels take a thirtieth of the time of the equations."""
        material, nothing = self.body.stiffness.material, np.zeros(len(self.body.volumes))
        law = law_named("stable_neo_hookean", material)
        scheme = Scheme(law, 1.0, nothing, 0.0, 0.0, 0.0, RECORD_EVERY, 0, self.across, material.yield_strength, material.hardening)
        return body_on("cpu", self.body).shaped(scheme)


@dataclass(frozen=True, eq=False)
class Balance:
    """A body under a share of a load, all in the numbering of its mesh.

    Attributes:
        factor: The share.
        displacement: Of the nodes [mm], shape [node_count, 3].
        strain: Equivalent plastic strain, shape [tet_count, points].
        permanent: What stays bent when the load is taken off, the material being elastic then [mm], shape [vertex_count, 3].
        figures: The same in figures.
    """

    factor: float
    displacement: Floats
    strain: NDArray[np.float32]
    permanent: Floats
    figures: Measured


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a load does.

    Attributes:
        at: The body under it; if it collapses, just before.
        stress: Largest stress on the way there [MPa], shape [tet_count, points].
        factor: Times the load up to which the body is in balance and no more than the tolerance stays bent.
        reached: Whether it gave way there; if not, it was loaded no further.
        collapses: Whether nothing balances the load.
    """

    at: Balance
    stress: NDArray[np.float32]
    factor: float
    reached: bool
    collapses: bool


class Ramp:
    """Raises one load on a body until it gives way, or to `MOST` times the load."""

    def __init__(self, held: Held, springback: Springback, load: Floats, tolerance: float) -> None:
        self._held, self._springback, self._tolerance = held, springback, tolerance
        self._load, self._shaped = tilted(load), held.shaped()
        self._density = _density(held.body)
        body = held.body  # single precision strains every tetrahedron by rounding, the more the farther it moves
        steepness = np.einsum("tij,tij->t", body.gradients, body.gradients)
        self._rounding = np.finfo(np.float32).eps ** 2 * body.stiffness.material.youngs_modulus * _dot(body.volumes, steepness)
        self._far = FAR * float(np.linalg.norm(np.ptp(held.body.mesh.nodes, axis=0)))

    def put_on(self, first: float, progress: Progress) -> Outcome:
        """What the load does; something yields under about the share `first` of it. `progress` gets the share of `MOST` that is on."""
        low, factor = self._under(0.0, np.zeros_like(self._load)), 0.0
        asked: Outcome | None = None
        limit: float | None = None
        while factor < MOST and (asked is None or limit is None):
            progress(factor / MOST)
            factor = _raised(factor, first)
            displacement, balanced = self._sought(factor, low.displacement)
            high = self._under(factor, displacement) if balanced else self._most(low, factor, math.inf)
            if limit is None and high.figures.permanent_set > self._tolerance:
                limit = self._most(low, high.factor, self._tolerance).factor
            elif limit is None and not balanced:
                limit = high.factor
            if not balanced and asked is not None:
                break  # under more than was asked for
            self._shaped.keep(self._ordered(high.displacement))
            if not balanced or factor == 1.0:
                asked = Outcome(high, self._stress(), MOST, reached=False, collapses=not balanced)
            low = high
        assert asked is not None, "it was loaded up to the load, or collapsed before"
        return asked if limit is None else replace(asked, factor=limit, reached=True)

    def _most(self, low: Balance, high: float, tolerance: float) -> Balance:
        """The body under as much of the load as it bears with no more than a tolerance; it bears `low`, and not the share `high`."""
        while high > max(CLOSE * low.factor, LEAST):
            middle = 0.5 * (low.factor + high)
            displacement, balanced = self._sought(middle, low.displacement)
            found = self._under(middle, displacement) if balanced else None
            if found is None or found.figures.permanent_set > tolerance:
                high = middle
            else:
                low = found
        return low

    def _sought(self, factor: float, start: Floats) -> tuple[Floats, bool]:
        """A shape that balances a share of the load, or the last one looked at, and whether it does; both [mm], [node_count, 3]."""
        basis, load, shape = self._held.basis, factor * self._load, start
        memory = deque[tuple[Floats, Floats]](maxlen=MEMORY)

        def rest(shape: Floats) -> Floats:
            return np.asarray(basis.T @ (load + self._shaped.forces(self._ordered(shape))[self._held.body.place]).ravel())

        force = rest(shape)
        for _ in range(ROUNDS):
            way = _direction(force, memory, self._held.nearly)
            pull, along = _dot(way, force), (basis @ way).reshape(shape.shape)
            if pull <= ENOUGH**2 * abs(_dot(load.ravel(), shape.ravel())) + self._rounding * float(np.abs(shape).max()) ** 2:
                return shape, True
            if not math.isfinite(pull):
                break
            length, ahead = _length(partial(_at, rest, shape, along), way, pull)
            shape = shape + length * along
            farthest = float(np.linalg.norm(shape, axis=1).max())
            if farthest > self._far:
                return shape * (self._far / farthest), False
            if _dot(way, force - ahead) > 0.0:
                memory.append((length * way, force - ahead))
            force = ahead
        return shape, False

    def _under(self, factor: float, displacement: Floats) -> Balance:
        """What has flowed on the way to a shape, from the one kept, and what stays of it."""
        body, mesh = self._held.body, self._held.body.mesh
        self._shaped.forces(self._ordered(displacement))
        plastic = self._shaped.plastic()
        permanent = self._springback(plastic[..., :FLOW])[0][body.place[: len(mesh.tets.vertices)]]
        in_order = np.empty_like(plastic[0])
        in_order[body.tet_order] = plastic[0]
        figures = measured(mesh.tets, permanent, in_order[..., TENSION], self._density)
        return Balance(factor, displacement, in_order[..., STRAIN], permanent, figures)

    def _stress(self) -> NDArray[np.float32]:
        """Largest stress of the shapes kept so far [MPa], shape [tet_count, points]."""
        found = self._shaped.peak()[0]
        in_order = np.empty_like(found)
        in_order[self._held.body.tet_order] = found
        return in_order

    def _ordered(self, displacement: Floats) -> Floats:
        """The same in the order of computation."""
        ordered = np.empty_like(displacement)
        ordered[self._held.body.place] = displacement
        return ordered


def _density(body: Discretisation) -> Floats | float:
    """Share that is solid at the Gauss points, shape [tet_count, points], in the order of its mesh."""
    if body.relative is None:
        return 1.0
    density = np.empty_like(body.relative.density)
    density[body.tet_order] = body.relative.density
    return density


def tilted(load: Floats) -> Floats:
    """A load [N], shape [node_count, 3], turned by `TILTED` about an axis across the direction that most of it has."""
    _, axes = np.linalg.eigh(load.T @ load)
    return np.asarray(load + TILTED * np.cross(axes[:, :2] @ [0.6, 0.8], load))  # askew, so that it leans to both sides of a section


def _raised(factor: float, first: float) -> float:
    """The next share of a load: with nothing to yield all of it or `MOST` times as much, else a little more."""
    target = 1.0 if factor < 1.0 else MOST
    return target if first >= target else min(max(factor * GROWS, first, LEAST), target)


def _direction(force: Floats, memory: deque[tuple[Floats, Floats]], nearly: Callable[[Floats], Floats]) -> Floats:
    """Where a force drives a body, by its elastic stiffness and by how forces fell along the last steps (Nocedal 1980)."""
    left, shares = force, list[float]()
    for step, fall in reversed(memory):
        shares.append(_dot(step, left) / _dot(step, fall))
        left = left - shares[-1] * fall
    way = nearly(left)
    for step, fall in memory:
        way = way + (shares.pop() - _dot(fall, way) / _dot(step, fall)) * step
    return way


def _length(rest: Callable[[float], Floats], way: Floats, pull: float) -> tuple[float, Floats]:
    """How far to go along a way until the force along it, `pull` at first, has nearly gone, and the force that is left there."""
    length, low, high = 1.0, (0.0, pull), None
    for left in reversed(range(TRIES)):
        ahead = rest(length)
        along = _dot(way, ahead)
        if abs(along) <= TAKEN * pull or not left:
            break
        if along > 0.0:
            low = (length, along)
        else:
            high = (length, along if math.isfinite(along) else -pull)
        length = 3.0 * length if high is None else low[0] + (high[0] - low[0]) * low[1] / (low[1] - high[1])
    return length, ahead


def _dot(one: Floats, other: Floats) -> float:
    """Their inner product, without BLAS, whose threads sum in another order and wait for each other."""
    return float(np.einsum("i,i->", one, other))


def _at(rest: Callable[[Floats], Floats], shape: Floats, along: Floats, length: float) -> Floats:
    return rest(shape + length * along)
