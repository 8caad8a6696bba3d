"""What people write: lengths with a unit or in millimetres, and small TOML and JSON files."""

from __future__ import annotations

import math
import re
import tomllib
from pathlib import Path
from typing import Any

import msgspec

from mechstyle.errors import BadInput

UNITS = {"mm": 1.0, "cm": 10.0, "m": 1000.0}
"""Units that a height may be written in [mm]."""
LEAST_BARE = 50.0
"""A number without a unit below this is asked about [mm]: it was most likely meant in metres."""
HOW = 'write "1.5 m", "150 cm" or "1500 mm"'
_WRITTEN = re.compile(r"([-+]?(?:\d+[.,]?\d*|[.,]\d+)(?:e[-+]?\d+)?)\s*(.*)")
_TWO_WAYS = re.compile(r"[-+]?[1-9]\d{0,2},\d{3}")


def length_of(value: str | float) -> float:
    """A height of fall [mm]: "1.5 m", "150 cm", "1500 mm", or a number of millimetres.

    BadInput if it is no height, or a number without a unit that is too small to be meant in millimetres.
    """
    number, unit = _read(value, "a height", HOW)
    if unit not in ("", *UNITS):
        raise BadInput(f"a height is in m, cm or mm, not in {unit!r:.40}: {HOW}")
    length = number * UNITS.get(unit, 1.0)
    if not 0.0 < length < math.inf:
        raise BadInput(f"a height of {f'{number:g} {unit}'.rstrip()} is no fall: {HOW}")
    if not unit and length < LEAST_BARE:
        ways = [f'"{number:g} {one}"' for one in ("m", "cm", "mm")]
        raise BadInput(f"a height of {number:g} would be {number:g} mm: write {ways[0]}, {ways[1]} or {ways[2]}")
    return length


SMALL_UNITS = {"mm": 1.0, "µm": 1e-3, "μm": 1e-3, "um": 1e-3, "cm": 10.0}
"""Units that a tolerance may be written in [mm]."""
HOW_SMALL = 'write "0.2 mm" or "200 µm"'


def tolerance_of(value: str | float) -> float:
    """What may stay bent [mm]: "0.2 mm", "200 µm", or a number of millimetres.

    BadInput if it is no length above 0, or in a unit that nobody measures a bend in.
    """
    number, unit = _read(value, "a tolerance", HOW_SMALL)
    if unit not in ("", *SMALL_UNITS):
        raise BadInput(f"a tolerance is in mm or µm, not in {unit!r:.40}: {HOW_SMALL}")
    tolerance = number * SMALL_UNITS.get(unit, 1.0)
    if not 0.0 < tolerance < math.inf:
        raise BadInput(f"a tolerance of {f'{number:g} {unit}'.rstrip()} is none: {HOW_SMALL}")
    return tolerance


HOW_SHARE = 'write "15 %" or 0.15'


def share_of(value: str | float) -> float:
    """A share of a whole: "15 %", or a number from 0 to 1.

    BadInput if it is none, or a number without "%" above 1, which was most likely meant in per cent.
    """
    number, unit = _read(value, "an infill", HOW_SHARE)
    if unit not in ("", "%"):
        raise BadInput(f"an infill is a share such as 15 %, not in {unit!r:.40}: {HOW_SHARE}")
    share = 0.01 * number if unit else number
    if not 0.0 <= share <= 1.0:
        meant = f'write "{number:g} %"' if not unit and 1.0 < number <= 100.0 else HOW_SHARE
        raise BadInput(f"an infill of {f'{number:g} {unit}'.rstrip()} is no share of the inside: {meant}")
    return share


READERS = {"height": length_of, "tolerance": tolerance_of, "infill": share_of}
"""What reads a setting that is written with a unit."""


def written(length: float) -> str:
    """A length [mm] as `length_of` reads it, to the last digit, in the unit that a person would use: 1500 is "1.5 m"."""
    for unit in ("m", "cm"):
        text = f"{length / UNITS[unit]:.12g} {unit}"
        if length >= UNITS[unit] and length_of(text) == length:
            return text
    return f"{length!r} mm".replace(".0 mm", " mm")


def _read(value: object, what: str, how: str) -> tuple[float, str]:
    """Number and unit of what was given; BadInput, which says what was asked and how, if it is no number with or without a unit."""
    if isinstance(value, int | float) and not isinstance(value, bool):
        return (math.inf if abs(value) > 1e300 else float(value)), ""  # a whole number may be too large for a float
    found = _WRITTEN.fullmatch(value.strip().lower()) if isinstance(value, str) else None
    if found is None:
        raise BadInput(f"cannot read {value!r:.60} as {what}: {how}")
    number, unit = found.groups()
    if _TWO_WAYS.fullmatch(number):
        ways = f"{number.replace(',', '')} or as {number.replace(',', '.')}"
        raise BadInput(f"{number} can be read as {ways}: write it without a comma")
    return float(number.replace(",", ".")), unit


MOST_BYTES = 100_000


def read_table(file: Path) -> Any:
    """What a TOML file holds, or a JSON file if its suffix says so.

    ValueError if it cannot be read, is no such file, or larger than anybody writes one.
    """
    try:
        if file.stat().st_size > MOST_BYTES:
            raise ValueError(f"it has more than {MOST_BYTES // 1000} kB")
        text = file.read_bytes().decode("utf-8-sig")  # editors of Windows begin a file with a mark, which is no part of either format
        if file.suffix.lower() == ".json":
            return msgspec.json.decode(text)
        try:
            return tomllib.loads(text)
        except tomllib.TOMLDecodeError:
            raise
        except ValueError as error:  # from Python's own reading of whole numbers, with advice on how to programme it
            raise ValueError("it has a number of thousands of digits") from error
    except OSError as error:
        raise ValueError(error.strerror or str(error)) from error
    except RecursionError as error:
        raise ValueError("its tables are nested too deeply") from error
