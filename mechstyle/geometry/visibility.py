"""Visibility of a part that stands on the floor: how much of the sky above it each place sees."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechstyle._warp import wp
from mechstyle.geometry.kernels import gather_light
from mechstyle.geometry.proximity import TriangleTree
from mechstyle.records.mesh import Floats, SurfaceMesh, on_floor


def sky_seen(surface: SurfaceMesh, *, directions: int = 64, device: str = "cpu") -> NDArray[np.float32]:
    """Share of the sky that each vertex sees from above the floor, in [0, 1], shape [vertex_count].

    It is the light of an even sky that falls on a vertex, over that on a horizontal face in the open. A free vertical wall has one half.
    The floor gives no light. Vertices that rest on it see nothing, and at the rim of a resting face its share of the area counts as 0.

    Args:
        surface: A closed surface, z up, as it stands on the floor.
        directions: Number of directions the sky is divided into.
        device: Warp device.
    """
    sky, count = _hemisphere(directions), len(surface.vertices)
    tree = TriangleTree(surface.vertices, surface.faces, device)
    normals: Any = wp.array(surface.vertex_normals.astype(np.float32), dtype=wp.vec3, device=device)
    rays: Any = wp.array(sky.astype(np.float32), dtype=wp.vec3, device=device)
    light: Any = wp.empty(count, dtype=wp.float32, device=device)
    inputs = [tree.id, tree.points(surface.vertices), normals, rays, 1e-4 * surface.size, 2.0 * surface.size, light]
    wp.launch(gather_light, dim=count, inputs=inputs, device=device)
    seen = np.clip(light.numpy() / sky[:, 2].sum(), 0.0, 1.0) * (1.0 - _resting(surface))
    return np.asarray(seen, dtype=np.float32)


def _hemisphere(count: int) -> Floats:
    """Evenly spread unit vectors with z > 0, shape [count, 3]: a Fibonacci spiral, each for the same solid angle."""
    k = np.arange(count) + 0.5
    height, angle = k / count, np.pi * (3.0 - np.sqrt(5.0)) * k
    radius = np.sqrt(1.0 - height**2)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height])


def _resting(surface: SurfaceMesh) -> Floats:
    """Share of the area around each vertex that lies on the floor, in [0, 1], shape [vertex_count]."""
    areas = np.where(on_floor(surface), surface.face_areas, 0.0)
    rests = np.bincount(surface.faces.ravel(), np.repeat(areas / 3.0, 3), len(surface.vertices))
    share = np.divide(rests, surface.vertex_areas, out=np.zeros(len(rests)), where=rests > 0.0)
    return np.minimum(share, 1.0)
