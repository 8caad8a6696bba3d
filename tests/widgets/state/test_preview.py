"""The preview of a style: the latest wish counts, another part overtakes the one before, and what is wanted no longer leaves nothing."""

import asyncio
import threading

import numpy as np
import pytest
import trimesh

from mechstyle.records.mesh import SurfaceMesh
from mechstyle.runs.recipes import recipe_for
from mechstyle.runs.stylizers import finished_style
from mechstyle.simulation.part import Shape
from mechstyle_widgets.jupyter import prepare
from mechstyle_widgets.jupyter.prepare import shape_in_worker
from mechstyle_widgets.state import preview as module
from mechstyle_widgets.state.preview import Previewer

PATIENCE = 30.0
FEW = 600


class Seen(list):
    """The parts of this, and the gate that holds them up."""

    def __init__(self):
        super().__init__()
        self.gate = threading.Event()
        self.gate.set()

    async def until(self, count):
        while len(self) < count:  # noqa: ASYNC110 — a thread is waited for
            await asyncio.sleep(0.01)


@pytest.fixture
def prepared(monkeypatch):
    """The parts that were made ready, each as it is, once the gate is open; it is open unless a test closes it."""
    seen = Seen()

    def at_once(mesh, vertices, go_on):
        seen.append((mesh, vertices))
        assert seen.gate.wait(PATIENCE)
        go_on()
        return Shape(mesh, np.full(len(mesh.vertices), 8.0, np.float32))

    monkeypatch.setattr(module, "shape_in_worker", at_once)
    monkeypatch.setattr(module, "WAIT", 0.01)
    monkeypatch.setattr(module, "_ready", {})
    return seen


class Asker:
    """A previewer in an event loop, and what came of it."""

    def __init__(self):
        self.shown, self.failed, self._news = [], [], asyncio.Event()
        self.previewer = Previewer(lambda one: self._note(self.shown, one), lambda why: self._note(self.failed, why))

    def _note(self, where, what):
        where.append(what)
        self._news.set()

    async def news(self):
        await asyncio.wait_for(self._news.wait(), PATIENCE)
        self._news.clear()

    async def rest(self):
        while self.previewer._busy or self.previewer._timer is not None:  # noqa: ASYNC110 — a thread is waited for, too
            await asyncio.sleep(0.01)


def test_the_style_is_that_of_the_run_unrestrained(prepared, sphere):
    async def main():
        asker, recipe = Asker(), recipe_for("brick", relief=1.0)
        assert asker.previewer.ready(sphere, 25_000) is None
        asker.previewer.ask(sphere, 25_000, recipe)
        await asker.news()
        made = asker.shown[0]
        assert asker.previewer.ready(sphere, 25_000) is made.shape.surface
        np.testing.assert_array_equal(made.style.relief, finished_style(made.shape, recipe).relief)
        np.testing.assert_allclose(made.surface.vertices, sphere.displaced(made.style.relief).vertices)
        assert np.ptp(made.surface.colours, axis=0).max() > 0.1

    asyncio.run(main())
    assert [vertices for _, vertices in prepared] == [module.VERTICES]


def test_the_latest_of_quick_changes_is_drawn_and_the_part_made_ready_once(prepared, sphere):
    async def main():
        asker = Asker()
        for relief in (0.2, 0.4, 0.6):
            asker.previewer.ask(sphere, FEW, recipe_for("brick", relief=relief))
        await asker.news()
        asker.previewer.ask(sphere, FEW, recipe_for("brick", relief=1.2))
        await asker.news()
        await asker.rest()
        depths = [float(np.ptp(one.style.relief)) for one in asker.shown]
        assert len(depths) == 2
        assert depths[1] > 1.5 * depths[0]

    asyncio.run(main())
    assert len(prepared) == 1


def test_a_part_that_is_wanted_no_longer_is_not_shown(prepared, sphere, cube):
    async def main():
        asker = Asker()
        prepared.gate.clear()
        asker.previewer.ask(sphere, FEW, recipe_for("brick"))
        await prepared.until(1)
        asker.previewer.cancel()
        prepared.gate.set()
        await asker.rest()
        assert asker.shown == asker.failed == []
        half, most = sphere.moved(0.5 * sphere.vertices), sphere.moved(0.9 * sphere.vertices)
        prepared.gate.clear()
        asker.previewer.ask(most, FEW, recipe_for("brick"))
        await prepared.until(2)
        asker.previewer.ask(half, FEW, recipe_for("brick"))
        prepared.gate.set()
        await asker.news()
        await asker.rest()
        assert {id(one.shape.surface) for one in asker.shown} == {id(half)}

    asyncio.run(main())


def test_a_wish_of_another_thread_wakes_a_loop_that_sleeps(prepared, sphere):
    """JupyterLab's widgets speak to a thread of the kernel's own: a part chosen was shown only when the kernel had something else to do."""

    async def main():
        asker = Asker()
        threading.Timer(0.2, asker.previewer.ask, (sphere, FEW, recipe_for("brick"))).start()  # when the loop has gone to sleep
        await asker.news()
        assert len(asker.shown) == 1

    asyncio.run(main())


def test_the_newest_wish_is_drawn_though_the_answer_before_it_could_not_be_shown(prepared, sphere):
    """An error in showing one preview was the end of all that was asked for while it was drawn."""

    async def main():
        asker, errors = Asker(), []
        asyncio.get_running_loop().set_exception_handler(lambda _loop, context: errors.append(context["exception"]))
        show = asker.previewer._arrived
        asker.previewer._arrived = lambda one: show(one) if errors else 1 / 0
        prepared.gate.clear()
        asker.previewer.ask(sphere, FEW, recipe_for("brick"))
        await prepared.until(1)
        asker.previewer.ask(sphere, FEW, recipe_for("stone"))
        while asker.previewer._timer is not None:  # noqa: ASYNC110 — it is to find that the first is still being drawn
            await asyncio.sleep(0.01)
        prepared.gate.set()
        await asker.news()
        assert [type(error) for error in errors] == [ZeroDivisionError]
        assert len(asker.shown) == 1

    asyncio.run(main())


def test_a_wish_of_another_thread_is_drawn_however_soon_its_time_has_come(prepared, sphere, monkeypatch):
    """The timer went off before it was noted down, and was taken for one that is still to come."""

    class Hasty(module.Timer):
        def __init__(self, loop, _wait, act):
            super().__init__(loop, 0.0, act)
            turned = threading.Event()
            loop.call_soon_threadsafe(loop.call_later, 0.01, turned.set)
            turned.wait(0.3)

    monkeypatch.setattr(module, "Timer", Hasty)

    async def main():
        asker = Asker()
        prepared.gate.clear()
        await asyncio.to_thread(asker.previewer.ask, sphere, FEW, recipe_for("brick"))
        await prepared.until(1)
        await asyncio.to_thread(asker.previewer.ask, sphere, FEW, recipe_for("stone"))
        prepared.gate.set()
        await asker.news()
        await asker.rest()
        assert len(asker.shown) == 2

    asyncio.run(asyncio.wait_for(main(), 5.0))


def test_where_only_running_tells_the_part_is_shown_as_it_came(prepared, sphere):
    async def main():
        asker = Asker()
        asker.previewer.ask(sphere, FEW, recipe_for("brick", field="network"))
        await asker.news()
        assert asker.shown[0].style is None
        assert asker.shown[0].surface is sphere

    asyncio.run(main())


def test_another_studio_of_the_same_part_finds_it_ready_and_only_the_last_few_are_kept(prepared, sphere, cube):
    """A cell that is run again made its part ready once more, and drew the style on it from the start."""

    async def main():
        for mesh in (sphere, sphere, *(cube.moved(0.1 * count * cube.vertices) for count in range(module.READY)), sphere):
            asker = Asker()
            asker.previewer.ask(mesh, FEW, recipe_for("brick"))
            await asker.news()

    asyncio.run(main())
    assert [mesh is sphere for mesh, _ in prepared] == [True, *([False] * module.READY), True]
    assert len(module._ready) == module.READY


def test_without_an_event_loop_nothing_is_drawn(prepared, sphere):
    previewer = Previewer(lambda _: pytest.fail("drawn"), pytest.fail)
    previewer.ask(sphere, FEW, recipe_for("brick"))
    assert prepared == []
    assert previewer.ready(sphere, FEW) is None


def test_a_part_is_made_ready_in_another_process_that_ends_when_told(cube):
    class Enough(Exception):
        pass

    def enough():
        raise Enough

    with pytest.raises(Enough):
        shape_in_worker(cube, FEW, enough)
    shape = shape_in_worker(cube, FEW, lambda: None)
    assert abs(len(shape.surface.vertices) - FEW) < 0.2 * FEW
    assert not shape.inside.any()


def test_what_was_made_ready_before_needs_no_other_process(cube, monkeypatch):
    """It takes two seconds to begin, which is all the time that a Studio has until its style is on show."""
    first = shape_in_worker(cube, FEW, lambda: None)
    monkeypatch.setattr(prepare, "WorkerProcess", lambda *_: pytest.fail("a process of its own"))
    again = shape_in_worker(cube, FEW, lambda: None)
    assert again.surface.digest == first.surface.digest
    np.testing.assert_array_equal(again.thickness, first.thickness)


@pytest.fixture
def ball() -> SurfaceMesh:
    sphere = trimesh.creation.icosphere(subdivisions=4, radius=20.0)
    return SurfaceMesh(sphere.vertices, sphere.faces)


def test_a_pattern_that_its_mesh_does_not_carry_says_how_much_larger_it_is_and_what_would(ball):
    """What was drawn three times larger was said after the run, in a list that was folded away."""
    recipe = recipe_for("brick", "PLA", feature=1.0)
    shape = Shape(ball, np.full(len(ball.vertices), 8.0, np.float32))
    drawn, count = module.Preview(shape, finished_style(shape, recipe), 0.1), len(ball.vertices)
    found = drawn.enlarged(count)
    assert found.times > 1.1
    assert any(found.what in note for note in drawn.style.notes)
    assert drawn.enlarged(count // 4).times == pytest.approx(2.0 * found.times, rel=0.01), "a run that is coarser is worse"
    assert drawn.enlarged(found.vertices) is None, "what is offered is enough"
    coarse = recipe_for("brick", "PLA", feature=30.0)
    assert module.Preview(shape, finished_style(shape, coarse), 0.1).enlarged(count) is None
