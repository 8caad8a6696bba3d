"""The language of what the Studio's controls are called: one table, from English to German.

Sentences about a verdict, a prompt and a part come from the core, which speaks English.
"""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from importlib.resources import files
from typing import Any

from mechstyle.errors import unknown

LANGUAGES = ("en", "de")
_spoken = ["en"]


def speak(language: str) -> None:
    """Let everything that is made from now on be called by its names in a language, `en` or `de`."""
    if language not in LANGUAGES:
        raise unknown("language", language, LANGUAGES)
    _spoken[0] = language


def word(english: str) -> str:
    """A label in the language spoken; what is in no table, as a name or a figure, stays."""
    return GERMAN.get(english, english) if _spoken[0] == "de" else english


def worded(traits: dict[str, Any]) -> dict[str, Any]:
    """Traits of a control with its labels in the language spoken; what its options stand for stays."""
    if _spoken[0] == "en":
        return traits
    said = dict(traits)
    for name in LABELS & said.keys():
        said[name] = word(said[name]) if isinstance(said[name], str) else [word(one) for one in said[name]]
    if "options" in said:
        said["options"] = _options(said["options"])
    return said


def _options(options: Any) -> Any:
    """Options whose labels are in the language spoken."""
    if isinstance(options, dict):
        return {word(label): value for label, value in options.items()}
    if not isinstance(options, Sequence):
        return options
    pairs = [one if isinstance(one, tuple) and len(one) == 2 else (one, one) for one in options]
    return [(word(label) if isinstance(label, str) else str(label), value) for label, value in pairs]


LABELS = {"description", "tooltip", "tooltips", "placeholder", "titles"}
"""Traits of controls that people read."""

GERMAN: dict[str, str] = tomllib.loads(files("mechstyle_widgets.jupyter").joinpath("static", "german.toml").read_text(encoding="utf-8"))
"""German by English, for everything that a control is called."""
