"""Isogrid: a lattice of triangular ribs milled from the solid, with bosses at its nodes."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.drawing.tilings import folded
from mechstyle.styling.style import Relief, Style

SIDE, RIB = 24.0, 4.4
ROW = 0.5 * 3.0**0.5 * SIDE


def isogrid(canvas: Canvas) -> Relief:
    """Ribs along three directions around deep pockets."""
    unit = canvas.unit("ribs", RIB, edges=2.2)
    bond = canvas.bond(SIDE * unit, ROW * unit, grip=0.6)
    x, y = bond.x * SIDE, bond.y * ROW
    lean = 0.5 * 3.0**0.5 * x / ROW
    # Distances to the lines through the nodes, level and slanting both ways.
    line = ROW * np.min([np.abs(bond.y), folded(lean - 0.5 * bond.y), folded(lean + 0.5 * bond.y)], axis=0)
    beyond = 0.5 * np.abs(x) + np.abs(y) * ROW / SIDE > 0.5 * SIDE
    node = np.where(beyond, np.hypot(0.5 * SIDE - np.abs(x), ROW - np.abs(y)), np.hypot(x, y))
    rib = smoothstep(0.70 * RIB, 0.35 * RIB, line)
    boss, hole = smoothstep(1.25 * RIB, 0.95 * RIB, node), smoothstep(0.60 * RIB, 0.30 * RIB, node)
    raised = np.maximum(rib, boss)
    cloud = canvas.noise(50.0 * unit, 3, "cloud")
    metal = ramp(["5d656d", "8b949c", "b8bfc5", "e6e9eb"], np.clip(0.20 + 0.60 * raised + 0.15 * cloud, 0.0, 1.0))
    colour = mix(canvas.painted(metal), rgb("2e3338"), 0.8 * hole)
    return Relief(canvas.softened(-1.0 + 1.75 * raised + 0.35 * boss - 0.9 * hole + 0.04 * cloud), canvas.softened(colour))


STYLE = Style(
    name="isogrid",
    description="triangular ribs around milled pockets, as on the panel of a rocket",
    feature_mm=ROW,
    program=isogrid,
)
