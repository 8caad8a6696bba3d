"""The language of all that the Studio says: one table, from English to German.

The core speaks English. Its sentences are in the table with `{}` for what is filled in, and are said in German where they are shown.
Each widget keeps the language in which it was made: whatever a page or a cell asks of it is answered in that (`jupyter.one_thread`).
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache, lru_cache
from importlib.resources import files
from typing import Any

from mechstyle.errors import unknown

LANGUAGES = ("en", "de")
_usual = ["en"]
_here: ContextVar[str] = ContextVar("language of what is at work", default="")


def speak(language: str) -> None:
    """Let everything that is made from now on be called by its names in a language, `en` or `de`; what was made keeps its own."""
    if language not in LANGUAGES:
        raise unknown("language", str(language), LANGUAGES)
    _usual[0] = language


@contextmanager
def speaking(language: str) -> Iterator[None]:
    """Speak a language in the block, and in what is planned there for later; "" for the usual one."""
    token = _here.set(language)
    try:
        yield
    finally:
        _here.reset(token)


def language_of(widget: object) -> str:
    """The language in which a widget was made, "" where that is not known."""
    return str(getattr(widget, "spoken_here", ""))


def spoken() -> str:
    """The language spoken."""
    return _here.get() or _usual[0]


def word(english: str) -> str:
    """A label in the language spoken; what is in no table, as a name or a figure, stays."""
    return GERMAN.get(english, english) if spoken() == "de" else english


def in_page(words: Sequence[str]) -> dict[str, str]:
    """What a page's own script says, in the language spoken, by the English of it."""
    return {english: GERMAN[english] for english in words if english in GERMAN} if spoken() == "de" else {}


def said(english: str) -> str:
    """A sentence, or several, in the language spoken: as a whole if the table has it, else piece by piece; what is in no table stays."""
    return _german(english) if spoken() == "de" else english


@lru_cache(maxsize=4096)
def _german(english: str) -> str:
    if (plain := english.replace("\N{NO-BREAK SPACE}", " ")) in GERMAN:
        return GERMAN[plain]
    for form, german in _forms():
        if found := form.fullmatch(english):
            return german.format(*map(_german, found.groups()))
    for apart in (_SENTENCES, _PARTS):
        if len(pieces := apart.split(english)) > 1:
            return "".join(part if number % 2 else _german(part) for number, part in enumerate(pieces))
    return f"{_german(english[:-1])}." if english.endswith(".") else english


@cache
def _forms() -> list[tuple[re.Pattern[str], str]]:
    """What matches the sentences of the table in which something is filled in, those with most words first."""
    found = []
    for english in sorted((one for one in GERMAN if "{}" in one), key=lambda one: -len(one.replace("{}", ""))):
        few = sum(letter.isalpha() for letter in english) <= FEW  # a figure is filled in, no part of a sentence
        filled = r"(\S+)" if few else r"((?:(?!; |\. | · |\n).)+?)"
        found.append((re.compile(re.escape(english).replace(r"\{\}", filled)), GERMAN[english]))
    return found


FEW = 3
"""Letters of a sentence of the table that match about everything, as `{} of {}` does."""
_SENTENCES, _PARTS = re.compile(r"(; |\. | · |\n|, and also )"), re.compile("(: )")
"""What stands between sentences, and between parts of one that are said by themselves."""


def worded(traits: dict[str, Any]) -> dict[str, Any]:
    """Traits of a control with its labels in the language spoken; what its options stand for stays."""
    if spoken() == "en":
        return traits
    said = dict(traits)
    for name in LABELS & said.keys():
        said[name] = word(said[name]) if isinstance(said[name], str) else [word(one) for one in said[name]]
    if "options" in said:
        said["options"] = _options(said["options"])
    return said


def _options(options: Any) -> Any:
    if isinstance(options, dict):
        return {word(label): value for label, value in options.items()}
    if not isinstance(options, Sequence):
        return options
    pairs = [one if isinstance(one, tuple) and len(one) == 2 else (one, one) for one in options]
    return [(word(label) if isinstance(label, str) else str(label), value) for label, value in pairs]


LABELS = {"description", "tooltip", "tooltips", "placeholder", "titles"}
"""Traits of controls that people read."""

GERMAN: dict[str, str] = tomllib.loads(files("mechstyle_widgets.jupyter").joinpath("static", "german.toml").read_text(encoding="utf-8"))
"""German by English, for everything that is said."""
