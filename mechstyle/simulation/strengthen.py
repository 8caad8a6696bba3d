"""A part that does not hold as it is, thickened where it is overloaded, before any style: along its normals, smoothly, within a budget.

What the published study leaves as future work. A wall of thickness t under a bending moment bears σ ∝ 1/t², so it is thickened by
t (√overload − 1), half of it on each side, a round at a time: every round is tested on the displaced part, and loads keep to the places
they were picked at on the unthickened part.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mechstyle.fea.drop import resolve_device
from mechstyle.fea.explicit import no_progress
from mechstyle.geometry.cancelling import CancelCheck, never_cancel
from mechstyle.geometry.region_selection import protection
from mechstyle.geometry.resting_face import resting_weight
from mechstyle.loop import control
from mechstyle.records import Recipe, Simulation, Verdict, judge, sentences
from mechstyle.records.material import Material
from mechstyle.records.mesh import STANDARD_VERTICES, SurfaceMesh
from mechstyle.simulation.part import Stage, Workpiece, cached_memo, fitted, prepare
from mechstyle.simulation.simulator import DropSimulator

if TYPE_CHECKING:
    from scipy.sparse import csr_array

ROUNDS = 6
"""Simulations after the first at most."""
AIM = 0.85
"""Overload that a round aims at: below 1, since stress moves on to what was not thickened."""
REACH = 4.0
"""How far around what is overloaded material is added, fading out [mm]."""
LEAST = 0.02
"""A round that adds less than this anywhere is the last [mm]."""
ONCE = 0.25
"""Share of the budget that one round may add at most, so that the next can see what it did."""


@dataclass(frozen=True, eq=False)
class Strengthened:
    """A part, before and thickened.

    Attributes:
        part: The prepared part before.
        recipe: Material, drop, loads and budget.
        added: What was added along the normals [mm], shape [vertex_count].
        before: The test of the part before.
        after: The test of the thickened part.
        rounds: Simulations that were needed besides the first.
    """

    part: Workpiece
    recipe: Recipe
    added: NDArray[np.float32]
    before: Simulation
    after: Simulation
    rounds: int

    @cached_property
    def surface(self) -> SurfaceMesh:
        """The thickened surface."""
        return self.part.surface.displaced(self.added)

    @property
    def result(self) -> SurfaceMesh | Workpiece:
        """What is to be styled: the thickened surface, or the part before where nothing was added."""
        return self.surface if self.added.any() else self.part

    def noted(self, part: Workpiece) -> Workpiece:
        """A part that was prepared of the result, with a note on what was done and the mass it gained."""
        return replace(part, notes=tuple(dict.fromkeys((*part.notes, self.words))), mass_gained=self.mass_gained)

    @property
    def verdicts(self) -> tuple[Verdict, Verdict]:
        """Whether the part holds, before and thickened."""
        return judge(self.before, None, self.recipe), judge(self.after, None, self.recipe)

    @property
    def mass_gained(self) -> float:
        """What it weighs more, printed solid [g]."""
        return float((self.surface.volume - self.part.surface.volume) * self.recipe.test.material.density)

    @property
    def words(self) -> str:
        """What was done, in one sentence."""
        before, after = self.verdicts
        bends = f"{sentences.least(before)}, then {sentences.least(after)}"
        if not self.added.any():
            why = {"HOLDS": "it holds as it is", "FAILS": "there is nothing that may be"}.get(before.outcome, "its test gave no answer")
            return f"it was not thickened: {why}"
        share = self.mass_gained / (self.part.surface.volume * self.recipe.test.material.density)
        held = "it holds" if after.passes else f"it still does not hold within {self.recipe.delivery.strengthen:g} mm"
        if after.passes and not after.sure:
            held = f"it only just holds, within {self.recipe.delivery.strengthen:g} mm"
        added = f"by up to {self.added.max():.2f} mm, {self.mass_gained:.1f} g ({share:+.1%})"
        return f"it was thickened {added}: {bends}: {held}"


def strengthened(
    mesh: SurfaceMesh | Workpiece,
    recipe: Recipe,
    *,
    vertices: int = STANDARD_VERTICES,
    device: str = "auto",
    stage: Stage = no_progress,
    prepare: Callable[..., Workpiece] = prepare,
    go_on: CancelCheck = never_cancel,
) -> Strengthened:
    """Thicken a part where it is overloaded, along its normals, until it holds or the budget is spent.

    Args:
        mesh: A closed surface [mm], z up, as it stands, or a part that is prepared.
        recipe: Material, drop, loads, protected regions, and `strengthen`, the most that is added [mm].
        vertices: Vertices of the standardised surface.
        device: `auto`, `cpu` or `cuda`.
        stage: Called with what is being done, in words.
        prepare: What prepares a surface, `simulation.part.prepare` or a function like it.
        go_on: Asked several times a second whether to, in a drop, too; what it raises ends the work.

    Raises:
        BadInput: If the part, a region or a load cannot be used.
    """
    part = mesh if isinstance(mesh, Workpiece) else prepare(mesh, vertices=vertices, stage=stage, go_on=go_on)
    plain = fitted(recipe, part)
    memo, where = cached_memo(), resolve_device(device)

    def asking(_fraction: float) -> None:
        go_on()

    simulator = DropSimulator(part, plain, memo, memo, where, asking)
    free = _freedom(part, recipe)
    added = np.zeros(len(part.surface.vertices), np.float32)
    stage("testing the part")
    before = after = simulator.simulate(added, thorough=True)
    for turn in range(ROUNDS + 1):
        verdict = judge(after, None, plain)
        holds = verdict.outcome != "FAILS" and (turn == 0 or verdict.sure)  # meshed again it may read a little more
        if turn == ROUNDS or holds:
            break
        most = plain.delivery.strengthen
        more = np.minimum(added + _wanted(part, after, verdict, plain.test.material, most) * free, most).astype(np.float32)
        if float((more - added).max()) < LEAST:
            break
        added = more
        stage(f"thickening it, round {turn + 1}")
        after = simulator.simulate(added, thorough=True)
    return Strengthened(part, plain, added, before, after, turn)


def _freedom(part: Workpiece, recipe: Recipe) -> NDArray[np.float64]:
    """Factor on what is added: 0 in protected regions and on what the part stands on."""
    held = protection(recipe.restraint.protect, part.surface, part.thickness).freedom if recipe.restraint.protect else 1.0
    return np.asarray(resting_weight(part.surface, low=0.5, high=3.0) * held)


def _wanted(part: Workpiece, found: Simulation, verdict: Verdict, material: Material, budget: float) -> NDArray[np.float64]:
    """What a round adds along the normals [mm], shape [vertex_count]: by overload, spread around where it yields and fading out."""
    overload = control.overload(found, [row for row in verdict.rows if row.outcome == "FAILS" or not row.sure], material)
    lacking = 0.5 * part.thickness * (np.sqrt(np.maximum(overload.astype(np.float64) / AIM, 1.0)) - 1.0)
    means = _neighbour_means(part.surface)
    rounds = max(1, round(REACH / float(np.sqrt(part.surface.vertex_areas.mean()))))
    spread = np.minimum(lacking, ONCE * budget)
    for _ in range(rounds):  # the largest nearby, so that smoothing takes nothing off the peak …
        spread = part.surface.dilated(spread)
    for _ in range(2 * rounds):  # … then smooth
        spread = means @ spread
    return np.asarray(spread)


def _neighbour_means(surface: SurfaceMesh) -> csr_array:
    """The mean of a vertex and its neighbours, as a matrix [vertex_count, vertex_count]."""
    from scipy import sparse  # noqa: PLC0415 — loaded when something is thickened

    count, (one, other) = len(surface.vertices), surface.edges.T
    links = sparse.coo_array((np.ones(2 * len(one)), (np.r_[one, other], np.r_[other, one])), (count, count)) + sparse.eye_array(count)
    links = links.tocsr()
    return sparse.diags_array(1.0 / links.sum(axis=1)) @ links
