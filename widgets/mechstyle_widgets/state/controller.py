"""Controller of runs: begin, carry on, pause, step, stop, branch. It changes the state and nothing on screen."""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import replace
from pathlib import Path
from typing import Any

from mechstyle.errors import BadInput
from mechstyle.fea.drop import resolve_device
from mechstyle.fea.explicit import Progress
from mechstyle.loop.engine import Checkpointed, Event
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.runs.recipes import FREESTYLE
from mechstyle.runs.run import Draft, Run
from mechstyle.runs.session import Session
from mechstyle.simulation.part import Origin, Workpiece
from mechstyle_widgets.jupyter.prepare import prepare_in_worker
from mechstyle_widgets.state.opening import of_ones_own
from mechstyle_widgets.state.studio_state import FREE, StudioState
from mechstyle_widgets.state.troubles import gone, sentence

STOPPING = "the run is being stopped: go on with it when what is in hand has ended"
ENDED = "the run has just ended: see what came of it before you go on"


class Controller:
    """Carries out what people ask for, in the background; what cannot be done is said in `state.message`."""

    def __init__(self, state: StudioState, wanted: Callable[[], Draft]) -> None:
        """Begin and carry on runs; `wanted` is asked for the settings when one is begun, and may raise BadInput."""
        self.state, self.wanted = state, wanted
        self._begun: dict[Path, tuple[str, int, float]] = {}  # by the folders of the runs begun here: what tells their parts

    # what the buttons do

    def run(self) -> None:
        """Go on to the end: what is paused or unfinished if the settings are still its own, else a new run; what is paused ends for it."""
        self._with_session(lambda session: session.run())

    def both(self) -> None:
        """Go on to the end as `run` does, then stylize the same part freely, and show the two side by side."""
        self._with_session(lambda session: session.run(), then_freely=True)

    def step(self) -> None:
        """Go on to the next checkpoint, then pause."""
        self._with_session(lambda session: session.run_until(lambda event: isinstance(event, Checkpointed)))

    def step_to_simulation(self) -> None:
        """Go on to the next checkpoint that was simulated, then pause."""

        def simulated(event: Event) -> bool:
            return isinstance(event, Checkpointed) and event.checkpoint.simulated_at == event.checkpoint.iteration > 0

        self._with_session(lambda session: session.run_until(simulated))

    def pause(self) -> None:
        """Pause after the event in hand, until when the state says that it is going to."""
        session = self.state.session
        if session is not None and session.state == "running":
            self.state.tell(pausing=True)
            session.pause()
            if session.wait(0.0) != "running":  # it was over before it heard of it
                self.state.tell(pausing=False)
            self.state.pump()

    def stop(self) -> None:
        """End the work; what was checkpointed is kept, and running again goes on from there."""
        if self.busy and self.state.session is not None:
            self.state.session.stop()

    def branch(self, iteration: int, lane: str = "", say: Callable[[str], None] | None = None, **changes: Any) -> None:
        """Begin a new lane at an iteration of the lane on show, with other settings, and carry it on.

        What cannot be done is said to `say`, by default in the state. A lane without a name has the next number.
        """
        run, say = self.state.run, say or self.state.refuse
        if run is None:
            say("there is no run to branch from yet: run something first")
        elif self.busy:
            say("a run is going on: stop it before you branch")
        else:
            self._tried(lambda: self._carry_on(of_ones_own(run).branch(iteration, lane=lane, **changes)).run(), say)

    @property
    def busy(self) -> bool:
        """Whether a session is under way, be it paused."""
        return self.state.busy

    def differs(self) -> dict[str, Any]:
        """Settings that are not those of the lane on show, by name; BadInput if the settings cannot be used."""
        run = self.state.run
        return {} if run is None else {name: value for name, _, value in run.recipe.differences(self.wanted().recipe)}

    def asks_for_another(self) -> bool:
        """Whether the settings ask for another run than the one on show; BadInput if they cannot be used."""
        wanted, run = self.wanted(), self.state.run
        return run is None or self.gone or not self._of_the_same_part(wanted) or bool(run.recipe.differences(wanted.recipe))

    @property
    def gone(self) -> bool:
        """Whether the folder of the run on show is gone."""
        return self.state.run is not None and not self.state.run.store.place.is_dir()

    def began_with(self, mesh: SurfaceMesh) -> int | None:
        """Vertices with which the run on show was begun here of a part, whatever the settings are now; None if it was not."""
        begun = None if self.state.run is None else self._begun.get(self.state.run.store.place)
        return begun[1] if begun is not None and begun[0] == mesh.digest else None

    # how it does it

    def _with_session(self, act: Callable[[Session], None], *, then_freely: bool = False) -> None:
        def acted() -> None:
            session = self._session(then_freely=then_freely)
            try:
                act(session)
            except RuntimeError as error:  # it ended, or was asked to, and has not heard of it yet
                raise BadInput(STOPPING if session.state in ("running", "paused") else ENDED) from error

        self._tried(acted)

    def _tried(self, act: Callable[[], None], say: Callable[[str], None] | None = None) -> None:
        try:
            act()
        except Exception as error:  # noqa: BLE001 — whatever it is, it is said
            folder = None if self.state.run is None else self.state.run.store.place
            (say or self.state.refuse)(sentence(error, folder))

    def _session(self, *, then_freely: bool = False) -> Session:
        """The session under way, or a new one for what is wanted, which may stylize the part freely afterwards."""
        session = self.state.session
        if not self.busy or session is None:
            return self._new_session(then_freely)
        self.state.pump()  # what was begun a moment ago may not be on show yet
        if session.state != "paused" or not self.asks_for_another():
            return session
        left, new = self.state.run, self._new_session(then_freely)  # is refused, or is what the state follows from here on
        session.stop()
        session.wait()  # at a pause nothing is in hand: what is left is left at once
        self.state.message = f"the run that was paused is kept in {left.store.root}: open it to go on with it" if left is not None else ""
        return new

    def _new_session(self, then_freely: bool) -> Session:
        """A session that begins what is wanted, or carries it on if it is what is on show."""
        state, wanted = self.state, self.wanted()
        if then_freely and wanted.recipe.restraint.control == "none":
            raise BadInput("this is Freestyle already: choose MechStyle under Restraint to see one beside the other")
        same_part = self._of_the_same_part(wanted)
        if state.run is None or self.gone or not same_part or state.run.recipe.differences(wanted.recipe):
            return self._begin(wanted, state.run if same_part else None, then_freely=then_freely)
        if state.run.finished and not then_freely:
            raise BadInput("this lane is finished: change a setting to begin another run, or branch from an earlier iteration")
        return self._carry_on(state.run, then_freely=then_freely)

    def _of_the_same_part(self, draft: Draft) -> bool:
        run = self.state.run
        return isinstance(draft.part, Workpiece) or (run is not None and self._begun.get(run.store.place) == _part_of(draft))

    def _begin(self, draft: Draft, earlier: Run | None, *, then_freely: bool = False) -> Session:
        """A session that prepares the part, unless an earlier run has it, begins the run and carries it on."""
        asked, draft = _part_of(draft), replace(draft, device=resolve_device(draft.device))  # refused at once, not in the session
        if earlier is not None:
            if earlier.part.mass_gained and not self.gone and draft.recipe.delivery.strengthen != earlier.recipe.delivery.strengthen:
                raise BadInput("the part of this run was thickened already: to thicken it otherwise choose the plain part again")
            draft = replace(draft, part=earlier.part, origin=Origin() if self.gone else earlier.record.origin)

        def events(progress: Progress) -> Generator[Event, None, None]:
            self.state.tell(status="preparing", fraction=0.0)

            def waits() -> None:
                self.state.tell(**self.state.left_as_foretold())
                progress(0.0)

            run = draft.ready(stage=lambda words: self.state.tell(stage=words), prepare=prepare_in_worker, go_on=waits).begin()
            self._begun[run.store.place] = asked
            self.state.tell(opened=run)
            if draft.folder is not None and run.store.place != Path(draft.folder).absolute():
                self.state.tell(message=f"{draft.folder} holds a run with other settings: this one is in {run.store.root}")
            yield from self._told(run, progress, then_freely=then_freely)

        return self.state.watch(Session(events), draft.recipe.schedule.iterations, self.state.expected)

    def _carry_on(self, run: Run, *, then_freely: bool = False) -> Session:
        self.state.open(run)
        session = Session(lambda progress: self._told(run, progress, then_freely=then_freely))
        return self.state.watch(session, run.recipe.schedule.iterations)

    def _told(self, run: Run, progress: Progress, *, then_freely: bool) -> Generator[Event, None, None]:
        """The events of a run, and of its free twin if that is to follow; and how far a drop test has come."""
        if not run.finished:
            yield from self._events(run, progress)
        if then_freely:
            free = run.branch(0, lane=FREE, **FREESTYLE)
            if not free.finished:
                self.state.tell(opened=free, fraction=0.0)
                yield from self._events(free, progress)
            self.state.tell(opened=run, pinned=(free.lane, free.recipe.schedule.iterations), layer="stress", falls=self.state.falls + 1)

    def _events(self, run: Run, progress: Progress) -> Generator[Event, None, None]:
        self.state.tell(stage="drawing the style, simulating the unstylized part", step=0.0)

        def on_fraction(fraction: float) -> None:
            self.state.tell(step=fraction, **self.state.left_as_foretold())
            progress(fraction)

        try:
            yield from run.events(on_fraction)
        except Exception as error:
            if run.store.place.is_dir():
                raise
            raise BadInput(gone(run.store.place)) from error


def _part_of(draft: Draft) -> tuple[str, int, float]:
    """What tells the part of a draft from others, whatever becomes of it: its surface, how fine it is and how far it may be thickened."""
    surface = draft.part.surface if isinstance(draft.part, Workpiece) else draft.part
    return surface.digest, draft.vertices, draft.recipe.delivery.strengthen
