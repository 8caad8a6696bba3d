"""Impacts as a browser plays them: the motion as a whole of each moment, what is left of it, and the stress, quantised.

Only what was worked out before is shown, because a drop takes its time. `static/impact.js` plays what is packed here; positions and faces
are those of the replay at its last iteration.
"""

from __future__ import annotations

import gzip
from collections.abc import Iterator
from typing import Any

import msgspec
import numpy as np

from mechstyle.fea.orientations import UP
from mechstyle.pictures.fields import Quantity, moment
from mechstyle.records import Checkpoint, Simulation
from mechstyle.records.simulation import Place
from mechstyle.runs.report.replay_data import ReplayData, channel_of, layer_entry
from mechstyle.runs.report.run_protocol import LaneOfRun
from mechstyle.simulation.impact import Impact, impact_key, impact_of

MOMENTS = 16
"""Most moments of an impact: of 25k vertices they take some 2 MB."""
BUDGET = 3_700_000
"""Most bytes of all impacts, a third less than what they take in the page."""


def impacts(run: LaneOfRun) -> list[ReplayData]:
    """The impacts of the last checkpoint that were worked out: flat, then those that stress it most, as many as there is room for."""
    found: list[ReplayData] = []
    state = run.store.checkpoint(run.store.lane(run.lane).head)
    for name, impact in _known(run, state):
        played = impact_data(run, state, name, impact)
        if sum(len(one.payload) for one in (*found, played)) <= BUDGET:
            found.append(played)
    return found


def work_out(run: LaneOfRun) -> None:
    """Drop the last checkpoint flat, and in the other landing that stresses it most, so that `impacts` finds them.

    Raises:
        SimulationFailed: If a drop breaks down.
    """
    state = run.store.checkpoint(run.store.lane(run.lane).head)
    for _, normal in _landings(run, state)[:2]:
        impact_of(run.part, run.store.recipe(state.recipe), state.displacement, run.store.memo, normal=normal)


def _known(run: LaneOfRun, state: Checkpoint) -> Iterator[tuple[str, Impact]]:
    """Name and impact of each landing of the last simulation whose impact is remembered."""
    recipe = run.store.recipe(state.recipe)
    for name, normal in _landings(run, state):
        impact = run.store.memo.recall(impact_key(recipe, state.displacement, normal), Impact)
        if impact is not None and impact.displacement.shape[1] == len(state.displacement):
            yield name, impact


def _landings(run: LaneOfRun, state: Checkpoint) -> list[tuple[str, Place]]:
    """Name and floor normal of the landings of the last simulation: flat, then those that stress the part most."""
    tested = run.store.objects.get_record(state.simulation, Simulation).landings if state.simulation else ()
    hardest = sorted(tested[1:], key=lambda one: -one.stress)
    return [(one.name, one.normal) for one in (*tested[:1], *hardest)] or [("flat", UP)]


def impact_data(run: LaneOfRun, state: Checkpoint, name: str, impact: Impact) -> ReplayData:
    """An impact of a checkpoint for `static/impact.js`."""
    vertices = run.part.surface.displaced(state.displacement).vertices
    frames = moments(len(impact.time), impact.peak)
    motions = [impact.motion(vertices, frame) for frame in frames]
    spans = zip([-1, *frames[:-1]], frames, strict=True)
    quantity = _judged(run, state, name)
    stress = channel_of("moment", [quantity.made(impact.stress[before + 1 : last + 1].max(axis=0)) for before, last in spans])
    deformation = channel_of("deformation", [motion.deformation for motion in motions])
    header: dict[str, Any] = {
        "name": name,
        "peak": frames.index(impact.peak),
        "frames": [
            {"time": float(impact.time[frame]), "turn": np.ravel(motion.turn).tolist(), "shift": motion.shift.tolist()}
            for frame, motion in zip(frames, motions, strict=True)
        ],
        "layers": [layer_entry(quantity, stress)],
        "channels": [stress.spec, deformation.spec],
    }
    return ReplayData(header, gzip.compress(stress.packed() + deformation.packed(), 6, mtime=0))


def _judged(run: LaneOfRun, state: Checkpoint, name: str) -> Quantity:
    """The stress of a moment as the landing of a name is judged, which need not be the hardest of its kind."""
    verdict, strength = run.store.verdict(state), run.store.recipe(state.recipe).test.material.yield_strength
    tested = run.store.objects.get_record(state.simulation, Simulation).landing(name) if state.simulation else None
    row = None if verdict is None or tested is None else verdict.row(tested.way)
    if row is None or tested is None:
        return moment(strength)
    return moment(row.limit, msgspec.structs.replace(row, landing=name, stress=tested.stress))


def moments(count: int, peak: int) -> list[int]:
    """At most MOMENTS of `count` frames, the first, the last and that of the peak among them, as even as may be on either side of it."""
    before = round((MOMENTS - 1) * peak / max(count - 1, 1))
    before = min(max(before, min(peak, 1)), MOMENTS - 1 - min(count - 1 - peak, 1))
    sides = (np.linspace(0, peak, min(before, peak) + 1), np.linspace(peak, count - 1, min(MOMENTS - 1 - before, count - 1 - peak) + 1))
    return sorted({round(place) for side in sides for place in side.tolist()})
