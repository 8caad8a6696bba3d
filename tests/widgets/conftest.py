"""A run without physics for the widgets to look at: the sheet, the bump and the lever of the loop's own tests."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace

import msgspec
import numpy as np
import pytest
from ipywidgets import Widget

from mechstyle._files import write_whole
from mechstyle.records.mesh import TetMesh
from mechstyle.runs.folders import PartRecord
from mechstyle.runs.run import Draft, Run
from mechstyle.runs.session import Session
from mechstyle.simulation.part import Origin
from mechstyle_widgets.jupyter import throttle
from mechstyle_widgets.state.controller import Controller
from mechstyle_widgets.state.studio_state import StudioState
from mechstyle_widgets.viewer import impact_player
from support.bench import Bench

PATIENCE = 30.0  # seconds before a test gives up; nothing waits this long


class FakeRun:
    """A run directory of the sheet, carried on by the lever simulator instead of a drop test."""

    def __init__(self, folder: Path, **settings: object) -> None:
        self.bench = Bench(folder)
        defaults = {"prompt": "brick", "iterations": 12, "schedule": "every", "every": 4}
        self.engine = self.bench.engine(self.bench.recipe(**{**defaults, **settings}))
        surface, objects = self.bench.surface, self.engine.store.objects
        corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], float)
        record = PartRecord(
            name="sheet",
            surface=objects.put_mesh(surface),
            tets=objects.put_mesh(TetMesh(corners, np.array([(0, 1, 2, 3)]))),
            thickness=objects.put_array(np.full(len(surface.vertices), 4.0, np.float32)),
            stands=True,
            notes=(),
            origin=Origin(model="sheet.stl", vertices=500),
        )
        write_whole(folder / "part.json", msgspec.json.encode(record))
        self.run = Run(self.engine.store)

    def session(self, lane: str = "main") -> Session:
        """Carries a lane on."""
        recipe = self.run.store.recipe(self.run.store.lane(lane).recipe)
        return Session(lambda _progress: self.bench.engine(recipe, lane).run())

    def go(self, lane: str = "main") -> Run:
        """The lane, finished."""
        for _ in self.session(lane)._events(lambda _fraction: None):
            pass
        return Run(self.run.store, lane)


@pytest.fixture
def fake_run() -> type[FakeRun]:
    """Makes runs without physics: `fake_run(folder, **settings)`."""
    return FakeRun


@pytest.fixture
def fake(tmp_path) -> FakeRun:
    """A run directory that has not begun."""
    return FakeRun(tmp_path / "run")


@pytest.fixture(scope="session")
def done(tmp_path_factory) -> Run:
    """A finished run with a branch `soft` at iteration 6; not to be written to."""
    made = FakeRun(tmp_path_factory.mktemp("done") / "run")
    made.go().branch(6, lane="soft", control="linear", every=3)
    return Run(made.go("soft").store)


@pytest.fixture(autouse=True)
def close_what_a_test_opened() -> Iterator[None]:
    yield
    Widget.close_all()


@pytest.fixture
def controller(fake, monkeypatch) -> Controller:
    """A controller of the run without physics, whose settings are those of its recipe until a test changes `wanted`."""
    monkeypatch.setattr(Run, "events", lambda run, _progress: fake.bench.engine(run.recipe, run.lane).run())
    state = StudioState(fake.run)
    return Controller(state, lambda: Draft(fake.run.recipe, fake.run.part, 500, "sheet"))


@pytest.fixture
def settle() -> Callable[[Controller], None]:
    """Waits until the session pauses or ends, and carries over its news."""

    def wait(controller: Controller) -> None:
        controller.state.session.wait(PATIENCE)
        controller.state.pump()

    return wait


@dataclass
class Later:
    """Drops that an impact player began, and what they bring to its event loop; either happens when a test calls it."""

    drops: list[Callable[[], None]] = field(default_factory=list)
    brought: list[Callable[[], None]] = field(default_factory=list)

    def turn(self) -> None:
        """The event loop turns."""
        now, self.brought[:] = list(self.brought), []
        for act in now:
            act()


@pytest.fixture
def later(monkeypatch) -> Later:
    """Impacts are worked out and brought when the test says so, not in threads."""
    made = Later()

    def thread(target, **_):
        return SimpleNamespace(start=lambda: made.drops.append(target))

    loop = SimpleNamespace(call_soon_threadsafe=made.brought.append, is_closed=lambda: False)
    monkeypatch.setattr(impact_player, "running_loop", lambda: loop)
    monkeypatch.setattr(throttle, "threading", SimpleNamespace(Thread=thread))
    return made
