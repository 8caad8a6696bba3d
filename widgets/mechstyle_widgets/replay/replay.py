"""A run to scrub through: every iteration is in the browser, so it follows the slider without asking the kernel.

It plays the same data with the same scripts as the report. They are state of the widget, not a message to a view, so a view
that appears later, a second one, or a page opened again has it.
"""

from __future__ import annotations

import math
from typing import Any

import traitlets

from mechstyle.errors import BadInput, unknown
from mechstyle.runs.report import markup
from mechstyle.runs.report.replay_data import ReplayData, replay_data
from mechstyle.runs.run import Run
from mechstyle_widgets.jupyter.cell_output import OncePerCell
from mechstyle_widgets.jupyter.page_widget import PageWidget, static


class Replay(OncePerCell, PageWidget):
    """All iterations of a lane, with layers, a colour bar and a threshold.

    Attributes:
        iteration: Which is shown; set by slider, keys and play, or from Python.
        layer: `style`, `stress`, `demand`, `restraint` or `displacement`; another one brings its own threshold.
        threshold: Values above it are set apart [unit of the layer]; None for no threshold.
    """

    _esm = markup.bundle(static("replay", "replay.js"))
    _css = markup.static("player.css") + static("replay", "replay.css")

    iteration = traitlets.Int(0).tag(sync=True)
    layer = traitlets.Unicode("style").tag(sync=True)
    threshold = traitlets.Float(None, allow_none=True).tag(sync=True)
    _header = traitlets.Dict().tag(sync=True)
    _payload = traitlets.Bytes().tag(sync=True)

    def __init__(self, run: Run, *, iteration: int | None = None, layer: str = "style", threshold: float | None = None) -> None:
        """Show a lane, at its last iteration and with the threshold of the layer unless others are given.

        Raises:
            BadInput: If the run has no checkpoint yet, or no such iteration, layer or threshold.
        """
        self._run = run
        self._data: ReplayData = replay_data(run)
        shown = self._data.iterations[-1] if iteration is None else self._iteration(iteration)
        own = self._data.layer(self._layer(layer))["threshold"]
        chosen = own if threshold is None else self._threshold(layer, threshold)
        super().__init__(iteration=shown, layer=layer, _header=self._data.header, _payload=self._data.payload)
        self.threshold = chosen

    def __repr__(self) -> str:
        """Lane, iteration and layer; never the data."""
        return f"Replay({self._run!r}, iteration={self.iteration}, layer={self.layer!r})"

    def refresh(self) -> None:
        """Take in what the run has done since; a replay that stood at the end goes to the new one."""
        at_end = self.iteration == self._data.iterations[-1]
        self._data = replay_data(self._run)
        with self.hold_sync():
            self._header, self._payload = self._data.header, self._data.payload
            if at_end or self.iteration not in self._data.iterations:
                self.iteration = self._data.iterations[-1]

    @traitlets.validate("iteration")
    def _known_iteration(self, proposal: dict[str, Any]) -> int:
        return self._iteration(proposal["value"])

    @traitlets.validate("layer")
    def _known_layer(self, proposal: dict[str, Any]) -> str:
        return self._layer(proposal["value"])

    @traitlets.validate("threshold")
    def _fitting_threshold(self, proposal: dict[str, Any]) -> float:
        return self._threshold(self.layer, proposal["value"])

    def _iteration(self, wanted: int) -> int:
        known = self._data.iterations
        if wanted not in known:
            raise BadInput(f"iteration {wanted} is not in this replay: it holds {known[0]} to {known[-1]}")
        return wanted

    def _layer(self, wanted: str) -> str:
        keys = [layer["key"] for layer in self._data.header["layers"]]
        if wanted not in keys:
            raise unknown("layer", wanted, keys)
        return wanted

    def _threshold(self, layer: str, wanted: float) -> float:
        if self._data.layer(layer)["threshold"] is None:
            bounded = [layer["key"] for layer in self._data.header["layers"] if layer["threshold"] is not None]
            raise BadInput(f"the layer {layer!r} has no threshold: choose {' or '.join(bounded)} first")
        if not math.isfinite(wanted):
            raise BadInput(f"a threshold must be a number, not {wanted}")
        return wanted

    @traitlets.observe("layer")
    def _own_threshold(self, change: dict[str, Any]) -> None:
        self.threshold = self._data.layer(change["new"])["threshold"]
