"""What mouse and keys do in a view besides turning it: ask about a place, keep it, measure, cut the part open."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import ipywidgets
import numpy as np
import traitlets
import trimesh

from mechstyle.errors import BadInput
from mechstyle.records.mesh import Floats, SurfaceMesh
from mechstyle.records.regions import Point
from mechstyle_widgets.viewer import probe
from mechstyle_widgets.viewer.camera import Orbit
from mechstyle_widgets.viewer.layers import STYLE
from mechstyle_widgets.viewer.section import Section
from mechstyle_widgets.viewer.shaders import MOST_PINS
from mechstyle_widgets.viewer.toolbar import TOOLS, Toolbar

COARSE, FINE = 15.0, 1.0
"""How far an arrow key turns the part, and with Ctrl [degrees]."""
ARROWS = {"ArrowLeft": (-1, 0), "ArrowRight": (1, 0), "ArrowUp": (0, 1), "ArrowDown": (0, -1)}
NEARER = {"+": 1.25, "=": 1.25, "-": 0.8}
PAGES = {"PageUp": 1, "PageDown": -1}
SHIFTED = {"1": "front", "2": "side", "3": "top", "4": "below", "5": "three_quarter"}
"""Standard views by the digits that, with Shift, call them."""
ROOM = 0.85
"""How near the camera comes to a part it looks at as a whole, so that the legend below hides nothing of it."""
PICKS = {"m": "measure", "a": "places"}


class Tools(traitlets.HasTraits):
    """Mixin of a view.

    Attributes:
        layer: Name of what is shown.
        probed: The vertex asked about, None for none.
        places: Vertices that are kept in the list, in order, at most MOST_PINS.
        measured: Ends of what is measured [mm], two at most.
        arrow: Foot and tip of an arrow on the part [mm], nothing for none.
        tool: What a click does besides asking: "", `measure` or `places`.
        parallel: Whether one looks in parallel instead of in perspective.
        section: Where the part is cut open: `section.on`, `section.axis`, `section.at` [mm].
    """

    layer = traitlets.Unicode(STYLE)
    probed = traitlets.Int(None, allow_none=True)
    places = traitlets.Tuple()
    measured = traitlets.Tuple()
    arrow = traitlets.Tuple()
    tool = traitlets.Enum(TOOLS, "")
    parallel = traitlets.Bool(False)
    subject: Any
    section: Section
    _orbit: Orbit
    _toolbar: Toolbar
    _clicks: ipywidgets.CallbackDispatcher

    @property
    def at_rest(self) -> SurfaceMesh:
        """The part to which the places of clicks belong."""
        return self.subject.mesh

    @property
    def towards_eye(self) -> Floats:
        """Unit vector from the part to the eye."""
        return self._orbit.seen.axes[2]

    def fit(self, view: str = "") -> None:
        """Bring the whole part into view."""
        raise NotImplementedError

    def _measure(self, change: object = None) -> None:
        """Bring the scale up to date."""
        raise NotImplementedError

    def on_click(self, call: Callable[[Point], None]) -> None:
        """Call back with the position [mm] of every click that does not measure, repeated clicks included."""
        self._clicks.register_callback(call)

    def key(self, name: str, *, shift: bool = False, ctrl: bool = False) -> None:
        """What a key does in a view.

        Arrows turn it, with Shift they move it, + and - come nearer and go farther, Home shows the whole part, Enter is a click in the
        middle, Page Up and Down move the cut; A keeps places, M measures, X cuts, O looks in parallel, L shows the next layer, Escape
        leaves the last of them.
        """
        step = FINE if ctrl else COARSE
        across, up = ARROWS.get(name, (0, 0))
        if name == "Home":
            self.fit()
        elif name in NEARER:
            self._orbit.near(NEARER[name])
        elif shift and name in SHIFTED:
            self.fit(SHIFTED[name])
        elif (across, up) != (0, 0):
            self._orbit.move(across, up) if shift else self._orbit.turn(across * step, up * step)
        elif name in PAGES and self.section.on:
            self.section.move(PAGES[name])
        elif name == "Enter":  # a click in the middle
            self._look(-self._orbit.seen.axes[2])
        else:
            self._press(name)
        self._measure()

    def fly(self, place: Point) -> None:
        """Look at a place of the part at rest [mm] from close by, and tell what is known of it."""
        self._fly_to(int(np.linalg.norm(self.at_rest.vertices - np.asarray(place), axis=1).argmin()))

    def look_round(self, vertex: int) -> None:
        """Look at the whole part from a side from which a vertex is seen, and tell what is known of it."""
        mesh = self.subject.mesh
        self._orbit.look_from(probe.seen_from(mesh, vertex))
        self._orbit.near(ROOM)
        self._orbit.move(0, 1)
        self.probed = vertex
        self._measure()

    def cut_open(self, *, on: bool = True) -> None:
        """Cut the part open towards the eye, or close it."""
        if on and not self.section.on:
            seen = self._orbit.seen
            self.section.open_towards(seen.eye - np.asarray(seen.target))
        elif not on:
            self.section.on = False

    def _fly_to(self, vertex: int) -> None:
        mesh = self.subject.mesh
        self._orbit.look_at(mesh.vertices[vertex], probe.seen_from(mesh, vertex))
        self.probed = vertex
        self._measure()

    def _press(self, key: str) -> None:
        if key in PICKS:
            self.tool = "" if self.tool == PICKS[key] else PICKS[key]
        elif key == "o":
            self.parallel = not self.parallel
        elif key == "x":
            self.cut_open(on=not self.section.on)
        elif key == "l":
            names = [STYLE, *(layer.name for layer in self.subject.layers)]
            self.layer = names[(names.index(self.layer) + 1) % len(names)]
        elif key == "Escape" and self.tool:
            self.tool = ""
        elif key == "Escape" and self.measured:
            self.measured = ()
        elif key == "Escape":
            self.section.on = False

    @traitlets.validate("probed", "places")
    def _known(self, proposal: dict[str, Any]) -> Any:
        given, count = proposal["value"], len(self.subject.mesh.vertices)
        for vertex in given if isinstance(given, tuple) else () if given is None else (given,):
            if not 0 <= vertex < count:
                raise BadInput(f"there is no vertex {vertex}: the part has {count}, counted from 0")
        return given[-MOST_PINS:] if isinstance(given, tuple) else given

    @traitlets.observe("parallel")
    def _project(self, _change: object) -> None:
        self._orbit.project(parallel=self.parallel)
        self._measure()

    @traitlets.observe("tool")
    def _begin_anew(self, _change: object) -> None:
        if self.tool == "measure":
            self.measured = ()

    def _remove(self, number: int | None) -> None:
        """Take a place from the list, counted from 0, or all."""
        self.places = () if number is None else (*self.places[:number], *self.places[number + 1 :])
        if not self.places:
            self._toolbar.rest()  # the list had the focus, and keys would go to the page

    def _pick(self, point: tuple[float, float, float], face: int) -> None:
        """A click on the part, as if nothing were cut off."""
        where = np.add(point, self._orbit.home.target)
        if self.section.keeps(where):
            self._point(where, face)
        else:
            self._look(where - self._orbit.seen.eye)

    def _look(self, towards: Floats) -> None:
        """Point at what one sees in a direction."""
        eye, mesh = self._orbit.seen.eye, self.subject.mesh
        met = probe.struck(mesh, eye, towards, self.section.keeps)
        if met is None:
            return
        where, face = met
        if self.section.filled and float(mesh.face_normals[face] @ towards) > 0.0:  # seen from within: it is the cut that is met
            *normal, reach = self.section.plane
            where = eye + towards * (reach - eye @ np.asarray(normal)) / (towards @ np.asarray(normal))
        self._point(where, face)

    def _point(self, where: Floats, face: int) -> None:
        """A click on a place [mm] of a face."""
        if self.tool == "measure":
            kept = self.measured if len(self.measured) == 1 else ()
            self.measured = (*kept, tuple(where.tolist()))
            return
        mesh = self.subject.mesh
        corners, weigh = mesh.faces[face], trimesh.triangles.points_to_barycentric
        self.probed = int(corners[np.linalg.norm(mesh.vertices[corners] - where, axis=1).argmin()])
        if self.tool == "places" and self.probed not in self.places:
            self.places = (*self.places, self.probed)
        weights = weigh(mesh.corners[[face]], np.atleast_2d(where))  # type: ignore[no-untyped-call]
        self._clicks(tuple((weights[0] @ self.at_rest.corners[face]).tolist()))  # the same place on the part at rest
