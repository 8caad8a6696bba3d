"""The critical drop height against drops from other heights: too large a height is the unsafe side."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from mechstyle.fea.drop import DropTest
from mechstyle.fea.orientations import landings
from mechstyle.records import Landing
from mechstyle.records.mesh import Floats, TetMesh
from mechstyle.simulation.simulator import exponent_of
from mechstyle.simulation.validation.cases import Result, compared
from mechstyle.simulation.validation.meshes import bracket, cup
from mechstyle.simulation.validation.reading import PLA, Body, period_of_body

FALL = 1500.0
"""Height of the fall asked for [mm]."""
FALLS = {150.0: 0.02, 750.0: 0.01, 3000.0: 0.01}
"""Other heights of a flat fall [mm], and how far σ_V may be from what it should be by σ_V ∝ √h."""
FORMULA, FOUND = 0.01, 0.05


def flat() -> Iterator[Result]:
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


def nearly() -> Iterator[Result]:
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
