"""The one command that makes a run again: its options are what differs from the defaults, so nobody has to remember them."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable, Collection, Sequence
from functools import partial
from itertools import pairwise
from typing import Any

import msgspec

from mechstyle.loop.store import Entry
from mechstyle.records import SETTINGS, Recipe
from mechstyle.records.material import LIBRARY, Material
from mechstyle.records.mesh import STANDARD_VERTICES
from mechstyle.records.recipe import OF_FEEDBACK, OPTIONS, settings_of
from mechstyle.records.regions import Region
from mechstyle.records.written import written
from mechstyle.runs.images import file_name
from mechstyle.runs.recipes import changed, recipe_for
from mechstyle.runs.report.run_protocol import LaneOfRun

OF_FREESTYLE = frozenset(OPTIONS) - frozenset(OF_FEEDBACK)

FIRST = ("criterion", "control", "standard", "poses")
"""Settings that bring others with them, so they are compared first."""

LENGTHS = ("height", "tolerance")
"""Settings in mm that are written with their unit."""

ANY_PROMPT = "brick"
RECORDS = re.compile(r"\b(LoadCase|Load|Support)\(")
"""Records that a setting may hold, as they are written."""

AS_THEY_ARE = settings_of("style")
"""Settings that bring nothing with them, and whose check may need what is not on this machine."""


def command_for(run: LaneOfRun, history: Sequence[Entry]) -> str:
    """The command line that makes a lane again: `mechstyle run`, then one `mechstyle branch` for each recipe it went on with."""
    recipes = _recipes(run, history)
    folder = f"again-{run.record.stem}"
    steps = [_run(run, next(iter(recipes.values())), folder)]
    parent = "main"
    for number, ((digest, old), (_, new)) in enumerate(pairwise(recipes.items()), 1):
        at = max(entry.iteration for entry in history if entry.recipe == digest)
        lane = run.lane if number == len(recipes) - 1 and run.lane != "main" else f"step-{number}"
        changes = settings_for(new, lambda old=old, **settings: changed(old, settings))
        steps.append(shlex.join(["mechstyle", "branch", f"{folder}@{parent}:{at}", "--lane", lane, *options(changes)]))
        parent = lane
    return " && ".join(steps)


def cell_for(run: LaneOfRun, history: Sequence[Entry]) -> str:
    """The same as lines of Python for a notebook."""
    recipes = _recipes(run, history)
    origin = run.record.origin
    first = next(iter(recipes.values()))
    given = settings_for(first, partial(recipe_for, ANY_PROMPT)) | {"prompt": first.style.prompt}
    reading = "".join(f", {name}={value!r}" for name, value in origin.reading.items())
    made = {"vertices": origin.vertices} if origin.vertices != STANDARD_VERTICES else {}
    model = f"ms.load({origin.model or f'{run.record.stem}.stl'!r}{reading})"
    lines = ["import mechstyle as ms", f"run = ms.stylize({', '.join([model, *_arguments(given | made)])})"]
    for (digest, old), (_, new) in pairwise(recipes.items()):
        at = max(entry.iteration for entry in history if entry.recipe == digest)
        changes = settings_for(new, lambda old=old, **settings: changed(old, settings))
        lines.append(f"run = run.branch({', '.join([str(at), *_arguments(changes)])}).go()")
    return "\n".join([*lines, "run"])


def _arguments(settings: dict[str, Any]) -> list[str]:
    """Settings as Python writes them."""
    arguments = []
    for name, value in settings.items():
        literal = RECORDS.sub(r"ms.\1(", repr(written(value) if name in LENGTHS else value))
        if isinstance(value, Material):
            literal = repr(value.name) if LIBRARY.get(value.name) == value else f"ms.{value!r}"
        elif isinstance(value, tuple) and all(isinstance(one, Region) for one in value):
            literal = repr([one.words for one in value])
        arguments.append(f"{name}={literal}")
    return arguments


def _recipes(run: LaneOfRun, history: Sequence[Entry]) -> dict[str, Recipe]:
    """The recipes of a lane, one after the other, by the digests they are stored under."""
    found = {digest: run.store.recipe(digest) for digest in dict.fromkeys(entry.recipe for entry in history)}
    if run.recipe not in found.values():
        found[run.recipe.digest] = run.recipe  # branched, but not carried on yet
    return found


def settings_for(recipe: Recipe, start: Callable[..., Recipe]) -> dict[str, Any]:
    """The settings that lead from `start`, a function of settings such as `recipe_for`, to the recipe."""

    def differing(names: Sequence[str], old: Recipe) -> dict[str, Any]:
        values = {name: value for name, _, value in old.differences(recipe) if value is not None}  # what is None cannot be asked for
        return {name: values[name] for name in names if name in values}

    given: dict[str, Any] = {}
    for names in (FIRST, [name for name in SETTINGS if name not in AS_THEY_ARE]):
        given |= differing(names, start(**given))
    return differing(AS_THEY_ARE, start()) | given


def options(settings: dict[str, Any], known: Collection[str] = OPTIONS) -> list[str]:
    """Settings as command-line arguments; `known` have an option of their own."""
    arguments: list[str] = []
    for name, value in settings.items():
        flag = name.replace("_", "-")
        if name == "material" and LIBRARY.get(value.name) == value:
            arguments += ["--material", value.name]
        elif name == "prompt":
            arguments += [f"--prompt={value}"] if value.startswith("-") else ["--prompt", value]
        elif name in LENGTHS:
            arguments += [f"--{name}", written(value)]
        elif name == "image":
            arguments += ["--image", file_name(value)]
        elif name in known and isinstance(value, bool):
            arguments.append(f"--{flag}" if value else f"--no-{flag}")
        elif name in known and isinstance(value, str | int | float):
            arguments += [f"--{flag}", str(value)]
        else:
            arguments += ["--set", f"{name}={msgspec.json.encode(value).decode()}"]
    return arguments


def _run(run: LaneOfRun, recipe: Recipe, folder: str) -> str:
    """`mechstyle run` or `mechstyle freestyle`, whichever needs fewer settings."""
    plain, free = (settings_for(recipe, partial(recipe_for, ANY_PROMPT, freestyle=freestyle)) for freestyle in (False, True))
    verb, settings, known = ("freestyle", free, OF_FREESTYLE) if len(free) < len(plain) else ("run", plain, OPTIONS)
    origin = run.record.origin
    model = origin.model or f"{run.record.stem}.stl"
    made = ["--vertices", str(origin.vertices)] if origin.vertices != STANDARD_VERTICES else []
    for name, value in origin.reading.items():
        made += [f"--{name}={value}"] if str(value).startswith("-") else [f"--{name}", str(value)]
    model = f"./{model}" if model.startswith("-") else model
    return shlex.join(["mechstyle", verb, model, *options({"prompt": recipe.style.prompt, **settings}, known), *made, "--out", folder])
