"""What was molten, or will be: ice, cut glass and lava."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, smoothstep
from mechstyle.styling.drawing.tilings import dome
from mechstyle.styling.style import Relief, Style

ICICLE, CUT, PLATE = 11.0, 26.0, 30.0


def ice(canvas: Canvas) -> Relief:
    """Ledges of ice with icicles below, round and pointed, each of its own length and width."""
    unit = canvas.unit("icicles", 0.6 * ICICLE, edges=2.2)
    bond = canvas.bond(ICICLE * unit, 2.7 * ICICLE * unit, shift=0.37, grip=0.6)
    frost, bent = canvas.noise(7.0 * unit, 2, "frost"), canvas.noise(14.0 * unit, 2, "bent")
    column = canvas.pieces((np.abs(bond.x) < 0.42) & (np.abs(bond.y) < 0.44), bond.odd)
    own = canvas.random(column, "own") * (np.abs(bond.x) < 0.42)
    down = 0.5 - bond.y
    tip = np.clip((0.55 + 0.42 * own - down) / (0.45 + 0.42 * own), 0.0, 1.0)  # 0 where it ends, 1 near the ledge
    width = (0.36 + 0.14 * own) * tip**0.8
    aside = np.abs(bond.x + 0.10 * bent * down) / np.maximum(width, 1e-3)
    icicle = dome(aside) * smoothstep(0.0, 0.10, width) * (0.60 + 0.40 * tip)
    ledge = dome(np.clip(np.abs(down - 0.09 - 0.05 * bent) / (0.14 + 0.03 * frost), 0.0, 1.0))
    body = np.maximum(icicle, 0.95 * ledge)
    blue = ramp(["4f93bd", "8cc4e0", "cbe8f4", "f6fcfe"], np.clip(0.14 + 0.72 * body + 0.16 * frost, 0.0, 1.0))
    return Relief(canvas.softened(-0.85 + 1.80 * body + 0.10 * frost), canvas.softened(canvas.painted(blue)))


def glass(canvas: Canvas) -> Relief:
    """Cut glass: crossing grooves part diamonds, and each is cut into a star of sharp rays."""
    unit = canvas.unit("cuts", 4.0, edges=2.0)
    bond = canvas.bond(CUT * unit, 1.35 * CUT * unit, shift=0.5)
    ax, ay = np.abs(bond.x), np.abs(bond.y)
    beyond = ax + ay > 0.5  # the corners of a cell belong to the diamonds between
    x, y = np.where(beyond, 0.5 - ax, ax), np.where(beyond, 0.5 - ay, ay)
    edge = (0.5 - x - y) * 0.8 * CUT
    angle = np.arctan2(y, x)
    ray = np.abs(np.cos(4.0 * angle))
    reach = np.clip(np.hypot(x, y) / 0.36, 0.0, 1.0)
    star = ray * smoothstep(0.0, 0.35, reach) * smoothstep(1.0, 0.75, reach) - 0.9 * smoothstep(0.9, 0.0, reach) * (1.0 - ray)
    groove = smoothstep(3.0, 0.0, edge)
    flow = canvas.noise(45.0 * unit, 2, "flow")
    height = 0.35 + 0.75 * star - 1.35 * groove + 0.06 * flow
    tone = np.clip(0.45 + 0.40 * star - 0.30 * groove + 0.25 * flow, 0.0, 1.0)
    return Relief(canvas.softened(height), canvas.softened(canvas.painted(ramp(["5f9aa0", "a5d0d2", "d9eeee", "fbffff"], tone))))


def lava(canvas: Canvas) -> Relief:
    """A crust that wrinkled into ropes as it flowed and broke into plates, with fire between."""
    unit = canvas.unit("ropes of lava", 5.0, edges=2.2)
    plates = canvas.cells(PLATE * unit, "plates", at=canvas.warped(22.0 * unit, 6.0 * unit, "outline"))
    edge = plates.edge / unit
    crust = smoothstep(1.2, 4.0, edge + 0.8 * canvas.noise(8.0 * unit, 2, "ragged"))
    bend = canvas.noise(26.0 * unit, 2, "bend")
    turn = 2.0 * np.pi * canvas.random(plates.identity, "turn")
    slope = canvas.points @ np.array([[1.0, 0.2], [0.3, -0.2], [0.1, 1.0]])
    rope = np.abs(np.sin(np.pi * ((slope[:, 0] * np.cos(turn) + slope[:, 1] * np.sin(turn)) / (6.5 * unit) + 1.7 * bend)))
    rough = canvas.noise(6.0 * unit, 2, "rough")
    height = -1.05 + crust * (0.75 + 0.95 * rope + 0.22 * rough + 0.15 * smoothstep(3.0, 12.0, edge))
    basalt = ramp(["141213", "2a2526", "4a4142"], np.clip(0.10 + 0.60 * rope + 0.25 * rough, 0.0, 1.0))
    fire = ramp(["b3200a", "f0590e", "fdb52b", "fff0a0"], np.clip(smoothstep(4.5, 0.0, edge) + 0.15 * rough, 0.0, 1.0))
    return Relief(canvas.softened(height), canvas.softened(mix(fire, canvas.painted(basalt), crust)))


STYLES = {
    style.name: style
    for style in (
        Style(name="ice", description="icicles hanging in rows from a frozen sheet", feature_mm=1.8 * ICICLE, program=ice),
        Style(name="glass", description="cut glass, stars of sharp rays in diamonds", feature_mm=0.5 * CUT, program=glass),
        Style(name="lava", description="a dark ropy crust with fire in its cracks", feature_mm=PLATE, program=lava),
    )
}
