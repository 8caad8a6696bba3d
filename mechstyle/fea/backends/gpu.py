"""The drop test on a GPU: all orientations step together, a stride of steps is one CUDA graph.

The same code runs on any device Warp knows; that is how it is tested where there is no GPU.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechstyle._warp import wp
from mechstyle.fea.backends import kernels, sampling_kernels
from mechstyle.fea.discretisation import Discretisation
from mechstyle.fea.elasticity import ElasticLaw
from mechstyle.fea.explicit import QUANTITIES, RECORD_EVERY, STATE, Scheme, Starts, law_number, limits
from mechstyle.records.mesh import Floats

BLOCK = 64
"""Threads in a block: few enough that a single drop of 10k tetrahedra is spread over all multiprocessors."""


class DeviceBody:
    """A discretised body as float32 arrays on a device."""

    def __init__(self, body: Discretisation, device: str) -> None:
        self.device = device
        self.tet_count, self.node_count = len(body.volumes), len(body.masses)
        self.element = body.mesh.element
        self.element_forces = kernels.linear_forces if self.element.nodes == 4 else kernels.quadratic_forces
        self.masses, self.arms = self.array(body.masses, float), self.array(body.arms, wp.vec3f)
        numbers = (body.connectivity, body.slots, body.first_slot)
        nodes, self.slots, self.first_slot = (wp.array(values, dtype=int, device=device) for values in numbers)
        self.elements = [nodes, self.array(body.gradients, wp.mat33f), self.array(body.point_volumes, float)]
        self.relative = body.relative
        for module in (kernels, sampling_kernels):
            wp.load_module(module, device=device)

    def array(self, values: NDArray[np.floating], dtype: Any) -> Any:
        """A float32 array of Warp type `dtype` on the device."""
        return wp.array(np.ascontiguousarray(values, dtype=np.float32), dtype=dtype, device=self.device)

    def zeros(self, *shape: int, dtype: Any = float) -> Any:
        """A zero array on the device."""
        return wp.zeros(shape, dtype=dtype, device=self.device)

    def launch(self, kernel: Any, dim: tuple[int, ...], *arguments: Any) -> None:
        """Queue a kernel."""
        wp.launch(kernel, dim=dim, inputs=arguments, device=self.device, block_dim=BLOCK)

    def forces_and_peak(self, orientations: int) -> tuple[Any, Any]:
        """Arrays the element kernels write: nodal forces by slot, running maximum of the stress at the Gauss points."""
        forces = self.zeros(self.tet_count * self.element.nodes, orientations, dtype=wp.vec3f)
        return forces, self.zeros(self.tet_count, self.element.points, orientations)

    def internal_forces(
        self, law: ElasticLaw, displacement: Floats, velocity: Floats | float = 0.0, damping: Floats | float = 0.0
    ) -> Floats:
        """Forces f_a = −Σ V P ∇N_a of u + β v, β [ms] of each tetrahedron, in float32 [N], shape [node_count, 3]."""
        fields = (displacement, np.broadcast_to(velocity, displacement.shape))
        ahead = (self.of_tets(damping), *(self.array(field[:, None], wp.vec3f) for field in fields))
        total = self.zeros(self.node_count, 1, dtype=wp.vec3f)
        forces, peak = self.forces_and_peak(1)
        constants = (law_number(law), law.mu, law.la, wp.vec3f(), self.limits(math.inf, 0.0))
        outcome = (0, forces, self.zeros(0), self.zeros(0, 0, 0, 0), peak)
        self.launch(self.element_forces, (self.tet_count, 1), *self.elements, self.slots, *ahead, *constants, *outcome)
        self.launch(kernels.gather_forces, (self.node_count, 1), forces, self.first_slot, total)
        return np.asarray(total.numpy()[:, 0], dtype=np.float64)

    def of_tets(self, values: Floats | float) -> Any:
        """A number of each tetrahedron."""
        return self.array(np.broadcast_to(values, self.tet_count), float)

    def limits(self, strength: float, hardening: float) -> Any:
        """The `explicit.limits` of each Gauss point."""
        shape = (self.tet_count, self.element.points, 3)
        return self.array(np.broadcast_to(limits(strength, hardening, self.relative), shape), wp.vec3f)

    def batches(self, scheme: Scheme, starts: Starts) -> list[DeviceBatch]:
        """All orientations together."""
        return [DeviceBatch(self, scheme, starts)]

    def shaped(self, scheme: Scheme) -> DeviceShaped:
        """The body as it is before anything flows."""
        return DeviceShaped(self, scheme)


class _OnDevice:
    """Bodies on their way, a `State`.

    Args:
        body: The body.
        scheme: The step.
        starts: Where they start.
    """

    def __init__(self, body: DeviceBody, scheme: Scheme, starts: Starts) -> None:
        self.body, self.scheme, self.count = body, scheme, len(starts)
        each_node = (body.node_count, self.count)
        self.normals, self.heights = body.array(starts.normals, wp.vec3f), body.array(starts.heights.T, float)
        self.u, self.v = (body.array(np.swapaxes(field, 0, 1), wp.vec3f) for field in (starts.displacements, starts.velocities))
        self.damping, self.limits = body.of_tets(scheme.damping), body.limits(scheme.yield_strength, scheme.hardening)
        self.by_slot, self.peak_squared = body.forces_and_peak(self.count)
        self.shares, self.flowed = body.of_tets(scheme.shares), self._flowed(starts.plastic)
        self.impulse, self.contact_loss = body.zeros(*each_node), body.zeros(*each_node)
        self.parts = body.zeros(len(QUANTITIES), int(sampling_kernels.PARTS), self.count)
        self.groups = body.zeros(len(QUANTITIES), int(sampling_kernels.GROUPS), self.count)
        self.samples = body.zeros(scheme.samples, len(QUANTITIES), self.count)
        self.row = body.zeros(1, dtype=int)
        self._graph: Any = None

    @property
    def constants(self) -> tuple[Any, ...]:
        """Of the material, as the kernels take them."""
        scheme, law = self.scheme, self.scheme.law
        return scheme.law_number, law.mu, law.la, wp.vec3f(*scheme.across), self.limits

    def history(self, first: int, last: int) -> Floats:
        """Samples from one to another, waiting until they are there, shape [samples, QUANTITIES, orientations]."""
        return np.asarray(self.samples[first:last].numpy(), dtype=np.float64)

    def peak(self) -> NDArray[np.float32]:
        """Running maximum of the stress at the Gauss points [MPa], shape [orientations, tet_count, points]."""
        return np.ascontiguousarray(np.moveaxis(np.sqrt(self.peak_squared.numpy()), -1, 0))

    def plastic(self) -> NDArray[np.float32]:
        """What has flowed, shape [orientations, tet_count, points, STATE]; of an elastic body nothing."""
        return np.ascontiguousarray(np.moveaxis(self.flowed.numpy(), -1, 0))

    def forget_peak(self) -> None:
        """Begin the running maximum of the stress anew."""
        self.peak_squared.zero_()

    def motion(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Displacement since the start [mm] and velocity [mm/ms] of each node, each of shape [orientations, node_count, 3]."""
        u, v = (np.ascontiguousarray(np.swapaxes(field.numpy(), 0, 1)) for field in (self.u, self.v))
        return u, v

    def _flowed(self, before: NDArray[np.float32] | None) -> Any:
        """What has flowed as [tetrahedron][point][number][orientation], without numbers for an elastic body."""
        body = self.body
        if before is None or not self.scheme.yields:
            return body.zeros(body.tet_count, body.element.points, STATE if self.scheme.yields else 0, self.count)
        return body.array(np.moveaxis(before, 0, -1), float)

    def _element_forces(self, record: int) -> None:
        body = self.body
        ahead, outcome = (self.damping, self.u, self.v), (record, self.by_slot, self.shares, self.flowed, self.peak_squared)
        body.launch(body.element_forces, (body.tet_count, self.count), *body.elements, body.slots, *ahead, *self.constants, *outcome)


class DeviceBatch(_OnDevice):
    """Drops in several orientations, a `Batch`."""

    def advance(self, samples: int) -> None:
        """Queue `samples` strides and samples, on CUDA as replays of one graph: thousands of launches would cost more than the work."""
        for _ in range(samples):
            if not wp.get_device(self.body.device).is_cuda:
                self._stride()
                continue
            if self._graph is None:
                with wp.ScopedCapture(device=self.body.device) as capture:
                    self._stride()
                self._graph = capture.graph
            wp.capture_launch(self._graph)

    def pays(self, going: int) -> bool:
        """Whether so many of its drops are worth their share of it; drops that are packed anew need a new graph."""
        return 2 * going > self.count

    def touched(self) -> NDArray[np.bool_]:
        """Whether each node has met the floor, shape [orientations, node_count]."""
        return np.ascontiguousarray(self.impulse.numpy().T > 0.0)

    def _stride(self) -> None:
        body, scheme = self.body, self.scheme
        for step in range(scheme.stride):
            self._element_forces(record=int(step % RECORD_EVERY == 0))
            self._advance_nodes()
        parts, motion = (int(sampling_kernels.PARTS), self.count), (self.u, self.v)
        inputs = (*body.elements, *self.constants, scheme.time_step, *motion, self.shares, self.flowed, self.parts)
        body.launch(sampling_kernels.sample_elements, parts, *inputs)
        sums = (self.impulse, self.contact_loss, self.parts)
        body.launch(sampling_kernels.sample_nodes, parts, body.masses, self.normals, *motion, *sums)
        body.launch(sampling_kernels.sample_motion, parts, body.masses, body.arms, *motion, self.parts)
        body.launch(sampling_kernels.sample_groups, self.groups.shape, self.parts, self.groups)
        body.launch(sampling_kernels.sample_total, (len(QUANTITIES), self.count), self.groups, self.row, self.samples)
        body.launch(sampling_kernels.next_row, (1,), self.row)

    def _advance_nodes(self) -> None:
        body, scheme = self.body, self.scheme
        given = (self.by_slot, body.first_slot, body.masses, self.heights, self.normals)
        numbers = (scheme.time_step, scheme.gravity, scheme.friction)
        state = (self.u, self.v, self.impulse, self.contact_loss)
        if scheme.contact_stiffness:
            body.launch(kernels.advance_on_penalty, (body.node_count, self.count), *given, *numbers, scheme.contact_stiffness, *state)
        else:
            body.launch(kernels.advance, (body.node_count, self.count), *given, *numbers, *state)


class DeviceShaped(_OnDevice):
    """One body that is put into one shape after another, a `Shaped`."""

    def __init__(self, body: DeviceBody, scheme: Scheme) -> None:
        super().__init__(body, scheme, Starts.at_rest(body.node_count))
        self.kept, self.total = wp.clone(self.flowed), body.zeros(body.node_count, 1, dtype=wp.vec3f)

    def forces(self, displacement: Floats) -> Floats:
        """Internal forces [N] after the flow to a shape from the one kept, both of shape [node_count, 3]."""
        self._take(displacement, record=0)
        self.body.launch(kernels.gather_forces, (self.body.node_count, 1), self.by_slot, self.body.first_slot, self.total)
        return np.asarray(self.total.numpy()[:, 0], dtype=np.float64)

    def keep(self, displacement: Floats) -> None:
        """Let the flow to a shape have happened, and take its stress into the running maximum."""
        self._take(displacement, record=1)
        wp.copy(self.kept, self.flowed)

    def _take(self, displacement: Floats, record: int) -> None:
        wp.copy(self.flowed, self.kept)
        self.u.assign(displacement.astype(np.float32)[:, None])
        self._element_forces(record)
