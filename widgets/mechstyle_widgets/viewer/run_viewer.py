"""A run in three dimensions: the viewer of whatever iteration the state shows."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import traitlets

from mechstyle.errors import BadInput
from mechstyle.fea.orientations import UP
from mechstyle.pictures.fields import MOMENT, STAYS_BENT
from mechstyle.pictures.panels import exaggeration
from mechstyle.records import Checkpoint
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.runs.run import Run
from mechstyle.runs.summary import on_little
from mechstyle_widgets.jupyter.looks import sharing
from mechstyle_widgets.jupyter.throttle import LatestOnly, Throttled
from mechstyle_widgets.state.on_show import OnShow, on_show, summary_of
from mechstyle_widgets.state.studio_state import Linked, StudioState
from mechstyle_widgets.viewer import badge
from mechstyle_widgets.viewer.impact_player import DEFORMED, ImpactPlayer
from mechstyle_widgets.viewer.layers import STYLE, Layer, Subject, subject_of
from mechstyle_widgets.viewer.viewer import Viewer

FOLLOWED = ("checkpoint", "status")
"""Traits of the state that change what is to be seen: what a run delivers is drawn after its last checkpoint."""
JUDGED = ("history", "checkpoint", "status", "another")
"""Traits of a state that its badge tells of."""
Derived = Callable[[Run, Checkpoint], Layer]


class _Wish(NamedTuple):
    """An iteration that is to be seen, with layers that are derived from it."""

    run: Run
    state: Checkpoint
    derived: tuple[Derived, ...]


class RunViewer(Linked, Viewer):
    """The styled part at the iteration a state shows, with every field known there; the unstylized part may stand beside it.

    The layer `stays_bent` shows it in the shape that stays after the test that decides, exaggerated. It follows the run directory it was
    made for; when the state opens another one, make another viewer.

    `iteration`, `lane` and `layer` are those of the state, both ways.

    Attributes:
        player: Shows the impact moment by moment.
        compared: Lane and iteration that may stand beside it, None for the unstylized part.
        also: Lane and iteration that stand beside those two, None for none.
        insight: How what is compared differs, in a sentence that stands over all panes, "" for none.
        derived: Functions of run and checkpoint, each of which gives one more layer, such as a mask that would be.
    """

    compared = traitlets.Tuple(None, allow_none=True)
    also = traitlets.Tuple(None, allow_none=True)
    insight = traitlets.Unicode("")
    derived = traitlets.Tuple()

    @sharing()
    def __init__(self, state: StudioState, *, theme: str = "light", width: int = 640, height: int = 440) -> None:
        """Show the run of a state, so large [pixels]; BadInput if there is no iteration to show yet."""
        if state.run is None or state.checkpoint is None:
            raise BadInput("there is no iteration to show yet: start a run, or open one with Run.open")
        self._catch_up, self._moment = Throttled(self._show_checkpoint, state.alert), Throttled(self._show_moment, state.alert)
        self._newest, self._place = LatestOnly(_seen, self._bring, self._go_back), state.run.store.place
        self._drawn = _Wish(state.run, state.checkpoint, ())
        self._still = subject = _seen(self._drawn)
        original = subject_of(state.run, state.run.checkpoint(0))
        self._rests: tuple[Subject, ...] = (original,)
        self._before = STYLE  # of an impact
        wanted = state.layer if subject.layer(state.layer) else STYLE
        super().__init__(subject.mesh, subject.layers, original=original, theme=theme, width=width, height=height)
        self.player = ImpactPlayer(state)
        self.children = (*self.children[:-1], self.player, self.children[-1])  # between the view and what is written under it
        self.player.observe(lambda _: self._moment(), ("frame", "exaggeration"))
        self.player.observe(self._show_stress, "impact")
        self.observe(self._bend, "layer")
        self.layer = state.layer = wanted
        self.link(state, "layer")
        state.observe(self._follow, FOLLOWED)
        state.observe(self._judge, JUDGED)
        self.observe(self._follow, "derived")
        self.observe(self._stand_beside, ("compared", "also"))
        self.observe(self._judge, ("compared", "insight"))
        self.observe(self._fall_together, ("beside", "compared", "also"))
        state.observe(self._fall_once, "falls")
        self._name((self._drawn_place, *self._places))
        self._judge()

    def let_go(self) -> None:
        """Stop following the state, which may come to show a part with other faces."""
        if self._links:
            for work in (self._catch_up, self._moment, self._newest):
                work.cancel()
            self.unlink()
            self._state.unobserve(self._follow, FOLLOWED)
            self._state.unobserve(self._judge, JUDGED)
            self._state.unobserve(self._fall_once, "falls")
            self.player.close()

    def close(self) -> None:
        """Close the view; the state is not followed any more."""
        self.let_go()
        super().close()

    @property
    def undeformed(self) -> SurfaceMesh:
        """The unstylized part, to which regions belong, whatever style or impact has moved."""
        run = self._state.run
        return super().undeformed if run is None else run.part.surface

    def _stand_beside(self, _change: Any) -> None:
        """Let what is compared stand beside it."""
        run, places = self._state.run, self._places
        if run is not None:
            with self.hold_trait_notifications():
                shown = (self._drawn_place, *places)
                self._name(shown)
                others = [(Run(run.store, lane, run.device), iteration) for lane, iteration in places]
                self._rests = tuple(subject_of(other, other.checkpoint(iteration)) for other, iteration in others)
                self.original, self.third = self._rests[0], self._rests[1] if len(self._rests) > 1 else None
                self.beside = self.compared is not None

    @property
    def _places(self) -> tuple[tuple[str, int], ...]:
        """Lane and iteration of what may stand beside the part."""
        first = self.compared or (self._state.lane, 0)
        return (first, self.also) if self.compared and self.also else (first,)

    def _fall_together(self, _change: object = None) -> None:
        """What stands beside the part falls with it."""
        player, places = self.player, self._places if self.beside else ()
        if player.beside != places:
            player.beside = places
            if player.impact is not None:
                player.put_away()
                player.play()

    def _fall_once(self, _change: object = None) -> None:
        """Show how both fall, once, in the landing after which one stays bent most."""
        self._fall_together()
        self.player.put_away()
        shown = [self._state.row(iteration, lane) for lane, iteration in (self._drawn_place, *self._places)]
        decide = [row.verdict.deciding for row in shown if row is not None and row.verdict is not None]
        worst = max((row for row in decide if row is not None and row.landing), key=lambda row: row.used, default=None)
        if worst is not None:
            self.player.land(worst.landing)
        self.player.play(once=True)

    def _name(self, shown: tuple[tuple[str, int], ...]) -> None:
        """Say of each pane what it is and what came of it; beside the plain part the badge over the view is that of what is styled."""
        panes = self._panes(shown)
        self.captions = tuple(pane.caption for pane in panes)
        if self.compared:
            self.names, self.outcomes = tuple(pane.pane for pane in panes), tuple(map(badge.of_pane, panes))
        else:
            self.names, self.outcomes = ("styled", "plain"), ("", *map(badge.of_pane, panes[1:]))

    def _panes(self, shown: tuple[tuple[str, int], ...]) -> list[OnShow]:
        """What is to be said of each lane and iteration."""
        return [pane for place in shown if (pane := on_show(self._state, *place)) is not None]

    @property
    def _drawn_place(self) -> tuple[str, int]:
        """Lane and iteration of what is drawn, which may be a step behind what the state shows."""
        return self._drawn.run.lane, self._drawn.state.iteration

    @property
    def up_to_date(self) -> bool:
        """Whether what is drawn is what the state shows: a correction has the iteration of what it corrects."""
        return self._drawn.run.lane == self._state.lane and self._drawn.state is self._state.checkpoint

    def _judge(self, _change: Any = None) -> None:
        if self._state.run is None or self._state.run.store.place != self._place:
            return
        self._name((self._drawn_place, *self._places))  # a correction has the iteration of what it corrects
        if self.insight and self.compared:
            self.badge.say(badge.insight(self.insight), self.fly_to_worst)
            return
        state, shown = self._state, on_show(self._state)
        if shown is None:
            self.badge.say("")
            return
        last = state.headed(shown.title)
        little = "" if state.run is None or shown.kept is None else on_little(summary_of(state.run).notes)
        verdict, more = shown.verdict, {"last": last, "little": little}
        words = badge.of_several(self._panes((self._drawn_place, *self._places)), **more) if self.compared else badge.of(shown, **more)
        self.badge.say(words, self.fly_to_worst if verdict and verdict.rows else None)

    def fly_to_worst(self) -> None:
        """Look at the place that decides."""
        try:
            vertex = self._worst()
            if vertex is not None:
                self._fly_to(vertex)
        except Exception as error:  # noqa: BLE001 — whatever it is, it is said
            self._state.alert(error)

    def lead_to_worst(self) -> None:
        """Show what stays bent of all of the part, from a side from which its worst place is seen."""
        vertex = self._worst()
        if vertex is not None:
            self.look_round(vertex)
            if self._still.layer(STAYS_BENT) is not None:
                self.layer = STAYS_BENT

    def _worst(self) -> int | None:
        """The vertex that decides, None where what is on show was not tested."""
        state, shown = self._state, on_show(self._state)
        if shown is None or shown.verdict is None or state.checkpoint is None or state.run is None:
            return None
        tested = state.simulation(state.run.store, state.checkpoint)
        return badge.worst_vertex(self._still.mesh, state.checkpoint, tested, shown.verdict)

    def _follow(self, _change: Any) -> None:
        self._catch_up()

    def _show_checkpoint(self) -> None:
        run, state = self._state.run, self._state.checkpoint
        if run is not None and state is not None and run.store.place == self._place:  # another part needs another viewer
            self._newest.ask(_Wish(run, state, self.derived))

    def _bring(self, wish: _Wish, seen: Subject) -> None:
        self._drawn, self._still = wish, seen
        with self.hold_trait_notifications():
            self._name((self._drawn_place, *self._places))
            self._magnify()
            self._show_moment()
        if not self._state.busy:
            self.renew_still()

    def _go_back(self, error: Exception) -> None:
        """Say why an iteration cannot be drawn, and let all that speak of what is on show speak of what is drawn."""
        state = self._state
        state.go_to(*self._drawn_place)
        state.alert(error)

    def _show_moment(self) -> None:
        if self.layer == STAYS_BENT and self.player.impact is None:
            shown, *beside = (_bent(one, self.player.exaggeration) for one in (self._still, *self._rests))
        else:
            shown, *beside = (self.player.at_the_moment(one, pane) for pane, one in enumerate((self._still, *self._rests)))
        with self.hold_trait_notifications():
            self.subject = shown
            if self.original is not None:
                self.original, self.third = beside[0], beside[1] if len(beside) > 1 else None

    def _bend(self, change: Any) -> None:
        """Show the part in the shape that stays, or as it is again; an impact, which ends in that shape, is put away for it."""
        if STAYS_BENT in (change["new"], change["old"]):
            if change["new"] == STAYS_BENT:
                self.player.put_away()
            self.player.exaggeration = DEFORMED
            self._magnify()
            self._show_moment()

    def _magnify(self) -> None:
        """Offer to exaggerate the shape that stays, at first so that its bend can be seen."""
        self._under.children = (self._legend, self._said, *([self.player.factor] if self.layer == STAYS_BENT else []), self._scale)
        if self.layer == STAYS_BENT:
            most = max(one.most_bent for one in (self._still, *self._rests))
            self.player.exaggeration = float(exaggeration(most, self._still.mesh.size))

    def _show_stress(self, change: Any) -> None:
        """An impact begins with its stress on show; when it is put away, what was on show before it takes its place again."""
        shown = self.layer
        self._show_moment()
        if change["new"] is not None:
            self._before = self._before if shown == MOMENT else shown
            self.layer = MOMENT
        falls = change["new"] is not None
        if falls or change["old"].normal != UP:  # it does not stand where it stood
            self._orbit.follow(self.subject.mesh, self.player.highest(self._still.mesh.size) if falls else 0.0)
            self.fit()
        if change["new"] is None and shown == MOMENT and self.subject.layer(self._before):
            self.layer = self._before


@lru_cache(maxsize=4)
def _bent(subject: Subject, factor: float) -> Subject:
    """The same object again for a pane that stays as it is, so that it is not drawn again."""
    return subject.bent(factor)


def _seen(wish: _Wish) -> Subject:
    """In whatever thread: what is to be seen of an iteration."""
    subject = subject_of(wish.run, wish.state)
    for layer in wish.derived:
        subject = subject.with_layer(layer(wish.run, wish.state))
    _ = subject.mesh.vertex_normals  # are kept with the mesh, and are most of the work
    return subject
