"""What the studies ask for: the published formative study and evaluation (Faruqi et al. 2025), and what each mechanism is worth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from types import MappingProxyType
from typing import Any

from mechstyle.errors import unknown
from mechstyle.gallery import PREFIX, entry, load, names
from mechstyle.records.mesh import STANDARD_VERTICES
from mechstyle.runs.recipes import FREESTYLE, draft
from mechstyle.study.cells import Cell

STYLES = ("brick", "stone", "cactus", "realistic", "crochet", "green")
"""The six styles of the published study, in its order."""
STUDY_CONTROLS = ("linear", "exponential", "frozen")
STUDY_SCHEDULES = ("every", "exponential", "geometry", "stress")
"""Published as linear temporal, non-linear temporal, geometry-based and stress-based."""
STUDIES = ("formative", "evaluation", "ablation")


@dataclass(frozen=True)
class Arm:
    """A way to stylize with some of the mechanisms.

    Attributes:
        about: What is left, in words.
        settings: What its recipe has different from the default.
    """

    about: str
    settings: Mapping[str, Any]


ARMS: Mapping[str, Arm] = MappingProxyType(
    {
        "freestyle": Arm("the style alone", FREESTYLE),
        "static": Arm("base and walls bounded, no feedback", {"schedule": "never", "guarantee": False}),
        "masks": Arm("masks while the relief grows, no correction", {"guarantee": False}),
        "full": Arm("masks, then corrections", {}),
        "finish-first": Arm("no masks, corrections of the finished relief", {"schedule": "never"}),
    }
)
"""The arms by name; `static` is the twin without feedback of all that follow it."""


STUDY_ARMS: Mapping[str, Arm] = MappingProxyType(
    {**ARMS, "strengthened": Arm("as full, the part first thickened by up to 2 mm where it does not hold", {"strengthen": 2.0})}
)
"""The arms a study knows."""


@dataclass(frozen=True, kw_only=True)
class Factors:
    """What is crossed in a study.

    Attributes:
        models: Names of gallery models, or files.
        styles: Prompts.
        controls: Of an evaluation.
        schedules: Of an evaluation.
        arms: Of an ablation, names of `STUDY_ARMS`.
        amplitudes: Of an ablation: half the relief's depth over local wall thickness; None is the depth that is the default.
        seeds: Seeds of the style.
        loaded: Whether an ablation is run once more under the loads of the gallery's models, where they have one.
        iterations: Stylization iterations.
        vertices: Vertices of the standardised surface.
        device: `auto`, `cpu` or `cuda`.
        settings: Other fields of the recipe, for all cells.
    """

    models: Sequence[str] = ()
    styles: Sequence[str] = STYLES
    controls: Sequence[str] = STUDY_CONTROLS
    schedules: Sequence[str] = STUDY_SCHEDULES
    arms: Sequence[str] = ("static", "masks", "full")
    amplitudes: Sequence[float | None] = (None, 0.5)
    seeds: Sequence[int] = (0,)
    loaded: bool = True
    iterations: int = 200
    vertices: int = STANDARD_VERTICES
    device: str = "auto"
    settings: Mapping[str, Any] = field(default_factory=dict)

    @property
    def addresses(self) -> list[str]:
        """The models as they are opened, all of the gallery unless told; BadInput for a name neither of a file nor in the gallery."""
        return [_address(model) for model in self.models or names()]

    def cell(self, model: str, style: str, seed: int, arm: str, **settings: Any) -> Cell:
        """A cell of these factors."""
        recipe = draft(style, **{"seed": seed, "iterations": self.iterations, **self.settings, **settings})
        return Cell(model=model, arm=arm, recipe=recipe, vertices=self.vertices, device=self.device)


def cells_of(study: str, factors: Factors) -> list[Cell]:
    """The cells of a study.

    Args:
        study: One of STUDIES.
        factors: What is crossed in it.

    Raises:
        BadInput: For a study, model, style or setting that there is not, and a file that cannot be used.
    """
    if study not in STUDIES:
        raise unknown("study", study, STUDIES)
    for model in dict.fromkeys(factors.addresses):
        if not model.startswith(PREFIX):
            load(model)  # one that cannot be used is refused before hours are spent on the others
    return {"formative": _formative, "evaluation": _evaluation, "ablation": _ablation}[study](factors)


def _formative(factors: Factors) -> list[Cell]:
    """How often a style alone breaks a part."""
    blocks = product(factors.addresses, factors.styles, factors.seeds)
    return [factors.cell(model, style, seed, "freestyle", **FREESTYLE) for model, style, seed in blocks]


def _evaluation(factors: Factors) -> list[Cell]:
    """Every control with every schedule, without corrections at the end, as published; and freely, for the loss it is compared with."""
    ways = [
        (f"{schedule} × {control}", {"control": control, "schedule": schedule, "guarantee": False})
        for schedule, control in product(factors.schedules, factors.controls)
    ]
    blocks = product(factors.addresses, factors.styles, factors.seeds)
    return [
        factors.cell(model, style, seed, arm, **settings)
        for model, style, seed in blocks for arm, settings in [("freestyle", FREESTYLE), *ways]
    ]  # fmt: skip


def _ablation(factors: Factors) -> list[Cell]:
    """Mechanisms taken away, at each depth, under the drop alone and under the load of the model's use."""
    for arm in factors.arms:
        if arm not in STUDY_ARMS:
            raise unknown("arm", arm, STUDY_ARMS)
    cells = []
    for model, style, seed, depth in product(factors.addresses, factors.styles, factors.seeds, factors.amplitudes):
        deep = {} if depth is None else {"amplitude": depth}
        for loads in _loads(model, loaded=factors.loaded):
            cells += [factors.cell(model, style, seed, arm, **{**deep, **loads, **STUDY_ARMS[arm].settings}) for arm in factors.arms]
    return cells


def _loads(model: str, *, loaded: bool) -> list[dict[str, Any]]:
    """No load, and if wanted the load of its use, if it has one."""
    use = entry(model.removeprefix(PREFIX)).use if loaded and model.startswith(PREFIX) else None
    return [{}, {"loads": [use]}] if use is not None else [{}]


def _address(model: str) -> str:
    if Path(model).suffix and not model.startswith(PREFIX):
        return model
    name = model.removeprefix(PREFIX)
    entry(name)
    return PREFIX + name
