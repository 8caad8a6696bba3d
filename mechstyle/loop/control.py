"""From stress to restraint: demand (normalised stress) and the mask that multiplies further movement.

All functions are pure and work per vertex. Masks lie in [0, 1], fall with demand, and the formulas are those of
Faruqi et al. 2025, §4.2, with the limits corrected: 1 where demand is 0, exactly 0 where demand is 1 or more
(for `linear`, `exponential` and `frozen` alike).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from mechstyle.errors import unknown
from mechstyle.records import CONTROLS, NORMALISATIONS, Recipe, Row, Simulation
from mechstyle.records.material import Material
from mechstyle.records.mesh import Field

RESERVE = 0.01
"""Share of a limit that counts as reserve where the original itself stands at the limit, so that no division is by zero."""


YIELDED = 0.002
"""Plastic strain from which a place has yielded: the R_p0.2 of the textbooks."""


def utilisation(stress: Field, strain: Field, material: Material) -> Field:
    """σ_vM / σ_y where a place stays elastic, 1 + ε_p / ε_break where it yields, shape [vertex_count].

    `stress` [MPa] and plastic strain are those of one test at the surface, shape [vertex_count].
    """
    elastic = np.minimum(stress / np.float32(material.yield_strength), 1.0)
    return np.where(strain > YIELDED, 1.0 + strain / np.float32(material.elongation), elastic).astype(np.float32)


def demand(simulation: Simulation, original: Simulation, recipe: Recipe) -> Field:
    """Normalised stress s_norm(v) ≥ 0, at or above 1 where a vertex has no reserve left, shape [vertex_count].

    `headroom` compares the utilisation of each landing and load with that of the original in the same test; the largest counts. The
    other normalisations read the stress of the part as placed, as published.
    """
    material, normalisation = recipe.test.material, recipe.restraint.normalisation
    if normalisation != "headroom":
        own = original.stress
        return normalised(simulation.stress, own, np.float32(material.yield_strength), float(own.max()), material, normalisation)
    tests = [{"landing": one.name} for one in simulation.landings] + [{"load": one.name} for one in simulation.loads]
    fields = []
    for test in tests:
        used, before = (utilisation(part.stress_of(**test), part.strain_of(**test), material) for part in (simulation, original))
        fields.append(headroom(used, before, np.float32(1.0)))
    return np.maximum.reduce(fields)


def overload(simulation: Simulation, rows: Sequence[Row], material: Material) -> Field:
    """Utilisation in the tests that are to be met, over what each row allows, shape [vertex_count]: above 1 where relief is to go.

    A place that has yielded counts by its plastic strain over the largest, so that the hinge is lowered and not the scratch beside it.
    """
    fields = [np.zeros(len(simulation.displacement), np.float32)]
    for row in rows:
        if row.test == "published rule":
            fields.append(simulation.stress / np.float32(material.yield_strength))
            continue
        strain = simulation.strain_of(landing=row.landing, load=row.load)
        stress = simulation.stress_of(landing=row.landing, load=row.load) / np.float32(material.yield_strength)
        most, excess = max(float(strain.max()), YIELDED), min(max(row.used - 1.0, LEAST_EXCESS), 1.0)
        fields.append(np.where(strain > YIELDED, 1.0 + excess * strain / most, ELASTIC_COUNTS * stress).astype(np.float32))
    return np.maximum.reduce(fields)


LEAST_EXCESS = 0.1
"""Overload of a test that all but passes, so that something is lowered …"""
ELASTIC_COUNTS = 0.85
"""… and share of its stress with which a place counts that does not yield: it matters only where nothing at the surface does."""


def normalised(stress: Field, original: Field, limit: Field | np.float32, largest: float, material: Material, normalisation: str) -> Field:
    """Demand of one field, shape [vertex_count].

    `headroom`: see there; `own_max`: s over the unstylized part's own maximum (the published frozen rule);
    `sigma_c`: s over σ_c = safety_coefficient · S_yield (Stava et al. 2012, the published rule).

    Args:
        stress: Field of the styled part [MPa], shape [vertex_count].
        original: Field of the unstylized part [MPa], shape [vertex_count].
        limit: What `headroom` lets the stress reach [MPa], shape [vertex_count] or one for all.
        largest: The unstylized part's own maximum [MPa].
        material: The material.
        normalisation: One of NORMALISATIONS.
    """
    if normalisation == "headroom":
        return headroom(stress, original, limit)
    if normalisation == "own_max":
        used = stress / max(largest, 1e-6)
    elif normalisation == "sigma_c":
        used = stress / material.critical_stress
    else:
        raise unknown("normalisation", normalisation, NORMALISATIONS)
    return np.maximum(used, 0.0).astype(np.float32)


def headroom(stress: Field, original: Field, limit: Field | np.float32) -> Field:
    """(s − s0) / (A − s0), the share of the reserve the style has used up, at least 1 where the stress s exceeds A; shape [vertex_count].

    s0 is that of the original, of the same unit, shape [vertex_count], A the limit, one for each vertex or for all. Where the original is
    above A itself, A is what it reaches: nothing is demanded of the unstylized part.
    """
    limit = np.maximum(limit, original)
    used = (stress - original) / np.maximum(limit - original, np.float32(RESERVE) * limit)
    return np.where(stress > limit, np.maximum(used, stress / limit), np.maximum(used, 0.0)).astype(np.float32)


def linear(s_norm: Field) -> Field:
    """1 − s_norm, clamped to [0, 1]; like the other masks 0 where s_norm is not a number."""
    return np.fmin(np.fmax(1.0 - s_norm, 0.0), 1.0).astype(np.float32)


def exponential(s_norm: Field) -> Field:
    """exp(−s_norm / (1 − s_norm)) below 1; exactly 0 from 1 on, where the formula itself would blow up."""
    inside = s_norm < 1.0
    safe = np.where(inside, s_norm, 0.0).astype(np.float64)
    return np.where(inside, np.exp(-safe / (1.0 - safe)), 0.0).astype(np.float32)


def frozen(s_norm: Field) -> Field:
    """1 below the threshold, 0 from it on."""
    return (s_norm < 1.0).astype(np.float32)


MASKS: Mapping[str, Callable[[Field], Field]] = {
    "linear": linear, "exponential": exponential, "frozen": frozen, "none": lambda s_norm: np.ones_like(s_norm, dtype=np.float32),
}  # fmt: skip
"""By control; `none`, of Freestyle, is 1 everywhere."""


def mask(s_norm: Field, control: str, threshold: float = 1.0) -> Field:
    """Factor on further movement in [0, 1], shape [vertex_count].

    The threshold, above 0, is the demand that is to count as 1, where the masks become 0.
    """
    if control not in MASKS:
        raise unknown("control", control, CONTROLS)
    return MASKS[control](s_norm / np.float32(threshold))
