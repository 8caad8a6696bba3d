"""Explicit time integration of several drops of one body: state in device arrays, stepped without the host looking on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from mechstyle.fea import kernels
from mechstyle.fea.discretisation import Discretisation
from mechstyle.fea.elasticity import LAWS, ElasticLaw, StableNeoHookean
from mechstyle.mesh import Floats

RECORD_EVERY = 4
"""Steps between updates of the running maximum; a stress wave crosses an element in several steps."""


@dataclass(frozen=True)
class Scheme:
    """What one step does to every orientation.

    Attributes:
        law: The elastic law.
        time_step: Δt [ms].
        damping: Kelvin–Voigt time β [ms].
        gravity: g [mm/ms²].
        friction: Coulomb coefficient of the floor.
        speed: Speed at first touch [mm/ms].
        stride: Steps between two samples of the history, a multiple of RECORD_EVERY.
        samples: Samples of the whole drop.
    """

    law: ElasticLaw
    time_step: float
    damping: float
    gravity: float
    friction: float
    speed: float
    stride: int
    samples: int


def law_number(law: ElasticLaw) -> int:
    """How the kernels know a law."""
    return LAWS.index("stable_neo_hookean" if isinstance(law, StableNeoHookean) else "st_venant_kirchhoff")


class DeviceBody:
    """The discretised body as float32 arrays on a device."""

    def __init__(self, body: Discretisation, device: str) -> None:
        self.device = device
        self.tet_count, self.vertex_count = len(body.tets.tets), len(body.tets.vertices)
        self.tets = wp.array(body.tets.tets, dtype=wp.vec4i, device=device)
        self.gradients = wp.array(body.gradients.astype(np.float32), dtype=wp.mat33f, device=device)
        self.volumes = wp.array(body.tets.volumes.astype(np.float32), dtype=float, device=device)
        self.masses = wp.array(body.masses.astype(np.float32), dtype=float, device=device)
        self.first_corner = wp.array(body.first_corner, dtype=int, device=device)
        self.corners = wp.array(body.corners, dtype=int, device=device)

    @property
    def elements(self) -> list[Any]:
        """The arguments with which element kernels begin."""
        return [self.tets, self.gradients, self.volumes]


class Batch:
    """Drops in several orientations, advanced together by the portable kernels.

    Args:
        body: The body, on the device.
        scheme: The step.
        normals: Floor normals in the frame of the body, shape [orientations, 3].
        heights: Height of every vertex above the floor at first touch [mm], shape [vertex_count, orientations].
    """

    def __init__(self, body: DeviceBody, scheme: Scheme, normals: Floats, heights: Floats) -> None:
        self.body, self.scheme, self.count = body, scheme, len(normals)
        device, vertices, count = body.device, body.vertex_count, len(normals)
        start = np.broadcast_to(-scheme.speed * normals, (vertices, count, 3)).astype(np.float32)
        self.normals = wp.array(normals.astype(np.float32), dtype=wp.vec3f, device=device)
        self.heights = wp.array(heights.astype(np.float32), dtype=float, device=device)
        self.v = wp.array(start, dtype=wp.vec3f, device=device)
        self.u = wp.zeros((vertices, count), dtype=wp.vec3f, device=device)
        self.w = wp.zeros((vertices, count), dtype=wp.vec3f, device=device)
        self.forces = wp.zeros((body.tet_count, 4, count), dtype=wp.vec3f, device=device)
        self.peak_squared = wp.zeros((body.tet_count, count), dtype=float, device=device)
        self.impulse = wp.zeros((vertices, count), dtype=float, device=device)
        self.contact_loss = wp.zeros((vertices, count), dtype=float, device=device)
        self.parts = wp.zeros((kernels.QUANTITIES, int(kernels.PARTS), count), dtype=float, device=device)
        self.samples = wp.zeros((scheme.samples, kernels.QUANTITIES, count), dtype=float, device=device)
        self.row = wp.zeros(1, dtype=int, device=device)
        self._graph: Any = None

    def advance(self, samples: int) -> None:
        """Take `samples` times `stride` steps, each run of steps followed by a sample; the host does not wait."""
        for _ in range(samples):
            if wp.get_device(self.body.device).is_cuda:
                self._replay()
            else:
                self._stride()

    def history(self, samples: int) -> Floats:
        """The first samples, waiting until they are there, shape [samples, QUANTITIES, orientations]."""
        return np.asarray(self.samples.numpy()[:samples], dtype=np.float64)

    def peak(self) -> NDArray[np.float32]:
        """Running maximum of the von Mises stress [MPa], shape [orientations, tet_count]."""
        return np.ascontiguousarray(np.sqrt(self.peak_squared.numpy()).T)

    def touched(self) -> NDArray[np.bool_]:
        """Whether each vertex has met the floor, shape [orientations, vertex_count]."""
        return np.ascontiguousarray(self.impulse.numpy().T > 0.0)

    def _replay(self) -> None:
        """A stride as one CUDA graph: thousands of launches otherwise cost more than the work in them."""
        if self._graph is None:
            wp.load_module(kernels, device=self.body.device)
            with wp.ScopedCapture(device=self.body.device) as capture:
                self._stride()
            self._graph = capture.graph
        wp.capture_launch(self._graph)

    def _stride(self) -> None:
        for step in range(self.scheme.stride):
            self._step(record=step % RECORD_EVERY == 0)
        self._sample()

    def _step(self, *, record: bool) -> None:
        scheme, body = self.scheme, self.body
        constants = [law_number(scheme.law), scheme.law.mu, scheme.law.la]
        arguments = [*body.elements, self.w, *constants, int(record), self.forces, self.peak_squared]
        wp.launch(kernels.element_forces, dim=(body.tet_count, self.count), inputs=arguments, device=body.device)
        numbers = [scheme.time_step, scheme.damping, scheme.gravity, scheme.friction]
        arguments = [self.forces, body.first_corner, body.corners, body.masses, self.heights, self.normals, *numbers]
        arguments += [self.u, self.v, self.w, self.impulse, self.contact_loss]
        wp.launch(kernels.advance, dim=(body.vertex_count, self.count), inputs=arguments, device=body.device)

    def _sample(self) -> None:
        scheme, body = self.scheme, self.body
        constants = [law_number(scheme.law), scheme.law.mu, scheme.law.la, scheme.damping]
        arguments = [*body.elements, body.masses, self.normals, *constants, self.u, self.v, self.impulse, self.contact_loss, self.parts]
        wp.launch(kernels.sample_parts, dim=(int(kernels.PARTS), self.count), inputs=arguments, device=body.device)
        total = [self.parts, self.row, self.samples]
        wp.launch(kernels.sample_total, dim=(kernels.QUANTITIES, self.count), inputs=total, device=body.device)
        wp.launch(kernels.next_row, dim=1, inputs=[self.row], device=body.device)


def largest_frequency(body: DeviceBody, masses: Floats, law: ElasticLaw, iterations: int = 60) -> float:
    """Largest eigenfrequency ω of M⁻¹K [rad/ms] by power iteration with the element kernel itself, from a fixed start.

    The estimate comes from below, by less than 1 % after 60 iterations on the meshes tried; the safety factor of the time
    step covers it. Displacements are at most 1e-4 of the smallest tetrahedron, where the law is linear.
    """
    root = np.sqrt(masses)[:, None]
    mode = np.random.default_rng(0).standard_normal((len(masses), 3)) / root
    forces = wp.zeros((body.tet_count, 4, 1), dtype=wp.vec3f, device=body.device)
    total = wp.zeros((body.vertex_count, 1), dtype=wp.vec3f, device=body.device)
    peak = wp.zeros((body.tet_count, 1), dtype=float, device=body.device)
    small, frequency2 = 1e-4 * np.cbrt(body.volumes.numpy().min()), 0.0
    for _ in range(iterations):
        mode *= small / np.abs(mode).max()
        w = wp.array(mode[:, None].astype(np.float32), dtype=wp.vec3f, device=body.device)
        arguments = [*body.elements, w, law_number(law), law.mu, law.la, 0, forces, peak]
        wp.launch(kernels.element_forces, dim=(body.tet_count, 1), inputs=arguments, device=body.device)
        gather = [forces, body.first_corner, body.corners, total]
        wp.launch(kernels.gather_forces, dim=(body.vertex_count, 1), inputs=gather, device=body.device)
        image = -total.numpy()[:, 0].astype(np.float64) / root**2
        frequency2 = float(np.linalg.norm(root * image) / np.linalg.norm(root * mode))
        mode = image
    return float(np.sqrt(frequency2))
