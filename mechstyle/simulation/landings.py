"""The landings of a drop test as they are recorded, and how likely one of them begins to yield."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mechstyle.fea.criterion import exceedance, measures
from mechstyle.fea.drop import Drop
from mechstyle.fea.orientations import Orientations
from mechstyle.fea.surface_stress import Deciding
from mechstyle.records import Landing, Simulation
from mechstyle.records.material import Material
from mechstyle.records.mesh import Floats, TetMesh


def landings(ways: Orientations, tets: TetMesh, result: Drop, deciding: Sequence[Deciding]) -> tuple[Landing, ...]:
    """Measures and phases of each landing.

    Args:
        ways: The orientations; as placed may be all that was dropped.
        tets: The tetrahedra as they were dropped.
        result: The drop.
        deciding: The stress that decides in each landing.
    """
    known = result.von_mises, deciding, result.phases, result.endings
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


def with_probability(found: Simulation, fields: Floats, material: Material) -> Simulation:
    """A thorough test and how likely a random drop begins to yield, at each vertex and anywhere.

    Args:
        found: The test, in all orientations.
        fields: Stress of each landing [MPa], shape [landings, vertex_count].
        material: What the stress is compared with.
    """
    peaks = [landing.measures.peak for landing in found.landings]
    weights, allowable = np.array([landing.weight for landing in found.landings]), material.yield_strength
    return replace(
        found,
        probability=exceedance(fields, weights, allowable).astype(np.float32),
        failure_probability=float(exceedance(peaks, weights, allowable)),
    )
