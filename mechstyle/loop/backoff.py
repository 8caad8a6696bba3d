"""When the finished relief is not viable: reduce it step by step until it is.

The ladder: two local rounds where stress exceeds its limit, then the relief near the contact is removed, then all of it
is scaled down to nothing. It ends, because no relief is the original part on the same tetrahedra, which is viable under
the `robust` criterion by definition. Removing a loaded bump loads the next one, so local rounds alone may not converge.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from mechstyle.records import Simulation
from mechstyle.records.mesh import Field

LOCAL_ROUNDS = 2
LOCAL_RADIUS = 6.0
"""Reach of the first local round [mm]; the second reaches half as far again."""
CONTACT_RADIUS = 4.0
"""Reach around the contact [mm]."""
SCALES = (0.7, 0.5, 0.25, 0.0)
"""Global factors, applied to what the local rounds and the contact step left."""
SCALING = LOCAL_ROUNDS + 1
"""The rung at which the whole relief is first scaled."""
RUNGS = SCALING + len(SCALES)


def nearness(vertices: NDArray[np.float64], selected: NDArray[np.bool_], radius: float) -> Field:
    """exp(−(d/radius)²) with d the distance to the nearest selected vertex [mm], shape [vertex_count]; zero if none is selected."""
    if not selected.any():
        return np.zeros(len(vertices), np.float32)
    distance, _ = cKDTree(vertices[selected]).query(vertices)
    return np.exp(-((distance / radius) ** 2)).astype(np.float32)


def overloaded(simulation: Simulation, limit: Field, envelope_limit: Field) -> NDArray[np.bool_]:
    """Vertices above their limit as placed, else over all orientations, else the fifty closest to it, shape [vertex_count]."""
    for stress, allowed in ((simulation.stress, limit), (simulation.envelope, envelope_limit)):
        over = stress > allowed
        if over.any():
            return over
    use = simulation.stress / limit
    return use >= np.partition(use, -min(50, len(use)))[-min(50, len(use))]


def step(
    rung: int,
    displacement: Field,
    before_scaling: Field,
    simulation: Simulation,
    vertices: NDArray[np.float64],
    limit: Field,
    envelope_limit: Field,
) -> tuple[Field, str]:
    """The next, smaller relief and what was done, in words.

    Args:
        rung: 0 to RUNGS − 1.
        displacement: The relief that was simulated last [mm], shape [vertex_count].
        before_scaling: The relief when global scaling began (ignored before) [mm], shape [vertex_count].
        simulation: Its simulation.
        vertices: Vertices of the unstylized surface [mm], shape [vertex_count, 3].
        limit: Allowed as-placed stress [MPa], shape [vertex_count].
        envelope_limit: Allowed stress over all orientations [MPa], shape [vertex_count].
    """
    if rung < LOCAL_ROUNDS:
        radius = LOCAL_RADIUS * (1.0 + 0.5 * rung)
        over = overloaded(simulation, limit, envelope_limit)
        weight = nearness(vertices, over, radius)
        return displacement * (
            1.0 - np.float32(0.6 + 0.1 * rung) * weight
        ), f"relief reduced within {radius:g} mm of {over.sum()} overloaded vertices"
    if rung == LOCAL_ROUNDS:
        weight = nearness(vertices, simulation.contact, CONTACT_RADIUS)
        return displacement * (1.0 - weight), f"relief removed within {CONTACT_RADIUS:g} mm of the contact"
    factor = SCALES[rung - SCALING]
    # Adding zero turns -0 into 0: the same bytes as the unstylized part, whose simulation is remembered.
    return before_scaling * np.float32(factor) + np.float32(0.0), f"whole relief scaled to {factor:.0%}"
