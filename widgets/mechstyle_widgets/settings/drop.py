"""Drop test settings: drop, loads, criterion, resolution, device, folder."""

from __future__ import annotations

from typing import Any

import ipywidgets
import traitlets

from mechstyle.errors import BadInput
from mechstyle.records import CRITERIA, POSES
from mechstyle.records.landings import STANDARDS, landings_after, with_drops
from mechstyle.records.load_cases import LoadCase, load_cases
from mechstyle.records.mesh import STANDARD_VERTICES
from mechstyle.records.recipe import DEFAULTS, LIMITS
from mechstyle.records.written import length_of, written
from mechstyle.runs.recipes import EXPECTED
from mechstyle_widgets.jupyter.language import word
from mechstyle_widgets.jupyter.looks import lean, show
from mechstyle_widgets.settings.section import NARROW_LABEL, WIDE, Section, range_of, setting

DEVICES = ("auto", "cpu", "cuda")
SIZES = {"Try it": 4000, "Print it": STANDARD_VERTICES}
"""How fine a run is, in words, and in vertices."""
RULES = {"robust": "what it survives", "paper": "published rule"}
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


class Height(traitlets.Float[float, Any]):
    """A height of fall [mm], which may be set as people write it."""

    def validate(self, obj: Any, value: Any) -> Any:
        """The height in millimetres; BadInput for text that is none."""
        return super().validate(obj, length_of(value) if isinstance(value, str) else value)


class DropOptions(Section):
    """Drop test, loads, criterion, resolution, device and folder.

    Attributes:
        height: Height of fall [mm]; text with a unit, such as "1.5 m", may be set, too.
        orientations: Drops in the final test, the first as placed.
        poses: How the others land, one of `POSES`; of no account with one drop.
        standard: Drop standard whose orientations and height are simulated, a key of `STANDARDS`, or "". Choosing one by hand brings them.
        nearly_flat: Whether landings tilted by 3° onto the corners and sides of what the part stands on are judged, too.
        loads: Load cases the part must carry besides the drop, as records; a load file or a list of records may be set.
        criterion: What the part is judged by, `robust` or `paper`.
        guarantee: Whether the finished relief is corrected until the part passes.
        minimum_wall: The thinnest wall the style may leave [mm], 0 for no rule.
        strengthen: The most that a part that does not hold as it is may be thickened by before its style [mm], 0 to leave it as it is.
        vertices: Of the standardised surface.
        device: `auto`, `cpu` or `cuda`.
        folder: Run directory, "" for one named by prompt and recipe.
    """

    OWN = ("vertices", "device", "folder")

    height: Any = Height(DEFAULTS["height"], min=LIMITS["height"][0], max=LIMITS["height"][1])
    orientations = setting("orientations")
    poses = setting("poses")
    standard = setting("standard")
    nearly_flat = setting("nearly_flat")
    loads = traitlets.Any(())
    criterion = setting("criterion")
    guarantee = setting("guarantee")
    minimum_wall = setting("minimum_wall")
    strengthen = setting("strengthen")
    vertices = traitlets.Int(SIZES["Try it"], min=1)
    device = traitlets.Enum(DEVICES, "auto")
    folder = traitlets.Unicode("")

    def __init__(self, **traits: Any) -> None:
        """Offer them; `traits` are any of the attributes."""
        look = {"style": NARROW_LABEL, "layout": WIDE}
        controls = {
            "orientations": lean(
                ipywidgets.BoundedIntText,
                description="drops", tooltip="Drops of the final test, the first as the part stands", **range_of("orientations"), **look
            ),
            "nearly_flat": lean(
                ipywidgets.Checkbox,
                description="nearly flat", tooltip="Landings tilted by 3° onto its corners and sides are judged, too", indent=False,
                layout=WIDE,
            ),
            "criterion": lean(ipywidgets.Dropdown, options=[(RULES[name], name) for name in CRITERIA], description="criterion", **look),
            "guarantee": lean(ipywidgets.Checkbox, description="correct until it passes", indent=False, layout=WIDE),
            "minimum_wall": lean(
                ipywidgets.BoundedFloatText,
                description="thinnest [mm]", step=0.1, tooltip="The thinnest wall the style may leave", **range_of("minimum_wall"), **look
            ),
            "strengthen": lean(
                ipywidgets.BoundedFloatText,
                description="thicken [mm]", step=0.5,
                tooltip="The most that is added before the style where the part does not hold as it is; 0 leaves it as it is",
                **range_of("strengthen"), **look,
            ),
            "vertices": lean(ipywidgets.BoundedIntText, description="detail", min=1, max=400_000, step=1000, **look),
            "device": lean(ipywidgets.Dropdown, options=DEVICES, description="device", **look),
            "folder": lean(
                ipywidgets.Text,
                description="folder", placeholder="mechstyle-runs/…", continuous_update=False, tooltip="Where the run is kept", **look
            ),
        }
        ways = [(name, way) for way, (name, _) in WAYS.items()]
        self._way = lean(ipywidgets.Dropdown, options=ways, description="it lands", tooltip="How the part meets the floor", **look)
        known = [("none", ""), *((standard.title, name) for name, standard in STANDARDS.items())]
        after = "A drop standard: its landings and height"
        self._standard = lean(ipywidgets.Dropdown, options=known, description="drop standard", tooltip=after, **look)
        self._drops = controls["orientations"]
        self._height = lean(
            ipywidgets.Text, description="fall", continuous_update=False, tooltip="From how high it falls, such as 1.5 m or 80 cm", **look
        )
        others = tuple(controls.values())
        super().__init__([self._height, self._way, *others[:1], self._standard, self._loads_row(), *others[1:]])
        for name, value in traits.items():
            setattr(self, name, value)
        for name, widget in controls.items():
            traitlets.link((self, name), (widget, "value"))
        words = ["Coarse, to see what comes of it", "Fine, as it is printed"]
        looks = {"button_width": "auto"}
        self.sizes = lean(ipywidgets.ToggleButtons, options=list(SIZES.items()), value=None, tooltips=words, style=looks)
        self.sizes.add_class("mechstyle-sizes")
        self.sizes.observe(self._choose_size, "value")
        self.observe(self._show_size, "vertices")
        self._show_size()
        self._way.observe(self._choose_way, "value")
        self._standard.observe(self._choose_standard, "value")
        self._height.observe(self._fall, "value")
        self._file.observe(self._read, "value")
        self._tell()

    def _loads_row(self) -> ipywidgets.HBox:
        """A place for the name of a load file, and a button that takes the loads away."""
        self._file = lean(
            ipywidgets.Text,
            description="it carries", placeholder="a load file.toml", continuous_update=False, style=NARROW_LABEL,
            tooltip="A file of load cases: where the part is held, what pulls or presses on it", layout={"flex": "1 1 auto", "width": "0"},
        )  # fmt: skip
        self._unload = lean(ipywidgets.Button, icon="times", tooltip="Nothing to carry but the drop", layout={"width": "32px"})
        self._unload.on_click(lambda _: self._carry(""))
        return lean(ipywidgets.HBox, [self._file, self._unload], layout=WIDE)

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

    @traitlets.validate("loads")
    def _as_records(self, proposal: dict[str, Any]) -> tuple[LoadCase, ...]:
        return load_cases(proposal["value"])

    @traitlets.observe("orientations", "poses", "standard", "height", "nearly_flat", "loads", "strengthen", "criterion")
    def _tell(self, _change: object = None) -> None:
        """Bring the way up to date, and say what will be tested."""
        self._way.value, self._standard.value = self.way, self.standard
        show(self._drops, self.way != ONCE)
        show(self._unload, self.loads)
        self._height.value = written(self.height)
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

    @traitlets.observe("loads")
    def _forget_file(self, _change: object) -> None:
        """Loads that came another way are not those of the file named last."""
        self._name("")

    def _fall(self, change: dict[str, Any]) -> None:
        """Take the height that was written; what cannot be used is said and leaves the last one."""
        try:
            self.height = change["new"]
        except BadInput as error:
            self.complain(str(error))
        except traitlets.TraitError:
            low, high = (written(height) for height in range_of("height").values())
            self.complain(f"a fall of {change['new']} cannot be simulated: write one between {low} and {high}")
        else:
            self.complain("")
            self._height.value = written(self.height)

    def _choose_way(self, change: dict[str, Any]) -> None:
        """Another way brings its usual number of drops."""
        way = change["new"]
        if way == ONCE:
            self.orientations = 1
        elif way != self.way:
            with self.hold_trait_notifications():
                self.poses, self.orientations = way, POSES[way]

    def _choose_size(self, change: dict[str, Any]) -> None:
        if change["new"] is not None:
            self.vertices = change["new"]

    def _show_size(self, _change: object = None) -> None:
        """Neither where a number was asked for that is of neither."""
        self.sizes.value = self.vertices if self.vertices in SIZES.values() else None

    def _choose_standard(self, change: dict[str, Any]) -> None:
        """A standard brings its landings and height; none leaves them as they are."""
        if change["new"] != self.standard:
            with self.hold_trait_notifications():
                for name, value in with_drops({"standard": change["new"]}).items():
                    setattr(self, name, value)

    def _carry(self, file: str) -> None:
        """Take the load cases of a file, or none; what cannot be used is said and leaves the others."""
        try:
            self.loads = file or ()
        except BadInput as error:
            self.complain(str(error))
        else:
            self.complain("")
            self._name(file)

    def _name(self, file: str) -> None:
        self._file.unobserve(self._read, "value")
        self._file.value = file
        self._file.observe(self._read, "value")

    def _read(self, change: dict[str, Any]) -> None:
        self._carry(change["new"].strip())
