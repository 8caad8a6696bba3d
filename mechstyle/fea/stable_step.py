"""The largest time step that is stable for certain, and the damping that goes with it.

With stress of u + β v central differences are stable if Δt² K + 2 Δt C ≤ 4 M, C = Σ β_e K_e. The largest eigenvalue of M⁻¹A is bounded
from above: see `mass_scaling`.
"""

from __future__ import annotations

import math

from mechstyle.fea.discretisation import Discretisation
from mechstyle.fea.mass_scaling import bound
from mechstyle.records.mesh import Floats


def stable_step(frequency: float, damping: float) -> float:
    """Largest stable Δt = (2/ω)(sqrt(1 + ξ²) − ξ), ξ = βω/2 [ms], of central differences with lagged viscous stress."""
    xi = 0.5 * damping * frequency
    return 2.0 / frequency * (math.sqrt(1.0 + xi * xi) - xi)


def damped_step(body: Discretisation, share: float) -> tuple[float, Floats]:
    """A stable Δt [ms], and β of each tetrahedron [ms], shape [tet_count], that damps it by a share of its own critical damping.

    β_e = 2 ξ/ω_e, with the frequencies ω_e of the tetrahedra on their own scaled so that the highest is the bound of the body's: so
    each would allow the step (2/ω_e)(sqrt(1 + ξ²) − ξ), the stiffest the smallest. What the assembled body allows is checked: with
    A = K + 2/Δt C and λ a bound of M⁻¹A, Δt min(1, 4/(Δt² λ)) is stable, since 2 Δt C falls more slowly with Δt than Δt² K.
    """
    stiffness = body.stiffness
    frequency = math.sqrt(bound(stiffness.norms, body.masses, body.highest))
    each = frequency * body.frequencies / body.frequencies.max()
    damping = 2.0 * share / each
    step = stable_step(frequency, 2.0 * share / frequency)
    if share > 0.0:
        weighted = stiffness.weighted_norms(1.0 + 2.0 * damping / step)
        step *= min(1.0, 4.0 / (step**2 * bound(weighted, body.masses, body.highest)))
    return step, damping
