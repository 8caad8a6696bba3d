"""The same part computed again: on other meshes of other triangulations, followed for twice as long, and with half the step.

Stress scatters; a verdict may change with it only where it says that it is MARGINAL. Elastic stress does not depend on the yield strength,
so verdicts are asked for with strengths all around the stress that decides, which no single part would put to the test.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache

import msgspec
import numpy as np

from mechstyle.fea.criterion import measures
from mechstyle.fea.discretisation import discretise
from mechstyle.fea.drop import Drop, DropTest, drop
from mechstyle.fea.elements import QUADRATIC
from mechstyle.fea.orientations import fibonacci, nearly
from mechstyle.fea.period import lowest_period
from mechstyle.fea.surface_stress import Deciding, SurfaceStress, worst
from mechstyle.fea.verdict import judge
from mechstyle.geometry.remesh import standardise
from mechstyle.geometry.tetrahedra import tetrahedralise
from mechstyle.records import Measures, Simulation, Verdict
from mechstyle.records.material import LIBRARY
from mechstyle.records.mesh import Floats, SurfaceMesh, TetMesh
from mechstyle.simulation.validation import second_impacts
from mechstyle.simulation.validation.bodies import Styled, styled_cup
from mechstyle.simulation.validation.cases import Result, bounded

PLA = LIBRARY["PLA"]
TILTS = 3
MESHES, TETS = 5, 6_000
VERTICES = (2400, 2700, 3000, 3300, 3600)
"""Of the five triangulations: none shares a triangle with another."""
USUAL = DropTest()
LESS_MASS = 0.0001
SURFACE, CONTACT, P99 = 0.03, 0.12, 0.04
STRENGTHS = np.linspace(0.7, 1.4, 71)
"""Yield strengths that verdicts are asked for, over the mean of the deciding stress."""


class Pair(msgspec.Struct, frozen=True):
    """A part and its original, tested alike.

    Attributes:
        styled: The part.
        original: Its original.
    """

    styled: Simulation
    original: Simulation

    def verdict(self, strength: float) -> Verdict:
        """Of the part if its material had another yield strength [MPa]."""
        return judge(self.styled, self.original, msgspec.structs.replace(PLA, yield_strength=strength), "robust")


def smooth() -> Iterator[Result]:
    """Five triangulations of a square cup, each filled anew."""
    originals = [simulation for _, simulation in _originals()]
    yield from spread("again: cup", originals)
    yield flips("again: cup", [Pair(one, originals[0]) for one in originals])


def styled() -> Iterator[Result]:
    """The same cup in brick, against originals meshed as often; besides with a third of the mass that is added."""
    part, period = styled_cup(), _originals()[0][0]
    filled = [_filled(part.surface, vertices) for vertices in VERTICES]
    for name, test in (("brick cup", USUAL), (f"brick cup, {LESS_MASS:.2%} of added mass", DropTest(added_mass=LESS_MASS))):
        found = [landed(tets, period, test) for tets in filled]
        yield from spread(f"again_styled: {name}", found)
        yield flips(f"again_styled: {name}", [Pair(one, original) for one, (_, original) in zip(found, _originals(), strict=True)])


@cache
def _originals() -> list[tuple[float, Simulation]]:
    """The smooth cup in each triangulation, and its lowest period [ms]."""
    part = styled_cup()
    period = _period(part.unstyled)
    return [(period, landed(_filled(part.smooth, vertices), period)) for vertices in VERTICES]


def numerics() -> Iterator[Result]:
    """A square cup in brick with every time of the rule that ends a drop doubled, and with half the step."""
    part = styled_cup()
    period, test = _period(part.unstyled), DropTest()
    variants = {"twice as long": (2.0 * period, test), "half the step": (period, replace(test, safety=0.5 * test.safety))}
    usual = _pair(part, period, test)
    for name, (longer, other) in variants.items():
        pair = _pair(part, longer, other)
        yield from _changed(f"numerics: {name}", pair.styled, usual.styled)
        yield flips(f"numerics: {name}", [usual, pair])


def numerics_of_a_bar() -> Iterator[Result]:
    """The same of a bar that lands again in four of six tilts."""
    tets, ways = second_impacts.BAR, second_impacts.tilted_ways()
    period, test = _period(tets), DropTest()
    usual, halved = _envelope(tets, ways, period, test), replace(test, safety=0.5 * test.safety)
    for name, other in (
        ("twice as long", _envelope(tets, ways, 2.0 * period, test)),
        ("half the step", _envelope(tets, ways, period, halved)),
    ):
        for label, value, before, limit in (
            ("σ_2 of the envelope", other.surface, usual.surface, SURFACE),
            ("average around the contact", other.contact, usual.contact, CONTACT),
            ("p99 of the envelope", other.p99, usual.p99, P99),
        ):
            yield bounded(f"numerics_bar: {name}, {label}", abs(value / before - 1.0), limit, f"{value:.2f} instead of {before:.2f} MPa")


def landed(tets: TetMesh, period: float, test: DropTest = USUAL) -> Simulation:
    """A body dropped as placed, tilted and in three other orientations: the measures of all of them, without fields."""
    ways = nearly(fibonacci(4), TILTS)
    result = drop(tets, PLA, ways.normals, test, device="cpu", period=period)
    deciding = _deciding(tets, result)

    def over(which: slice) -> Measures:
        return measures(tets, result.von_mises[which].max(axis=0), worst(deciding[which]))

    nothing = np.zeros(0, np.float32)
    return Simulation(
        displacement=nothing, stress=nothing, envelope=nothing, probability=nothing, contact=np.zeros(0, bool),
        as_placed=over(slice(1)), tilted=over(slice(1, 1 + TILTS)), overall=over(slice(None)), backed_off=0.0, deviation=0.0,
        time_step=result.time_step, steps=result.steps, added_mass=result.added_mass, failure=result.failure,
    )  # fmt: skip


def _envelope(tets: TetMesh, ways: Floats, period: float, test: DropTest) -> Measures:
    """Measures over all ways to land, [orientations, 3]."""
    result = drop(tets, PLA, ways, test, device="cpu", period=period)
    return measures(tets, result.von_mises.max(axis=0), worst(_deciding(tets, result)))


def _deciding(tets: TetMesh, result: Drop) -> list[Deciding]:
    """The stress that decides in each landing."""
    reading, drops = SurfaceStress(tets), zip(result.von_mises, result.corners, result.contact, strict=True)
    return [reading.of_landing(tets, points, corners, touched) for points, corners, touched in drops]


def _period(tets: TetMesh) -> float:
    return lowest_period(discretise(tets, PLA, DropTest().added_mass, QUADRATIC))


def _filled(surface: SurfaceMesh, vertices: int) -> TetMesh:
    """New tetrahedra within a new triangulation."""
    return tetrahedralise(standardise(surface, vertices), TETS)


def _pair(part: Styled, period: float, test: DropTest) -> Pair:
    return Pair(landed(part.morphed, period, test), landed(part.unstyled, period, test))


def _figures(one: Simulation) -> dict[str, tuple[float, float]]:
    """Values [MPa] and the scatter that is allowed."""
    if one.tilted is None or one.overall is None:
        raise ValueError("dropped as placed only")
    return {
        "σ_2 as placed": (one.as_placed.surface, SURFACE),
        "σ_2 tilted by 3°": (one.tilted.surface, SURFACE),
        "average around the contact": (one.as_placed.contact, CONTACT),
        "p99 of the envelope": (one.overall.p99, P99),
    }


def spread(name: str, found: Sequence[Simulation]) -> Iterator[Result]:
    """Half the range over the mean."""
    each = [_figures(one) for one in found]
    for label, (_, limit) in each[0].items():
        values = [figures[label][0] for figures in each]
        listed = ", ".join(f"{value:.1f}" for value in values)
        scatter = 0.5 * float(np.ptp(values) / np.mean(values))
        yield bounded(f"{name}, {label}", scatter, limit, f"half the range over the mean of {listed} MPa")


def _changed(name: str, one: Simulation, usual: Simulation) -> Iterator[Result]:
    for (label, (value, limit)), (before, _) in zip(_figures(one).items(), _figures(usual).values(), strict=True):
        yield bounded(f"{name}, {label}", abs(value / before - 1.0), limit, f"{value:.2f} instead of {before:.2f} MPa")


def flips(name: str, pairs: Sequence[Pair]) -> Result:
    """Yield strengths at which verdicts differ though not all of them say MARGINAL."""
    mean, flips, bad = float(np.mean([pair.styled.as_placed.peak for pair in pairs])), 0, 0
    for strength in STRENGTHS * mean:
        verdicts = [pair.verdict(float(strength)) for pair in pairs]
        differ = len({verdict.outcome for verdict in verdicts}) > 1
        flips += differ
        bad += differ and not all(verdict.marginal for verdict in verdicts)
    note = f"of {len(STRENGTHS)} yield strengths from {STRENGTHS[0]:g} to {STRENGTHS[-1]:g} of the peak of {mean:.1f} MPa; {flips} change"
    return bounded(f"{name}, verdicts that change without MARGINAL", float(bad), 0.0, note)
