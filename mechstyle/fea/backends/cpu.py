"""The drop test on CPU cores: a job is one drop (`simd_by_element`) or eight side by side (`simd_by_drop`), and a core does one job."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechstyle._warp import wp
from mechstyle.fea.backends import simd_by_drop, simd_by_element
from mechstyle.fea.backends.simd_state import LaneBody, LaneScheme, LaneState
from mechstyle.fea.discretisation import Discretisation
from mechstyle.fea.elasticity import ElasticLaw
from mechstyle.fea.explicit import QUANTITIES, RECORD_EVERY, Scheme, Starts, cores, law_number
from mechstyle.records.mesh import Floats

ONE_BY_ONE = 6
"""Drops that a core does one by one faster than eight lanes of drops, filled or not: lanes are 1.2 times as fast as drops alone …"""
LANES_UP_TO = 20_000
"""… up to so many nodes. The state of eight drops of more lies too far from the core, and lanes are no faster even if all are filled."""


class CoreBody:
    """A discretised body in both layouts, shared by the drops of all orientations."""

    def __init__(self, body: Discretisation) -> None:
        self.tet_count, self.node_count = len(body.volumes), len(body.masses)
        self.points = body.mesh.element.points
        self.corners = 4 if self.points > 1 else 0
        geometry = np.concatenate([body.gradients.reshape(-1, 9), body.volumes[:, None]], axis=1).astype(np.float32)
        padding = ((0, -self.tet_count % simd_by_element.LANES), (0, 0))
        nodes = (_cpu(body.masses.astype(np.float32)), _cpu(_rows(body.arms)))
        self.by_drop = _lane_body(body.connectivity, geometry, nodes, self.tet_count)
        nodes_of, geometry = (_transposed(np.pad(table, padding), simd_by_element.LANES) for table in (body.connectivity, geometry))
        self.by_tet = _lane_body(nodes_of, geometry, nodes, -(-self.tet_count // simd_by_element.LANES))
        for module in (simd_by_element, simd_by_drop):
            wp.load_module(module, device="cpu")

    def internal_forces(
        self, law: ElasticLaw, displacement: Floats, velocity: Floats | float = 0.0, damping: Floats | float = 0.0
    ) -> Floats:
        """As `elasticity.internal_forces` of u + β v, β [ms] of each tetrahedron, in float32 [N], shape [node_count, 3]."""
        state = LaneState()
        state.u, state.v = _cpu(_rows(displacement)), _cpu(_rows(np.broadcast_to(velocity, displacement.shape)))
        state.forces = _zeros(4 * self.node_count)
        state.peak_squared = _zeros(self.points * simd_by_element.LANES * self.by_tet.blocks)
        scheme = LaneScheme()
        scheme.law, scheme.mu, scheme.la, scheme.damping = law_number(law), law.mu, law.la, self.damping_by_tet(damping)
        wp.launch(simd_by_element.forces_only, dim=1, inputs=[self.by_tet, state, scheme], device="cpu")
        return state.forces.numpy().reshape(-1, 4)[:, :3].astype(np.float64)

    def damping_by_tet(self, damping: Floats | float) -> Any:
        """β of each tetrahedron, those of the last block that fill it up included."""
        each = np.broadcast_to(np.float32(damping), self.tet_count)
        return _cpu(np.pad(each, (0, -self.tet_count % simd_by_element.LANES)))

    def batches(self, scheme: Scheme, starts: Starts) -> list[CoreDrop | CoreDrops]:
        """Jobs of eight orientations each; a small remainder, and all of a large body, runs one per job."""
        count = len(starts)
        rest = count % (simd_by_drop.LANES * cores())
        together = count - (rest if rest <= ONE_BY_ONE * cores() else 0) if self.node_count <= LANES_UP_TO else 0
        parts = [slice(first, min(first + simd_by_drop.LANES, together)) for first in range(0, together, simd_by_drop.LANES)]
        jobs: list[CoreDrop | CoreDrops] = [CoreDrops(self, scheme, starts.of(part)) for part in parts]
        return jobs + [CoreDrop(self, scheme, starts.of(slice(index, index + 1))) for index in range(together, count)]


class CoreDrop:
    """One orientation, a `Batch` of one.

    Args:
        body: The body.
        scheme: The step.
        start: Where it starts, a single one.
    """

    count = 1

    def __init__(self, body: CoreBody, scheme: Scheme, start: Starts) -> None:
        self.body, self.scheme, self.done = body, scheme, 0
        self.state = _state(start.heights[0].astype(np.float32), _rows(start.displacements[0]), _rows(start.velocities[0]))
        self.state.peak_squared, self.state.corners_squared = (
            _zeros(places * simd_by_element.LANES * body.by_tet.blocks) for places in (body.points, body.corners)
        )
        self.state.samples = _zeros(scheme.samples * len(QUANTITIES))
        self.step = _step(scheme, start.normals[0], body.damping_by_tet(scheme.damping))

    def advance(self, samples: int) -> None:
        """Take `samples` strides and samples; Warp releases the interpreter lock meanwhile."""
        arguments = [self.body.by_tet, self.state, self.step, self.done, samples, self.scheme.stride, RECORD_EVERY]
        wp.launch(simd_by_element.strides, dim=1, inputs=arguments, device="cpu")
        self.done += samples

    def history(self, first: int, last: int) -> Floats:
        """Samples from one to another, shape [samples, QUANTITIES, 1]."""
        return self.state.samples.numpy().reshape(-1, len(QUANTITIES), 1)[first:last].astype(np.float64)

    def peak(self) -> NDArray[np.float32]:
        """Running maximum of the von Mises stress at the Gauss points [MPa], shape [1, tet_count, points]."""
        return self._root(self.state.peak_squared, self.body.points)

    def corners(self) -> NDArray[np.float32]:
        """The same at the corners [MPa], shape [1, tet_count, 4]."""
        return self._root(self.state.corners_squared, 4) if self.body.corners else _constant(self.peak())

    def forget_peak(self) -> None:
        """Begin the running maxima of the stress anew."""
        self.state.peak_squared.zero_()
        self.state.corners_squared.zero_()

    def pays(self, going: int) -> bool:
        """Whether its one drop goes on."""
        return going == self.count

    def motion(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Displacement since the start [mm] and velocity [mm/ms] of each node, each of shape [1, node_count, 3]."""
        u, v = (field.numpy().reshape(1, -1, 4)[..., :3].copy() for field in (self.state.u, self.state.v))
        return u, v

    def touched(self) -> NDArray[np.bool_]:
        """Whether each node has met the floor, shape [1, node_count]."""
        return np.asarray(self.state.impulse.numpy()[None] > 0.0)

    def _root(self, squares: Any, places: int) -> NDArray[np.float32]:
        """Square roots of what lies in blocks of tetrahedra, shape [1, tet_count, places]."""
        blocks = squares.numpy().reshape(-1, places, simd_by_element.LANES)
        return np.sqrt(blocks.transpose(0, 2, 1).reshape(1, -1, places)[:, : self.body.tet_count])


class CoreDrops:
    """Up to eight orientations side by side, a `Batch`; unused SIMD lanes repeat the last orientation.

    Args:
        body: The body.
        scheme: The step.
        starts: Where they start.
    """

    def __init__(self, body: CoreBody, scheme: Scheme, starts: Starts) -> None:
        self.body, self.scheme, self.done, self.count = body, scheme, 0, len(starts)
        lanes = np.minimum(np.arange(simd_by_drop.LANES), self.count - 1)
        fields = (starts.heights, starts.displacements, starts.velocities)
        each = [np.moveaxis(field[lanes], 0, -1).astype(np.float32).ravel() for field in fields]
        self.state = _state(*each)
        self.state.peak_squared, self.state.corners_squared = (
            _zeros(body.tet_count * places * simd_by_drop.LANES) for places in (body.points, body.corners)
        )
        self.state.samples = _zeros(scheme.samples * len(QUANTITIES) * simd_by_drop.LANES)
        self.step = _step(scheme, starts.normals[lanes].T, _cpu(scheme.damping.astype(np.float32)))

    def advance(self, samples: int) -> None:
        """Take `samples` strides and samples; Warp releases the interpreter lock meanwhile."""
        arguments = [self.body.by_drop, self.state, self.step, self.done, samples, self.scheme.stride, RECORD_EVERY]
        wp.launch(simd_by_drop.strides_of_drops, dim=1, inputs=arguments, device="cpu")
        self.done += samples

    def history(self, first: int, last: int) -> Floats:
        """Samples from one to another, shape [samples, QUANTITIES, orientations]."""
        return self._lanes(self.state.samples, len(QUANTITIES))[first:last].astype(np.float64)

    def peak(self) -> NDArray[np.float32]:
        """Running maximum of the von Mises stress at the Gauss points [MPa], shape [orientations, tet_count, points]."""
        return np.sqrt(np.moveaxis(self._lanes(self.state.peak_squared, self.body.points), -1, 0))

    def corners(self) -> NDArray[np.float32]:
        """The same at the corners [MPa], shape [orientations, tet_count, 4]."""
        if not self.body.corners:
            return _constant(self.peak())
        return np.sqrt(np.moveaxis(self._lanes(self.state.corners_squared, 4), -1, 0))

    def forget_peak(self) -> None:
        """Begin the running maxima of the stress anew."""
        self.state.peak_squared.zero_()
        self.state.corners_squared.zero_()

    def pays(self, going: int) -> bool:
        """Whether so many of its drops are done together faster than one by one."""
        return going > ONE_BY_ONE

    def motion(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Displacement since the start [mm] and velocity [mm/ms] of each node, each of shape [orientations, node_count, 3]."""
        u, v = (np.ascontiguousarray(np.moveaxis(self._lanes(field, 3), -1, 0)) for field in (self.state.u, self.state.v))
        return u, v

    def touched(self) -> NDArray[np.bool_]:
        """Whether each node has met the floor, shape [orientations, node_count]."""
        return np.asarray(self._lanes(self.state.impulse, 1)[:, 0].T > 0.0)

    def _lanes(self, values: Any, width: int) -> NDArray[np.float32]:
        """An array as [item, quantity, orientation], without the lanes to spare."""
        return np.asarray(values.numpy().reshape(-1, width, simd_by_drop.LANES)[..., : self.count])


def _constant(peak: NDArray[np.float32]) -> NDArray[np.float32]:
    """The one stress of linear tetrahedra at their four corners, shape [orientations, tet_count, 4]."""
    return np.repeat(peak, 4, axis=2)


def _lane_body(nodes_of: NDArray[Any], geometry: NDArray[Any], nodes: tuple[Any, Any], blocks: int) -> Any:
    """A body in blocks; axis 1 of `nodes_of` counts the nodes of an element, `nodes` are masses and arms."""
    body = LaneBody()
    body.nodes, body.blocks = nodes_of.shape[1], blocks
    body.nodes_of, body.geometry, body.masses = _cpu(nodes_of.astype(np.int32).ravel()), _cpu(geometry.ravel()), nodes[0]
    body.arms = nodes[1]
    return body


def _state(heights: NDArray[np.float32], displacement: NDArray[np.float32], velocity: NDArray[np.float32]) -> Any:
    """Drops where they start."""
    state = LaneState()
    state.heights, state.u, state.v = _cpu(heights), _cpu(displacement), _cpu(velocity)
    state.forces = _zeros(len(velocity))
    state.impulse, state.contact_loss = _zeros(len(heights)), _zeros(len(heights))
    return state


def _step(scheme: Scheme, normals: Floats, damping: Any) -> Any:
    """The scheme as the kernels read it, β in the order of the blocks."""
    step = LaneScheme()
    step.law, step.mu, step.la = scheme.law_number, scheme.law.mu, scheme.law.la
    step.time_step, step.damping, step.gravity, step.friction = scheme.time_step, damping, scheme.gravity, scheme.friction
    step.normals, step.across = _cpu(normals.astype(np.float32).ravel()), wp.vec3f(*scheme.across)
    return step


def _transposed(table: NDArray[Any], lanes: int) -> NDArray[Any]:
    """[tetrahedron][quantity] as [block][quantity][lane]."""
    return np.ascontiguousarray(table.reshape(-1, lanes, table.shape[1]).transpose(0, 2, 1))


def _rows(vectors: Floats) -> NDArray[np.float32]:
    """Vectors as rows x, y, z, 0 of float32, flat."""
    return np.pad(vectors, ((0, 0), (0, 1))).astype(np.float32).ravel()


def _cpu(values: NDArray[Any]) -> Any:
    """A Warp array with a copy of `values`."""
    return wp.array(values, device="cpu")


def _zeros(count: int) -> Any:
    """A Warp array of float32 zeros."""
    return wp.zeros(count, dtype=wp.float32, device="cpu")
