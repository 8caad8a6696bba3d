"""The scene of a part on its floor: buffers are made once, later only their contents change.

Replacing a buffer, or adding to a scene on show, leaks memory in the browser.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pythreejs
import trimesh
from numpy.typing import ArrayLike, NDArray

from mechstyle.pictures.colormap import PLAIN
from mechstyle.records.mesh import Floats, SurfaceMesh
from mechstyle_widgets.viewer import shaders
from mechstyle_widgets.viewer.layers import Layer
from mechstyle_widgets.viewer.shaders import HIDDEN, MOST_PINS, OWN, WHOLE

BACKGROUNDS = {"light": "#f6f6f4", "dark": "#1e1f22"}
SHADES = {"light": [0.87, 0.87, 0.86], "dark": [0.07, 0.075, 0.085]}
"""Colours of a shadow on them."""
SUNK = 0.002
"""How far below its floor a shadow lies, of the size of the part, so that the grid is drawn over it."""
RULER = "#d9480f"
"""Colour of the bar that is measured along: seen on both backgrounds and from every ramp."""
THICK, HEAD = 0.008, 8.0
"""How thick it is, of the size of the part, and how long the head of an arrow, of that."""
AXES = {"x": "#b4483c", "y": "#3d7d3a", "z": "#3b5fa8"}

Floats32 = NDArray[np.float32]
Plane = tuple[float, float, float, float]
"""A normal and how far along it a plane lies [mm]: what lies beyond it is cut off."""


class Scene:
    """A part (`part`), perhaps cut open, the floor it stands on, its axes, markers, numbered pins, and a line that is measured along."""

    def __init__(self, mesh: SurfaceMesh, centre: ArrayLike, theme: str = "light") -> None:
        """Build it whole around a part, with `centre` [mm] at the origin, about which the controls orbit."""
        self._vertices, self._normals = _attribute(mesh.vertices), _attribute(mesh.vertex_normals)
        self._colours, self._places = _attribute(_own_colours(mesh)), _attribute(np.full(len(mesh.vertices), OWN))
        self._protected = _attribute(np.zeros(len(mesh.vertices)))
        count = 5 + MOST_PINS
        self._spots, self._kinds = _attribute(np.zeros((count, 3))), _attribute(np.full(count, HIDDEN))
        self._cut: tuple[Plane, bool] = (WHOLE, False)
        self._bands = 0
        self._marked: tuple[Any, ...] = (None, None, False)
        self._thick = THICK * mesh.size
        self._bar = _attribute(_bar(np.zeros(3), np.ones(3), 1.0, arrow=False))
        self._ruler = pythreejs.Mesh(
            pythreejs.BufferGeometry(attributes={"position": self._bar}),
            pythreejs.MeshBasicMaterial(color=RULER, depthTest=False, transparent=True, side="DoubleSide"),
            frustumCulled=False, renderOrder=1, visible=False,
        )  # fmt: skip
        index = pythreejs.BufferAttribute(mesh.faces.ravel().astype(np.uint32), normalized=False)
        self._geometry = pythreejs.BufferGeometry(attributes={
            "position": self._vertices, "normal": self._normals, "colour": self._colours, "place": self._places,
            "is_protected": self._protected, "index": index,
        })  # fmt: skip
        material = pythreejs.ShaderMaterial(
            vertexShader=shaders.PART_VERTEX, fragmentShader=shaders.PART_FRAGMENT, extensions={"derivatives": True}, side="DoubleSide",
            uniforms=_uniforms(_texture(shaders.ramp()), WHOLE, filled=False),
        )  # fmt: skip
        self.part = pythreejs.Mesh(self._geometry, material)
        level = float(mesh.vertices[:, 2].min()) - SUNK * mesh.size
        self._shadow = pythreejs.Mesh(self._geometry, pythreejs.ShaderMaterial(
            vertexShader=shaders.SHADOW_VERTEX, fragmentShader=shaders.SHADOW_FRAGMENT, side="DoubleSide",
            uniforms={"level": {"value": level}, "shade": {"value": SHADES[theme]}},
        ), frustumCulled=False)  # fmt: skip
        children = [self.part, self._shadow, *_floor(mesh), self._ruler, *self._markers()]
        self._stage = pythreejs.Group(children=children, position=(-np.asarray(centre)).tolist())
        self.three = pythreejs.Scene(children=[self._stage], background=BACKGROUNDS[theme])

    def light(self, theme: str) -> None:
        """Take the ground of another theme, and its shadows."""
        self.three.background = BACKGROUNDS[theme]
        material = self._shadow.material
        material.uniforms = {**material.uniforms, "shade": {"value": SHADES[theme]}}

    def move(self, mesh: SurfaceMesh) -> None:
        """Take over the positions, normals and colours of a mesh of the same faces."""
        self._vertices.array = _single(mesh.vertices)
        self._normals.array = _single(mesh.vertex_normals)
        self._colours.array = _single(_own_colours(mesh))
        self._geometry.exec_three_obj_method("computeBoundingSphere")

    def paint(self, layer: Layer | None) -> None:
        """Show a field, or the part's own colours."""
        count = len(self._places.array)
        self._places.array = np.full(count, OWN, np.float32) if layer is None else shaders.paint(layer.values, layer.scale)

    def hatch(self, protected: NDArray[np.bool_] | None) -> None:
        """Hatch what is protected, shape [vertex_count]; None for nothing."""
        self._protected.array = np.zeros(len(self._protected.array), np.float32) if protected is None else _single(protected)

    def cut(self, plane: Plane = WHOLE, *, filled: bool = False) -> None:
        """Cut off what lies beyond a plane; `filled` shows the cut as if the part were solid there, else one looks inside."""
        if (plane, filled) != self._cut:
            self._cut = plane, filled
            self._renew()
            self.mark(*self._marked[:-1], arrow=self._marked[-1])

    def band(self, count: int) -> None:
        """Show fields in so many colours, 0 for all."""
        if count != self._bands:
            self._bands = count
            self._renew()

    def _renew(self) -> None:
        """Tell the material of the part what to leave out, and how many colours a field has."""
        (plane, filled), material = self._cut, self.part.material
        material.uniforms = _uniforms(material.uniforms["ramp"]["value"], plane, filled=filled, bands=self._bands)

    def mark(
        self,
        extremes: tuple[int, int] | None,
        picked: int | None,
        pins: Sequence[int] = (),
        ends: Sequence[ArrayLike] = (),
        *,
        arrow: bool = False,
    ) -> None:
        """Put the markers where they belong; what is None, missing or cut off is taken away.

        They are vertices: of the greatest and the least value, picked, and pins with numbers, at most MOST_PINS. Between two ends [mm]
        lies a ruler, or an arrow from foot to tip.
        """
        self._marked, (*normal, reach) = (extremes, picked, pins, ends, arrow), self._cut[0]
        spots, kinds = np.zeros((5 + MOST_PINS, 3), np.float32), np.full(5 + MOST_PINS, HIDDEN, np.float32)
        looks = (shaders.MAXIMUM, shaders.MINIMUM, shaders.PICKED)
        marked = zip((0, 1, 2), (*(extremes or (None, None)), picked), looks, strict=True)
        numbered = ((5 + number, vertex, shaders.PIN + 1 + number) for number, vertex in enumerate(pins))
        for place, vertex, kind in (*marked, *numbered):
            if vertex is not None and self._vertices.array[vertex] @ normal <= reach:
                spots[place], kinds[place] = self._vertices.array[vertex], kind
        for place, end in enumerate(ends[:1] if arrow else ends, start=3):
            spots[place], kinds[place] = end, shaders.END
        self._spots.array, self._kinds.array = spots, kinds
        if len(ends) == 2:
            foot, tip = (np.asarray(end, np.float64) for end in ends)
            self._bar.array = _single(_bar(foot, tip, self._thick, arrow=arrow))
        self._ruler.visible = len(ends) == 2

    def _markers(self) -> Iterator[Any]:
        """All markers over everything, and once more the extremes, where nothing of the part is before them."""
        geometry, numbers = pythreejs.BufferGeometry(attributes={"position": self._spots, "kind": self._kinds}), _texture(shaders.numbers())
        for near_side in (False, True):
            material = pythreejs.ShaderMaterial(
                vertexShader=shaders.MARKER_VERTEX, fragmentShader=shaders.MARKER_FRAGMENT, depthTest=near_side, depthWrite=False,
                transparent=True, uniforms={"near_side": {"value": float(near_side)}, "numbers": {"value": numbers}},
            )  # fmt: skip
            yield pythreejs.Points(geometry, material, frustumCulled=False, renderOrder=2 + near_side)


def round_length(wanted: float) -> float:
    """The largest of 1, 2, 5, 10, 20, 50 … (and of their tenths) that is not above `wanted` [mm]."""
    power = 10.0 ** math.floor(math.log10(max(wanted, 1e-3)))
    return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= max(wanted, 1e-3) * (1 + 1e-9))


def floor_cell(mesh: SurfaceMesh) -> float:
    """Width of a cell of the grid a part stands on [mm]."""
    return round_length(max(0.12 * mesh.size, 0.1 * float(mesh.extents[:2].max())))


def floor_corners(mesh: SurfaceMesh) -> NDArray[np.float64]:
    """Two opposite corners of the grid a part stands on [mm], shape [2, 3]."""
    cell, low, high = floor_cell(mesh), mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    first, last = np.floor(low[:2] / cell), np.ceil(high[:2] / cell)
    return np.column_stack([np.stack([first, last]) * cell, [low[2], low[2]]])


def _floor(mesh: SurfaceMesh) -> list[Any]:
    """A grid on the floor, and the three axes at its corner with their letters."""
    corners, cell = floor_corners(mesh), floor_cell(mesh)
    (x0, y0, floor), (x1, y1, _) = corners
    along_y = [((x, y0, floor), (x, y1, floor)) for x in np.arange(x0, x1 + 0.5 * cell, cell)]
    along_x = [((x0, y, floor), (x1, y, floor)) for y in np.arange(y0, y1 + 0.5 * cell, cell)]
    positions = pythreejs.BufferGeometry(attributes={"position": _attribute(np.reshape(along_x + along_y, (-1, 3)))})
    look = {"vertexShader": shaders.FLOOR_VERTEX, "fragmentShader": shaders.FLOOR_FRAGMENT, "transparent": True, "depthWrite": False}
    arrows = [part for axis, letter in enumerate(AXES) for part in _axis(corners[0], axis, letter, cell)]
    return [pythreejs.LineSegments(positions, pythreejs.ShaderMaterial(**look)), *arrows]


def _axis(corner: NDArray[np.float64], axis: int, letter: str, length: float) -> list[Any]:
    """A line of one grid cell along an axis, and its letter at the end."""
    step = np.zeros(3)
    step[axis] = length
    line = pythreejs.BufferGeometry(attributes={"position": _attribute(np.stack([corner, corner + step]))})
    texture = pythreejs.TextTexture(string=letter, color=AXES[letter], size=64, squareTexture=True)
    name = pythreejs.Sprite(pythreejs.SpriteMaterial(map=texture, transparent=True), position=(corner + 1.3 * step).tolist())
    name.scale = [0.6 * length] * 3
    return [pythreejs.LineSegments(line, pythreejs.LineBasicMaterial(color=AXES[letter], linewidth=2)), name]


def _texture(pixels: NDArray[np.uint8]) -> Any:
    smooth = {"magFilter": "LinearFilter", "minFilter": "LinearFilter"}
    return pythreejs.DataTexture(pixels, format="RGBAFormat", type="UnsignedByteType", **smooth)


def _uniforms(texture: Any, plane: Plane, *, filled: bool, bands: int = 0) -> dict[str, dict[str, Any]]:
    """What the shader of a part gets; the texture comes last, because pythreejs gives it the name of whichever does."""
    numbers: dict[str, Any] = {"cut": [float(value) for value in plane], "filled": float(filled), "bands": float(bands)}
    return {**{name: {"value": value} for name, value in numbers.items()}, "ramp": {"value": texture}}


def _bar(foot: Floats, tip: Floats, thick: float, *, arrow: bool) -> Floats:
    """Triangles of a round bar between two places, with the head of an arrow at its tip [mm], shape [144, 3].

    A line is a pixel wide whatever width it is given, and gets lost on a part of many colours.
    """
    length = float(np.linalg.norm(tip - foot))
    head = min(HEAD * thick, 0.5 * length) if arrow else 0.0
    shaft = trimesh.creation.cylinder(0.5 * thick, max(length - head, 1e-6), sections=8)
    cone = trimesh.creation.cone(2.0 * thick if arrow else 0.0, head, sections=8)
    raised = ((shaft, 0.5 * (length - head)), (cone, length - head))
    corners = np.concatenate([np.add(solid.triangles.reshape(-1, 3), (0.0, 0.0, height)) for solid, height in raised])
    up = np.array([0.0, 0.0, 1.0])
    turned: Any = trimesh.geometry.align_vectors(up, tip - foot if length > 0.0 else up)  # type: ignore[no-untyped-call]
    return np.asarray(foot + corners @ turned[:3, :3].T)


def _own_colours(mesh: SurfaceMesh) -> NDArray[np.floating]:
    """Display colours of the part itself, shape [vertex_count, 3]."""
    return np.broadcast_to(PLAIN, mesh.vertices.shape) if mesh.colours is None else mesh.colours


def _attribute(values: ArrayLike) -> Any:
    return pythreejs.BufferAttribute(_single(values), normalized=False)


def _single(values: ArrayLike) -> Floats32:
    return np.ascontiguousarray(values, dtype=np.float32)
