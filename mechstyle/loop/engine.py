"""The loop: stylize, restrain, simulate when it is worth it, remember everything.

`Engine.run` is a generator of frozen events. It owns the order of things and nothing else: what a style is, how a drop
is simulated, how stress becomes a mask and when to simulate are collaborators declared here by what the loop needs of them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from mechstyle.errors import BadInput
from mechstyle.loop import control, correction, schedule
from mechstyle.loop.bounds import Bounds, advanced, unrestrained_relief
from mechstyle.loop.store import Lane, Store
from mechstyle.records import Checkpoint, Recipe, Simulation, Verdict
from mechstyle.records.mesh import Field, SurfaceMesh
from mechstyle.records.verdict import OLDER


@dataclass(frozen=True)
class Stylized:
    """The stylizer proposed and the mask let part of it through; `moved` is the largest movement of a vertex [mm]."""

    iteration: int
    style_loss: float
    moved: float


@dataclass(frozen=True)
class SimulationStarted:
    """A drop test begins; `reason` is what the schedule said."""

    iteration: int
    reason: str


@dataclass(frozen=True)
class Simulated:
    """A drop test ended; `restrained` is the share of the vertices that now count as restrained."""

    iteration: int
    reason: str
    simulation: Simulation
    verdict: Verdict
    restrained: float


@dataclass(frozen=True)
class Corrected:
    """The finished relief was lowered, because it failed, or raised, because it passed; a simulation of the result follows.

    `step` says what was changed, `kept` is the share of what the style asks for that is left.
    """

    step: str
    kept: float


@dataclass(frozen=True)
class Checkpointed:
    """A checkpoint is on disk under `digest`."""

    digest: str
    checkpoint: Checkpoint


@dataclass(frozen=True)
class Finished:
    """The run is complete; the last checkpoint is the best surface that was simulated at its end, with this verdict."""

    verdict: Verdict
    digest: str


Event = Stylized | SimulationStarted | Simulated | Corrected | Checkpointed | Finished


STEP_LIMIT = 0.01
"""A vertex moves at most this share of the part's size per iteration (Faruqi et al. 2025)."""
KEYFRAME_EVERY = 20
"""Iterations between stored stylizer states."""


class Proposal(Protocol):
    """Proposal of a stylizer: displacement along the original normals [mm], shape [vertex_count], and RGB colours."""

    @property
    def displacement(self) -> Field:
        """Total displacement [mm], shape [vertex_count]."""

    @property
    def colour(self) -> Field:
        """RGB in [0, 1], shape [vertex_count, 3]."""


class Stylizer(Protocol):
    """Anything that proposes a relief and colours, iteration by iteration, without being fed what the mask held back."""

    def proposal(self) -> Proposal:
        """The current proposal."""

    def step(self) -> Proposal:
        """Take one iteration; return the new proposal."""

    def loss(self, displacement: Field, colour: Field) -> float:
        """Distance of a surface from the style's target."""

    def state(self) -> dict[str, Field]:
        """State from which `restore` continues with the same bytes."""

    def restore(self, state: dict[str, Field]) -> None:
        """Continue from a state."""

    def start_from(self, displacement: Field, colour: Field) -> None:
        """Continue from a surface another style has left."""


class Simulator(Protocol):
    """Anything that tells what stress a displaced surface would see."""

    @property
    def baseline(self) -> Simulation:
        """The unstylized part in all landings."""

    def simulate(self, displacement: Field, *, thorough: bool) -> Simulation:
        """Test the displaced part: in the landings that steer, or in all if `thorough`."""

    def judge(self, simulation: Simulation, *, alone: bool = False) -> Verdict:
        """Verdict on a simulation beside the unstylized part, or `alone` on that part itself."""


Untangle = Callable[[Field], Field]
"""What is left of a relief [mm], shape [vertex_count], where the surface would pass through itself."""


@dataclass(frozen=True)
class Engine:
    """One lane of one store, carried on to the end of its recipe; finished reliefs are untangled before they are simulated."""

    recipe: Recipe
    surface: SurfaceMesh
    bounds: Bounds
    stylizer: Stylizer
    simulator: Simulator
    store: Store
    lane: str = "main"
    untangled: Untangle = lambda relief: relief

    def run(self) -> Iterator[Event]:
        """Carry the lane on to its end, yielding what happens; stopping between two events loses nothing that was yielded."""
        digest, state = self._stand()
        if digest == "":
            digest, event = self._save(self._original())
            yield event
            state = event.checkpoint
        proposed = self.bounds.levelled(self._wind_stylizer(state).displacement)
        if state.recipe != self.recipe.digest:  # its stress stays, its restraint is worked out anew
            demand = self._demand(self.store.objects.get_record(state.simulation, Simulation))
            state = replace(state, demand=demand, mask=self._mask(demand))
        while state.iteration < self.recipe.schedule.iterations:
            proposal, before = self.stylizer.step(), state.displacement
            wanted = self.bounds.levelled(proposal.displacement)
            state = self._moved(state, proposal, wanted - proposed, parent=digest)
            proposed = wanted
            yield Stylized(state.iteration, state.style_loss, float(np.abs(state.displacement - before).max()))
            reason = self._reason(state)
            if reason:
                yield SimulationStarted(state.iteration, reason)
                state, simulated = self._simulated(state, reason)
                yield simulated
            digest, event = self._save(state)
            yield event
        yield from self._finish(state, digest)

    def _stand(self) -> tuple[str, Checkpoint]:
        """The checkpoint to go on from; corrections are replayed from the last iteration (their simulations are remembered)."""
        digest = self.store.lane(self.lane).head
        if not digest:
            return "", self._original()
        state = self.store.checkpoint(digest)
        while state.parent and state.iteration == self.recipe.schedule.iterations == self.store.entry(state.parent).iteration:
            digest, state = state.parent, self.store.checkpoint(state.parent)
        if state.verdict is not None and state.verdict.failure == OLDER and state.iteration == self.recipe.schedule.iterations:
            digest, state = state.parent, self.store.checkpoint(state.parent)  # what it ended with is tested again
        if state.iteration > self.recipe.schedule.iterations:
            beyond = f"beyond the {self.recipe.schedule.iterations} asked for; ask for more iterations"
            raise BadInput(f"lane {self.lane!r} stands at iteration {state.iteration}, {beyond}")
        return digest, state

    def _original(self) -> Checkpoint:
        count = len(self.surface.vertices)
        nothing = np.zeros(count, np.float32)
        start = self.stylizer.proposal()
        base = self.simulator.baseline
        demand, verdict = self._demand(base), self.simulator.judge(base, alone=True)
        return Checkpoint(
            iteration=0, parent="", recipe=self.recipe.digest, displacement=nothing, colour=start.colour.astype(np.float16),
            mask=self._mask(demand), share=np.ones(count, np.float32), anchor=nothing, stress=shown(base, verdict), demand=demand,
            simulated_at=0, simulation=self.store.objects.put_record(base), style_loss=self.stylizer.loss(nothing, start.colour),
            reason="original part", verdict=verdict, keyframe=self.stylizer.state(),
        )  # fmt: skip

    def _wind_stylizer(self, state: Checkpoint) -> Proposal:
        """Bring the stylizer to where it was after `state`: from the nearest keyframe, or afresh where another style ended."""
        last = state.iteration
        while True:
            ours, theirs = self.recipe, self.recipe if state.recipe == self.recipe.digest else self.store.recipe(state.recipe)
            if (theirs.style, theirs.delivery.nozzle) != (ours.style, ours.delivery.nozzle):
                self.stylizer.start_from(state.displacement, state.colour.astype(np.float32))
                break
            if state.keyframe is not None:
                self.stylizer.restore(state.keyframe)
                break
            state = self.store.checkpoint(state.parent)
        for _ in range(last - state.iteration):  # corrections are checkpoints too, but no iterations
            self.stylizer.step()
        return self.stylizer.proposal()

    def _moved(self, state: Checkpoint, proposal: Proposal, increment: Field, parent: str) -> Checkpoint:
        """D += mask · share · clip(increment), within the bounds; colours are never masked, only kept where the user wants it."""
        limit = np.float32(STEP_LIMIT * self.surface.size)
        displacement = advanced(state.displacement, state.mask * state.share, np.clip(increment, -limit, limit), self.bounds, self.recipe)
        colour = np.where(np.asarray(self.bounds.uncoloured) == 1.0, state.colour, proposal.colour).astype(np.float32)
        iteration = state.iteration + 1
        return replace(
            state, iteration=iteration, parent=parent, recipe=self.recipe.digest, displacement=displacement,
            colour=colour.astype(np.float16), style_loss=self.stylizer.loss(displacement, colour), reason="", verdict=None, final=False,
            keyframe=self.stylizer.state() if iteration % KEYFRAME_EVERY == 0 else None,
        )  # fmt: skip

    @cached_property
    def _walls(self) -> Field:
        """Wall thickness on which the schedule decides [mm], shape [vertex_count]: a wall thin at one vertex alone is a corner."""
        return self.surface.dilated(self.bounds.thickness)

    def _reason(self, state: Checkpoint) -> str:
        if state.iteration == self.recipe.schedule.iterations:
            return "last iteration"
        travelled = state.displacement - state.anchor
        progress = schedule.Progress(state.iteration, state.simulated_at, travelled, self._walls, state.demand)
        return schedule.due(self.recipe, progress)

    def _simulated(self, state: Checkpoint, reason: str) -> tuple[Checkpoint, Simulated]:
        """Simulate; the new demand restrains what comes next, and what the tetrahedra could not follow is taken out of D."""
        last, state = state.iteration == self.recipe.schedule.iterations, replace(state, reason=reason)
        relief = self.untangled(state.displacement) if last else state.displacement
        simulation = self.simulator.simulate(relief, thorough=last)
        verdict = self.simulator.judge(simulation)
        state = replace(state, displacement=simulation.displacement, simulated_at=state.iteration, verdict=verdict)
        if not simulation.failure:
            demand = self._demand(simulation)
            state = replace(state, stress=shown(simulation, verdict), demand=demand, mask=self._mask(demand))
        state = replace(
            state, anchor=state.displacement, simulation=self.store.objects.put_record(simulation),
            style_loss=self.stylizer.loss(state.displacement, state.colour.astype(np.float32)),
        )  # fmt: skip
        return state, Simulated(state.iteration, reason, simulation, verdict, float(state.restrained.mean()))

    def _demand(self, simulation: Simulation) -> Field:
        if simulation.failure or self.simulator.baseline.failure:
            return np.zeros(len(self.surface.vertices), np.float32)
        return control.demand(simulation, self.simulator.baseline, self.recipe)

    def _mask(self, demand: Field) -> Field:
        """The control's mask, within the freedom that protection leaves."""
        return control.mask(demand, self.recipe.restraint.control, self.recipe.restraint.threshold) * self.bounds.freedom

    def _finish(self, state: Checkpoint, digest: str) -> Iterator[Event]:
        """Correct the finished relief until it passes (if the recipe asks for it), then mark the best as final."""
        assert state.verdict is not None, "the last iteration is always simulated"
        finished, best = state.displacement, state
        target = self._target()
        masked = self.recipe.restraint.control != "none" and self.recipe.schedule.when != "never"
        unheld = not masked and np.all(state.share == 1.0)
        wanted = finished if unheld else target  # what nothing held back is all that can be given back
        search = correction.Correction(self.surface, wanted, lambda relief: self._retained(relief, target), self.bounds.standing)
        tries = search.tries(finished, self._finding(state))
        tried = next(tries, None) if self.recipe.restraint.guarantee and not self.simulator.baseline.failure else None
        while tried is not None:
            relief, words = tried
            yield Corrected(words, search.kept(relief))
            yield SimulationStarted(state.iteration, f"{correction.REASON}{words}")
            share = state.share * correction.remaining_share(finished, relief)
            corrected = replace(state, displacement=relief, share=share, parent=digest, keyframe=None)
            corrected, simulated = self._simulated(corrected, f"{correction.REASON}{words}")
            yield simulated
            digest, event = self._save(corrected)
            yield event
            best = corrected if self._worth(corrected, target) >= self._worth(best, target) else best
            try:
                tried = tries.send(self._finding(corrected))
            except StopIteration:
                tried = None
        if not best.final:
            digest, event = self._save(replace(best, parent=digest, keyframe=None, final=True))
            yield event
        assert best.verdict is not None, "every correction is simulated"
        yield Finished(best.verdict, digest)

    def _target(self) -> Field:
        """What the finished style asks for within its bounds [mm], shape [vertex_count], whatever of it the part came to."""
        return unrestrained_relief(self.stylizer.proposal().displacement, self.bounds, self.recipe)

    def _finding(self, state: Checkpoint) -> correction.Finding:
        """What the test of a state found, as a correction looks at it."""
        verdict = state.verdict
        assert verdict is not None, "what is corrected was simulated"
        worst, failing = verdict.deciding, [row for row in verdict.rows if row.outcome == "FAILS"]
        if worst is None or not failing:
            return correction.Finding(verdict.passes, float("inf") if worst is None else worst.used)
        simulation = self.store.objects.get_record(state.simulation, Simulation)
        return correction.Finding(False, worst.used, control.overload(simulation, failing, self.recipe.test.material))

    def _worth(self, state: Checkpoint, target: Field) -> tuple[bool, float, bool]:
        """What makes one finished state better than another: that it passes, how much is kept, and that it passes for sure."""
        if not state.passes:
            return False, 0.0, False
        assert state.verdict is not None, "what passes was simulated"
        return True, round(self._retained(state.displacement, target), 2), state.verdict.sure

    def kept(self, state: Checkpoint) -> float:
        """Share of the finished style's target that a state keeps, by what can be seen of it; of every run, Freestyle as well."""
        return self._retained(state.displacement, self._target())

    def cuts(self) -> float:
        """Share of the surface that can be seen on which the finished style's target goes inwards."""
        areas = self.bounds.seen_areas(self.surface)
        return float(areas[self._target() < 0.0].sum() / max(areas.sum(), 1e-9))

    def _retained(self, displacement: Field, reference: Field) -> float:
        return retained_share(displacement, reference, self.bounds.seen_areas(self.surface))

    def _save(self, state: Checkpoint) -> tuple[str, Checkpointed]:
        """Store the checkpoint, then move the lane to it."""
        digest = self.store.objects.put_record(state)
        lane = self.store.lane(self.lane)
        self.store.move(self.lane, Lane(recipe=lane.recipe, head=digest, forked_from=lane.forked_from))
        return digest, Checkpointed(digest, state)


def shown(simulation: Simulation, verdict: Verdict) -> Field:
    """Stress at the surface in the test that decides [MPa], shape [vertex_count]; as placed where there is none."""
    row = verdict.deciding
    if row is None or row.test == "published rule":
        return simulation.stress
    return simulation.stress_of(landing=row.landing, load=row.load)


def retained_share(displacement: Field, reference: Field, areas: NDArray[np.float64]) -> float:
    """Share of a reference relief that is left, ⟨T, D⟩ / ⟨T, T⟩ weighted by area; 1 where the reference is flat.

    All are of shape [vertex_count]: D and T in mm, the areas that can be seen in mm².
    """
    total = float((areas * reference.astype(np.float64) ** 2).sum())
    return float((areas * reference * displacement).sum()) / total if total > 0 else 1.0
