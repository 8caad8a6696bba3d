"""EXPERIMENTAL, and no part of the loop: how the peak stress of a short drop changes when vertices move.

The derivative is that of the discrete drop itself, by Warp's reverse mode through all its steps. What is differentiated stands for
the largest ball average, a maximum over places and time that has no useful derivative, by means of order p:

    m = (mean over time of σ_vM^p)^(1/p)     at each Gauss point, over the recorded steps
    a = 2 mm ball average of m               that of `ball_average`, which decides where parts touch the floor
    smooth peak = (mean over the volume of a^p)^(1/p)

A mean of order p is never above the maximum, so the smooth peak bounds the peak from below, peak ≥ smooth peak, and approaches it
as p grows. The other way, peak ≤ smooth peak · (T V / V_min)^(1/p) for T recorded steps, volume V and the smallest tetrahedron's share
V_min of it. Being a mean, it does not grow merely because a mesh gets finer or a step shorter.

Rest positions enter through ∇L, volumes, masses and the height above the floor. Held fixed: time step, damping and mass scaling,
which places are neighbours, and which vertex touches first (where several are lowest this is one of several derivatives).

Contact opens and closes, so the derivative holds nearby only: on a pen holder it agrees with differences to 0.1 % over 0.1 µm and to
3 % over 1 µm. Nearly all of it lies on the few vertices that touch first.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mechstyle._warp import wp
from mechstyle.errors import BadInput, SimulationFailed
from mechstyle.fea.ball_average import BallAverage
from mechstyle.fea.discretisation import Discretisation, discretise
from mechstyle.fea.drop import DropTest, resolve_device, scheme_for
from mechstyle.fea.elements import EDGES, ElementMesh, element_named
from mechstyle.fea.explicit import RECORD_EVERY, Scheme
from mechstyle.fea.sensitivity import kernels
from mechstyle.records.material import Material
from mechstyle.records.mesh import Floats, Indices, TetMesh

SHORT = DropTest(window=0.05)
"""The first touch and the first waves; what comes later is not differentiated well, contact opening and closing many times."""

LEAST_EXPONENT, MOST_EXPONENT = 8.0, 64.0
MOST_STEPS = 5000
"""Every step is kept for the way back, some megabytes each."""


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """The smooth peak and its derivative.

    Attributes:
        smooth_peak: Bound of the peak from below [MPa].
        gradient: ∂(smooth peak)/∂(vertex) [MPa/mm], shape [vertex_count, 3]; zero for vertices no tetrahedron uses.
    """

    smooth_peak: float
    gradient: Floats


class SmoothPeak(BallAverage):
    """The mean of order p of ball averages, and its derivative."""

    def evaluated(self, tets: TetMesh, mean_power: Floats, exponent: float) -> tuple[float, Floats, Floats]:
        """The smooth peak over `tets`, a morph of the mesh the operator was made for.

        Args:
            tets: The body.
            mean_power: Mean over time of σ_vM^p, in any unit of stress, shape [tet_count, points].
            exponent: p.

        Returns:
            The smooth peak in that unit, and its derivatives by `mean_power` and the volumes, shapes [tet_count, points] and [tet_count].
        """
        in_time = mean_power ** (1.0 / exponent)
        averages = self(tets, in_time)
        weights = np.broadcast_to(tets.volumes[:, None] / tets.volumes.sum() / averages.shape[1], averages.shape)
        highest = max(float(averages.max()), np.finfo(np.float64).tiny)
        relative = averages / highest
        mean = float((weights * relative**exponent).sum())
        smooth = highest * mean ** (1.0 / exponent)
        by_average = smooth / (highest * mean) * weights * relative ** (exponent - 1.0)
        by_weight = smooth / (exponent * mean) * (relative**exponent - mean) * weights
        by_time, by_volume = self._backward(tets, in_time, averages, by_average)
        by_power = np.divide(by_time * in_time, exponent * mean_power, out=np.zeros_like(mean_power), where=mean_power > 0.0)
        return smooth, by_power, by_volume + by_weight.sum(axis=1) / tets.volumes

    def _backward(self, tets: TetMesh, values: Floats, averages: Floats, seed: Floats) -> tuple[Floats, Floats]:
        """Derivatives by values and volumes from `seed`, that by the averages. Beside the tip of a notch neighbours are not mutual."""
        interpolate = self._from_gauss(values.shape[1])
        weights = np.repeat(tets.volumes, averages.shape[1])
        share = seed.ravel() / (self._near @ weights)
        spread = np.asarray(self._near.T @ share)
        by_weight = spread * (values @ interpolate.T).ravel() - self._near.T @ (share * averages.ravel())
        return (weights * spread).reshape(averages.shape) @ interpolate, by_weight.reshape(averages.shape).sum(axis=1)


class ShortDrop:
    """A drop whose smoothed peak stress can be differentiated with respect to the vertex positions.

    Args:
        tets: The body [mm]; step, mass scaling and neighbours are its, also for vertices given later.
        material: Its material.
        direction: Floor normal in the frame of the body, out of the floor, shape [3].
        test: The drop; each of its steps is kept for the way back.
        exponent: Order p of the means, 8 to 64.
        device: As for `drop.drop`.

    Raises:
        BadInput: Unusable tetrahedra, direction or device name, an order out of range, or a window of too many steps.
        MissingPiece: CUDA was asked for and is not there.
    """

    def __init__(
        self,
        tets: TetMesh,
        material: Material,
        direction: ArrayLike,
        test: DropTest = SHORT,
        *,
        exponent: float = 16.0,
        device: str = "auto",
    ) -> None:
        if not LEAST_EXPONENT <= exponent <= MOST_EXPONENT:
            raise BadInput(f"smooth peak: the exponent is {exponent:g}, but must lie between {LEAST_EXPONENT:g} and {MOST_EXPONENT:g}")
        self.tets, self.test, self.exponent, self.device = tets, test, exponent, resolve_device(device)
        self._normal, self._unit = _unit(direction), material.yield_strength
        body = discretise(tets, material, test.added_mass, element_named(test.element))
        self.scheme: Scheme = scheme_for(body, material, test)
        if self.scheme.steps > MOST_STEPS:
            raise BadInput(f"a gradient keeps every step and this drop has {self.scheme.steps}, more than {MOST_STEPS}: shorten its window")
        self._vertices, self._average = body.vertices, SmoothPeak(body.mesh.tets)
        self._tables = _Tables(body, material.density, self.device)
        self._damping = self._tables.by_tet(self.scheme.damping)

    @property
    def node_count(self) -> int:
        """Nodes, each of which keeps its motion at every step."""
        return self._tables.node_count

    def smooth_peak(self, vertices: ArrayLike | None = None) -> float:
        """The smooth peak with the vertices there [mm], shape [vertex_count, 3], or as they were [MPa]."""
        return self._followed(self._placed(vertices), backward=False).smooth_peak

    def sensitivity(self, vertices: ArrayLike | None = None) -> Sensitivity:
        """The smooth peak with the vertices there [mm], shape [vertex_count, 3], or as they were, and its derivative by them.

        SimulationFailed if the drop or its derivative is not finite.
        """
        return self._followed(self._placed(vertices), backward=True)

    def _placed(self, vertices: ArrayLike | None) -> TetMesh:
        """The body in the numbering of the drop; BadInput if a tetrahedron is flat or inverted."""
        tets = self.tets if vertices is None else self.tets.moved(np.asarray(vertices, dtype=np.float64))
        used = TetMesh(tets.vertices[self._vertices], np.searchsorted(self._vertices, tets.tets).astype(np.int32))
        if not (used.volumes > 0.0).all():
            raise BadInput("moved like this, a tetrahedron has no positive volume: move the vertices less")
        return used

    def _followed(self, tets: TetMesh, *, backward: bool) -> Sensitivity:
        """Forward through the drop and, if wanted, back."""
        positions = wp.array(tets.vertices, dtype=wp.vec3d, device=self.device, requires_grad=backward)
        tape = wp.Tape()
        if backward:
            with tape:
                volumes, powers = self._forward(positions, tets)
        else:
            volumes, powers = self._forward(positions, tets)
        mean_power = powers.numpy() / (self.scheme.steps // RECORD_EVERY)
        if not np.isfinite(mean_power).all():
            raise SimulationFailed("the short drop broke down: its stress is no longer finite")
        relative, by_power, by_volume = self._average.evaluated(tets, mean_power, self.exponent)
        gradient = np.zeros_like(self.tets.vertices)
        if backward:
            by_power = by_power / (self.scheme.steps // RECORD_EVERY)
            tape.backward(grads={powers: self._float64(self._unit * by_power), volumes: self._float64(self._unit * by_volume)})
            gradient[self._vertices] = positions.grad.numpy()
        if not np.isfinite(gradient).all():
            raise SimulationFailed("the derivative of the short drop is not finite")
        return Sensitivity(self._unit * relative, gradient)

    def _forward(self, positions: Any, tets: TetMesh) -> tuple[Any, Any]:
        """Volumes [mm³] and the sum over time of (σ_vM/unit)^p at the Gauss points; a tape keeps the arrays of all steps, else they go."""
        tables, scheme, law = self._tables, self.scheme, self.scheme.law
        gradients, volumes, masses, heights = tables.shape(positions, self._normal, tets)
        start = np.broadcast_to(-scheme.speed * self._normal, (tables.node_count, 3)).astype(np.float32)
        v = wp.array(start, dtype=wp.vec3f, device=self.device, requires_grad=positions.requires_grad)
        u = tables.zeros(tables.node_count, wp.vec3f, positions)
        powers = tables.zeros((tables.tet_count, tables.points), wp.float64, positions)
        normal, floor = wp.vec3f(*self._normal), (scheme.time_step, scheme.gravity, scheme.friction)
        for step in range(scheme.steps):
            forces, *after = (tables.zeros(tables.node_count, wp.vec3f, positions) for _ in range(3))
            elements = (tables.connectivity, tables.derivatives, gradients, volumes, self._damping, u, v, scheme.law_number, law.mu, law.la)
            record = (int(step % RECORD_EVERY == 0), self._unit, self.exponent)
            wp.launch(
                kernels.element_forces, (tables.tet_count, tables.points), [*elements, *record], [forces, powers], device=self.device
            )
            wp.launch(kernels.advance, tables.node_count, [forces, masses, heights, normal, *floor, u, v], after, device=self.device)
            u, v = after
        return volumes, powers

    def _float64(self, values: Floats) -> Any:
        """A Warp array on the device."""
        return wp.array(values, dtype=wp.float64, device=self.device)


class _Tables:
    """Quantities that do not depend on the vertex positions: connectivity, shape function table, density and mass scaling."""

    def __init__(self, body: Discretisation, density: float, device: str) -> None:
        mesh, element, self._tet_order = body.mesh, body.mesh.element, body.tet_order
        self.device, self.tet_count, self.node_count, self.points = device, len(mesh.connectivity), len(mesh.nodes), element.points
        self.connectivity, self.ends = (wp.array(table, dtype=int, device=device) for table in (mesh.connectivity, _ends(mesh)))
        derivatives = (element.derivatives[..., 1:] - element.derivatives[..., :1]).astype(np.float32)
        self.derivatives = wp.array(derivatives, dtype=wp.vec3f, device=device)
        tables = (body.heavier[body.place], element.mass_shares)
        self.heavier, self.mass_shares = (wp.array(table, dtype=wp.float64, device=device) for table in tables)
        self.density = wp.float64(density)

    def by_tet(self, values: Floats) -> Any:
        """A value of each tetrahedron in the order of computation, in that of the mesh."""
        of_mesh = np.empty(self.tet_count, dtype=np.float32)
        of_mesh[self._tet_order] = values
        return wp.array(of_mesh, dtype=float, device=self.device)

    def zeros(self, shape: int | tuple[int, ...], dtype: Any, like: Any) -> Any:
        """A zero array that has a derivative if `like` has one."""
        return wp.zeros(shape, dtype=dtype, device=self.device, requires_grad=like.requires_grad)

    def shape(self, positions: Any, normal: Floats, tets: TetMesh) -> tuple[Any, Any, Any, Any]:
        """Gradients of L [1/mm], volumes [mm³], masses [g] and heights above the floor [mm]."""
        gradients, volumes = self.zeros(self.tet_count, wp.mat33f, positions), self.zeros(self.tet_count, wp.float64, positions)
        masses, heights = (self.zeros(self.node_count, wp.float32, positions) for _ in range(2))
        given = [self.connectivity, positions, self.density, self.heavier, self.mass_shares]
        wp.launch(kernels.shape, self.tet_count, given, [gradients, volumes, masses], device=self.device)
        lowest = int(np.argmin(tets.vertices @ normal))
        floor = [self.ends, positions, wp.vec3d(*normal), lowest]
        wp.launch(kernels.heights_above_floor, self.node_count, floor, [heights], device=self.device)
        return gradients, volumes, masses, heights


def _ends(mesh: ElementMesh) -> Indices:
    """The two corners each node lies halfway between, shape [node_count, 2]; a corner lies between itself and itself."""
    ends = np.repeat(np.arange(len(mesh.nodes), dtype=np.int32)[:, None], 2, axis=1)
    if mesh.element.nodes > 4:
        ends[mesh.connectivity[:, 4:]] = mesh.tets.tets[:, EDGES]
    return ends


def _unit(direction: ArrayLike) -> NDArray[np.float64]:
    """A direction of length one, shape [3]; BadInput if it has none."""
    normal = np.array(direction, dtype=np.float64)
    length = float(np.linalg.norm(normal))
    if normal.shape != (3,) or not 1e-9 < length < np.inf:
        raise BadInput(f"the drop direction is {direction!r}: give one finite vector (x, y, z) that points out of the floor")
    return normal / length
