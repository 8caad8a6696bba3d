"""The thinnest wall a printer can make: how far a style may cut into one, and what to say where a wall is thinner.

A drop does not see a thin wall, because the stress of an impact does not depend on thickness; so walls have a rule of their own.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from mechstyle.records.mesh import Field, Floats, SurfaceMesh

RAMP = 0.5
"""Cutting is slowed from this share of the minimum above it …"""
SEEN = 0.02
"""… and a wall is called too thin from this far below it [mm]; less is rounding."""


def room(thickness: Floats, minimum: float) -> Floats:
    """How deep a wall may be cut from one side without being slowed, should it be cut as deep from the other [mm], at least 0."""
    return np.maximum(0.5 * (thickness - (1.0 + RAMP) * minimum), 0.0)


def freedom(thickness: Field, displacement: Field, minimum: float) -> Field:
    """Factor on movement into the material: 1 for a wall 1.5 times the minimum or more, falling to 0 at the minimum, shape [vertex_count].

    The wall left is reckoned as if its other side were cut as deep, t + 2 min(D, 0), so that both together keep to the minimum.

    t is the local wall thickness of the unstylized part and D goes along the outward normals [mm], shape [vertex_count].
    """
    left = thickness + 2.0 * np.minimum(displacement, 0.0)
    return np.clip((left - minimum) / (RAMP * minimum), 0.0, 1.0).astype(np.float32)


def spared(step: Field, thickness: Field, displacement: Field, minimum: float) -> Field:
    """A step [mm] of which the part into the material is slowed and never leaves less than the minimum; outwards it is free.

    Thickness and displacement are those of `freedom`; a minimum of 0 is no rule.
    """
    if minimum <= 0.0:
        return step
    deepest = np.minimum(0.0, 0.5 * (minimum - thickness) - np.minimum(displacement, 0.0))
    inward = np.maximum(step * freedom(thickness, displacement, minimum), deepest)
    return np.where(step < 0.0, inward, step).astype(np.float32)


def styled_thickness(surface: SurfaceMesh, thickness: Field, displacement: Field) -> Field:
    """Thickness less the relief cut into a wall from both sides [mm], shape [vertex_count].

    The other side is the vertex nearest to where a way of the wall's thickness along the inward normal ends.
    """
    opposite = surface.vertices - surface.vertex_normals * thickness[:, None]
    _, other = cKDTree(surface.vertices).query(opposite)
    cut = np.minimum(displacement, 0.0)
    return (thickness + cut + cut[other]).astype(np.float32)


def warnings(surface: SurfaceMesh, thickness: Field, displacement: Field, minimum: float) -> tuple[str, ...]:
    """One sentence if the part itself has a wall below the minimum, and one if the style leaves such a wall, each with place and value."""
    thickness = surface.dilated(thickness)
    thin = thickness < minimum - SEEN
    styled = styled_thickness(surface, thickness, displacement)
    cut = (styled < minimum - SEEN) & (styled < thickness - SEEN)
    sentences = []
    if thin.any():
        what = f"the part itself has a wall of {_thinnest(surface, thickness, thin)}, thinner than the {minimum:g} mm minimum"
        sentences.append(f"{what}: it may not print")
    if cut.any():
        what = f"the style leaves a wall of {_thinnest(surface, styled, cut)}, thinner than the {minimum:g} mm minimum"
        sentences.append(f"{what}: lower the relief, or let feedback hold it back")
    return tuple(sentences)


def _thinnest(surface: SurfaceMesh, thickness: Field, where: NDArray[np.bool_]) -> str:
    """The smallest thickness among some vertices and its place, in words."""
    vertex = int(np.flatnonzero(where)[thickness[where].argmin()])
    x, y, z = surface.vertices[vertex]
    return f"{max(float(thickness[vertex]), 0.0):.2f} mm at ({x:.1f}, {y:.1f}, {z:.1f}) mm"
