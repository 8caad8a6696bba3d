"""Layouts and styles that controls share.

ipywidgets makes a layout and a style for every control: two models of three. A page that is loaded anew asks for all of them at once
and makes them all before it shows any, so that it may give up in between; those that say the same are one here, in every cell.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import ipywidgets
import traitlets

W = TypeVar("W")
Shared = dict[tuple[Any, ...], Any]

_shared: Shared = {}


def look(kind: Any = ipywidgets.Layout, **values: Any) -> Any:
    """The layout, or the style of another kind, with these values: one for all who ask."""
    key = (kind, *sorted(values.items()))
    known = _shared.get(key)
    if known is None or known.comm is None:  # somebody closed all widgets
        known = _shared[key] = kind(**values)
        known.observe(_refuse)
    return known


def shared(widget: ipywidgets.Widget) -> bool:
    """Whether it is a layout or style of more than one control, which none of them may close."""
    return any(widget is known for known in _shared.values())


def lean(kind: Callable[..., W], *given: Any, **traits: Any) -> W:
    """A control of a kind of ipywidgets, whose layout and style are given as dictionaries if at all, and shared."""
    known = kind.class_traits()  # type: ignore[attr-defined]  # ipywidgets has no types
    for name in {"layout", "style"} & known.keys():
        if isinstance(traits.setdefault(name, {}), dict):
            traits[name] = look(known[name].klass, **traits[name])
    return kind(*given, **traits)


def show(widget: ipywidgets.DOMWidget, there: object) -> None:
    """Show a control, or let it take no room."""
    display = None if there else "none"
    if not shared(widget.layout):
        widget.layout.display = display
    elif widget.layout.display != display:
        values = {name: getattr(widget.layout, name) for name in widget.layout.keys if not name.startswith("_")}
        widget.layout = look(**{name: value for name, value in {**values, "display": display}.items() if value is not None})


def _refuse(change: Any) -> None:
    if change["name"] in change["owner"].keys:
        raise traitlets.TraitError(f"other controls share this look: give this one another, instead of changing its {change['name']}")
