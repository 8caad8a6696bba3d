"""The drop test: a body touches a rigid floor at the speed of its fall, in one or many orientations at once."""

from __future__ import annotations

import logging
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mechstyle._warp import wp
from mechstyle.errors import BadInput, MissingPiece
from mechstyle.fea.backends.cpu import CoreBody
from mechstyle.fea.backends.gpu import DeviceBody
from mechstyle.fea.discretisation import Discretisation, discretise
from mechstyle.fea.elasticity import LAWS, element_frequencies, law_named
from mechstyle.fea.elements import element_named
from mechstyle.fea.explicit import (
    QUANTITIES,
    RECORD_EVERY,
    Batch,
    Body,
    Progress,
    Scheme,
    failing,
    integrate,
    no_progress,
    total_energy,
)
from mechstyle.fea.stable_step import damped_step
from mechstyle.records.material import Material
from mechstyle.records.mesh import Floats, TetMesh, frozen_array

logger = logging.getLogger(__name__)

GRAVITY = 9.81e-3
"""Standard gravity [mm/ms²]."""

SAMPLES = 120
"""Samples of the history per drop, about: enough to see a bounce, a few per cent of the work."""

MAX_STEPS = 1_000_000
"""Steps beyond which a drop would take hours: a sliver has slipped through, and no answer is better than none tonight."""

Law = Literal["stable_neo_hookean", "st_venant_kirchhoff"]


@dataclass(frozen=True)
class DropTest:
    """Height, window and numerical settings of a drop test.

    Attributes:
        height: Height of fall [mm].
        friction: Coulomb coefficient of the floor.
        window: Simulated time after first touch [ms].
        damping: Share ξ of the critical damping of each tetrahedron: with ω_e its own largest frequency, stress is that of the
            displacement u + β_e v, β_e = 2 ξ/ω_e.
        law: Elastic law, one of `elasticity.LAWS`.
        element: "tet10", or "tet4" as in the published study: linear tetrahedra lock, in a one-layer wall to a sixth of its deflection.
        added_mass: Most mass that may be added to slivers to lengthen the step, over the mass of the part.
        safety: Time step over a limit that is stable for certain at small strain.
        across: Normal of printed layers over their share of the strength, n / r; zero for a material without layers. What is recorded as
            von Mises stress is then `elasticity.equivalent_stress`.
    """

    height: float = 1500.0
    friction: float = 0.0
    window: float = 1.5
    damping: float = 0.1
    law: Law = "stable_neo_hookean"
    element: str = "tet10"
    added_mass: float = 0.01
    safety: float = 0.95
    across: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        """Refuse values no drop test has, naming the value and the range."""
        limits = {"height": (1.0, 1e5), "friction": (0.0, 2.0), "window": (1e-3, 50.0), "damping": (0.0, 1.0), "added_mass": (0.0, 0.1),
                  "safety": (0.05, 2.0)}
        for field, (low, high) in limits.items():
            value = getattr(self, field)
            if not low <= value <= high:
                raise BadInput(f"drop test: {field.replace('_', ' ')} is {value:g}, but must lie between {low:g} and {high:g}")
        if self.law not in LAWS:
            raise BadInput(f"drop test: unknown elastic law {self.law!r}, known are {', '.join(LAWS)}")
        element_named(self.element)

    @property
    def speed(self) -> float:
        """Speed at first touch, sqrt(2 g h) [mm/ms = m/s]."""
        return math.sqrt(2.0 * GRAVITY * self.height)


@dataclass(frozen=True, eq=False)
class History:
    """Energies and forces over a drop; arrays over samples and orientations have shape [samples, orientations].

    Energy is conserved: kinetic + strain + contact_loss + damping_loss − gravity_work is what it was at first touch.

    Attributes:
        time: Time since first touch [ms], shape [samples].
        kinetic: Kinetic energy [mJ].
        strain: Strain energy half a step earlier, where velocity is [mJ].
        gravity_work: Work done by weight since first touch [mJ].
        contact_loss: Kinetic energy taken by the floor since first touch: impact of lumped masses and friction [mJ].
        damping_loss: What is missing then, the energy dissipated in the material and the error of the integration [mJ];
            without damping the error alone, some 1e-5 of the energy at first touch.
        peak_stress: Largest von Mises stress in the part at that moment [MPa].
        contact_force: Mean normal force of the floor since the sample before [N].
        momentum: Momentum along the floor normal, negative while falling [g mm/ms = mN s].
    """

    time: Floats
    kinetic: Floats
    strain: Floats
    gravity_work: Floats
    contact_loss: Floats
    damping_loss: Floats
    peak_stress: Floats
    contact_force: Floats
    momentum: Floats


@dataclass(frozen=True, eq=False)
class Drop:
    """Result of a drop test.

    Attributes:
        von_mises: Running maximum of the von Mises stress at the Gauss points [MPa], shape [orientations, tet_count, points];
            infinite if it failed.
        corners: The same at the corners of the tetrahedra [MPa], shape [orientations, tet_count, 4].
        contact: Whether a vertex met the floor, shape [orientations, vertex_count].
        time_step: Δt [ms].
        steps: Steps per orientation.
        added_mass: Mass added to slivers, over the mass of the part.
        history: Energies and forces over time, up to the failure if there was one.
        failure: Why there is no usable answer, "" if there is.
    """

    von_mises: NDArray[np.float32]
    corners: NDArray[np.float32]
    contact: NDArray[np.bool_]
    time_step: float
    steps: int
    added_mass: float
    history: History
    failure: str = ""

    def __post_init__(self) -> None:
        """Freeze the fields over the mesh."""
        for name, places in (("von_mises", None), ("corners", 4)):
            object.__setattr__(self, name, frozen_array(getattr(self, name), np.float32, (None, None, places), name))
        object.__setattr__(self, "contact", frozen_array(self.contact, np.bool_, (len(self.von_mises), None), "contact"))


def drop(
    tets: TetMesh,
    material: Material,
    directions: ArrayLike,
    test: DropTest = DropTest(),
    *,
    device: str = "auto",
    progress: Progress = no_progress,
) -> Drop:
    """Drop a body onto a rigid floor in every given orientation and follow it through the window.

    Args:
        tets: The body [mm].
        material: Its material.
        directions: Floor normals in the frame of the body, pointing out of the floor, shape [orientations, 3].
        test: Height, window and numerical settings.
        device: "cpu", "cuda", "cuda:1", … or "auto": CUDA if there is a device.
        progress: Called now and then in the calling thread with the fraction done; may raise to cancel.

    Raises:
        BadInput: Unusable tetrahedra, directions or device name.
        MissingPiece: CUDA was asked for and is not there.
    """
    normals = _unit(directions)
    where = resolve_device(device)
    discretisation = discretise(tets, material, test.added_mass, element_named(test.element))
    body = body_on(where, discretisation)
    scheme = scheme_for(discretisation, material, test)
    heights = discretisation.positions @ normals.T
    batches = body.batches(scheme, normals, heights - heights.min(axis=0))
    samples, failure = _first_touch(discretisation, scheme, len(normals)), _too_long(discretisation, material, scheme)
    if not failure:
        energy = float(samples[0, QUANTITIES.index("kinetic"), 0])
        samples = np.concatenate([samples, integrate(batches, scheme, energy, progress)])
        failure = _failure(samples, scheme, energy)
    return _drop(tets, discretisation, scheme, batches, samples, failure)


def body_on(where: str, discretisation: Discretisation) -> Body:
    """The body where it is computed; plain kernels, five times slower, on a processor whose vector code cannot be compiled."""
    if where == "cpu":
        try:
            return CoreBody(discretisation)
        except Exception:  # noqa: BLE001 - Warp raises a bare Exception when its compiler fails
            logger.warning("the vectorised drop test cannot be compiled for this processor; the plain one is used, which is slower")
    return DeviceBody(discretisation, where)


def available_devices() -> list[str]:
    """Names of the devices a drop can run on, "cpu" first."""
    return ["cpu", *(str(device) for device in wp.get_cuda_devices())]


def resolve_device(device: str) -> str:
    """A device Warp knows, for "auto" or a name; MissingPiece if it is not there."""
    if device == "auto":
        return "cuda:0" if wp.get_cuda_device_count() else "cpu"
    if device != "cpu" and not device.startswith("cuda"):
        raise BadInput(f"unknown device {device!r}: known are 'auto', 'cpu', 'cuda', 'cuda:0', 'cuda:1', …")
    try:
        return str(wp.get_device(device))
    except (ValueError, RuntimeError) as error:
        raise MissingPiece(f"device {device!r} is not there; use 'cpu' or 'auto', or install an NVIDIA driver") from error


def scheme_for(discretisation: Discretisation, material: Material, test: DropTest) -> Scheme:
    """Step and sampling of a test: whole strides fill the window exactly, so that all meshes see the same time."""
    law = law_named(test.law, material)
    step, damping = damped_step(discretisation, material, test.damping)
    steps = math.ceil(test.window / (test.safety * step))
    stride = RECORD_EVERY * math.ceil(steps / (RECORD_EVERY * SAMPLES))
    samples = math.ceil(steps / stride)
    return Scheme(law, test.window / (samples * stride), damping, GRAVITY, test.friction, test.speed, stride, samples, test.across)


def _first_touch(discretisation: Discretisation, scheme: Scheme, orientations: int) -> Floats:
    """The sample before the first step, shape [1, QUANTITIES, orientations]."""
    sample = np.zeros((1, len(QUANTITIES), orientations))
    mass = discretisation.masses.sum()
    sample[:, QUANTITIES.index("kinetic")] = 0.5 * mass * scheme.speed**2
    sample[:, QUANTITIES.index("momentum")] = -mass * scheme.speed
    return sample


def _too_long(discretisation: Discretisation, material: Material, scheme: Scheme) -> str:
    """Why the drop is not worth starting, "" if it is."""
    if scheme.steps <= MAX_STEPS:
        return ""
    tets = discretisation.mesh.tets
    stiffest = int(np.argmax(element_frequencies(tets, material)))
    x, y, z = tets.vertices[tets.tets[stiffest]].mean(axis=0)
    return (
        f"the drop test would need {scheme.steps} steps of {1e3 * scheme.time_step:.2g} µs because of a sliver at"
        f" ({x:.1f}, {y:.1f}, {z:.1f}) mm: mesh the part again"
    )


def _unit(directions: ArrayLike) -> Floats:
    """Directions of length one, shape [orientations, 3]; BadInput if there is none or one has no direction."""
    normals = np.array(directions, dtype=np.float64)
    if normals.ndim != 2 or normals.shape[1] != 3 or len(normals) == 0:
        raise BadInput(f"drop directions must have shape (orientations, 3), not {normals.shape}")
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    if not (np.isfinite(lengths).all() and (lengths > 1e-9).all()):
        raise BadInput("a drop direction is zero or not finite: give vectors that point out of the floor")
    return normals / lengths


def _drop(
    tets: TetMesh, discretisation: Discretisation, scheme: Scheme, batches: Sequence[Batch], samples: Floats, failure: str
) -> Drop:
    """Bring the results back to the caller's numbering; a failed drop has no stress but infinity."""
    von_mises, corners = (
        _in_callers_order(np.concatenate(recorded), discretisation, failure)
        for recorded in ([batch.peak() for batch in batches], [batch.corners() for batch in batches])
    )
    contact = np.zeros((len(von_mises), len(tets.vertices)), dtype=bool)
    touched = np.concatenate([batch.touched() for batch in batches])
    contact[:, discretisation.vertices] = touched[:, discretisation.place[: len(discretisation.vertices)]]
    finite = np.logical_and.accumulate(np.isfinite(samples).all(axis=(1, 2)))
    history = _history(samples[finite], scheme)
    return Drop(von_mises, corners, contact, scheme.time_step, scheme.steps, discretisation.added_mass, history, failure)


def _in_callers_order(stress: NDArray[np.float32], discretisation: Discretisation, failure: str) -> NDArray[np.float32]:
    """Stress in the order of computation, shape [orientations, tet_count, n], in the caller's; infinite if the drop failed."""
    ordered = np.full_like(stress, np.inf)
    if not failure:
        ordered[:, discretisation.tet_order] = stress
    return ordered


def _history(samples: Floats, scheme: Scheme) -> History:
    """Physical quantities from the sums of the kernels."""
    interval = scheme.stride * scheme.time_step
    of = {name: samples[:, place] for place, name in enumerate(QUANTITIES)}
    energy = total_energy(samples, scheme)
    return History(
        time=interval * np.arange(len(samples), dtype=np.float64),
        kinetic=of["kinetic"],
        strain=of["strain"],
        gravity_work=-scheme.gravity * of["height"],
        contact_loss=of["contact_loss"],
        damping_loss=energy[0] - energy,
        peak_stress=np.sqrt(of["peak_squared"]),
        contact_force=np.diff(of["impulse"], axis=0, prepend=0.0) / interval,
        momentum=of["momentum"],
    )


def _failure(samples: Floats, scheme: Scheme, energy: float) -> str:
    """Why a drop cannot be trusted: not finite, or more energy than fall and weight put in; "" if it can."""
    bad = failing(samples, scheme, energy)
    if not bad.any():
        return ""
    row, orientation = (int(index) for index in np.argwhere(bad)[0])
    time, step = row * scheme.stride * scheme.time_step, 1e3 * scheme.time_step
    place = f"in orientation {orientation} at {time:.3f} ms"
    if not np.isfinite(samples[row, :, orientation]).all():
        return f"the drop test broke down {place}: its state is no longer finite (time step {step:.3g} µs)"
    growth = total_energy(samples, scheme)[row, orientation] / energy
    return f"the drop test is unstable {place}: its energy grew {growth:.3g} times (time step {step:.3g} µs)"
