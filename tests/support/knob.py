"""A knob that brings its tetrahedra: a run of it takes two seconds, where fTetWild alone takes twenty to fill another part twice."""

from __future__ import annotations

from mechstyle.simulation.part import Model, Origin
from mechstyle.teaching import turned

SETTINGS = {
    "prompt": "brick", "iterations": 12, "orientations": 1, "schedule": "every", "every": 4, "nearly_flat": False, "window": 0.3,
    "element": "tet4",
}  # fmt: skip
"""A run of it that is simulated at iterations 4, 8 and 12."""


def knob() -> Model:
    """A round knob of 40 mm diameter and 30 mm height."""
    body = turned(((19.0, 0.0), (20.0, 1.0), (20.0, 22.0), (16.0, 30.0)), (8, 24, 48), 20)
    surface = body.boundary
    return Model(surface.vertices, surface.faces, name="knob", origin=Origin(vertices=len(surface.vertices)), tets=body)
