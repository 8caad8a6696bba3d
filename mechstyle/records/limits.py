"""The stress a styled part may reach, given what its original reaches: the one table that both the verdict and the mask read."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mechstyle.records.material import Material
from mechstyle.records.mesh import Field
from mechstyle.records.simulation import Simulation

UNHARMED = 1.10
"""Growth over the original that counts as unharmed where the original itself yields; re-meshing alone changes it by 1 to 5 %."""


@dataclass(frozen=True)
class Limits:
    """Limits of a styled part [MPa].

    Attributes:
        surface: Of the surface stress outside the contact, dropped as placed and under loads.
        contact: Of the average around the contact, dropped as placed, and around supports and loads: it depends more on the mesh.
        tilted: Of the surface stress outside the contact, dropped nearly as placed; infinite where the original was not dropped so.
        envelope: Of the envelope over all orientations where the original is calm; 0 where it was not dropped so.
    """

    surface: float
    contact: float
    tilted: float
    envelope: float

    @classmethod
    def of(cls, original: Simulation, material: Material) -> Limits:
        """The limits that an original part sets: the yield strength, or what it reaches itself where that is more.

        As placed the surface may not exceed what the original reaches. Where contact is a point or an edge, as around it and in tilted
        landings, most originals yield, and any relief changes how: there the original's own stress may grow to UNHARMED times.
        """
        strength, own = material.yield_strength, original.as_placed
        nearly = math.inf if original.tilted is None else _larger(strength, UNHARMED * original.tilted.surface)
        overall = 0.0 if original.overall is None else UNHARMED * original.overall.p99
        return cls(_larger(strength, own.surface), _larger(strength, UNHARMED * own.contact), nearly, overall)

    def of_stress(self, original: Field) -> Field:
        """Limit of the field as placed [MPa], shape [vertex_count]: the lower of both, the higher where the original is above that.

        Args:
            original: Field of the original [MPa], shape [vertex_count].
        """
        lower, higher = sorted((self.surface, self.contact))
        return np.where(original > lower, higher, lower).astype(np.float32)

    def of_envelope(self, original: Field) -> Field:
        """Limit of the envelope over all orientations [MPa], shape [vertex_count].

        Args:
            original: Envelope of the original [MPa], shape [vertex_count].
        """
        return np.maximum(np.float32(self.envelope), np.float32(UNHARMED) * original)


def _larger(strength: float, own: float) -> float:
    """The larger of the two; of an original whose stress is no finite number only the strength is left."""
    return max(strength, own) if math.isfinite(own) else strength
