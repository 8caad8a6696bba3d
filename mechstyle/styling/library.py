"""The styles by name: every module of `styles` defines one `STYLE`, or the `STYLES` of a family."""

from __future__ import annotations

import importlib
import pkgutil
from functools import cache

from mechstyle.errors import unknown
from mechstyle.styling import picture, styles
from mechstyle.styling.style import Style


@cache
def _modules() -> dict[str, str]:
    """Name of the module of each style, by its name; imports none of them."""
    alone = {module.name: module.name for module in pkgutil.iter_modules(styles.__path__) if module.name not in styles.FAMILIES}
    return alone | {name: family for family, members in styles.FAMILIES.items() for name in members}


@cache
def names() -> tuple[str, ...]:
    """Names of all styles, sorted; imports none of them."""
    return tuple(sorted(_modules()))


@cache
def style_named(name: str) -> Style:
    """The style of that name; BadInput names the known ones, nearest first. A picture of the user's is one, though not in the library."""
    if name == picture.NAME:
        return picture.STYLE
    if name not in names():
        raise unknown("style", name, names())
    module = importlib.import_module(f"{styles.__name__}.{_modules()[name]}")
    style: Style = module.STYLES[name] if hasattr(module, "STYLES") else module.STYLE
    return style


def library() -> dict[str, Style]:
    """All styles by name, in the order of their names."""
    return {name: style_named(name) for name in names()}
