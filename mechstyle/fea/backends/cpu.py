"""The drop test on CPU cores: a job is one drop, sixteen tetrahedra at a time (`simd_by_element`), and a core does one job."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechstyle._warp import wp
from mechstyle.fea.backends import simd_by_element
from mechstyle.fea.backends.simd_by_element import LaneBody, LaneScheme, LaneState
from mechstyle.fea.discretisation import Discretisation
from mechstyle.fea.elasticity import ElasticLaw
from mechstyle.fea.explicit import ELASTIC, QUANTITIES, RECORD_EVERY, STATE, Scheme, Starts, law_number, limits
from mechstyle.records.mesh import Floats


class CoreBody:
    """A discretised body in blocks of tetrahedra, shared by the drops of all orientations."""

    def __init__(self, body: Discretisation) -> None:
        self.tet_count, self.node_count = len(body.volumes), len(body.masses)
        self.points = body.mesh.element.points
        geometry = np.concatenate([body.gradients.reshape(-1, 9), body.volumes[:, None]], axis=1).astype(np.float32)
        lanes, nodes = simd_by_element.LANES, body.connectivity.shape[1]
        padded = (np.pad(table, ((0, -self.tet_count % lanes), (0, 0))) for table in (body.connectivity, geometry))
        nodes_of, in_blocks = (np.ascontiguousarray(each.reshape(-1, lanes, each.shape[1]).transpose(0, 2, 1)) for each in padded)
        self.lanes = LaneBody()
        self.lanes.nodes, self.lanes.blocks, self.lanes.cellular = nodes, len(nodes_of), int(body.relative is not None)
        self.relative = body.relative
        self.lanes.nodes_of, self.lanes.geometry = _cpu(nodes_of.astype(np.int32).ravel()), _cpu(in_blocks.ravel())
        self.lanes.masses, self.lanes.arms = _cpu(body.masses.astype(np.float32)), _cpu(_rows(body.arms))
        wp.load_module(simd_by_element, device="cpu")

    def internal_forces(
        self, law: ElasticLaw, displacement: Floats, velocity: Floats | float = 0.0, damping: Floats | float = 0.0
    ) -> Floats:
        """Forces f_a = −Σ V P ∇N_a of u + β v, β [ms] of each tetrahedron, in float32 [N], shape [node_count, 3]."""
        state = LaneState()
        state.u, state.v = _cpu(_rows(displacement)), _cpu(_rows(np.broadcast_to(velocity, displacement.shape)))
        state.forces = _zeros(4 * self.node_count)
        state.peak_squared = _zeros(self.points * simd_by_element.LANES * self.lanes.blocks)
        scheme = LaneScheme()
        scheme.law, scheme.mu, scheme.la, scheme.damping = law_number(law), law.mu, law.la, self.of_tets(damping)
        scheme.limits = self.limits(math.inf, 0.0)
        wp.launch(simd_by_element.forces_only, dim=1, inputs=[self.lanes, state, scheme, 0], device="cpu")
        return state.forces.numpy().reshape(-1, 4)[:, :3].astype(np.float64)

    def of_tets(self, values: Floats | float) -> Any:
        """A number of each tetrahedron, those of the last block that fill it up included."""
        each = np.broadcast_to(np.float32(values), self.tet_count)
        return _cpu(np.pad(each, (0, -self.tet_count % simd_by_element.LANES)))

    def limits(self, strength: float, hardening: float) -> Any:
        """The `explicit.limits` of each Gauss point and its factor on stiffness, as they lie in blocks; nothing for a solid body."""
        if self.relative is None:
            return _zeros(0)
        of = np.concatenate([limits(strength, hardening, self.relative), self.relative.stiffness[..., None]], axis=-1)
        padded = np.pad(of, ((0, -self.tet_count % simd_by_element.LANES), (0, 0), (0, 0)), mode="edge")
        blocks = padded.reshape(-1, simd_by_element.LANES, *padded.shape[1:]).transpose(0, 2, 3, 1)
        return _cpu(np.ascontiguousarray(blocks, dtype=np.float32).ravel())

    def batches(self, scheme: Scheme, starts: Starts) -> list[CoreDrop]:
        """One orientation per job."""
        return [CoreDrop(self, scheme, starts.subset(slice(index, index + 1))) for index in range(len(starts))]

    def shaped(self, scheme: Scheme) -> CoreShaped:
        """The body as it is before anything flows."""
        return CoreShaped(self, scheme)


class _OnCore:
    """One body on its way, a `State` of one.

    Args:
        body: The body.
        scheme: The step.
        start: Where it starts, a single one.
    """

    count = 1

    def __init__(self, body: CoreBody, scheme: Scheme, start: Starts) -> None:
        self.body, self.scheme, self.done = body, scheme, 0
        self.state = _state(start.heights[0].astype(np.float32), _rows(start.displacements[0]), _rows(start.velocities[0]))
        self.state.peak_squared = _zeros(body.points * simd_by_element.LANES * body.lanes.blocks)
        if scheme.yields:
            self.state.plastic, self.state.flowed = self._plastic(start.plastic)
        self.state.samples = _zeros(scheme.samples * len(QUANTITIES))
        self.step = _step(scheme, start.normals[0], body)

    def history(self, first: int, last: int) -> Floats:
        """Samples from one to another, shape [samples, QUANTITIES, 1]."""
        return self.state.samples.numpy().reshape(-1, len(QUANTITIES), 1)[first:last].astype(np.float64)

    def peak(self) -> NDArray[np.float32]:
        """Running maximum of the stress at the Gauss points [MPa], shape [1, tet_count, points]."""
        blocks = self.state.peak_squared.numpy().reshape(-1, self.body.points, simd_by_element.LANES)
        return np.sqrt(blocks.transpose(0, 2, 1).reshape(1, -1, self.body.points)[:, : self.body.tet_count])

    def plastic(self) -> NDArray[np.float32]:
        """What has flowed, shape [1, tet_count, points, STATE]; of an elastic body nothing."""
        body = self.body
        if not self.scheme.yields:
            return np.zeros((1, body.tet_count, body.points, 0), np.float32)
        blocks = self.state.plastic.numpy().reshape(-1, body.points, STATE, simd_by_element.LANES)
        return blocks.transpose(0, 3, 1, 2).reshape(1, -1, body.points, STATE)[:, : body.tet_count].copy()

    def forget_peak(self) -> None:
        """Begin the running maximum of the stress anew."""
        self.state.peak_squared.zero_()

    def motion(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Displacement since the start [mm] and velocity [mm/ms] of each node, each of shape [1, node_count, 3]."""
        u, v = (field.numpy().reshape(1, -1, 4)[..., :3].copy() for field in (self.state.u, self.state.v))
        return u, v

    def _plastic(self, before: NDArray[np.float32] | None) -> tuple[Any, Any]:
        """What has flowed as it lies in blocks, and which blocks have."""
        body, lanes = self.body, simd_by_element.LANES
        if before is None:
            return _zeros(body.points * STATE * lanes * body.lanes.blocks), wp.zeros(body.lanes.blocks, dtype=wp.int32, device="cpu")
        padded = np.pad(before[0], ((0, -body.tet_count % lanes), (0, 0), (0, 0)))
        blocks = np.ascontiguousarray(padded.reshape(-1, lanes, body.points, STATE).transpose(0, 2, 3, 1), dtype=np.float32)
        return _cpu(blocks.ravel()), _cpu(np.any(blocks.reshape(len(blocks), -1), axis=1).astype(np.int32))


class CoreDrop(_OnCore):
    """One orientation, a `Batch` of one."""

    def advance(self, samples: int) -> None:
        """Take `samples` strides and samples; Warp releases the interpreter lock meanwhile."""
        arguments = [self.body.lanes, self.state, self.step, self.done, samples, self.scheme.stride, RECORD_EVERY]
        wp.launch(simd_by_element.strides, dim=1, inputs=arguments, device="cpu")
        self.done += samples

    def pays(self, going: int) -> bool:
        """Whether its one drop goes on."""
        return going == self.count

    def touched(self) -> NDArray[np.bool_]:
        """Whether each node has met the floor, shape [1, node_count]."""
        return np.asarray(self.state.impulse.numpy()[None] > 0.0)


class CoreShaped(_OnCore):
    """One body that is put into one shape after another, a `Shaped`."""

    def __init__(self, body: CoreBody, scheme: Scheme) -> None:
        super().__init__(body, scheme, Starts.at_rest(body.node_count))
        self.kept = wp.clone(self.state.plastic), wp.clone(self.state.flowed)

    def forces(self, displacement: Floats) -> Floats:
        """Internal forces [N] after the flow to a shape from the one kept, both of shape [node_count, 3]."""
        self._take(displacement, record=0)
        return self.state.forces.numpy().reshape(-1, 4)[:, :3].astype(np.float64)

    def keep(self, displacement: Floats) -> None:
        """Let the flow to a shape have happened, and take its stress into the running maximum."""
        self._take(displacement, record=1)
        for kept, found in zip(self.kept, (self.state.plastic, self.state.flowed), strict=True):
            wp.copy(kept, found)

    def _take(self, displacement: Floats, record: int) -> None:
        for kept, found in zip(self.kept, (self.state.plastic, self.state.flowed), strict=True):
            wp.copy(found, kept)
        self.state.u.assign(_rows(displacement))
        self.state.forces.zero_()
        wp.launch(simd_by_element.forces_only, dim=1, inputs=[self.body.lanes, self.state, self.step, record], device="cpu")


def _state(heights: NDArray[np.float32], displacement: NDArray[np.float32], velocity: NDArray[np.float32]) -> Any:
    """A drop where it starts."""
    state = LaneState()
    state.heights, state.u, state.v = _cpu(heights), _cpu(displacement), _cpu(velocity)
    state.forces = _zeros(len(velocity))
    state.impulse, state.contact_loss = _zeros(len(heights)), _zeros(len(heights))
    return state


def _step(scheme: Scheme, normals: Floats, body: CoreBody) -> Any:
    """The scheme as the kernels read it."""
    step = LaneScheme()
    step.law, step.mu, step.la = scheme.law_number, scheme.law.mu, scheme.law.la
    step.yields, step.hardening = int(scheme.yields), scheme.hardening
    step.yield_strength = min(scheme.yield_strength, ELASTIC)
    step.damping, step.shares = body.of_tets(scheme.damping), body.of_tets(scheme.shares)
    step.time_step, step.gravity, step.friction = scheme.time_step, scheme.gravity, scheme.friction
    step.contact_stiffness, step.limits = scheme.contact_stiffness, body.limits(scheme.yield_strength, scheme.hardening)
    step.normals, step.across = _cpu(normals.astype(np.float32).ravel()), wp.vec3f(*scheme.across)
    return step


def _rows(vectors: Floats) -> NDArray[np.float32]:
    """Vectors as rows x, y, z, 0 of float32, flat."""
    return np.pad(vectors, ((0, 0), (0, 1))).astype(np.float32).ravel()


def _cpu(values: NDArray[Any]) -> Any:
    """A Warp array with a copy of `values`."""
    return wp.array(values, device="cpu")


def _zeros(count: int) -> Any:
    """A Warp array of float32 zeros."""
    return wp.zeros(count, dtype=wp.float32, device="cpu")
