"""As deep as it can be: the deepest of several reliefs that passes as it is, without masks and corrections, and what limits it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mechstyle.errors import BadInput
from mechstyle.fea.explicit import no_progress
from mechstyle.records import Verdict
from mechstyle.records.material import Material
from mechstyle.records.mesh import STANDARD_VERTICES, SurfaceMesh
from mechstyle.runs.recipes import draft
from mechstyle.runs.run import started
from mechstyle.simulation.part import Stage, Warn, Workpiece, logged, prepare

DEPTHS = (0.15, 0.25, 0.4, 0.6, 0.8)
"""Amplitudes that are tried."""

ALONE = {"schedule": "never", "guarantee": False}
"""A relief as it is drawn, dropped once."""


@dataclass(frozen=True)
class Depth:
    """The deepest relief that passes: half of it over local wall thickness, and what limits it, in one sentence."""

    amplitude: float
    words: str


def deepest(
    mesh: SurfaceMesh, prompt: str = "", *,
    material: str | Material = "PLA", vertices: int = STANDARD_VERTICES, out: str | Path, device: str = "auto",
    depths: Sequence[float] = DEPTHS, stage: Stage = no_progress, prepare: Callable[..., Workpiece] = prepare, warn: Warn = logged,
    **settings: Any,
) -> Depth:  # fmt: skip
    """Find the deepest of several reliefs that passes as it is drawn; the trials stay in a run directory of their own, a lane each.

    A trial is judged as any run is at its end: by the surface that would be delivered. What was tried in `out` before is read.
    Arguments are those of `runs.run.stylize` and `started`; `depths` are amplitudes, ascending.

    Raises:
        BadInput: If the part, the prompt or a setting cannot be used.
    """
    if settings.get("relief") is not None:
        raise BadInput(f"a relief of {settings['relief']:g} mm is asked for, and the deepest that passes: leave out one of them")
    wanted = draft(prompt, material, **{**settings, **ALONE, "amplitude": depths[-1]})
    run = started(wanted, mesh, vertices=vertices, out=out, device=device, stage=stage, prepare=prepare, warn=warn)

    def verdict(depth: float) -> Verdict:
        stage(f"trying a relief of {depth:g} of the wall")
        whole = depth == run.recipe.style.amplitude  # the run itself, which the others branch off from before its first iteration
        return (run if whole else run.branch(0, lane=f"depth-{depth:g}", amplitude=depth)).go().verdict

    return deepest_of(depths, verdict)


def deepest_of(depths: Sequence[float], verdict: Callable[[float], Verdict]) -> Depth:
    """The deepest of ascending depths that passes, by bisection, which assumes that a shallower relief passes where one does."""
    found = verdict(depths[-1])
    if found.passes:
        return Depth(depths[-1], f"{depths[-1]:g} of the wall is the deepest relief that was tried, and it passes")
    passes, fails, why = -1, len(depths) - 1, found.words
    while fails - passes > 1:
        middle = (passes + fails) // 2
        found = verdict(depths[middle])
        if found.passes:
            passes = middle
        else:
            fails, why = middle, found.words
    if passes < 0:
        return Depth(depths[0], f"even {depths[0]:g} of the wall does not pass without correction ({why})")
    return Depth(depths[passes], f"{depths[passes]:g} of the wall is the deepest relief that passes as it is; at {depths[fails]:g}: {why}")
