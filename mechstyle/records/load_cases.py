"""Loads a part must carry in use, as people write them down: where it is held, what pulls or presses on it, and the file format.

A load file is TOML, one `[[case]]` per situation, in mm, N and MPa:

    [[case]]
    name = "hand on the rim"
    supports = [{ at = "resting face" }]
    loads = [{ at = { sphere = [40, 0, 100, 8] }, force = [0, 0, -50] }, { gravity = 1 }]

Places are picked on the unstylized part as it stands, so that a style does not move them. In Python a place may also be the region
of the same shape: `Support(at=ms.Sphere((40, 0, 100), 8))` is stored as the patch above.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal

import msgspec

from mechstyle.errors import BadInput, absent
from mechstyle.records.mesh import Bools, Floats, in_ball, in_box, in_half_space
from mechstyle.records.regions import Box, HalfSpace, Region, Sphere, regions
from mechstyle.records.written import read_table

RESTING_FACE = "resting face"
SHAPES = ("sphere", "box", "plane", "near", "facet")
EFFECTS = ("force", "pressure", "gravity")


class Patch(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A piece of the surface: exactly one of sphere, box, plane, near and facet [mm].

    Attributes:
        sphere: All surface inside a ball: x, y, z of its centre and its radius.
        box: All surface inside a box: x, y, z of its lowest and of its highest corner.
        plane: All surface on one side of a plane: x, y, z of a point on it, then of a vector towards that side.
        near: Surface around the place nearest to x, y, z, up to a radius, on the same side of a wall.
        facet: The smooth face around the place nearest to x, y, z.
        angle: How far the normals of a facet may turn from that place's [degrees].
    """

    sphere: tuple[float, float, float, float] | None = None
    box: tuple[float, float, float, float, float, float] | None = None
    plane: tuple[float, float, float, float, float, float] | None = None
    near: tuple[float, float, float, float] | None = None
    facet: tuple[float, float, float] | None = None
    angle: float = 20.0

    def __post_init__(self) -> None:
        given = [shape for shape in SHAPES if getattr(self, shape) is not None]
        if len(given) != 1:
            raise BadInput(f"a patch is one of {', '.join(SHAPES)}, not {' and '.join(given) or 'nothing'}")
        numbers = getattr(self, given[0])
        _finite(given[0], numbers)
        if given[0] in ("sphere", "near") and numbers[3] <= 0.0:
            raise BadInput(f"the radius of {given[0]} {_spaced(numbers)} is {numbers[3]:g} mm, but must be above 0")
        if self.box is not None and any(low > high for low, high in zip(self.box[:3], self.box[3:], strict=True)):
            raise BadInput(f"box {_spaced(self.box)} must give its lowest corner first, then its highest")
        if self.plane is not None and not any(self.plane[3:]):
            raise BadInput(f"plane {_spaced(self.plane)} has no direction: its last three numbers point to the side that is meant")
        if not 0.0 < self.angle <= 90.0:
            raise BadInput(f"angle is {self.angle:g}, but must lie above 0 and up to 90 degrees")

    @classmethod
    def of(cls, region: Region) -> Patch:
        """The surface in a box, a sphere or a half-space; BadInput for a region that is no such shape, or fades, or keeps its colour."""
        (shape,) = regions(region)
        if shape.ramp or shape.colour:
            raise BadInput(f"the place of a support or a load has no ramp and no colour: {shape.words!r} must do without")
        if isinstance(shape, Sphere):
            return cls(sphere=(*shape.centre, shape.radius))
        if isinstance(shape, Box):
            return cls(box=(*shape.low, *shape.high))
        if isinstance(shape, HalfSpace):
            return cls(plane=(*shape.point, *shape.normal))
        remedy = "write ms.Sphere, ms.Box or ms.HalfSpace, or ms.lab.Patch(facet=(x, y, z)) for a smooth face"
        raise BadInput(f"{shape.words!r} is no place of a support or a load: {remedy}")

    def contains(self, points: Floats, *, margin: float = 0.0) -> Bools:
        """Whether points [mm], shape [..., 3], lie in a sphere, box or half-space, or no more than a margin [mm] outside."""
        if self.sphere is not None:
            return in_ball(points, self.sphere[:3], self.sphere[3], margin=margin)
        if self.box is not None:
            return in_box(points, self.box[:3], self.box[3:], margin=margin)
        assert self.plane is not None, "near and facet are no shapes in space: they are picked on the surface"
        return in_half_space(points, self.plane[:3], self.plane[3:], margin=margin)

    @property
    def words(self) -> str:
        """Its notation in a load file."""
        shape = next(shape for shape in SHAPES if getattr(self, shape) is not None)
        return f"{shape} {_spaced(getattr(self, shape))}"


Place = Patch | Literal["resting face"]


class Support(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A support: a place of the part that is held.

    Attributes:
        at: The place; a Box, Sphere or HalfSpace becomes the patch of that shape.
        kind: `fixed`, or `roller`: free to slide along the surface, held across it.

    Example:
        >>> ms.Support(at=ms.Box((-9, -9, -1), (9, 9, 1))).kind
        'fixed'
    """

    at: Place
    kind: Literal["fixed", "roller"] = "fixed"

    def __post_init__(self) -> None:
        """Take a region for the patch it is."""
        _take_region(self)


class Load(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A load on a part: exactly one of force, pressure and gravity.

    Attributes:
        at: The place a force or a pressure acts on; a Box, Sphere or HalfSpace becomes the patch of that shape.
        force: Total force, spread evenly over the place [N].
        pressure: Pressure into the surface [MPa].
        gravity: The part's own weight, as a multiple of standard gravity.
        direction: Where gravity points; any length.

    Example:
        >>> ms.Load(at=ms.Sphere((0, 0, 40), 10), force=20, direction=(0, 0, -1)).force
        20
    """

    at: Place | None = None
    force: tuple[float, float, float] | None = None
    pressure: float | None = None
    gravity: float | None = None
    direction: tuple[float, float, float] = (0.0, 0.0, -1.0)

    def __post_init__(self) -> None:
        _take_region(self)
        given = [effect for effect in EFFECTS if getattr(self, effect) is not None]
        if len(given) != 1:
            raise BadInput(f"a load is one of {', '.join(EFFECTS)}, not {' and '.join(given) or 'nothing'}")
        value = getattr(self, given[0])
        numbers = (value,) if isinstance(value, int | float) else value
        _finite(given[0], numbers)
        _finite("direction", self.direction)
        if not any(numbers):
            raise BadInput(f"{given[0]} is zero: leave the load out or give it a size")
        if self.gravity is not None and not any(self.direction):
            raise BadInput("the direction of gravity is zero: (0, 0, -1) is down")
        if (self.at is None) != (self.gravity is not None):
            raise BadInput("gravity acts everywhere: leave out its `at`" if self.gravity is not None else f"{given[0]} needs a place: `at`")


class LoadCase(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A load case: supports and the loads that act together.

    Attributes:
        name: What people call it, "hand on the rim".
        supports: Where the part is held.
        loads: What acts on it.

    Example:
        >>> foot, top = ms.Box((-9, -9, -1), (9, 9, 1)), ms.Box((-9, -9, 30), (9, 9, 50))
        >>> case = ms.LoadCase(name="a hand", supports=(ms.Support(at=foot),), loads=(ms.Load(at=top, force=50, direction=(0, 0, -1)),))
        >>> case.name
        'a hand'
    """

    name: str
    supports: tuple[Support, ...]
    loads: tuple[Load, ...]

    def __post_init__(self) -> None:
        if not self.name.strip():
            raise BadInput("a load case needs a name, such as 'hand on the rim'")
        for what in ("supports", "loads"):
            if not getattr(self, what):
                raise BadInput(f"load case {self.name!r} has no {what}: give at least one")


def read_loads(path: str | Path) -> tuple[LoadCase, ...]:
    """The load cases of a TOML file; BadInput names the file, the case and the key that cannot be used."""
    file = Path(path)
    if not file.exists():
        raise absent(file, "load file")
    try:
        table = read_table(file)
    except ValueError as error:
        raise BadInput(f"load file {file} cannot be read: {error}") from error
    if not isinstance(table, dict):
        raise BadInput(f"load file {file} has no load case: begin one with [[case]]")
    cases, others = table.get("case"), sorted(set(table) - {"case"})
    if others:
        raise BadInput(f"load file {file}: unknown key {others[0]!r}; a load file holds [[case]] tables only")
    if not isinstance(cases, list) or not cases:
        raise BadInput(f"load file {file} has no load case: begin one with [[case]]")
    return _cases(cases, f"load file {file}")


def load_cases(loads: str | Path | LoadCase | Sequence[LoadCase]) -> tuple[LoadCase, ...]:
    """Load cases from a file, or as given in Python, with every number in the type it has when read from disk."""
    if isinstance(loads, str | Path):
        return read_loads(loads)
    given = [loads] if isinstance(loads, LoadCase) else list(loads)
    if not all(isinstance(case, LoadCase) for case in given):
        raise BadInput("loads must be a load file or a list of LoadCase")
    return _cases([msgspec.to_builtins(case) for case in given], "loads")


def _cases(tables: Sequence[Any], source: str) -> tuple[LoadCase, ...]:
    """Load cases from what a file holds; BadInput names the case that cannot be read."""
    cases = list[LoadCase]()
    for number, table in enumerate(tables, start=1):
        try:
            cases.append(msgspec.convert(table, LoadCase))
        except (msgspec.ValidationError, BadInput) as error:
            name = table.get("name") if isinstance(table, dict) else None
            label = repr(name) if isinstance(name, str) and name else f"number {number}"
            words = str(error).replace(" - at `$.", " at `")  # the parser's sign for the table
            words = words.replace("Object missing", "it is missing").replace("Object contains", "it contains")
            if words.endswith(".at`"):
                words += f"; a place is {RESTING_FACE!r} or a table of one of {', '.join(SHAPES)}"
            raise BadInput(f"{source}, case {label}: {words}") from error
    names = [case.name for case in cases]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:  # a verdict could not say which it means
        raise BadInput(f"{source}: two cases are called {twice!r}; give each its own name")
    return tuple(cases)


def _take_region(record: Support | Load) -> None:
    """Store a region given as the place of a record as a patch, so that there is one way a place is written down."""
    given: Any = record.at  # the annotation is what is stored; msgspec takes no union of tagged and other records
    if isinstance(given, Region):
        msgspec.structs.force_setattr(record, "at", Patch.of(given))
    elif not (given is None or isinstance(given, Patch) or given == RESTING_FACE):
        raise BadInput(f"a place is ms.Sphere, ms.Box, ms.HalfSpace or {RESTING_FACE!r}, not {given!r}")


def _finite(what: str, numbers: Sequence[float]) -> None:
    if not all(map(math.isfinite, numbers)):
        raise BadInput(f"{what} {_spaced(numbers)} must be finite numbers")


def _spaced(numbers: Sequence[float]) -> str:
    return "[" + ", ".join(f"{number:g}" for number in numbers) + "]"
