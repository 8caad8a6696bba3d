"""Probe of one vertex: found by a click on the part, shown as a table."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from html import escape
from typing import Any

import numpy as np
import pythreejs
from numpy.typing import NDArray

from mechstyle.records.mesh import Floats, SurfaceMesh
from mechstyle_widgets.jupyter.language import said
from mechstyle_widgets.viewer.layers import Subject
from mechstyle_widgets.viewer.legend import FAINT, INK

DRAG = 0.3
"""A click this soon after the camera has moved is the end of a drag [s]."""
NOWHERE = (0.0, 0.0, 0.0)
"""Of the scene, about which one orbits: what the browser gets after a click, so that one more at the same place is news."""


class Picker:
    """Clicks on a part, given as the nearest vertex; `three` is the control of pythreejs that listens to the mouse."""

    def __init__(self, part: Any, camera: Any, picked: Callable[[tuple[float, float, float], int], None]) -> None:
        """Call `picked` with the point [mm, about the scene's origin] and the face of every click that is no drag."""
        self.three = pythreejs.Picker(controlling=part, event="click")
        self._picked, self._moved = picked, -DRAG
        camera.observe(self._drag, "position")
        self.three.observe(self._click, "point")

    def _drag(self, change: dict[str, Any]) -> None:
        if not np.allclose(change["old"], change["new"], rtol=1e-4, atol=1e-4):  # a first click rounds the position in the browser
            self._moved = time.monotonic()

    def _click(self, _change: object) -> None:
        point = tuple(self.three.point)
        if point == NOWHERE or self.three.faceIndex is None:
            return
        if time.monotonic() - self._moved > DRAG:
            self._picked(point, self.three.faceIndex)
        self.three.point = NOWHERE


def seen_from(mesh: SurfaceMesh, vertex: int) -> Floats:
    """Direction from which a place is seen, nothing of the part before it: of a few all around the one that is nearest to level with it.

    It is the outward normal where the place is hidden from all of them.
    """
    place, normal = mesh.vertices[vertex], np.asarray(mesh.vertex_normals[vertex], np.float64)
    outside = place + 1e-3 * mesh.size * normal
    for direction in _SIDES[np.argsort(-np.round(_SIDES @ normal, 1), kind="stable")]:
        if direction @ normal > GRAZING and struck(mesh, outside, direction, lambda points: np.ones(len(points), bool)) is None:
            return direction
    return normal


_SIDES = np.array([
    (math.sin(a) * math.cos(e), -math.cos(a) * math.cos(e), math.sin(e))
    for e in np.radians([28.0, 5.0, 60.0, -25.0, -50.0]) for a in np.radians(np.arange(35.0, 395.0, 30.0))
])  # fmt: skip
"""Unit vectors to look from, those that show most of a part first, shape [n, 3]."""
GRAZING = 0.25
"""Cosine of the flattest angle under which a place can be read."""


def struck(mesh: SurfaceMesh, eye: Any, towards: Any, keeps: Callable[[Any], NDArray[np.bool_]]) -> tuple[Floats, int] | None:
    """The first place on a surface [mm] that a line of sight meets where a cut leaves it, and the face; None if it misses it.

    Where the line meets the face from within, as through a cut, it counts for the face, too. `keeps` says of points, shape
    [n, 3], whether they are left.
    """
    corner, along = mesh.corners[:, 0], mesh.corners[:, 1:] - mesh.corners[:, :1]
    across = np.cross(towards, along[:, 1])
    size = np.einsum("ij,ij->i", along[:, 0], across)
    with np.errstate(divide="ignore", invalid="ignore"):  # faces that are seen edge on are not met (Möller and Trumbore 1997)
        away = eye - corner
        u = np.einsum("ij,ij->i", away, across) / size
        turned = np.cross(away, along[:, 0])
        v = turned @ np.asarray(towards) / size
        far = np.einsum("ij,ij->i", turned, along[:, 1]) / size
        met = np.flatnonzero((u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (far > 0.0))
    points = eye + far[met, None] * np.asarray(towards)
    left = np.flatnonzero(keeps(points))
    if not left.size:
        return None
    first = left[far[met][left].argmin()]
    return points[first], int(met[first])


def brief(subject: Subject, vertex: int, name: str) -> str:
    """HTML of where a vertex is, and of its value in the layer of a name."""
    layer, place = subject.layer(name), ", ".join(f"{value:.1f}" for value in subject.mesh.vertices[vertex])
    value = "" if layer is None else f"<b>{escape(said(layer.text_at(vertex)))}</b> &ensp;"
    return f"<span>✕ {value}{said('at')} ({place}) mm</span>"


def table(subject: Subject, vertex: int) -> str:
    """HTML of a vertex's place and of its value in every layer."""
    place, swatch = ", ".join(f"{value:.2f}" for value in subject.mesh.vertices[vertex]), ""
    if subject.mesh.colours is not None:
        r, g, b = np.rint(255 * np.clip(subject.mesh.colours[vertex], 0.0, 1.0)).astype(int).tolist()
        box = f"display:inline-block;width:10px;height:10px;margin-left:8px;border-radius:2px;background:rgb({r},{g},{b})"
        swatch = f'<span title="{said("colour of the style")}" style="{box}"></span>'
    rows = [("place", f"({place}) mm"), *((layer.label, layer.text_at(vertex)) for layer in subject.layers)]
    cells = "".join(
        f'<tr><td style="color:{FAINT};padding-right:12px">{escape(said(name))}</td>'
        f'<td style="font-variant-numeric:tabular-nums">{escape(said(value))}{swatch if name == "place" else ""}</td></tr>'
        for name, value in rows
    )
    rows_of_it = f'<table style="border-spacing:0 1px">{cells}</table>'
    return f'<div style="margin:4px 8px;font-size:12px;line-height:1.45;color:{INK}">{rows_of_it}</div>'
