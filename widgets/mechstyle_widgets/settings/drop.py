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
from mechstyle.runs.recipes import EXPECTED
from mechstyle_widgets.jupyter.looks import lean, show
from mechstyle_widgets.settings.section import NARROW_LABEL, WIDE, Section, range_of, setting

DEVICES = ("auto", "cpu", "cuda")
ONCE = "once"
"""The way to land that is a single drop."""
WAYS = {
    ONCE: ("as it stands, once", "one drop, as the part stands"),
    "fibonacci": ("any way up", "{} drops: as the part stands, then turned every way, evenly spread"),
    "tilts": ("nearly as it stands", "{} drops: as the part stands, then tilted a little to every side"),
    "resting": ("as it comes to rest", "up to {} drops: as the part stands, then on what it would come to rest on, the likeliest first"),
    "box26": ("on faces, edges, corners", "up to {} drops: as the part stands, then on each face, edge and corner of the box around it"),
    "box10": (
        "on a corner, its edges, faces",
        "up to {} drops: as the part stands, then on a corner of the box around it, on its edges, and on the faces",
    ),
    "faces6": ("on each face", "up to {} drops: as the part stands, then on each face of the box around it"),
}
"""Ways to land, a single drop or one of `POSES`: what they are called, and what is dropped so many times."""


class DropOptions(Section):
    """Drop test, loads, criterion, resolution, device and folder.

    Attributes:
        drop_height: Height of fall [mm].
        orientations: Drops in the final test, the first as placed.
        poses: How the others land, one of `POSES`; of no account with one drop.
        standard: Drop standard whose orientations and height are simulated, a key of `STANDARDS`, or "". Choosing one by hand brings them.
        tilts: Landings tilted by 3° that are judged together with the drop as placed.
        loads: Load cases the part must carry besides the drop, as records; a load file or a list of records may be set.
        criterion: What viable means, `robust` or `paper`.
        guarantee: Whether the finished relief is corrected until it is viable.
        minimum_wall: The thinnest wall the style may leave [mm], 0 for no rule.
        strengthen: The most that a part that does not hold as it is may be thickened by before its style [mm], 0 to leave it as it is.
        vertices: Of the standardised surface.
        device: `auto`, `cpu` or `cuda`.
        folder: Run directory, "" for one named by prompt and recipe.
    """

    FIELDS = (
        "standard", "drop_height", "orientations", "poses", "tilts", "loads", "criterion", "guarantee", "minimum_wall", "strengthen",
    )  # fmt: skip
    OWN = ("vertices", "device", "folder")

    drop_height = setting("drop_height")
    orientations = setting("orientations")
    poses = setting("poses")
    standard = setting("standard")
    tilts = setting("tilts")
    loads = traitlets.Any(())
    criterion = setting("criterion")
    guarantee = setting("guarantee")
    minimum_wall = setting("minimum_wall")
    strengthen = setting("strengthen")
    vertices = traitlets.Int(STANDARD_VERTICES, min=1)
    device = traitlets.Enum(DEVICES, "auto")
    folder = traitlets.Unicode("")

    def __init__(self, **traits: Any) -> None:
        """Offer them; `traits` are any of the attributes."""
        look = {"style": NARROW_LABEL, "layout": WIDE}
        controls = {
            "drop_height": lean(ipywidgets.BoundedFloatText, description="drop [mm]", step=100.0, **range_of("drop_height"), **look),
            "orientations": lean(
                ipywidgets.BoundedIntText,
                description="drops", tooltip="Drops of the final test, the first as the part stands", **range_of("orientations"), **look
            ),
            "tilts": lean(
                ipywidgets.BoundedIntText,
                description="tilted by 3°", tooltip="Drops tilted to all sides, judged with the one as placed; 0 takes flat at its word",
                **range_of("tilts"), **look,
            ),
            "criterion": lean(ipywidgets.Dropdown, options=CRITERIA, description="criterion", **look),
            "guarantee": lean(ipywidgets.Checkbox, description="correct until it is viable", indent=False, layout=WIDE),
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
            "vertices": lean(ipywidgets.BoundedIntText, description="vertices", min=1, max=400_000, step=1000, **look),
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
        self._standard = lean(ipywidgets.Dropdown, options=known, description="after", tooltip=after, **look)
        self._drops = controls["orientations"]
        drop_height, *others = controls.values()
        super().__init__([drop_height, self._way, *others[:1], self._standard, self._loads_row(), *others[1:]])
        for name, value in traits.items():
            setattr(self, name, value)
        for name, widget in controls.items():
            traitlets.link((self, name), (widget, "value"))
        self._way.observe(self._choose_way, "value")
        self._standard.observe(self._choose_standard, "value")
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
        return f"{self.drop_height / 1000:g} m, {WAYS[self.way][0]}"

    @property
    def way(self) -> str:
        """Landing orientations, a key of WAYS."""
        return ONCE if self.orientations == 1 else self.poses

    @traitlets.validate("loads")
    def _as_records(self, proposal: dict[str, Any]) -> tuple[LoadCase, ...]:
        return load_cases(proposal["value"])

    @traitlets.observe("orientations", "poses", "standard", "drop_height", "loads", "strengthen", "criterion")
    def _tell(self, _change: object = None) -> None:
        """Bring the way up to date, and say what will be tested."""
        self._way.value, self._standard.value = self.way, self.standard
        show(self._drops, self.way != ONCE)
        show(self._unload, self.loads)
        drops, carried = WAYS[self.way][1].format(self.orientations), "; ".join(case.name for case in self.loads)
        after = landings_after(self.standard, poses=self.poses, orientations=self.orientations, drop_height=self.drop_height)
        said = (
            drops,
            f"{after[:1].upper()}{after[1:]}",
            f"Besides, it must carry: {carried}" if carried else "",
            f"Where it does not hold as it is, it is thickened by up to {self.strengthen:g} mm before the style" if self.strengthen else "",
        )
        self.note(". ".join(filter(None, said)), (EXPECTED,) if self.criterion == "paper" else ())

    @traitlets.observe("loads")
    def _forget_file(self, _change: object) -> None:
        """Loads that came another way are not those of the file named last."""
        self._name("")

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
