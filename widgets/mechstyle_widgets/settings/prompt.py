"""The style in words: a prompt, a picture of each style to choose from, and how the prompt was read."""

from __future__ import annotations

from collections.abc import Callable
from html import escape
from typing import Any

import ipywidgets
import traitlets

from mechstyle.errors import BadInput, MechStyleError
from mechstyle.runs.images import digest_of, thumbnail
from mechstyle.styling.library import library
from mechstyle.styling.picture import NAME as PICTURE
from mechstyle.styling.prompt import Reading, read, suggestions
from mechstyle.styling.vocabulary import called
from mechstyle_widgets.jupyter.frame import unseen
from mechstyle_widgets.jupyter.language import word
from mechstyle_widgets.jupyter.looks import lean, show
from mechstyle_widgets.settings.section import AUTO, WIDE, Fold, Millimetres, Read, Section, Words, linked, setting
from mechstyle_widgets.settings.thumbnail_buttons import FEW, PictureChoice
from mechstyle_widgets.state.preview import Enlarged

GROUPS = {
    "stone, clay and metal": (
        "brick", "stone", "concrete", "marble", "terracotta", "cracked_earth", "crystal", "realistic", "weathered", "hammered",
        "brushed_metal", "damascus", "tiles", "terrazzo", "herringbone", "shingles", "chainmail", "diamond_plate",
        "corrugated", "half_timbered", "kintsugi",
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
        "spiral", "fluted", "checkers", "cones",
    ),
    "ornaments": ("art_deco", "celtic_knot", "girih", "greek_key", "mandala", "waves", "dots", "bubbles", "ice", "glass", "lava"),
}  # fmt: skip
"""Styles by what they remind of."""
DEPTHS = tuple(round(0.1 * step, 1) for step in range(31))
SIZES = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 15.0, 20.0, 25.0, 30.0, 40.0)
"""Depths and sizes of features that the sliders offer [mm]."""


WIDTHS = (5.0, 8.0, 10.0, 12.0, 15.0, 20.0, 25.0, 30.0, 40.0, 50.0, 60.0, 80.0, 100.0, 150.0, 200.0)
"""Widths of a picture that the slider offers [mm]."""


class ImageChoice(ipywidgets.VBox):  # type: ignore[misc]  # ipywidgets has no types
    """A button for a picture and, once there is one, how it is to lie on the part: traits as in a recipe.

    `image` is a digest of pixels, "" for none; a file, its bytes or an array may be set. `trouble` says why a file could not be taken.
    """

    FIELDS = ("image", "image_size", "image_as", "image_layout", "projection")

    image: Any = Read(digest_of, "")
    image_size = setting("image_size")
    image_as = setting("image_as")
    image_layout = setting("image_layout")
    projection = setting("projection")
    trouble: Any = traitlets.Unicode("")

    def __init__(self) -> None:
        """Offer to choose a file."""
        what = "A PNG or JPEG file: light stands out, dark is cut in, what is transparent stays plain"
        kinds, own = ".png,.jpg,.jpeg", {"width": "auto"}
        self._upload = lean(ipywidgets.FileUpload, accept=kinds, description="your picture", tooltip=what, layout=own)
        self._remove = lean(ipywidgets.Button, description="without it", tooltip="Go on without the picture", layout=WIDE)
        self._shown = lean(ipywidgets.Image, width=56, layout={"border": "1px solid var(--jp-border-color2, #ccc)"})
        what = "Width of the picture, or of one of its tiles"
        self._size = linked(self, "image_size", Millimetres, "wide", lengths=WIDTHS, tooltip=what)
        uses = [("relief and colours", "both"), ("relief", "height"), ("colours", "colour")]
        use = linked(self, "image_as", ipywidgets.Dropdown, "gives", options=uses, tooltip="What is taken of the picture")
        layouts = [("repeated", "tiled"), ("once a side", "placed")]
        layout = linked(self, "image_layout", ipywidgets.Dropdown, "is", options=layouts, tooltip="How often it is laid out")
        ways = [("from six sides", "box"), ("from one side", "planar"), ("around the part", "around")]
        what = "A prompt such as `front: picture` names it"
        self._way = linked(self, "projection", ipywidgets.Dropdown, "lies", options=ways, tooltip=what)
        self._details = lean(ipywidgets.VBox, [self._size, use, layout, self._way])
        super().__init__([lean(ipywidgets.HBox, [self._shown, lean(ipywidgets.VBox, [self._upload, self._remove])]), self._details])
        self._upload.observe(self._take, "value")
        self._remove.on_click(lambda _button: setattr(self, "image", ""))
        self._show(None)

    def _take(self, _change: object) -> None:
        chosen = self._upload.value
        if not chosen:
            return
        try:
            self.image = bytes(chosen[0]["content"])
        except MechStyleError as error:
            self.trouble = str(error).replace("the picture", chosen[0]["name"], 1)
        else:
            self.trouble = ""
        self._upload.value = ()

    @traitlets.observe("image")
    def _show(self, _change: object) -> None:
        for widget in (self._shown, self._remove, self._details):
            show(widget, self.image)
        self._shown.value = thumbnail(self.image) if self.image else b""


class PromptBox(Section):
    """A prompt and the styles it may name.

    Attributes:
        prompt: The style, in words.
        reading: How it was read, None if it could not be.
        relief: Depth of the relief [mm], None for what can be seen and the walls allow.
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
    image: Any = Read(digest_of, "")
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
        what = "Depth of the relief, from its lowest to its highest"
        self._relief = linked(self, "relief", Millimetres, "depth", lengths=DEPTHS, tooltip=what)
        what = "Size of the style's feature, such as a course of bricks"
        self._feature = linked(self, "feature", Millimetres, "size", lengths=SIZES, tooltip=what)
        sides = [("as the walls allow", "auto"), ("outwards", "outwards"), ("inwards", "inwards"), ("both ways", "both")]
        where = "Where the relief goes from the surface; by itself outwards on thin walls, else both ways"
        fine = "Diameter of the printer's nozzle: features that are not given are made for it; 0 for no rule"
        insides = [("plain", "plain"), ("styled as well", "styled")]
        hollow, differently = "The inside of a cup, a tray, a case", "Another number draws the same style a little differently"
        guides = [("a drawn target, offline", "offline"), ("CLIP, any prompt", "clip")]
        needs = "CLIP needs its weights on disk"
        carriers = [("a value at each point", "vertex"), ("a network (X-Mesh)", "network")]
        self._image = ImageChoice()
        more = Fold("more of the style", lean(ipywidgets.VBox, [
            linked(self, "side", ipywidgets.Dropdown, "goes", options=sides, tooltip=where),
            linked(self, "nozzle", ipywidgets.BoundedFloatText, "nozzle [mm]", step=0.1, tooltip=fine),
            linked(self, "inside", ipywidgets.Dropdown, "inside", options=insides, tooltip=hollow),
            linked(self, "seed", ipywidgets.BoundedIntText, "variation", tooltip=differently),
            linked(self, "guidance", ipywidgets.Dropdown, "style from", options=guides, tooltip=needs),
            linked(self, "field", ipywidgets.Dropdown, "shape from", options=carriers, tooltip="What is optimised"),
        ]))  # fmt: skip
        super().__init__([self._text, self._chips, self._image, self._relief, self._feature, more])
        self._coarse = lean(Words)
        self._finer = lean(
            ipywidgets.Button, description="Finer", tooltip="As many vertices as the pattern takes", layout={"width": "auto"}
        )
        self._cure = lean(ipywidgets.HBox, [self._coarse, self._finer])
        self._cure.add_class("mechstyle-cure")
        self.enlarge(None)
        # an answer stands where one has asked
        self.children = (self._text, self._note, self._trouble, self._cure, *self.children[1:-2])
        self._chips.observe(self._choose, "pressed")
        for name in ImageChoice.FIELDS:
            traitlets.link((self._image, name), (self, name))
        self._image.observe(lambda _change: self.complain(self._image.trouble), "trouble")
        traitlets.link((self, "prompt"), (self._text, "value"))
        self.prompt = prompt
        for name, value in traits.items():
            setattr(self, name, value)
        self.observe(self._tell_lengths, ("reading", "amplitude"))
        self._tell_lengths()

    @property
    def brief(self) -> str:
        """The prompt."""
        return self.prompt

    def focus(self) -> None:
        """Let what is typed next be the prompt."""
        self._text.focus()

    def enlarge(self, found: Enlarged | None, finer: Callable[[int], object] = lambda _: None) -> None:
        """Say what of the pattern is drawn larger than asked, and offer as many vertices as would carry it; None for nothing."""
        self._finer.on_click(self._ask_finer, remove=True)
        show(self._cure, found is not None)
        if found is not None:
            self._ask_finer = lambda _button: finer(found.vertices)
            self._finer.on_click(self._ask_finer)
            what = word(f"{found.what} of {{}}").rsplit(" ", 2)[0]  # the table has them with their size
            said = word("{} are drawn {} × larger than asked: the mesh is too coarse.").format(what, f"{found.times:.1f}")
            self._coarse.say(f'<div class="mechstyle-warning" role="status">{escape(said[:1].upper() + said[1:])}</div>')

    _ask_finer: Callable[[Any], object] = staticmethod(lambda _button: None)

    def _choose(self, _change: object) -> None:
        """A picture was pressed: put the name of its style in the place of the one the prompt names."""
        name = self._chips.value.replace("_", " ")
        old = _first_style(self.reading).replace("_", " ")
        self.prompt = self.prompt.replace(old, name, 1) if old and old in self.prompt else name

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
            if "names no style that can be drawn" in str(error):  # the sentence leads on to the pictures of the nearest styles
                why = f"“{words}” names no style. Near it are these, or take a picture of your own:"
            else:
                why = str(error).split("; `mechstyle styles`", maxsplit=1)[0]
            self.complain(why if drawn else "")
            self.note("" if drawn else "CLIP reads the whole prompt")
            self._chips.nearest = list(suggestions(words, FEW)) if drawn else []
        else:
            self.complain("")  # an empty box waits; what cannot be begun without a style says so
            ask = "Write what it should look like, or choose a style."
            self.note(ask if self.reading is None else "; ".join([f"read as {self.reading.words}", *self.reading.notes]))
            self._chips.nearest = []
        self._chips.value = _first_style(self.reading)

    def _tell_lengths(self, _change: object = None) -> None:
        """The sliders say what the prompt or a share of the wall decides while nothing is chosen."""
        wishes = () if self.reading is None else self.reading.wishes
        deep, large = (next((length for wish in wishes if (length := getattr(wish, name))), None) for name in ("relief", "feature"))
        share = AUTO if self.amplitude is None else f"{self.amplitude:g} of wall"
        self._relief.auto = share if deep is None else f"{deep:g} mm, as written"
        self._feature.auto = AUTO if large is None else f"{large:g} mm, as written"


def _first_style(reading: Reading | None) -> str:
    """The first style a prompt names, "" if it could not be read."""
    return "" if reading is None else next(wish.style for wish in reading.wishes if wish.style)
