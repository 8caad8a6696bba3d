"""A part in three dimensions: turn it, see its style or a field on it, ask what is known of a place.

All of pythreejs stays behind `Viewer`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import replace
from html import escape
from typing import TYPE_CHECKING, Any, NamedTuple

import ipywidgets
import numpy as np
import pythreejs
import traitlets
import trimesh
from numpy.typing import NDArray

from mechstyle.errors import BadInput, unknown
from mechstyle.pictures.camera import VIEWS
from mechstyle.pictures.panels import Picture, picture
from mechstyle.records.mesh import Floats, SurfaceMesh
from mechstyle.records.regions import Point
from mechstyle_widgets.jupyter.cell_output import OncePerCell
from mechstyle_widgets.jupyter.frame import Framed
from mechstyle_widgets.jupyter.language import said
from mechstyle_widgets.jupyter.looks import close_family, lean, sharing, show
from mechstyle_widgets.jupyter.one_thread import hear_on_one_thread
from mechstyle_widgets.jupyter.throttle import Throttled
from mechstyle_widgets.state.troubles import sentence
from mechstyle_widgets.viewer import legend, probe
from mechstyle_widgets.viewer.badge import Badge, untested
from mechstyle_widgets.viewer.camera import Orbit
from mechstyle_widgets.viewer.layers import STYLE, Layer, Subject
from mechstyle_widgets.viewer.places import Places
from mechstyle_widgets.viewer.scene import BACKGROUNDS, Scene, floor_cell
from mechstyle_widgets.viewer.section import Section
from mechstyle_widgets.viewer.shaders import MOST_PINS
from mechstyle_widgets.viewer.toolbar import TOOLS, Toolbar

if TYPE_CHECKING:
    from mechstyle.pictures.figure import Panel

BANDS = 9
"""Colours of a field that is shown in steps: each spans five MPa of a strength of 45."""
DRAWN = ("subject", "original", "third", "layer", "markers", "probed", "places", "measured", "arrow", "tool", "beside", "names", "outcomes",
         "protected", "stepped")  # fmt: skip
"""Traits that change what is drawn."""
COARSE, FINE = 15.0, 1.0
"""How far an arrow key turns the part, and with Ctrl [degrees]."""
ARROWS = {"ArrowLeft": (-1, 0), "ArrowRight": (1, 0), "ArrowUp": (0, 1), "ArrowDown": (0, -1)}
NEARER = {"+": 1.25, "=": 1.25, "-": 0.8}
PAGES = {"PageUp": 1, "PageDown": -1}
SHIFTED = {"1": "front", "2": "side", "3": "top", "4": "below", "5": "three_quarter"}
"""Standard views by the digits that, with Shift, call them."""
ROOM = 0.85
"""How near the camera comes to a part it looks at as a whole, so that the legend below hides nothing of it."""
STALE = "mechstyle-stale"
"""Class of a view whose picture is of a style that is not asked for any more."""
PICKS = {"m": "measure", "a": "places"}


class _Look(NamedTuple):
    """All that one view shows: a subject with its field and the scale of that, and what is marked, cut off and hatched."""

    subject: Subject
    scale: tuple[Any, ...] | None
    bands: int
    cut: tuple[Any, bool]
    marks: tuple[Any, ...]
    protected: NDArray[np.bool_] | None


def _alike(one: _Look, other: _Look) -> bool:
    """Whether two looks draw the same; arrays and subjects are the same where they are one object."""
    return one.subject is other.subject and one.protected is other.protected and one[1:-1] == other[1:-1]


class Viewer(Framed, OncePerCell, ipywidgets.VBox):  # type: ignore[misc]  # ipywidgets has no types
    """A part one can orbit with the mouse, coloured by its style or by a field over it.

    Drag turns it, the right button moves it, the wheel comes nearer, a click asks what is known of the place; `key` tells what keys do.

    Attributes:
        subject: The part and its fields; may be replaced by one with the same faces.
        original: What may be shown beside it, None for nothing.
        third: What stands beside those two, None for nothing.
        beside: Whether the original is shown beside it, moving along with the mouse.
        names: What they are called where they stand side by side.
        outcomes: HTML of the verdict on each of them, which may be "".
        captions: What a picture says of each of them: what it is and whether it holds.
        stepped: Whether a field is shown in BANDS colours instead of many.
        markers: Whether the greatest (ring) and the least value (triangle) are marked.
        protected: Whether the style must leave each vertex as it is, which is hatched, shape [vertex_count]; None for nothing.
        theme: `light` or `dark`.
        badge: What is said over the view.
        layer: Name of what is shown.
        probed: The vertex asked about, None for none.
        places: Vertices that are kept in the list, in order, at most MOST_PINS.
        measured: Ends of what is measured [mm], two at most.
        arrow: Foot and tip of an arrow on the part [mm], nothing for none.
        tool: What a click does besides asking: "", `measure` or `places`.
        parallel: Whether one looks in parallel instead of in perspective.
        section: Where the part is cut open: `section.on`, `section.axis`, `section.at` [mm].
        drawings: How many times it was drawn.
    """

    subject = traitlets.Instance(Subject)
    original = traitlets.Instance(Subject, None, allow_none=True)
    third = traitlets.Instance(Subject, None, allow_none=True)
    beside = traitlets.Bool(False)
    names = traitlets.Tuple(default_value=("styled", "plain"))
    outcomes = traitlets.Tuple()
    captions = traitlets.Tuple()
    stepped = traitlets.Bool(False)
    markers = traitlets.Bool(True)
    protected = traitlets.Instance(np.ndarray, None, allow_none=True)
    theme = traitlets.Enum(tuple(BACKGROUNDS), "light")
    layer = traitlets.Unicode(STYLE)
    probed = traitlets.Int(None, allow_none=True)
    places = traitlets.Tuple()
    measured = traitlets.Tuple()
    arrow = traitlets.Tuple()
    tool = traitlets.Enum(TOOLS, "")
    parallel = traitlets.Bool(False)
    drawings = traitlets.Int(0)
    _built = False  # `close()` also runs, from `__del__`, on a viewer whose `__init__` raised

    @sharing()
    def __init__(
        self, mesh: SurfaceMesh, layers: Sequence[Layer] = (), *,
        original: Subject | None = None, theme: str = "light", width: int = 640, height: int = 440,
    ) -> None:  # fmt: skip
        """Show a part [mm] with fields over its surface, the first in front, so large [pixels].

        `original`, with the same faces, may be shown beside it.

        Raises:
            BadInput: If a layer does not fit the part, or the original has other faces.
        """
        subject = Subject(mesh, tuple(layers))
        self._first, self._faces, self._size = mesh, mesh.faces, (width, height)
        self._clicks = ipywidgets.CallbackDispatcher()
        if original is not None:
            self._check_faces(original)
        if theme not in BACKGROUNDS:
            raise unknown("theme", theme, BACKGROUNDS)
        self._orbit = Orbit(mesh, width / height)
        centre = self._orbit.home.target
        self._scenes, self._looks = [Scene(mesh, centre, theme)], list[_Look]()
        self._picker = probe.Picker(self._scenes[0].part, self._orbit.three, self._pick)
        self._views = [self._renderer(self._scenes[0], [*self._orbit.controls, self._picker.three])]
        self._stage = lean(ipywidgets.HBox, self._views)
        self.badge, self._titles = Badge(), lean(ipywidgets.HTML, layout={"display": "none"})
        self._said = lean(ipywidgets.HTML)
        self._said.add_class("mechstyle-said")
        self._legend, self._scale, self._table = lean(ipywidgets.HTML), lean(ipywidgets.HTML), lean(ipywidgets.HTML)
        self._legend.add_class("mechstyle-legend")
        self._scale.add_class("mechstyle-scale")
        seen, self._under = lean(ipywidgets.VBox, [self._stage]), lean(ipywidgets.HBox, [self._legend, self._said, self._scale])
        seen.add_class("mechstyle-seen")
        self._under.add_class("mechstyle-under")
        window = lean(ipywidgets.VBox, [self.badge, self._titles, seen, self._under])
        window.add_class("mechstyle-stage")
        self.section = Section(mesh.vertices.min(axis=0), mesh.vertices.max(axis=0))
        self._toolbar = Toolbar(self.fit, self.picture)
        self._list = Places(lambda number: self._fly_to(self.places[number]), self._remove)
        self._foot = lean(ipywidgets.VBox, [self._table])
        super().__init__([self._toolbar, self.section, window, self._foot, self._list])
        self.add_class("mechstyle-viewer")
        self.subject, self.original, self.theme = subject, original, theme
        # an error is said until drawing does not fail; the event loop would keep it to itself
        alert = '<span role="alert">{}</span>'.format
        self._refresh = Throttled(self._draw, lambda error: setattr(self._said, "value", alert(escape(said(sentence(error))))))
        self.layer = layers[0].name if layers else STYLE
        hear_on_one_thread()
        for name in ("layer", "beside", "markers", "stepped", "parallel", "tool"):
            traitlets.link((self, name), (self._toolbar, name))
        traitlets.dlink((self.section, "on"), (self._toolbar, "cut"))
        self._toolbar.observe(lambda change: self.cut_open(on=change["new"]), "cut")
        self.section.observe(self._cut, ("on", "axis", "at", "flipped", "filled"))
        self._orbit.three.observe(self._measure, "position")  # the mouse has let go of the camera
        self.observe(lambda _: self._refresh(), DRAWN)
        self._built = True
        self._draw()

    def __repr__(self) -> str:
        """Layer and subject; never the arrays."""
        return f"Viewer({self.subject.mesh!r}, layer={self.layer!r})"

    # what can be done with it

    def put(self, layer: Layer) -> None:
        """Add a layer, or put it in the place of the one of its name."""
        self.subject = self.subject.with_layer(layer)

    def fit(self, view: str = "") -> None:
        """Bring the whole part into view, from `three_quarter`, `front`, `side`, `top`, `below`, or from where one looks now."""
        if view and view not in VIEWS:
            raise unknown("view", view, VIEWS)
        self._orbit.fit(view)
        self._measure()

    def resize(self, width: int, height: int) -> None:
        """Take another width and height [pixels]."""
        if (width, height) != self._size:
            self._size = width, height
            self._share_width()
            self._measure()

    def look_from(self, other: Viewer) -> None:
        """Look from where another view looks."""
        self._orbit.look_like(other._orbit)
        self.parallel = self._orbit.parallel
        self._measure()

    def lend_table(self) -> ipywidgets.HTML:
        """The table of the place asked about, to be shown elsewhere than under the view, where it would push down what follows."""
        self._foot.children = ()
        return self._table

    def picture(self, title: str = "") -> Picture:
        """The view, cut open as it is, without the hatching of protected regions, rendered in the kernel: `.save(path)` writes the PNG."""
        return picture(self._panels(), title=self._heading or title)

    @property
    def _heading(self) -> str:
        """Caption of what stands there alone; of several each has its own."""
        return self.captions[0] if self.captions and len(self._shown) == 1 else ""

    def _panels(self) -> list[Panel]:
        from mechstyle.pictures.figure import Panel  # noqa: PLC0415 — matplotlib is loaded when a picture is wanted

        shown, seen, made = self._shown, self._orbit.seen, []
        titles = (self.captions or self.names) if len(shown) > 1 else ("",)
        for subject, layer, title in zip(shown, self._layers, titles, strict=False):
            if layer is None:
                made.append(Panel(self.section.applied(subject.mesh)[0], title, view=seen))
                continue
            mesh, values = self.section.applied(subject.mesh, layer.values)
            how = (layer.unit, layer.label, layer.limits, layer.threshold, seen, layer.note, layer.edge)
            peak = layer.peak if mesh is subject.mesh else None  # a cut part has other vertices
            made.append(Panel(mesh, title, values, *how, said=layer.said, peak=peak))
        return made

    def still(self) -> Callable[[], bytes]:
        """What draws the view as it is now."""
        panels, title = self._panels(), self._heading
        return lambda: picture(panels, title=title).png

    @property
    def undeformed(self) -> SurfaceMesh:
        """The part to which the places of clicks belong."""
        return self.subject.mesh

    @property
    def towards_eye(self) -> Floats:
        """Unit vector from the part to the eye."""
        return self._orbit.seen.axes[2]

    def close(self) -> None:
        """Close the view and every widget it is made of; nothing stays behind in the kernel."""
        if self._built:
            self.unobserve_all()  # or what it still hears of would be drawn, with renderers made anew that nobody closes
            self._refresh.cancel()
            self._list.close()
            close_family(self, self._table, *self._views)
        super().close()

    # traits

    @traitlets.validate("subject", "original", "third")
    def _same_faces(self, proposal: dict[str, Any]) -> Subject | None:
        if proposal["value"] is not None:
            self._check_faces(proposal["value"])
        return proposal["value"]

    def _check_faces(self, subject: Subject) -> None:
        if not np.array_equal(subject.mesh.faces, self._faces):
            raise BadInput("a viewer follows one part as it moves, but the new mesh has other faces: make another Viewer for it")

    @traitlets.validate("layer")
    def _known_layer(self, proposal: dict[str, Any]) -> str:
        names = [STYLE, *(layer.name for layer in self.subject.layers)]
        if proposal["value"] not in names:
            raise unknown("layer", proposal["value"], names)
        return proposal["value"]

    @traitlets.validate("protected")
    def _one_for_each(self, proposal: dict[str, Any]) -> NDArray[np.bool_] | None:
        given, count = proposal["value"], len(self.subject.mesh.vertices)
        if given is not None and given.shape != (count,):
            raise BadInput(f"what is protected has shape {given.shape}, but the part has {count} vertices: give one value for each")
        return None if given is None else given.astype(bool)

    @traitlets.observe("subject")
    def _offer_layers(self, _change: object) -> None:
        """Keep the layer if there still is one of its name."""
        shown = self.layer if self.subject.layer(self.layer) else STYLE
        self._toolbar.offer(self.subject.layers, shown)
        self.layer = shown

    @traitlets.observe("original")
    def _offer_original(self, _change: object) -> None:
        self._toolbar.offer_beside(self.names[1].split(",")[0], there=self.original is not None)
        self.beside = self.beside and self.original is not None

    @traitlets.observe("theme")
    def _relight(self, change: dict[str, Any]) -> None:
        for scene in self._scenes:
            scene.light(change["new"])

    # what is drawn

    def _draw(self) -> None:
        layers, bands = self._layers, BANDS if self.stepped else 0
        layer = layers[0]
        self._orbit.follow(self.subject.mesh)
        self._arrange()
        looks = [self._look_of(number, subject, layer) for number, (subject, layer) in enumerate(zip(self._shown, layers, strict=True))]
        changed = [number for number, look in enumerate(looks) if number >= len(self._looks) or not _alike(look, self._looks[number])]
        self._looks = looks
        with ExitStack() as views:  # nothing is drawn until all that changes has changed, and what does not change is not drawn again
            for number in changed:
                views.enter_context(self._views[number].hold())
                self._show_in(self._scenes[number], looks[number], layers[number])
        mesh = self.subject.mesh
        key = "" if self.protected is None else legend.protected(self.protected, mesh)
        self._legend.value = (legend.colour_bar(layer, mesh, bands, brief=len(self._shown) > 1) if layer else "") + key
        self._table.value = "" if self.probed is None else probe.table(self.subject, self.probed)
        at = "" if self.probed is None else probe.brief(self.subject, self.probed, self.layer)
        self._said.value = legend.said(self.tool, self.measured) or at
        self._list.show(self.subject, self.places)
        self._measure()
        self.drawings += 1

    def _look_of(self, number: int, subject: Subject, layer: Layer | None) -> _Look:
        """All that a view shows of a subject."""
        field, cut = subject.layer(self.layer) if self.markers else None, self.section
        marks = (None if field is None else field.extremes(), self.probed, self.places, self.measured or self.arrow, not self.measured)
        scale = None if layer is None else (layer.name, layer.limits, layer.threshold)
        return _Look(subject, scale, BANDS if self.stepped else 0, (cut.plane, cut.filled), marks, None if number else self.protected)

    @staticmethod
    def _show_in(scene: Scene, look: _Look, layer: Layer | None) -> None:
        scene.move(look.subject.mesh)
        scene.paint(layer)
        scene.band(look.bands)
        scene.cut(look.cut[0], filled=look.cut[1])
        *marks, arrow = look.marks
        scene.mark(*marks, arrow=arrow)
        scene.hatch(look.protected)

    @property
    def _shown(self) -> list[Subject]:
        return [self.subject, *(one for one in (self.original, self.third) if self.beside and one is not None)]

    @property
    def _layers(self) -> list[Layer | None]:
        """The layer on show of each that stands there, in colours that mean the same: the widest range, the limit of the first."""
        layers = [subject.layer(self.layer) for subject in self._shown]
        scales = [layer.scale for layer in layers if layer is not None]
        if len(scales) < 2:
            return layers
        limits, limit = (min(scale.low for scale in scales), max(scale.high for scale in scales)), scales[0].threshold
        return [None if layer is None else replace(layer, limits=limits, threshold=limit) for layer in layers]

    def _arrange(self) -> None:
        """Lay out one view, or two or three that share the width and the camera."""
        shown = self._shown
        self._titles.value = legend.titles(self.names, self.outcomes)
        self._toolbar.offer_beside(self.names[1].split(",")[0], there=self.original is not None)
        for _ in shown[len(self._views) :]:
            self._scenes.append(Scene(self._first, self._orbit.home.target, self.theme))
            self._views.append(self._renderer(self._scenes[-1], [self._orbit.share()]))
        views = tuple(self._views[: len(shown)])
        if self._stage.children != views:
            self._stage.children = views
            self._share_width()
            show(self._titles, len(views) > 1)

    def _share_width(self) -> None:
        (width, height), shown = self._size, self._stage.children
        for view in shown:
            with view.hold_sync():
                view.width, view.height = width // len(shown), height
        self._orbit.resize(width / len(shown) / height)

    def _measure(self, _change: object = None) -> None:
        self._scale.value = legend.scale_bar(self._orbit.pixels_per_mm(self._size[1]), floor_cell(self.subject.mesh))

    def _renderer(self, scene: Scene, controls: list[Any]) -> Any:
        width, height = self._size
        look = {"width": width, "height": height, "antialias": True}
        return pythreejs.Renderer(camera=self._orbit.three, scene=scene.three, controls=controls, **look)

    def _cut(self, _change: object) -> None:
        for scene in self._scenes:
            scene.cut(self.section.plane, filled=self.section.filled)

    # what mouse and keys do besides turning it

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
        """Look at a place of the undeformed part [mm] from close by, and tell what is known of it."""
        self._fly_to(int(np.linalg.norm(self.undeformed.vertices - np.asarray(place), axis=1).argmin()))

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
        self._clicks(tuple((weights[0] @ self.undeformed.corners[face]).tolist()))  # the same place on the undeformed part


class PartViewer(Viewer):
    """The part, to which the places of clicks belong whatever style is shown on it."""

    def __init__(self, mesh: SurfaceMesh, **look: Any) -> None:
        """Show a plain part; `look` as for `Viewer`."""
        self._rest = mesh
        super().__init__(mesh, **look)

    @property
    def undeformed(self) -> SurfaceMesh:
        """The plain part."""
        return self._rest

    def put_on(self, styled: SurfaceMesh, more: str) -> None:
        """Show a style on it that was not tested; `more` is said below that."""
        self.subject, self.original = Subject(styled), Subject(self._rest)
        self._said_of("Preview", more)

    def wait(self) -> None:
        """Say that a style is being drawn; what is on show until then is that of before, and dimmed."""
        self._said_of("Preview", "The style is being drawn on the part …")
        self.add_class(STALE)

    def take_off(self, why: str = "") -> None:
        """Show the plain part, and say why if there is a reason."""
        self.subject, self.original = Subject(self._rest), None
        self._said_of("No preview", why)

    def _said_of(self, name: str, more: str) -> None:
        self.remove_class(STALE)
        self.badge.say(untested(name, more) if more else "")
