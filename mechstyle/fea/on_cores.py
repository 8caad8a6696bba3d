"""The drop test on CPU cores: one drop is one job, computed by the vectorised kernels of `lanes`."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechstyle.fea import lanes
from mechstyle.fea.discretisation import Discretisation
from mechstyle.fea.elasticity import ElasticLaw
from mechstyle.fea.integration import QUANTITIES, RECORD_EVERY, Scheme, law_number
from mechstyle.mesh import Floats
from mechstyle.quiet import wp


class CoreBody:
    """A discretised body in blocks of LANES tetrahedra, shared by the drops of all orientations."""

    def __init__(self, body: Discretisation) -> None:
        tet_count = len(body.tets.tets)
        blocks = -(-tet_count // lanes.LANES)
        tets = np.zeros((blocks * lanes.LANES, 4), dtype=np.int32)
        tets[:tet_count] = body.tets.tets
        geometry = np.zeros((blocks * lanes.LANES, 10), dtype=np.float32)
        geometry[:tet_count, :9] = body.gradients.reshape(tet_count, 9)
        geometry[:tet_count, 9] = body.tets.volumes
        self.tet_count, self.vertex_count, self.padded_count = tet_count, len(body.tets.vertices), len(tets)
        self.arguments = lanes.LaneBody()
        self.arguments.tets = _cpu(_transposed(tets))
        self.arguments.geometry = _cpu(_transposed(geometry))
        self.arguments.masses = _cpu(body.masses.astype(np.float32))
        wp.load_module(lanes, device="cpu")

    def internal_forces(self, law: ElasticLaw, displacement: Floats) -> Floats:
        """As `elasticity.internal_forces`, in float32 [N], shape [vertex_count, 3]."""
        state = lanes.LaneState()
        state.w = _cpu(_rows(displacement))
        state.forces = _zeros(4 * self.vertex_count)
        state.peak_squared = _zeros(self.padded_count)
        scheme = lanes.LaneScheme()
        scheme.law, scheme.mu, scheme.la = law_number(law), law.mu, law.la
        wp.launch(lanes.forces_only, dim=1, inputs=[self.arguments, state, scheme], device="cpu")
        return state.forces.numpy().reshape(-1, 4)[:, :3].astype(np.float64)

    def batches(self, scheme: Scheme, normals: Floats, heights: Floats) -> list[CoreDrop]:
        """One drop per orientation, at first touch."""
        return [CoreDrop(self, scheme, normal, heights[:, index]) for index, normal in enumerate(normals)]


class CoreDrop:
    """One orientation, a `Batch` of one.

    Args:
        body: The body.
        scheme: The step.
        normal: Floor normal in the frame of the body, shape [3].
        heights: Height of every vertex above the floor at first touch [mm], shape [vertex_count].
    """

    def __init__(self, body: CoreBody, scheme: Scheme, normal: Floats, heights: Floats) -> None:
        self.body, self.scheme, self.done = body, scheme, 0
        count = body.vertex_count
        state = lanes.LaneState()
        state.heights = _cpu(heights.astype(np.float32))
        state.u, state.w, state.forces = _zeros(4 * count), _zeros(4 * count), _zeros(4 * count)
        state.v = _cpu(_rows(np.broadcast_to(-scheme.speed * normal, (count, 3))))
        state.impulse, state.contact_loss = _zeros(count), _zeros(count)
        state.peak_squared = _zeros(body.padded_count)
        state.samples = _zeros(scheme.samples * len(QUANTITIES))
        step = lanes.LaneScheme()
        step.law, step.mu, step.la, step.normal = scheme.law_number, scheme.law.mu, scheme.law.la, wp.vec3f(*normal)
        step.time_step, step.damping, step.gravity, step.friction = scheme.time_step, scheme.damping, scheme.gravity, scheme.friction
        self.state, self.step = state, step

    def advance(self, samples: int) -> None:
        """Take `samples` strides and samples; Warp releases the interpreter lock meanwhile."""
        arguments = [self.body.arguments, self.state, self.step, self.done, samples, self.scheme.stride, RECORD_EVERY]
        wp.launch(lanes.strides, dim=1, inputs=arguments, device="cpu")
        self.done += samples

    def history(self, samples: int) -> Floats:
        """The first samples, shape [samples, QUANTITIES, 1]."""
        return self.state.samples.numpy().reshape(-1, len(QUANTITIES), 1)[:samples].astype(np.float64)

    def peak(self) -> NDArray[np.float32]:
        """Running maximum of the von Mises stress [MPa], shape [1, tet_count]."""
        return np.sqrt(self.state.peak_squared.numpy()[None, : self.body.tet_count])

    def touched(self) -> NDArray[np.bool_]:
        """Whether each vertex has met the floor, shape [1, vertex_count]."""
        return np.asarray(self.state.impulse.numpy()[None] > 0.0)


def _transposed(table: NDArray[Any]) -> NDArray[Any]:
    """[tetrahedron][quantity] as [block][quantity][lane], flat."""
    return np.ascontiguousarray(table.reshape(-1, lanes.LANES, table.shape[1]).transpose(0, 2, 1)).ravel()


def _rows(vectors: Floats) -> NDArray[np.float32]:
    """Vectors as rows x, y, z, 0 of float32, flat."""
    return np.pad(vectors, ((0, 0), (0, 1))).astype(np.float32).ravel()


def _cpu(values: NDArray[Any]) -> Any:
    """A Warp array with a copy of `values`."""
    return wp.array(values, device="cpu")


def _zeros(count: int) -> Any:
    """A Warp array of float32 zeros."""
    return wp.zeros(count, dtype=wp.float32, device="cpu")
