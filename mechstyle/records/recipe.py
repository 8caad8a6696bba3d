"""The recipe: all that decides a run, in chapters, and the flat view of its settings."""

from __future__ import annotations

import hashlib
import inspect
import re
from collections.abc import Mapping
from typing import Any

import msgspec

from mechstyle.errors import BadInput, unknown
from mechstyle.records.chapters import Choices, Delivery, Limits, Restraint, Schedule, Specimen, StrengthTest, Style
from mechstyle.records.material import Material


class Recipe(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """All that decides a run, and nothing else: no times, hosts or paths.

    Who types settings types them flat, by names that no two chapters share: `Recipe.of(prompt="brick", height=1000.0, …)`.

    Attributes:
        style: What the part is to look like.
        restraint: What holds the style back.
        schedule: How long the style grows, and when it is simulated meanwhile.
        test: What the part must survive, of which material and meshes.
        delivery: What a printer can make of the part.
    """

    style: Style
    restraint: Restraint = Restraint()
    schedule: Schedule = Schedule()
    test: StrengthTest
    delivery: Delivery = Delivery()

    @classmethod
    def of(cls, *, surface: str = "", tetrahedra: str = "", **settings: Any) -> Recipe:
        """A recipe of flat settings: prompt and material, and what differs from the defaults.

        Args:
            surface: Digest of the surface, "" for any part.
            tetrahedra: Digest of the tetrahedra, "" for any.
            settings: By name.

        Raises:
            BadInput: If a name is unknown or a value out of range.
        """
        given = _by_chapter(settings)
        given["test"]["specimen"] = Specimen(surface=surface, tetrahedra=tetrahedra)
        return cls(**{chapter: kind(**given[chapter]) for chapter, kind in CHAPTERS.items()})

    def with_settings(self, **changes: Any) -> Recipe:
        """This recipe with some settings changed, given flat; BadInput for an unknown name or a value out of range."""
        given = {chapter: changed for chapter, changed in _by_chapter(changes).items() if changed}
        return msgspec.structs.replace(
            self, **{chapter: msgspec.structs.replace(getattr(self, chapter), **changed) for chapter, changed in given.items()}
        )

    def on(self, **digests: str) -> Recipe:
        """This recipe with other meshes: digests of `surface`, `tetrahedra` or both."""
        specimen = msgspec.structs.replace(self.test.specimen, **digests)
        return msgspec.structs.replace(self, test=msgspec.structs.replace(self.test, specimen=specimen))

    @property
    def digest(self) -> str:
        """SHA-256 of the recipe's canonical JSON."""
        return hashlib.sha256(msgspec.json.encode(self, order="deterministic")).hexdigest()

    @property
    def settings(self) -> dict[str, Any]:
        """Every setting by name, chapter by chapter."""
        return {name: getattr(getattr(self, chapter), attribute) for name, (chapter, attribute) in _PLACES.items()}

    def differences(self, other: Recipe, *, by_figure: bool = False) -> tuple[tuple[str, Any, Any], ...]:
        """The settings that another recipe does not share: name, value here, value there.

        Args:
            other: The recipe to compare with.
            by_figure: Whether to compare materials figure by figure, for people to read, instead of as a whole.
        """
        here, there = (_by_figure(recipe.settings) if by_figure else recipe.settings for recipe in (self, other))
        return tuple((name, value, there[name]) for name, value in here.items() if value != there[name])


CHAPTERS: Mapping[str, Any] = {field.name: field.type for field in msgspec.structs.fields(Recipe)}
"""The chapters of a recipe, by the name of its field, in their order."""

_FIELDS = {
    field.encode_name: (chapter, field)
    for chapter, kind in CHAPTERS.items()
    for field in msgspec.structs.fields(kind)
    if field.type is not Specimen
}
_PLACES = {name: (chapter, field.name) for name, (chapter, field) in _FIELDS.items()}

SETTINGS = tuple(_FIELDS)
"""Names of the settings of a recipe, chapter by chapter."""

CHAPTER_OF: Mapping[str, str] = {name: chapter for name, (chapter, _) in _FIELDS.items()}
"""The chapter of a setting, by setting."""

TYPES: Mapping[str, Any] = {name: field.type for name, (_, field) in _FIELDS.items()}
"""Type of a setting, by setting."""

DEFAULTS: Mapping[str, Any] = {
    name: field.default for name, (_, field) in _FIELDS.items() if field.default is not msgspec.NODEFAULT
}
"""What a setting is by default, by setting; those that every recipe must be given are not in it."""

CHOICES: Choices = {name: known for kind in CHAPTERS.values() for name, known in kind.CHOICES.items()}
"""The names a setting may have, by setting."""

LIMITS: Limits = {name: limits for kind in CHAPTERS.values() for name, limits in kind.LIMITS.items()}
"""The least and the greatest value of a setting, by setting, in its unit."""

OPTIONS = tuple(name for name in SETTINGS if not any(name in kind.RARE for kind in CHAPTERS.values()))
"""Settings with an option of their own on the command line; the others are given with --set."""

OF_FEEDBACK = ("control", "normalisation", "threshold", "base", "schedule", "every")
"""Options that restrain a style, or say when to simulate to that end: Freestyle has no use for them."""


def settings_of(chapter: str) -> tuple[str, ...]:
    """Names of the settings of a chapter."""
    return tuple(name for name, its in CHAPTER_OF.items() if its == chapter)


def _by_chapter(settings: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Values by chapter and attribute."""
    given: dict[str, dict[str, Any]] = {chapter: {} for chapter in CHAPTERS}
    for name, value in settings.items():
        if name not in _PLACES:
            raise unknown("setting", name, SETTINGS)
        chapter, attribute = _PLACES[name]
        given[chapter][attribute] = value
    return given


def direction_of(value: object) -> tuple[float, float, float]:
    """A direction given as x, y, z (of either sign and case), as text such as `0,0,1`, or as three numbers.

    Raises:
        BadInput: If it is none of these.
    """
    axes = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
    named = axes.get(value.strip().lower().lstrip("+-")) if isinstance(value, str) else None
    parts: Any = value.strip("[]() ").split(",") if isinstance(value, str) else value
    try:
        x, y, z = named or map(float, parts)
    except (TypeError, ValueError) as error:
        raise BadInput(f"a direction is x, y, z or three numbers such as 0,0,1, not {value!r}") from error
    return x, y, z


def described(name: str) -> str:
    """Description of a setting in one sentence with its unit and the names it may have.

    It is the first sentence on it in its chapter's docstring. Empty where Python runs without docstrings.
    """
    chapter, attribute = _PLACES[name]
    text = inspect.cleandoc(CHAPTERS[chapter].__doc__ or "").partition("Attributes:\n")[2]
    found = re.search(rf"^    {attribute}: (.+(?:\n        .+)*)", text, re.MULTILINE)
    if found is None:
        return ""
    sentence = " ".join(found[1].split()).partition(". ")[0].removesuffix(".") + "."
    return re.sub(r"\bone of [A-Z]+\b", f"one of {', '.join(filter(None, CHOICES.get(name, ())))}", sentence)


def _by_figure(settings: dict[str, Any]) -> dict[str, Any]:
    """Settings with name and figures of the material in its place, without their sources."""
    figures: dict[str, Any] = {}
    for name, value in settings.items():
        figures |= msgspec.structs.asdict(value) if isinstance(value, Material) else {name: value}
    del figures["source"], figures["layer_source"]
    return figures
