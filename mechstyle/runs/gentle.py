"""Where a part bears much, its relief is delivered as its tetrahedra have it: a file must not hold a notch that no test has seen.

Tetrahedra make the walls of a joint about as wide as their edges are long, and what they do not follow bears no stress in them: a towel
hook in brick read 43 MPa as placed where its file, with walls of 0.25 mm, read 52. Tetrahedra made for the very surface that is delivered
followed 0.91 of it instead of 0.89, took a minute longer to make, and were not always found. So it is the surface that gives way, as a
designer rounds off a groove across bending; elsewhere it stays as crisp as it was drawn.
"""

from __future__ import annotations

import numpy as np

from mechstyle.loop.bounds import Bounds
from mechstyle.records import Simulation
from mechstyle.records.limits import Limits
from mechstyle.records.material import Material
from mechstyle.records.mesh import Field, SurfaceMesh, TetMesh
from mechstyle.styling.drawing.operators import Operators

CRISP, GENTLE = 0.35, 0.55
"""Shares of its limits that the unstylized part bears up to which a relief stays as it was drawn, and from which on it is as it is tested:
the sharp joints of a hook, across bending, bore 1.35 times what the tested ones did."""
ROUNDED = 0.2
"""Over what share of the tetrahedra's edges their facets are rounded off …"""
ROUNDS = 2
"""… in so many steps of diffusion: one leaves a kink."""


def gentle(surface: SurfaceMesh, relief: Field, followed: Field, tets: TetMesh, borne: Field, bounds: Bounds) -> Field:
    """A relief [mm], shape [vertex_count], as its tetrahedra have it where the part bears much; under the part it stays as it is.

    Args:
        surface: The unstylized surface.
        relief: As it was drawn [mm], shape [vertex_count].
        followed: How far the boundary of the tetrahedra goes for it [mm], shape [vertex_count].
        tets: These tetrahedra.
        borne: Share of its limits that the unstylized part bears, shape [vertex_count].
        bounds: How far the style may go.
    """
    share = bounds.freedom * np.clip((borne - CRISP) / (GENTLE - CRISP), 0.0, 1.0)
    share[bounds.standing] = 0.0
    if not share.any():
        return relief
    operators, rounded = Operators(surface), followed.astype(np.float64)
    length = ROUNDED * SurfaceMesh(tets.vertices, tets.boundary_faces).edge_length / np.sqrt(ROUNDS)
    for _ in range(ROUNDS):
        rounded = operators.diffused_in_steps(rounded, length)
    return np.where(share > 0.0, bounds.clipped((relief + share * (rounded - relief)).astype(np.float32)), relief)


def borne(original: Simulation, material: Material) -> Field:
    """Share of its limits that an unstylized part bears on its surface, as placed, tilted and under loads, shape [vertex_count].

    Landings in the other orientations are left out: they are judged where they touch, by an average over 2 mm that sees no notch.
    """
    limits = Limits.of(original, material)
    placed = np.maximum.reduce([one.stress / one.limit for one in limits.as_it_stands(original, original)])
    return placed if original.tilted is None else np.maximum(placed, original.tilted_stress / np.float32(limits.tilted))
