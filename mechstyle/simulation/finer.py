"""A test on the surface of a run and on the same in smaller faces."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from mechstyle.geometry.subdivision import Subdivided
from mechstyle.records import Simulation
from mechstyle.records.mesh import Field

STRESSES = ("stress", "envelope", "probability", "tilted_stress")
"""Fields of a simulation over the surface that are stresses, or told by them."""


def on_coarse(simulation: Simulation, cut: Subdivided, displacement: Field) -> Simulation:
    """A test on a finer surface as one on the coarse one's vertices, of a displacement of that [mm], shape [coarse_count].

    At a vertex stands the largest stress of those it is nearest to: a peak between vertices is to be lowered, too.
    """
    fields: dict[str, Any] = {name: cut.largest_near(getattr(simulation, name)) for name in STRESSES}
    return replace(simulation, displacement=displacement, contact=simulation.contact[: len(displacement)], **fields)


def on_finer(simulation: Simulation, cut: Subdivided) -> Simulation:
    """A test on the coarse surface as one on a finer one."""
    spread: dict[str, Any] = {name: cut.spread(getattr(simulation, name)) for name in ("displacement", *STRESSES)}
    return replace(simulation, contact=cut.spread(simulation.contact.astype(np.float32)) > 0.5, **spread)
