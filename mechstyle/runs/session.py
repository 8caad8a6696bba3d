"""A run in the background: a worker thread carries the engine on, listeners hear its events, people pause, step and stop it."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Generator
from contextlib import closing
from typing import Literal

from mechstyle.fea.explicit import Progress
from mechstyle.loop.engine import Event, Simulated

State = Literal["ready", "running", "paused", "stopped", "finished", "failed"]
Listener = Callable[[Event], None]
Watcher = Callable[[State], None]

logger = logging.getLogger(__name__)


class Stopped(Exception):
    """Raised inside a simulation that was asked to stop; what was checkpointed before is kept."""


class Session:
    """Pumps a generator of events in a worker thread.

    Pausing and stopping act between two events, stopping also inside a drop test, between two chunks of time steps. What was asked to
    stop stops, whatever is asked of it afterwards. A listener that
    raises is logged and dropped for that event; it never stops the run. Whatever happens, the run on disk stands at its
    last checkpoint, from which a new session goes on.
    """

    def __init__(self, events: Callable[[Progress], Generator[Event, None, None]]) -> None:
        """Prepare to pump `events(progress)`; `progress` must be passed on to the simulator, so that stopping can reach it."""
        self._events = events
        self._listeners: list[Listener] = []
        self._watchers: list[Watcher] = []
        self._changed = threading.Condition()
        self._state: State = "ready"
        self._wanted: Literal["run", "pause", "stop"] = "pause"
        self._until: Callable[[Event], bool] | None = None
        self._thread: threading.Thread | None = None
        self.error: BaseException | None = None
        self.fraction = 0.0

    @property
    def state(self) -> State:
        """ready, running, paused, stopped, finished or failed."""
        return self._state

    def listen(self, listener: Listener) -> Callable[[], None]:
        """Call `listener` with every event, in the worker thread; returns a function that ends it."""
        self._listeners.append(listener)
        return lambda: self._listeners.remove(listener) if listener in self._listeners else None

    def watch(self, watcher: Watcher) -> None:
        """Call `watcher` with every state the session comes to, at once and in whatever thread brought it there; it must not wait."""
        self._watchers.append(watcher)

    def run(self) -> None:
        """Start, or go on after a pause."""
        self._go(None)

    def step(self) -> None:
        """Go on to the next event, then pause."""
        self._go(lambda _: True)

    def step_to_simulation(self) -> None:
        """Go on until a simulation has ended, then pause."""
        self._go(lambda event: isinstance(event, Simulated))

    def run_until(self, reached: Callable[[Event], bool]) -> None:
        """Go on until an event for which `reached` holds, then pause."""
        self._go(reached)

    def pause(self) -> None:
        """Pause after the event in hand."""
        self._want("pause")

    def stop(self) -> None:
        """End the run after the event in hand, a drop test within a fraction of a second; its checkpoints stay."""
        self._want("stop")
        with self._changed:
            if self._thread is None:
                self._become("stopped")

    def wait(self, timeout: float | None = None) -> State:
        """Wait until the session pauses or ends, at most `timeout` [s]; the state it is in then."""
        with self._changed:
            self._changed.wait_for(lambda: self._state != "running" and (self._state != "paused" or self._wanted == "pause"), timeout)
        return self._state

    def _go(self, until: Callable[[Event], bool] | None) -> None:
        with self._changed:
            if self._wanted == "stop" or self._state not in ("ready", "paused", "running"):
                how = "was asked to stop" if self._wanted == "stop" else f"has {self._state}"
                raise RuntimeError(f"this session {how}; start a new one to go on from its last checkpoint")
            self._wanted, self._until = "run", until
            self._become("running")
            if self._thread is None:
                self._thread = threading.Thread(target=self._work, name="mechstyle-session", daemon=True)
                self._thread.start()

    def _want(self, wanted: Literal["pause", "stop"]) -> None:
        with self._changed:
            if self._wanted != "stop":
                self._wanted = wanted
            self._changed.notify_all()

    def _become(self, state: State) -> None:
        with self._changed:
            self._state = state
            for watcher in self._watchers:
                watcher(state)
            self._changed.notify_all()

    def _work(self) -> None:
        try:
            state = self._pumped()
        except Stopped:
            state = "stopped"
        except BaseException as error:  # noqa: BLE001 — kept for whoever asks; a thread has nobody to raise to
            self.error = error
            state = "failed"
        self._become(state)

    def _pumped(self) -> State:
        """Tell all events; how it ended. The generator is closed before anybody hears of it, so that a new session can go on at once."""
        with closing(self._events(self._progress)) as events:
            for event in events:
                for listener in tuple(self._listeners):
                    try:
                        listener(event)
                    except Exception:
                        logger.exception("a listener failed on %s", type(event).__name__)
                with self._changed:
                    if self._wanted == "run" and self._until is not None and self._until(event):
                        self._wanted, self._until = "pause", None
                    if self._wanted == "pause":
                        self._become("paused")
                        self._changed.wait_for(lambda: self._wanted != "pause")
                    if self._wanted == "stop":
                        return "stopped"
        return "finished"

    def _progress(self, fraction: float) -> None:
        """Called by the simulator between chunks."""
        self.fraction = fraction
        if self._wanted == "stop":
            raise Stopped
