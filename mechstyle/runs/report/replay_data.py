"""A run as a browser plays it: base surface and normals once, then one plane of quantised values per field and iteration.

A vertex moves along its own normal only, so one displacement per vertex makes a frame. Planes that do not change from one
iteration to the next (stress, demand, mask between simulations) are kept once. Each plane is stored as the difference to the one
before, low bytes apart from high bytes, which gzip then packs to a fraction. `static/replay_data.js` unpacks what is packed here.

Of a long run on many vertices some iterations are left out, or a file would have hundreds of megabytes: what was simulated is in it.

Impacts follow: the motion as a whole of each moment, what is left of it, and the stress. Only what was worked out before is shown, because
a drop takes its time; the last moment is the shape that stays. `static/impact.js` plays what is packed here; positions and faces are those
of the replay at its last iteration.
"""

from __future__ import annotations

import gzip
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from mechstyle._colour import linear_to_srgb
from mechstyle.loop.history import Row, per_iteration
from mechstyle.pictures import scene
from mechstyle.pictures.colormap import ABOVE, LINE, STRIPE, UNKNOWN, Scale
from mechstyle.pictures.fields import STAYS_BENT, Quantity, moment, quantities, stays_bent
from mechstyle.records import Landing, Recipe, Simulation, sentences
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.records.written import written
from mechstyle.runs.report.run_protocol import LaneOfRun, begun
from mechstyle.simulation.impact import FALLING, Impact, heights, impact_key, impact_of

LEVELS = 4095
"""Steps of a quantised field: a quarter of a micrometre for a millimetre of relief."""
MOST = 5_000_000
"""Vertices of all frames together, about: 200 iterations of 25 000 vertices make some 20 MB."""
NO_NUMBER = 65535
"""Stands for a value that is not a number."""

STYLE = {"key": "style", "title": "Style", "label": "", "unit": "", "low": 0.0, "high": 1.0, "threshold": None, "bounded": False}
"""The layer of the part's own colours."""

Plane = NDArray[np.uint8] | NDArray[np.uint16]


@dataclass(frozen=True)
class ReplayData:
    """All iterations of a lane: frames and layers, as JSON can hold them, and the packed arrays, gzip."""

    header: dict[str, Any]
    payload: bytes

    @property
    def iterations(self) -> list[int]:
        """Iteration of each frame, rising."""
        return [frame["iteration"] for frame in self.header["frames"]]

    def layer(self, key: str) -> dict[str, Any]:
        """A layer of the header by its key."""
        return next(layer for layer in self.header["layers"] if layer["key"] == key)


class Digests(msgspec.Struct, frozen=True):
    """The digests of a checkpoint's arrays: equal digests are equal planes, known without reading them."""

    displacement: str
    colour: str
    stress: str
    demand: str
    mask: str
    simulation: str = ""


@dataclass(frozen=True, eq=False)
class Channel:
    """One field over all frames: its different planes, raw, shape [vertex_count * width] each, and which of them each frame has.

    Raw 0 is the value `low`, and one raw step is `step`.
    """

    name: str
    planes: list[Plane]
    frames: list[int]
    low: float = 0.0
    step: float = 1.0
    width: int = 1

    @property
    def extremes(self) -> tuple[float, float]:
        """Its least and greatest value over all frames."""
        raw = max(int(plane.max(initial=0, where=plane != NO_NUMBER)) for plane in self.planes)
        return self.low, self.low + self.step * raw

    @property
    def spec(self) -> dict[str, Any]:
        """Its entry in the header."""
        size = self.planes[0].dtype.itemsize
        return {
            "name": self.name,
            "planes": len(self.planes),
            "frames": self.frames,
            "low": self.low,
            "step": self.step,
            "width": self.width,
            "size": size,
        }

    def packed(self) -> bytes:
        """The planes as differences to the plane before, low bytes before high bytes."""
        parts, before = [], np.zeros_like(self.planes[0])
        for plane in self.planes:
            change = (plane - before).view(np.uint8).reshape(len(plane), -1)  # wraps around, as the browser's sum does
            parts.append(np.ascontiguousarray(change.T).tobytes())
            before = plane
        return b"".join(parts)


def replay_data(run: LaneOfRun) -> ReplayData:
    """The replay of a lane, finished or not; a frame for an iteration, the newest where corrections repeated one.

    BadInput if the lane has no checkpoint yet.
    """
    history = begun(run)
    rows = _shown(per_iteration(history), run.part.surface)
    digests = [run.store.objects.get_record(row.digest, Digests) for row in rows]
    surface = run.part.surface
    fields, shown = dict[str, Channel](), quantities(run.recipe, run.store.verdict(history[-1]))
    for of in shown:
        different, frames = _unique(digests, "simulation" if of.name == STAYS_BENT else of.source)
        if of.name == STAYS_BENT:
            arrays = [_bend(run, digest, rows[frames.index(place)]) for place, digest in enumerate(different)]
        else:
            arrays = [of.made(run.store.objects.get_array(digest)) for digest in different]
        fields[of.name] = channel_of(of.name, arrays, frames)
    different, frames = _unique(digests, "colour")
    colours = (run.store.objects.get_array(digest).astype(np.float32) for digest in different)
    planes: list[Plane] = [np.rint(255 * np.clip(colour, 0, 1)).astype(np.uint8).ravel() for colour in colours]
    channels = [*fields.values(), Channel("colour", planes, frames, width=3)]
    header = {
        "name": run.record.name, "prompt": run.recipe.style.prompt, "vertices": len(surface.vertices), "faces": len(surface.faces),
        "frames": [_frame(row) for row in rows], "layers": [STYLE, *(layer_entry(quantity, fields[quantity.name]) for quantity in shown)],
        "channels": [channel.spec for channel in channels], "colours": palette(), "light": light(),
    }  # fmt: skip
    base = (surface.vertices.astype("<f4"), surface.vertex_normals.astype("<f4"), surface.faces.astype("<u4"))
    packed = b"".join([*(array.tobytes() for array in base), *(channel.packed() for channel in channels)])
    return ReplayData(header, gzip.compress(packed, 6, mtime=0))


def _shown(rows: Sequence[Row], surface: SurfaceMesh) -> list[Row]:
    """The iterations to show: all, or the simulated ones, the last and as many others, evenly, as MOST allows."""
    every = max(1, round(len(rows) * len(surface.vertices) / MOST))
    return [row for number, row in enumerate(rows) if row.verdict is not None or row is rows[-1] or number % every == 0]


def _bend(run: LaneOfRun, simulation: str, row: Row) -> NDArray[np.float32]:
    """What stays bent in the worst test of a stored simulation, as a checkpoint judges it [mm], shape [vertex_count]; NaN without one."""
    verdict = run.store.verdict(row)
    worst = None if verdict is None else verdict.deciding
    if worst is None or not simulation:
        return np.full(len(run.part.surface.vertices), np.nan, np.float32)
    return stays_bent(worst).values_in(run.store.objects.get_record(simulation, Simulation))


def _unique(digests: Sequence[Digests], key: str) -> tuple[list[str], list[int]]:
    """Different digests in order of appearance, and which of them each frame has."""
    wanted = [getattr(one, key) for one in digests]
    order = {digest: place for place, digest in enumerate(dict.fromkeys(wanted))}
    return list(order), [order[digest] for digest in wanted]


def channel_of(name: str, arrays: Sequence[NDArray[Any]], frames: list[int] | None = None) -> Channel:
    """A field of shape [vertex_count] or [vertex_count, width], quantised to LEVELS steps between its extremes; an array for each frame."""
    known = [array[np.isfinite(array)] for array in arrays]
    low = min((float(array.min()) for array in known if array.size), default=0.0)
    high = max((float(array.max()) for array in known if array.size), default=0.0)
    step, planes = (high - low) / LEVELS or 1.0, list[Plane]()
    for values in map(np.ravel, arrays):
        raw, finite = np.full(values.shape, NO_NUMBER, "<u2"), np.isfinite(values)
        raw[finite] = np.rint((values[finite].astype(np.float64) - low) / step)
        planes.append(raw)
    width = 1 if arrays[0].ndim == 1 else arrays[0].shape[1]
    return Channel(name, planes, list(range(len(arrays))) if frames is None else frames, low, step, width)


def _frame(row: Row) -> dict[str, Any]:
    """A frame of the replay."""
    frame = {
        "iteration": row.iteration,
        "simulatedAt": row.simulated_at,
        "reason": row.reason,
        "restrained": round(row.share, 5),
        "loss": row.style_loss,
    }
    verdict = row.verdict
    if verdict is None:
        return frame
    return {**frame, "outcome": sentences.marked(verdict.outcome, sure=verdict.sure), "words": sentences.note(verdict)}


def layer_entry(quantity: Quantity, channel: Channel) -> dict[str, Any]:
    """A field as the table of quantities has it, with colours that show it in every frame."""
    low, high = quantity.limits(channel.extremes) or channel.extremes
    return {
        "key": quantity.name, "title": quantity.title.capitalize(), "label": quantity.label, "unit": quantity.unit,
        "low": low, "high": high, "threshold": quantity.threshold, "bounded": quantity.bounded,
    }  # fmt: skip


def light() -> dict[str, Any]:
    """The lamps of the figures, by the names the shaders give them."""
    return {
        "key": list(scene.KEY), "keyLight": scene.KEY_LIGHT, "fill": list(scene.FILL), "fillLight": scene.FILL_LIGHT,
        "sky": scene.SKY_LIGHT, "ground": scene.GROUND_LIGHT, "flatness": scene.FLATNESS,
    }  # fmt: skip


def palette() -> dict[str, Any]:
    """The colours of the figures, as display RGB in 0 to 255, so that report, notebook and pictures agree."""
    ramp = np.rint(255 * linear_to_srgb(Scale(0.0, 1.0).colours(np.linspace(0.0, 1.0, 256)))).astype(int)
    named = {"above": ABOVE, "stripe": STRIPE, "line": LINE, "unknown": UNKNOWN}
    return {"ramp": ramp.ravel().tolist(), **{name: [round(255 * part) for part in colour] for name, colour in named.items()}}


MOMENTS = 16
"""Most moments of an impact: of 25k vertices they take some 2 MB."""
BUDGET = 3_700_000
"""Most bytes of all impacts, a third less than what they take in the page."""


def impacts(run: LaneOfRun) -> list[ReplayData]:
    """The impacts of the last test that were worked out: flat, then those after which most stays bent, as many as there is room for."""
    found: list[ReplayData] = []
    recipe, simulation = _last_test(run)
    for landing in _landings(simulation):
        assert simulation is not None, "it has landings"
        impact = run.store.memo.recall(impact_key(recipe, simulation, landing.normal), Impact)
        if impact is None or impact.displacement.shape[1] != len(simulation.displacement):
            continue
        played = impact_data(run, simulation, landing, impact)
        if sum(len(one.payload) for one in (*found, played)) <= BUDGET:
            found.append(played)
    return found


def work_out(run: LaneOfRun) -> None:
    """Drop the part of the last test flat, and in the other landing after which most stays bent, so that `impacts` finds them.

    SimulationFailed if a drop breaks down.
    """
    recipe, simulation = _last_test(run)
    for landing in _landings(simulation)[:2]:
        assert simulation is not None, "it has landings"
        impact_of(run.simulator(recipe), simulation, landing.name)


def _last_test(run: LaneOfRun) -> tuple[Recipe, Simulation | None]:
    """The recipe of the last checkpoint and its simulation, None if there is none of this measure."""
    state = run.store.checkpoint(run.store.lane(run.lane).head)
    verdict = run.store.verdict(state)
    known = verdict is not None and verdict.rows and state.simulation
    return run.store.recipe(state.recipe), run.store.objects.get_record(state.simulation, Simulation) if known else None


def _landings(simulation: Simulation | None) -> list[Landing]:
    """The landings of a test: flat, then those after which most stays bent."""
    tested = () if simulation is None else simulation.landings
    return [*tested[:1], *sorted(tested[1:], key=lambda one: -one.permanent_set)]


def impact_data(run: LaneOfRun, simulation: Simulation, landing: Landing, impact: Impact) -> ReplayData:
    """The impact of a landing for `static/impact.js`."""
    vertices = run.part.surface.displaced(simulation.displacement).vertices
    frames = moments(len(impact.time), impact.peak)
    motions = [impact.motion(vertices, frame) for frame in frames]
    spans = zip([-1, *frames[:-1]], frames, strict=True)
    quantity = moment(run.recipe.test.material.yield_strength)
    still, air = np.zeros_like(impact.stress[0]), heights(run.part.surface.size, landing.fall)
    after = [impact.stress[before + 1 : last + 1].max(axis=0) for before, last in spans]
    stress = channel_of("moment", [*[still] * FALLING, *after])
    deformation = channel_of("deformation", [*[np.zeros_like(motions[0].deformation)] * FALLING, *(one.deformation for one in motions)])
    turn, shift = motions[0].turn, motions[0].shift
    moved = [
        {"above": above, "turn": np.ravel(turn).tolist(), "shift": [*shift[:2].tolist(), float(shift[2]) + above]} for above in air.tolist()
    ]
    moved += [
        {"time": float(impact.time[frame]), "turn": np.ravel(motion.turn).tolist(), "shift": motion.shift.tolist()}
        for frame, motion in zip(frames, motions, strict=True)
    ]
    header = {
        "name": landing.name, "peak": FALLING + frames.index(impact.peak), "frames": moved, "stays": sentences.bend(landing.permanent_set),
        "fall": written(landing.fall),
        "layers": [layer_entry(quantity, stress)], "channels": [stress.spec, deformation.spec],
    }  # fmt: skip
    return ReplayData(header, gzip.compress(stress.packed() + deformation.packed(), 6, mtime=0))


def moments(count: int, peak: int) -> list[int]:
    """At most MOMENTS of `count` frames, the first, the last and that of the peak among them, as even as may be on either side of it."""
    before = round((MOMENTS - 1) * peak / max(count - 1, 1))
    before = min(max(before, min(peak, 1)), MOMENTS - 1 - min(count - 1 - peak, 1))
    sides = (np.linspace(0, peak, min(before, peak) + 1), np.linspace(peak, count - 1, min(MOMENTS - 1 - before, count - 1 - peak) + 1))
    return sorted({round(place) for side in sides for place in side.tolist()})
