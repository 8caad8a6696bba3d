"""From what a person asks for to the recipe of a run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from typing import Any

import msgspec
import numpy as np

from mechstyle.errors import BadInput, unknown
from mechstyle.records import SETTINGS, Recipe, written
from mechstyle.records.landings import with_drops
from mechstyle.records.load_cases import load_cases
from mechstyle.records.material import Material, material_named
from mechstyle.records.recipe import DEFAULTS, TYPES, direction_of, settings_of
from mechstyle.records.regions import regions
from mechstyle.records.sliced import with_sliced
from mechstyle.runs.images import digest_of
from mechstyle.runs.stylizers import name_of, settled
from mechstyle.simulation.part import Workpiece, fitted

FREESTYLE: dict[str, Any] = {"control": "none", "schedule": "never", "base": "free", "guarantee": False}
"""Stylization without feedback: one simulation, at the end."""

PAPER: dict[str, Any] = {
    "base": "free", "guarantee": False, "transfer": "nearest", "element": "tet4", "minimum_wall": 0.0, "nearly_flat": False,
    "schedule": "stress", "contact_stiffness": 300.0,
}  # fmt: skip
"""The published method taken literally (Faruqi et al. 2025); its floor as docs/published-study.md says."""

MASKED = "stress"
"""Schedule that a control brings, unless one is asked for: a mask that nothing is simulated for never closes."""

EXPECTED = (
    "criterion paper leaves little of a style: its masks compare stress with a fifth of the yield strength, which a flat landing alone"
    " exceeds, and its rule looks at the worst single element; of brick on five models of 2500 vertices 29 % was kept once and 1.4 % or"
    " less four times, two of these failed even so, and one original failed by itself"
)
"""What is said before a run under that criterion."""

ROBUST: dict[str, Any] = {name: DEFAULTS[name] for name in PAPER}
"""What this project adds to it by default."""

PLAIN = {
    int: "a whole number, such as 40", int | None: "a whole number", float: "a number", float | None: "a number", bool: "True or False",
}  # fmt: skip
"""Types of settings that are checked here, in words; names are checked by the recipe."""


def plan(part: Workpiece, prompt: str = "", material: str | Material = "PLA", *, freestyle: bool = False, **settings: Any) -> Recipe:
    """The recipe for a part: `recipe_for` fitted to it."""
    return fitted(recipe_for(prompt, material, freestyle=freestyle, **settings), part)


def recipe_for(prompt: str = "", material: str | Material = "PLA", *, freestyle: bool = False, **settings: Any) -> Recipe:
    """A recipe for any part, so that a bad request is refused before anything slow is done.

    Args:
        prompt: The style, in words.
        material: A library name, a .toml/.json file, or a Material.
        freestyle: Whether to stylize without feedback.
        settings: Settings of a recipe that are to differ from the defaults of the criterion chosen; `sliced`, a G-code file, gives those of
            how the part is printed.

    Raises:
        BadInput: If a name is unknown or a value out of range.
    """
    given = _given({"material": material, **with_sliced(settings)})
    paper = given.get("criterion") == "paper"
    presets = {**(PAPER if paper else {}), **(FREESTYLE if freestyle else {})}
    _check_floor(given, "paper" if paper else "robust")
    chosen = with_drops({**presets, **given})
    if chosen.get("control", "none") != "none":
        chosen.setdefault("schedule", MASKED)
    chosen.setdefault("normalisation", default_normalisation(chosen.get("control", "exponential"), paper=paper))
    return settled(Recipe.of(prompt=prompt, **chosen), clip_asked_for=bool(given.get("clip")))


def changed(recipe: Recipe, changes: dict[str, Any]) -> Recipe:
    """A recipe with some settings changed; unless given, another criterion brings its presets, another control its normalisation."""
    given = with_drops(_given(with_sliced(changes)))
    if given.get("strengthen", recipe.delivery.strengthen) != recipe.delivery.strengthen:
        raise BadInput("a part is strengthened before its style, so a branch cannot do it: start a run of its own with --strengthen")
    if "amplitude" in given:
        given = {"relief": None, **given}  # which would go before it
    control, paper = given.get("control", recipe.restraint.control), given.get("criterion", recipe.test.criterion) == "paper"
    other_criterion = given.get("criterion", recipe.test.criterion) != recipe.test.criterion
    if other_criterion:
        presets = {**(PAPER if paper else ROBUST), **(FREESTYLE if control == "none" else {})}
        own = {} if recipe.schedule.when == (ROBUST if paper else PAPER)["schedule"] else {"schedule": recipe.schedule.when}
        given = {**presets, **own, **given}
    _check_floor(given, "paper" if paper else "robust")
    if given.get("control", "none") != "none" and recipe.schedule.when == "never":
        given.setdefault("schedule", MASKED)
    if other_criterion or "control" in given:
        given.setdefault("normalisation", default_normalisation(control, paper=paper))
    return settled(recipe.with_settings(**given), clip_asked_for=bool(given.get("clip")))


def brought(settings: dict[str, Any], control: str) -> dict[str, Any]:
    """Settings with what a standard, poses and a criterion among them bring, unless it is given; for whoever shows all of them.

    `control` is the one in force, unless another is given.
    """
    given = with_drops(settings)
    given |= {name: read(given[name]) for name, read in written.READERS.items() if name in given}
    if "criterion" not in given:
        return given
    paper = given["criterion"] == "paper"
    normalisation = default_normalisation(given.get("control", control), paper=paper)
    presets = PAPER if paper else {**ROBUST, "schedule": MASKED}  # who shows all settings shows the mask grow
    return {**presets, "normalisation": normalisation, **given}


def expected(recipe: Recipe) -> tuple[str, ...]:
    """What is known beforehand of a run by the published method, one sentence; nothing of any other."""
    restraint = recipe.restraint
    return (EXPECTED,) if recipe.test.criterion == "paper" and restraint.normalisation == "sigma_c" and restraint.feedback else ()


def idle(given: Mapping[str, Any], recipe: Recipe) -> tuple[str, ...]:
    """Which of the settings that were given do nothing in a recipe, one sentence each."""
    masked = recipe.restraint.feedback and recipe.schedule.when != "never"
    counts = {
        "every": (recipe.schedule.when == "every", "the schedule every"),
        "travel": (recipe.schedule.when in ("geometry", "stress"), "the schedule geometry or stress"),
        "normalisation": (masked, "masks: ask for a schedule such as stress"),
        "threshold": (masked, "masks: ask for a schedule such as stress"),
        "control": (masked or not recipe.restraint.feedback, "a schedule such as stress"),
        "poses": (recipe.test.orientations > 1, "more than one orientation"),
        **{name: (not recipe.printed.solid, "an infill below 100 %") for name in settings_of("printed") if name != "infill"},
    }
    return tuple(f"{name} does nothing without {what}" for name, (does, what) in counts.items() if name in given and not does)


def check_settings(settings: dict[str, Any]) -> None:
    """Refuse a setting no recipe has, with the nearest names."""
    for name in settings:
        if name not in SETTINGS:
            raise unknown("setting", name, SETTINGS, lists="docs/settings.md")


def check_figure(name: str, value: Any) -> None:
    """Refuse a figure that a setting cannot have, whatever the others are; what is no figure is checked with the others."""
    if TYPES[name] in PLAIN:
        Recipe.of(prompt="", **_given({"material": "PLA", name: value}))


def typed(text: str) -> tuple[str, Any]:
    """A setting and its value, written as NAME=VALUE; the value as JSON or as it is.

    BadInput if there is no such setting, or it cannot have that value.
    """
    name, equals, value = text.partition("=")
    if not equals:
        raise BadInput(f"--set {text} gives no value: write NAME=VALUE, such as travel=0.2")
    check_settings({name: value})
    if name in written.READERS:
        written.READERS[name](value)
        return name, value  # its unit decides how it is read, wherever settings come in
    kind = TYPES[name]
    for read_value in (partial(msgspec.json.decode, value, type=kind), partial(msgspec.convert, value, kind, strict=False)):
        with suppress(msgspec.MsgspecError):
            return name, read_value()
    if name == "material":
        return name, value  # a library name or a file
    raise BadInput(f"--set {text}: {name.replace('_', ' ')} cannot be {value!r}; give one it can have, such as those a report lists")


def _check_floor(given: Mapping[str, Any], criterion: str) -> None:
    """Refuse a floor that pushes softly where the floor is rigid."""
    if given.get("contact_stiffness") and criterion != "paper":
        raise BadInput(
            "contact stiffness is of the published method, elsewhere the floor is rigid: leave it out, or ask for criterion paper"
        )


def _given(settings: dict[str, Any]) -> dict[str, Any]:
    """The settings that are not None, in the types they have when read from disk: 1000 and 1000.0 must not be two recipes."""
    given = {name: _built_in(value) for name, value in settings.items() if value is not None}
    check_settings(given)
    given = {name: READERS[name](value) if name in READERS else value for name, value in given.items()}
    for name in given:
        if TYPES[name] in PLAIN:
            try:
                given[name] = msgspec.convert(given[name], TYPES[name])
            except msgspec.ValidationError as error:
                raise BadInput(f"{name.replace('_', ' ')} is {given[name]!r}, but must be {PLAIN[TYPES[name]]}") from error
    return given


def _built_in(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value


READERS: dict[str, Callable[[Any], Any]] = {
    "material": lambda value: msgspec.convert(msgspec.to_builtins(material_named(value), enc_hook=_built_in), Material),
    **written.READERS,
    "build_direction": direction_of,
    "loads": load_cases,
    "protect": regions,
    "image": digest_of,
    "stylizer": name_of,
}
"""What reads a setting that may be written in several ways."""


def default_normalisation(control: str, *, paper: bool) -> str:
    """`frozen` compares with the part's own maximum, as published; graded masks use headroom, or σ_c in the paper's preset."""
    if control == "frozen":
        return "own_max"
    return "sigma_c" if paper else "headroom"
