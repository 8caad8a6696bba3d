"""The original on tetrahedra that were made for a relief: like is compared with like, but no limit rests on a notch.

The finer tetrahedra of a relief read up to a third more than those of the plain part where waves meet in a flat landing, in the styled part
as in the original: so the original is dropped on them, too. But where the way back from half a relief would turn tetrahedra inside out, the
original is stood in for by a part with a little relief left, and a notch left over may bear several times what the original does.
"""

from __future__ import annotations

from dataclasses import replace

import msgspec
import numpy as np

from mechstyle.records import Measures, Simulation
from mechstyle.records.mesh import Field

FINER = 1.4
"""What finer tetrahedra may read, over what those of the plain part read; more is a notch."""


def sobered(here: Simulation, at_rest: Simulation) -> Simulation:
    """The original as it is on tetrahedra made for a relief, its stresses as placed and tilted at most FINER times those at rest.

    Args:
        here: The original on tetrahedra made for a relief.
        at_rest: The original on tetrahedra of its own.
    """
    if here.failure or at_rest.failure:
        return here
    return replace(
        here,
        stress=_held(here.stress, at_rest.as_placed),
        tilted_stress=here.tilted_stress if at_rest.tilted is None else _held(here.tilted_stress, at_rest.tilted),
        as_placed=_lower(here.as_placed, at_rest.as_placed),
        tilted=here.tilted if here.tilted is None or at_rest.tilted is None else _lower(here.tilted, at_rest.tilted),
    )


def _held(field: Field, at_rest: Measures) -> Field:
    """A field [MPa], shape [vertex_count], nowhere above what the part at rest may read anywhere."""
    return np.minimum(field, np.float32(FINER * at_rest.peak))


def _lower(one: Measures, other: Measures) -> Measures:
    """The measures of one, surface and contact at most FINER times those of the other, and the places of whichever they are."""
    held = {name: min(getattr(one, name), FINER * getattr(other, name)) for name in ("surface", "contact")}
    of = {f"{name}_where": getattr(one if held[name] == getattr(one, name) else other, f"{name}_where") for name in held}
    larger = max(held, key=held.__getitem__)
    return msgspec.structs.replace(one, peak=held[larger], where=of[f"{larger}_where"] or one.where, **held, **of)
