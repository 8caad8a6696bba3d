"""The state shared by the Studio's widgets: run, lane, iteration, progress.

Pure traitlets, no widget. The worker thread of a session never touches a trait: what it has to say is noted down and
carried over by `pump`, on the kernel's own event loop, at most ten times a second, the latest word on each trait winning.
Pages are heard on that loop, too (`jupyter.one_thread`).
"""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import traitlets

from mechstyle.errors import MechStyleError
from mechstyle.loop.engine import Checkpointed, Corrected, Event, Finished, SimulationStarted, Stylized
from mechstyle.loop.history import Branch, Row, lanes, per_iteration, rows
from mechstyle.loop.store import Store
from mechstyle.records import Checkpoint, Simulation
from mechstyle.runs.run import Run
from mechstyle.runs.session import Session
from mechstyle_widgets.jupyter.language import speaking, spoken, word
from mechstyle_widgets.jupyter.throttle import running_loop
from mechstyle_widgets.state.time_left import Stopwatch
from mechstyle_widgets.state.troubles import sentence

STATUSES = ("idle", "preparing", "running", "paused", "stopped", "finished", "failed")
SHORTEST_WAIT = 0.1  # between two updates of what is shown [s]
KEPT = 12  # checkpoints in memory; one of 25k vertices is about 1 MB
OF_A_RUN = ("layer", "pinned", "falls")
"""Traits that mean something in the run they belong to, in the order in which they are set."""
ASKED = ("settings", "part")
"""What the user asks for: a message about it ends when it changes."""
PLACE = ("lane", "iteration", "run", "status")
"""What a message about something that cannot be done here and now ends with, too."""


class StudioState(traitlets.HasTraits):
    """The shown run, lane and iteration, and the progress of the session that carries it on.

    Attributes:
        run: The run on show, opened at `lane`; None before there is one.
        session: The session that carries it on, or the last one that did.
        lane: Name of the lane on show.
        iteration: Iteration on show; may be set to any that `history` holds.
        iterations_done: Newest iteration of the lane.
        follow: Whether `iteration` moves on with the run; so it does until an earlier one is chosen.
        checkpoint: The newest checkpoint of `iteration` in `lane`, read from the store; None before there is one.
        history: The newest `Row` of each iteration of the lane, oldest first.
        histories: The same for every lane, by its name.
        branches: One `Branch` for each lane.
        status: One of STATUSES.
        pausing: Whether a pause was asked for that waits for what is in hand.
        stage: What is being done, in words; "" while nothing is.
        fraction: How much of the run is done, 0 to 1.
        step: How much of the drop test in hand is done, 0 to 1.
        seconds_left: Estimate of what is left of it [s], None while there is none.
        message: One sentence for the user: what went wrong, or what to do next. It is gone as soon as what it is about has changed.
        alarming: Whether it says that something did not work.
        layer: Name of the viewer's layer on show.
        pinned: Lane and iteration that what is on show is compared with, None for none.
        third: Lane and iteration that stand beside those two, None for none.
        settings: Fields of the recipe that the next run is to have.
        part: Name of the part that the next run is of.
        title: What the run on show is called: its part and its style; "" before there is one.
        outlook: What test the next run has and how long it will take, in one sentence; "" while that is not known.
        expected: How long that is [s], 0 while it is not known.
        another: Whether what is asked for is another run than the one on show, which is then the last one.
        falls: Counts the comparisons whose fall is to be played once.
        calm: Whether the system asks that nothing moves by itself.
        price: What filament costs per kg, 0 for no cost.
    """

    run = traitlets.Instance(Run, None, allow_none=True)
    session = traitlets.Instance(Session, None, allow_none=True)
    lane = traitlets.Unicode("main")
    iteration = traitlets.Int(0)
    iterations_done = traitlets.Int(0)
    follow = traitlets.Bool(True)
    checkpoint = traitlets.Instance(Checkpoint, None, allow_none=True)
    history = traitlets.List(traitlets.Instance(Row))
    histories = traitlets.Dict()
    branches = traitlets.List(traitlets.Instance(Branch))
    status = traitlets.Enum(STATUSES, "idle")
    pausing = traitlets.Bool(False)
    stage = traitlets.Unicode("")
    fraction = traitlets.Float(0.0)
    step = traitlets.Float(0.0)
    seconds_left = traitlets.Float(None, allow_none=True)
    message = traitlets.Unicode("")
    alarming = traitlets.Bool(False)
    layer = traitlets.Unicode("style")
    pinned: Any = traitlets.Tuple(None, allow_none=True)
    third: Any = traitlets.Tuple(None, allow_none=True)
    settings = traitlets.Dict()
    part = traitlets.Unicode("")
    title = traitlets.Unicode("")
    outlook = traitlets.Unicode("")
    expected = traitlets.Float(0.0)
    another = traitlets.Bool(False)
    falls = traitlets.Int(0)
    calm = traitlets.Bool(False)
    price = traitlets.Float(0.0)
    _ends_with: tuple[str, ...] = ASKED
    _language = ""

    def __init__(self, run: Run | None = None, **traits: Any) -> None:
        """Look at a run, if there is one; made in a cell, it learns the kernel's event loop by itself."""
        super().__init__(**traits)
        self._language = spoken()
        self._lock = threading.Lock()
        self._noted: dict[str, Any] = {}
        self._stale, self._due, self._pumped = False, False, 0.0
        self._loop = running_loop()
        self._opened: Run | None = None
        self._watch, self._iterations, self._foretold = Stopwatch(), 1, 0.0
        self._last = ("", -1)  # digest and iteration of the newest checkpoint of the session
        self._seconds: dict[str, float] = {}
        self._rows: dict[str, Row] = {}
        self._read = lru_cache(maxsize=KEPT)(Store.checkpoint)
        self._tested = lru_cache(maxsize=KEPT)(lambda store, digest: store.objects.get_record(digest, Simulation))
        if run is not None:
            self.open(run)

    # what went wrong

    def refuse(self, words: str) -> None:
        """Say what cannot be done here and now, in one sentence."""
        self.message, self.alarming, self._ends_with = words, True, (*ASKED, *PLACE)

    def alert(self, error: BaseException) -> None:
        """Say what an error of a handler means."""
        self.refuse(sentence(error, None if self.run is None else self.run.store.place))

    def notify_change(self, change: Any) -> None:
        """Let nobody's error in hearing of a change end in a log only, and be heard in the language of those who follow it."""
        with speaking(self._language or spoken()):
            try:
                super().notify_change(change)
            except Exception as error:  # noqa: BLE001 — whatever it is, it is said
                self.alert(error)

    @traitlets.observe("message")
    def _said(self, _change: object) -> None:
        self.alarming, self._ends_with = False, ASKED

    @traitlets.observe(*ASKED, *PLACE)
    def _outlived(self, change: dict[str, Any]) -> None:
        if change["name"] in self._ends_with:
            self.message = ""

    @property
    def seconds_of_a_test(self) -> float | None:
        """Mean time of the tests on the way of the lane on show, as far as they were made here [s]; None if none was."""
        tested = [row for row in self.history if row.verdict is not None and 0 < row.iteration < self.length]
        taken = [row.seconds for row in tested if row.seconds is not None]
        return sum(taken) / len(taken) if taken else None

    # what is on show

    def called(self, lane: str) -> str:
        """What people call a lane: Freestyle, MechStyle, or its own name."""
        return called(self.branches).get(lane, lane)

    @property
    def busy(self) -> bool:
        """Whether a session is under way, be it paused."""
        return self.session is not None and self.session.state in ("running", "paused")

    def headed(self, title: str) -> str:
        """The heading of a run's views while other settings are chosen, "" while they are its own."""
        return f"{'This' if self.busy else 'Last'} run: {title}" if self.another else ""

    @property
    def length(self) -> int:
        """Iterations that the lane on show is to have."""
        return self.end_of(self.lane)

    def end_of(self, lane: str) -> int:
        """The same of any lane; 1 where it is not there."""
        return next((branch.iterations for branch in self.branches if branch.lane == lane), 1)

    def open(self, run: Run, *, follow: bool = True) -> None:
        """Show a lane of a run, opened at that lane, at its newest iteration, or without `follow` at the one on show."""
        self._take(run, follow=follow)
        if not self.busy:  # while nothing is going on, the status is that of the lane on show
            self.status = "idle" if not self.history else "finished" if run.finished else "stopped"  # it may have ended since it was read
            self.fraction = self.iterations_done / run.recipe.schedule.iterations
            self.message = ""

    def row(self, iteration: int | None = None, lane: str = "") -> Row | None:
        """Row of an iteration of a lane, by default the current ones; None if it is not there."""
        wanted = self.iteration if iteration is None else iteration
        return next((row for row in self.histories.get(lane or self.lane, []) if row.iteration == wanted), None)

    def checkpoint_at(self, iteration: int, lane: str = "") -> Checkpoint | None:
        """The newest checkpoint of an iteration, from memory or from the store; None if it is not there."""
        row = self.row(iteration, lane)
        return None if row is None or self.run is None else self._read(self.run.store, row.digest)

    def simulation(self, store: Store, checkpoint: Checkpoint) -> Simulation:
        """The last simulation of a checkpoint, from memory or from the store; from any thread."""
        return self._tested(store, checkpoint.simulation)

    @traitlets.validate("iteration")
    def _within_reach(self, proposal: dict[str, Any]) -> int:
        """The nearest iteration of the lane; the one on show where that cannot be read any more, which is said."""
        wanted = max(0, min(proposal["value"], self.iterations_done))
        if wanted == self.iteration or self.run is None:
            return wanted
        try:
            self.run.store.lane(self.lane)  # what was read before is still in memory once its folder is gone
            self.checkpoint_at(wanted)
        except Exception as error:  # noqa: BLE001 — whatever it is, it is said
            self.alert(error)
            return self.iteration
        return wanted

    @traitlets.validate("lane")
    def _there(self, proposal: dict[str, Any]) -> str:
        if self.run is not None and proposal["value"] != self.lane:
            self.run.store.lane(proposal["value"])  # refuses a lane that is not there
        return proposal["value"]

    def go_to(self, lane: str, iteration: int | None = None) -> None:
        """Show a lane, and perhaps another iteration of it; what cannot be shown is said."""
        try:
            self.lane = lane
        except MechStyleError as error:
            self.alert(error)
            return
        if iteration is not None:
            self.iteration = iteration

    @traitlets.observe("lane")
    def _other_lane(self, change: dict[str, Any]) -> None:
        if self.run is not None and self.run.lane != change["new"]:
            self.open(Run(self.run.store, change["new"], self.run.device), follow=self.follow)

    @traitlets.observe("iteration")
    def _other_iteration(self, _change: object) -> None:
        self.follow = self.iteration >= self.iterations_done
        self.checkpoint = self.checkpoint_at(self.iteration)

    def _take(self, run: Run, *, follow: bool) -> None:
        """Set the run and all that follows from it at once, so that who hears of any of it finds it whole; nothing if it is damaged."""
        store, thickness = run.store, run.part.thickness
        past: dict[str, list[Row]] = {}
        for name in store.lanes():
            past[name] = rows(store, name, known=self._rows, thickness=thickness, seconds=self._seconds)
            self._rows.update((row.digest, row) for row in past[name])
        histories, branches = {name: per_iteration(history) for name, history in past.items()}, lanes(store, past)
        history = histories.get(run.lane, [])
        done = history[-1].iteration if history else 0
        iteration = done if follow else min(self.iteration, done)
        shown = next((self._read(store, row.digest) for row in history if row.iteration == iteration), None)
        with self.hold_trait_notifications():
            self.follow, self.run, self.lane = follow, run, run.lane
            self.title = titled(run.record.name, run.recipe.style.prompt)
            self.history, self.histories, self.branches = history, histories, branches
            self.iterations_done, self.iteration, self.checkpoint = done, iteration, shown

    # what is going on

    def watch(self, session: Session, iterations: int, foretold: float = 0.0) -> Session:
        """Follow a session that is about to start, and return it: every event and every change of its state is brought here.

        Its lane is to end at `iterations`; `foretold` is how long it will take, by an estimate [s], 0 where there is none.
        """
        self.message = ""
        self.session, self._iterations, self._foretold = session, iterations, foretold
        self._watch, self._last = Stopwatch(), ("", -1)
        session.listen(lambda event: self._hear(event) if session is self.session else None)

        def changed(state: str) -> None:
            """In whatever thread the session changed its state."""
            if session is not self.session:
                return
            self._watch.run() if state == "running" else self._watch.pause()
            if state == "failed":
                self.tell(message=sentence(session.error, None if self.run is None else self.run.store.place), alarming=True)
            if state != "running":
                self.tell(stage="", seconds_left=None)
            self.tell(status="idle" if state == "ready" else state, pausing=False)

        session.watch(changed)
        return session

    def tell(self, *, stale: bool = False, opened: Run | None = None, **traits: Any) -> None:
        """Note what traits are to become, from any thread; those of `OF_A_RUN` when the opened run is shown.

        `stale` says that the store holds more than is shown, `opened` is a run to show from now on.
        """
        with self._lock:
            self._noted.update(traits)
            self._stale |= stale
            self._opened = opened or self._opened
            if self._due or self._loop is None:
                return
            self._due = True
        loop = self._loop
        # at most ten times a second
        loop.call_soon_threadsafe(lambda: loop.call_later(max(0.0, self._pumped + SHORTEST_WAIT - time.monotonic()), self.pump))

    def pump(self) -> None:
        """Carry over what was noted; the kernel's event loop calls it, in plain Python whoever wants to see the news does."""
        with self._lock:
            noted, self._noted = self._noted, {}
            stale, self._stale, self._due = self._stale, False, False
            opened, self._opened = self._opened, None
        of_it = {name: noted.pop(name) for name in OF_A_RUN if name in noted}
        for name, value in noted.items():
            setattr(self, name, value)
        try:
            if opened is not None:
                self.open(opened)
            elif stale and self.run is not None:
                self._take(self.run, follow=self.follow)
            for name, value in of_it.items():
                setattr(self, name, value)
        except Exception as error:  # noqa: BLE001 — the event loop would keep it to itself
            shown = opened or self.run
            self.refuse(sentence(error, None if shown is None else shown.store.place))
        self._pumped = time.monotonic()  # what takes long leaves the loop as much time for others

    def _hear(self, event: Event) -> None:
        """In the worker thread: what an event means for the traits."""
        if isinstance(event, Stylized):
            self.tell(status="running", stage="stylizing", **self.left_as_foretold())
        elif isinstance(event, SimulationStarted):
            self.tell(status="running", stage=f"drop test: {event.reason}", step=0.0, **self.left_as_foretold())
        elif isinstance(event, Corrected):
            self.tell(stage=f"correcting: {event.step}")
        elif isinstance(event, Checkpointed):
            self._count(event)
            self.tell(stale=True, fraction=event.checkpoint.iteration / self._iterations)
        elif isinstance(event, Finished):
            self.tell(fraction=1.0, seconds_left=None)

    def _count(self, event: Checkpointed) -> None:
        """Record the time a checkpoint took; those that share an iteration, as corrections do, add up."""
        made, seconds = event.checkpoint, self._watch.lap()
        if (made.parent, made.iteration) == self._last:
            self._seconds[event.digest] = seconds + self._seconds[made.parent]
        else:
            self._seconds[event.digest] = seconds
        self._last = (event.digest, made.iteration)

    def left_as_foretold(self) -> dict[str, Any]:
        """Time left by the estimate of before, from any thread; nothing once more has passed."""
        left = self._foretold - self._watch.total
        return {"seconds_left": left if left > 0.0 else None} if self._foretold else {}


class Linked(traitlets.HasTraits):
    """A view of a state; mixed into a widget. Its lane and iteration are those of the state."""

    lane = traitlets.Unicode("main")
    iteration = traitlets.Int(0)
    _links: tuple[str, ...] = ()

    def link(self, state: StudioState, *names: str) -> None:
        """Let lane, iteration and the given traits be those of a state, both ways, until `unlink`."""
        self._state, self._links = state, ("lane", "iteration", *names)
        for name in self._links:
            self._hear_state({"name": name})
        state.observe(self._hear_state, self._links)
        self.observe(self._tell_state, self._links)

    def unlink(self) -> None:
        """Undo `link`."""
        if self._links:
            self._state.unobserve(self._hear_state, self._links)
            self.unobserve(self._tell_state, self._links)
        self._links = ()

    def _hear_state(self, change: Any) -> None:
        setattr(self, change["name"], getattr(self._state, change["name"]))  # it may have gone on since

    def _tell_state(self, change: Any) -> None:
        try:
            setattr(self._state, change["name"], change["new"])
        finally:  # it may not have gone there
            self._hear_state(change)


def titled(part: str, prompt: str) -> str:
    """What a run is called: its part and its style, in the language spoken."""
    return ", ".join(word(name) for name in (part.replace("_", " "), prompt.replace("_", " ")) if name)


FREE = "freestyle"
"""Lane of the whole style, which nothing holds back, beside the lane on show."""


def called(branches: Sequence[Branch]) -> dict[str, str]:
    """What people call the lanes of a run: what was begun by itself Freestyle or MechStyle, others by their names."""
    own = {branch.lane: "Freestyle" if branch.recipe.restraint.control == "none" else "MechStyle" for branch in branches}
    return {lane: name if lane in ("main", FREE) else lane for lane, name in own.items()}
