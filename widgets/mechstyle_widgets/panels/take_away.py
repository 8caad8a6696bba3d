"""Taking away what a run made: files for the printer and for others, a picture, the lines of code that make it again."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from functools import partial
from html import escape
from pathlib import Path

import ipywidgets

from mechstyle.geometry.threemf import SLICERS
from mechstyle.runs.export import Exported
from mechstyle.runs.printing import Printing
from mechstyle.runs.report.reproduce import cell_for
from mechstyle.runs.run import Run
from mechstyle_widgets.jupyter.frame import Frame
from mechstyle_widgets.jupyter.language import word
from mechstyle_widgets.jupyter.looks import lean, show
from mechstyle_widgets.jupyter.throttle import in_a_thread, running_loop
from mechstyle_widgets.settings.section import Section
from mechstyle_widgets.state.on_show import on_show
from mechstyle_widgets.state.studio_state import StudioState
from mechstyle_widgets.state.troubles import sentence

MEDIA = {".3mf": "model/3mf", ".stl": "model/stl", ".glb": "model/gltf-binary", ".html": "text/html", ".png": "image/png"}


class TakeAway(Section):
    """Buttons that let the page save what the iteration on show is."""

    def __init__(self, state: StudioState, frame: Frame) -> None:
        """Offer what a state shows; files go by way of a frame."""
        self.state, self._frame, self._loop = state, frame, running_loop()
        kinds: dict[str, tuple[str, str, str, Callable[[Run, int, Path], object]]] = {
            "3MF": (".3mf", "download", "The part in colour, for the slicer named beside it",
                    lambda run, at, path: run.exported(path, at, printing=Printing(slicer=self._slicer.value))),
            "STL": (".stl", "download", "The shape alone, for any slicer", lambda run, at, path: run.exported(path, at)),
            "GLB": (".glb", "cube", "The part in colour, to look at and to share", lambda run, at, path: run.exported(path, at)),
            "Report": (".html", "file-text-o", "The whole run as one page that opens offline", lambda run, _, path: run.report(path)),
            "Picture": (".png", "picture-o", "Style, stress and mask as a picture", lambda run, at, path: run.show(at).save(path)),
        }  # fmt: skip
        self._buttons = {name: self._button(name, icon, tooltip) for name, (_, icon, tooltip, _) in kinds.items()}
        self._tooltips = {name: word(tooltip) for name, (_, _, tooltip, _) in kinds.items()}
        for name, (suffix, _, _, make) in kinds.items():
            self._buttons[name].on_click(partial(self._begin, suffix, make))
        self._code = self._button("Copy as code", "code", "The lines of Python that make this run again")
        self._code.on_click(self._copy)
        self._slicer = lean(
            ipywidgets.Dropdown, options=SLICERS, description="3MF for", style={"description_width": "initial"}, layout={"width": "auto"},
            tooltip="Whose 3MF it is: standard or prusa (one strict file), bambu or orca (another)",
        )  # fmt: skip
        first, *others = (self._buttons[name] for name in ("3MF", "Report", "STL", "GLB", "Picture"))
        look = {"width": "40px"}
        self._more = lean(ipywidgets.ToggleButton, icon="ellipsis-h", tooltip="STL, GLB, picture, and whose 3MF it is", layout=look)
        rest = lean(ipywidgets.HBox, [self._slicer, *others[1:]], layout={"flex_flow": "row wrap"})
        self._more.observe(lambda change: show(rest, change["new"]), "value")
        rest.add_class("mechstyle-menu")
        show(rest, False)
        row = lean(ipywidgets.HBox, [first, others[0], self._code, self._more], layout={"flex_flow": "row wrap"})
        super().__init__([row, rest])
        self.add_class("mechstyle-take")
        state.observe(self._offer, ("run", "checkpoint", "status", "title", "another"))
        self._offer()

    @property
    def main(self) -> ipywidgets.Button:
        """What one does with a finished part."""
        return self._buttons["3MF"]

    def _button(self, name: str, icon: str, tooltip: str) -> ipywidgets.Button:
        return lean(ipywidgets.Button, description=name, icon=icon, tooltip=tooltip, layout={"width": "auto"})

    def _offer(self, _change: object = None) -> None:
        """Nothing is to take before there is an iteration; where what is asked for is another, the button names whose file it is."""
        state, shown = self.state, on_show(self.state)
        show(self, state.checkpoint is not None)
        name = word("3MF of {}").format(state.title) if state.another else "3MF"
        self.main.description = word("{}, take it anyway").format(name) if shown is not None and shown.fails else name
        for name, button in self._buttons.items():
            whose = "" if shown is None else f": {shown.caption}"
            button.tooltip = self._tooltips[name] + whose
        self.note("")
        self.complain("")

    def _begin(self, suffix: str, make: Callable[[Run, int, Path], object], _button: object = None) -> None:
        """Make a file, in a thread where there is an event loop to bring it back, and let the page save it."""
        run, iteration = self.state.run, self.state.iteration
        if run is None or self.state.checkpoint is None:
            return
        self._more.value = False  # what is said of the file stands where the menu was
        self.complain("")
        try:
            branch = "" if run.lane == "main" else f"{run.lane}-"
            name = f"{run.record.stem}-{branch}{iteration}{suffix}"
        except Exception as error:  # noqa: BLE001 — whatever it is, it is said
            self._refuse(sentence(error, run.store.place))
            return
        self.note(f"making {name} …")

        def made() -> tuple[bytes, tuple[str, ...]]:
            with tempfile.TemporaryDirectory() as folder:
                path = Path(folder) / name
                found = make(run, iteration, path)
                return path.read_bytes(), found.warnings if isinstance(found, Exported) else ()

        def hand_over(given: tuple[bytes, tuple[str, ...]]) -> None:
            data, warnings = given
            self._frame.hand_over(name, data, MEDIA[suffix])
            self.note(f"{name} is saved where the browser puts downloads", warnings)

        in_a_thread(self._loop, made, hand_over, lambda error: self._refuse(sentence(error, run.store.place)))

    def _refuse(self, why: str) -> None:
        self.note("")
        self.complain(why)

    def _copy(self, _button: object) -> None:
        """Put the lines where the page keeps what was copied, and say whose they are; they unfold where a browser does not let it."""
        run = self.state.run
        assert run is not None, "the buttons are hidden before there is an iteration"
        try:
            code = cell_for(run, run.history)
        except Exception as error:  # noqa: BLE001 — whatever it is, it is said
            self._refuse(sentence(error, run.store.place))
            return
        self._frame.copy(code)
        head = f"<summary>{escape(word('copied: the lines that make {} again').format(self.state.title))}</summary>"
        self._note.say(f'<details class="mechstyle-note mechstyle-code">{head}<pre>{escape(code)}</pre></details>')
