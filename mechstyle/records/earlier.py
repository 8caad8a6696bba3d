"""Recipes of earlier versions in today's words: the one place that knows what a setting was called, or meant, before."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

Fields = dict[str, Any]

GONE: Mapping[str, Callable[[Any], Fields]] = {
    "protect_resting_face": lambda held: {"base": "protected" if held else "free"},
}
"""What stands today for a field that recipes no longer have, given its value."""


BEFORE_TILTS = "protect_resting_face"
"""A field of the versions that dropped a part exactly flat only and told damping in ms of stiffness-proportional damping."""

SINCE_MILLIMETRES = "side"
"""A field of the versions that know relief and features in mm."""

BEFORE_MILLIMETRES: Fields = {"side": "both", "inside": "styled", "nozzle": 0.0}
"""What the others did: relief to both sides of every wall, inside and outside, features sized by the part's area alone."""


SINCE_DELIVERED = "delivered"
"""A field of the versions that draw the delivered surface finer than the run's; the others delivered the run's."""


def translated(fields: Fields) -> Fields:
    """The fields of a recipe, as decoded, without those that are gone; what a field that came later was then is its default.

    Damping in ms has no counterpart per tetrahedron and gives way to today's default.
    """
    kept = {name: value for name, value in fields.items() if name not in GONE}
    if BEFORE_TILTS in fields:
        kept = {name: value for name, value in kept.items() if name != "damping"} | {"tilts": 0}
    if SINCE_MILLIMETRES not in fields:
        kept = BEFORE_MILLIMETRES | kept
    if SINCE_DELIVERED not in fields:
        kept = {SINCE_DELIVERED: 0} | kept
    for name, words in GONE.items():
        if name in fields:
            kept |= words(fields[name])
    return kept
