"""Regions of a part, as records: a style is kept from them, or is asked for there; a run keeps them, people write them.

Which vertices a region holds is worked out in `geometry.region_selection`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial

import msgspec
import numpy as np

from mechstyle.errors import BadInput, unknown
from mechstyle.records.mesh import Bools, Floats, in_ball, in_box, in_half_space

Point = tuple[float, float, float]

ENDS: Mapping[str, tuple[int, int]] = {"top": (2, 1), "bottom": (2, -1), "left": (0, -1), "right": (0, 1), "front": (1, -1), "back": (1, 1)}
"""Axis and sign of the direction of each end of a part, as its front view shows it."""
KINDS = {
    "box": "box x y z x y z (two corners)",
    "sphere": "sphere x y z radius",
    "plane": "plane x y z nx ny nz (a point and the direction in which everything is protected)",
    "above": "above z",
    "below": "below z",
    "inside": "inside",
    "outside": "outside",
    "sides": "sides (the surfaces that stand upright)",
    "rim": "rim [width] (the band around openings)",
    "holes": "holes [width] (bores and slots with their rims, up to so many mm wide)",
    **{end: f"{end} [depth] (the half of the part at that end, or so many mm of it)" for end in ENDS},
    "segment": "segment x y z (the smooth piece of surface nearest to a point)",
    "vertices": "vertices i j k …",
}
"""How a region is written, after `--protect` or before the colon of a prompt, by its first word; lengths in mm."""


class ProtectedRegion(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind"):
    """Base of all protected regions: the ramp around them, and whether they keep their colour.

    Attributes:
        ramp: Way along the surface, from the border of the region on, over which the relief grows back to its full height [mm].
        colour: Whether the region keeps the part's own colour, too.
    """

    ramp: float = 0.0
    colour: bool = False

    def __post_init__(self) -> None:
        """Refuse a ramp that is no length."""
        if not 0.0 <= self.ramp <= 1e3:
            raise BadInput(f"the ramp of a protected region is {self.ramp:g} mm, but must lie between 0 and 1000")

    @property
    def words(self) -> str:
        """Its notation, as after `--protect`."""
        kind, own = self._notation()
        ramp, colour = [f"ramp {self.ramp:g}"] if self.ramp else [], ["colour"] if self.colour else []
        return " ".join([kind, *(f"{number:g}" for number in own), *ramp, *colour])

    def _notation(self) -> tuple[str, list[float]]:
        """The first word of its notation, and its numbers; a length of 0 is left to the part, and not written."""
        values = [getattr(self, name) for name in self.__struct_fields__ if name not in ProtectedRegion.__struct_fields__]
        own = [value for value in values if value and not isinstance(value, str)]
        numbers = [number for value in own for number in (value if isinstance(value, tuple) else (value,))]
        return str(self.__struct_config__.tag), numbers


class Vertices(ProtectedRegion, frozen=True, tag="vertices"):
    """Vertices of the standardised surface, by number."""

    indices: tuple[int, ...]

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.indices or min(self.indices) < 0:
            raise BadInput("a protected list of vertices must hold at least one number, and none below zero")


class Box(ProtectedRegion, frozen=True, tag="box"):
    """All within a box between two corners [mm].

    Example:
        >>> ms.Box((0, 0, 0), (10, 10, 5)).contains([[5, 5, 1], [5, 5, 9]])
        array([ True, False])
    """

    low: Point
    high: Point

    def __post_init__(self) -> None:
        super().__post_init__()
        _check_points(self.low, self.high)
        if not all(low < high for low, high in zip(self.low, self.high, strict=True)):
            raise BadInput("a protected box must have a first corner that is lower than the second in x, y and z")

    def contains(self, points: Floats) -> Bools:
        """Whether points [mm], shape [..., 3], lie in it."""
        return in_box(points, self.low, self.high)


class Sphere(ProtectedRegion, frozen=True, tag="sphere"):
    """All within a radius of a centre [mm].

    Example:
        >>> ms.Sphere((0, 0, 0), 4).contains([[0, 0, 3], [0, 0, 5]])
        array([ True, False])
    """

    centre: Point
    radius: float

    def __post_init__(self) -> None:
        super().__post_init__()
        _check_points(self.centre)
        if not 0.0 < self.radius < math.inf:
            raise BadInput(f"a protected sphere must have a radius above zero, not {self.radius:g} mm")

    def contains(self, points: Floats) -> Bools:
        """Whether points [mm], shape [..., 3], lie in it."""
        return in_ball(points, self.centre, self.radius)


class HalfSpace(ProtectedRegion, frozen=True, tag="plane"):
    """All on that side of a plane to which its normal points; the normal need not have length 1.

    Example:
        >>> above = ms.HalfSpace((0, 0, 20), (0, 0, 1))
        >>> above.contains([[0, 0, 25], [0, 0, 15]])
        array([ True, False])
    """

    point: Point
    normal: Point

    def __post_init__(self) -> None:
        super().__post_init__()
        _check_points(self.point, self.normal)
        if not any(self.normal):
            raise BadInput("a protected half-space needs a normal that is not zero, such as 0 0 1 for all above its point")

    def contains(self, points: Floats) -> Bools:
        """Whether points [mm], shape [..., 3], lie in it."""
        return in_half_space(points, self.point, self.normal)

    def _notation(self) -> tuple[str, list[float]]:
        if self.point[:2] == (0.0, 0.0) and self.normal in {(0.0, 0.0, 1.0), (0.0, 0.0, -1.0)}:  # its height says it all
            return "above" if self.normal[2] > 0.0 else "below", [self.point[2]]
        return super()._notation()


class Inside(ProtectedRegion, frozen=True, tag="inside"):
    """The surfaces of hollows that open to the outside: the inside of a cup, the cells of a box."""


class Outside(ProtectedRegion, frozen=True, tag="outside"):
    """The outside of a hollow part: everything that is not inside."""


class Sides(ProtectedRegion, frozen=True, tag="sides"):
    """The surfaces that stand upright, within 45°."""


class Rim(ProtectedRegion, frozen=True, tag="rim"):
    """The band around the openings of a hollow part: all that is this near to the border between inside and outside.

    Attributes:
        width: Way along the surface from that border [mm]; 0 for one that suits the part.
    """

    width: float = 0.0

    def __post_init__(self) -> None:
        """Refuse a width that is no length."""
        super().__post_init__()
        _check_length("width of a rim", self.width)


class Holes(ProtectedRegion, frozen=True, tag="holes"):
    """Bores, slots and sockets with the rims around them, so that screws, plugs and threads keep their fit.

    Attributes:
        width: The widest that is one [mm]; 0 for a quarter of the size of the part.
    """

    width: float = 0.0

    def __post_init__(self) -> None:
        """Refuse a width that is no length."""
        super().__post_init__()
        _check_length("width of holes", self.width)


class End(ProtectedRegion, frozen=True, tag="end"):
    """All at one end of a part, as it stands.

    Attributes:
        end: One of ENDS.
        depth: How far it reaches into the part from there [mm]; 0 for half of the part.
    """

    end: str
    depth: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.end not in ENDS:
            raise unknown("end of a part", self.end, ENDS)
        _check_length(f"depth of the {self.end}", self.depth)

    def beyond(self, points: Floats) -> Floats:
        """How far points [mm], shape [n, 3], lie beyond that end of what they all span [mm], shape [n]; in it zero or less."""
        axis, sign = ENDS[self.end]
        along = sign * points[:, axis]
        depth = self.depth or 0.5 * float(np.ptp(along))
        return np.asarray(along.max() - depth - along)

    def contains(self, points: Floats) -> Bools:
        """Whether points [mm], shape [n, 3], lie at that end of what they all span."""
        return np.asarray(self.beyond(points) <= 0.0)

    def _notation(self) -> tuple[str, list[float]]:
        return self.end, super()._notation()[1]


class Segment(ProtectedRegion, frozen=True, tag="segment"):
    """The smooth piece of surface, of one wall thickness, nearest to a point [mm]."""

    point: Point

    def __post_init__(self) -> None:
        """Refuse a point that is nowhere."""
        super().__post_init__()
        _check_points(self.point)


Shape = Box | Sphere | HalfSpace
"""Regions that hold points of space, whatever the part."""
Region = Vertices | Box | Sphere | HalfSpace | Inside | Outside | Sides | Rim | Holes | End | Segment


def region(text: str) -> Region:
    """A region as people write it: "inside", "box 0 0 0 10 10 10 ramp 2 colour"; KINDS lists what there is.

    BadInput if it cannot be read, with how to write it.
    """
    kind, *words = text.lower().split() or [""]
    if kind not in KINDS:
        raise unknown("region to protect", kind, KINDS, lists="`mechstyle protect --help`")
    try:
        ramp, colour = _option(words, "ramp", 1), _option(words, "colour", 0) is not None
        made = _MAKERS[kind](*(float(word) for word in words))
    except (ValueError, TypeError, IndexError) as error:
        how = f"write {KINDS[kind]}, then, if wanted, `ramp` with millimetres and `colour`"
        raise BadInput(f"cannot read the region {text!r}: {how}") from error
    return msgspec.structs.replace(made, ramp=ramp or 0.0, colour=colour)


_MAKERS: dict[str, Callable[..., Region]] = {
    "box": lambda a, b, c, d, e, f: Box((a, b, c), (d, e, f)),
    "sphere": lambda x, y, z, radius: Sphere((x, y, z), radius),
    "plane": lambda x, y, z, nx, ny, nz: HalfSpace((x, y, z), (nx, ny, nz)),
    "above": lambda z: HalfSpace((0.0, 0.0, z), (0.0, 0.0, 1.0)),
    "below": lambda z: HalfSpace((0.0, 0.0, z), (0.0, 0.0, -1.0)),
    "inside": lambda: Inside(),  # noqa: PLW0108 (the class itself would take a ramp from a stray number)
    "outside": lambda: Outside(),  # noqa: PLW0108
    "sides": lambda: Sides(),  # noqa: PLW0108
    "rim": lambda width=0.0: Rim(width),
    "holes": lambda width=0.0: Holes(width),
    **{end: partial(End, end) for end in ENDS},
    "segment": lambda x, y, z: Segment((x, y, z)),
    "vertices": lambda *numbers: Vertices(tuple(int(str(number).removesuffix(".0")) for number in numbers)),
}


def _option(words: list[str], name: str, values: int) -> float | None:
    """Take an option out of the words: its value, 1 if it has none, None if it is not there."""
    if name not in words:
        return None
    at = words.index(name)
    value = float(words[at + 1]) if values else 1.0
    del words[at : at + 1 + values]
    return value


def regions(given: str | Region | Sequence[str | Region]) -> tuple[Region, ...]:
    """Regions from records or from their notation, one or several, as they would be read from disk.

    So (0, 0, 1) and [0.0, 0.0, 1.0] are one recipe.
    """
    found = list[Region]()
    for one in [given] if isinstance(given, str | ProtectedRegion) else given:
        try:
            plain = msgspec.to_builtins(region(one) if isinstance(one, str) else one, enc_hook=lambda value: value.tolist())
            found.append(msgspec.convert(plain, Region))
        except (msgspec.ValidationError, AttributeError, TypeError) as error:
            raise BadInput(f"{one!r} is no region to protect ({error}): write `inside` or ms.Box((0, 0, 0), (10, 10, 10))") from error
    return tuple(found)


def _check_length(what: str, length: float) -> None:
    if not 0.0 <= length < math.inf:
        raise BadInput(f"the {what} is {length:g} mm, but must be a length, or be left out")


def _check_points(*points: Point) -> None:
    try:
        fine = all(len(point) == 3 and all(math.isfinite(x) for x in point) for point in points)
    except TypeError:
        fine = False
    if not fine:
        raise BadInput("the points and directions of a protected region must each be three finite numbers [mm]")
