"""A plane through the part, and the controls that move it."""

from __future__ import annotations

from typing import Any

import ipywidgets
import numpy as np
import traitlets
from numpy.typing import ArrayLike, NDArray
from trimesh.intersections import slice_faces_plane

from mechstyle.records.mesh import SurfaceMesh
from mechstyle_widgets.jupyter.language import word
from mechstyle_widgets.jupyter.looks import lean, show
from mechstyle_widgets.viewer.scene import Plane
from mechstyle_widgets.viewer.shaders import WHOLE

STEPS = 200
"""Steps of the slider across a part."""
LEAP = 10
"""Of them, how many a key in the view makes."""


class Section(ipywidgets.HBox):  # type: ignore[misc]  # ipywidgets has no types
    """Where the part is cut open.

    Attributes:
        on: Whether it is.
        axis: Direction across the plane, `x`, `y` or `z`.
        at: Where the plane stands along it [mm].
        flipped: Whether what lies towards the lower end of the axis is cut off instead of the rest.
        filled: Whether the cut is shown as if the part were solid, hatched, instead of open.
    """

    on = traitlets.Bool(False)
    axis = traitlets.Enum(("x", "y", "z"), "y")
    at = traitlets.Float(0.0)
    flipped = traitlets.Bool(False)
    filled = traitlets.Bool(True)

    def __init__(self, low: ArrayLike, high: ArrayLike) -> None:
        """Cut a part that fills the box from `low` to `high` [mm]."""
        self._low, self._high = np.asarray(low, np.float64), np.asarray(high, np.float64)
        tooltips = [f"Cut across {axis}" for axis in "xyz"]
        axes = lean(ipywidgets.ToggleButtons, options=["x", "y", "z"], value="y", tooltips=tooltips, style={"button_width": "32px"})
        self._slider = lean(
            ipywidgets.FloatSlider,
            min=float(self._low[1]), max=float(self._high[1]), readout_format=".1f", continuous_update=True,
            tooltip="Where the cut is [mm]; Page Up and Page Down in the view",
            layout={"flex": "1 1 180px", "width": "auto", "min_width": "140px"},
        )  # fmt: skip
        flip = lean(ipywidgets.ToggleButton, description="other side", icon="exchange", tooltip="Show the other side of the cut")
        fill = lean(ipywidgets.ToggleButton, description="solid", icon="square", tooltip="Show the cut as solid, or look inside")
        what, unit = lean(ipywidgets.Label, word("cut across")), lean(ipywidgets.Label, "mm")
        super().__init__([what, axes, self._slider, unit, flip, fill])
        self.add_class("mechstyle-section-plane")
        for name, widget in (("axis", axes), ("at", self._slider), ("flipped", flip), ("filled", fill)):
            traitlets.link((self, name), (widget, "value"))
        self.observe(lambda _: show(self, self.on), "on")
        self._measure_out()
        show(self, self.on)

    @property
    def plane(self) -> Plane:
        """The plane; one that cuts nothing off while it is off."""
        if not self.on:
            return WHOLE
        side = -1.0 if self.flipped else 1.0
        normal = [side * float(axis == self.axis) for axis in "xyz"]
        return (normal[0], normal[1], normal[2], side * self.at)

    def open_towards(self, eye: ArrayLike) -> None:
        """Cut what is nearer to an eye [mm, from the middle of the part] off, across the level axis that points at it most."""
        across = np.asarray(eye, np.float64)[:2]
        number = int(np.abs(across).argmax())
        self.axis, self.flipped = "xy"[number], bool(across[number] < 0.0)
        self.on = True

    def move(self, steps: int) -> None:
        """Move the plane by so many of the keys' leaps."""
        wanted = self.at + steps * LEAP * self._slider.step
        self.at = float(np.clip(wanted, self._slider.min, self._slider.max))

    def keeps(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Whether points [mm], shape [..., 3], are left."""
        *normal, reach = self.plane
        return np.asarray(np.asarray(points) @ np.asarray(normal) <= reach)

    def applied(self, mesh: SurfaceMesh, values: NDArray[Any] | None = None) -> tuple[SurfaceMesh, NDArray[Any] | None]:
        """What is left of a surface, open where it is cut, and of values over its vertices; all of it if nothing would be left."""
        if not self.on or not self.keeps(mesh.vertices).any():
            return mesh, values
        *normal, reach = self.plane
        carried = [*([] if mesh.colours is None else [mesh.colours]), *([] if values is None else [np.asarray(values)[:, None]])]
        given = np.hstack(carried) if carried else np.zeros((len(mesh.vertices), 1))
        inwards = -np.asarray(normal)
        cut: Any = slice_faces_plane
        vertices, faces, found = cut(mesh.vertices, mesh.faces, inwards, -reach * inwards, uv=given)
        if not len(faces):  # what is left lies in the plane
            return mesh, values
        colours = None if mesh.colours is None else np.clip(found[:, :3], 0.0, 1.0)
        return SurfaceMesh(vertices, faces, colours), None if values is None else found[:, -1]

    @traitlets.observe("axis")
    def _measure_out(self, _change: Any = None) -> None:
        """Let the slider reach across the part, with the plane in its middle."""
        number = "xyz".index(self.axis)
        low, high = float(self._low[number]), float(self._high[number])
        slider = self._slider
        slider.min, slider.max = min(low, slider.min), max(high, slider.max)  # as its value has to lie between
        self.at = 0.5 * (low + high)
        slider.min, slider.max, slider.step = low, high, (high - low) / STEPS or 1.0
