"""Parametric printable models, in millimetres, standing as they are used.

`names()` lists them, `describe(name)` says what one is, `make(name, **parameters)` builds it.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mechstyle.records.mesh import SurfaceMesh

__all__ = ["describe", "make", "names"]

# Name: (module that builds it, what it is).
_MODELS: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "pen_holder": ("containers", "round cup for pens with a rounded rim"),
        "vase": ("containers", "bellied vase with lobes that wind around it"),
        "pill_box": ("containers", "tray with a row of rounded cells, one for each day"),
        "phone_stand": ("supports", "desk stand with a leaning back, a lip and a cable slot"),
        "wall_hook": ("supports", "coat hook on a screw plate, lying on the plate"),
        "spectacle_frame": ("wearables", "front of a pair of spectacles, lying flat"),
        "utensil_grip": ("handles", "thick handle for a spoon or fork, lying on its flat"),
        "lampshade": ("lighting", "fluted shade with a ring for the socket on three spokes"),
    }
)


def names() -> tuple[str, ...]:
    """The models there are."""
    return tuple(_MODELS)


def describe(name: str) -> str:
    """One line on a model; BadInput for a name that is not in the gallery."""
    return _entry(name)[1]


def make(name: str, **parameters: float) -> SurfaceMesh:
    """Build a model.

    Args:
        name: One of `names()`.
        **parameters: Measures of that model [mm] where they should differ from its defaults; see the function of its name.

    Returns:
        A closed surface of one body [mm], z up, standing on z = 0 as it rests on a table.

    Raises:
        BadInput: An unknown model or measure, or measures out of range.
    """
    import inspect  # noqa: PLC0415 — only a build needs it
    from importlib import import_module  # noqa: PLC0415

    from mechstyle.errors import unknown  # noqa: PLC0415

    build = getattr(import_module(f"mechstyle.gallery.{_entry(name)[0]}"), name)
    known = inspect.signature(build).parameters
    for given in parameters:
        if given not in known:
            raise unknown(f"measure of {name}", given, known)
    mesh: SurfaceMesh = build(**parameters)
    return mesh


def _entry(name: str) -> tuple[str, str]:
    from mechstyle.errors import unknown  # noqa: PLC0415

    if name not in _MODELS:
        raise unknown("gallery model", name, _MODELS)
    return _MODELS[name]
