"""The Studio: settings, mask and branches beside the part, its story below."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import ipywidgets
import numpy as np
import traitlets
from numpy.typing import NDArray

from mechstyle.errors import BadInput, MechStyleError
from mechstyle.fea.explicit import cores
from mechstyle.gallery import PREFIX
from mechstyle.loop.store import parse_address
from mechstyle.pictures.fields import STAYS_BENT
from mechstyle.records import SETTINGS, Recipe
from mechstyle.records.mesh import SurfaceMesh, check_vertices
from mechstyle.records.recipe import DEFAULTS
from mechstyle.runs.images import remember
from mechstyle.runs.recipes import FREESTYLE, brought, check_figure, recipe_for
from mechstyle.runs.run import Draft, Run
from mechstyle.simulation.estimate import estimated, landings_on_the_way, plan_of
from mechstyle.teaching import STYLE, trophy
from mechstyle_widgets.jupyter.cell_output import OncePerCell
from mechstyle_widgets.jupyter.frame import Frame
from mechstyle_widgets.jupyter.language import said, speak, speaking, spoken, word
from mechstyle_widgets.jupyter.looks import close_family, lean, sharing, show, stacked, unheard
from mechstyle_widgets.jupyter.one_thread import hear_on_one_thread
from mechstyle_widgets.panels.branches import Branches
from mechstyle_widgets.panels.keys import Keys
from mechstyle_widgets.panels.mask_inspector import DECIDES, MaskInspector
from mechstyle_widgets.panels.my_runs import MyRuns
from mechstyle_widgets.panels.next_steps import NextSteps
from mechstyle_widgets.panels.pull import PullHere
from mechstyle_widgets.panels.result import Result
from mechstyle_widgets.panels.run_controls import NOT_RUNNING, RunControls
from mechstyle_widgets.panels.take_away import TakeAway
from mechstyle_widgets.panels.undo import Undo
from mechstyle_widgets.settings.control import ControlSelector
from mechstyle_widgets.settings.drop import SIZES, DropOptions
from mechstyle_widgets.settings.material import MaterialPicker
from mechstyle_widgets.settings.part import PartPicker
from mechstyle_widgets.settings.printed import PrintedPicker
from mechstyle_widgets.settings.prompt import PromptBox
from mechstyle_widgets.settings.regions import RegionsPicker, covered, paintable
from mechstyle_widgets.settings.schedule import ScheduleSelector
from mechstyle_widgets.settings.section import Group
from mechstyle_widgets.state.controller import Controller
from mechstyle_widgets.state.on_show import OnShow, on_show
from mechstyle_widgets.state.opening import opening, shipped
from mechstyle_widgets.state.preview import Preview, Previewer
from mechstyle_widgets.state.studio_state import FREE, StudioState, titled
from mechstyle_widgets.timeline.timeline import Timeline
from mechstyle_widgets.viewer.run_viewer import RunViewer
from mechstyle_widgets.viewer.viewer import PartViewer, Viewer

SIZE = (640, 430)  # width and height of the view until the page says how much room there is [pixels]
TITLES = ("Part", "Style", "Material", "How it is printed", "Holding back", "When to test", "Keep plain", "Drop test")
OPEN = ("Part", "Style")
"""Groups of settings that are open at first: what decides the look."""
ASKED = 2
"""The tab that tells what is known of the place that was clicked."""
SECTIONS = (PromptBox, MaterialPicker, PrintedPicker, ControlSelector, ScheduleSelector, RegionsPicker, DropOptions)
INSTEAD = {"quick": "ask for fewer vertices instead, such as vertices=4000", "out": "name its folder instead, folder='runs/cup'"}
"""What is asked for in the Studio where `ms.stylize` has another name."""
ENDINGS = {"finished": "The run of {} is finished.", "failed": "The run of {} has stopped by an error."}
"""What the browser says of a run that nobody watched, by what became of it."""
SHOWN = {field for section in SECTIONS for field in section.FIELDS}
OF_A_PART = ("relief", "amplitude", "side", "feature", "image_size", "protect", "loads", "minimum_wall", "strengthen")
"""Fields of a recipe that are meant for one part: lengths on it and places of it."""
TRAIT = re.compile(r"^The (?:value of the )?'(?P<name>\w+)' trait of an? \w+ instance")
"""How a trait begins to say what it does not take."""
IN_WORDS = {
    "expected a float": "must be a number", "expected an int": "must be a whole number", "expected a boolean": "must be True or False",
    "expected a unicode string": "must be text", "expected any of": "must be one of",
}  # fmt: skip
"""What it takes, in plain words."""
UNSEEN = tuple(name for name in SETTINGS if name not in SHOWN)
"""Fields of a recipe without a control: what a run was opened with, or was given by name, stays."""


@contextmanager
def plainly() -> Iterator[None]:
    """Refuse what cannot be used in one line, in the language spoken; a value of the wrong kind by the name it was given by."""
    try:
        yield
    except BadInput as error:
        if (told := _said_of_settings(str(error))) == str(error):
            raise
        raise BadInput(told) from None
    except traitlets.TraitError as error:
        line = re.sub(r", not the \w+ (.*)\.$", r", not \1", TRAIT.sub(r"\g<name>", str(error)))
        for says, means in IN_WORDS.items():
            line = line.replace(says, means)
        raise BadInput(_said_of_settings(line)) from None


def _said_of_settings(line: str) -> str:
    """A sentence in the language spoken; the setting with which it begins keeps its name, by which it was given."""
    name, _, rest = line.partition(" ")
    return said(f"… {rest}").replace("…", name, 1) if name in SETTINGS else said(line)


class Studio(OncePerCell, ipywidgets.VBox):  # type: ignore[misc]  # ipywidgets has no types
    """A part, a prompt and a run, as the last expression of a cell.

    Each part of it is a widget with documented traits; what the mouse sets, Python can set: `studio.prompt_box.prompt`,
    `studio.control_selector.threshold`, `studio.state.iteration`, `studio.controller.run()`.

    Attributes:
        state: What is shown and what is going on.
        controller: What the buttons do.
        theme: `light` or `dark`, or `auto`, which follows the notebook's.
    """

    theme = traitlets.Enum(("auto", "light", "dark"), "auto")
    _viewer: Viewer | None = None
    _timeline: Timeline | None = None
    _pictured = False
    _enlarged = ""
    """The prompt of which it is said how much larger it is drawn than asked."""
    _drafted: tuple[dict[str, Any], Recipe] | None = None
    _of_lesson: Mapping[str, Any] = {}
    """Settings that another part does not keep, as long as nobody has changed them."""
    _spared: tuple[str, NDArray[np.bool_]] = ("", np.zeros(0, bool))
    """What the last preview left as it is, but for what was painted or written: digest of its surface, and shape [vertex_count]."""

    @sharing()
    @plainly()
    def __init__(
        self, part: str | Path | SurfaceMesh | Run | None = None, *,
        theme: str = "auto", language: str | None = None, filled: bool = False, **settings: Any,
    ) -> None:  # fmt: skip
        """Open a part, or a run that was made before. The Studio is as wide as its cell.

        Args:
            part: `gallery:NAME`, a file, a surface, a run, or a run directory, which may be written DIR@LANE; None for the trophy
                of the lessons, in their style, and without any setting for a finished run of it beside Freestyle.
            theme: `light` or `dark`, or `auto`, which follows the notebook's.
            language: What it speaks: `en` or `de`; None for that of the Studio before it, English at first.
            filled: Whether it fills the window from the beginning on.
            settings: Any of `prompt`, `material`, `freestyle`, `vertices`, `device`, `folder`, `scale`, and settings of a recipe.

        Raises:
            BadInput: If the part or a setting cannot be used, in one sentence.
        """
        if language is not None:
            speak(language)
        hear_on_one_thread()  # from the first control on, so that each knows what it speaks
        with speaking(spoken()):
            self._make(part, settings, theme=theme, filled=filled)

    def _make(self, part: str | Path | SurfaceMesh | Run | None, settings: dict[str, Any], *, theme: str, filled: bool) -> None:
        """Put it together, in the language spoken; arguments as of `__init__`."""
        shown, lesson = part is None and not settings, part is None
        if shown:
            part = opening()
        elif part is None:
            part = trophy()
            settings = {**STYLE, "vertices": len(part.vertices), "name": part.name, **settings}
        run = run_in(part, settings.get("device", "auto"))
        if run is None:
            settings = {"vertices": SIZES["Try it"], **settings}
        self.state = StudioState()
        self.controller = Controller(self.state, self.wanted)
        self._make_sections("" if run is not None else part, settings)
        self.next_steps = NextSteps(self.controller, self.mask_inspector, self.drop_options, self.make_yours)
        self._undo = Undo(self._all_settings, self._give_all)
        self._changed()  # the timeline begins with the plan: what a figure gets before a page shows it may get lost
        self.frame, self._size = Frame(filled=filled), SIZE
        traitlets.link((self.frame, "calm"), (self.state, "calm"))
        self.take_away = TakeAway(self.state, self.frame)
        self.previewer = Previewer(self._heard(self._arrived), self._heard(self._not_drawn))
        self._middle, self._asked = stacked([], "mechstyle-view"), stacked([], "mechstyle-asked")
        self.theme = theme
        self._timeline = Timeline(self.state, theme=self.shown_theme, width=SIZE[0])
        bar = [self.run_controls, self._undo, self.drop_options.sizes, self.take_away, self.frame]
        super().__init__([stacked(bar, "mechstyle-bar"), self._body()])
        self.add_class("mechstyle-studio")
        self._wire()
        if run is not None:
            with self.state.hold_trait_notifications():  # all is heard of at once: no view of the plain part is made first
                self.state.open(run)
                self._take(run)
        self._of_lesson = {name: getattr(self._owners[name], name) for name in STYLE} if lesson else {}
        self._other_part()
        if shown:
            self.state.pinned, self.state.layer = (FREE, self.state.end_of(FREE)), STAYS_BENT
        self._undo.begin()
        self.state.observe(self._emphasise, ("settings", "status", "run", "part", "lane", "iteration"))
        self.drop_options.observe(self._emphasise, "vertices")
        self.state.observe(self._fill, "checkpoint")
        self._emphasise()
        self.state.observe(self._preview, "settings")
        self.state.observe(self._rested, ("status", "run"))

    def _wire(self) -> None:
        """Let the page, the state and the settings be heard."""
        self.frame.observe(self._fit, "size")
        self.frame.observe(self._relight, "dark")
        self.frame.on_key("view", self._heard(lambda key, **held: self._viewer.key(key, **held) if self._viewer is not None else None))
        self.frame.on_key("studio", self._heard(Keys(self)))
        self.frame.on_file(self._heard(self.part_picker.take_file))
        self.state.observe(self._other_run, "run")
        self.state.observe(self._another_checkpoint, "checkpoint")
        self.part_picker.observe(self._other_part, "mesh")
        self.mask_inspector.selector.observe(self._derive, ("freestyle", *DECIDES))
        self.state.observe(self._stand_beside, ("pinned", "third"))
        self.regions_picker.observe(self._hatch, "protect")
        self.drop_options.observe(self._other_criterion, "criterion")
        for section in self._sections:
            section.observe(self._changed, (*section.FIELDS, *section.OWN))

    def __repr__(self) -> str:
        """The run and the iteration shown."""
        return f"Studio({self.state.run!r})" if self.state.run is not None else f"Studio({self.part_picker.name!r})"

    def still(self) -> Callable[[], bytes] | None:
        """What draws the view under its badge."""
        return None if self._viewer is None else self._viewer.still()

    def renew_still(self) -> None:
        """Let the notebook have a picture of what is shown now, unless a style is on its way that will take its place."""
        if self._pictured or not self.previewer.awaited or not isinstance(self._viewer, PartViewer):
            super().renew_still()

    @property
    def run(self) -> Run | None:
        """The run on show, None before there is one."""
        return self.state.run

    @property
    def viewer(self) -> Viewer | None:
        """The view of what is on show, None while there is none."""
        return self._viewer

    def step_back(self, *, forward: bool = False) -> None:
        """Undo the last setting, or redo one that was undone."""
        (self._undo.redo if forward else self._undo.undo)()

    def show_mask(self) -> None:
        """Show what is held back, and what another setting would hold back."""
        self._tabs.selected_index = 0

    def make_yours(self) -> None:
        """Leave the shipped comparison for the plain part, and wait for a style in the box for it."""
        with self._undo.as_one(), self.state.hold_trait_notifications():
            self._leave_freestyle()
            self.prompt_box.prompt = ""
        self.prompt_box.focus()

    def _leave_freestyle(self) -> None:
        """Who has looked at the free one of the shipped comparison has not asked for Freestyle."""
        if self.run is not None and shipped(self.run) and self.control_selector.freestyle:
            self.control_selector.freestyle = False
            for name in FREESTYLE.keys() - STYLE.keys():
                setattr(self._owners[name], name, DEFAULTS[name])

    def back(self) -> None:
        """Ask for the run on show again: its part and its settings."""
        if self.run is not None:
            self._take(self.run)
            self._other_part()

    def wanted(self) -> Draft:
        """The run the settings ask for; BadInput if they cannot be used."""
        run, mesh, options, recipe = self.run, self.part_picker.mesh, self.drop_options, self._recipe
        assert mesh is not None, "a Studio begins with a part"
        opened = mesh is self._opened_mesh and options.vertices == len(mesh.vertices)
        at_hand = run if opened and run is not None and run.store.place == self._opened_place else None
        if not opened:
            check_vertices(options.vertices)
        part, name = mesh if at_hand is None else at_hand.part, self.part_picker.name or "part"
        return Draft(recipe, part, options.vertices, name, options.folder or None, options.device)

    def close(self) -> None:
        """Stop what is going on and close every widget."""
        if self._timeline is not None:  # None if `__init__` raised
            self.controller.stop()
            self.previewer.cancel()
            self._timeline.close()
            if self._viewer is not None:
                self._viewer.close()
            close_family(self)
        super().close()

    # how it is put together

    def _make_sections(self, part: Any, settings: dict[str, Any]) -> None:
        self._opened_mesh: SurfaceMesh | None = None  # the part of the run that was opened, ready as it is
        self._opened_place: Path | None = None
        self._unseen: dict[str, Any] = {}
        given = dict(settings)
        scale, name = given.pop("scale", None), given.pop("name", "part")
        self.part_picker = PartPicker(str(part) if isinstance(part, Path) else part, scale=scale, name=name)
        self.prompt_box = PromptBox(given.pop("prompt", "brick"))
        self.material_picker = MaterialPicker(given.pop("material", "PLA"))
        self.printed_picker = PrintedPicker()
        self.control_selector = ControlSelector(self.material_picker.material)
        self.schedule_selector = ScheduleSelector()
        self.regions_picker = RegionsPicker()
        self.drop_options = DropOptions()
        self._sections = [self.prompt_box, self.material_picker, self.printed_picker, self.control_selector, self.schedule_selector,
                          self.regions_picker, self.drop_options]  # fmt: skip
        self._owners = {name: section for section in self._sections for name in (*section.FIELDS, *section.OWN)}
        traitlets.link((self.material_picker, "material"), (self.control_selector, "material"))
        traitlets.link((self.material_picker, "price"), (self.state, "price"))
        for name in ("relief", "amplitude"):
            traitlets.link((self.prompt_box, name), (self.schedule_selector, name))
        self._give(given)
        self.run_controls = RunControls(self.controller, self.back)
        self.mask_inspector = MaskInspector(self.controller)
        self.branches, self._result = Branches(self.controller), Result(self.state)
        self.pull_here = PullHere(self.drop_options, lambda: self._viewer)

    def _give(self, settings: dict[str, Any]) -> None:
        """Set what was given by name; as everywhere, a standard, poses and a criterion bring what belongs to them."""
        for name, value in brought(settings, self.control_selector.control).items():
            if name in SETTINGS:
                check_figure(name, value)
            elif name == "vertices":
                check_vertices(value)
            if name in self._owners:
                setattr(self._owners[name], name, value)
            elif name in UNSEEN:
                self._unseen[name] = value.tolist() if isinstance(value, np.ndarray) else value  # two of them can be compared
            else:
                known = sorted({*UNSEEN, *self._owners})
                near = difflib.get_close_matches(name, known, n=1, cutoff=0.5)
                hint = f"did you mean {near[0]!r}?" if near else "docs/studio.md and `help(Studio)` name those it has"
                raise BadInput(f"the Studio has no setting {name!r}: {INSTEAD.get(name, hint)}")

    @property
    def _chosen(self) -> dict[str, Any]:
        """What is chosen in all sections, by the names of a recipe's fields."""
        return {name: value for section in self._sections for name, value in section.settings.items()}

    @property
    def _recipe(self) -> Recipe:
        """What they come to; several ask for it after every change, and again when a run is begun: it is worked out once."""
        chosen, freestyle = self._chosen, self.control_selector.freestyle
        unseen = {name: value for name, value in self._unseen.items() if not (name == "clip" and chosen["guidance"] == "offline")}
        settled = (*FREESTYLE, "normalisation") if freestyle else ()
        asked = {**unseen, **{name: value for name, value in chosen.items() if name not in settled}, "freestyle": freestyle}
        if self._drafted is None or self._drafted[0] != asked:
            self._drafted = asked, recipe_for(**asked)
        return self._drafted[1]

    def _body(self) -> ipywidgets.Box:
        """Settings, view with timeline, and what looks into them; the sheet of the frame says which stand beside each other."""
        sections = zip(TITLES, (self.part_picker, *self._sections), strict=True)
        self._groups = [Group(title, section, unfolded=title in OPEN, page=title not in OPEN) for title, section in sections]
        self.my_runs = MyRuns(self.state, self._open_again)
        runs = Group("My runs", self.my_runs, page=True)
        runs.observe(lambda change: self.my_runs.look() if change["new"] else None, "unfolded")
        self._groups.append(runs)
        for group in self._groups:
            group.observe(self._turn_page, "unfolded")
        self._tabs = lean(ipywidgets.Tab, [self.mask_inspector, self.branches, self._asked], titles=("What if", "Branches", "Place"))
        traitlets.dlink((self._tabs, "selected_index"), (self.pull_here, "shown"), lambda index: index == ASKED)
        setup, middle = stacked(self._groups, "mechstyle-setup"), stacked([self._middle, self._timeline], "mechstyle-middle")
        return stacked([setup, middle, self.next_steps, stacked([self._result, self._tabs], "mechstyle-inspect")], "mechstyle-body")

    def _turn_page(self, _change: object = None) -> None:
        """A group that is a page takes the place of all others while it is open."""
        pages = [group for group in self._groups if group.page and group.unfolded]
        for group in self._groups:
            show(group, not pages or group in pages)

    def close_page(self) -> bool:
        """Go back from a page to all groups of settings; whether one was open."""
        pages = [group for group in self._groups if group.page and group.unfolded]
        for group in pages:
            group.unfolded = False
        return bool(pages)

    def _open_again(self, run: Run) -> None:
        self.close_page()
        self._take(run)
        self.state.open(run)
        self._other_part()

    def _all_settings(self) -> dict[str, Any]:
        chosen, part = {name: getattr(section, name) for name, section in self._owners.items()}, self.part_picker
        return {**chosen, "unseen": dict(self._unseen), "part": (part.model, part.scale, part.body, part.mesh, part.name)}

    def _give_all(self, settings: dict[str, Any]) -> None:
        self._unseen = dict(settings["unseen"])
        model, scale, body, mesh, name = settings["part"]
        if mesh is not self.part_picker.mesh and mesh is not None:  # it brings defaults of its own
            self.part_picker.choose(model, scale, body) if model else self.part_picker.show(mesh, name)
        # the method of a criterion is among the settings
        with unheard(self.drop_options, self._other_criterion, "criterion"), self.state.hold_trait_notifications():
            for name, section in self._owners.items():
                setattr(section, name, settings[name])

    def _take(self, run: Run) -> None:
        remember(run.recipe, run.store)  # its picture may come from another machine
        self._take_recipe(run.recipe)
        self.drop_options.vertices = len(run.part.surface.vertices)
        self._opened_mesh, self._opened_place = run.part.surface, run.store.place
        self.part_picker.show(run.part.surface, run.record.name, run.record.origin.model)

    def _take_recipe(self, recipe: Recipe) -> None:
        self._unseen = {name: recipe.settings[name] for name in UNSEEN}
        heard = unheard(self.drop_options, self._other_criterion, "criterion")  # whose method is in the recipe
        with heard, self._undo.as_one(), self.state.hold_trait_notifications():  # one change of the settings, not one for each
            for section in self._sections:
                section.take(recipe)

    # what it follows

    def _other_criterion(self, change: dict[str, Any]) -> None:
        """A criterion that is chosen brings its method, as everywhere."""
        with self._undo.as_one():
            self._give({"criterion": change["new"]})

    def _changed(self, _change: object = None) -> None:
        self.state.settings = {**self._chosen, **(FREESTYLE if self.control_selector.freestyle else {})}
        self._undo.note()

    def _other_part(self, change: object = None) -> None:
        """A part was picked: show its run if there is one at hand, else the part as it is, with defaults of its own."""
        mesh = self.part_picker.mesh
        if change is not None and mesh is not None:
            self._give_defaults(mesh)
        self.state.part = "" if mesh is None else mesh.digest
        self._undo.note()
        if mesh is not None and not self._show_its_run():
            self._show_part(mesh)
            self._preview()

    def _give_defaults(self, mesh: SurfaceMesh) -> None:
        """Ask for nothing that was meant for the part before: sizes on it, places of it, how fine it was; its own run has its own."""
        run, vertices = self.run, self.controller.began_with(mesh)
        if mesh is self._opened_mesh:
            if run is None or run.store.place != self._opened_place:  # it is being opened, with its settings
                return
            vertices = len(mesh.vertices)
        with self._undo.as_one(), self.state.hold_trait_notifications():
            if vertices is not None and run is not None:
                self._take_recipe(run.recipe)
            else:
                self._leave_freestyle()
                lesson = [name for name, value in self._of_lesson.items() if getattr(self._owners[name], name) == value]
                for name in (*OF_A_PART, *lesson):
                    setattr(self._owners[name], name, DEFAULTS[name])
            self.drop_options.vertices = vertices or SIZES["Try it"]

    def _show_its_run(self) -> bool:
        """Show the run of the part that is chosen, if one is at hand and there is anything to see of it; whether it is on show."""
        run, mesh = self.run, self.part_picker.mesh
        if run is None or mesh is None or self.state.checkpoint is None:
            return False
        opened = mesh is self._opened_mesh and run.store.place == self._opened_place
        if (not opened and self.controller.began_with(mesh) is None) or self._looks_otherwise():
            return False
        self.previewer.cancel()  # a part is there before its run: a style would be drawn that nobody sees
        if not isinstance(self._viewer, RunViewer):
            self._show_run()
        return True

    def _other_run(self, change: dict[str, Any]) -> None:
        """Another run directory needs another viewer; another lane of the same shows its settings."""
        old, new = change["old"], change["new"]
        if isinstance(old, Run) and new is not None and old.store.place == new.store.place:
            self._take_recipe(new.recipe)
            return
        if isinstance(self._viewer, RunViewer):
            self._viewer.let_go()
        if self.state.checkpoint is not None:
            self._show_run()
        elif new is not None and not isinstance(self._viewer, PartViewer):  # a preview stays until there is more to see
            self._show(self._made(Viewer, new.part.surface))

    def _another_checkpoint(self, change: dict[str, Any]) -> None:
        """A run is on show from its first checkpoint on, and whenever one of it is looked at."""
        there = self.state.checkpoint is None or isinstance(self._viewer, RunViewer) or self._show_its_run()
        if not there and (change["old"] is None or not self.state.follow):
            self._show_run()
        if isinstance(self._viewer, RunViewer):
            self._viewer.insight = self.branches.insight()  # which is of tested ends alone

    def _looks_otherwise(self) -> bool:
        """Whether a style is asked for that the run on show does not have, while nothing is in hand."""
        if self.run is None or self.controller.busy:
            return False
        try:
            return not self.controller.differs().keys().isdisjoint(PromptBox.FIELDS)
        except MechStyleError:  # what is wrong is said where it is set
            return True

    def _show_part(self, mesh: SurfaceMesh) -> None:
        """Show a part in the view in which its style will stand, if that is known: a page takes a second to make another."""
        ready = self.previewer.ready(mesh, self.drop_options.vertices)
        self._show(self._made(PartViewer, paintable(mesh) if ready is None else ready))

    def _show_run(self) -> None:
        self._show(self._made(RunViewer, self.state))
        self._stand_beside()
        self._derive()

    def _stand_beside(self, _change: object = None) -> None:
        """What is compared stands beside what is shown from now on, and the place that decides is marked."""
        viewer = self._viewer
        if isinstance(viewer, RunViewer):
            viewer.insight = self.branches.insight()
            viewer.also, viewer.compared = self.state.third, self.state.pinned
            vertex, _ = self.branches.decisive() or (None, "")
            if vertex is None:
                viewer.probed = None
            else:
                viewer.look_round(vertex)

    def _derive(self, _change: object = None) -> None:
        """Let the viewer work out the mask that would be with other settings."""
        if isinstance(self._viewer, RunViewer):
            self._viewer.derived = (self.mask_inspector.layer(),)

    def _show(self, viewer: Viewer) -> None:
        old, self._viewer = self._viewer, viewer
        self._middle.children, self._asked.children = [viewer], [self.pull_here, viewer.lend_table()]
        self._caption()
        viewer.on_click(self._click)
        self._hatch()
        if old is not None:
            old.close()

    def _click(self, place: tuple[float, float, float]) -> None:
        """A click paints while the brush is in hand; otherwise it asks of the place."""
        self.regions_picker.click(place)
        if not self.regions_picker.paint:
            self.pull_here.click(place)
            self._tabs.selected_index = ASKED

    def _made(self, make: Callable[..., Any], what: Any) -> Any:
        return make(what, theme=self.shown_theme, width=self._size[0], height=self._size[1])

    def _emphasise(self, _change: object = None) -> None:
        """Say what is made, and fill the one button that leads on: running what can be run, or, once the part is done, taking it away."""
        state, clear = self.state, True
        try:
            state.another = self.controller.asks_for_another() and self.run is not None
        except MechStyleError:  # what is wrong is said where it is set
            state.another, clear = self.run is not None, False
        self._foretell()
        self._fill()
        self.run_controls.emphasise(clear and not self._done)
        self.run_controls.title = state.title if self.run is not None and (self.controller.busy or not state.another) else self._asked_for
        self._caption()

    @property
    def _done(self) -> bool:
        return self.state.status == "finished" and not self.state.another

    def _fill(self, _change: object = None) -> None:
        """Taking the part away leads on where nothing else does; what a run was corrected to comes after its last iteration."""
        self.take_away.main.button_style = "primary" if self._done and not self.next_steps.steps else ""

    @property
    def _asked_for(self) -> str:
        """Part and style that are asked for."""
        return titled(self.part_picker.name, self.prompt_box.prompt)

    def _caption(self) -> None:
        """Let pictures of a style that was not run say so."""
        if isinstance(self._viewer, PartViewer):
            plain = titled(self.part_picker.name, "plain")
            self._viewer.captions = tuple(OnShow(title).caption for title in (self._asked_for, plain))

    def _foretell(self) -> None:
        """Say what test the next run has, and how long it will take on this machine."""
        plan, vertices = plan_of(self.state.settings), self.drop_options.vertices
        try:
            recipe = self.wanted().recipe
        except MechStyleError:  # what is wrong is said where it is set
            plan = None
        if plan is None:
            self.state.outlook, self.state.expected = "", 0.0
            return
        run, taken = self.run, self.state.seconds_of_a_test
        fall = None
        if run is not None and taken is not None and len(run.part.surface.vertices) == vertices:
            fall = taken / math.ceil(landings_on_the_way(self.state.settings) / cores())
        found = estimated(recipe, vertices, fall=fall)
        self.state.outlook, self.state.expected = found.words, found.seconds

    # what the page tells

    @property
    def shown_theme(self) -> str:
        """`light` or `dark`, as it is shown."""
        return self.theme if self.theme != "auto" else "dark" if self.frame.dark else "light"

    def _fit(self, _change: object) -> None:
        width, height = self.frame.size
        self._size = width, height
        if self._viewer is not None:
            self._viewer.resize(width, height)
        if self._timeline is not None:
            self._timeline.resize(width)

    # the style before it is run

    def _preview(self, _change: object = None) -> None:
        mesh = self.part_picker.mesh
        if mesh is not None and isinstance(self._viewer, RunViewer) and self._looks_otherwise():
            before = self._viewer
            before.let_go()
            self._show_part(mesh)
            self._viewer.look_from(before)
        if mesh is None or not isinstance(self._viewer, PartViewer) or self._show_its_run():
            self.previewer.cancel()
            if self.prompt_box.prompt != self._enlarged:
                self.prompt_box.enlarge(None)
            return
        try:
            recipe = self.wanted().recipe
        except MechStyleError:  # what is wrong is said where it is set
            self.previewer.cancel()
            self._viewer.take_off()
            self.prompt_box.enlarge(None)
            return
        if self.previewer.ask(mesh, self.drop_options.vertices, recipe):
            self._viewer.wait()

    def _arrived(self, preview: Preview) -> None:
        """A style was drawn: show it on the part, from where one looks now."""
        viewer = self._viewer
        if not isinstance(viewer, PartViewer):
            return
        surface, style = preview.shape.surface, preview.style
        self.part_picker.remark(preview.shape.too_thin(self.drop_options.minimum_wall))
        if style is not None:
            self._spared = surface.digest, style.spared & ~covered(preview.protect, surface)
        if viewer.undeformed.digest != surface.digest:
            finer = self._made(PartViewer, surface)
            finer.look_from(viewer)
            self._show(finer)
            viewer = finer
        if style is None:
            viewer.take_off("Only running it tells what this comes to")
        else:
            drawn = "at once" if preview.seconds < 0.05 else f"in {preview.seconds:.1f} s"
            viewer.put_on(preview.surface, f"Changes as you choose · drawn {drawn}")
        self._enlarged = self.prompt_box.prompt
        self.prompt_box.enlarge(preview.enlarged(self.drop_options.vertices), partial(setattr, self.drop_options, "vertices"))
        self._hatch()
        self._picture_first()

    def _not_drawn(self, why: str) -> None:
        if isinstance(self._viewer, PartViewer):
            self._viewer.take_off(why)
            self._picture_first()

    def _picture_first(self) -> None:
        """Let the notebook have a picture of the first preview alone: drawing another for each would take time from the next."""
        if not self._pictured:
            self._pictured = True
            self.renew_still()

    def _rested(self, _change: object) -> None:
        """What has come of a run is what its notebook is to show; a part that fails shows where."""
        shown = on_show(self.state)
        if self.state.status == "finished" and self.state.pinned is None and shown is not None and shown.fails:
            self._lead_to_worst()
        if self.state.status in (*NOT_RUNNING, "paused"):
            self.renew_still()
        if self.state.status in ENDINGS and self.state.session is not None:
            self.frame.tell(word(ENDINGS[self.state.status]).format(self.state.title))

    def _lead_to_worst(self) -> None:
        if isinstance(self._viewer, RunViewer):
            self._viewer.lead_to_worst()

    def _hatch(self, _change: object = None) -> None:
        """Show on the part what is painted or written as a protected region now, and what else the last preview left as it is."""
        viewer, picker = self._viewer, self.regions_picker
        if viewer is None:
            return
        digest, spared = self._spared
        try:
            painted = covered(picker.protect, viewer.undeformed)
            viewer.protected = painted | spared if isinstance(viewer, PartViewer) and viewer.undeformed.digest == digest else painted
        except BadInput as error:
            viewer.protected = None
            picker.complain(str(error))

    def _heard(self, act: Callable[..., object]) -> Callable[..., None]:
        """What a key does, whose every error is said."""

        def acted(*given: Any, **more: Any) -> None:
            try:
                act(*given, **more)
            except Exception as error:  # noqa: BLE001 — whatever it is, it is said
                self.state.alert(error)

        return acted

    @traitlets.observe("theme")
    def _relight(self, _change: object) -> None:
        for view in (self._viewer, self._timeline):
            if view is not None:
                view.theme = self.shown_theme


def run_in(part: Any, device: str) -> Run | None:
    """The run that `part` names, None if it names a part."""
    if isinstance(part, Run):
        return part
    if isinstance(part, SurfaceMesh) or str(part).startswith(PREFIX):
        return None
    root, _, _ = parse_address(str(part))
    return Run.open(part, device) if root.is_dir() else None
