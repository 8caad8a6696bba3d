"""The errors a user can cause, each saying in one sentence what is wrong, where, and what to do."""

from __future__ import annotations

import difflib
import inspect
import unicodedata
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any


class MechStyleError(Exception):
    """Base of every error that is the input's or the machine's fault, not a defect of the program.

    Example:
        >>> try:
        ...     ms.load("no-such-part.stl")
        ... except ms.MechStyleError as error:
        ...     print(error)
        no-such-part.stl does not exist in ...; check the path
    """

    def __str__(self) -> str:
        """One line, whatever a name in it holds."""
        return "".join(repr(one)[1:-1] if unicodedata.category(one) in ("Cc", "Zl", "Zp") else one for one in super().__str__())

    def _render_traceback_(self) -> list[str]:
        """What a notebook shows: the sentence alone, as the place in our code helps nobody."""
        return [f"{type(self).__name__}: {self}"]


class BadInput(MechStyleError):
    """A file or a value that cannot be used as it is.

    Example:
        >>> ms.Sphere((0, 0, 0), -1)
        Traceback (most recent call last):
        mechstyle.errors.BadInput: a protected sphere must have a radius above zero, not -1 mm
    """


class MissingPiece(MechStyleError):
    """Something optional that this request needs is not installed or not there."""


class SimulationFailed(MechStyleError):
    """The drop test gave no usable answer; never read as HOLDS."""


class DamagedStore(MechStyleError):
    """A stored object does not have the content its name promises."""


LISTED = 12
"""Most known names that a refusal lists beside one that comes near."""


def unknown(kind: str, name: str, known: Iterable[str], *, lists: str = "") -> BadInput:
    """The error for a name that is not in a list, with the nearest known names first; of a long list only those, or who lists it."""
    names = sorted(filter(None, known))
    by_small_letters = {other.lower(): other for other in names}
    near = [by_small_letters[match] for match in difflib.get_close_matches(name.lower(), by_small_letters, n=3, cutoff=0.5)]
    ordered = near + [other for other in names if other not in near]
    if near and len(names) > LISTED:
        return BadInput(f"unknown {kind} {name!r}: did you mean {' or '.join(map(repr, near))}?")
    if lists and len(names) > LISTED:
        return BadInput(f"unknown {kind} {name!r}: {lists} lists what is known")
    hint = f"did you mean {near[0]!r}? " if near else ""
    return BadInput(f"unknown {kind} {name!r}: {hint}known are {', '.join(ordered)}")


def absent(path: str | Path, what: str = "") -> BadInput:
    """The error for a path at which there is nothing, with the folder in which it was looked for; `what` it should be."""
    where = "" if Path(path).is_absolute() else f" in {Path.cwd()}"
    return BadInput(f"{what}{' ' if what else ''}{path} does not exist{where}; check the path")


def check_known(function: Callable[..., Any], given: Iterable[str], others: Iterable[str] = ()) -> None:
    """Refuse arguments that a function does not take by name; `others` are those that it hands on."""
    taken = {name for name, one in inspect.signature(function).parameters.items() if one.kind is not one.VAR_KEYWORD}
    for name in given:
        if name not in {*taken, *others}:
            kind, lists = ("setting", "docs/settings.md") if others else (f"argument of {function.__name__}", "")
            raise unknown(kind, name, {*taken, *others}, lists=lists)
