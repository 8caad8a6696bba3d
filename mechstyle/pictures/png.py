"""What a picture may be called."""

from __future__ import annotations

from pathlib import Path

from mechstyle.errors import BadInput


def as_png(path: str | Path) -> Path:
    """The path of a picture; BadInput, with a better one, if it is not called PNG."""
    target = Path(path)
    if target.suffix.lower() != ".png":
        raise BadInput(f"pictures are written as PNG: give {target.with_suffix('.png')} instead of {target}")
    return target
