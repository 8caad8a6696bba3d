"""Parametric printable models, in millimetres, standing as they are used.

`names()` lists them, `entry(name)` is what is known of one, `make(name, **parameters)` builds it; `load` opens one by its address,
or a file.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import msgspec

from mechstyle.records.load_cases import LoadCase

if TYPE_CHECKING:
    from mechstyle.records.mesh import SurfaceMesh
    from mechstyle.simulation.part import Model

__all__ = ["PREFIX", "READING", "Entry", "addressed", "describe", "entry", "load", "make", "names", "use_of"]

PREFIX = "gallery:"
"""What the address of a gallery model begins with, where a file could be meant as well."""
READING: Mapping[str, type] = MappingProxyType({"unit": str, "scale": float, "size": float, "up": str, "body": str})
"""What can be said of how a file is read: by arguments of `load`, or after the path, as in `box.3mf#unit=in,body=lid`."""
_SAID = re.compile(r"(.+)#(\w+=.*)", re.DOTALL)


class Entry(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A model as the catalogue knows it."""

    module: str  # the module of this package that builds it
    about: str  # what it is, in one line
    teaches: str  # what one learns from it, in one sentence
    protect: tuple[str, ...]  # the regions of its function, as they are written after `--protect`
    use: LoadCase | None = None  # a load it carries in life, for its default measures; None for what carries nothing


def names() -> tuple[str, ...]:
    """The models there are."""
    return tuple(_catalogue())


def describe(name: str) -> str:
    """Description of a model in one line; BadInput for a name that is not in the gallery."""
    return entry(name).about


def entry(name: str) -> Entry:
    """What is known of a model; BadInput for a name that is not in the gallery."""
    from mechstyle.errors import unknown  # noqa: PLC0415 — rooms load nothing by themselves

    if name not in _catalogue():
        raise unknown("gallery model", name, _catalogue(), lists="`mechstyle gallery`")
    return _catalogue()[name]


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

    build = getattr(import_module(f"mechstyle.gallery.{entry(name).module}"), name)
    known = inspect.signature(build).parameters
    for given in parameters:
        if given not in known:
            raise unknown(f"measure of {name}", given, known)
    mesh: SurfaceMesh = build(**parameters)
    return mesh


def load(
    model: str | Path, *, scale: float | None = None, up: str = "", unit: str = "", size: float | None = None, body: str | int = ""
) -> Model:
    """Open a part: a file, repaired where needed, or a model of the gallery.

    Args:
        model: An STL, OBJ, PLY, GLB or 3MF file, or `gallery:NAME`; `box.3mf#unit=in,body=lid` says how a file is read, too.
        scale: Factor from the coordinates of a file to millimetres; None for the format's own unit.
        up: The axis of a file that points up: z, -z, y, -y, x or -x; "" for the format's own.
        unit: The unit of a file's coordinates, such as cm or in, instead of a scale.
        size: The longest side of a file's part [mm], instead of a scale: for files that have no unit.
        body: Which of several bodies of a file, by its name or number.

    Returns:
        A closed surface of one body [mm], z up, with its `name`, its `origin` and, as `notes`, its size and the repairs it took.

    Raises:
        BadInput: If the file cannot be used or there is no such model, in one sentence that says why and what to do.

    Example:
        >>> ms.load("gallery:drawer_knob")
        SurfaceMesh(9650 vertices, 19296 faces, 34.0 x 34.0 x 28.0 mm)
    """
    from mechstyle.errors import BadInput  # noqa: PLC0415 — rooms load nothing by themselves
    from mechstyle.geometry.files import read  # noqa: PLC0415
    from mechstyle.simulation.part import Model, Origin  # noqa: PLC0415

    if not isinstance(model, str | Path):
        raise BadInput(f"a part is the path of a file or gallery:NAME, not {model!r}"[:200])
    address, said = addressed(model)
    if said:
        given = {"scale": scale, "up": up, "unit": unit, "size": size, "body": body}
        return load(address, **{**{name: value for name, value in given.items() if value not in (None, "")}, **said})
    if address in names():
        raise BadInput(f"{address} is a model of the gallery: write {PREFIX}{address}")
    if not address.startswith(PREFIX):
        mesh, notes = read(model, scale=scale, up=up, unit=unit, size=size, body=body)
        origin = Origin(model=Path(model).name, scale=scale, up=up, unit=unit, size=size, body=str(body))
        return Model(mesh.vertices, mesh.faces, mesh.colours, name=Path(model).stem, origin=origin, notes=notes)
    if scale is not None or up or unit or size is not None or body:
        raise BadInput(f"{address}: scale, unit, size, body and an axis for up are for files; gallery models are in millimetres, and stand")
    name = address.removeprefix(PREFIX)
    mesh = make(name)
    return Model(mesh.vertices, mesh.faces, mesh.colours, name=name, origin=Origin(model=address))


def addressed(model: str | Path) -> tuple[str, dict[str, Any]]:
    """The path of a file, and what its address says of how it is read, as `load` takes it; BadInput for nonsense.

    A path that exists is itself, whatever signs it has.
    """
    from mechstyle.errors import BadInput, unknown  # noqa: PLC0415
    from mechstyle.geometry.files import is_there  # noqa: PLC0415

    address = str(model)
    found = None if address.startswith(PREFIX) else _SAID.fullmatch(address)
    if found is None or is_there(Path(address)):
        return address, {}
    said: dict[str, Any] = {}
    for word in re.split(r",(?=\w+=)", found[2]):
        name, _, value = word.partition("=")
        if name not in READING:
            raise unknown("word on how a file is read", name, READING)
        try:
            said[name] = READING[name](value)
        except ValueError as error:
            where = Path(found[1]).name[:80]  # what follows the file's name may be long, and of any signs
            raise BadInput(f"{name} is {value[:40]!r} in the address of {where!r}, but must be a number, such as {name}=25.4") from error
    return found[1], said


def use_of(address: str) -> LoadCase:
    """The load of its use of a model given as `gallery:NAME`; BadInput if there is no such model, or it carries nothing."""
    from mechstyle.errors import BadInput  # noqa: PLC0415

    name = address.removeprefix(PREFIX)
    use = entry(name).use
    if use is None:
        carrying = ", ".join(other for other, known in _catalogue().items() if known.use is not None)
        raise BadInput(f"{name} carries nothing in its use: write a load file, or choose one of {carrying}")
    return use


@cache
def _catalogue() -> Mapping[str, Entry]:
    """The models by name, in order."""
    text = Path(__file__).with_name("models.toml").read_text(encoding="utf-8")
    return MappingProxyType(msgspec.convert(tomllib.loads(text), dict[str, Entry]))
