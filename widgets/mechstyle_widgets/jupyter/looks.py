"""Layouts and styles that the controls of a widget share.

ipywidgets makes a layout and a style for every control: two models of three. A page that is loaded anew asks for all of them at once
and makes them all before it shows any, so that it may give up in between; in a widget those that say the same are one.

Two widgets share none. As long as a layout lives the page keeps a view of it for every control that ever had it, each of which holds on
to its control, and that to all that was shown with it: what ran before would stay in memory as long as what runs now.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any, TypeVar
from weakref import WeakValueDictionary

import ipywidgets
import traitlets

from mechstyle_widgets.jupyter.language import worded

W = TypeVar("W")
Looks = dict[tuple[Any, ...], Any]

_here: ContextVar[Looks | None] = ContextVar("looks that what is being made shares", default=None)
_among: dict[Any, Looks] = {}  # each look that is open, and those it is one of
_controls: WeakValueDictionary[int, Any] = WeakValueDictionary()  # by their id

_promised: list[int] = []
"""Ids of looks that a control is to have which is being made."""


@contextmanager
def sharing() -> Iterator[None]:
    """Controls made in here by `lean` share their looks, also with what is being made around them."""
    token = _here.set({} if (around := _here.get()) is None else around)
    try:
        yield
    finally:
        _here.reset(token)


def shared(widget: ipywidgets.Widget) -> bool:
    """Whether it is a layout or style that more than one control may have, none of which may close or change it."""
    return widget in _among


def close_unused(looks: Iterable[ipywidgets.Widget]) -> None:
    """Close those that no control has any more, of these and those they were shared with.

    Controls may be made and looks closed meanwhile, by another thread or by what closing one sets off: what is gone through is a copy.
    """
    controls = [control for known in _controls.valuerefs() if (control := known()) is not None and control.comm is not None]
    had = {id(one) for control in controls for one in (control.layout, getattr(control, "style", None))} | {*_promised}
    for among in {id(among): among for one in looks if (among := _among.get(one)) is not None}.values():
        for key, one in list(among.items()):
            if id(one) not in had:
                one.close()
                among.pop(key, None)
                _among.pop(one, None)


def lean(kind: Callable[..., W], *given: Any, **traits: Any) -> W:
    """A control of a kind of ipywidgets, whose layout and style are given as dictionaries if at all, and shared while `sharing`."""
    traits = worded(traits)
    known, looks = kind.class_traits(), _here.get()  # type: ignore[attr-defined]  # ipywidgets has no types
    if looks is not None:
        for name in {"layout", "style"} & known.keys():
            if isinstance(traits.setdefault(name, {}), dict):
                traits[name] = _look(looks, known[name].klass, traits[name])
    with _promising(traits.get("layout"), traits.get("style")):
        control = kind(*given, **traits)
        _controls[id(control)] = control
    return control


@contextmanager
def _promising(*looks: object) -> Iterator[None]:
    """What is closed in the block, by whatever making a control sets off, leaves the looks that it is to have."""
    promised = [id(one) for one in looks]
    _promised.extend(promised)
    try:
        yield
    finally:
        for one in promised:
            _promised.remove(one)


def stacked(children: Sequence[ipywidgets.Widget], name: str) -> ipywidgets.VBox:
    """Controls under each other, in a box that the sheet of the frame lays out by a name."""
    box = lean(ipywidgets.VBox, list(children))
    box.add_class(name)
    return box


@contextmanager
def unheard(widget: traitlets.HasTraits, handler: Callable[[dict[str, Any]], object], name: str = "value") -> Iterator[None]:
    """Change a trait in the block without a handler's hearing of it."""
    widget.unobserve(handler, name)
    try:
        yield
    finally:
        widget.observe(handler, name)


def show(widget: ipywidgets.DOMWidget, there: object) -> None:
    """Show a control, or let it take no room."""
    display = None if there else "none"
    if not shared(widget.layout):
        widget.layout.display = display
    elif widget.layout.display != display:
        values = {name: getattr(widget.layout, name) for name in widget.layout.keys if not name.startswith("_")}
        given = {name: value for name, value in {**values, "display": display}.items() if value is not None}
        look = _look(_among[widget.layout], ipywidgets.Layout, given)
        with _promising(look):
            widget.layout = look


def _look(looks: Looks, kind: Any, values: dict[str, Any]) -> Any:
    key = (kind, *sorted(values.items()))
    known = looks.get(key)
    if known is None or known.comm is None:  # somebody closed all widgets
        known = looks[key] = kind(**values)
        _among[known] = looks
        known.observe(_refuse)
    return known


def _refuse(change: Any) -> None:
    if change["name"] in change["owner"].keys:
        raise traitlets.TraitError(f"other controls share this look: give this one another, instead of changing its {change['name']}")


def family(widget: ipywidgets.Widget) -> list[ipywidgets.Widget]:
    """The widget and every widget its state refers to, however deep."""
    found: dict[int, ipywidgets.Widget] = {}
    waiting: list[Any] = [widget]
    while waiting:
        one = waiting.pop()
        if isinstance(one, dict):
            waiting.extend(one.values())
        elif isinstance(one, list | tuple):
            waiting.extend(one)
        elif isinstance(one, ipywidgets.Widget) and id(one) not in found:
            found[id(one)] = one
            waiting.extend(getattr(one, key) for key in one.keys)
    return list(found.values())


REMEMBERED = 20_000
"""Closed widgets that a page may still speak of."""
_closed: dict[str, None] = {}
"""Their ids: what a page says of them is no news, though JupyterLab put a red number on its log for it."""
logging.getLogger("Comm").addFilter(lambda record: record.getMessage().rpartition("No such comm: ")[2] not in _closed)


def close_family(widget: ipywidgets.Widget, *more: ipywidgets.Widget) -> None:
    """Close everything a widget, and more it keeps out of sight, is made of; the widget itself is left to its owner.

    Of one that is closed nothing is touched: Python asks for that once more when it removes it, at any moment and in any thread.
    """
    if widget.comm is None:
        return
    parts = list({id(part): part for one in (widget, *more) for part in family(one)}.values())
    for part in parts:
        if part.comm is not None:
            _closed[part.model_id] = None
        if part is not widget and not shared(part):
            part.close()
    close_unused(part for part in parts if shared(part))
    for ident in list(_closed)[:-REMEMBERED]:
        _closed.pop(ident, None)
