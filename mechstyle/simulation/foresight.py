"""What less relief, or a thicker part, may come to before it is tested: a range of what stays bent, worked out of the test that failed.

No drop is made. Nothing stays less bent than the plain part. The shape that stays is linear in the plastic flow, and flow grows faster
than the relief that causes it, so where relief goes no more flow is left than in proportion. Some of what is relieved flows elsewhere: at
the weakest section that is left, where a wall of thickness t bears σ ∝ 1/t² under a bending moment.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from mechstyle.records import Row, Simulation, Verdict, sentences
from mechstyle.records.mesh import Floats, SurfaceMesh
from mechstyle.records.verdict import REPEATS, REPEATS_SHARE

ELSEWHERE = 0.5
"""Share of the flow relieved that returns at most, where the weakest section is left as it is: 0 to 0.41 in ten cures of the trophy."""
OUT_OF_REACH = 0.9
"""A cure after which so much of the flow is left does not reach what bends."""
THINNEST = 0.2
"""Least share of a wall that a relief leaves: thinner is nothing that a mesh has."""
LEVEL = 0.98
"""Places around which this share of the most flows count alike."""

TRIED = 300
"""Vertices around which it is looked, those that flow most."""


class Foreseen(NamedTuple):
    """What a cure may come to.

    Attributes:
        least, most: Range of what stays bent in the worst test [mm].
        why: Why it would not help, in a few words; "" where it may.
    """

    least: float
    most: float
    why: str = ""

    @property
    def words(self) -> str:
        """The range in words."""
        return f"{self.least:.2f} to {self.most:.2f} mm"


def with_less_relief(
    verdict: Verdict, failed: Simulation, plain: Simulation, surface: SurfaceMesh, thickness: ArrayLike, left: ArrayLike, *,
    masked: bool = False,
) -> Foreseen:  # fmt: skip
    """What stays bent where a share of the relief is left.

    Args:
        verdict: The verdict that fails.
        failed: Its simulation.
        plain: The simulation of the part without a relief.
        surface: The part without a relief [mm].
        thickness: Its walls [mm], shape [vertex_count].
        left: Share of the relief that is left, shape [vertex_count].
        masked: Whether masks hold the style back: they let through elsewhere what is relieved, so that as much may stay bent as now.
    """
    walls, shares, why = np.asarray(thickness, np.float64), np.clip(np.asarray(left, np.float64), 0.0, 1.0), ""
    least = most = 0.0
    for row in _rows(verdict):
        flow, base = _flow(row, failed, surface), min(row.plain_permanent_set or 0.0, row.permanent_set)
        of_it = float(flow @ shares / flow.sum()) if flow.any() else 1.0
        stress = plain.stress_of(landing=row.landing, load=row.load)
        share = 1.0 if masked else of_it + ELSEWHERE * (1.0 - of_it) * _weakest(stress, failed.displacement, walls, shares)
        bent = base + share * (row.permanent_set - base)
        least, most = max(least, base), max(most, bent + max(REPEATS, REPEATS_SHARE * bent))
        if row.outcome == "FAILS" and of_it > OUT_OF_REACH:
            why = why or f"hardly any relief goes where it bends, {sentences.landed(row)}"
    return Foreseen(least, most, why)


def held_back(verdict: Verdict) -> Foreseen:
    """What stays bent once the finished relief is corrected: no more than is allowed, as it is lowered until it passes."""
    rows = list(_rows(verdict))
    plain = max(((row.plain_permanent_set or 0.0) for row in rows), default=0.0)
    return Foreseen(plain, max((row.allowed for row in rows), default=0.0))


def certain_share(verdict: Verdict) -> float:
    """Share of the whole relief with which it holds for sure, as no more stays bent than in proportion to it."""
    shares = [1.0]
    for row in _rows(verdict):
        base = row.plain_permanent_set or 0.0
        if row.permanent_set > max(row.allowed, base):
            shares.append(max(row.allowed - base, 0.0) / (row.permanent_set - base))
    return min(shares)


def thickened(verdict: Verdict, failed: Simulation, surface: SurfaceMesh, thickness: ArrayLike, most: float) -> Foreseen:
    """What stays bent of a part without a relief that gets up to `most` thicker on each side [mm].

    A wall under a given moment bears σ ∝ 1/t². Of a blow of given energy it takes a larger moment, M ∝ t^1.5, and bears σ ∝ t^−½.
    """
    walls, found = np.asarray(thickness, np.float64), 0.0
    for row in _rows(verdict):
        flow = _flow(row, failed, surface)
        wall = float(flow @ walls / flow.sum()) if flow.any() else float(np.median(walls))
        grown = wall / (wall + 2.0 * most)
        found = max(found, row.permanent_set * (grown**2 if row.load else grown**0.5))
    return Foreseen(0.0, found)


def hinge(verdict: Verdict, failed: Simulation, surface: SurfaceMesh, reach: float) -> int:
    """The vertex around which most flows in the test that decides, within a reach [mm]: far from it the part is off its shape most."""
    row = verdict.deciding
    flow = np.zeros(len(surface.vertices)) if row is None else _flow(row, failed, surface)
    yields = np.flatnonzero(flow)
    if not len(yields):
        return int(failed.stress.argmax())
    most = yields[np.argsort(-flow[yields], kind="stable")[:TRIED]]
    near = cKDTree(surface.vertices[yields]).query_ball_point(surface.vertices[most], reach)
    around = np.array([flow[yields[one]].sum() for one in near])
    level = most[around >= LEVEL * around.max()]
    return int(level[flow[level].argmax()])


def _rows(verdict: Verdict) -> Iterator[Row]:
    return (row for row in verdict.rows if row.stress is None)


def _flow(row: Row, failed: Simulation, surface: SurfaceMesh) -> Floats:
    """Plastic strain over the surface in the test of a row [mm²], shape [vertex_count]."""
    return np.asarray(failed.strain_of(landing=row.landing, load=row.load) * surface.vertex_areas, np.float64)


def _weakest(stress: ArrayLike, relief: NDArray[np.float32], thickness: Floats, left: Floats) -> float:
    """How near the weakest section that is left comes to the weakest now, by its stress: 0 as without a relief, 1 as now.

    Stress is that of the part without a relief [MPa], relief and thickness in mm, all of shape [vertex_count].
    """
    bare, walls = np.asarray(stress, np.float64), np.maximum(thickness, 1e-6)
    sections = (np.clip(1.0 + share * relief / walls, THINNEST, 1.0) for share in (np.zeros_like(left), np.ones_like(left), left))
    before, now, then = (float((bare / section**2).max()) for section in sections)
    return float(np.clip((then - before) / (now - before), 0.0, 1.0)) if now > before else 0.0
