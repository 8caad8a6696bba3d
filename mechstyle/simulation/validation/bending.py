"""Load factors of plates and bars in bending against beam theory: too large a factor is the unsafe side.

σ_V lies below the fibre stress by as much as the fibre stress falls over V0. A factor counts from first yield of the fibre; a plastic hinge
needs 1.5 times that load in a rectangular section and 1.7 times in a round one, so beyond that nothing may pass.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import msgspec
from scipy.optimize import brentq

from mechstyle.fea.stressed_volume import LOADED, THIN
from mechstyle.simulation.validation.cases import Result, bounded, compared
from mechstyle.simulation.validation.meshes import box, round_bar
from mechstyle.simulation.validation.reading import PLA, Body

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
                over = _over_first_yield(section, width, slender * width)
                note = f"load factor over first yield; a plastic hinge at {hinge:g}"
                yield bounded(f"bars: {section}, {width:g} mm, {slender:g} times as long", over, hinge, note)


def _over_first_yield(section: str, width: float, length: float) -> float:
    """Fibre stress at the clamp over σ_V of a cantilever."""
    along = max(10, round(2.0 * length / width))
    tets = round_bar(width, length, 4, along) if section == "round" else box((along, 2, 2), (length, width, width))
    modulus = math.pi * width**3 / 32.0 if section == "round" else width**3 / 6.0
    return CLAMP / Body(tets).loaded((0.0, 0.0, -CLAMP * modulus / length)).stress


def _quantile(share: float) -> float:
    """Stress over the fibre stress at the clamp that a share of the volume of a cantilever exceeds.

    Stress is (1 − x/L) |z|/(t/2) of that at the clamp: it exceeds k in a share 1 − k + k ln k.
    """
    return float(brentq(lambda k: 1.0 - k + k * math.log(k) - share, 1e-9, 1.0 - 1e-12))
