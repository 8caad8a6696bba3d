# The widgets and where they are.

from mechstyle_widgets.panels.branches import Branches as Branches
from mechstyle_widgets.panels.mask_inspector import MaskInspector as MaskInspector
from mechstyle_widgets.panels.run_controls import RunControls as RunControls
from mechstyle_widgets.settings.control import ControlSelector as ControlSelector
from mechstyle_widgets.settings.drop import DropOptions as DropOptions
from mechstyle_widgets.settings.material import MaterialPicker as MaterialPicker
from mechstyle_widgets.settings.part import PartPicker as PartPicker
from mechstyle_widgets.settings.prompt import PromptBox as PromptBox
from mechstyle_widgets.settings.regions import RegionsPicker as RegionsPicker
from mechstyle_widgets.settings.schedule import ScheduleSelector as ScheduleSelector
from mechstyle_widgets.state.studio_state import StudioState as StudioState
from mechstyle_widgets.studio import Studio as Studio
from mechstyle_widgets.timeline.timeline import Timeline as Timeline
from mechstyle_widgets.viewer.layers import Layer as Layer, Subject as Subject
from mechstyle_widgets.viewer.run_viewer import RunViewer as RunViewer
from mechstyle_widgets.viewer.viewer import Viewer as Viewer
