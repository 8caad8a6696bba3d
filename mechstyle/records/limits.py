"""The stress a styled part may reach, given what its original reaches: the one table that both the verdict and the mask read."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mechstyle.records.material import Material
from mechstyle.records.mesh import Field
from mechstyle.records.simulation import Measures, Simulation

UNHARMED = 1.10
"""Growth over the original that counts as unharmed where the original itself yields; re-meshing alone changes it by 1 to 5 %."""


class OfTest(NamedTuple):
    """Limits of one test of a styled part as it stands, of the drop or of one load case [MPa].

    Attributes:
        surface: Of the surface stress outside the contact.
        contact: Of the average around the contact, or around supports and loads: it depends more on the mesh.
    """

    surface: float
    contact: float

    @classmethod
    def of(cls, own: Measures | None, strength: float) -> OfTest:
        """The limits that the original sets by what it reaches in the same test; the strength [MPa] alone if that is not known."""
        if own is None:
            return cls(strength, strength)
        return cls(_larger(strength, own.surface), _larger(strength, UNHARMED * own.contact))

    def of_stress(self, original: Field) -> Field:
        """Limit of the field of that test [MPa], shape [vertex_count]: the lower of both, the higher where the original is above that.

        Args:
            original: Field of the original [MPa], shape [vertex_count].
        """
        lower, higher = sorted(self)
        return np.where(original > lower, higher, lower).astype(np.float32)


class OnSurface(NamedTuple):
    """Stress of one test beside that of the original and its limit [MPa], each of shape [vertex_count]."""

    stress: Field
    original: Field
    limit: Field


@dataclass(frozen=True)
class Limits:
    """Limits of a styled part [MPa].

    What an original bears in one test excuses nothing in another: a part may be dropped once and hung up for years.

    Attributes:
        drop: Dropped as placed.
        loads: Under each load case of the original, by its name.
        strength: The yield strength.
        tilted: Of the surface stress outside the contact, dropped nearly as placed; infinite where the original was not dropped so.
        envelope: Of the envelope over all orientations where the original is calm; 0 where it was not dropped so.
    """

    drop: OfTest
    loads: dict[str, OfTest]
    strength: float
    tilted: float
    envelope: float

    @classmethod
    def of(cls, original: Simulation, material: Material) -> Limits:
        """The limits that an original part sets: the yield strength, or what it reaches itself where that is more.

        As placed and under a load the surface may not exceed what the original reaches in that very test. Where contact is a point or
        an edge, as around it and in tilted landings, most originals yield, and any relief changes how: there the original's own stress
        may grow to UNHARMED times.
        """
        strength = material.yield_strength
        loads = {case.name: OfTest.of(case.measured, strength) for case in original.loaded}
        nearly = math.inf if original.tilted is None else _larger(strength, UNHARMED * original.tilted.surface)
        overall = 0.0 if original.overall is None else UNHARMED * original.overall.p99
        return cls(OfTest.of(original.drop, strength), loads, strength, nearly, overall)

    def under(self, load: str) -> OfTest:
        """Under a load case, by its name; of one that the original was not tested by, the yield strength."""
        return self.loads.get(load, OfTest(self.strength, self.strength))

    def as_it_stands(self, simulation: Simulation, original: Simulation) -> list[OnSurface]:
        """The fields of the drop as placed and of each load case, beside those of the original and their own limits."""
        own = original.drop_stress
        fields = [OnSurface(simulation.drop_stress, own, self.drop.of_stress(own))]
        for name in (case.name for case in simulation.loaded):
            own = original.load_stress(name)
            fields.append(OnSurface(simulation.load_stress(name), own, self.under(name).of_stress(own)))
        return fields

    def of_envelope(self, original: Field) -> Field:
        """Limit of the envelope over all orientations [MPa], shape [vertex_count].

        Args:
            original: Envelope of the original [MPa], shape [vertex_count].
        """
        return np.maximum(np.float32(self.envelope), np.float32(UNHARMED) * original)


def _larger(strength: float, own: float) -> float:
    """The larger of the two; of an original whose stress is no finite number only the strength is left."""
    return max(strength, own) if math.isfinite(own) else strength
