"""Runs as people meet them: start one, carry it on, look into it, branch it, take the part out of it."""

from __future__ import annotations

import logging
from collections.abc import Callable, Generator, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import msgspec

from mechstyle._files import exclusive, write_whole
from mechstyle.errors import BadInput, MechStyleError, check_known
from mechstyle.fea.drop import resolve_device
from mechstyle.fea.explicit import Progress, no_progress
from mechstyle.geometry.cancelling import CancelCheck, never_cancel
from mechstyle.geometry.print_quality import untangled
from mechstyle.loop import minimum_wall
from mechstyle.loop.engine import Engine, Event, Finished
from mechstyle.loop.history import measured_at, simulations
from mechstyle.loop.objects import read_record, to_json
from mechstyle.loop.store import Entry, Lane, Store, parse_address
from mechstyle.pictures.panels import Picture, checkpoint_panels, chosen_panels, picture, styled_panel, with_protected
from mechstyle.records import SETTINGS, Checkpoint, Recipe, Simulation, Verdict, sentences
from mechstyle.records.material import Material
from mechstyle.records.mesh import QUICK_VERTICES, STANDARD_VERTICES, Field, SurfaceMesh, check_vertices
from mechstyle.runs import images
from mechstyle.runs.export import AS_USUAL, Exported, exported, known_fields
from mechstyle.runs.folders import PartRecord, check_free, default_folder, folder_for
from mechstyle.runs.printing import Printing
from mechstyle.runs.recipes import changed, expected, idle, recipe_for
from mechstyle.runs.session import Session
from mechstyle.runs.stylizers import FinishedStyle, finished_style, stylizer_for
from mechstyle.runs.summary import Clock, Summary, summarise
from mechstyle.simulation.part import (
    Origin,
    Relief,
    Shape,
    Stage,
    Warn,
    Workpiece,
    bounds_for,
    cached_memo,
    fitted,
    logged,
    prepare,
    refilled,
)
from mechstyle.simulation.simulator import DropSimulator
from mechstyle.simulation.strengthen import strengthened

OnEvent = Callable[[Event], None]
STYLED = "styled.png"
"""Name of the picture of the finished style in a run directory."""

logger = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class Run:
    """One lane of a run directory.

    Attributes:
        store: The run directory.
        lane: Name of the lane.
        device: `cpu` or `cuda`: where it is simulated when it goes on.
        clock: Seconds spent on it in this process.
        trusting: Whether what other runs remember of the unstylized part is taken for this one.

    Example:
        >>> run = ms.stylize(ms.load("gallery:drawer_knob"), "brick", vertices=500, iterations=4, out="runs/knob", device="cpu")
        >>> ms.Run.open("runs/knob").verdict == run.verdict
        True
    """

    store: Store
    lane: str = "main"
    device: str = "cpu"
    clock: Clock = field(default_factory=Clock, repr=False)
    trusting: bool = True

    @classmethod
    def open(cls, address: str | Path, device: str = "auto") -> Run:
        """A run directory, written as `DIR` or `DIR@LANE`."""
        root, lane, iteration = parse_address(str(address))
        if iteration is not None:
            raise BadInput(f"{address} names an iteration: open {root}@{lane} and give the iteration to show, surface, export or branch")
        store = Store.open(root)
        store.lane(lane)
        return cls(store, lane, resolve_device(device))

    def __repr__(self) -> str:
        """Folder, lane, prompt and progress."""
        named = f"Run({str(self.store.root)!r}, lane {self.lane!r}"
        try:
            history, recipe = self.history, self.recipe
        except MechStyleError as error:  # its folder may be gone, and what shows a run in a line must show it even so
            return f"{named}, which cannot be read: {error})"
        where = f"iteration {history[-1].iteration} of {recipe.schedule.iterations}" if history else "not started"
        return f"{named}, {recipe.style.prompt!r}, {where})"

    # what it is

    @property
    def recipe(self) -> Recipe:
        """The recipe in force."""
        return self.store.recipe(self.store.lane(self.lane).recipe)

    @property
    def record(self) -> PartRecord:
        """The part as stored."""
        return read_record(self.store.root / "part.json", PartRecord)

    @cached_property
    def part(self) -> Workpiece:
        """The prepared part."""
        return self.record.part(self.store.objects, self.store.root / "part.json")

    @property
    def history(self) -> list[Entry]:
        """Every checkpoint without its arrays, oldest first."""
        return self.store.history(self.lane)

    @property
    def finished(self) -> bool:
        """Whether the newest checkpoint is the end of the recipe in force."""
        return self.store.is_finished(self.lane)

    @property
    def verdict(self) -> Verdict:
        """The verdict of the newest simulation."""
        for entry in reversed(self.history):
            if entry.verdict is not None:
                return entry.verdict
        raise BadInput(f"nothing has been simulated in lane {self.lane!r} of {self.store.root} yet")

    @property
    def summary(self) -> Summary:
        """Summary of the lane; BadInput if it is not finished."""
        path = self._summary_path
        if not (self.finished and path.is_file()):
            how = "run the command that started it again, it goes on where it stopped"
            raise BadInput(f"lane {self.lane!r} of {self.store.root} is not finished: {how}")
        summary, history, verdict = read_record(path, Summary), self.history, self.verdict  # which know if an older measure judged
        given = {"outcome": verdict.outcome, "rows": verdict.rows, "doubts": verdict.doubts, "words": verdict.words}
        return msgspec.structs.replace(summary, **given, simulations=simulations(history))

    def checkpoint(self, iteration: int | None = None) -> Checkpoint:
        """The newest checkpoint of an iteration, None for the last."""
        return self.store.checkpoint(self.store.find(iteration, self.lane).digest)

    def simulation(self, iteration: int | None = None) -> Simulation:
        """The last simulation before or at an iteration, None for the last."""
        return self.store.objects.get_record(self.checkpoint(iteration).simulation, Simulation)

    def surface(self, iteration: int | None = None) -> SurfaceMesh:
        """The styled, coloured surface at an iteration, None for the last."""
        state = self.checkpoint(iteration)
        return self.part.surface.displaced(state.displacement).coloured(state.colour)

    # what can be done with it

    def show(self, iteration: int | None = None, *, fields: Sequence[str] = ()) -> Picture:
        """Styled part, stress, what stays bent and mask, or the `fields` named, side by side; `.save(path)` writes the PNG."""
        state = self.checkpoint(iteration)
        recipe = self.store.recipe(state.recipe)
        measured = measured_at(self.history, self.store.find(iteration, self.lane).digest)
        verdict = None if measured is None else self.store.find(measured, self.lane).verdict
        simulation = None if measured is None else self.simulation(measured)
        look, *of_test, restraint = checkpoint_panels(self.part.surface, state, recipe, verdict, measured, simulation)
        shown = [*of_test, with_protected(restraint, bounds_for(self.part, recipe)[0].freedom == 0.0)]
        if fields:
            shown = chosen_panels(look.mesh, known_fields(self.store, self.lane, self.part, state), fields)
        entry = self.store.find(iteration, self.lane)
        came = sentences.untested(entry.simulated_at) if entry.verdict is None else sentences.title(entry.verdict)
        return picture([look, *shown], title=f"{self.record.name}, iteration {state.iteration}: {came}")

    def _repr_mimebundle_(self, **_: Any) -> dict[str, str]:
        """A picture and a table in a notebook, also where no kernel runs; the one-line form elsewhere."""
        from mechstyle.runs.report.page import mimebundle  # noqa: PLC0415 — loaded when a notebook asks

        return mimebundle(self)

    def report(self, path: str | Path, *, impact: bool = False) -> Path:
        """Write a report of the lane as one HTML file that opens offline: verdict, replay, timeline, settings, how to make it again.

        Impacts that were looked at are in it; `impact` drops the part for it flat and in its hardest other landing.
        """
        from mechstyle.runs.report.page import write_report  # noqa: PLC0415 — loaded when a report is wanted

        return write_report(self, path, impact=impact)

    def export(self, path: str | Path, iteration: int | None = None, *, fields: bool = False, printing: Printing = AS_USUAL) -> Path:
        """Write the styled surface at an iteration to a file, and what is known of it to `FILE.json`.

        Args:
            path: The file; its suffix decides the format.
            iteration: None for the last.
            fields: Whether it is to hold stress, demand and every other known field at its vertices; in GLB and PLY.
            printing: Slicer and filaments of a 3MF file: `ms.Printing(palette="#111111, #f4f1e8", slicer="bambu")`.
        """
        for warning in self.exported(path, iteration, fields=fields, printing=printing).warnings:
            logger.warning("%s: %s", path, warning)
        return Path(path)

    def exported(self, path: str | Path, iteration: int | None = None, *, fields: bool = False, printing: Printing = AS_USUAL) -> Exported:
        """As `export`; returns verdict, quality and warnings of the very surface that was written."""
        entry = self.store.find(iteration, self.lane)
        what = self.store, self.lane, self.part, entry, Path(path)
        return exported(*what, name=self.record.name, fields=fields, printing=printing)

    def branch(self, iteration: int | None = None, *, lane: str = "", **changes: Any) -> Run:
        """A lane from the checkpoint of an iteration, with other settings; `.go()` carries it on.

        It is new unless the same was asked for before: that lane then goes on where it stopped.
        """
        entry = self.store.find(iteration, self.lane)
        recipe = changed(self.store.recipe(entry.recipe), changes)
        if recipe.schedule.iterations <= entry.iteration:
            raise BadInput(f"a branch at iteration {entry.iteration} must go beyond it, not to {recipe.schedule.iterations}: ask for more")
        with self.store.branching():
            images.keep(recipe, self.store)
            fork = Lane(recipe=self.store.put_recipe(recipe), head=entry.digest, forked_from=entry.digest)
            return Run(self.store, self.store.fork(fork, lane), self.device)

    def events(self, progress: Progress = no_progress) -> Generator[Event, None, None]:
        """Carry the lane on to its end, yielding what happens; the summary is written at the end.

        BadInput if another process, or another session of this one, is carrying it on.
        """
        with exclusive(self.store.root / "locks" / f"{self.lane}.lock", f"lane {self.lane!r} of {self.store.root}"):
            self.store.move(self.lane, msgspec.structs.replace(self.store.lane(self.lane), recipe=self.store.put_recipe(self.recipe)))
            with self.clock.stage("style target"):
                recipe, part = self.recipe, self.part
                stylizer, notes, enlarged = stylizer_for(part, recipe, self.device, self.store.objects, lambda: progress(0.0))
                bounds, protected = bounds_for(part, recipe)
                simulator = replace(self.simulator(recipe, progress), enlarged=enlarged)
                untangle = partial(untangled, part.surface, go_on=lambda: progress(0.0))
                notes = (*expected(recipe), *protected, *notes)
                engine = Engine(recipe, part.surface, bounds, stylizer, simulator, self.store, self.lane, untangle)
            with self.clock.stage("simulation of the unstylized part"):
                _ = engine.simulator.baseline
            for event in self.clock.timed(engine.run()):
                if isinstance(event, Finished):
                    files = {"run": str(self.store.root)}
                    relief, minimum = self.checkpoint().displacement, recipe.delivery.minimum_wall
                    notes = (*part.notes, *notes, *minimum_wall.warnings(part.surface, part.thickness, relief, minimum))
                    self._save(summarise(engine, device=self.device, notes=notes, seconds=self.clock.seconds(), files=files))
                yield event

    def go(self, on_event: OnEvent | None = None, progress: Progress = no_progress) -> Run:
        """Carry the lane on to its end."""
        with closing(self.events(progress)) as events:  # a listener that raises ends it at once
            for event in events:
                if on_event is not None:
                    on_event(event)
        return self

    def session(self) -> Session:
        """A background session that carries the lane on."""
        return Session(self.events)

    def add_files(self, files: dict[str, Path], notes: tuple[str, ...] = ()) -> Summary:
        """Name more files in the summary, and what a user should know of them."""
        known = self.summary
        named = {**known.files, **{what: str(path) for what, path in files.items()}}
        summary = msgspec.structs.replace(known, files=named, notes=tuple(dict.fromkeys((*known.notes, *notes))))
        self._save(summary)
        return summary

    def simulator(self, recipe: Recipe, progress: Progress = no_progress) -> DropSimulator:
        """The drop test of the part under a recipe."""
        part, shared = self.record.droppable(self.part, self.store.root / "part.json"), cached_memo() if self.trusting else None
        return DropSimulator(part, recipe, self.store.memo, shared, self.device, progress)

    @property
    def _summary_path(self) -> Path:
        return self.store.root / "summaries" / f"{self.lane}.json"

    def _save(self, summary: Summary) -> None:
        write_whole(self._summary_path, msgspec.json.format(to_json(summary), indent=2))


@dataclass(frozen=True, eq=False)
class Draft:
    """A run as it is asked for: `ready` prepares its part, `begin` makes its folder or finds it, and the run's `go` carries it on.

    Attributes:
        recipe: What is asked for, for any part, as `Draft.of` makes it of settings, or for this very one, as `ms.lab.plan` does.
        part: A closed surface [mm], z up, as it stands, or a part that is prepared.
        vertices: Of the standardised surface, where the part is to be prepared.
        name: What the part is called in pictures and files.
        folder: Run directory; None for one named by prompt and recipe under `mechstyle-runs`.
        device: `auto`, `cpu` or `cuda`.
        origin: Where a prepared part came from; a surface knows it itself.
        beside: Whether a folder that holds another run is left to that one for a folder beside it, `folder-2`, which is logged.
        clock: Seconds spent on it in this process.

    Example:
        >>> knob = ms.load("gallery:drawer_knob")
        >>> run = ms.lab.Draft.of(knob, "brick", vertices=500, iterations=4, folder="runs/knob", device="cpu").begin().go()
        >>> ms.lab.Draft(run.recipe, run.part, folder="runs/knob", device="cpu").begin().finished
        True
    """

    recipe: Recipe
    part: SurfaceMesh | Workpiece
    vertices: int = STANDARD_VERTICES
    name: str = "part"
    folder: str | Path | None = None
    device: str = "auto"
    origin: Origin = field(default_factory=Origin)
    beside: bool = True
    clock: Clock = field(default_factory=Clock, repr=False)

    @classmethod
    def of(
        cls, part: SurfaceMesh | Workpiece, prompt: str = "", material: str | Material = "PLA", *,
        freestyle: bool = False, vertices: int = STANDARD_VERTICES, name: str = "part", folder: str | Path | None = None,
        device: str = "auto", **settings: Any,
    ) -> Draft:  # fmt: skip
        """A draft of settings, as `ms.stylize` takes them; BadInput if they cannot be used, before anything slow is done."""
        recipe = recipe_for(prompt, material, freestyle=freestyle, **settings)
        return cls(recipe, part, check_vertices(vertices), name, folder, device)

    def place(self, recipe: Recipe) -> Path:
        """The folder of a run of this recipe; BadInput if it holds something else than a run, or another and `beside` is False."""
        return folder_for(default_folder(recipe) if self.folder is None else Path(self.folder), recipe, beside=self.beside)

    def ready(
        self, *, stage: Stage = no_progress, prepare: Callable[..., Workpiece] = prepare, warn: Warn | None = None,
        go_on: CancelCheck = never_cancel, shown: Callable[[Path], None] | None = None,
    ) -> Draft:  # fmt: skip
        """This draft with its part prepared: thickened first, if the recipe asks for it, with tetrahedra that carry the style's relief.

        Args:
            stage: Called with what is being done, in words.
            prepare: What prepares a surface, `simulation.part.prepare` or one like it.
            warn: What takes sentences on thin walls; None for none.
            go_on: Asked in between whether to; what it raises ends the work.
            shown: Called with the path of a picture of the finished style, written before the minutes that tetrahedra may take.

        Raises:
            BadInput: If the part, a region or a load cannot be used, or the folder is another run's.
        """
        if self.folder is not None:
            check_free(Path(self.folder), self.recipe, beside=self.beside)
        device = resolve_device(self.device)
        origin = Origin.of(self.part, self.vertices) if isinstance(self.part, SurfaceMesh) else self.origin
        if warn is not None:
            prepare = partial(prepare, measured=partial(self._measured, warn))
        with self.clock.stages(stage) as begun:
            relief = partial(_relief, self.recipe, None if shown is None else partial(self._pictured, shown))
            part = self._prepared(device, relief, begun, prepare, go_on)
        return replace(self, recipe=fitted(self.recipe, part), part=part, device=device, origin=origin)

    def begin(self) -> Run:
        """A run directory for it: new, or an earlier one of the same recipe, which then goes on where it stopped.

        A part that is a surface is made ready first, one that is prepared is taken as it is. The earlier run keeps its tetrahedra:
        those of a part that was meshed anew are others, without anything else being other.

        Raises:
            BadInput: If the folder holds something else than a run; if it holds another run and `beside` is False.
        """
        if not isinstance(self.part, Workpiece):
            return self.ready().begin()
        recipe = fitted(self.recipe, self.part)
        store = Store(self.place(recipe))
        run = Run(store, "main", resolve_device(self.device), self.clock)
        if "main" in store.lanes():
            return run
        images.keep(recipe, store)
        record = PartRecord.kept(self.part, self.name, self.origin, store.objects)
        write_whole(store.root / "part.json", msgspec.json.encode(record))
        store.move("main", Lane(recipe=store.put_recipe(recipe)))
        vars(run)["part"] = self.part  # as stored, and what was worked out of it need not be again
        return run

    def _prepared(
        self, device: str, relief: Relief, stage: Stage, prepare: Callable[..., Workpiece], go_on: CancelCheck
    ) -> Workpiece:  # fmt: skip
        """The part made ready; one that was thickened before is not thickened again."""
        thicker, rough, before = None, self.part, isinstance(self.part, Workpiece) and self.part.mass_gained > 0.0
        if self.recipe.delivery.strengthen and not before:
            thicker = strengthened(self.part, self.recipe, vertices=self.vertices, device=device, stage=stage, prepare=prepare, go_on=go_on)
            rough = thicker.result
        if isinstance(rough, Workpiece):
            part = refilled(rough, relief, stage, go_on)
        else:
            part = prepare(rough, vertices=self.vertices, stage=stage, relief=relief, go_on=go_on)
        return part if thicker is None else thicker.noted(part)

    def _pictured(self, shown: Callable[[Path], None], surface: SurfaceMesh, style: FinishedStyle) -> None:
        """Write a picture of the finished style into the folder that the run will have."""
        folder = self.place(self.recipe.on(surface=surface.digest, tetrahedra=""))
        look = styled_panel(surface.displaced(style.relief).coloured(style.colour), self.recipe)
        shown(picture([look], title=self.name).save(folder / STYLED))

    def _measured(self, warn: Warn, shape: Shape) -> None:
        """Warn of a part's walls, and refuse the folder of another part's run, before the minutes that tetrahedra may take."""
        warn(shape.too_thin(self.recipe.delivery.minimum_wall))
        if self.folder is not None and not self.recipe.delivery.strengthen:  # which gives another surface
            check_free(Path(self.folder), self.recipe.on(surface=shape.surface.digest), beside=self.beside)


def _relief(
    recipe: Recipe, pictured: Callable[[SurfaceMesh, FinishedStyle], None] | None, shape: Workpiece | Shape, *, go_on: CancelCheck
) -> Field | None:
    """The finished relief of a style [mm], shape [vertex_count]; a function of the module, which goes to a process that prepares a part."""
    style = finished_style(shape, recipe, go_on)
    if style is not None and pictured is not None:
        pictured(shape.surface, style)
    return None if style is None else style.relief


def stylize(
    mesh: SurfaceMesh, prompt: str = "", *,
    material: str | Material = "PLA", freestyle: bool = False, quick: bool = False, vertices: int | None = None,
    out: str | Path | None = None, name: str = "part", device: str = "auto", stage: Stage = no_progress, on_event: OnEvent | None = None,
    **settings: Any,
) -> Run:  # fmt: skip
    """Style a part while a drop test watches its strength.

    Args:
        mesh: A closed surface [mm], z up, as it stands.
        prompt: The style, in words: "brick", "small blue stones". With a picture (`image`) it says where and in what colour, if anything.
        material: A library name, a .toml/.json file, or a Material.
        freestyle: Whether to stylize without feedback.
        quick: Whether to take fewer vertices, for a first answer in about a minute.
        vertices: Vertices of the standardised surface; by default STANDARD_VERTICES, or QUICK_VERTICES of a quick run.
        out: Run directory; by default one named by prompt and recipe under `mechstyle-runs`. The same recipe goes on where it stopped,
            another one goes into a folder beside it: see the run's `store.root`.
        name: What the part is called in pictures and files.
        device: `auto`, `cpu` or `cuda`.
        stage: Called with what is being prepared, in words.
        on_event: Called with every event.
        settings: Settings of a recipe, such as control, schedule, iterations, criterion, protect=["inside", ms.Box(low, high, ramp=2)],
            image (a PNG or JPEG file, or an array), stylizer (a registered name, or a function as docs/plug-in.md shows).

    Returns:
        The finished run.

    Raises:
        BadInput: If the part, the prompt or a setting cannot be used, in one sentence.

    Example:
        >>> knob = ms.load("gallery:drawer_knob")
        >>> run = ms.stylize(knob, "brick", vertices=500, iterations=4, out="runs/knob", device="cpu")
        >>> run.verdict.outcome
        'HOLDS'
    """
    check_known(stylize, settings, SETTINGS)
    vertices = (QUICK_VERTICES if quick else STANDARD_VERTICES) if vertices is None else vertices
    wanted = Draft.of(mesh, prompt, material, freestyle=freestyle, vertices=vertices, name=name, folder=out, device=device, **settings)
    logged(idle(settings, wanted.recipe))
    return wanted.ready(stage=stage, warn=logged).begin().go(on_event)
