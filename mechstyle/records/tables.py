"""Small files that people write: TOML and JSON."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import msgspec

MOST_BYTES = 100_000


def read_table(file: Path) -> Any:
    """What a TOML file holds, or a JSON file if its suffix says so.

    Raises:
        ValueError: If it cannot be read, is no such file, or larger than anybody writes one.
    """
    try:
        if file.stat().st_size > MOST_BYTES:
            raise ValueError(f"it has more than {MOST_BYTES // 1000} kB")
        text = file.read_bytes().decode("utf-8-sig")  # editors of Windows begin a file with a mark, which is no part of either format
        return msgspec.json.decode(text) if file.suffix.lower() == ".json" else _toml(text)
    except OSError as error:
        raise ValueError(error.strerror or str(error)) from error
    except RecursionError as error:
        raise ValueError("its tables are nested too deeply") from error


def _toml(text: str) -> Any:
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        raise
    except ValueError as error:  # from Python's own reading of whole numbers, with advice on how to programme it
        raise ValueError("it has a number of thousands of digits") from error
