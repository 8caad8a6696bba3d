"""The drop test: a body touches the floor at the speed of its fall, in one or many orientations at once; what it leaves over time."""

from __future__ import annotations

import logging
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mechstyle._warp import without_native_stderr, wp
from mechstyle.errors import BadInput, MissingPiece
from mechstyle.fea.backends.cpu import CoreBody
from mechstyle.fea.backends.gpu import DeviceBody
from mechstyle.fea.discretisation import Discretisation, Relative, discretise
from mechstyle.fea.elasticity import element_frequencies, law_named
from mechstyle.fea.elements import element_named
from mechstyle.fea.explicit import (
    FLOW,
    QUANTITIES,
    RECORD_EVERY,
    STATE,
    STRAIN,
    TENSION,
    Body,
    Progress,
    Scheme,
    damped_step,
    no_progress,
    step_shares,
)
from mechstyle.fea.flight import RigidBody
from mechstyle.fea.linear_solvers import lowest_period
from mechstyle.fea.permanent_set import Springback
from mechstyle.fea.phases import QUIET_TIME, Rest, Rule, Track, follow, longest
from mechstyle.records.material import Material
from mechstyle.records.mesh import Floats, Indices, TetMesh, frozen_array

logger = logging.getLogger(__name__)

GRAVITY = 9.81e-3
"""Standard gravity [mm/ms²]."""

SAMPLES = 120
"""Samples of the history in a window, about: enough to see a bounce, a few per cent of the work."""

SAMPLES_PER_PERIOD, LONGEST_INTERVAL = 250, 0.05
"""Samples of a drop without a window, about: in a lowest period, and most time between two [ms]."""

MAX_STEPS = 1_000_000
"""Steps beyond which a drop would take hours: a sliver has slipped through, and no answer is better than none tonight."""

Law = Literal["stable_neo_hookean", "st_venant_kirchhoff"]


@dataclass(frozen=True)
class DropTest:
    """Height, window and numerical settings of a drop test.

    Attributes:
        height: Height of fall [mm].
        friction: Coulomb coefficient of the floor.
        window: Simulated time after first touch [ms]; None, until the impact has ended: see `phases`.
        damping: Share ξ of the critical damping of each tetrahedron: with ω_e its own largest frequency, stress is that of the
            displacement u + β_e v, β_e = 2 ξ/ω_e.
        law: Elastic law, one of `elasticity.LAWS`.
        element: "tet10", or "tet4" as in the published study: linear tetrahedra lock, in a one-layer wall to a sixth of its deflection.
        added_mass: Mass added where it lengthens the step most, over that of the solid part; see `discretisation`. It makes the step 1.3 to
            1.5 times as long as a tenth of it, and moves σ_V by 1 % at most; with 0.01 it would move by up to 4 %.
        quiet: Time without contact after which a phase of the impact is over, over the lowest period of the part.
        safety: Time step over a limit that is stable for certain at small strain. What bends, 0.95 leaves as 0.6 does, within 1 % of ε_p;
            where the stiffest tetrahedra are crushed within 5 %, as they are softer at a long step: see `elasticity.softened`.
        across: Normal of printed layers over their share of the strength, n / r; zero for a material without layers. What is recorded as
            von Mises stress is then `elasticity.equivalent_stress`.
        contact_stiffness: Stiffness of a penalty floor at each node [N/mm], as in the published study; 0 for a rigid floor. A penalty is
            of the mesh, no property of a floor: more nodes that touch carry more.
        plastic: Whether the material flows where it reaches its yield strength; False for an elastic body, as in the published study.
    """

    height: float = 1500.0
    friction: float = 0.0
    window: float | None = None
    damping: float = 0.1
    law: Law = "stable_neo_hookean"
    element: str = "tet10"
    added_mass: float = 0.003
    quiet: float = QUIET_TIME
    safety: float = 0.95
    across: tuple[float, float, float] = (0.0, 0.0, 0.0)
    plastic: bool = True
    contact_stiffness: float = 0.0

    @property
    def speed(self) -> float:
        """Speed at first touch, sqrt(2 g h) [mm/ms = m/s]."""
        return math.sqrt(2.0 * GRAVITY * self.height)


@dataclass(frozen=True, eq=False)
class Drop:
    """Result of a drop test.

    Attributes:
        von_mises: Running maximum of the von Mises stress at the Gauss points [MPa], shape [orientations, tet_count, points]: Kirchhoff's
            of a body that flows, Cauchy's of an elastic one; in a cellular body that of its solid parts. Infinite if the drop failed, as
            are the next three.
        plastic_strain: Equivalent plastic strain ε_p when it was over, of the same shape.
        tension_strain: The part ε_t of it that was gathered in tension, where the mean stress is above −σ_vM/3, of the same shape.
        flow: A = C_p⁻¹ − I then as xx yy zz xy yz zx, shape [orientations, tet_count, points, 6].
        permanent: What stays bent: displacement of the vertices without motion as a whole [mm], shape [orientations, vertex_count, 3]; zero
            for a vertex that no tetrahedron uses.
        contact: Whether a vertex met the floor in any phase, shape [orientations, vertex_count].
        time_step: Δt [ms].
        steps: Steps of the orientation that took most; of a drop that was not started, the least it would take.
        added_mass: Mass added to slivers, over the mass of the part.
        history: Energies and forces over time of each orientation, up to the failure if there was one.
        phases: What was simulated of each orientation.
        endings: Why each orientation was followed no further, in words.
        failure: Why there is no usable answer, "" if there is.
    """

    von_mises: NDArray[np.float32]
    plastic_strain: NDArray[np.float32]
    tension_strain: NDArray[np.float32]
    flow: NDArray[np.float32]
    permanent: NDArray[np.float32]
    contact: NDArray[np.bool_]
    time_step: float
    steps: int
    added_mass: float
    history: tuple[History, ...]
    phases: tuple[tuple[Phase, ...], ...]
    endings: tuple[str, ...]
    failure: str = ""

    def __post_init__(self) -> None:
        """Freeze the fields over the mesh."""
        shape = self.von_mises.shape
        for name in ("von_mises", "plastic_strain", "tension_strain"):
            object.__setattr__(self, name, frozen_array(getattr(self, name), np.float32, shape, name))
        object.__setattr__(self, "flow", frozen_array(self.flow, np.float32, (*shape, FLOW), "flow"))
        object.__setattr__(self, "permanent", frozen_array(self.permanent, np.float32, (shape[0], None, 3), "permanent"))
        object.__setattr__(self, "contact", frozen_array(self.contact, np.bool_, (len(self.von_mises), None), "contact"))


def drop(
    tets: TetMesh,
    material: Material,
    directions: ArrayLike,
    test: DropTest = DropTest(),
    *,
    device: str = "auto",
    progress: Progress = no_progress,
    period: float | None = None,
    relative: Relative | None = None,
) -> Drop:
    """Drop a body onto the floor in every given orientation and follow it until the impact has ended, or through the window.

    Args:
        tets: The body [mm].
        material: Its material.
        directions: Floor normals in the frame of the body, pointing out of the floor, shape [orientations, 3].
        test: Height, window and numerical settings.
        device: "cpu", "cuda", "cuda:1", … or "auto": CUDA if there is a device.
        progress: Called now and then in the calling thread with the fraction done; may raise to cancel.
        period: Lowest elastic period of the body [ms], which decides when its impact has ended; None to work it out if it is needed.
        relative: What a body that is not solid has of the solid's properties.

    Raises:
        BadInput: Unusable tetrahedra or device name.
        MissingPiece: CUDA was asked for and is not there.
        SimulationFailed: If the lowest period, or what stays bent, cannot be worked out.
    """
    normals = np.asarray(directions, np.float64)
    normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    where = resolve_device(device)
    discretisation = discretise(tets, material, test.added_mass, element_named(test.element), relative)
    body = body_on(where, discretisation)
    tracks, scheme = tracks_for(discretisation, material, normals, test, period)
    rule = tracks[0].rule
    steps = scheme.steps if rule.window is not None else math.ceil(rule.period / scheme.time_step)  # through the window, or one period
    if steps > MAX_STEPS:
        x, y, z = tets.vertices[tets.tets[int(np.argmax(element_frequencies(tets, material)))]].mean(axis=0)
        failure = (
            f"the drop test would need {steps} steps of {1e3 * scheme.time_step:.2g} µs because of a sliver at"
            f" ({x:.1f}, {y:.1f}, {z:.1f}) mm: mesh the part again"
        )
    else:
        follow(body, scheme, tracks, progress)
        steps, failure = scheme.stride * max(track.taken for track in tracks), _failure(tracks, scheme)
    return _of_tracks(tets, discretisation, scheme, tracks, steps, failure)


def tracks_for(
    discretisation: Discretisation, material: Material, normals: Floats, test: DropTest, period: float | None = None
) -> tuple[list[Track], Scheme]:
    """Drops at first touch with the floor normals `normals`, unit vectors of shape [orientations, 3], and their scheme."""
    if test.window is None and period is None:
        period = lowest_period(discretisation)
    scheme = scheme_for(discretisation, material, test, period)
    rule, body = Rule(test.speed, period or 0.0, test.window, test.quiet), RigidBody.of(discretisation, scheme.gravity)
    rest = Rest(discretisation, scheme, Springback(discretisation))
    return [Track(normal, body, scheme, rule, rest) for normal in normals], scheme


def body_on(where: str, discretisation: Discretisation) -> Body:
    """Create the body on CPU or GPU; plain kernels, five times slower, on a processor whose vector code cannot be compiled."""
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
        with without_native_stderr():
            return str(wp.get_device(device))
    except (ValueError, RuntimeError) as error:
        raise MissingPiece(f"device {device!r} is not there; use 'cpu' or 'auto', or install an NVIDIA driver") from error


def scheme_for(discretisation: Discretisation, material: Material, test: DropTest, period: float | None = None) -> Scheme:
    """Step and sampling of a test: whole strides fill a window exactly, so that all meshes see the same time.

    Without a window the samples are the most that may be needed, and the lowest period [ms] must be given.
    """
    law = law_named(test.law, material)
    stable, damping = damped_step(discretisation, test.damping, test.contact_stiffness)
    step = test.safety * stable
    if test.window is not None:
        steps = math.ceil(test.window / step)
        stride = RECORD_EVERY * math.ceil(steps / (RECORD_EVERY * SAMPLES))
        samples = math.ceil(steps / stride)
        step = test.window / (samples * stride)
    else:
        assert period is not None, "a drop without a window ends by the lowest period"
        interval = min(period / SAMPLES_PER_PERIOD, LONGEST_INTERVAL)
        stride = max(RECORD_EVERY * round(interval / (RECORD_EVERY * step)), RECORD_EVERY)
        samples = min(math.ceil(longest(period) / (stride * step)), MAX_STEPS // stride)
    strength, hardening = (material.yield_strength, material.hardening) if test.plastic else (math.inf, 0.0)
    shares = step_shares(discretisation, step, damping)
    return Scheme(
        law, step, damping, GRAVITY, test.friction, test.speed, stride, samples, test.across, strength, hardening, shares,
        test.contact_stiffness,
    )  # fmt: skip


def _of_tracks(tets: TetMesh, discretisation: Discretisation, scheme: Scheme, tracks: Sequence[Track], steps: int, failure: str) -> Drop:
    """What drops left, in the caller's numbering; a failed drop has no stress but infinity."""
    used, shape = discretisation.vertices, (len(tracks), len(discretisation.volumes), discretisation.mesh.element.points)
    von_mises = np.full(shape, np.inf, np.float32)
    plastic = np.full((*shape, STATE), np.inf if failure else 0.0, np.float32)
    contact = np.zeros((len(tracks), len(tets.vertices)), dtype=bool)
    permanent = np.zeros((*contact.shape, 3), np.float32)
    if scheme.yields and not failure:
        flow = np.stack([track.plastic[..., :FLOW] for track in tracks if track.plastic is not None])
        permanent[:, used] = tracks[0].rest.springback(flow)[:, discretisation.place[: len(used)]]
    for index, track in enumerate(tracks):
        if track.peak is not None and not failure:
            von_mises[index, discretisation.tet_order] = track.peak
        if track.plastic is not None and scheme.yields and not failure:
            plastic[index, discretisation.tet_order] = track.plastic
        if track.touched is not None:
            contact[index, used] = track.touched[discretisation.place[: len(used)]]
    return Drop(
        von_mises, plastic[..., STRAIN], plastic[..., TENSION], plastic[..., :FLOW], permanent, contact,
        scheme.time_step, steps, discretisation.added_mass,
        tuple(history_of(track, scheme) for track in tracks), tuple(phases_of(track, scheme) for track in tracks),
        tuple(track.ended for track in tracks), failure,
    )  # fmt: skip


def _failure(tracks: Sequence[Track], scheme: Scheme) -> str:
    """Why a drop cannot be trusted, the first to break down of several; "" if it can."""
    broken = [(track.time, orientation) for orientation, track in enumerate(tracks) if track.failed]
    if not broken:
        return ""
    time, orientation = min(broken)
    return f"the drop test is unstable at {time:.3f} ms: {tracks[orientation].ended} (time step {1e3 * scheme.time_step:.3g} µs)"


@dataclass(frozen=True)
class Phase:
    """A stretch of a drop that was simulated, from a touch on.

    Attributes:
        start: When it began [ms since first touch].
        end: When it was over, and with it the drop or a rigid flight began [ms since first touch].
        speed: Speed at which the touching point met the floor [mm/ms = m/s].
        normal: Floor normal in the frame of the part, out of the floor.
    """

    start: float
    end: float
    speed: float
    normal: tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class History:
    """Energies and forces of one drop; arrays over its samples, of all phases one after the other, shape [samples].

    Energy is conserved: kinetic + strain + plastic_work + contact_loss + damping_loss − gravity_work is what it was at first touch.

    Attributes:
        time: Time since first touch, flights included, of which there are no samples [ms].
        phase: Which phase each sample belongs to, counted from 0.
        kinetic: Kinetic energy [mJ].
        strain: Strain energy half a step earlier, where velocity is [mJ].
        plastic_work: Energy that plastic flow has dissipated or stored in hardening, Σ V (σ_y ε_p + ½ h ε_p²) [mJ]; of
            printed layers, which flow at less than σ_y, no more than is missing, and then damping is in it.
        gravity_work: Work done by weight since first touch [mJ].
        contact_loss: Kinetic energy taken by the floor since first touch: impact of lumped masses and friction [mJ].
        damping_loss: What is missing then, the energy dissipated in the material and the error of the integration [mJ]; in the first phase
            of a drop without damping the error alone, some 1e-5 of the energy at first touch. A flight takes what still vibrated.
        peak_stress: Largest von Mises stress in the part at that moment [MPa].
        contact_force: Mean normal force of the floor since the sample before [N].
        momentum: Momentum along the floor normal, negative while falling [g mm/ms = mN s].
    """

    time: Floats
    phase: Indices
    kinetic: Floats
    strain: Floats
    plastic_work: Floats
    gravity_work: Floats
    contact_loss: Floats
    damping_loss: Floats
    peak_stress: Floats
    contact_force: Floats
    momentum: Floats


def history_of(track: Track, scheme: Scheme) -> History:
    """Physical quantities from the sums of the kernels, up to where they are finite."""
    parts = [_finite(samples) for samples in track.samples]
    interval = scheme.stride * scheme.time_step
    of = {name: np.concatenate([samples[:, place] for samples in parts]) for place, name in enumerate(QUANTITIES)}
    phase = np.repeat(np.arange(len(parts)), [len(samples) for samples in parts])
    taken = np.cumsum([0.0, *(samples[-1, QUANTITIES.index("contact_loss")] for samples in parts[:-1])])
    contact_loss = taken[phase] + of["contact_loss"]
    gravity_work = -scheme.gravity * (np.array(track.sunk)[phase] + of["height"])
    left = of["kinetic"] + of["strain"] + contact_loss - gravity_work
    plastic_work = of["plastic_work"]
    if any(scheme.across):  # printed layers flow at less than the strength that their work is worked out with
        plastic_work = np.minimum(plastic_work, np.maximum(left[0] - left, 0.0))
    energy = left + plastic_work
    forces = [np.diff(samples[:, QUANTITIES.index("impulse")], prepend=0.0) / interval for samples in parts]
    return History(
        time=np.concatenate([begun + interval * np.arange(len(samples)) for begun, samples in zip(track.begun, parts, strict=True)]),
        phase=phase.astype(np.int32),
        kinetic=of["kinetic"],
        strain=of["strain"],
        plastic_work=plastic_work,
        gravity_work=gravity_work,
        contact_loss=contact_loss,
        damping_loss=energy[0] - energy,
        peak_stress=np.sqrt(of["peak_squared"]),
        contact_force=np.concatenate(forces),
        momentum=of["momentum"],
    )


def phases_of(track: Track, scheme: Scheme) -> tuple[Phase, ...]:
    """The phases of a drop."""
    ends = [begun + scheme.stride * scheme.time_step * (len(rows) - 1) for begun, rows in zip(track.begun, track.samples, strict=True)]
    phases = zip(track.begun, ends, track.speeds, track.normals, strict=True)
    return tuple(Phase(begun, end, speed, (float(x), float(y), float(z))) for begun, end, speed, (x, y, z) in phases)


def _finite(samples: Floats) -> Floats:
    """The first samples, as long as all is finite."""
    return samples[np.logical_and.accumulate(np.isfinite(samples).all(axis=1))]
