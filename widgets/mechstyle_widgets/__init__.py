"""Notebook widgets of MechStyle: the Studio and its parts, views of a part and of a run. They import mechstyle, never the reverse."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mechstyle_widgets.branches import Branches
    from mechstyle_widgets.control_selector import ControlSelector
    from mechstyle_widgets.drop_options import DropOptions
    from mechstyle_widgets.layers import Layer, Subject
    from mechstyle_widgets.mask_inspector import MaskInspector
    from mechstyle_widgets.material_picker import MaterialPicker
    from mechstyle_widgets.part_picker import PartPicker
    from mechstyle_widgets.prompt_box import PromptBox
    from mechstyle_widgets.regions_picker import RegionsPicker
    from mechstyle_widgets.replay import Replay
    from mechstyle_widgets.run_controls import RunControls
    from mechstyle_widgets.run_viewer import RunViewer
    from mechstyle_widgets.schedule_selector import ScheduleSelector
    from mechstyle_widgets.state import StudioState
    from mechstyle_widgets.studio import Studio
    from mechstyle_widgets.timeline import Timeline
    from mechstyle_widgets.viewer import Viewer

_WHERE = {
    "Branches": "branches",
    "ControlSelector": "control_selector",
    "DropOptions": "drop_options",
    "Layer": "layers",
    "MaskInspector": "mask_inspector",
    "MaterialPicker": "material_picker",
    "PartPicker": "part_picker",
    "PromptBox": "prompt_box",
    "RegionsPicker": "regions_picker",
    "Replay": "replay",
    "RunControls": "run_controls",
    "RunViewer": "run_viewer",
    "ScheduleSelector": "schedule_selector",
    "Studio": "studio",
    "StudioState": "state",
    "Subject": "layers",
    "Timeline": "timeline",
    "Viewer": "viewer",
}

__all__ = [
    "Branches",
    "ControlSelector",
    "DropOptions",
    "Layer",
    "MaskInspector",
    "MaterialPicker",
    "PartPicker",
    "PromptBox",
    "RegionsPicker",
    "Replay",
    "RunControls",
    "RunViewer",
    "ScheduleSelector",
    "Studio",
    "StudioState",
    "Subject",
    "Timeline",
    "Viewer",
]


def __getattr__(name: str) -> Any:
    """Load what is asked for on first use: a process that only draws or prepares a part needs no widget library."""
    if name not in _WHERE:
        raise AttributeError(f"module 'mechstyle_widgets' has no attribute {name!r}")
    try:
        value = getattr(import_module(f"mechstyle_widgets.{_WHERE[name]}"), name)
    except ModuleNotFoundError as error:
        raise ModuleNotFoundError(
            f"the notebook widgets need {error.name}, which is not installed: pip install 'mechstyle[jupyter]'", name=error.name
        ) from error
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Every public name, loaded or not."""
    return __all__
