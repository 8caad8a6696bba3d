"""How the part is tested and the run is made: drop, criterion, resolution, device, folder."""

from __future__ import annotations

from typing import Any

import ipywidgets
import traitlets

from mechstyle.records import CRITERIA
from mechstyle.workpiece import STANDARD_VERTICES
from mechstyle_widgets.section import NARROW_LABEL, WIDE, Section

DEVICES = ("auto", "cpu", "cuda")


class DropOptions(Section):
    """Settings most people leave as they are.

    Attributes:
        drop_height: Height of fall [mm].
        orientations: Drops in the final test, the first as placed.
        criterion: What viable means, `robust` or `paper`.
        guarantee: Whether the finished relief is backed off until it is viable.
        minimum_wall: The thinnest wall the style may leave [mm], 0 for no rule.
        vertices: Of the standardised surface.
        device: `auto`, `cpu` or `cuda`.
        folder: Run directory, "" for one named by prompt and recipe.
    """

    FIELDS = ("drop_height", "orientations", "criterion", "guarantee", "minimum_wall")
    OWN = ("vertices", "device", "folder")

    drop_height = traitlets.Float(1500.0, min=1.0, max=1e5)
    orientations = traitlets.Int(5, min=1, max=512)
    criterion = traitlets.Enum(CRITERIA, "robust")
    guarantee = traitlets.Bool(True)
    minimum_wall = traitlets.Float(0.8, min=0.0)
    vertices = traitlets.Int(STANDARD_VERTICES, min=1)
    device = traitlets.Enum(DEVICES, "auto")
    folder = traitlets.Unicode("")

    def __init__(self, **traits: Any) -> None:
        """Offer them; `traits` are any of the attributes."""
        look = {"style": NARROW_LABEL, "layout": WIDE}
        controls = {
            "drop_height": ipywidgets.BoundedFloatText(description="drop [mm]", min=1.0, max=1e5, step=100.0, **look),
            "orientations": ipywidgets.BoundedIntText(
                description="orientations", min=1, max=512, tooltip="Drops of the final test, the first as the part stands", **look
            ),
            "criterion": ipywidgets.Dropdown(options=CRITERIA, description="criterion", **look),
            "guarantee": ipywidgets.Checkbox(description="back off until it is viable", indent=False, layout=WIDE),
            "minimum_wall": ipywidgets.BoundedFloatText(
                description="thinnest [mm]", min=0.0, max=50.0, step=0.1, tooltip="The thinnest wall the style may leave", **look
            ),
            "vertices": ipywidgets.BoundedIntText(description="vertices", min=1, max=400_000, step=1000, **look),
            "device": ipywidgets.Dropdown(options=DEVICES, description="device", **look),
            "folder": ipywidgets.Text(
                description="folder", placeholder="mechstyle-runs/…", continuous_update=False, tooltip="Where the run is kept", **look
            ),
        }
        super().__init__(list(controls.values()))
        for name, value in traits.items():
            setattr(self, name, value)
        for name, widget in controls.items():
            traitlets.link((self, name), (widget, "value"))
