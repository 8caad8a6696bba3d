"""The part of demo, Studio and lessons, and helpers: it brings regular tetrahedra, so that all see the same figures."""

from __future__ import annotations

import hashlib
import html
from collections.abc import Mapping, Sequence
from functools import cache
from itertools import permutations
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.interpolate import PchipInterpolator

from mechstyle.loop.store import Store
from mechstyle.pictures import fields
from mechstyle.pictures.panels import Picture, bent_panel, exaggerated, field_panel, picture
from mechstyle.records import Recipe, Row, sentences
from mechstyle.records.mesh import Floats, TetMesh
from mechstyle.runs.recipes import FREESTYLE, plan
from mechstyle.runs.run import Draft, Run
from mechstyle.simulation.part import Model, Origin, Workpiece, prepare
from mechstyle.simulation.simulator import Landed

if TYPE_CHECKING:
    from mechstyle.pictures.figure import Panel

FOOT = 18.0
"""Radius of the trophy's foot [mm]."""
RINGS, LAYERS = (6, 24), 56
"""Vertices on each ring of its sections, outwards, and layers of prisms above each other: so few that it falls in seconds."""

STYLE: Mapping[str, Any] = {
    "relief": 3.0, "side": "inwards", "feature": 11.0, "iterations": 40, "schedule": "never", "nearly_flat": False, "tolerance": "0.1 mm",
}  # fmt: skip
"""Settings of Studio, demo and lessons: bricks of 11 mm, cut up to 3 mm deep into the part, one landing and a close tolerance."""
INK, BLUE, ORANGE, GREEN, GREY = "#1c1c1e", "#1f6fb4", "#d1610f", "#3d8a5f", "#b9bdc4"
"""Colours of the lessons' figures, which differ in grey as well."""


@cache
def trophy(stem: float = 10.0, head: float = 30.0, lean: float = 12.0, rings: Sequence[int] = RINGS, layers: int = LAYERS) -> Model:
    """A heavy head on a slender stem that leans to the right.

    Args:
        stem: Its diameter [mm].
        head: Its diameter [mm].
        lean: How far the head is off the middle of the foot [mm].
        rings: Vertices on each ring of its sections, outwards.
        layers: Layers of prisms above each other.
    """
    r, big, top = 0.5 * stem, 0.5 * head, 51.0
    foot = ((FOOT - 1.0, 0.0), (FOOT, 1.0), (FOOT, 5.0), (FOOT - 2.0, 6.5), (r + 2.5, 8.0), (r, 12.0), (r, top))
    turn = np.radians(40.0)  # a cone, which prints without support, runs into the ball
    centre = top + big * np.sin(turn) + (big * np.cos(turn) - r) / np.tan(turn)
    ball = tuple((big * np.cos(at), centre + big * np.sin(at)) for at in np.linspace(-turn, 0.37 * np.pi, 12))
    upright = turned((*foot, *ball), rings, layers)
    aside = PchipInterpolator([0.0, 9.0, top + 3.0, 2.0 * centre], [0.0, 0.0, lean, lean])(upright.vertices[:, 2])
    body = upright.moved(upright.vertices + np.outer(aside, [1.0, 0.0, 0.0]))
    surface = body.boundary
    return Model(surface.vertices, surface.faces, name="trophy", origin=Origin(vertices=len(surface.vertices)), tets=body)


@cache
def _ready() -> Workpiece:
    """The trophy, ready for a run."""
    return prepare(trophy())


def turned(profile: Sequence[tuple[float, float]], rings: Sequence[int], layers: int) -> TetMesh:
    """A solid of revolution about z in regular tetrahedra, finer where it is thinner.

    Args:
        profile: Radius and height [mm] from the lowest to the highest point, joined by a smooth line without overshoot.
        rings: Vertices on each ring of a section, from the innermost to its rim.
        layers: Layers of prisms, each prism cut into three tetrahedra.
    """
    radius, height = np.array(profile).T
    line = PchipInterpolator(height, radius)
    fine = np.linspace(height[0], height[-1], 2001)
    density = 1.0 / np.clip(line(fine), radius.min() + 1.5, 0.65 * radius.max())
    way = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]) * np.diff(fine))])
    levels = np.interp(np.linspace(0.0, way[-1], layers + 1), way, fine)
    points, triangles = _disc(rings)
    vertices = np.concatenate([np.column_stack([line(z) * points, np.full(len(points), z)]) for z in levels])
    a, b, c = np.sort(triangles, axis=1).T
    up = len(points)
    prism = [(a, b, c, c + up), (a, b, b + up, c + up), (a, a + up, b + up, c + up)]
    tets = np.concatenate([np.stack(corners, axis=1) + layer * up for layer in range(layers) for corners in prism])
    p, q, r, s = (vertices[tets[:, corner]] for corner in range(4))
    inside_out = np.einsum("ij,ij->i", np.cross(q - p, r - p), s - p) < 0.0
    tets[inside_out] = tets[inside_out][:, [0, 2, 1, 3]]
    return TetMesh(vertices, tets.astype(np.int32))


def _disc(rings: Sequence[int]) -> tuple[Floats, np.ndarray]:
    """Points of a disc of radius 1, so many on each ring outwards, and the triangles between them."""
    turns = [np.arange(count) * 2.0 * np.pi / count for count in rings]
    points = [np.zeros((1, 2)), *(np.column_stack([np.cos(t), np.sin(t)]) * at / len(rings) for at, t in enumerate(turns, 1))]
    triangles, below, first = [], (0, 1), 1
    for count in rings:
        inner, outer = ([start + at % many for at in range(many + 1)] for start, many in (below, (first, count)))
        at = 0
        for step in range(count):  # round both rings at once, and ahead on the one that is behind
            triangles.append((inner[at], outer[step], outer[step + 1]))
            while below[1] > 1 and (at + 0.5) * count < (step + 1) * below[1] - 1e-9 and at < below[1]:
                triangles.append((inner[at], outer[step + 1], inner[at + 1]))
                at += 1
        below, first = (first, count), first + count
    return np.concatenate(points), np.array(triangles)


def box(counts: tuple[int, int, int], size: tuple[float, float, float]) -> TetMesh:
    """A box of equal cells, each cut into six tetrahedra: one for each order of the steps along x, y and z.

    Args:
        counts: Cells along each axis.
        size: Its lengths [mm].
    """
    axes = [np.linspace(0.0, length, count + 1) for count, length in zip(counts, size, strict=True)]
    vertices = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    steps = np.array([(counts[1] + 1) * (counts[2] + 1), counts[2] + 1, 1])  # to the next vertex along x, y and z
    cells = np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), axis=-1).reshape(-1, 3) @ steps
    tets = []
    for order in permutations(range(3)):
        corners = np.concatenate([[0], np.cumsum(steps[list(order)])])
        if np.linalg.det(np.eye(3)[list(order)]) < 0.0:
            corners[[2, 3]] = corners[[3, 2]]  # or its volume would be negative
        tets.append(cells[:, None] + corners)
    return TetMesh(vertices, np.stack(tets, axis=1).reshape(-1, 4))


def run(prompt: str = "brick", *, freely: bool = False, folder: str | Path = "runs", **changes: Any) -> Run:
    """A finished run of the trophy; one that was made before in this folder is only opened, and no trophy is dropped twice for it.

    Args:
        prompt: The style.
        freely: Whether the style grows without feedback (Freestyle).
        folder: Where the runs of a lesson are kept; each has a folder of its own settings.
        changes: Settings besides `STYLE`.
    """
    recipe = settled(prompt, freely=freely, **changes)
    place = Path(folder) / f"trophy-{hashlib.sha256(recipe.digest.encode()).hexdigest()[:8]}"
    begun = Draft(recipe, _ready(), name="trophy", folder=place, device="cpu").begin()
    if not begun.finished:
        _teach(begun, [other for other in sorted(place.parent.glob("trophy-*")) if other.name != place.name])
    return begun.go()


def _teach(begun: Run, others: Sequence[Path]) -> None:
    """Let a run know what was dropped for others, so that lessons do not wait for the same fall again.

    A result is named by the digest of all that decides it, so only the same physics on the same tetrahedra is taken for known.
    """
    for memo in (Store(other).memo for other in others):
        for key in memo.named():
            landed = memo.recall(key, Landed)
            if landed is not None:
                begun.store.memo.remember(key, landed)


def settled(prompt: str = "brick", *, freely: bool = False, **changes: Any) -> Recipe:
    """The recipe of a run of the trophy; arguments as for `run`."""
    return plan(_ready(), prompt, **{**STYLE, **(FREESTYLE if freely else {}), **changes})


Shown = Mapping[str, "Run | tuple[Run, int]"]
"""Runs by the words that stand above them, each at its end or at an iteration: 0 is the part without a style."""


def stress(shown: Shown, title: str = "") -> Picture:
    """Stress of parts side by side in the worst test of each; what yields is hatched.

    Args:
        shown: Runs, or runs at an iteration, by the words that stand above them.
        title: Over all of them.
    """
    panels = []
    for words, (one, at) in _at(shown):
        row, test = worst(one, at), one.simulation(at)
        quantity = fields.stress(one.recipe.test.material.yield_strength, row)
        panels.append(field_panel(one.surface(at), quantity, quantity.values_in(test), title=words, note=sentences.figures(row)))
    return picture(panels, title=title)


def look(shown: Shown, title: str = "") -> Picture:
    """Styled parts side by side, in their colours; arguments as for `stress`."""
    return picture(_looks(shown), title=title)


def bent(shown: Shown, title: str = "") -> Picture:
    """Styled parts side by side, each above what stays bent of it in its worst test, all by one factor; arguments as for `stress`."""
    tested = [(one.surface(at), one.simulation(at), worst(one, at)) for _, (one, at) in _at(shown)]
    factor = min(exaggerated(*one) for one in tested)
    below = [bent_panel(*one, factor=factor) for one in tested]
    return picture([*_looks(shown), *below], title=title, columns=len(below))


def worst(one: Run, iteration: int) -> Row:
    """The worst test of a run at an iteration that was tested; 0 is the part without a style, judged by itself."""
    verdict = one.checkpoint(iteration).verdict if iteration else one.summary.plain
    row = None if verdict is None else verdict.deciding
    assert row is not None, "what is shown was tested"
    return row


def _looks(shown: Shown) -> list[Panel]:
    from mechstyle.pictures.figure import Panel  # noqa: PLC0415 — matplotlib is loaded when a picture is wanted

    return [Panel(one.surface(at) if at else one.part.surface, words) for words, (one, at) in _at(shown)]


def _at(shown: Shown) -> list[tuple[str, tuple[Run, int]]]:
    """Runs with the iteration that is shown of each."""
    ends = {words: (one, one.history[-1].iteration) if isinstance(one, Run) else one for words, one in shown.items()}
    return list(ends.items())


class Table:
    """A small table that a notebook draws and a terminal prints."""

    def __init__(self, headings: Sequence[str], rows: Sequence[Sequence[object]]) -> None:
        """A table of these headings and rows."""
        self.rows = [tuple(map(str, headings)), *(tuple(map(str, row)) for row in rows)]

    def __repr__(self) -> str:
        """Columns of one width each."""
        widths = [max(map(len, column)) for column in zip(*self.rows, strict=True)]
        return "\n".join("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in self.rows)

    def _repr_html_(self) -> str:
        kinds = ("th", *("td" for _ in self.rows[1:]))
        rows = ("".join(f"<{kind}>{html.escape(cell)}</{kind}>" for cell in row) for kind, row in zip(kinds, self.rows, strict=True))
        return f"<table>{''.join(f'<tr>{row}</tr>' for row in rows)}</table>"


def table(runs: Mapping[str, Run]) -> Table:
    """What each run came to: outcome, what stays bent in its worst test, the style that is left, and its tests."""
    rows = []
    for words, one in runs.items():
        verdict, summary = one.verdict, one.summary
        row = verdict.deciding
        assert row is not None, "a finished run was dropped"
        outcome = sentences.marked(verdict.outcome, sure=verdict.sure)
        rows.append((words, outcome, sentences.found(row), sentences.label(row), f"{summary.kept:.0%}", len(summary.simulations)))
    return Table(("run", "outcome", "stays bent", "in the test", "style kept", "tests"), rows)


def axes(width: float = 7.2, height: float = 2.9, **options: Any) -> Any:
    """A figure and its axes in the lessons' style; `options` as for matplotlib's `subplots`."""
    import matplotlib.pyplot as plt  # noqa: PLC0415 — loaded when a lesson draws

    plt.rcParams.update({"axes.spines.top": False, "axes.spines.right": False, "font.size": 10})
    return plt.subplots(figsize=(width, height), layout="constrained", **options)
