"""The toolbar of a view: what is shown, where from, and the tools; each button has a name that a screen reader tells, and most a key."""

from __future__ import annotations

import base64
from collections.abc import Callable, Sequence
from typing import Any

import ipywidgets
import traitlets

from mechstyle.pictures.camera import VIEWS
from mechstyle.pictures.panels import Picture
from mechstyle_widgets.jupyter.frame import unseen
from mechstyle_widgets.jupyter.language import said, word
from mechstyle_widgets.jupyter.looks import lean, show, unheard
from mechstyle_widgets.viewer.layers import STYLE, Layer

SELDOM, MORE = ("demand", "displacement", "added", "thickness", "contact", "stress_"), "\n"
"""How the names of layers begin that are offered with all others alone, and what stands for these."""
TOOLS = ("", "measure", "places")
"""What a click does besides asking about a place: nothing, measure, or keep the place."""


class Toolbar(ipywidgets.HBox):  # type: ignore[misc]  # ipywidgets has no types
    """Menus and buttons above the view; each trait of the view that has its name is what it sets."""

    layer = traitlets.Unicode(STYLE)
    beside = traitlets.Bool(False)
    stepped = traitlets.Bool(False)
    markers = traitlets.Bool(True)
    parallel = traitlets.Bool(False)
    cut = traitlets.Bool(False)
    tool = traitlets.Enum(TOOLS, "")

    def __init__(self, fit: Callable[[str], None], picture: Callable[[], Picture]) -> None:
        """`fit` is called with a view, or "" for all of the part from where one looks; `picture` makes one to save."""
        self.choice = unseen(lean(
            ipywidgets.Dropdown,
            options=[("style", STYLE)], description="layer", tooltip="What is shown on the part (1 to 6, L for the next)",
            layout={"width": "auto", "min_width": "108px"},
        ))  # fmt: skip
        views = [("seen from", ""), *((view.replace("_", " "), view) for view in VIEWS)]
        self._view = unseen(lean(
            ipywidgets.Dropdown, options=views, description="seen from", tooltip="Where from (Shift with 1 to 5)",
            layout={"width": "124px"},
        ))  # fmt: skip
        self._fit = _button("arrows-alt", "Bring the whole part into view (Home)")
        self.both = _toggle("columns", "Show the plain part beside it", "plain")
        show(self.both, False)
        self._marks = _toggle("dot-circle-o", "Mark the greatest and the least value: dashed where it is on the far side")
        self._stepped = _toggle("bars", "Show values in steps, or smoothly")
        self._parallel = _toggle("cube", "Look in parallel, without perspective (O)")
        self._cut = _toggle("scissors", "Cut the part open along a plane (X)")
        self._tools = {
            "measure": _toggle("arrows-h", "Measure between two clicks, or Enter at the cross (M)"),
            "places": _toggle("map-marker", "Keep the places one clicks on in a list (A)"),
        }
        self._shot = _button("camera", "Make a picture of this to save")
        self._download = lean(ipywidgets.HTML)
        seldom = lean(ipywidgets.HBox, [self._marks, self._stepped, self._parallel, self._tools["places"]])
        self._more = more = _toggle("ellipsis-h", "Marks, steps, parallel look, kept places")
        more.observe(lambda change: show(seldom, change["new"]), "value")
        show(seldom, False)
        first = [self.choice, self._view, self._fit, self.both, self._cut, self._tools["measure"], self._shot, more, seldom, self._download]
        super().__init__(first)
        self.layout.flex_flow = "row wrap"
        self.add_class("mechstyle-toolbar")
        self._picture = picture
        self._layers: Sequence[Layer] = ()
        self._all = False
        self.choice.observe(self._choose, "value")
        self.observe(lambda change: self.offer(self._layers, change["new"]), "layer")
        linked = {"beside": self.both, "markers": self._marks, "stepped": self._stepped}
        linked |= {"parallel": self._parallel, "cut": self._cut}
        for name, widget in linked.items():
            traitlets.link((self, name), (widget, "value"))
        self._view.observe(self._look, "value")
        self._turn = fit
        self._fit.on_click(lambda _: fit(""))
        self._shot.on_click(self._offer_picture)
        for name, button in self._tools.items():
            button.observe(lambda change, name=name: self._take(name, taken=change["new"]), "value")

    def offer(self, layers: Sequence[Layer], shown: str) -> None:
        """Offer the style and these layers, with one of them shown."""
        self._layers, wide = layers, self._all or shown.startswith(SELDOM)
        offered = [layer for layer in layers if wide or not layer.name.startswith(SELDOM)]
        options = [(word("style"), STYLE), *((said(layer.title), layer.name) for layer in offered)]
        options += [(word("more layers …"), MORE)] if len(offered) < len(layers) else []
        if tuple(self.choice.options) != tuple(options):
            with unheard(self.choice, self._choose):  # other options put it to the first
                self.choice.options = options
        self.choice.value = shown

    def _choose(self, change: dict[str, Any]) -> None:
        """Show the layer that was chosen, or offer all of them."""
        if change["new"] == MORE:
            self._all = True
            self.offer(self._layers, self.layer)
        elif change["new"] is not None:
            self.layer = change["new"]

    def _look(self, change: dict[str, Any]) -> None:
        """Look from there; the menu goes back to its name, as the mouse may turn the part away and one may want that view again."""
        if change["new"]:
            self._turn(change["new"])
            self._view.value = ""

    def offer_beside(self, name: str, *, there: bool) -> None:
        """Offer what may stand beside, by its name, if it is there."""
        show(self.both, there)
        self.both.description = word(name)

    def rest(self) -> None:
        """Take the focus, with what is always in sight."""
        self._more.focus()

    def _take(self, name: str, *, taken: bool) -> None:
        if taken or self.tool == name:
            self.tool = name if taken else ""

    @traitlets.observe("tool")
    def _press(self, _change: Any = None) -> None:
        for name, button in self._tools.items():
            button.value = self.tool == name

    def _offer_picture(self, _button: object) -> None:
        data = base64.b64encode(self._picture().png).decode("ascii")
        name = f"mechstyle-{self.layer}.png"
        words = word("save {}").format(name)
        self._download.value = f'<a download="{name}" href="data:image/png;base64,{data}" style="font-size:12px">{words}</a>'


def _button(icon: str, tooltip: str) -> ipywidgets.Button:
    return lean(ipywidgets.Button, icon=icon, tooltip=tooltip, layout={"width": "36px"})


def _toggle(icon: str, tooltip: str, description: str = "") -> ipywidgets.ToggleButton:
    layout = {"width": "auto" if description else "36px"}
    made = lean(ipywidgets.ToggleButton, description=description, icon=icon, tooltip=tooltip, layout=layout)
    if description:
        made.add_class("mechstyle-worded")
    return made
