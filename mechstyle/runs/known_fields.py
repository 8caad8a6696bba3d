"""The fields that are known of a checkpoint of a run, for pictures and viewers alike."""

from __future__ import annotations

from mechstyle.loop.store import Store
from mechstyle.pictures.fields import Known, known
from mechstyle.records import Checkpoint, Simulation
from mechstyle.simulation.part import Workpiece


def known_fields(store: Store, lane: str, part: Workpiece, state: Checkpoint) -> tuple[Known, ...]:
    """Every field that is known of a checkpoint, in the order in which they are offered.

    Args:
        store: The run directory.
        lane: The lane on show.
        part: The prepared part.
        state: The checkpoint.
    """
    simulation = store.objects.get_record(state.simulation, Simulation) if state.simulation else None
    newest, verdict = store.checkpoint(store.lane(lane).head), store.verdict(state)
    return known(store.recipe(state.recipe), state, simulation, part.thickness, newest, verdict)
