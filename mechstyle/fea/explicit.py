"""The explicit integration seen from above: the scheme, and the loop that carries all drops through the window.

How a step is computed is the business of the two implementations of `Body`: `backends.cpu` (vectorised, one drop per CPU
core) and `backends.gpu` (plain kernels and CUDA graphs, all drops at once).
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from queue import SimpleQueue
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from mechstyle.fea.elasticity import LAWS, ElasticLaw, StableNeoHookean
from mechstyle.records.mesh import Floats

QUANTITIES = ("kinetic", "strain", "impulse", "contact_loss", "height", "momentum", "peak_squared")
"""Rows of a sample: energies [mJ], floor impulse so far [g mm/ms], energy lost to the floor so far [mJ], Σ m u·n [g mm],
Σ m v·n [g mm/ms], largest σ_vM² at that moment [MPa²]. The kernels know them by their place."""

RECORD_EVERY = 4
"""Steps between updates of the running maximum; a stress wave crosses an element in several steps."""

SAMPLES_PER_CHUNK = 2
ENERGY_GAIN = 0.01
"""Share of the energy at first touch by which energy may exceed what it was before: more means an unstable integration, not physics."""

Progress = Callable[[float], None]
"""Called now and then with the fraction done; may raise to cancel the rest."""


def no_progress(fraction: float) -> None:
    """Report to nobody."""


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
        samples: Samples of the whole drop.
        across: Normal of printed layers over their share of the strength; zero for a material without layers.
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


class Batch(Protocol):
    """Drops that are advanced together, in the numbering of the discretisation."""

    def advance(self, samples: int) -> None:
        """Take `samples` times `stride` steps, each stride followed by a sample of the history."""

    def history(self, samples: int) -> Floats:
        """The first samples, shape [samples, QUANTITIES, orientations]."""

    def peak(self) -> NDArray[np.float32]:
        """Running maximum of the von Mises stress at the Gauss points [MPa], shape [orientations, tet_count, points]."""

    def corners(self) -> NDArray[np.float32]:
        """The same at the corners of the tetrahedra [MPa], shape [orientations, tet_count, 4]."""

    def touched(self) -> NDArray[np.bool_]:
        """Whether each node has met the floor, shape [orientations, node_count]."""


class Body(Protocol):
    """A discretised body where it is computed."""

    def internal_forces(
        self, law: ElasticLaw, displacement: Floats, velocity: Floats | float = 0.0, damping: Floats | float = 0.0
    ) -> Floats:
        """As `elasticity.internal_forces` of u + β v, in the numbering of the discretisation, float32 inside, shape [node_count, 3]."""

    def batches(self, scheme: Scheme, normals: Floats, heights: Floats) -> Sequence[Batch]:
        """Drops at first touch; `normals` is [orientations, 3], `heights` above the floor [mm] is [node_count, orientations]."""


def cores() -> int:
    """CPU cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def integrate(batches: Sequence[Batch], scheme: Scheme, energy: float, progress: Progress) -> Floats:
    """Carry all batches through the window, as many at once as there are cores; a batch that breaks down stops there.

    Args:
        batches: Drops at first touch.
        scheme: The step.
        energy: Kinetic energy of the body at first touch [mJ].
        progress: Called in this thread with the fraction done; what it raises cancels the rest.

    Returns:
        The samples that all batches reached, shape [samples, QUANTITIES, orientations].
    """
    done = [0] * len(batches)
    running: dict[Future[None], int] = {}
    workers = min(cores(), len(batches))
    with ThreadPoolExecutor(workers, initializer=_stay_on_a_core, initargs=(_places(workers),)) as pool:

        def submit(index: int) -> None:
            chunk = min(SAMPLES_PER_CHUNK, scheme.samples - done[index])
            done[index] += chunk
            running[pool.submit(batches[index].advance, chunk)] = index

        try:
            for index in range(len(batches)):
                submit(index)
            while running:
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    index = running.pop(future)
                    future.result()
                    if done[index] < scheme.samples and not failing(batches[index].history(done[index]), scheme, energy).any():
                        submit(index)
                progress(sum(done) / (scheme.samples * len(batches)))
        finally:
            pool.shutdown(cancel_futures=True)
    return np.concatenate([batch.history(min(done)) for batch in batches], axis=2)


def _places(workers: int) -> SimpleQueue[int]:
    """One core per worker if the workers fill the machine: Linux was seen to put two threads on one core and leave another idle."""
    places: SimpleQueue[int] = SimpleQueue()
    if hasattr(os, "sched_getaffinity") and workers == len(os.sched_getaffinity(0)) > 1:
        for core in sorted(os.sched_getaffinity(0)):
            places.put(core)
    return places


def _stay_on_a_core(places: SimpleQueue[int]) -> None:
    """Keep the calling thread, and no other, on the next free place; where there is none it may run anywhere."""
    if not places.empty():
        os.sched_setaffinity(0, {places.get()})


def failing(samples: Floats, scheme: Scheme, energy: float) -> NDArray[np.bool_]:
    """Samples that are not finite or hold more energy than one before, shape [samples, orientations].

    Kinetic, strain and potential energy and what the floor took can only lose to damping. They are held against the least they were,
    or what damping took would hide as much energy gained.

    Args:
        samples: From the first after first touch, shape [samples, QUANTITIES, orientations].
        scheme: The step.
        energy: Kinetic energy at first touch [mJ].
    """
    with np.errstate(invalid="ignore"):  # sums of infinities, which is what is looked for
        total = total_energy(samples, scheme)
        least = np.minimum(np.minimum.accumulate(total, axis=0), energy)
        return ~np.isfinite(samples).all(axis=1) | ~(total - least <= ENERGY_GAIN * energy)


def total_energy(samples: Floats, scheme: Scheme) -> Floats:
    """Kinetic, strain and potential energy and what the floor took, from first touch [mJ], shape [samples, orientations]."""
    of = {name: samples[:, place] for place, name in enumerate(QUANTITIES)}
    return of["kinetic"] + of["strain"] + of["contact_loss"] + scheme.gravity * of["height"]
