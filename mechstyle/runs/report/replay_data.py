"""A run as a browser plays it: base surface and normals once, then one plane of quantised values per field and iteration.

A vertex moves along its own normal only, so one displacement per vertex makes a frame. Planes that do not change from one
iteration to the next (stress, demand, mask between simulations) are kept once. Each plane is stored as the difference to the one
before, low bytes apart from high bytes, which gzip then packs to a fraction. `static/replay_data.js` unpacks what is packed here.

Of a long run on many vertices some iterations are left out, or a file would have hundreds of megabytes: what was simulated is in it.
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
from mechstyle.loop.objects import Objects
from mechstyle.pictures import scene
from mechstyle.pictures.colormap import ABOVE, LINE, STRIPE, UNKNOWN, Scale
from mechstyle.pictures.fields import Quantity, quantities
from mechstyle.records import sentences
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.runs.report.run_protocol import LaneOfRun, begun

LEVELS = 4095
"""Steps of a quantised field: a quarter of a micrometre for a millimetre of relief."""
MOST = 5_000_000
"""Vertices of all frames together, about: 200 iterations of 25 000 vertices make some 20 MB."""
NO_NUMBER = 65535
"""Stands for a value that is not a number."""

STYLE = {"key": "style", "title": "Style", "label": "", "unit": "", "low": 0.0, "high": 1.0, "threshold": None, "judged": None}
"""The layer of the part's own colours."""

Plane = NDArray[np.uint8] | NDArray[np.uint16]


@dataclass(frozen=True)
class ReplayData:
    """All iterations of a lane.

    Attributes:
        header: What the payload holds, the frames and the layers, as JSON can hold it.
        payload: The packed arrays, gzip.
    """

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


@dataclass(frozen=True, eq=False)
class Channel:
    """One field over all frames.

    Attributes:
        name: Its key in the header.
        planes: The different planes, raw, shape [vertex_count * width] each.
        frames: Plane of each frame.
        low: Value of raw 0.
        step: Value of one raw step.
        width: Numbers per vertex.
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
            "name": self.name, "planes": len(self.planes), "frames": self.frames,
            "low": self.low, "step": self.step, "width": self.width, "size": size,
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

    Raises:
        BadInput: If the lane has no checkpoint yet.
    """
    history = begun(run)
    rows = _shown(per_iteration(history), run.part.surface)
    digests = [run.store.objects.get_record(row.digest, Digests) for row in rows]
    surface = run.part.surface
    shown = quantities(run.recipe, run.store.verdict(history[-1]))
    newest, frames_of = None, list[tuple[Quantity, ...]]()
    for row in rows:
        newest = row.verdict or newest
        frames_of.append(tuple(quantities(run.recipe, newest)))
    each = zip(*frames_of, strict=True)  # the quantities of every frame
    fields = {of[-1].name: _channel(run.store.objects, digests, of) for of in each}
    different, frames = _unique(digests, "colour")
    colours = (run.store.objects.get_array(digest).astype(np.float32) for digest in different)
    planes: list[Plane] = [np.rint(255 * np.clip(colour, 0, 1)).astype(np.uint8).ravel() for colour in colours]
    channels = [*fields.values(), Channel("colour", planes, frames, width=3)]
    header = {
        "name": run.record.name,
        "prompt": run.recipe.style.prompt,
        "vertices": len(surface.vertices),
        "faces": len(surface.faces),
        "frames": [_frame(row) for row in rows],
        "layers": [STYLE, *(layer_entry(quantity, fields[quantity.name]) for quantity in shown)],
        "channels": [channel.spec for channel in channels],
        "colours": palette(),
        "light": light(),
    }
    arrays = (surface.vertices.astype("<f4"), surface.vertex_normals.astype("<f4"), surface.faces.astype("<u4"))
    packed = b"".join([*(array.tobytes() for array in arrays), *(channel.packed() for channel in channels)])
    return ReplayData(header, gzip.compress(packed, 6, mtime=0))


def _shown(rows: Sequence[Row], surface: SurfaceMesh) -> list[Row]:
    """The iterations to show: all, or the simulated ones, the last and as many others, evenly, as MOST allows."""
    every = max(1, round(len(rows) * len(surface.vertices) / MOST))
    return [row for number, row in enumerate(rows) if row.verdict is not None or row is rows[-1] or number % every == 0]


def _unique(digests: Sequence[Digests], key: str) -> tuple[list[str], list[int]]:
    """Different digests in order of appearance, and which of them each frame has."""
    wanted = [getattr(one, key) for one in digests]
    order = {digest: place for place, digest in enumerate(dict.fromkeys(wanted))}
    return list(order), [order[digest] for digest in wanted]


def _channel(objects: Objects, digests: Sequence[Digests], each: Sequence[Quantity]) -> Channel:
    """A scalar field quantised to LEVELS steps between its extremes, made as the quantity of the frame it appears in."""
    quantity = each[-1]
    different, frames = _unique(digests, quantity.source)
    arrays = [each[frames.index(place)].made(objects.get_array(digest)) for place, digest in enumerate(different)]
    known = [array[np.isfinite(array)] for array in arrays]
    low = min((float(array.min()) for array in known if array.size), default=0.0)
    high = max((float(array.max()) for array in known if array.size), default=0.0)
    step = (high - low) / LEVELS or 1.0
    return Channel(quantity.name, [_quantised(array, low, step) for array in arrays], frames, low, step)


def channel_of(name: str, arrays: Sequence[NDArray[Any]]) -> Channel:
    """Frames of a field, shape [vertex_count] or [vertex_count, width], all quantised to LEVELS steps between their extremes."""
    low, high = (float(pick([end(array) for array in arrays])) for pick, end in ((min, np.min), (max, np.max)))
    step = (high - low) / LEVELS or 1.0
    width = 1 if arrays[0].ndim == 1 else arrays[0].shape[1]
    return Channel(name, [_quantised(np.ravel(array), low, step) for array in arrays], list(range(len(arrays))), low, step, width)


def _quantised(values: NDArray[np.float32], low: float, step: float) -> Plane:
    raw = np.full(values.shape, NO_NUMBER, "<u2")
    known = np.isfinite(values)
    raw[known] = np.rint((values[known].astype(np.float64) - low) / step)
    return raw


def _frame(row: Row) -> dict[str, Any]:
    """A frame; stress and limit are of the test that decides [MPa], 0 without an answer."""
    frame = {
        "iteration": row.iteration, "simulatedAt": row.simulated_at, "reason": row.reason,
        "restrained": round(row.share, 5), "loss": row.style_loss,
    }
    verdict = row.verdict
    if verdict is None:
        return frame
    decides = verdict.deciding
    figures = {"stress": 0.0, "limit": verdict.strength} if decides is None else {"stress": decides.stress, "limit": decides.limit}
    return {**frame, "outcome": sentences.marked(verdict.outcome, sure=verdict.sure), "words": sentences.note(verdict), **figures}


def layer_entry(quantity: Quantity, channel: Channel) -> dict[str, Any]:
    """A field as the table of quantities has it, with colours that show it in every frame."""
    low, high = quantity.limits(channel.extremes) or channel.extremes
    return {
        "key": quantity.name, "title": quantity.title.capitalize(), "label": quantity.label, "unit": quantity.unit,
        "low": low, "high": high, "threshold": quantity.threshold, "judged": quantity.judged,
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
