"""Ways a part may land, and the drop standards that prescribe them: landings, heights, and what a simulation leaves out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import msgspec

from mechstyle.records.written import written

POSES: Mapping[str, int] = {"fibonacci": 5, "resting": 8, "box26": 27, "box10": 11, "faces6": 7}
"""Ways a part may land, and how many drops each takes by default, flat counted as the first: all directions, what it comes to rest on;
faces, edges and corners of the smallest box around it, a corner with its edges and the faces, or the faces alone."""


class Standard(msgspec.Struct, frozen=True, kw_only=True):
    """Landings and height of fall [mm] after a standard, cited with its clause; `departs` says what is not as the standard has it."""

    title: str
    poses: str
    orientations: int
    height: float
    departs: str


_ONCE = "each landing is that of an undamaged part, so damage does not add up from drop to drop"

STANDARDS: Mapping[str, Standard] = {
    "mil-810h": Standard(
        title="MIL-STD-810H, method 516.8, procedure IV (transit drop)", poses="box26", orientations=27, height=1220.0,
        departs=f"The floor is rigid where the standard has a steel plate on concrete, and {_ONCE}.",
    ),
    "ista-1a": Standard(
        title="ISTA 1A, drop test below 10 kg", poses="box10", orientations=11, height=760.0,
        departs=f"The part is dropped without a package, vibration is left out, and {_ONCE}; from 10 to 19 kg the height is 610 mm.",
    ),
    "en71": Standard(
        title="EN 71-1, 8.5 (drop test of toys)", poses="box26", orientations=27, height=850.0,
        departs="The standard drops five times in the most onerous attitude, which is looked for here among faces, edges and corners; the"
        f" floor is rigid where it has coated steel, and {_ONCE}.",
    ),
    "astm-f963": Standard(
        title="ASTM F963, 8.7.1 (drop test of toys for children up to 18 months)", poses="fibonacci", orientations=10, height=1372.0,
        departs=f"The ten attitudes are spread evenly instead of at random, the floor is rigid where it has vinyl tile, and {_ONCE}.",
    ),
    "astm-f963-96": Standard(
        title="ASTM F963, 8.7.1 (drop test of toys for children of 18 to 96 months)", poses="fibonacci", orientations=4, height=914.0,
        departs=f"The four attitudes are spread evenly instead of at random, the floor is rigid where it has vinyl tile, and {_ONCE}.",
    ),
}  # fmt: skip
"""The standards whose landings can be asked for, by the name they are asked for with."""


def with_drops(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Settings of a recipe with what a standard brings, and the number of drops that poses take, unless they are given."""
    given = dict(settings)
    standard = STANDARDS.get(given.get("standard", ""))
    if standard is not None:
        given.setdefault("height", standard.height)
        if "poses" not in given:
            given = {"orientations": standard.orientations, **given, "poses": standard.poses}
    if given.get("poses") in POSES:
        given.setdefault("orientations", POSES[given["poses"]])
    return given


def landings_after(standard: str, *, poses: str, orientations: int, height: float) -> str:
    """Whose orientations are simulated, and where these settings depart from those of the standard; "" for no standard."""
    known = STANDARDS.get(standard)
    if known is None:
        return ""
    changes = []
    if poses != known.poses:
        changes.append(f"poses {poses} instead of {known.poses}")
    if orientations != known.orientations:
        changes.append(f"{orientations} orientations instead of {known.orientations}")
    if height != known.height:
        changes.append(f"{written(height)} instead of {written(known.height)}")
    return f"simulated orientations after {known.title}" + (f", but {', '.join(changes)}" if changes else "")
