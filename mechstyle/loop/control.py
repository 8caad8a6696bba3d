"""From stress to restraint: demand (normalised stress) and the mask that multiplies further movement.

All functions are pure and work per vertex. Masks lie in [0, 1], fall with demand, and the formulas are those of
Faruqi et al. 2025, §4.2, with the limits corrected: 1 where demand is 0, exactly 0 where demand is 1 or more
(for `linear`, `exponential` and `frozen` alike).
"""

from __future__ import annotations

import numpy as np

from mechstyle.errors import unknown
from mechstyle.records import CONTROLS, NORMALISATIONS, Simulation, Verdict
from mechstyle.records.limits import Limits
from mechstyle.records.material import Material
from mechstyle.records.mesh import Field

RESERVE = 0.01
"""Share of a limit that counts as reserve where the original itself stands at the limit, so that no division is by zero."""


def demand(
    simulation: Simulation, original: Simulation, material: Material, normalisation: str, failing: Verdict | None = None
) -> Field:
    """Normalised stress s_norm(v) ≥ 0, at or above 1 where a vertex has no reserve left, shape [vertex_count].

    `headroom` is the largest over all rules that count: of the part as placed and under each of its loads, of the tilted landings and,
    where it was dropped so, of the envelope over all orientations, each against its own limit (`records.limits`). The others know the
    field as placed alone, as published.

    Args:
        simulation: The last simulation.
        original: The unstylized part.
        material: The material.
        normalisation: One of NORMALISATIONS.
        failing: A verdict on it, of which only the rules that fail are to be met; all rules without it or where none of these fails.
    """
    limits = Limits.of(original, material)
    if normalisation != "headroom":
        largest, strength = float(original.stress.max()), np.float32(limits.strength)
        return normalised(simulation.stress, original.stress, strength, largest, material, normalisation)
    fields = {"as_placed": np.maximum.reduce([headroom(*one) for one in limits.as_it_stands(simulation, original)])}
    if simulation.tilted is not None and original.tilted is not None:
        fields["tilted"] = headroom(simulation.tilted_stress, original.tilted_stress, np.float32(limits.tilted))
    if simulation.overall is not None and original.overall is not None:
        fields["all_orientations"] = headroom(simulation.envelope, original.envelope, limits.of_envelope(original.envelope))
    broken = [] if failing is None else [rule for rule in failing.counting if rule.outcome == "FAILS"]
    to_meet = [field for name, field in fields.items() if getattr(failing, name, None) in broken]
    return np.maximum.reduce(to_meet or list(fields.values()))


def landed(simulation: Simulation, failing: Verdict) -> bool:
    """Whether a landing is among what a simulation fails by, not load cases alone."""
    landings, told = (failing.tilted, failing.all_orientations), failing.as_placed.value
    of_load = any(told in (case.measured.surface, case.measured.contact) for case in simulation.loaded)
    return not of_load or any(rule in failing.counting and rule.outcome == "FAILS" for rule in landings if rule is not None)


def normalised(
    stress: Field, original: Field, limit: Field | np.float32, largest: float, material: Material, normalisation: str
) -> Field:
    """Demand of one field, shape [vertex_count].

    `headroom`: see there; `own_max`: s over the unstylized part's own maximum (the published frozen rule);
    `sigma_c`: s over σ_c = safety_coefficient · S_yield (Stava et al. 2012, the published rule); `yield`: s over S_yield.

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
    elif normalisation == "yield":
        used = stress / material.yield_strength
    else:
        raise unknown("normalisation", normalisation, NORMALISATIONS)
    return np.maximum(used, 0.0).astype(np.float32)


def headroom(stress: Field, original: Field, limit: Field | np.float32) -> Field:
    """(s − s0) / (A − s0), the share of the reserve the style has used up, at least 1 where the stress s exceeds A; shape [vertex_count].

    Where the original is above A itself, A is what it reaches: nothing is demanded of a part as it came.

    Args:
        stress: Field s of the styled part [MPa], shape [vertex_count].
        original: Field s0 of the unstylized part [MPa], shape [vertex_count].
        limit: A [MPa], shape [vertex_count] or one for all.
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


def unrestrained(s_norm: Field) -> Field:
    """1 everywhere: Freestyle."""
    return np.ones_like(s_norm, dtype=np.float32)


MASKS = {"linear": linear, "exponential": exponential, "frozen": frozen, "none": unrestrained}


def mask(s_norm: Field, control: str, threshold: float = 1.0) -> Field:
    """Factor on further movement in [0, 1], shape [vertex_count].

    Args:
        s_norm: Demand, shape [vertex_count].
        control: One of CONTROLS.
        threshold: Demand that is to count as 1, where the masks become 0; above 0.
    """
    if control not in MASKS:
        raise unknown("control", control, CONTROLS)
    return MASKS[control](s_norm / np.float32(threshold))
