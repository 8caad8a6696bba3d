"""Parametric printable models, in millimetres, standing as they are used.

`names()` lists them, `describe(name)` says what one is, `make(name, **parameters)` builds it; `load` opens one by its address, or a file.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mechstyle.records.mesh import SurfaceMesh
    from mechstyle.simulation.part import Model

__all__ = ["PREFIX", "describe", "load", "make", "names"]

PREFIX = "gallery:"
"""What the address of a gallery model begins with, where a file could be meant as well."""

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
    """Description of a model in one line; BadInput for a name that is not in the gallery."""
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


def load(model: str | Path, *, scale: float | None = None, up: str = "") -> Model:
    """Open a part: a file, repaired where needed, or a model of the gallery.

    Args:
        model: An STL, OBJ, PLY, GLB or 3MF file, or `gallery:NAME`.
        scale: Factor from the coordinates of a file to millimetres; None for the format's own unit.
        up: The axis of a file that points up: z, -z, y, -y, x or -x; "" for the format's own.

    Returns:
        A closed surface of one body [mm], z up, with its `name`, its `origin` and the repairs it took as `notes`.

    Raises:
        BadInput: If the file cannot be used or there is no such model, in one sentence that says why and what to do.
    """
    from mechstyle.errors import BadInput  # noqa: PLC0415 — rooms load nothing by themselves
    from mechstyle.geometry.files import read  # noqa: PLC0415
    from mechstyle.simulation.part import Model, Origin  # noqa: PLC0415

    address = str(model)
    if not address.startswith(PREFIX):
        mesh, notes = read(model, scale=scale, up=up)
        origin = Origin(model=Path(model).name, scale=scale, up=up)
        return Model(mesh.vertices, mesh.faces, mesh.colours, name=Path(model).stem, origin=origin, notes=notes)
    if scale is not None or up:
        raise BadInput(f"{address}: a scale and an axis for up are for files; gallery models are in millimetres, and stand")
    name = address.removeprefix(PREFIX)
    mesh = make(name)
    return Model(mesh.vertices, mesh.faces, mesh.colours, name=name, origin=Origin(model=address))


def _entry(name: str) -> tuple[str, str]:
    from mechstyle.errors import unknown  # noqa: PLC0415

    if name not in _MODELS:
        raise unknown("gallery model", name, _MODELS)
    return _MODELS[name]
