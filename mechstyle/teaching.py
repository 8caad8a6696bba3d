"""The part of the lessons, and helpers: a trophy whose neck decides, meshed regularly so that everybody sees the same figures."""

from __future__ import annotations

import hashlib
import html
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import PchipInterpolator

from mechstyle.geometry.thickness import local_thickness
from mechstyle.pictures import fields
from mechstyle.pictures.figure import Panel
from mechstyle.pictures.panels import Picture, picture
from mechstyle.records import Recipe, sentences
from mechstyle.records.mesh import Floats, TetMesh
from mechstyle.runs.recipes import plan
from mechstyle.runs.run import Run, begin
from mechstyle.simulation.part import Workpiece

PROFILE = (
    (21.0, 0.0), (22.0, 1.5), (21.5, 5.0), (13.0, 8.0), (7.0, 14.0), (6.5, 24.0), (6.5, 34.0), (8.5, 40.0), (15.0, 46.0),
    (18.0, 54.0), (17.0, 63.0), (12.0, 70.0), (7.0, 74.0), (3.5, 75.0),
)  # fmt: skip
"""Radius and height of the trophy from its foot to its top [mm]."""
RINGS, LAYERS = 4, 26
"""Rings of triangles in each of its sections, and layers of prisms above each other."""

LESSON: Mapping[str, Any] = {
    "relief": 3.0, "side": "inwards", "iterations": 40, "nearly_flat": False, "window": 0.3,
}  # fmt: skip
"""Settings of all lessons: deep bricks cut into the part; the flat landing alone, because tilted the plain trophy yields by itself."""
FREELY: Mapping[str, Any] = {"control": "none", "guarantee": False, "base": "free", "schedule": "never"}
"""What makes a run Freestyle."""
INK, BLUE, ORANGE, GREEN, GREY = "#1c1c1e", "#1f6fb4", "#d1610f", "#3d8a5f", "#b9bdc4"
"""Colours of the lessons' figures, which differ in grey as well."""
TOP = 90.0
"""End of every scale of stress in the lessons [MPa], so that equal stress has equal colour."""


@cache
def trophy() -> Workpiece:
    """The part of the lessons, ready for a run: surface, tetrahedra and walls."""
    body = turned(PROFILE, RINGS, LAYERS)
    surface = body.boundary
    return Workpiece(surface, body, local_thickness(surface).astype(np.float32), stands=True)


def turned(profile: Sequence[tuple[float, float]], rings: int, layers: int) -> TetMesh:
    """A solid of revolution about z in regular tetrahedra, finer where it is thinner.

    Args:
        profile: Radius and height [mm] from the lowest to the highest point, joined by a smooth line without overshoot.
        rings: Rings of triangles in each section.
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


def _disc(rings: int) -> tuple[Floats, np.ndarray]:
    """Points of a disc of radius 1, six more on each ring, and nearly equilateral triangles between them."""
    turns = [np.arange(6 * ring) * np.pi / (3 * ring) for ring in range(1, rings + 1)]
    points = [np.zeros((1, 2)), *(np.column_stack([np.cos(t), np.sin(t)]) * (len(t) // 6) / rings for t in turns)]
    first = np.cumsum([0, *map(len, points)])
    triangles = []
    for ring in range(1, rings + 1):
        outer, inner = 6 * ring, max(6 * (ring - 1), 1)
        for sector in range(6):
            for step in range(ring):
                here = first[ring] + np.array([sector * ring + step, (sector * ring + step + 1) % outer])
                below = first[ring - 1] + np.array([sector * (ring - 1) + step, sector * (ring - 1) + step + 1]) % inner
                triangles.append((below[0], here[0], here[1]))
                if step < ring - 1:
                    triangles.append((below[0], here[1], below[1]))
    return np.concatenate(points), np.array(triangles)


def run(prompt: str = "brick", *, freely: bool = False, folder: str | Path = "runs", **changes: Any) -> Run:
    """A finished run of the trophy; one that was made before in this folder is only opened.

    Args:
        prompt: The style.
        freely: Whether the style grows without feedback (Freestyle).
        folder: Where the runs of a lesson are kept; each has a folder of its own settings.
        changes: Settings besides `LESSON`.
    """
    recipe = settled(prompt, freely=freely, **changes)
    name = hashlib.sha256(recipe.digest.encode()).hexdigest()[:8]
    return begin(trophy(), recipe, Path(folder) / f"trophy-{name}", name="trophy", device="cpu").go()


def settled(prompt: str = "brick", *, freely: bool = False, **changes: Any) -> Recipe:
    """The recipe of a run of the trophy; arguments as for `run`."""
    return plan(trophy(), prompt, **{**LESSON, **(FREELY if freely else {}), **changes})


Shown = Mapping[str, "Run | tuple[Run, int]"]
"""Runs by the words that stand above them, each at its end or at an iteration: 0 is the part without a style."""


def stress(shown: Shown, title: str = "") -> Picture:
    """Stress of parts side by side, in one scale; what is beyond the limit is hatched.

    Args:
        shown: Runs, or runs at an iteration, by the words that stand above them.
        title: Over all of them.
    """
    panels = []
    for words, (one, iteration) in _at(shown):
        limit = one.recipe.test.material.yield_strength
        flat = one.simulation(iteration).flat
        note = "" if flat is None else f"survives {sentences.length(flat.critical_height)}"
        values, quantity = one.checkpoint(iteration).stress, fields.stress(limit)
        panels.append(Panel(one.surface(iteration), words, values, quantity.unit, quantity.label, (0.0, TOP), limit, note=note))
    return picture(panels, title=title)


def look(shown: Shown, title: str = "") -> Picture:
    """Styled parts side by side, in their colours; arguments as for `stress`."""
    return picture([Panel(one.surface(at) if at else one.part.surface, words) for words, (one, at) in _at(shown)], title=title)


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
    """What each run came to: outcome, the fall it survives, the stress that decides, the style that is left, and its drops."""
    rows = []
    for words, one in runs.items():
        verdict, summary = one.verdict, one.summary
        row = verdict.deciding
        assert row is not None, "a finished run was dropped"
        height = "–" if row.height is None else sentences.length(row.height)
        outcome = sentences.marked(verdict.outcome, sure=verdict.sure)
        rows.append((words, outcome, height, f"{row.stress:.1f}", f"{summary.kept:.0%}", len(summary.simulations)))
    return Table(("run", "outcome", "survives", "stress [MPa]", "style kept", "drops"), rows)


def axes(width: float = 7.2, height: float = 2.9, **options: Any) -> Any:
    """A figure and its axes in the lessons' style; `options` as for matplotlib's `subplots`."""
    import matplotlib.pyplot as plt  # noqa: PLC0415 — loaded when a lesson draws

    plt.rcParams.update({"axes.spines.top": False, "axes.spines.right": False, "font.size": 10})
    return plt.subplots(figsize=(width, height), layout="constrained", **options)
