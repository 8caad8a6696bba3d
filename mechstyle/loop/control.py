"""From stress to restraint: demand (normalised stress) and the mask that multiplies further movement.

All functions are pure and work per vertex. Masks lie in [0, 1], fall with demand, and the formulas are those of
Faruqi et al. 2025, §4.2, with the limits corrected: 1 where demand is 0, exactly 0 where demand is 1 or more
(for `linear`, `exponential` and `frozen` alike).
"""

from __future__ import annotations

import numpy as np

from mechstyle.errors import unknown
from mechstyle.records import CONTROLS, NORMALISATIONS
from mechstyle.records.material import Material
from mechstyle.records.mesh import Field

HEADROOM_GROWTH = 1.25
"""A vertex may rise to this multiple of its unstylized stress even where that exceeds yield."""


def allowable(baseline: Field, material: Material) -> Field:
    """Stress each vertex may carry, A(v) = max(S_yield, 1.25 s0(v)) [MPa], shape [vertex_count].

    Args:
        baseline: Field s0 of the unstylized part [MPa], shape [vertex_count].
        material: The material.
    """
    return np.maximum(np.float32(material.yield_strength), np.float32(HEADROOM_GROWTH) * baseline)


def demand(stress: Field, baseline: Field, material: Material, normalisation: str) -> Field:
    """Normalised stress s_norm(v) ≥ 0, at or above 1 where a vertex has no reserve left, shape [vertex_count].

    `headroom`: (s − s0) / (A − s0), the share of the reserve the style has used up, A from `allowable`;
    `own_max`: s over the unstylized part's own maximum (the published frozen rule);
    `sigma_c`: s over σ_c = safety_coefficient · S_yield (Stava et al. 2012, the published rule);
    `yield`: s over S_yield.

    Args:
        stress: Field of the last simulation [MPa], shape [vertex_count].
        baseline: Field of the unstylized part [MPa], shape [vertex_count].
        material: The material.
        normalisation: One of NORMALISATIONS.
    """
    if normalisation == "headroom":
        used = (stress - baseline) / (allowable(baseline, material) - baseline)
    elif normalisation == "own_max":
        used = stress / max(float(baseline.max()), 1e-6)
    elif normalisation == "sigma_c":
        used = stress / material.critical_stress
    elif normalisation == "yield":
        used = stress / material.yield_strength
    else:
        raise unknown("normalisation", normalisation, NORMALISATIONS)
    return np.maximum(used, 0.0).astype(np.float32)


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
