"""What stays bent: the shape that a plastic strain leaves of a free body, and one figure for it, the permanent set.

A plastic strain ε_p alone loads a body as the stress C : ε_p would: K u = ∫ Bᵀ C ε_p (the springback step of metal forming). Of u, without
motion as a whole, the measure is the length that more than a small volume of the part exceeds. A largest value has no meaning where
contact is a point or a corner is sharp: it grows with every finer mesh. What a given volume exceeds does not: a singular peak holds no
volume (the stressed-volume methods of fatigue: Kuguel 1961; Sonsino and Fischer 2005).
"""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from mechstyle.errors import SimulationFailed
from mechstyle.fea.discretisation import Discretisation
from mechstyle.fea.linear_solvers import FreeBody
from mechstyle.records.mesh import Bools, Floats, TetMesh
from mechstyle.records.simulation import Place

VOLUME, SHARE = 8.0, 0.01
"""What has to be bent for it to count: a cube of 2 mm [mm³], and of a small part no more than this share."""

STEPS = 50
"""Bisections of a value: enough for single precision."""

APART = 1e-6
"""Least difference between the corner values of a tetrahedron, over the largest: the volume above a level divides by it."""


class Measured(NamedTuple):
    """What stays of a test.

    Attributes:
        permanent_set: Displacement that more than `measured_volume` of the part exceeds [mm].
        where: A place of the largest piece that does [mm].
        plastic_strain: The plastic strain in tension that as much of the part exceeds.
    """

    permanent_set: float
    where: Place
    plastic_strain: float


class Springback:
    """Finds the shape that plastic flow leaves of a body on which nothing acts; what it needs of the body is prepared once."""

    def __init__(self, discretisation: Discretisation) -> None:
        self._body = discretisation

    def __call__(self, flow: ArrayLike) -> Floats:
        """Displacement without motion as a whole [mm], shape [states, node_count, 3]; exactly zero where nothing flowed.

        `flow` is A = C_p⁻¹ − I of each state as xx yy zz xy yz zx, shape [states, tet_count, points, 6]. All is in the order of
        computation of the discretisation. SimulationFailed if the equations cannot be solved.
        """
        states = np.asarray(flow)
        if not np.isfinite(states).all():
            raise SimulationFailed("what stays bent could not be found: what flowed is not a finite number")
        displacement = np.zeros((len(states), len(self._body.masses), 3))
        bent = [number for number, state in enumerate(states) if state.any()]
        if bent:
            loads = np.stack([self._loads(states[number]).ravel() for number in bent])
            displacement[bent] = self._free.displacement(loads).reshape(len(bent), -1, 3)
        return displacement

    @cached_property
    def _free(self) -> FreeBody:
        return FreeBody(self._body)

    def _loads(self, flow: NDArray[np.floating]) -> Floats:
        """Loads f = Σ V/points (C : ε_p) ∇N of one state [N], shape [node_count, 3]."""
        body, element = self._body, self._body.stiffness.element
        tets = np.flatnonzero(flow.any(axis=(1, 2)))
        strain, material = plastic_strain(flow[tets]), body.stiffness.material
        spherical = material.lame_lambda * np.einsum("tpii->tp", strain)[..., None, None] * np.eye(3)
        stress = (spherical + 2.0 * material.shear_modulus * strain) * body.point_volumes[tets][..., None, None]
        by_barycentric = element.derivatives[..., 1:] - element.derivatives[..., :1]  # by L_1, L_2, L_3, of which L_0 is the rest
        shares = np.einsum("tpxy,paj,tjy->tax", stress, by_barycentric, body.gradients[tets], optimize=True)
        nodes, count = body.connectivity[tets].ravel(), len(body.masses)
        return np.stack([np.bincount(nodes, shares[..., axis].ravel(), count) for axis in range(3)], axis=1)


def plastic_strain(flow: NDArray[np.floating]) -> Floats:
    """Logarithmic plastic strain ε_p = −½ ln(I + A), shape [..., 3, 3], of A as xx yy zz xy yz zx, shape [..., 6]."""
    strain = np.zeros((*flow.shape[:-1], 3, 3))
    there = flow.any(axis=-1)
    values, axes = np.linalg.eigh(flow[there].astype(np.float64)[:, [[0, 3, 5], [3, 1, 4], [5, 4, 2]]])
    with np.errstate(invalid="ignore", divide="ignore"):  # of what is no plastic strain; its loads are not finite and are refused
        strain[there] = (axes * (-0.5 * np.log1p(values))[:, None, :]) @ axes.swapaxes(1, 2)
    return strain


def measured_volume(tets: TetMesh) -> float:
    """The volume that has to exceed a value for it to count [mm³]."""
    return min(VOLUME, SHARE * float(tets.volumes.sum()))


def measured(tets: TetMesh, displacement: ArrayLike, tension_strain: ArrayLike, density: Floats | float = 1.0) -> Measured:
    """The figures of a test, by what it leaves.

    Args:
        tets: The part.
        displacement: What stays of it at its vertices [mm], shape [vertex_count, 3].
        tension_strain: Plastic strain gathered in tension at the Gauss points, shape [tet_count, points].
        density: Share that is solid at the Gauss points, shape [tet_count, points], as only that counts.
    """
    volume = measured_volume(tets)
    solid = density if np.ndim(density) == 0 else np.mean(density, axis=1)
    length, where = exceeded(tets, np.linalg.norm(np.asarray(displacement, np.float64), axis=1), volume, solid)
    return Measured(length, where, quantile(tension_strain, tets.volumes, volume, density))


def quantile(values: ArrayLike, volumes: Floats, volume: float, density: Floats | float = 1.0) -> float:
    """The value that more than a volume [mm³] exceeds or reaches; the least if there is no more than that volume.

    `values` are at the Gauss points, [tet_count, points], each of which stands for its share of the tetrahedron, of `volumes` [tet_count],
    by as much of it as is solid, `density`, [tet_count, points].
    """
    points = np.asarray(values, np.float64)
    order = np.argsort(-points, axis=None)
    shares = np.repeat(volumes[:, None] / points.shape[1], points.shape[1], axis=1) * density
    held = np.cumsum(shares.ravel()[order])
    return float(points.ravel()[order[min(int(np.searchsorted(held, volume, side="right")), len(order) - 1)]])


def exceeded(tets: TetMesh, nodal: ArrayLike, volume: float, density: Floats | float = 1.0) -> tuple[float, Place]:
    """The value that more than a volume [mm³] exceeds, and a place in the largest piece of it, near its centre [mm].

    It is the smallest value if the part has no more than that volume. `nodal` are the values at its vertices, shape [vertex_count], between
    which they are linear in each tetrahedron; of a tetrahedron as much counts as is solid, `density`, shape [tet_count].
    """
    values = np.sort(np.asarray(nodal, np.float64)[tets.tets], axis=1)
    if not np.isfinite(values).all():
        return float("nan"), (0.0, 0.0, 0.0)
    volumes = density * tets.volumes
    low, high = float(values.min()), float(values.max())
    for _ in range(STEPS):
        middle = 0.5 * (low + high)
        reached = values[:, 3] > middle
        more = float((volumes[reached] * share_above(values[reached], middle)).sum()) > volume
        low, high = (middle, high) if more else (low, middle)
    there = values[:, 3] >= low
    return high, _middle(tets, there, volumes[there] * share_above(values[there], low))


def _middle(tets: TetMesh, which: Bools, held: Floats) -> Place:
    """The tetrahedron nearest to the centre of the largest connected piece: the centre of a rim that is bent all round lies in the air.

    `which` are the tetrahedra it is sought in, [tet_count], `held` how much of each counts [mm³].
    """
    some = tets.tets[which]
    ends = (np.repeat(some[:, 0], 3), some[:, 1:].ravel())
    links = coo_array((np.ones(len(ends[0])), ends), shape=(len(tets.vertices),) * 2)
    piece = connected_components(links, directed=False)[1][some[:, 0]]
    largest = piece == np.bincount(piece, held).argmax()
    middles, weights = tets.vertices[some[largest]].mean(axis=1), held[largest]
    centre = np.average(middles, axis=0, weights=weights if weights.sum() > 0.0 else None)
    x, y, z = middles[np.linalg.norm(middles - centre, axis=1).argmin()]
    return float(x), float(y), float(z)


def share_above(values: Floats, level: float) -> Floats:
    """Share of each tetrahedron in which a linear field is above a level, shape [n], by its values at the corners, ascending, shape [n, 4].

    The share below is the divided difference of (level − f)₊³ over the corner values f (Curry and Schoenberg 1966).
    """
    gap = APART * np.maximum(np.abs(values).max(axis=1, keepdims=True, initial=0.0), 1e-30) * np.arange(4)
    apart = np.maximum.accumulate(values - gap, axis=1) + gap
    a, b, c, d = apart.T
    below, above = level <= a, level >= d
    first = np.clip(level - a, 0.0, None) ** 3 / ((b - a) * (c - a) * (d - a))
    second = np.clip(level - b, 0.0, None) ** 3 / ((b - a) * (c - b) * (d - b))
    last = np.clip(d - level, 0.0, None) ** 3 / ((d - a) * (d - b) * (d - c))
    share: NDArray[np.float64] = np.where(level < c, 1.0 - first + second, last)
    return np.where(below, 1.0, np.where(above, 0.0, np.clip(share, 0.0, 1.0)))
