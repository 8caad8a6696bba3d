"""The tools a style program draws with, on one part, in millimetres, and patterns on its cells that several styles share."""

from __future__ import annotations

import zlib
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mechstyle.geometry.cancelling import CancelCheck, never_cancel
from mechstyle.records.mesh import Floats, Indices, SurfaceMesh
from mechstyle.records.simulation import LIKE_ASKED
from mechstyle.styling.drawing import noise, scatter
from mechstyle.styling.drawing.charts import Chart, chart_of
from mechstyle.styling.drawing.colours import cast, finish_of, recoloured, shaded
from mechstyle.styling.drawing.operators import Operators
from mechstyle.styling.drawing.projection import PlacedPicture

_REFERENCE_AREA = 60_000.0  # surface of a 100 mm cube or pen holder [mm²], on which features have their nominal size
_SCALES = (0.1, 4.0)
_CLOUD = 14.0  # size of the patches of a mottled finish, on a part of 100 mm [mm]
_SOFTENING = 0.35  # halves a pattern that alternates from vertex to vertex, and leaves one of six edges nearly as it was


def scale_by_area(mesh: SurfaceMesh) -> float:
    """Size of features over their nominal size that suits a part by its area alone."""
    return float(np.clip(np.sqrt(mesh.face_areas.sum() / _REFERENCE_AREA), *_SCALES))


class Bond(NamedTuple):
    """Cells in rows."""

    x: Floats  # place along the row in the cell, in [-½, ½], 0 in the middle, shape [n]
    y: Floats  # place across the row, upwards, in [-½, ½], shape [n]
    odd: NDArray[np.bool_]  # whether the row is one of every second, shape [n]


class Canvas:
    """A part and the tools to draw on it; equal part, seed, size and colour draw equal pictures.

    Attributes:
        mesh: The part.
        seed: Decides everything random.
        colour: Display RGB of the body, None for the style's own.
        shade: How light the style's own colours are to be; 1 as they are.
        scale: Size of features over their nominal size, which suits a part of 100 mm.
        nozzle: Diameter of the nozzle it is printed with [mm], 0 for none: what is finer is noted.
        edge: Edge length of the mesh [mm]; nothing much finer than two of them can be drawn.
        notes: What the user should know of this drawing, in sentences.
        enlarged: Times larger than asked the pattern is drawn, 1 if it is not.
        picture: The picture to draw, None for none.
        found_pieces: What `pieces` has answered so far.
        go_on: Asked before each of the tools that take long; what it raises ends the drawing.
    """

    def __init__(
        self, mesh: SurfaceMesh, seed: int, size: float = 1.0, colour: tuple[float, float, float] | None = None, shade: float = 1.0, *,
        nozzle: float = 0.0,
    ) -> None:  # fmt: skip
        self.colour = colour
        self.shade = shade
        self.mesh = mesh
        self.seed = seed
        self.operators = Operators(mesh)
        self._charts: list[Chart] = []  # one or none, in common with the canvases it shares with
        self.edge = self.operators.mesh.edge_length
        self.scale = scale_by_area(mesh) * size
        self.nozzle = nozzle
        self.notes: list[str] = []
        self.enlarged = 1.0
        self.picture: PlacedPicture | None = None
        self.found_pieces: list[Indices] = []
        self.go_on: CancelCheck = never_cancel

    @property
    def points(self) -> Floats:
        """Positions [mm], shape [n, 3]."""
        return self.mesh.vertices

    @cached_property
    def chart(self) -> Chart:
        """Chart of rows and columns on the surface."""
        if not self._charts:
            self._charts.append(chart_of(self.operators))
        return self._charts[0]

    def share(self, other: Canvas) -> None:
        """Take over what another canvas of the same surface works out of that surface alone, which takes longer than a pattern."""
        if other.mesh is self.mesh:
            self.operators, self._charts = other.operators, other._charts

    def unit(self, what: str, finest: float, edges: float = 2.0) -> float:
        """Millimetres per nominal millimetre, enough for the mesh to carry the finest feature.

        The feature has a plural name, for the note, and a nominal size [mm], and must span so many mesh edges.
        """
        needed = edges * self.edge / finest
        if needed > LIKE_ASKED * self.scale:
            self.enlarged = max(self.enlarged, needed / self.scale)
            wide, carried = finest * self.scale, finest * needed
            self.notes.append(
                f"the mesh (edge {self.edge:.2g} mm) is too coarse for {what} of {wide:.2g} mm: "
                f"the pattern was enlarged {needed / self.scale:.1f}x, to {what} of {carried:.2g} mm"
            )
        unit = max(self.scale, needed)
        if finest * unit < self.nozzle:
            too_fine = f"{what} of {finest * unit:.2g} mm are finer than a nozzle of {self.nozzle:g} mm prints"
            self.notes.append(f"{too_fine}: ask for larger features")
        return unit

    def bond(self, length: float, height: float, *, shift: float = 0.5, margin: float = 0.0, grip: float = 1.0) -> Bond:
        """Rows of cells of a length and height [mm], by default in running bond, every second row shifted by so many cells.

        The outermost cells end a `margin` [mm] outside a box-like part. Below a `grip` of 1, cells rather keep their length than stay above
        each other where the part gets narrower.
        """
        self.go_on()
        chart = self.chart
        self.go_on()
        row = chart.rows(height, margin)
        nearest = np.round(row)
        odd = nearest % 2 == 1
        self.go_on()
        column = chart.columns(length, margin, grip) + shift * odd
        return Bond(column - np.round(column), row - nearest, odd)

    def noise(self, wavelength: float, octaves: int = 4, salt: str = "", at: Floats | None = None) -> Floats:
        """Fractal solid noise, three deviations scaled to 1, free of what the mesh would alias; shape [n]."""
        self.go_on()
        where = self.points if at is None else at
        return noise.fbm(where, wavelength, octaves, self._seed(salt), finest=2.5 * self.edge)

    def warped(self, wavelength: float, strength: float, salt: str = "") -> Floats:
        """The points moved by noise of about `strength` [mm], shape [n, 3]."""
        moves = [self.noise(wavelength, 3, f"{salt}/{axis}") for axis in "xyz"]
        return self.points + strength * np.stack(moves, axis=1)

    def random(self, identities: NDArray[np.integer], salt: str = "") -> Floats:
        """A uniform random number in [0, 1) per identity, the same shape as `identities`."""
        return noise.random_of(identities, self._seed(salt))

    def scattered(self, spacing: float, salt: str = "", room: float = 0.0) -> Indices:
        """Vertices no two of which are nearer than `spacing` [mm] (Poisson disc).

        None is on a sharp edge or nearer to one than `room` [mm]; on a part too slim for that, none in the half that is nearest to edges.
        """
        self.go_on()
        free = self.operators.room
        wanted = max(room, 0.5 * self.edge)
        return scatter.poisson_disc(self.mesh, spacing, self._seed(salt), free >= min(wanted, float(np.median(free))))

    def cells(self, spacing: float, salt: str = "", at: Floats | None = None, stretch: Floats | float = 1.0) -> scatter.Cells:
        """Worley cells around scattered points, looked up at `at` if given, shape [n]; long along an axis whose `stretch` is below 1."""
        points = self.scattered(spacing, salt)
        looked_up = self.points if at is None else at
        return scatter.worley(self.points * stretch, self.mesh.vertex_normals, points, looked_up * stretch, spacing)

    def stamps(self, points: Indices, spacing: float, count: int = 1) -> scatter.Stamps:
        """The `count` nearest stamps at each vertex, placed at vertices `points` and upright, `spacing` [mm] apart."""
        self.go_on()
        return scatter.stamps(self.operators, points, self.chart.along, count, spacing)

    def pieces(self, inside: NDArray[np.bool_], label: NDArray[np.generic] | None = None) -> Indices:
        """Identity of the connected piece of `inside` (and of one `label`) that each vertex is in, shape [n]."""
        tail, head = self.operators.tail, self.operators.head
        together = inside[tail] & inside[head]
        if label is not None:
            together &= label[tail] == label[head]
        self.found_pieces.append(self.operators.components(together))
        return self.found_pieces[-1]

    def painted(self, colours: Floats) -> Floats:
        """The style's own colours of its body (brick, not mortar), shaded, or the colour asked for with their lights; shape [n, 3]."""
        if self.colour is None:
            return shaded(colours, self.shade)
        found = finish_of(self.colour)
        if found is None:
            return recoloured(colours, self.colour)
        mottled = found[0].mottled > 0.0
        return cast(colours, self.colour, found, self.noise(_CLOUD * self.scale, 4, "finish") if mottled else np.zeros(len(colours)))

    def softened(self, values: Floats) -> Floats:
        """Values [n] or [n, k] averaged with their neighbours' mean: edges sharper than the mesh can carry would look like combs."""
        return (1.0 - _SOFTENING) * values + _SOFTENING * (self.operators.ring_mean @ values)

    def smoothed(self, values: Floats, length: float) -> Floats:
        """Values diffused over `length` [mm]."""
        self.go_on()
        return self.operators.diffused(values, length)

    def _seed(self, salt: str) -> int:
        """A seed of its own for each use, so that two noises of one program are independent."""
        return zlib.crc32(f"{self.seed}/{salt}".encode())


def folded(phase: Floats) -> Floats:
    """Distance of a phase to the nearest whole number, in [0, ½]."""
    return np.asarray(np.abs(phase - np.round(phase)))


def dome(reach: Floats) -> Floats:
    """Height of half a ball of radius and height 1 at a distance from its middle."""
    return np.asarray(np.sqrt(np.clip(1.0 - reach**2, 0.0, 1.0)))


class Place(NamedTuple):
    """A place on a scale."""

    aside: Floats  # 0 on its middle line, 1 at its flanks, shape [n]
    down: Floats  # 0 on the line it hangs from, 1 at its tip, shape [n]


def hanging(bond: Bond) -> Place:
    """The place on the scale that hangs from this row of a running bond."""
    return Place(2.0 * np.abs(bond.x), 0.5 - bond.y)


def beneath(place: Place) -> Place:
    """The same place on the scale below, half a scale aside and a row down, which shows where the upper one ends."""
    return Place(1.0 - place.aside, place.down - 1.0)


def own_of_scales(canvas: Canvas, bond: Bond, inside: Floats, salt: str) -> Floats:
    """A random number in [-½, ½) for each scale, 0 in their corners; `inside` is positive on the upper scale, shape [n]."""
    aside, down = hanging(bond)
    # Scales of one row touch in their corners, where the one above has its tip.
    apart = np.minimum(np.hypot(1.0 - aside, down), np.hypot(aside, 1.0 - down)) > 0.25
    return (canvas.random(canvas.pieces(apart, bond.odd ^ (inside > 0.0)), salt) - 0.5) * apart


def fans(bond: Bond) -> tuple[Floats, Floats]:
    """Overlapping half rounds on a running bond of cells four times as wide as high, every row in front of the one above (seigaiha).

    Returns:
        Distance from the centre of the half round in front over its radius, in [0, 1], and angle from the upright [rad], at least 0.
    """
    # Centres lie on this row and the two below it, every second one half a round aside; the lowest round that reaches is in front.
    aside, up = np.abs(bond.x) * 2.0, bond.y * 0.5
    sideways = np.stack([1.0 - aside if step % 2 else aside for step in range(3)])
    upwards = np.stack([up + 0.5 * step for step in range(3)])
    reach = np.hypot(sideways, upwards)
    front = (2 - (reach[::-1] < 1.0).argmax(axis=0))[None]
    here, x, y = (np.take_along_axis(field, front, axis=0)[0] for field in (reach, sideways, upwards))
    return np.minimum(here, 1.0), np.asarray(np.arctan2(x, y))
