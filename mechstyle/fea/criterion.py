"""The criterion: measures of the stress of a test.

The stress that drives the mask is the stress that decides, `surface_stress.Deciding`, or the mask would sleep while the verdict fails.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from mechstyle.fea.drop import Drop
from mechstyle.fea.orientations import Orientations
from mechstyle.fea.surface_stress import Deciding
from mechstyle.records import Landing, Measures
from mechstyle.records.mesh import Floats, TetMesh


def exceedance(fields: ArrayLike, weights: ArrayLike, allowable: float) -> Floats:
    """Probability that a random drop takes the stress beyond what is allowed, place by place (Langlois et al. 2016).

    Args:
        fields: Stress in each orientation [MPa], shape [orientations, ...].
        weights: Probability of each orientation, shape [orientations].
        allowable: What the stress may at most be [MPa].

    Returns:
        Probabilities, shape [...].
    """
    beyond = np.asarray(fields, dtype=np.float64) > allowable
    return np.asarray(np.einsum("o,o...->...", np.asarray(weights), beyond.astype(np.float64)))


def percentile(values: ArrayLike, weights: ArrayLike, share: float) -> float:
    """Value below which the given share of the weight lies, linear between the values' cumulative weights."""
    values, weights = np.asarray(values, dtype=np.float64), np.asarray(weights, dtype=np.float64)
    order = np.argsort(values, kind="stable")
    below = np.cumsum(weights[order])
    return float(np.interp(share * below[-1], below, values[order]))


def measures(tets: TetMesh, von_mises: ArrayLike, deciding: Deciding) -> Measures:
    """Deciding stress, volume-weighted percentiles and literal maximum [MPa] of one stress field, shape [tet_count, points]."""
    stress = np.asarray(von_mises, dtype=np.float64)
    weights = np.repeat(tets.volumes, stress.shape[1])
    return Measures(
        peak=deciding.peak,
        surface=deciding.surface,
        contact=deciding.contact,
        p999=percentile(stress.ravel(), weights, 0.999),
        p99=percentile(stress.ravel(), weights, 0.99),
        maximum=float(stress.max()),
        where=deciding.where,
        surface_where=deciding.surface_where,
        contact_where=deciding.contact_where,
        volume=float(tets.volumes.sum()),
    )


def measured_landings(ways: Orientations, tets: TetMesh, result: Drop, deciding: Sequence[Deciding]) -> tuple[Landing, ...]:
    """Measures and phases of each landing of a drop test, the first as placed.

    Args:
        ways: Names, floor normals and weights of all landings; the test may be of the first few only.
        tets: The body that was dropped.
        result: The drop test.
        deciding: The stress that decides in each of its landings.
    """
    known = (result.von_mises, deciding, result.phases, result.endings)
    drops = zip(ways.names, ways.normals, ways.weights, *known, strict=False)
    return tuple(
        Landing(
            name=name,
            normal=(float(x), float(y), float(z)),
            weight=float(weight),
            measures=measures(tets, stress, one),
            touches=tuple(phase.speed for phase in phases),
            ended=ended,
        )
        for name, (x, y, z), weight, stress, one, phases, ended in drops
    )
