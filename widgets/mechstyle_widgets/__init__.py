"""Notebook widgets of MechStyle: the Studio and its parts, views of a part and of a run. They import mechstyle, never the reverse."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mechstyle_widgets.panels.branches import Branches
    from mechstyle_widgets.panels.mask_inspector import MaskInspector
    from mechstyle_widgets.panels.run_controls import RunControls
    from mechstyle_widgets.settings.control import ControlSelector
    from mechstyle_widgets.settings.drop import DropOptions
    from mechstyle_widgets.settings.material import MaterialPicker
    from mechstyle_widgets.settings.part import PartPicker
    from mechstyle_widgets.settings.prompt import PromptBox
    from mechstyle_widgets.settings.regions import RegionsPicker
    from mechstyle_widgets.settings.schedule import ScheduleSelector
    from mechstyle_widgets.state.studio_state import StudioState
    from mechstyle_widgets.studio import Studio
    from mechstyle_widgets.timeline.timeline import Timeline
    from mechstyle_widgets.viewer.layers import Layer, Subject
    from mechstyle_widgets.viewer.run_viewer import RunViewer
    from mechstyle_widgets.viewer.viewer import Viewer

_WHERE = {name: module for module, names in {
    "panels.branches": "Branches",
    "panels.mask_inspector": "MaskInspector",
    "panels.run_controls": "RunControls",
    "settings.control": "ControlSelector",
    "settings.drop": "DropOptions",
    "settings.material": "MaterialPicker",
    "settings.part": "PartPicker",
    "settings.prompt": "PromptBox",
    "settings.regions": "RegionsPicker",
    "settings.schedule": "ScheduleSelector",
    "state.studio_state": "StudioState",
    "studio": "Studio",
    "timeline.timeline": "Timeline",
    "viewer.layers": "Layer Subject",
    "viewer.run_viewer": "RunViewer",
    "viewer.viewer": "Viewer",
}.items() for name in names.split()}  # fmt: skip

__all__ = [
    "Branches", "ControlSelector", "DropOptions", "Layer", "MaskInspector", "MaterialPicker", "PartPicker", "PromptBox", "RegionsPicker",
    "RunControls", "RunViewer", "ScheduleSelector", "Studio", "StudioState", "Subject", "Timeline", "Viewer",
]  # fmt: skip


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
