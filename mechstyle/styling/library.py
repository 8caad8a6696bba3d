"""The styles by name: every module of `styles` defines one `STYLE`."""

from __future__ import annotations

import importlib
import pkgutil
from functools import cache

from mechstyle.errors import unknown
from mechstyle.styling import picture, styles
from mechstyle.styling.style import Style


@cache
def names() -> tuple[str, ...]:
    """Names of all styles, sorted; imports none of them."""
    return tuple(sorted(module.name for module in pkgutil.iter_modules(styles.__path__)))


@cache
def style_named(name: str) -> Style:
    """The style of that name; BadInput names the known ones, nearest first. A picture of the user's is one, though not in the library."""
    if name == picture.NAME:
        return picture.STYLE
    if name not in names():
        raise unknown("style", name, names())
    style: Style = importlib.import_module(f"{styles.__name__}.{name}").STYLE
    return style


def library() -> dict[str, Style]:
    """All styles by name, in the order of their names."""
    return {name: style_named(name) for name in names()}
