"""The explicit integration seen from above: the scheme, where drops start, and the pool that carries them.

How a step is computed is the business of the two implementations of `Body`: `backends.cpu` (vectorised, one drop per CPU
core) and `backends.gpu` (plain kernels and CUDA graphs, all drops at once).
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, fields
from queue import SimpleQueue
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import eye_array

from mechstyle.errors import BadInput
from mechstyle.fea.discretisation import Discretisation, Relative, bound
from mechstyle.fea.elasticity import LAWS, ElasticLaw, StableNeoHookean
from mechstyle.records.mesh import Floats

MOTION = (
    *(f"{name}_{axis}" for name in ("shift", "momentum", "spin") for axis in "xyz"),
    *(f"turn_{row}{column}" for row in "xyz" for column in "xyz"),
)
"""Sums that tell the motion as a whole, r the node seen from the centre of mass before the drop: Σ m u [g mm], Σ m v [g mm/ms],
Σ m (r + u) × v [g mm²/ms], Σ m u ⊗ r [g mm²]."""

QUANTITIES = ("kinetic", "strain", "impulse", "contact_loss", "height", "momentum", "peak_squared", "plastic_work", *MOTION)
"""Rows of a sample: energies [mJ], floor impulse so far [g mm/ms], energy lost to the floor so far [mJ], Σ m u·n [g mm],
Σ m v·n [g mm/ms], largest σ_vM² at that moment [MPa²], plastic work so far [mJ], motion. The kernels know them by their place."""

FLOW, STRAIN, TENSION, STATE = 6, 6, 7, 8
"""What has flowed at a Gauss point is STATE numbers: the FLOW entries xx yy zz xy yz zx of A = C_p⁻¹ − I, and in their places the
equivalent plastic strain ε_p and the part ε_t of it that was gathered in tension, where p > −σ_vM/3."""

MOST_SHARE = 0.9
"""Most that `step_shares` says: nothing is softened below ‖A‖ = 0.1, by which the stiffest tetrahedron gets 5 % faster."""

ELASTIC = 1e30
"""Yield strength from which the kernels take a material for elastic [MPa]."""

RECORD_EVERY = 4
"""Steps between updates of the running maximum; a stress wave crosses an element in several steps."""

ENERGY_GAIN = 0.01
"""Share of the kinetic energy at a touch by which energy may exceed what it was before: more means an unstable integration, not physics."""

Progress = Callable[[float], None]
"""Called now and then with the fraction done; may raise to cancel the rest."""


def no_progress(_what: object) -> None:
    """Null callback for progress and stages."""


@dataclass(frozen=True)
class Scheme:
    """Parameters of the explicit time step, the same for every orientation.

    Attributes:
        law: The elastic law.
        time_step: Δt [ms].
        damping: Kelvin–Voigt time β of each tetrahedron [ms], shape [tet_count].
        gravity: g [mm/ms²].
        friction: Coulomb coefficient of the floor.
        speed: Speed at first touch [mm/ms].
        stride: Steps between two samples of the history, a multiple of RECORD_EVERY.
        samples: Samples of the whole drop, or of the longest there may be.
        across: Normal of printed layers over their share of the strength; zero for a material without layers.
        yield_strength: Stress at which the material begins to flow [MPa]; infinite for an elastic body.
        hardening: By how much its strength rises per unit of plastic strain [MPa].
        shares: What each tetrahedron uses up of the step, `step_shares`; none where no time passes.
        contact_stiffness: Stiffness of a penalty floor at each node [N/mm]; 0 for a rigid floor.
    """

    law: ElasticLaw
    time_step: float
    damping: Floats
    gravity: float
    friction: float
    speed: float
    stride: int
    samples: int
    across: tuple[float, float, float] = (0.0, 0.0, 0.0)
    yield_strength: float = math.inf
    hardening: float = 0.0
    shares: Floats | float = 0.0
    contact_stiffness: float = 0.0

    @property
    def yields(self) -> bool:
        """Whether the material has a yield strength."""
        return self.yield_strength < ELASTIC

    @property
    def steps(self) -> int:
        """Steps of the whole drop."""
        return self.stride * self.samples

    @property
    def law_number(self) -> int:
        """Number of a constitutive law in the kernels."""
        return law_number(self.law)


def law_number(law: ElasticLaw) -> int:
    """The place of a law in LAWS, by which the kernels know it."""
    return LAWS.index("stable_neo_hookean" if isinstance(law, StableNeoHookean) else "st_venant_kirchhoff")


def limits(strength: float, hardening: float, relative: Relative | None) -> Floats:
    """What bounds the stress of the solid with the strains of a body, shape [3] or [tet_count, points, 3].

    They are strength and hardening [MPa], σ_y and h times what the body bears, and the factor on a stress squared that makes it comparable
    with σ_y. A smeared body yields at the stress at which its solid parts do; its own stress is `relative.stiffness` times the solid's.
    """
    bears = np.ones(()) if relative is None else relative.bears
    return np.stack([np.minimum(strength * bears, ELASTIC), hardening * bears, bears**-2.0], axis=-1)


@dataclass(frozen=True, eq=False)
class Starts:
    """Drops at the moment from which they are followed, nodes in the numbering of the discretisation.

    Attributes:
        normals: Floor normals in the frame of the body, shape [orientations, 3].
        heights: Heights of the undeformed nodes above the floor [mm], shape [orientations, node_count].
        displacements: Displacement of each node [mm], shape [orientations, node_count, 3].
        velocities: Velocity of each node [mm/ms], shape [orientations, node_count, 3].
        plastic: What has flowed before, tetrahedra in the numbering of the discretisation, shape [orientations, tet_count, points, STATE];
            None if nothing has.
    """

    normals: Floats
    heights: Floats
    displacements: NDArray[np.floating]
    velocities: NDArray[np.floating]
    plastic: NDArray[np.float32] | None = None

    @classmethod
    def falling(cls, positions: Floats, normals: Floats, speed: float) -> Starts:
        """An undeformed body at first touch, all of it falling at one speed [mm/ms]; `positions` [mm] is [node_count, 3]."""
        heights = normals @ positions.T
        velocities = np.broadcast_to(-speed * normals[:, None], (*heights.shape, 3))
        return cls(normals, heights - heights.min(axis=1, keepdims=True), np.broadcast_to(0.0, velocities.shape), velocities)

    @classmethod
    def at_rest(cls, node_count: int) -> Starts:
        """One undeformed body at rest, with no floor: its heights and normal are zero."""
        still = np.zeros((1, node_count, 3))
        return cls(np.zeros((1, 3)), np.zeros((1, node_count)), still, still)

    @classmethod
    def together(cls, starts: Sequence[Starts]) -> Starts:
        """Several in a row, all of bodies that have flowed or none."""
        rows = ([getattr(start, field.name) for start in starts] for field in fields(cls))
        joined: list[Any] = [None if row[0] is None else np.concatenate(row) for row in rows]
        return cls(*joined)

    def __len__(self) -> int:
        """Orientations."""
        return len(self.normals)

    def subset(self, which: slice) -> Starts:
        """Some of them."""
        flowed = None if self.plastic is None else self.plastic[which]
        return Starts(self.normals[which], self.heights[which], self.displacements[which], self.velocities[which], flowed)


class State(Protocol):
    """Bodies that are advanced together, in the numbering of the discretisation."""

    def history(self, first: int, last: int) -> Floats:
        """Samples from one to another, shape [samples, QUANTITIES, orientations]."""

    def peak(self) -> NDArray[np.float32]:
        """Running maximum of the stress that is held against the strength [MPa], shape [orientations, tet_count, points].

        Of an elastic body the equivalent Cauchy stress; of one that yields Kirchhoff's, by which it flows, after the flow.
        """

    def plastic(self) -> NDArray[np.float32]:
        """What has flowed, shape [orientations, tet_count, points, STATE]; of an elastic body nothing, with 0 in place of STATE."""

    def forget_peak(self) -> None:
        """Begin the running maximum of the stress anew."""

    def motion(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Displacement since the start [mm] and velocity [mm/ms] of each node, each of shape [orientations, node_count, 3]."""


class Batch(State, Protocol):
    """Drops that are advanced together."""

    @property
    def count(self) -> int:
        """Orientations."""

    def advance(self, samples: int) -> None:
        """Take `samples` times `stride` steps, each stride followed by a sample of the history."""

    def pays(self, going: int) -> bool:
        """Whether to compute on together though no more than `going` drops are looked at still: the others cost as much."""

    def touched(self) -> NDArray[np.bool_]:
        """Whether each node has met the floor, shape [orientations, node_count]."""


class Shaped(State, Protocol):
    """One body, without weight and floor, that is put into one shape after another."""

    def forces(self, displacement: Floats) -> Floats:
        """Internal forces [N] after the flow to a shape from the one kept, both of shape [node_count, 3]."""

    def keep(self, displacement: Floats) -> None:
        """Let the flow to a shape have happened, and take its stress into the running maximum."""


class Body(Protocol):
    """A discretised body where it is computed."""

    def internal_forces(
        self, law: ElasticLaw, displacement: Floats, velocity: Floats | float = 0.0, damping: Floats | float = 0.0
    ) -> Floats:
        """Forces f_a = −Σ V P ∇N_a of u + β v, in the numbering of the discretisation, float32 inside, shape [node_count, 3]."""

    def batches(self, scheme: Scheme, starts: Starts) -> Sequence[Batch]:
        """The drops, in their order."""

    def shaped(self, scheme: Scheme) -> Shaped:
        """The body as it is before anything flows."""


class Job(Protocol):
    """Drops on their way, as `carry` sees them."""

    def advance(self) -> None:
        """Go on for a while; called in a thread of a pool."""

    def look(self) -> Sequence[Job]:
        """The jobs that go on from here; called in the thread of `carry`."""


THREADS = "MECHSTYLE_THREADS"
"""The environment variable that limits the threads of a process, for several that share a machine."""


def cores() -> int:
    """CPU cores this process may use: those it is allowed, or as many as MECHSTYLE_THREADS says; BadInput if that is no whole number."""
    given = os.environ.get(THREADS)
    if given:
        if not given.isdecimal() or int(given) < 1:
            raise BadInput(f"{THREADS} is {given!r}, but must be a whole number of threads, 1 or more: unset it to use all cores")
        return int(given)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def carry(jobs: Sequence[Job], progress: Callable[[], None]) -> None:
    """Carry all jobs to their ends, as many at once as there are cores.

    Args:
        jobs: What there is to do.
        progress: Called in this thread now and then; what it raises cancels the rest.
    """
    running: dict[Future[None], Job] = {}
    workers = min(cores(), len(jobs))
    with ThreadPoolExecutor(workers, initializer=_stay_on_a_core, initargs=(_places(workers),)) as pool:
        try:
            running.update({pool.submit(job.advance): job for job in jobs})
            while running:
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    job = running.pop(future)
                    future.result()
                    running.update({pool.submit(after.advance): after for after in job.look()})
                progress()
        finally:
            pool.shutdown(cancel_futures=True)


def _places(workers: int) -> SimpleQueue[int]:
    """One core per worker if the workers fill the machine: Linux was seen to put two threads on one core and leave another idle."""
    places: SimpleQueue[int] = SimpleQueue()
    if os.environ.get(THREADS):  # others share the machine: they would all be put on the first cores
        return places
    if hasattr(os, "sched_getaffinity") and workers == len(os.sched_getaffinity(0)) > 1:
        for core in sorted(os.sched_getaffinity(0)):
            places.put(core)
    return places


def _stay_on_a_core(places: SimpleQueue[int]) -> None:
    """Keep the calling thread, and no other, on the next free place; where there is none it may run anywhere."""
    if not places.empty():
        os.sched_setaffinity(0, {places.get()})


def failing(samples: Floats, scheme: Scheme) -> NDArray[np.bool_]:
    """Samples that are not finite or hold more energy than one before, shape [samples, orientations].

    Kinetic, strain and potential energy, plastic work and what the floor took can only lose to damping. They are held against the least
    they were, or what damping took would hide as much energy gained. A floor gives back no more than it took.

    Args:
        samples: From the touch on, shape [samples, QUANTITIES, orientations].
        scheme: The step.
    """
    with np.errstate(invalid="ignore"):  # sums of infinities, which is what is looked for
        total = total_energy(samples, scheme)
        gained = total - np.minimum.accumulate(total, axis=0)
        return ~np.isfinite(samples).all(axis=1) | ~(gained <= ENERGY_GAIN * samples[0, QUANTITIES.index("kinetic")])


def total_energy(samples: Floats, scheme: Scheme) -> Floats:
    """Kinetic, strain and potential energy, plastic work and what the floor took [mJ], shape [samples, orientations].

    Printed layers flow at less than the yield strength that plastic work is worked out with: theirs is left out, as if it were damping.
    """
    of = {name: samples[:, place] for place, name in enumerate(QUANTITIES)}
    work = 0.0 if any(scheme.across) else of["plastic_work"]
    return np.asarray(of["kinetic"] + of["strain"] + work + np.maximum(of["contact_loss"], 0.0) + scheme.gravity * of["height"])


def stable_step(frequency: float, damping: float) -> float:
    """Largest stable Δt = (2/ω)(sqrt(1 + ξ²) − ξ), ξ = βω/2 [ms], of central differences with lagged viscous stress."""
    xi = 0.5 * damping * frequency
    return 2.0 / frequency * (math.sqrt(1.0 + xi * xi) - xi)


def step_shares(body: Discretisation, step: float, damping: Floats) -> Floats:
    """What each tetrahedron uses up of a stable step [ms], ω_e² (Δt² + 2 Δt β_e) / 4, at most MOST_SHARE, shape [tet_count].

    A tetrahedron that gets stiffer by the inverse of it would reach the limit of stability; `elasticity.softened` keeps it there. With half
    of it a knob and a phone stand whose edges are crushed break down in falls of 4 m, with 0.7 of it they do not.
    """
    limit = bound(body.stiffness.norms, body.masses, body.highest)
    squared = limit * (body.frequencies / body.frequencies.max()) ** 2
    return np.minimum(0.25 * squared * (step**2 + 2.0 * step * damping), MOST_SHARE)


def damped_step(body: Discretisation, share: float, floor: float = 0.0) -> tuple[float, Floats]:
    """A stable Δt [ms], and β of each tetrahedron [ms], shape [tet_count], that damps it by a share of its own critical damping.

    β_e = 2 ξ/ω_e, with the frequencies ω_e of the tetrahedra on their own scaled so that the highest is the bound of the body's: so
    each would allow the step (2/ω_e)(sqrt(1 + ξ²) − ξ), the stiffest the smallest. What the assembled body allows is checked: with
    A = K + 2/Δt C and λ a bound of M⁻¹A, Δt min(1, 4/(Δt² λ)) is stable, since 2 Δt C falls more slowly with Δt than Δt² K.

    A penalty floor of some stiffness [N/mm] at each node adds it to the diagonal of A, as if all nodes touched it.
    """
    stiffness = body.stiffness
    frequency = math.sqrt(bound(stiffness.norms, body.masses, body.highest))
    each = frequency * body.frequencies / body.frequencies.max()
    damping = 2.0 * share / each
    step = stable_step(frequency, 2.0 * share / frequency)
    if share > 0.0 or floor > 0.0:
        weighted = stiffness.weighted_norms(1.0 + 2.0 * damping / step)
        if floor > 0.0:
            weighted = weighted + floor * eye_array(weighted.shape[0], format="csr")
        step *= min(1.0, 4.0 / (step**2 * bound(weighted, body.masses, body.highest)))
    return step, damping
