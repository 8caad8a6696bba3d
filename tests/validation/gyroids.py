"""Gallery parts as they are printed, three walls around 15 % gyroid: each sheet meshed, beside the same smeared out."""

from __future__ import annotations

from collections.abc import Iterator

import manifold3d
import numpy as np

import mechstyle as ms
from mechstyle.fea.drop import drop, resolve_device
from mechstyle.fea.permanent_set import measured
from mechstyle.geometry.proximity import TriangleTree
from mechstyle.geometry.remeshing.filling import _set_down, _tidied
from mechstyle.geometry.remeshing.tetwild import Settings, tetwild
from mechstyle.records.mesh import Floats, SurfaceMesh, TetMesh
from mechstyle.records.recipe import Printed
from mechstyle.runs.recipes import recipe_for
from mechstyle.simulation.part import cached_memo, fitted, prepare
from mechstyle.simulation.physics import prescribed
from mechstyle.simulation.printed import STRETCHED
from mechstyle.simulation.simulator import DropSimulator
from validation.cases import Result, bounded, compared

PARTS = ("cable_clip", "drawer_knob", "cable_winder", "key_tag", "spectacle_frame", "s_hook")
"""The six lightest of the gallery: of larger ones the meshes take hours."""
VERTICES = 3000
SHARE, LENGTH = 0.20, 0.05
"""What stays bent may differ by this share, or by this length [mm]."""
STEP, EDGE, SHIFT = 0.25, 0.3, 0.05
"""Spacing of the points in which voids are looked for, longest edge of their surface, and how far simplifying may move that [mm]: coarser
ones lose half of a sheet."""
LONGEST = 1.2
"""Edges that tetrahedra may have where nothing is thinner [mm]."""
AREA = 3.0915
"""Area of a gyroid in a cube of period 1 (Schoen 1970)."""


def gyroids() -> Iterator[Result]:
    """In the hardest of the landings that are nearly flat: what stays bent, and whether that is too much."""
    for name in PARTS:
        yield from gyroid_in(name)


def gyroid_in(name: str) -> Iterator[Result]:
    """One part of the gallery; six to twenty minutes of a core."""
    part = prepare(ms.load(f"gallery:{name}"), vertices=VERTICES)
    recipe, memo, device = fitted(recipe_for("brick", infill="15 %"), part), cached_memo(), resolve_device("auto")
    landings = DropSimulator(part, recipe, memo, memo, device).baseline.landings
    hardest = max((one for one in landings if one.way == "nearly flat"), key=lambda one: one.permanent_set)
    sheets = meshed(part.surface, recipe.printed)
    found = drop(sheets, recipe.test.material, [hardest.normal], prescribed(recipe), device=device)
    reference = measured(sheets, found.permanent[0], found.tension_strain[0]).permanent_set
    limit, count = max(SHARE, LENGTH / max(reference, 1e-6)), f"{len(sheets.tets)} tetrahedra, each sheet meshed"
    yield compared(f"gyroids: {name}, nearly flat", hardest.permanent_set, reference, limit, "mm", count)
    holds = [float(length <= recipe.test.tolerance) for length in (hardest.permanent_set, reference)]
    yield bounded(f"gyroids: {name}, whether it holds", abs(holds[0] - holds[1]), 0.0, "outcomes differ by 1")


def meshed(surface: SurfaceMesh, printed: Printed) -> TetMesh:
    """Tetrahedra of a part without the voids of its gyroid."""
    hull = manifold3d.Manifold(manifold3d.Mesh(surface.vertices.astype(np.float32), surface.faces.astype(np.uint32)))
    solid = (hull - voids(surface, printed)).simplify(SHIFT).to_mesh()
    vertices, faces = np.asarray(solid.vert_properties, np.float64)[:, :3], np.asarray(solid.tri_verts, np.int32)
    size = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    found = _tidied(*tetwild(vertices, faces, Settings(LONGEST, 0.6 * SHIFT / size), timeout=3600.0))
    return _set_down(surface, found, 1.5 * SHIFT)


def voids(surface: SurfaceMesh, printed: Printed) -> manifold3d.Manifold:
    """What a slicer leaves empty: neither within the walls or solid layers, nor in a sheet that is one line thick."""
    low = surface.vertices.min(axis=0)
    count = np.ceil((surface.vertices.max(axis=0) - low) / STEP).astype(int) + 1
    points = low + STEP * np.stack(np.meshgrid(*map(np.arange, count), indexing="ij"), axis=-1).reshape(-1, 3)
    near = TriangleTree(surface.vertices, surface.faces).nearest(points)
    outwards = np.einsum("ij,ijk->ik", near.weights, surface.vertex_normals[surface.faces[near.face]])
    inside = np.einsum("ij,ij->i", near.point - points, outwards) > 0.0
    depth = np.where(inside, sheet_distance(points, printed) - 0.5 * printed.line_width, -near.distance)
    up = surface.face_normals[:, 2]
    for stretch, faces, deep in (
        ([1.0, 1.0, STRETCHED], np.isfinite(up), printed.walls * printed.line_width),
        ([STRETCHED, STRETCHED, 1.0], up > 0.0, printed.top * printed.layer_height),
        ([STRETCHED, STRETCHED, 1.0], up < 0.0, printed.bottom * printed.layer_height),
    ):
        shell = TriangleTree(surface.vertices * stretch, surface.faces[faces]).nearest(points * stretch).distance
        depth = np.minimum(depth, shell - deep)
    field = depth.reshape(count).astype(np.float32)

    def between(*place: float) -> float:
        """Depth at a place by the eight points around it; a plain function, as it is called millions of times."""
        i, j, k = ((place[axis] - low[axis]) / STEP for axis in range(3))
        a, b, c = int(i), int(j), int(k)
        if min(i, j, k) < 0.0 or a + 2 > count[0] or b + 2 > count[1] or c + 2 > count[2]:
            return -STEP
        around = field[a : a + 2, b : b + 2, c : c + 2]
        around = around[0] * (a + 1 - i) + around[-1] * (i - a)
        around = around[0] * (b + 1 - j) + around[-1] * (j - b)
        return float(around[0] * (c + 1 - k) + around[-1] * (k - c))

    return manifold3d.Manifold.level_set(between, [*low, *(low + STEP * (count - 1))], EDGE)


def sheet_distance(points: Floats, printed: Printed) -> Floats:
    """Distance of points from the surface sin x cos y + sin y cos z + sin z cos x = 0 whose sheets fill what infill says [mm]."""
    per_mm = 2.0 * np.pi * printed.infill / (AREA * printed.line_width)
    x, y, z = points.T * per_mm
    value = np.sin(x) * np.cos(y) + np.sin(y) * np.cos(z) + np.sin(z) * np.cos(x)
    slope = np.sqrt(
        (np.cos(x) * np.cos(y) - np.sin(z) * np.sin(x)) ** 2
        + (np.cos(y) * np.cos(z) - np.sin(x) * np.sin(y)) ** 2
        + (np.cos(z) * np.cos(x) - np.sin(y) * np.sin(z)) ** 2
    )
    return np.asarray(np.abs(value) / np.maximum(slope, 0.3) / per_mm)
