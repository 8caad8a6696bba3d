"""What load cases do to a part, beside its drop: each is kept by itself, as each is judged by what the original does in that very case."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mechstyle.fea.criterion import measures
from mechstyle.fea.statics.border_doubt import heading_for
from mechstyle.fea.statics.solve import Response
from mechstyle.fea.surface_stress import Deciding
from mechstyle.records import LoadResult, Measures, Simulation
from mechstyle.records.mesh import Bools, TetMesh


def told(name: str, tets: TetMesh, response: Response, deciding: Deciding, border: Bools) -> LoadResult:
    """The record of one load case on tetrahedra, by its response and the stress that decides there.

    Args:
        name: The case.
        tets: The body.
        response: What the case does to it.
        deciding: The stress that decides.
        border: Which vertices lie on the border of its supports and loads, shape [vertex_count].
    """
    found = measures(tets, response.von_mises, deciding)
    return LoadResult(
        name=name, peak=found.peak, where=found.where, deflection=response.deflection,
        surface=deciding.resolved, averaged=deciding.averaged, measures=found,
        border=heading_for(tets, border, deciding.field),
    )  # fmt: skip


def under_loads(dropped: Simulation, loaded: Sequence[LoadResult], fields: NDArray[np.float32]) -> Simulation:
    """A drop's result with what load cases do: as placed the larger of both is shown, and each is kept.

    Args:
        dropped: Of the drop alone.
        loaded: What each load case did, at least one.
        fields: Stress under each [MPa], shape [case_count, vertex_count].
    """
    raised = replace(
        dropped,
        dropped_stress=dropped.stress,
        loaded_stress=fields,
        stress=np.maximum(dropped.stress, fields.max(axis=0)),
        envelope=np.maximum(dropped.envelope, fields.max(axis=0)),
    )
    return with_measures(raised, dropped.as_placed, loaded)


def with_measures(simulation: Simulation, drop: Measures, loaded: Sequence[LoadResult]) -> Simulation:
    """A simulation with other measures of the drop as placed and other results of its load cases, and the largest of all of them."""
    largest = drop
    for case in loaded:
        largest = largest.or_worse(case.measured)
    return replace(simulation, as_placed=largest, dropped=drop if loaded else None, loaded=tuple(loaded))
