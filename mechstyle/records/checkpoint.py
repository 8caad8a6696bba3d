"""The checkpoint of an iteration: the state needed to show it, resume from it and branch at it."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechstyle.records.mesh import frozen_array
from mechstyle.records.verdict import Verdict

RESTRAINED_BELOW = 0.5
"""A vertex counts as restrained where the mask lets less than half of its movement through."""


def restrained(mask: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Whether each vertex counts as restrained by its mask, shape [vertex_count]."""
    return mask < RESTRAINED_BELOW


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """The state after one iteration: all that is needed to show it, resume from it and branch at it.

    Attributes:
        iteration: 0 for the unstylized part, then 1 to N; corrections repeat N.
        parent: Digest of the checkpoint before it, "" for the first.
        recipe: Digest of the recipe in force.
        displacement: D_i along the original normals [mm], shape [vertex_count].
        colour: Display RGB in [0, 1], shape [vertex_count, 3]; half precision, finer than any screen, at half the disk.
        mask: Factor on further movement in [0, 1], shape [vertex_count].
        share: Factor on the style's target after corrections in [0, 1], shape [vertex_count].
        anchor: Displacement at the last simulation [mm], shape [vertex_count].
        stress: Stress of the last simulation in its worst test [MPa], shape [vertex_count].
        demand: s_norm of the last simulation, shape [vertex_count].
        simulated_at: Iteration of the last simulation.
        simulation: Digest of the stored last simulation, which also holds what stays bent, contact and all landings.
        style_loss: Loss of this very surface and its colours against the style's target.
        reason: Why this iteration was simulated, "" if it was not.
        verdict: Verdict of this iteration's simulation, None if it was not simulated.
        final: Whether the run ended with this checkpoint.
        keyframe: State of the stylizer, kept now and then so that resuming need not replay everything; None in between.
    """

    iteration: int
    parent: str
    recipe: str
    displacement: NDArray[np.float32]
    colour: NDArray[np.float16]
    mask: NDArray[np.float32]
    share: NDArray[np.float32]
    anchor: NDArray[np.float32]
    stress: NDArray[np.float32]
    demand: NDArray[np.float32]
    simulated_at: int
    style_loss: float
    simulation: str = ""
    reason: str = ""
    verdict: Verdict | None = None
    final: bool = False
    keyframe: dict[str, NDArray[np.float32]] | None = None

    def __post_init__(self) -> None:
        count = len(self.displacement)
        for field in fields(self):
            value: Any = getattr(self, field.name)
            if isinstance(value, np.ndarray):
                kind, shape = (np.float16, (count, 3)) if field.name == "colour" else (np.float32, (count,))
                object.__setattr__(self, field.name, frozen_array(value, kind, shape, field.name))

    @property
    def passes(self) -> bool:
        """Whether it was simulated and passed."""
        return self.verdict is not None and self.verdict.passes

    @property
    def restrained(self) -> NDArray[np.bool_]:
        """Whether each vertex counts as restrained, shape [vertex_count]."""
        return restrained(self.mask)
