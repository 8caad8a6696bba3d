"""Events of a run as frozen values: the command line prints them, widgets show them, tests list them."""

from __future__ import annotations

from dataclasses import dataclass

from mechstyle.records import Checkpoint, Simulation, Verdict


@dataclass(frozen=True)
class Stylized:
    """The stylizer proposed and the mask let part of it through.

    Attributes:
        iteration: 1 to the recipe's iterations.
        style_loss: Loss of the surface as it now is.
        moved: Largest movement of a vertex in this iteration [mm].
    """

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
    """A drop test ended.

    Attributes:
        iteration: Iteration simulated.
        reason: Why.
        simulation: What was measured.
        verdict: What it means.
        restrained: Share of the vertices that count as restrained.
    """

    iteration: int
    reason: str
    simulation: Simulation
    verdict: Verdict
    restrained: float


@dataclass(frozen=True)
class Corrected:
    """The finished relief was lowered, because it failed, or raised, because it passed; a simulation of the result follows.

    Attributes:
        step: What was changed, in words.
        kept: Share of what the style asks for that is left.
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
    """The run is complete; the last checkpoint is the surface that was simulated last.

    Attributes:
        verdict: Verdict on it.
        digest: Digest of the last checkpoint.
    """

    verdict: Verdict
    digest: str


Event = Stylized | SimulationStarted | Simulated | Corrected | Checkpointed | Finished
