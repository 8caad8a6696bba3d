"""Load factors of plates and bars in bending against beam theory, and details: those of the part must count, those of the mesh must not.

Too large a factor is the unsafe side. σ_V lies below the fibre stress by as much as the fibre stress falls over V0. A factor counts from
first yield of the fibre; a plastic hinge needs 1.5 times that load in a rectangular section and 1.7 times in a round one, so beyond that
nothing may pass.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import msgspec
import numpy as np
from scipy.optimize import brentq

from mechstyle.fea.stressed_volume import LOADED, THIN
from mechstyle.records.mesh import Bools, Floats, TetMesh
from validation.cases import Result, bounded, compared
from validation.meshes import THICKNESS, WIDTH, bar_with_fillets, bar_with_hole, box, bracket, carved, round_bar
from validation.reading import PLA, Body

NOMINAL = 10.0
"""Stress away from the detail [MPa]."""
BRIDGE, PIN = 0.05, 0.05
HOLE, FILLET = 3.35, 1.86
"""Stress concentration: Ø 6 in 20 mm over the stress far away (Howland 1930), radius 2 from 16 to 20 mm over that in the narrow part
(Pilkey, Peterson's Stress Concentration Factors)."""
SAME = 0.05
SHARE = {"hole": 0.68, "fillet": 0.67}
"""σ_V over the largest stress in bars 4 mm thick: what is read of these notches."""
CORNER, TOUCHED = 0.05, 0.02
SPOT = 0.2
"""Edge of a spot of the mesh [mm]."""


def small() -> Iterator[Result]:
    """A bridge of 1 × 1 mm between two blocks, and a pin of 1 % of the volume on a plate: σ_V is that of the small member."""
    for name, tets, area, limit in (("bridge", _bridge(2), 1.0, BRIDGE), ("pin", _pin(1), 16.0, PIN)):
        note = f"the mean stress in it, {len(tets.tets)} TET10"
        yield compared(f"small: {name}", Body(tets).loaded((NOMINAL * area, 0.0, 0.0)).stress, NOMINAL, limit, "MPa", note)


def notches() -> Iterator[Result]:
    """A hole and a fillet in tension: σ_V over the handbook's largest stress, in one and two layers."""
    holes = [bar_with_hole(3.0, *cells) for cells in ((24, 5, 1), (32, 6, 2))]
    fillets = [bar_with_fillets(2.0, *cells) for cells in ((4, 10, 1), (6, 12, 2))]
    for name, meshes, width, handbook in (("hole", holes, WIDTH, HOLE), ("fillet", fillets, WIDTH - 4.0, FILLET)):
        for mesh in meshes:
            found = Body(mesh).loaded((NOMINAL * width * THICKNESS, 0.0, 0.0))
            note = f"what is read of K_t = {handbook:g}; the largest stress is {found.maximum / NOMINAL:.2f}; {len(mesh.tets)} TET10"
            share = found.stress / NOMINAL / handbook
            yield compared(f"notches: {name}, {len(mesh.tets)} tetrahedra", share, SHARE[name], SAME, "", note)


def corner() -> Iterator[Result]:
    """A sharp re-entrant corner in 1, 2 and 4 cells through the leg: its largest stress grows without end, σ_V does not."""
    found = [Body(bracket(20.0, 8.0, 4.0, cell)).loaded((0.0, 0.0, -20.0)) for cell in (4.0, 2.0, 1.0)]
    for one, name in zip(found[:-1], ("1 cell", "2 cells"), strict=True):
        note = f"4 cells through the leg; largest stress {one.maximum:.1f} and {found[-1].maximum:.1f} MPa"
        yield compared(f"corner: {name} through the leg", one.stress, found[-1].stress, CORNER, "MPa", note)
    yield bounded("corner: largest stress grows", found[1].maximum / found[2].maximum, 0.9, "the finest mesh's is larger: it has no limit")


def spots() -> Iterator[Result]:
    """Thorns, fins and pits of 0.2 mm on a cantilever: accidents of a mesh that hold no volume."""
    plain = Body(_spotted("")).loaded((0.0, 0.0, -40.0))
    for name in ("thorn", "fin", "pit"):
        found = Body(_spotted(name)).loaded((0.0, 0.0, -40.0))
        note = f"without it; largest stress {found.maximum:.0f} instead of {plain.maximum:.0f} MPa"
        yield compared(f"spots: {name}", found.stress, plain.stress, TOUCHED, "MPa", note)


def _bridge(through: int) -> TetMesh:
    """Two blocks of 10 × 11 × 11 mm with a bridge of 1 × 1 × 6 mm between them, along x."""
    across = np.unique(np.concatenate([np.linspace(0.0, 5.0, 4), np.linspace(5.0, 6.0, through + 1), np.linspace(6.0, 11.0, 4)]))
    parts = [np.linspace(0.0, 9.0, 4), np.linspace(9.0, 17.0, 8 * through + 1), np.linspace(17.0, 26.0, 4)]

    def keep(x: Floats, y: Floats, z: Floats) -> Bools:
        return (x < 10.0) | (x > 16.0) | ((np.abs(y - 5.5) < 0.5) & (np.abs(z - 5.5) < 0.5))

    return carved(np.unique(np.concatenate(parts)), across, across, keep)


def _pin(cells: int) -> TetMesh:
    """A plate of 40 × 40 × 6 mm with a pin of 4 × 4 × 6 mm on it, along x: 1 % of the volume."""
    parts = [np.linspace(0.0, 18.0, 4 * cells + 1), np.linspace(18.0, 22.0, cells + 1), np.linspace(22.0, 40.0, 4 * cells + 1)]
    across = np.unique(np.concatenate(parts))
    up = np.linspace(0.0, 12.0, 4 * cells + 1)
    return carved(up, across, across, lambda x, y, z: (x < 6.0) | ((np.abs(y - 20.0) < 2.0) & (np.abs(z - 20.0) < 2.0)))


def _spotted(spot: str) -> TetMesh:
    """A cantilever of 60 × 15 × 6 mm with a spot on its upper side, 9 mm from the clamp."""
    x, y = _with_spot(np.linspace(0.0, 60.0, 21), 9.0), _with_spot(np.linspace(0.0, 15.0, 6), 6.0)
    z = np.array([0.0, 3.0, 6.0 - SPOT, 6.0, 6.0 + SPOT])

    def keep(a: Floats, b: Floats, c: Floats) -> Bools:
        here = (a > 9.0) & (a < 9.0 + SPOT) & ((b > 6.0) & (b < 6.0 + SPOT) if spot != "fin" else True)
        return (c < 6.0) & ~(here & (c > 6.0 - SPOT) & (spot == "pit")) | ((c > 6.0) & here & (spot in ("thorn", "fin")))

    return carved(x, y, z, keep)


def _with_spot(axis: Floats, place: float) -> Floats:
    return np.sort(np.append(axis, place + SPOT))


SPAN, BREADTH = 100.0, 20.0
"""Of the plates [mm]."""
CLAMP = 37.5
"""Beam theory at the clamp, 6 F L/(b t²) [MPa]: 45.6 MPa of PLA over it is a load factor of 1.22."""
PLATES = {0.8: (50, 10, 1), 2.0: (40, 8, 1), 4.0: (25, 5, 1), 8.0: (25, 5, 2)}
"""Cells of the plates by their thickness [mm]; the first three are one element thick."""
FACTOR, QUANTILE = 0.1, 0.06
LIMP = msgspec.structs.replace(PLA, poisson_ratio=0.0)
"""Without lateral strain the clamp does not stiffen the plate across, and beam theory is exact but for the clamped edge."""
BARS = (1.0, 2.0, 4.0, 6.0)
"""Diameters, or sides of squares [mm]."""
HINGE = {"round": 1.7, "square": 1.5}
"""Load of a plastic hinge over that of first yield."""
SLENDER = (5.0, 10.0)
"""Lengths over diameters."""


def plates() -> Iterator[Result]:
    """Cantilevers whose clamp sees 37.5 MPa: their load factor, and σ_V without lateral strain against its closed form."""
    theory = PLA.yield_strength / CLAMP
    for thickness, counts in PLATES.items():
        body, force = Body(box(counts, (SPAN, BREADTH, thickness))), (0.0, 0.0, -CLAMP * BREADTH * thickness**2 / 6.0 / SPAN)
        note = f"beam theory at the clamp, {len(body.tets.tets)} TET10, {counts[2]} through the wall"
        factor = PLA.yield_strength / body.loaded(force).stress
        yield compared(f"plates: {thickness:g} mm, load factor", factor, theory, FACTOR, "", note)
        weight = max(1.0, (THIN / thickness) ** 3)
        closed = CLAMP * _quantile(LOADED**3 / weight / (SPAN * BREADTH * thickness))
        note = "the stress that 8 mm³, fewer in thin walls, exceed by beam theory"
        yield compared(f"plates: {thickness:g} mm, σ_V with ν = 0", body.loaded(force, LIMP).stress, closed, QUANTILE, "MPa", note)


def bars() -> Iterator[Result]:
    """Round and square cantilevers: the load factor over that of first yield must stay below the load of a plastic hinge."""
    for section, hinge in HINGE.items():
        for width in BARS:
            for slender in SLENDER:
                length = slender * width
                along = max(10, round(2.0 * length / width))
                tets = round_bar(width, length, 4, along) if section == "round" else box((along, 2, 2), (length, width, width))
                modulus = math.pi * width**3 / 32.0 if section == "round" else width**3 / 6.0
                over = CLAMP / Body(tets).loaded((0.0, 0.0, -CLAMP * modulus / length)).stress
                note = f"load factor over first yield; a plastic hinge at {hinge:g}"
                yield bounded(f"bars: {section}, {width:g} mm, {slender:g} times as long", over, hinge, note)


def _quantile(share: float) -> float:
    """Stress over the fibre stress at the clamp that a share of the volume of a cantilever exceeds.

    Stress is (1 − x/L) |z|/(t/2) of that at the clamp: it exceeds k in a share 1 − k + k ln k.
    """
    return float(brentq(lambda k: 1.0 - k + k * math.log(k) - share, 1e-9, 1.0 - 1e-12))
