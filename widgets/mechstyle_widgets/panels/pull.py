"""A load at the place that was clicked: how hard it pulls and which way, with an arrow on the part."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import ipywidgets
import numpy as np
import traitlets

from mechstyle.errors import BadInput
from mechstyle.records.load_cases import Load, LoadCase, Patch, Support
from mechstyle.records.mesh import Floats
from mechstyle.records.regions import Point
from mechstyle_widgets.jupyter.language import word
from mechstyle_widgets.jupyter.looks import lean, show
from mechstyle_widgets.settings.drop import DropOptions
from mechstyle_widgets.settings.section import WIDE, Section, linked
from mechstyle_widgets.viewer.viewer import Viewer

AXES = {"down": (0, 0, -1), "up": (0, 0, 1), "along x": (1, 0, 0), "against x": (-1, 0, 0), "along y": (0, 1, 0), "against y": (0, -1, 0)}
OUT, INTO, EYE = "out of the surface", "into the surface", "towards me"
"""Directions that depend on the place, and on where one looks from."""
REACH, LEAST = 0.05, 2.0
"""Radius of the place a load acts on, as a share of the part's size and at least [mm]."""
ARROW = 0.3
"""Length of the arrow, as a share of the part's size."""


class PullHere(Section):
    """A force at the place that was clicked last, which becomes one of the loads that the part must carry.

    Attributes:
        place: The place [mm], None before there is one.
        held: Another place [mm], where the part is held; None for the face it rests on.
        force: How hard it pulls [N].
        towards: Which way.
        shown: Whether its arrow is drawn: while one looks at it.
    """

    place: Any = traitlets.Tuple(None, allow_none=True)
    held: Any = traitlets.Tuple(None, allow_none=True)
    force = traitlets.Float(50.0, min=0.1, max=1e5)
    towards = traitlets.Enum((*AXES, OUT, INTO, EYE), "down")
    shown = traitlets.Bool(True)

    def __init__(self, options: DropOptions, seen: Callable[[], Viewer | None]) -> None:
        """Add to the loads of a drop test; `seen` gives the view that is clicked in."""
        self._options, self._seen = options, seen
        force = linked(self, "force", ipywidgets.BoundedFloatText, "force [N]", min=0.1, max=1e5, step=10.0)
        ways = [(one, one) for one in self.traits()["towards"].values]
        towards = linked(self, "towards", ipywidgets.Dropdown, "which way", options=ways)
        half = {"width": "50%"}
        what = "The part must carry this besides the fall"
        add = lean(ipywidgets.Button, description="pull here", icon="long-arrow-right", tooltip=what, layout=half)
        what = "The part is held at this place instead of on the face it rests on; once more, on that face again"
        hold = lean(ipywidgets.Button, description="hold it here", icon="lock", tooltip=what, layout=half)
        self._controls = lean(ipywidgets.VBox, [force, towards, lean(ipywidgets.HBox, [add, hold], layout=WIDE)])
        super().__init__([self._controls])
        add.on_click(lambda _: self.pull())
        hold.on_click(lambda _: self.hold())
        options.observe(self._tell, "loads")
        self._tell()

    def click(self, place: Point) -> None:
        """Take the place [mm] of a click on the part."""
        self.place = place

    def pull(self) -> None:
        """Let the part carry the force."""
        viewer = self._seen()
        if self.place is None or viewer is None:
            return
        x, y, z = (round(value, 2) + 0.0 for value in self.place)  # or a place is called -0
        reach = round(max(LEAST, REACH * viewer.undeformed.size), 2)
        fx, fy, fz = (round(float(value), 4) for value in self.force * self._direction(viewer))
        held = Support(at="resting face" if self.held is None else Patch(near=(*self.held, reach)))
        name = f"{self.force:g} N {self.towards} at {x:.0f}, {y:.0f}, {z:.0f}"
        case = LoadCase(name=name, supports=(held,), loads=(Load(at=Patch(near=(x, y, z, reach)), force=(fx, fy, fz)),))
        try:
            self._options.loads = (*(one for one in self._options.loads if one.name != name), case)
        except BadInput as error:
            self.complain(str(error))

    def hold(self) -> None:
        """Hold the part at the place that was clicked, or, once more, on the face it rests on."""
        self.held = None if self.held == self.place else self.place

    def _direction(self, viewer: Viewer) -> Floats:
        if self.towards in AXES:
            return np.asarray(AXES[self.towards], np.float64)
        if self.towards == EYE:
            return np.asarray(viewer.towards_eye, np.float64)
        mesh = viewer.undeformed
        normal = np.asarray(mesh.vertex_normals[np.linalg.norm(mesh.vertices - np.asarray(self.place), axis=1).argmin()], np.float64)
        return normal if self.towards == OUT else -normal

    @traitlets.observe("place", "held", "force", "towards", "shown")
    def _tell(self, _change: Any = None) -> None:
        """Draw the arrow, and say what the part must carry."""
        show(self._controls, self.place is not None)
        viewer = self._seen()
        if viewer is not None and not self.shown:
            viewer.arrow = ()
        elif viewer is not None and self.place is not None:
            tip = np.add(self.place, ARROW * viewer.undeformed.size * self._direction(viewer))
            viewer.arrow = (self.place, tuple(tip.tolist()))
        self.complain("")
        where = "" if self.held is None else word("Held at {}.").format(", ".join(f"{value:.0f}" for value in self.held))
        carried = "; ".join(case.name for case in self._options.loads)
        loads = word("It must carry: {}.").format(carried) if carried else ""
        ask = "" if self.place is not None else word("Click on the part to ask about a place, or to pull there.")
        self.note(" ".join(filter(None, (ask, where, loads))))
