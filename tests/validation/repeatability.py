"""The same part tested again: turned, mirrored, on other and on finer meshes, followed for twice as long, and with half the step.

σ_V scatters a little; a verdict may change with it only where it says that it is in doubt. Elastic stress does not depend on the yield
strength, so verdicts are asked for with strengths all around σ_V, which no single part would put to the test.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache

import msgspec
import numpy as np

from mechstyle.fea.drop import DropTest
from mechstyle.fea.orientations import landings
from mechstyle.fea.stressed_volume import Walls
from mechstyle.geometry.remeshing import even as standardise
from mechstyle.geometry.remeshing import fill
from mechstyle.records import Landing, Recipe, Simulation, Verdict, judge
from mechstyle.records.mesh import Floats, SurfaceMesh, TetMesh
from mechstyle.simulation.part import prepare
from validation import falls
from validation.cases import Result, bounded, compared
from validation.meshes import ball, box, bracket, cup, refined, roller
from validation.reading import PLA, Body, Styled, period_of_body, styled_cup

TETS = 6_000
VERTICES = (2400, 2700, 3000, 3300, 3600)
"""Of the five triangulations: none shares a triangle with another."""
USUAL = DropTest()
FLAT, NEARLY = 0.03, 0.08
"""Half the range over the mean of σ_V."""
STRENGTHS = np.linspace(0.7, 1.4, 71)
"""Yield strengths that verdicts are asked for, over the mean of σ_V."""
TURNED_VERTICES = 2000


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
        material = msgspec.structs.replace(PLA, yield_strength=strength)
        recipe = Recipe.of(prompt="", material=material)
        return judge(_of_strength(self.styled, strength), _of_strength(self.original, strength), recipe)


def smooth() -> Iterator[Result]:
    """Five triangulations of a square cup, each filled anew."""
    originals = _originals()
    yield from spread("again: cup", originals)
    yield flips("again: cup", [Pair(one, originals[0]) for one in originals])


def styled() -> Iterator[Result]:
    """The same cup in brick, against originals meshed as often."""
    part = styled_cup()
    period = period_of_body(part.unstyled)
    found = [landed(_filled(part.surface, vertices), period, part.smooth) for vertices in VERTICES]
    yield from spread("again_styled: brick cup", found)
    yield flips("again_styled: brick cup", [Pair(one, original) for one, original in zip(found, _originals(), strict=True)])


def numerics() -> Iterator[Result]:
    """A square cup in brick with every time of the rule that ends a drop doubled, and with half the step."""
    part = styled_cup()
    period = period_of_body(part.unstyled)
    usual = _pair(part, period, USUAL)
    for name, longer, step in (("twice as long", 2.0, 1.0), ("half the step", 1.0, 0.5)):
        pair = _pair(part, longer * period, replace(USUAL, safety=step * USUAL.safety))
        yield from changed(f"numerics: {name}", pair.styled, usual.styled)
        yield flips(f"numerics: {name}", [usual, pair])


def numerics_of_a_bar() -> Iterator[Result]:
    """The same of a bar that lands again in four of six tilts."""
    body, ways = Body(falls.BAR), falls.tilted_ways()
    period = period_of_body(body.tets)
    usual = body.dropped(USUAL, ways, period)
    for name, longer, step in (("twice as long", 2.0, 1.0), ("half the step", 1.0, 0.5)):
        other = body.dropped(replace(USUAL, safety=step * USUAL.safety), ways, longer * period)
        for tilt, one, before in zip(falls.TILTS, other, usual, strict=True):
            note = f"{one.stress:.2f} instead of {before.stress:.2f} MPa"
            error = abs(one.stress / before.stress - 1.0)
            yield bounded(f"numerics_bar: {name}, tilted {tilt:g}°", error, NEARLY if tilt > 10.0 else FLAT, note)


def turned() -> Iterator[Result]:
    """An angle bracket as it is, turned about z and mirrored, each prepared from its surface on."""
    model = bracket(30.0, 14.0, 5.0, 1.0).boundary
    ways = {"as it is": np.eye(3), "turned 17°": about_z(17.0), "turned 51°": about_z(51.0), "mirrored": np.diag([-1.0, 1.0, 1.0])}
    found = [dropped_anew(transformed(model, way), TURNED_VERTICES) for way in ways.values()]
    yield from spread("turned: bracket", found)


def dropped_anew(surface: SurfaceMesh, vertices: int) -> Simulation:
    """A surface, prepared and dropped flat and nearly flat."""
    part = prepare(surface, vertices=vertices)
    return landed(part.tets, period_of_body(part.tets), part.surface, walls=Walls(part.surface.vertices, part.thickness))


def transformed(surface: SurfaceMesh, turn: Floats) -> SurfaceMesh:
    """A surface turned, or mirrored, by a matrix of shape [3, 3]."""
    faces = surface.faces if np.linalg.det(turn) > 0.0 else surface.faces[:, [0, 2, 1]]
    return SurfaceMesh(surface.vertices @ np.asarray(turn).T, faces)


def about_z(degrees: float) -> Floats:
    """Rotation about the z-axis, shape [3, 3]."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


@cache
def _originals() -> list[Simulation]:
    """The plain cup in each triangulation."""
    part = styled_cup()
    period = period_of_body(part.unstyled)
    return [landed(_filled(part.smooth, vertices), period, part.smooth) for vertices in VERTICES]


def landed(tets: TetMesh, period: float, plain: SurfaceMesh, test: DropTest = USUAL, walls: Walls | None = None) -> Simulation:
    """A body dropped flat and nearly flat, without fields over its surface.

    Args:
        tets: The body.
        period: Lowest period of the plain part [ms].
        plain: The surface of the plain part, which landings belong to.
        test: Numerical settings.
        walls: Walls of the plain part; None for those of the body.
    """
    ways, body = landings(plain, "fibonacci", 1, nearly_flat=True), Body(tets)
    if walls is not None:
        body.walls = walls
    found = body.dropped(test, ways.normals, period)
    nothing = np.zeros(0, np.float32)
    drops = tuple(
        Landing(name=name, way=way, normal=(0.0, 0.0, 1.0), stress=one.stress, maximum=one.maximum, where=(0.0, 0.0, 0.0),
                fall=test.height, critical_height=_critical(test.height, one.stress, PLA.yield_strength))
        for name, way, one in zip(ways.names, ways.ways, found, strict=True)
    )  # fmt: skip
    return Simulation(displacement=nothing, contact=nothing.astype(bool), landings=drops)


def _critical(fall: float, stress: float, strength: float) -> float:
    """Critical drop height by σ_V ∝ √h [mm]."""
    return fall * (strength / stress) ** 2


def _of_strength(simulation: Simulation, strength: float) -> Simulation:
    """The same drops of a material with another yield strength [MPa]."""
    again = [msgspec.structs.replace(one, critical_height=_critical(one.fall, one.stress, strength)) for one in simulation.landings]
    return replace(simulation, landings=tuple(again))


def _filled(surface: SurfaceMesh, vertices: int) -> TetMesh:
    """New tetrahedra within a new triangulation."""
    return fill(standardise(surface, vertices), TETS)


def _pair(part: Styled, period: float, test: DropTest) -> Pair:
    return Pair(landed(part.morphed, period, part.smooth, test), landed(part.unstyled, period, part.smooth, test))


def _figures(one: Simulation) -> dict[str, tuple[float, float]]:
    """σ_V [MPa] and the scatter that is allowed."""
    nearly = max(landing.stress for landing in one.of("nearly flat"))
    return {"flat": (one.landings[0].stress, FLAT), "nearly flat": (nearly, NEARLY)}


def spread(name: str, found: Sequence[Simulation]) -> Iterator[Result]:
    """Half the range over the mean, of the flat landing and the hardest that is nearly flat."""
    each = [_figures(one) for one in found]
    for label, (_, limit) in each[0].items():
        values = [figures[label][0] for figures in each]
        listed = ", ".join(f"{value:.1f}" for value in values)
        scatter = 0.5 * float(np.ptp(values) / np.mean(values))
        cv = float(np.std(values) / np.mean(values))
        yield bounded(f"{name}, {label}", scatter, limit, f"half the range over the mean of {listed} MPa; standard deviation {cv:.3f}")


def changed(name: str, one: Simulation, usual: Simulation) -> Iterator[Result]:
    """The relative change of σ_V."""
    for (label, (value, limit)), (before, _) in zip(_figures(one).items(), _figures(usual).values(), strict=True):
        yield bounded(f"{name}, {label}", abs(value / before - 1.0), limit, f"{value:.2f} instead of {before:.2f} MPa")


def flips(name: str, pairs: Sequence[Pair]) -> Result:
    """Yield strengths at which one passes and another does not, though not all of them say that they are in doubt."""
    mean, changes, bad = float(np.mean([pair.styled.landings[0].stress for pair in pairs])), 0, 0
    for strength in STRENGTHS * mean:
        verdicts = [pair.verdict(float(strength)) for pair in pairs]
        differ = len({verdict.passes for verdict in verdicts}) > 1
        changes += differ
        bad += differ and any(verdict.sure for verdict in verdicts)
    note = f"of {len(STRENGTHS)} yield strengths from {STRENGTHS[0]:g} to {STRENGTHS[-1]:g} of σ_V = {mean:.1f} MPa; {changes} change"
    return bounded(f"{name}, verdicts that change without a doubt", float(bad), 0.0, note)


POINT, LINE, PLANE = 0.05, 0.12, 0.08
FINE, NEARLY_FINE = 0.06, 0.12
FEW = 3
"""Nearly flat landings that are compared."""


def point() -> Iterator[Result]:
    """A ball of 20 mm: contact at a point."""
    yield from _steady("point", [ball(10.0, cells, 4.0) for cells in (10, 12, 16)], 0.12, POINT)


def line() -> Iterator[Result]:
    """A round bar on its side, 16 × 24 mm: contact along a line."""
    yield from _steady("line", [roller(8.0, 24.0, cells, cells, 6.0) for cells in (10, 12, 16)], 0.1, LINE)


def plane() -> Iterator[Result]:
    """A cube of 16 mm on its side: contact over a plane."""
    yield from _steady("plane", [box((cells, cells, cells), (16.0, 16.0, 16.0)) for cells in (5, 6, 8)], 0.06, PLANE)


def finer() -> Iterator[Result]:
    """A plain cup, and the same with every tetrahedron cut into eight."""
    coarse = cup(12.0, 20.0, 2.0, (28, 8, 3))
    yield from _finer("finer: cup", coarse, coarse)


def finer_styled() -> Iterator[Result]:
    """A square cup in brick whose resting face is plain, and the same with every tetrahedron cut into eight."""
    part = styled_cup()
    yield from _finer("finer: brick cup", part.morphed, part.unstyled)


def _steady(name: str, meshes: Sequence[TetMesh], window: float, limit: float) -> Iterator[Result]:
    """Bodies of about 1, 2 and 4 times as many tetrahedra, each against the finest."""
    found = [Body(mesh).dropped(DropTest(window=window))[0] for mesh in meshes]
    finest, many = found[-1], len(meshes[-1].tets)
    for mesh, one in zip(meshes[:-1], found[:-1], strict=True):
        note = f"{many} TET10; largest stress {one.maximum:.0f} and {finest.maximum:.0f} MPa"
        yield compared(f"{name}: {len(mesh.tets)} tetrahedra", one.stress, finest.stress, limit, "MPa", note)


def _finer(name: str, coarse: TetMesh, plain: TetMesh) -> Iterator[Result]:
    ways = landings(plain.boundary, "fibonacci", 1, nearly_flat=True).normals[: 1 + FEW]
    fine = refined(coarse)
    (flat, *nearly), (flat_finer, *nearly_finer) = (
        [found.stress for found in Body(mesh).dropped(DropTest(window=1.2), ways)] for mesh in (coarse, fine)
    )
    for label, before, after, limit in (("flat", flat, flat_finer, FINE), ("nearly flat", max(nearly), max(nearly_finer), NEARLY_FINE)):
        note = f"{len(coarse.tets)} and {len(fine.tets)} TET10: {before:.1f} and {after:.1f} MPa"
        yield bounded(f"{name}, {label}", abs(before / after - 1.0), limit, note)
