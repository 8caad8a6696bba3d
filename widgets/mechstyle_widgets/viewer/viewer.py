"""A part in three dimensions: turn it, see its style or a field on it, ask what is known of a place.

All of pythreejs stays behind `Viewer`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import replace
from html import escape
from typing import Any

import ipywidgets
import numpy as np
import pythreejs
import traitlets
from numpy.typing import NDArray

from mechstyle.errors import BadInput, unknown
from mechstyle.pictures.camera import VIEWS
from mechstyle.pictures.figure import Panel
from mechstyle.pictures.panels import Picture, picture
from mechstyle.records.mesh import SurfaceMesh
from mechstyle_widgets.jupyter.cell_output import OncePerCell
from mechstyle_widgets.jupyter.frame import Framed
from mechstyle_widgets.jupyter.language import said
from mechstyle_widgets.jupyter.looks import close_family, lean, sharing, show
from mechstyle_widgets.jupyter.one_thread import hear_on_one_thread
from mechstyle_widgets.jupyter.throttle import Paced
from mechstyle_widgets.state.troubles import sentence
from mechstyle_widgets.viewer import legend, probe
from mechstyle_widgets.viewer.badge import Badge, untested
from mechstyle_widgets.viewer.camera import Orbit
from mechstyle_widgets.viewer.layers import STYLE, Layer, Subject
from mechstyle_widgets.viewer.places import Places
from mechstyle_widgets.viewer.scene import BACKGROUNDS, Scene, floor_cell
from mechstyle_widgets.viewer.section import Section
from mechstyle_widgets.viewer.toolbar import Toolbar
from mechstyle_widgets.viewer.tools import Tools

BANDS = 9
"""Colours of a field that is shown in steps: each spans five MPa of a strength of 45."""
DRAWN = ("subject", "original", "third", "layer", "markers", "probed", "places", "measured", "arrow", "tool", "beside", "names", "outcomes",
         "protected", "stepped")  # fmt: skip
"""Traits that change what is drawn."""


class Viewer(Tools, Framed, OncePerCell, ipywidgets.VBox):  # type: ignore[misc]  # ipywidgets has no types
    """A part one can orbit with the mouse, coloured by its style or by a field over it.

    Drag turns it, the right button moves it, the wheel comes nearer, a click asks what is known of the place; `Tools` has the rest.

    Attributes:
        subject: The part and its fields; may be replaced by one with the same faces.
        original: What may be shown beside it, None for nothing.
        third: What stands beside those two, None for nothing.
        beside: Whether the original is shown beside it, moving along with the mouse.
        names: What they are called where they stand side by side.
        outcomes: HTML of the verdict on each of them, which may be "".
        stepped: Whether a field is shown in BANDS colours instead of many.
        markers: Whether the greatest (ring) and the least value (triangle) are marked.
        protected: Whether the style must leave each vertex as it is, which is hatched, shape [vertex_count]; None for nothing.
        theme: `light` or `dark`.
        badge: What is said over the view.
        drawings: How many times it was drawn.
    """

    subject = traitlets.Instance(Subject)
    original = traitlets.Instance(Subject, None, allow_none=True)
    third = traitlets.Instance(Subject, None, allow_none=True)
    beside = traitlets.Bool(False)
    names = traitlets.Tuple(default_value=("styled", "plain"))
    outcomes = traitlets.Tuple()
    stepped = traitlets.Bool(False)
    markers = traitlets.Bool(True)
    protected = traitlets.Instance(np.ndarray, None, allow_none=True)
    theme = traitlets.Enum(tuple(BACKGROUNDS), "light")
    drawings = traitlets.Int(0)
    _built = False  # `close()` also runs, from `__del__`, on a viewer whose `__init__` raised

    @sharing()
    def __init__(
        self,
        mesh: SurfaceMesh,
        layers: Sequence[Layer] = (),
        *,
        original: Subject | None = None,
        theme: str = "light",
        width: int = 640,
        height: int = 440,
    ) -> None:
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
        self._scenes = [Scene(mesh, centre, theme)]
        self._picker = probe.Picker(self._scenes[0].part, self._orbit.three, self._pick)
        self._views = [self._renderer(self._scenes[0], [*self._orbit.controls, self._picker.three])]
        self._stage = lean(ipywidgets.HBox, self._views)
        self.badge, self._titles = Badge(), lean(ipywidgets.HTML, layout={"display": "none"})
        self._said = lean(ipywidgets.HTML)
        self._said.add_class("mechstyle-said")
        self._legend, self._scale, self._table = lean(ipywidgets.HTML), lean(ipywidgets.HTML), lean(ipywidgets.HTML)
        over = lean(ipywidgets.VBox, [self._said, self._legend])
        self._legend.add_class("mechstyle-legend")
        over.add_class("mechstyle-over")
        self._scale.add_class("mechstyle-scale")
        seen = lean(ipywidgets.VBox, [self._stage, over, self._scale])
        seen.add_class("mechstyle-seen")
        window = lean(ipywidgets.VBox, [self.badge, self._titles, seen])
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
        self._refresh = Paced(self._draw, lambda error: setattr(self._said, "value", alert(escape(said(sentence(error))))))
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
        return picture(self._panels(), title=title)

    def _panels(self) -> list[Panel]:
        shown, seen, made = self._shown, self._orbit.seen, []
        for subject, layer, title in zip(shown, self._layers, self.names if len(shown) > 1 else ("",), strict=False):
            if layer is None:
                made.append(Panel(self.section.applied(subject.mesh)[0], title, view=seen))
                continue
            mesh, values = self.section.applied(subject.mesh, layer.values)
            how = (layer.unit, layer.label, layer.limits, layer.threshold, seen, layer.note, layer.judged, layer.most)
            made.append(Panel(mesh, title, values, *how))
        return made

    def still(self, title: str = "") -> Callable[[], bytes]:
        """What draws the view as it is now."""
        panels = self._panels()
        return lambda: picture(panels, title=title).png

    def close(self) -> None:
        """Close the view and every widget it is made of; nothing stays behind in the kernel."""
        if self._built:
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
            scene.three.background = BACKGROUNDS[change["new"]]

    # what is drawn

    def _draw(self) -> None:
        layers, bands = self._layers, BANDS if self.stepped else 0
        layer = layers[0]
        self._orbit.follow(self.subject.mesh)
        self._arrange()
        with ExitStack() as views:  # nothing is drawn until all that changes has changed
            for view in self._views:
                views.enter_context(view.hold())
            for scene, subject, painted in zip(self._scenes, self._shown, layers, strict=False):
                scene.move(subject.mesh)
                scene.paint(painted, subject.mesh)
                scene.band(bands)
                scene.cut(self.section.plane, filled=self.section.filled)
                field, drawn = subject.layer(self.layer) if self.markers else None, self.measured or self.arrow
                extremes = None if field is None else field.extremes()
                scene.mark(extremes, self.probed, self.places, drawn, arrow=not self.measured)
            self._scenes[0].hatch(self.protected)
        mesh = self.subject.mesh
        key = "" if self.protected is None else legend.protected(self.protected, mesh)
        self._legend.value = (legend.colour_bar(layer, mesh, bands, brief=len(self._shown) > 1) if layer else "") + key
        self._table.value = "" if self.probed is None else probe.table(self.subject, self.probed)
        at = "" if self.probed is None else probe.brief(self.subject, self.probed, self.layer)
        self._said.value = legend.said(self.tool, self.measured) or at
        self._list.show(self.subject, self.places)
        self._measure()
        self.drawings += 1

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
        ends, widest = [(scale.low, scale.high) for scale in scales], (max, min) if scales[0].lower_is_worse else (min, max)
        limits, limit = (widest[0](low for low, _ in ends), widest[1](high for _, high in ends)), scales[0].threshold
        judged = max((layer.judged for layer in layers if layer is not None and layer.judged is not None), default=None)
        return [None if layer is None else replace(layer, limits=limits, threshold=limit, judged=judged) for layer in layers]

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
        return pythreejs.Renderer(
            camera=self._orbit.three, scene=scene.three, controls=controls, width=width, height=height, antialias=True
        )

    def _cut(self, _change: object) -> None:
        for scene in self._scenes:
            scene.cut(self.section.plane, filled=self.section.filled)


class PartViewer(Viewer):
    """The part, to which the places of clicks belong whatever style is shown on it."""

    def __init__(self, mesh: SurfaceMesh, **look: Any) -> None:
        """Show a plain part; `look` as for `Viewer`."""
        self._rest = mesh
        super().__init__(mesh, **look)

    @property
    def at_rest(self) -> SurfaceMesh:
        """The plain part."""
        return self._rest

    def put_on(self, styled: SurfaceMesh, more: str) -> None:
        """Show a style on it that was not tested; `more` is said below that."""
        self.subject, self.original = Subject(styled), Subject(self._rest)
        self.badge.say(untested("Preview", more))

    def wait(self) -> None:
        """Say that a style is being drawn, unless another is on show until then."""
        if self.original is None:
            self.badge.say(untested("Preview", "The style is being drawn on the part …"))

    def take_off(self, why: str = "") -> None:
        """Show the plain part, and say why if there is a reason."""
        self.subject, self.original = Subject(self._rest), None
        self.badge.say(untested("No preview", why) if why else "")
