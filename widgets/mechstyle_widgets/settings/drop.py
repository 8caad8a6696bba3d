"""Drop test settings: drop, loads, criterion; how fine the part is, on what device and in which folder it runs."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import ipywidgets
import traitlets

from mechstyle.errors import BadInput
from mechstyle.records import CRITERIA, POSES
from mechstyle.records.landings import STANDARDS, landings_after, with_drops
from mechstyle.records.load_cases import load_cases
from mechstyle.records.mesh import STANDARD_VERTICES
from mechstyle.records.recipe import DEFAULTS, LIMITS
from mechstyle.records.written import length_of, tolerance_of, written
from mechstyle.runs.recipes import EXPECTED
from mechstyle_widgets.jupyter.language import word
from mechstyle_widgets.jupyter.looks import lean, show, unheard
from mechstyle_widgets.settings.section import CHECK, WIDE, Read, Section, control, linked, setting

DEVICES = ("auto", "cpu", "cuda")
SIZES = {"Try it": 4000, "Print it": STANDARD_VERTICES}
"""How fine a run is, in words, and in vertices."""
RULES = {"robust": "what stays bent", "paper": "published rule"}
"""Criteria, in words."""
ONCE = "once"
"""The way to land that is a single drop."""
WAYS = {
    ONCE: ("as it stands", "one drop, as the part stands"),
    "fibonacci": ("any way up", "{} drops: as the part stands, then turned every way, evenly spread"),
    "resting": ("at rest", "up to {} drops: as the part stands, then on what it would come to rest on, the likeliest first"),
    "box26": ("on faces, edges, corners", "up to {} drops: as the part stands, then on each face, edge and corner of the box around it"),
    "box10": (
        "on a corner, its edges, faces",
        "up to {} drops: as the part stands, then on a corner of the box around it, on its edges, and on the faces",
    ),
    "faces6": ("on each face", "up to {} drops: as the part stands, then on each face of the box around it"),
}
"""Ways to land, a single drop or one of `POSES`: what they are called, and what is dropped so many times."""


NEAR = 0.02
"""Share by which a standardised surface may have more or fewer vertices than were asked for."""


def size_near(count: int) -> int | None:
    """The one of SIZES that a number of vertices is, None for one that is of neither."""
    return next((size for size in SIZES.values() if abs(count - size) <= NEAR * size), None)


class Length(traitlets.Float[float, Any]):
    """A length [mm] between the limits of a setting, which may be set as people write it."""

    def __init__(self, name: str, read: Callable[[str], float], write: Callable[[float], str]) -> None:
        """Of a setting; `read` raises BadInput for text that is no such length, `write` says one as `read` takes it."""
        self.read, self.write, (low, high) = read, write, LIMITS[name]
        super().__init__(DEFAULTS[name], min=low, max=high)

    def validate(self, obj: Any, value: Any) -> Any:
        """The length in millimetres; BadInput for text that is none."""
        return super().validate(obj, self.read(value) if isinstance(value, str) else value)


class DropOptions(Section):
    """Drop test, loads and criterion; resolution, device and folder are set in Python alone.

    Attributes:
        height: Height of fall [mm]; text with a unit, such as "1.5 m", may be set, too.
        tolerance: The most that may stay bent [mm]; likewise.
        orientations: Drops in the final test, the first as placed.
        poses: How the others land, one of `POSES`; of no account with one drop.
        standard: Drop standard whose orientations and height are simulated, a key of `STANDARDS`, or "". Choosing one by hand brings them.
        nearly_flat: Whether landings tilted by 3° onto the corners and sides of what the part stands on are judged, too.
        loads: Load cases the part must carry besides the drop, as records; a load file or a list of records may be set.
        criterion: What the part is judged by, `robust` or `paper`.
        guarantee: Whether the finished relief is corrected until the part passes.
        minimum_wall: The thinnest wall the style may leave [mm], 0 for no rule.
        strengthen: How much a plain part that does not hold is first thickened, at most [mm], 0 to leave it as it is.
        vertices: Of the standardised surface.
        device: `auto`, `cpu` or `cuda`.
        folder: Run directory, "" for one named by prompt and recipe.
    """

    OWN = ("vertices", "device", "folder")

    height: Any = Length("height", length_of, written)
    tolerance: Any = Length("tolerance", tolerance_of, "{:g} mm".format)
    orientations = setting("orientations")
    poses = setting("poses")
    standard = setting("standard")
    nearly_flat = setting("nearly_flat")
    loads = Read(load_cases, ())
    criterion = setting("criterion")
    guarantee = setting("guarantee")
    minimum_wall = setting("minimum_wall")
    strengthen = setting("strengthen")
    vertices = traitlets.Int(SIZES["Try it"], min=1)
    device = traitlets.Enum(DEVICES, "auto")
    folder = traitlets.Unicode("")

    def __init__(self, **traits: Any) -> None:
        """Offer them; `traits` are any of the attributes."""
        ways = [(name, way) for way, (name, _) in WAYS.items()]
        standards = [("none", ""), *((standard.title, name) for name, standard in STANDARDS.items())]
        what = "From how high it falls, such as 1.5 m or 80 cm"
        self._lengths = {"height": control(ipywidgets.Text, "fall", continuous_update=False, tooltip=what)}
        what = "What may stay bent after a fall or a load, such as 0.2 mm or 200 µm"
        self._lengths["tolerance"] = control(ipywidgets.Text, "may be off by", continuous_update=False, tooltip=what)
        self._way = control(ipywidgets.Dropdown, "it lands", options=ways, tooltip="How the part meets the floor")
        what = "Drops of the final test, the first as the part stands"
        self._drops = linked(self, "orientations", ipywidgets.BoundedIntText, "drops", tooltip=what)
        what = "A drop standard: its landings and height"
        self._standard = control(ipywidgets.Dropdown, "drop standard", options=standards, tooltip=what)
        self._file = control(
            ipywidgets.Text, "it carries",
            placeholder="a load file.toml", continuous_update=False, layout={"flex": "1 1 auto", "width": "0"},
            tooltip="A file of load cases: where the part is held, what pulls or presses on it",
        )  # fmt: skip
        self._unload = lean(ipywidgets.Button, icon="times", tooltip="Nothing to carry but the drop", layout={"width": "32px"})
        nearly = "Landings tilted by 3° onto its corners and sides are judged, too"
        most = "The most that is added before the style where the part does not hold as it is; 0 leaves it as it is"
        thinnest = "The thinnest wall the style may leave"
        super().__init__([
            *self._lengths.values(), self._way, self._drops, self._standard, lean(ipywidgets.HBox, [self._file, self._unload], layout=WIDE),
            linked(self, "nearly_flat", ipywidgets.Checkbox, "nearly flat", tooltip=nearly, **CHECK),
            linked(self, "criterion", ipywidgets.Dropdown, "criterion", options=[(RULES[name], name) for name in CRITERIA]),
            linked(self, "guarantee", ipywidgets.Checkbox, "correct until it passes", **CHECK),
            linked(self, "minimum_wall", ipywidgets.BoundedFloatText, "thinnest [mm]", step=0.1, tooltip=thinnest),
            linked(self, "strengthen", ipywidgets.BoundedFloatText, "thicken [mm]", step=0.5, tooltip=most),
        ])  # fmt: skip
        for name, value in traits.items():
            setattr(self, name, value)
        words = ["Coarse, to see what comes of it", "Fine, as it is printed"]
        looks = {"button_width": "auto"}
        self.sizes = lean(ipywidgets.ToggleButtons, options=list(SIZES.items()), value=None, tooltips=words, style=looks)
        self.sizes.add_class("mechstyle-sizes")
        self.sizes.observe(self._choose_size, "value")
        traitlets.dlink((self, "vertices"), (self.sizes, "value"), size_near)
        self._way.observe(self._choose_way, "value")
        self._standard.observe(self._choose_standard, "value")
        for name, box in self._lengths.items():
            box.observe(partial(self._written, name), "value")
        self._file.observe(self._carry, "value")
        self._unload.on_click(lambda _: self._carry({"new": ""}))
        self._tell()

    @property
    def brief(self) -> str:
        """Height and landings."""
        return f"{written(self.height)}, {word(WAYS[self.way][0])}"

    @property
    def way(self) -> str:
        """Landing orientations, a key of WAYS."""
        return ONCE if self.orientations == 1 else self.poses

    @property
    def settings(self) -> dict[str, Any]:
        """The chosen settings, by the names of the recipe's fields; the height as it is written, so that a small one is not asked about."""
        return {**super().settings, "height": written(self.height)}

    @traitlets.observe("orientations", "poses", "standard", "height", "tolerance", "nearly_flat", "loads", "strengthen", "criterion")
    def _tell(self, _change: object = None) -> None:
        """Bring the controls up to date, and say what will be tested."""
        self._way.value, self._standard.value = self.way, self.standard
        show(self._drops, self.way != ONCE)
        show(self._unload, self.loads)
        self._write()
        drops, carried = WAYS[self.way][1].format(self.orientations), "; ".join(case.name for case in self.loads)
        after = landings_after(self.standard, poses=self.poses, orientations=self.orientations, height=self.height)
        said = (
            drops,
            "Nearly flat as well, tilted by 3° onto the corners and sides of what it stands on" if self.nearly_flat else "",
            f"{after[:1].upper()}{after[1:]}",
            f"Besides, it must carry: {carried}" if carried else "",
            f"Where it does not hold as it is, it is thickened by up to {self.strengthen:g} mm before the style" if self.strengthen else "",
        )
        self.note(". ".join(filter(None, said)), (EXPECTED,) if self.criterion == "paper" else ())

    def _write(self) -> None:
        """Show the lengths as people write them."""
        for name, box in self._lengths.items():
            box.value = self.traits()[name].write(getattr(self, name))

    def _written(self, name: str, change: dict[str, Any]) -> None:
        """Take the length that was written; what cannot be used is said and leaves the last one."""
        trait = self.traits()[name]
        try:
            setattr(self, name, change["new"])
        except BadInput as error:
            self.complain(str(error))
        except traitlets.TraitError:
            what, how = {"height": ("a fall", "simulated"), "tolerance": ("a tolerance", "used")}[name]
            low, high = trait.write(trait.min), trait.write(trait.max)
            self.complain(f"{what} of {change['new']} cannot be {how}: write one between {low} and {high}")
        else:
            self.complain("")
            self._write()

    def _choose_size(self, change: dict[str, Any]) -> None:
        """Another size brings its number of vertices."""
        if change["new"] is not None and change["new"] != size_near(self.vertices):
            self.vertices = change["new"]

    def _choose_way(self, change: dict[str, Any]) -> None:
        """Another way brings its usual number of drops."""
        way = change["new"]
        if way == ONCE:
            self.orientations = 1
        elif way != self.way:
            with self.hold_trait_notifications():
                self.poses, self.orientations = way, POSES[way]

    def _choose_standard(self, change: dict[str, Any]) -> None:
        """A standard brings its landings and height; none leaves them as they are."""
        if change["new"] != self.standard:
            with self.hold_trait_notifications():
                for name, value in with_drops({"standard": change["new"]}).items():
                    setattr(self, name, value)

    @traitlets.observe("loads")
    def _name(self, _change: object, file: str = "") -> None:
        """Show the name of the file of the loads; those that came another way have none."""
        with unheard(self._file, self._carry):
            self._file.value = file

    def _carry(self, change: dict[str, Any]) -> None:
        """Take the load cases of a file, or none; what cannot be used is said and leaves the others."""
        file = change["new"].strip()
        try:
            self.loads = file or ()
        except BadInput as error:
            self.complain(str(error))
        else:
            self.complain("")
            self._name(None, file)
