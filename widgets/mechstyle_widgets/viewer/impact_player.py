"""The fall of an iteration as a film: through the air, moment by moment through the impact, to the shape that stays."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import partial
from typing import Any

import ipywidgets
import numpy as np
import traitlets
from numpy.typing import NDArray

from mechstyle.fea.orientations import FLAT
from mechstyle.pictures.fields import moment
from mechstyle.pictures.panels import FACTORS, exaggeration
from mechstyle.records import Landing
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.records.recipe import DEFAULTS
from mechstyle.records.sentences import bend
from mechstyle.records.written import written
from mechstyle.simulation.impact import FALLING, Impact, heights, impact_of
from mechstyle_widgets.jupyter.frame import unseen
from mechstyle_widgets.jupyter.language import said, word
from mechstyle_widgets.jupyter.looks import close_family, lean
from mechstyle_widgets.jupyter.throttle import Timer, in_a_thread, running_loop
from mechstyle_widgets.state.studio_state import StudioState
from mechstyle_widgets.state.troubles import sentence
from mechstyle_widgets.viewer.layers import Subject, layer_of

DEFORMED = 20.0
"""Factor by which an impact is deformed at first."""
FALL = 3.0
"""How long a fall is that is played by itself, from the air to the shape that stays [s]; slow views take longer."""


class _Cancelled(Exception):
    """Nobody waits any more for a drop that is being worked out."""


class ImpactPlayer(ipywidgets.VBox):  # type: ignore[misc]  # ipywidgets has no types
    """A button that drops the part of the iteration on show once more, and then a slider through what happened.

    It opens at the moment of the peak; playing it begins in the air and ends in the shape that stays.
    What stands beside the part falls with it, in the same landing and at the same time.

    Attributes:
        beside: Lane and iteration of each pane beside the part.
        landing: Name of the landing, one of those of the last simulation; flat at first.
        impact: The impact on show, None while there is none.
        factor: The menu of exaggerations, which is also of use without an impact.
        frame: Which of its moments, counted from first touch; below 0 it falls.
        exaggeration: Factor on the deformation; the motion of the part as a whole is shown as it is.
    """

    impact = traitlets.Instance(Impact, None, allow_none=True)
    landing = traitlets.Unicode(FLAT)
    frame = traitlets.Int(0)
    exaggeration = traitlets.Float(DEFORMED)
    beside: tuple[tuple[str, int], ...] = ()
    _built = False
    _falling: Timer | None = None
    _others: tuple[Impact | None, ...] = ()

    def __init__(self, state: StudioState) -> None:
        """Play impacts of whatever iteration a state shows."""
        self._state, self._landings = state, dict[str, Landing]()
        self._over = threading.Event()  # of the newest drop, set when its answer is there or nobody waits for it; each has its own
        self._over.set()
        self._once = False
        what, look = "Drop this part and watch", {"width": "auto"}
        self._button = lean(ipywidgets.Button, description="impact", icon="play-circle", tooltip=what, layout=look)
        self._which = unseen(lean(
            ipywidgets.Dropdown,
            options=[FLAT], description="landing", tooltip="Which landing, and what stays bent after it",
            layout={"width": "auto", "max_width": "280px"},
        ))  # fmt: skip
        self._away = lean(ipywidgets.Button, icon="times", tooltip="Back to the part at rest", layout={"width": "36px"})
        self._progress = lean(ipywidgets.FloatProgress, value=0.0, max=1.0, description="dropping", layout={"width": "260px"})
        self._said = lean(ipywidgets.HTML)
        self._play = lean(
            ipywidgets.Play,
            min=-FALLING,
            interval=100,
            show_repeat=False,
            layout=look,
            tooltip="Play on to the shape that stays, and from there again",
        )
        self._peak = lean(ipywidgets.Button, description="peak", tooltip="To the moment of the largest stress", layout={"width": "auto"})
        self._slider = lean(ipywidgets.IntSlider, min=-FALLING, readout=False, tooltip="Arrow keys step", layout={"width": "220px"})
        self._time = lean(ipywidgets.HTML, layout={"width": "140px"})
        factors, narrow = [(word("bend × {}").format(factor), float(factor)) for factor in FACTORS], {"width": "124px"}
        what = "How many times larger the deformation is drawn"
        self.factor = unseen(lean(
            ipywidgets.Dropdown, options=factors, value=self.exaggeration, description="deformed", tooltip=what, layout=narrow,
        ))  # fmt: skip
        moments = [self._play, self._slider, self._time, self._peak, self.factor, self._which, self._away]
        self._moments = lean(ipywidgets.HBox, moments, layout={"flex_flow": "row wrap", "align_items": "center"})
        self._moments.add_class("mechstyle-moments")
        self._start = lean(ipywidgets.HBox, [self._button])
        super().__init__([self._start])
        self.add_class("mechstyle-player-start")
        self._link = ipywidgets.jslink((self._play, "value"), (self._slider, "value"))
        traitlets.link((self._slider, "value"), (self, "frame"))
        traitlets.link((self, "landing"), (self._which, "value"))
        self._offer()
        traitlets.link((self.factor, "value"), (self, "exaggeration"))
        self._button.on_click(lambda _: self.play())
        self._peak.on_click(self._go_to_the_peak)
        self._away.on_click(lambda _: self.put_away())
        state.observe(self._other_part, "checkpoint")
        self._built = True

    @property
    def working(self) -> bool:
        """Whether an impact is being worked out."""
        return not self._over.is_set()

    def play(self, *, once: bool = False) -> None:
        """Work the impact out, unless that is being done, in a thread where there is an event loop to bring it back, and show it.

        With `once` it is played at once, in slow motion.
        """
        run, checkpoint = self._state.run, self._state.checkpoint
        if run is None or checkpoint is None or self.working:
            return
        self._progress.value, self._over, self._once = 0.0, threading.Event(), once
        self._say(self._progress)
        landing, state = self.landing, self._state
        fallen = [checkpoint, *filter(None, (state.checkpoint_at(iteration, lane) for lane, iteration in self.beside))]
        loop, over = running_loop(), self._over

        def drop() -> list[Impact | None]:
            found = list[Impact | None]()
            for number, one in enumerate(fallen):
                tested, simulator = state.simulation(run.store, one), run.simulator(run.store.recipe(one.recipe))
                there = number == 0 or tested.landing(landing) is not None
                found.append(impact_of(simulator, tested, landing, partial(progress, number)) if there else None)
            return found

        def progress(number: int, fraction: float) -> None:
            if over.is_set():
                raise _Cancelled
            tell = partial(heard, partial(setattr, self._progress, "value"), (number + fraction) / len(fallen))
            tell() if loop is None else loop.call_soon_threadsafe(tell)

        def failed(error: Exception) -> None:
            """Whatever it is, it is said, and it can be tried again."""
            over.set()
            self._said.value = said(sentence(error, run.store.place))
            self._say(self._start, self._said)

        def heard(act: Callable[[Any], None], given: Any) -> None:
            if over.is_set():
                return
            try:
                act(given)
            except Exception as error:  # noqa: BLE001 — it would end in a log, and the bar stand for ever
                failed(error)

        in_a_thread(loop, drop, partial(heard, self._show), partial(heard, failed))

    def land(self, name: str) -> None:
        """Choose a landing of the last simulation by its name; one that is not there changes nothing."""
        self.landing = name if name in self._landings else self.landing

    def put_away(self) -> None:
        """Show the undeformed part again; a drop that is being worked out ends."""
        self._over.set()
        self._halt()
        self._others, self.impact = (), None
        self._say(self._start)

    def at_the_moment(self, subject: Subject, pane: int = 0) -> Subject:
        """A subject at rest as the impact has it now, the stress of the moment against the yield strength; as it is without one.

        Pane 0 is the part on show, 1 and more are what stands beside it.
        """
        impacts = (self.impact, *self._others)
        impact = impacts[pane] if pane < len(impacts) else None
        if impact is None or self.impact is None or self._state.run is None:
            return subject
        if impact.displacement.shape[1] != len(subject.mesh.vertices):  # of the part that was on show before
            return subject
        if self.frame < 0:
            return self._in_the_air(subject, impact)
        ended = self.frame == self.impact.end
        frame = impact.end if ended else int(np.abs(impact.time[:-1] - self.impact.time[self.frame]).argmin())
        when = "in the shape that stays" if ended else f"at {1e3 * impact.time[frame]:.0f} µs"
        note = f"{self.landing}, {when}, deformed × {self.exaggeration:g}"
        return self._of_film(subject, impact.shape(subject.mesh, frame, self.exaggeration), impact, impact.stress[frame], note)

    def _in_the_air(self, subject: Subject, impact: Impact) -> Subject:
        """A subject before first touch, without any stress."""
        above = heights(subject.mesh.size, self._from)[self.frame]
        note = f"{self.landing}, falls from {written(self._from)}, {above:.0f} mm above the floor"
        return self._of_film(subject, impact.falling(subject.mesh, above), impact, np.zeros_like(impact.stress[0]), note)

    def _of_film(self, subject: Subject, shape: SurfaceMesh, impact: Impact, stress: NDArray[np.float32], note: str) -> Subject:
        assert self._state.run is not None, "it is what falls"
        strength = self._state.run.recipe.test.material.yield_strength
        return Subject(shape, (*subject.layers, layer_of(moment(strength), stress, impact.stress, note)))

    @property
    def _from(self) -> float:
        """How far what is on show falls [mm]."""
        landing = self._landings.get(self.landing)
        return DEFAULTS["height"] if landing is None else landing.fall

    def highest(self, size: float) -> float:
        """How far above the floor a part of a size [mm] is when it comes into view [mm]."""
        return float(heights(size, self._from)[0])

    def close(self) -> None:
        """Close it; a drop that is being worked out ends."""
        if self._built:
            self._built = False
            self._over.set()
            self._halt()
            self._state.unobserve(self._other_part, "checkpoint")
            close_family(self, self._start, self._progress, self._moments, self._said, self._link)
        super().close()

    def _say(self, *widgets: ipywidgets.Widget) -> None:
        self.children = widgets
        (self.add_class if widgets == (self._start,) else self.remove_class)("mechstyle-player-start")

    def _show(self, impacts: list[Impact | None]) -> None:
        self._over.set()
        impact, *others = impacts
        assert impact is not None, "the part on show fell"
        self._slider.max = self._play.max = impact.end
        first = -FALLING if self._once and not self._state.calm else impact.peak
        self._slider.value = self._play.value = first
        self._others, self.impact = tuple(others), impact
        self._magnify()
        self._say(self._moments)
        self._tell_time()
        if self._once and not self._state.calm:
            self._fall(-FALLING)

    def _magnify(self) -> None:
        """Exaggerate the deformation at the peak so that it is seen, and nothing of any part leaves the picture."""
        run = self._state.run
        assert run is not None, "it is what falls"
        surface = run.part.surface
        motions = (one.motion(surface.vertices, one.peak) for one in (self.impact, *self._others) if one is not None)
        self.exaggeration = float(exaggeration(max(float(np.abs(one.deformation).max()) for one in motions), surface.size))

    def _fall(self, reached: int) -> None:
        """Go on to the end, a moment at a time, unless somebody has gone elsewhere meanwhile."""
        loop, self._falling = running_loop(), None
        if self.impact is None or self.frame != reached or reached >= self.impact.end or loop is None:
            return
        self._slider.value = self._play.value = reached + 1
        self._falling = Timer(loop, FALL / (FALLING + self.impact.end), partial(self._fall, reached + 1))

    def _halt(self) -> None:
        self._play.playing = False
        if self._falling is not None:
            self._falling.cancel()
            self._falling = None

    def _go_to_the_peak(self, _button: object) -> None:
        if self.impact is not None:
            self._halt()
            self._slider.value = self._play.value = self.impact.peak

    def _offer(self) -> None:
        run, checkpoint = self._state.run, self._state.checkpoint
        found: tuple[Landing, ...] = ()
        if run is not None and checkpoint is not None and checkpoint.simulation:
            found = self._state.simulation(run.store, checkpoint).landings
        self._landings = {one.name: one for one in found}
        options = [(said(f"{one.name} · {bend(one.permanent_set)}"), one.name) for one in found] or [(FLAT, FLAT)]
        if tuple(self._which.options) != tuple(options):
            kept = self.landing if self.landing in [name for _, name in options] else options[0][1]
            self._which.options = options
            self._which.value = kept

    @traitlets.observe("landing")
    def _other_landing(self, _change: object) -> None:
        """What is on show, or being worked out, is another landing's."""
        if self._built and (self.impact is not None or self.working):
            self.put_away()
            self.play()

    @traitlets.observe("frame")
    def _tell_time(self, _change: object = None) -> None:
        if self.impact is None:
            return
        landing = self._landings.get(self.landing)
        if self.frame < 0:
            self._time.value = said(f"falls from {written(self._from)}")
        elif self.frame == self.impact.end and landing is not None:
            self._time.value = said(f"{bend(landing.permanent_set)} stays bent")
        else:
            at_peak = f" · {said('peak')}" if self.frame == self.impact.peak else ""
            self._time.value = f"{1e3 * self.impact.time[self.frame]:.0f} µs{at_peak}"

    def _other_part(self, _change: object) -> None:
        """Another iteration is another part: what is on show would not be its impact."""
        self._offer()
        if self.impact is not None or self.working:
            self.put_away()
