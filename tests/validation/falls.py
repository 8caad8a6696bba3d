"""Falls against other falls: critical heights against drops from there, and parts that land again against a window without a break.

Too large a height is the unsafe side.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from mechstyle.fea.backends.cpu import CoreBody
from mechstyle.fea.discretisation import Discretisation, discretise
from mechstyle.fea.drop import Drop, DropTest, drop, tracks_for
from mechstyle.fea.elements import QUADRATIC
from mechstyle.fea.explicit import no_progress
from mechstyle.fea.flight import RigidBody
from mechstyle.fea.linear_solvers import lowest_period
from mechstyle.fea.orientations import directions, landings
from mechstyle.fea.phases import IMPULSE, MIN_IMPULSE, MIN_SPEED_RATIO, QUIET_TIME, Track, follow
from mechstyle.fea.stressed_volume import DROPPED
from mechstyle.records import Landing
from mechstyle.records.mesh import Floats, TetMesh
from mechstyle.simulation.simulator import exponent_of
from validation.cases import Result, bounded, compared
from validation.meshes import box, bracket, cup, open_ring
from validation.reading import PLA, Body, period_of_body

TOUCH, WORST = 0.03, 0.05
BAR = box((30, 5, 1), (120.0, 20.0, 4.0))
TILTS = (3.0, 10.0, 20.0, 35.0, 45.0, 55.0)
"""Of the bar [degrees]."""


def bar() -> Iterator[Result]:
    """A bar of 120 × 20 × 4 mm that lands on one end, tilted by 3° to 55°; its other end comes down later, and faster."""
    yield from _landed_again("second_bar", BAR, tilted_ways(), 20.0, [f"tilted {angle:g}°" for angle in TILTS])


def large_cup() -> Iterator[Result]:
    """A cup of the size of a pen holder in five orientations."""
    yield from _landed_again("second_cup", cup(40.0, 100.0, 3.0, (28, 8, 3)), directions(5), 10.0, _landing_names(5))


def ring() -> Iterator[Result]:
    """An open ring, 70 × 40 mm of 6 × 6 mm, in five orientations: nothing in it is compact."""
    yield from _landed_again("second_ring", open_ring(35.0, 20.0, 6.0, 40), directions(5), 12.0, _landing_names(5))


def tilted_ways() -> Floats:
    """Floor normals of the bar, which lands with one end, shape [TILTS, 3]."""
    turn = np.radians(TILTS)
    ways = np.stack([np.sin(turn), 0.05 * np.sin(turn), np.cos(turn)], axis=1)
    return np.asarray(ways / np.linalg.norm(ways, axis=1, keepdims=True))


def _landed_again(name: str, tets: TetMesh, normals: Floats, window: float, labels: Sequence[str]) -> Iterator[Result]:
    body = discretise(tets, PLA, DropTest().added_mass, QUADRATIC)
    period = lowest_period(body)
    by_rule = drop(tets, PLA, normals, device="cpu", period=period)
    tracks, scheme = tracks_for(body, PLA, normals, DropTest(window=window))
    follow(CoreBody(body), scheme, tracks, no_progress)
    rigid, missed = RigidBody.of(body, scheme.gravity), 0
    for label, phases, track in zip(labels, by_rule.phases, tracks, strict=True):
        later = later_touches(track, rigid, period)
        missed += sum(met.speed > MIN_SPEED_RATIO * track.rule.speed and met.time > phases[-1].end for met in later)
        if len(phases) > 1:
            known = later or [Met(math.inf, math.inf)]  # a touch that never comes fails
            nearest = known[int(np.argmin([abs(met.time - phases[1].start) for met in known]))]
            yield compared(f"{name}: {label}, time of the second touch", phases[1].start, nearest.time, TOUCH, "ms", "the window")
            yield compared(f"{name}: {label}, its speed", phases[1].speed, nearest.speed, TOUCH, "m/s", "the window")
    again = sum(len(phases) - 1 for phases in by_rule.phases)
    limit = f"touches at {MIN_SPEED_RATIO:g} of the first speed or more after the end of the drop; {again} touches were followed"
    yield bounded(f"{name}: touches missed in {window:g} ms", float(missed), 0.0, limit)
    yield _worst(name, tets, by_rule, _in_callers_order(tracks, body), period)


def _worst(name: str, tets: TetMesh, by_rule: Drop, whole: Floats, period: float) -> Result:
    """The largest σ_V of all landings; the note gives each, which the vibration at the second touch decides by chance."""
    body = Body(tets)
    here, there = ([body.read(corners, DROPPED).stress for corners in stress] for stress in (by_rule.corners, whole))
    each = ", ".join(f"{one:.1f} ({other:.1f})" for one, other in zip(here, there, strict=True))
    simulated = sum(phase.end - phase.start for phases in by_rule.phases for phase in phases) / len(by_rule.phases)
    note = f"the window; each landing (in the window): {each}; by the rule {simulated:.1f} ms a drop, T1 {period:.2f} ms"
    return compared(f"{name}: largest σ_V", max(here), max(there), WORST, "MPa", note)


def _in_callers_order(tracks: Sequence[Track], body: Discretisation) -> Floats:
    """Largest stress of each drop at the corners of the tetrahedra [MPa], shape [orientations, tet_count, 4]."""
    stress = np.stack([track.corners for track in tracks if track.corners is not None]).astype(np.float64)
    ordered = np.empty_like(stress)
    ordered[:, body.tet_order] = stress
    return ordered


def _landing_names(count: int) -> list[str]:
    return [f"landing {number}" for number in range(count)]


class Met(NamedTuple):
    """A touch after the first.

    Attributes:
        time: Since first touch [ms].
        speed: Of the touching point [mm/ms].
    """

    time: float
    speed: float


def later_touches(track: Track, rigid: RigidBody, period: float) -> list[Met]:
    """Touches after the first in a drop without a break, each found from the rigid motion at the last sample but one before it.

    At the last one vibration may already let another point of an edge come first.
    """
    samples, normal = track.samples[0], track.normals[0]
    pushed = np.diff(samples[:, IMPULSE]) > MIN_IMPULSE * rigid.mass * track.rule.speed
    on = np.flatnonzero(pushed)  # the push comes between this sample and the next
    first = on[1:][np.diff(on) * track.interval > QUIET_TIME * period]
    found = []
    for sample in first:
        touch = rigid.next_touch(rigid.motion(samples[sample - 1]), normal)
        if touch is not None:
            found.append(Met(track.interval * (sample - 1) + touch.after, touch.speed))
    return found


FALL = 1500.0
"""Height of the fall asked for [mm]."""
FALLS = {150.0: 0.02, 750.0: 0.01, 3000.0: 0.01}
"""Other heights of a flat fall [mm], and how far σ_V may be from what it should be by σ_V ∝ √h."""
FORMULA, FOUND = 0.01, 0.05


def flat_heights() -> Iterator[Result]:
    """Flat landings, whose critical height follows from one drop: σ_V of drops from there and from other heights."""
    for name, tets in _bodies().items():
        body, period = Body(tets), period_of_body(tets)
        stress = _dropped(body, FALL, period)
        critical = FALL * (PLA.yield_strength / stress) ** 2
        note = f"the yield strength, from the critical height of {critical:.0f} mm by a drop from {FALL / 1000.0:g} m"
        yield compared(f"heights_flat: {name}, h*", _dropped(body, critical, period), PLA.yield_strength, FORMULA, "MPa", note)
        for height, limit in FALLS.items():
            scaled, note = stress * math.sqrt(height / FALL), f"σ_V of a drop from {FALL / 1000.0:g} m, by σ_V ∝ √h"
            yield compared(f"heights_flat: {name}, {height / 1000.0:g} m", _dropped(body, height, period), scaled, limit, "MPa", note)


def nearly_flat_heights() -> Iterator[Result]:
    """The hardest nearly flat landing, whose critical height takes further drops: a last drop from there."""
    for name, tets in _bodies().items():
        body, period = Body(tets), period_of_body(tets)
        ways = landings(tets.boundary, "fibonacci", 1, nearly_flat=True).normals[1:]
        stresses = [_dropped(body, FALL, period, way) for way in ways]
        way, stress = ways[int(np.argmax(stresses))], max(stresses)
        first = FALL * (PLA.yield_strength / stress) ** 2
        landing = Landing(name=name, way="nearly flat", normal=(0.0, 0.0, 1.0), stress=stress, maximum=stress, where=(0.0, 0.0, 0.0),
                          fall=FALL, critical_height=first)  # fmt: skip
        exponent, drops = exponent_of(landing, PLA.yield_strength, lambda height: _dropped(body, height, period, way))  # noqa: B023 — used at once
        critical = FALL * (PLA.yield_strength / stress) ** (1.0 / exponent)
        there = _dropped(body, critical, period, way)
        note = f"the yield strength, from h* = {critical:.0f} mm after {drops} more drops, p = {exponent:.2f}; first guess {first:.0f} mm"
        yield compared(f"heights_nearly: {name}, h*", there, PLA.yield_strength, FOUND, "MPa", note)


def _bodies() -> dict[str, TetMesh]:
    return {"cup": cup(20.0, 30.0, 2.5, (28, 8, 3)), "bracket": bracket(40.0, 16.0, 4.0, 4.0)}


def _dropped(body: Body, height: float, period: float, way: Floats | None = None) -> float:
    """σ_V of a fall [MPa], flat unless another floor normal is given."""
    normals = ((0.0, 0.0, 1.0),) if way is None else way[None]
    stress = body.dropped(DropTest(height=height), normals, period)[0].stress
    return stress if math.isfinite(stress) else math.inf
