"""The style in words: a prompt, a picture of each style to choose from, and how the prompt was read."""

from __future__ import annotations

from typing import Any

import ipywidgets
import traitlets

from mechstyle.errors import BadInput
from mechstyle.runs.images import digest_of
from mechstyle.styling.library import library
from mechstyle.styling.picture import NAME as PICTURE
from mechstyle.styling.prompt import Reading, read, suggestions
from mechstyle.styling.vocabulary import called
from mechstyle_widgets.jupyter.frame import unseen
from mechstyle_widgets.jupyter.looks import lean
from mechstyle_widgets.settings.group import Fold
from mechstyle_widgets.settings.image import ImageChoice
from mechstyle_widgets.settings.millimetres import AUTO, Millimetres
from mechstyle_widgets.settings.section import NARROW_LABEL, WIDE, Section, range_of, setting
from mechstyle_widgets.settings.thumbnail_buttons import FEW, PictureChoice

GROUPS = {
    "stone, clay and metal": (
        "brick", "stone", "concrete", "marble", "terracotta", "cracked_earth", "crystal", "realistic", "weathered", "hammered",
        "brushed_metal", "damascus", "tiles", "terrazzo", "herringbone", "shingles", "chainmail", "diamond_plate",
    ),
    "cloth and leather": (
        "knit", "cable_knit", "crochet", "basket_weave", "twill", "quilting", "leather", "studs", "stripes", "tartan", "pleats", "fuzzy",
        "paper",
    ),
    "plants and animals": (
        "wood", "bark", "bamboo", "cactus", "floral", "green", "moss", "cork", "feathers", "fur", "dragon_scales", "fish_scales",
        "honeycomb",
        "leopard", "zebra", "giraffe", "camouflage",
    ),
    "technical": (
        "carbon_fibre", "circuit", "grid", "grip", "isogrid", "knurling", "low_poly", "topographic", "voronoi", "panels", "spikes",
        "spiral", "fluted",
    ),
    "ornaments": ("art_deco", "celtic_knot", "girih", "greek_key", "mandala", "waves", "dots", "bubbles", "ice", "glass", "lava"),
}  # fmt: skip
"""Styles by what they remind of."""
DEPTHS = tuple(round(0.1 * step, 1) for step in range(31))
SIZES = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 15.0, 20.0, 25.0, 30.0, 40.0)
"""Depths and sizes of features that the sliders offer [mm]."""


class PromptBox(Section):
    """A prompt and the styles it may name.

    Attributes:
        prompt: The style, in words.
        reading: How it was read, None if it could not be.
        relief: Depth of the relief [mm], None for what can be seen and the walls bear.
        side: Where it goes from the surface.
        feature: Size of the style's feature [mm], None for what fits the part.
        nozzle: Diameter of the printer's nozzle [mm], for which features are made large enough; 0 for no rule.
        inside: What becomes of a container's inside.
        amplitude: Half the depth over wall thickness instead; a run that was opened may have it.
        seed: Decides everything random in the style.
        guidance: What the style descends to: `offline`, a drawn target, or `clip`, what CLIP takes for the prompt.
        field: What is descended in: `vertex`, values per vertex, or `network`, the X-Mesh style field.
        image: Digest of the pixels of a picture as the style, "" for none; a file, its bytes or an array may be set. With `image_size`
            [mm], `image_as`, `image_layout` and `projection` as in a recipe.
    """

    prompt = traitlets.Unicode("")
    reading = traitlets.Instance(Reading, None, allow_none=True)
    relief = setting("relief")
    side = setting("side")
    feature = setting("feature")
    nozzle = setting("nozzle")
    inside = setting("inside")
    amplitude = setting("amplitude")
    seed = setting("seed")
    guidance = setting("guidance")
    field = setting("field")
    image: Any = traitlets.Any("")
    image_size = setting("image_size")
    image_as = setting("image_as")
    image_layout = setting("image_layout")
    projection = setting("projection")

    def __init__(self, prompt: str = "brick", **traits: Any) -> None:
        """Offer the styles; `prompt` is asked for at first, `traits` are any other attributes."""
        tooltip = "The style, in words; one for each place: `outside: brick; rim: gold studs`"
        self._text = unseen(lean(ipywidgets.Text, description="style", placeholder="small blue stones", tooltip=tooltip, layout=WIDE))
        styles = library()
        asked_by = {name: " ".join(called(name)) for name in styles}
        self._chips = PictureChoice("style", {name: style.description for name, style in styles.items()}, GROUPS, asked_by)
        look = {"style": NARROW_LABEL, "layout": WIDE}
        deep = "Depth of the relief, from its lowest to its highest"
        self._relief = lean(Millimetres, DEPTHS, description="depth", tooltip=deep, **look)
        large = "Size of the style's feature, such as a course of bricks"
        self._feature = lean(Millimetres, SIZES, description="size", tooltip=large, **look)
        sides = [("as the walls allow", "auto"), ("outwards", "outwards"), ("inwards", "inwards"), ("both ways", "both")]
        where = "Where the relief goes from the surface; by itself outwards on thin walls, else both ways"
        self._side = lean(ipywidgets.Dropdown, options=sides, description="goes", tooltip=where, **look)
        fine = "Diameter of the printer's nozzle: features that are not given are made for it; 0 for no rule"
        self._nozzle = lean(ipywidgets.BoundedFloatText, description="nozzle [mm]", step=0.1, tooltip=fine, **range_of("nozzle"), **look)
        insides = [("plain", "plain"), ("styled as well", "styled")]
        hollow = "The inside of a cup, a tray, a case"
        self._inside = lean(ipywidgets.Dropdown, options=insides, description="inside", tooltip=hollow, **look)
        differently = "Another number draws the same style a little differently"
        self._seed = lean(ipywidgets.BoundedIntText, description="variation", tooltip=differently, **range_of("seed"), **look)
        guides = [("a drawn target, offline", "offline"), ("CLIP, any prompt", "clip")]
        needs = "CLIP needs its weights on disk"
        self._guidance = lean(ipywidgets.Dropdown, options=guides, description="style from", tooltip=needs, **look)
        carriers = [("a value at each point", "vertex"), ("a network (X-Mesh)", "network")]
        self._field = lean(ipywidgets.Dropdown, options=carriers, description="shape from", tooltip="What is optimised", **look)
        self._image = ImageChoice()
        rest = [self._side, self._nozzle, self._inside, self._seed, self._guidance, self._field]
        self._more = Fold("more of the style", rest)
        super().__init__([self._text, self._chips, self._image, self._relief, self._feature, self._more])
        self.children = (self._text, self._note, self._trouble, *self.children[1:-2])  # an answer stands where one has asked
        self._chips.observe(self._choose, "pressed")
        for name in ImageChoice.FIELDS:
            traitlets.link((self._image, name), (self, name))
        self._image.observe(lambda _change: self.complain(self._image.trouble), "trouble")
        traitlets.link((self, "prompt"), (self._text, "value"))
        self.prompt = prompt
        for name, value in traits.items():
            setattr(self, name, value)
        traitlets.link((self, "relief"), (self._relief, "length"))
        traitlets.link((self, "feature"), (self._feature, "length"))
        self.observe(self._tell_lengths, ("reading", "amplitude"))
        self._tell_lengths()
        pairs = {"side": self._side, "nozzle": self._nozzle}
        pairs |= {"inside": self._inside, "seed": self._seed, "guidance": self._guidance, "field": self._field}
        for name, widget in pairs.items():
            traitlets.link((self, name), (widget, "value"))

    @property
    def brief(self) -> str:
        """The prompt."""
        return self.prompt

    def _choose(self, _change: object) -> None:
        """A picture was pressed: put the name of its style in the place of the one the prompt names."""
        name = self._chips.value.replace("_", " ")
        old = _first_style(self.reading).replace("_", " ")
        self.prompt = self.prompt.replace(old, name, 1) if old and old in self.prompt else name

    @traitlets.validate("image")
    def _known(self, proposal: dict[str, Any]) -> str:
        return digest_of(proposal["value"])

    @traitlets.observe("image")
    def _speak_of_it(self, _change: object) -> None:
        """The prompt is to name the picture while there is one."""
        try:
            if self.prompt.strip():
                read(self.prompt, picture=bool(self.image))
        except BadInput:
            self.prompt = PICTURE if self.image else "brick"

    @traitlets.observe("prompt", "guidance", "image")
    def _read(self, _change: object) -> None:
        drawn, words = self.guidance == "offline", self.prompt.strip()
        try:
            self.reading = read(self.prompt, picture=bool(self.image)) if words or self.image else None
        except BadInput as error:
            self.reading = None
            self.complain(_refusal(words, str(error)) if drawn else "")
            self.note("" if drawn else "CLIP reads the whole prompt")
            self._chips.nearest = list(suggestions(words, FEW)) if drawn else []
        else:
            self.complain("" if self.reading else "Write what it should look like, or choose a style.")
            self.note("" if self.reading is None else "; ".join([f"read as {self.reading.words}", *self.reading.notes]))
            self._chips.nearest = []
        self._chips.value = _first_style(self.reading)

    def _tell_lengths(self, _change: object = None) -> None:
        """The sliders say what the prompt or a share of the wall decides while nothing is chosen."""
        wishes = () if self.reading is None else self.reading.wishes
        deep, large = (next((length for wish in wishes if (length := getattr(wish, name))), None) for name in ("relief", "feature"))
        share = AUTO if self.amplitude is None else f"{self.amplitude:g} of wall"
        self._relief.auto = share if deep is None else f"{deep:g} mm, as written"
        self._feature.auto = AUTO if large is None else f"{large:g} mm, as written"


def _refusal(prompt: str, error: str) -> str:
    """Why a prompt cannot be used, in a sentence that leads on to the pictures of the nearest styles."""
    if "names no style that can be drawn" in error:
        return f"“{prompt}” names no style. Near it are these, or take a picture of your own:"
    return error.split("; `mechstyle styles`", maxsplit=1)[0]


def _first_style(reading: Reading | None) -> str:
    """The first style a prompt names, "" if it could not be read."""
    return "" if reading is None else next(wish.style for wish in reading.wishes if wish.style)
