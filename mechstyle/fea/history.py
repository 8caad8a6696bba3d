"""What a drop leaves behind over time: its phases, energies and forces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mechstyle.fea.explicit import QUANTITIES, Scheme
from mechstyle.fea.phases import Track
from mechstyle.records.mesh import Floats, Indices


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

    Energy is conserved: kinetic + strain + contact_loss + damping_loss − gravity_work is what it was at first touch.

    Attributes:
        time: Time since first touch, flights included, of which there are no samples [ms].
        phase: Which phase each sample belongs to, counted from 0.
        kinetic: Kinetic energy [mJ].
        strain: Strain energy half a step earlier, where velocity is [mJ].
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
    energy = of["kinetic"] + of["strain"] + contact_loss - gravity_work
    forces = [np.diff(samples[:, QUANTITIES.index("impulse")], prepend=0.0) / interval for samples in parts]
    return History(
        time=np.concatenate([begun + interval * np.arange(len(samples)) for begun, samples in zip(track.begun, parts, strict=True)]),
        phase=phase.astype(np.int32),
        kinetic=of["kinetic"],
        strain=of["strain"],
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
