"""The original on tetrahedra that were made for a relief: what it bears there, but nowhere more than on tetrahedra of its own.

Where the way back from half a relief would turn tetrahedra inside out, the original is stood in for by a part with a little relief left,
and a notch left over may bear several times what the original does. Like is compared with like, but no limit rests on such a notch.
"""

from __future__ import annotations

from dataclasses import replace

import msgspec
import numpy as np

from mechstyle.records import Measures, Simulation


def sobered(here: Simulation, at_rest: Simulation) -> Simulation:
    """The original as it is on tetrahedra made for a relief, less what its stresses as placed and tilted exceed those at rest by.

    Args:
        here: The original on tetrahedra made for a relief.
        at_rest: The original on tetrahedra of its own.
    """
    if here.failure or at_rest.failure:
        return here
    return replace(
        here,
        stress=np.minimum(here.stress, at_rest.stress),
        tilted_stress=np.minimum(here.tilted_stress, at_rest.tilted_stress),
        as_placed=_lower(here.as_placed, at_rest.as_placed),
        tilted=here.tilted if here.tilted is None or at_rest.tilted is None else _lower(here.tilted, at_rest.tilted),
    )


def _lower(one: Measures, other: Measures) -> Measures:
    """The lower stress of each zone; the place of the larger zone."""
    surface, contact = min(one.surface, other.surface), min(one.contact, other.contact)
    peak = max(surface, contact)
    return msgspec.structs.replace(one, surface=surface, contact=contact, peak=peak, where=one.where if one.peak == peak else other.where)
