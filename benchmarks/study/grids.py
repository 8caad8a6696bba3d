"""The cells of each study: the published formative study and evaluation (Faruqi et al. 2025), and what each mechanism is worth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from pathlib import Path
from types import MappingProxyType
from typing import Any

import msgspec

from benchmarks.study.cells import Cell
from mechstyle.errors import BadInput, unknown
from mechstyle.gallery import PREFIX, entry, load, names
from mechstyle.records.mesh import STANDARD_VERTICES
from mechstyle.runs.recipes import FREESTYLE, recipe_for

STYLES = ("brick", "stone", "cactus", "realistic", "crochet", "green")
"""The six styles of the published study, in its order."""
STUDY_CONTROLS = ("linear", "exponential", "frozen")
STUDY_SCHEDULES = ("every", "exponential", "geometry", "stress")
"""Published as linear temporal, non-linear temporal, geometry-based and stress-based."""
STUDIES = ("formative", "evaluation", "ablation", "calibration", "sensitivity")
NAMED = (("pen_holder", "brick"), ("phone_stand", "brick"))
"""The cells that the published study describes: the first at about four times yield, its plain part below; the second viable."""
FLOORS = (10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0, 0.0)
"""Stiffnesses of a penalty floor at each node [N/mm], a rigid one last."""
MOVED: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "as published": {},
        "element tet10": {"element": "tet10"},
        "relief 0.3 mm": {"relief": 0.3},
        "relief 1.2 mm": {"relief": 1.2},
        "plain base": {"base": "plain"},
    }
)
"""What moves the share, one thing at a time: settings of a free run under the published rule; `sensitivity` adds coarser meshes."""
COARSER = (8_000, 16_000)
"""Tetrahedra of these."""


@dataclass(frozen=True)
class Arm:
    """A way to stylize with some of the mechanisms: what is left, and what its recipe has different from the default."""

    about: str
    settings: Mapping[str, Any]
    one_factor: bool = False


STATIC: Mapping[str, Any] = {"schedule": "never", "guarantee": False}
ARMS: Mapping[str, Arm] = MappingProxyType(
    {
        "freestyle": Arm("the published free method, the style alone", FREESTYLE),
        "static": Arm("plain base and thinnest wall, no simulation before the end", STATIC),
        "one-factor": Arm("as static, then one factor on the whole relief, the largest that passes", STATIC, one_factor=True),
        "finish-first": Arm("no masks, corrections of the finished relief", {"schedule": "never", "guarantee": True}),
        "masks": Arm("masks while the relief grows, then corrections", {"schedule": "stress", "guarantee": True}),
    }
)
"""The arms by name; `static` is the twin without feedback of those that follow it."""

STUDY_ARMS: Mapping[str, Arm] = MappingProxyType(
    {
        **ARMS,
        "strengthened": Arm(
            "as masks, the part first thickened by up to 2 mm where it does not hold", {**ARMS["masks"].settings, "strengthen": 2.0}
        ),
    }
)
"""The arms a study knows."""


@dataclass(frozen=True)
class Condition:
    """What is asked of a part, and how deep its style is.

    Attributes:
        about: The condition in words.
        settings: What its recipe has different from the default.
        load_share: Share of what the plain part carries that the load of its use is scaled to; 0 for no load.
    """

    about: str
    settings: Mapping[str, Any] = field(default_factory=dict)
    load_share: float = 0.0


CONDITIONS: Mapping[str, Condition] = MappingProxyType(
    {
        "drop": Condition("the fall alone"),
        "load": Condition("the fall, and the load of its use at 0.85 of what the plain part carries", load_share=0.85),
        "deep": Condition("the fall alone, relief half the wall deep", {"amplitude": 0.25}),
    }
)
"""The conditions of an ablation by name; an amplitude is half a depth."""


@dataclass(frozen=True, kw_only=True)
class Factors:
    """What is crossed in a study: parts (gallery models or files), prompts and seeds; and what all its cells have.

    On `floors` finished parts are dropped again, under the published rule. Controls and schedules are those of an evaluation, arms and
    conditions, names of `STUDY_ARMS` and `CONDITIONS`, of an ablation.
    """

    models: Sequence[str] = ()
    styles: Sequence[str] = STYLES
    controls: Sequence[str] = STUDY_CONTROLS
    schedules: Sequence[str] = STUDY_SCHEDULES
    arms: Sequence[str] = tuple(ARMS)
    conditions: Sequence[str] = tuple(CONDITIONS)
    seeds: Sequence[int] = (0,)
    iterations: int = 200
    vertices: int = STANDARD_VERTICES
    device: str = "auto"
    tetrahedra: int = 0
    floors: Sequence[float] = ()
    settings: Mapping[str, Any] = field(default_factory=dict)

    @property
    def addresses(self) -> list[str]:
        """The models as they are opened, all of the gallery if there are none; BadInput for a name neither of a file nor in the gallery."""
        found = []
        for model in self.models or names():
            if Path(model).suffix and not model.startswith(PREFIX):  # a file
                found.append(model)
            else:
                name = model.removeprefix(PREFIX)
                entry(name)  # refuses one that there is not
                found.append(PREFIX + name)
        return found

    def cell(self, model: str, style: str, seed: int, arm: str, **settings: Any) -> Cell:
        """A cell of these factors."""
        recipe = recipe_for(style, **{"seed": seed, "iterations": self.iterations, **self.settings, **settings})
        floors = tuple(self.floors) if recipe.restraint.control == "none" else ()
        return Cell(
            model=model, arm=arm, recipe=recipe, vertices=self.vertices, device=self.device, tetrahedra=self.tetrahedra, floors=floors
        )


def cells_of(study: str, factors: Factors) -> list[Cell]:
    """The cells of one of STUDIES: a style alone, every control with every schedule, or each arm under each condition.

    Raises:
        BadInput: For a study, model, style or setting that there is not, and a file that cannot be used.
    """
    if study not in STUDIES:
        raise unknown("study", study, STUDIES)
    for model in dict.fromkeys(factors.addresses):
        if not model.startswith(PREFIX):
            load(model)  # one that cannot be used is refused before hours are spent on the others
    if study == "ablation":
        return _ablation(factors)
    if study == "calibration":
        return [replace(factors, models=[model]).cell(PREFIX + model, style, 0, "freestyle", **FREESTYLE) for model, style in NAMED]
    blocks = list(product(factors.addresses, factors.styles, factors.seeds))
    if study == "sensitivity":
        cells = [factors.cell(*block, name, **{**FREESTYLE, **moved}) for block in blocks for name, moved in MOVED.items()]
        coarse = (replace(factors, tetrahedra=count) for count in COARSER)
        return cells + [one.cell(*block, f"{one.tetrahedra} tetrahedra", **FREESTYLE) for one in coarse for block in blocks]
    arms: list[tuple[str, dict[str, Any]]] = [("freestyle", FREESTYLE)]
    if study == "evaluation":  # without corrections at the end, as published; and freely, for the loss it is compared with
        ways = product(factors.schedules, factors.controls)
        arms += [(f"{one} × {control}", {"control": control, "schedule": one, "guarantee": False}) for one, control in ways]
    return [factors.cell(model, style, seed, arm, **settings) for model, style, seed in blocks for arm, settings in arms]


def _ablation(factors: Factors) -> list[Cell]:
    """Each arm under each condition; parts that carry nothing are left out where a load is asked for.

    Cells that ask for the same tetrahedra stand apart, so that processes side by side do not make them at the same time.
    """
    for what, asked, known in (("arm", factors.arms, STUDY_ARMS), ("condition", factors.conditions, CONDITIONS)):
        for name in asked:
            if name not in known:
                raise unknown(what, name, known)
    blocks = product(factors.addresses, factors.arms, factors.conditions, factors.styles, factors.seeds)
    cells = [_under(factors, *block) for block in blocks if not CONDITIONS[block[2]].load_share or _loads(factors, block[0])]
    if not cells:
        raise BadInput("none of these parts carries a load in its use: name a load file, or ask for another condition than load")
    return cells


def _under(factors: Factors, model: str, arm: str, condition: str, style: str, seed: int) -> Cell:
    asked = CONDITIONS[condition]
    loads = _loads(factors, model) if asked.load_share else ()
    cell = factors.cell(model, style, seed, arm, **{**asked.settings, "loads": loads, **STUDY_ARMS[arm].settings})
    one_factor = STUDY_ARMS[arm].one_factor
    return msgspec.structs.replace(cell, condition=condition, load_share=asked.load_share, one_factor=one_factor)


def _loads(factors: Factors, model: str) -> Any:
    """The load cases of a part: those given for all parts, or the load of its use; none where it carries nothing."""
    use = entry(model.removeprefix(PREFIX)).use if model.startswith(PREFIX) else None
    return factors.settings.get("loads") or ([] if use is None else [use])
