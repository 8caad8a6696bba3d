"""Notebook widgets of MechStyle: views of a part and of a run. They import mechstyle, never the reverse."""

try:
    from mechstyle_widgets.layers import Layer, Subject
    from mechstyle_widgets.run_viewer import RunViewer
    from mechstyle_widgets.timeline import Timeline
    from mechstyle_widgets.replay import Replay
    from mechstyle_widgets.viewer import Viewer
except ModuleNotFoundError as error:
    raise ModuleNotFoundError(
        f"the notebook widgets need {error.name}, which is not installed: pip install 'mechstyle[jupyter]'", name=error.name
    ) from error

__all__ = ["Layer", "Replay", "RunViewer", "Subject", "Timeline", "Viewer"]
