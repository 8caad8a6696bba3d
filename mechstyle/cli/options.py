"""The options that commands share; those that set a field of the recipe are made from `Recipe`, so that both say the same."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from inspect import Parameter, Signature
from pathlib import Path
from typing import Annotated, Any

import msgspec
import typer

from mechstyle.gallery import PREFIX, use_of
from mechstyle.records.lengths import length_of, written
from mechstyle.records.recipe import DEFAULTS, Recipe, described
from mechstyle.records.regions import KINDS

STYLE, RESTRAINT, SCHEDULE, DROP_TEST = "Style", "Restraint", "Schedule", "Drop test and material"
LOADS, MACHINE = "Loads, walls and regions", "Part and machine"
"""Headings of the help."""
DEFAULTS_MAY_CHANGE = "Defaults in parentheses are the recipe's; --control, --criterion, --poses and --standard may bring others."

Model = Annotated[str, typer.Argument(metavar="MODEL", help="A file (STL, OBJ, PLY, GLB, 3MF) or gallery:NAME.")]
READ_AS = 'Add "#unit=in", "#size=120" or "#body=lid" to a file to say how it is read.'
Vertices = Annotated[
    int, typer.Option(help="Vertices of the surface; beyond 25 000 only as many as edges of 0.6 mm need.", rich_help_panel=MACHINE)
]
Device = Annotated[str, typer.Option(help="auto, cpu or cuda.", rich_help_panel=MACHINE)]
Folder = Annotated[
    Path | None,
    typer.Option("--out", help="Run directory; the same command goes on where it stopped.", rich_help_panel=MACHINE),
]
Others = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE", help="Any other setting of the recipe, such as travel=0.2. May be given several times."),
]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object on stdout and nothing else.")]

READING = {
    "unit": (str, "", "Unit of the file's coordinates: mm, cm, m, in, ft or um; by default what the format says."),
    "scale": (float | None, None, "Multiply the file's coordinates by this to get millimetres, instead of a unit."),
    "size": (float | None, None, "Longest side of the part in mm, instead of a unit: for files that have none."),
    "up": (str, "", "The file's axis that points up: z, -z, y, -y, x or -x; by default the format's own."),
    "body": (str, "", "Which body of a file that holds several, by its name or number."),
}
"""Options that say how the file of a part is read, as `gallery.load` takes them: their type, default and help."""

Settings = dict[str, Any]
"""Settings of a recipe that were given on the command line, by the names of its fields."""


@dataclass(frozen=True)
class RecipeOption:
    """The command-line option of a field of the recipe.

    Attributes:
        panel: Heading it stands under in the help.
        flags: What is typed; the field's name by default.
        kind: Type of what is typed; the field's own by default.
        hint: What is to be known on the command line besides the field's description.
        default: What it is by default, for a field without a default.
    """

    panel: str
    flags: tuple[str, ...] = ()
    kind: Any = None
    hint: str = ""
    default: Any = None


OPTIONS = {
    "prompt": RecipeOption(STYLE, ("--prompt", "-p"), hint="Not needed with --image.", default=""),
    "iterations": RecipeOption(STYLE),
    "seed": RecipeOption(STYLE),
    "relief": RecipeOption(STYLE),
    "amplitude": RecipeOption(STYLE, kind=str, hint="With `run`, auto finds the deepest that holds."),
    "side": RecipeOption(STYLE),
    "feature": RecipeOption(STYLE),
    "nozzle": RecipeOption(STYLE),
    "inside": RecipeOption(STYLE),
    "image": RecipeOption(STYLE, kind=str),
    "image_size": RecipeOption(STYLE),
    "image_as": RecipeOption(STYLE),
    "image_layout": RecipeOption(STYLE),
    "projection": RecipeOption(STYLE, ("--project", "--projection")),
    "stylizer": RecipeOption(STYLE),
    "guidance": RecipeOption(STYLE, hint="clip takes any prompt; see `mechstyle weights list`."),
    "clip": RecipeOption(STYLE, hint="A name of `mechstyle weights list`, or a folder as transformers saves one."),
    "field": RecipeOption(STYLE),
    "control": RecipeOption(RESTRAINT),
    "normalisation": RecipeOption(RESTRAINT),
    "threshold": RecipeOption(RESTRAINT),
    "schedule": RecipeOption(SCHEDULE),
    "every": RecipeOption(SCHEDULE),
    "material": RecipeOption(
        DROP_TEST, ("--material", "-m"), str, "One of the library (see `mechstyle materials`), or a .toml or .json file.", "PLA"
    ),
    "height": RecipeOption(DROP_TEST, kind=str, hint='In m, cm or mm, such as "1.5 m"; a bare number is in mm.'),
    "orientations": RecipeOption(DROP_TEST),
    "poses": RecipeOption(DROP_TEST),
    "standard": RecipeOption(DROP_TEST),
    "nearly_flat": RecipeOption(DROP_TEST),
    "build_direction": RecipeOption(DROP_TEST, kind=str),
    "criterion": RecipeOption(DROP_TEST),
    "window": RecipeOption(DROP_TEST),
    "loads": RecipeOption(LOADS, ("--load",), Path, "A .toml file, or gallery:NAME for the load of that model's use."),
    "minimum_wall": RecipeOption(LOADS),
    "strengthen": RecipeOption(LOADS),
    "base": RecipeOption(LOADS),
    "protect": RecipeOption(
        LOADS,
        kind=list[str],
        hint=f"One of: {', '.join(KINDS.values())}; then, if wanted, ramp MM and colour. May be given several times.",
    ),
}
"""The settings with an option of their own, in the order of the help; the others are given with --set."""

TYPES = {field.name: field.type for field in msgspec.structs.fields(Recipe)}


def help_of(name: str) -> str:
    """The help of a recipe's field: its description, then what the command line adds."""
    return f"{described(name)} {OPTIONS[name].hint}".rstrip()


def recipe_options(*names: str, begins: bool = True, others: bool = False) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Give a command an option for each of these fields of the recipe; those that were used reach it as one dict, `settings`.

    Args:
        names: Fields of `Recipe`.
        begins: Whether a recipe begins here: what has no default must be given then, and defaults are shown. Else a recipe is changed.
        others: Whether --set takes the other fields.
    """
    options = [_parameter(name, begins=begins) for name in OPTIONS if name in names]
    options += [Parameter("others", Parameter.KEYWORD_ONLY, annotation=Others, default=None)] if others else []

    def decorate(function: Callable[..., None]) -> Callable[..., None]:
        @functools.wraps(function)
        def wrapped(**given: Any) -> None:
            settings = {option.name: given.pop(option.name) for option in options}
            function(**given, settings=_used(**settings))

        wrapped.__signature__ = _joined(inspect.signature(function, eval_str=True), options)  # type: ignore[attr-defined]
        return wrapped

    return decorate


def reads_a_part(function: Callable[..., None]) -> Callable[..., None]:
    """Give a command the options that say how its file is read; those that were used reach it as one dict, `reading`."""
    options = [
        Parameter(
            name,
            Parameter.KEYWORD_ONLY,
            annotation=kind,
            default=typer.Option(default, help=what, rich_help_panel=MACHINE, show_default=False),
        )
        for name, (kind, default, what) in READING.items()
    ]

    @functools.wraps(function)
    def wrapped(**given: Any) -> None:
        reading = {name: value for name in READING if (value := given.pop(name)) not in (None, "")}
        function(**given, reading=reading)

    wrapped.__signature__ = _joined(inspect.signature(function, eval_str=True), options, "reading")  # type: ignore[attr-defined]
    return wrapped


def _parameter(name: str, *, begins: bool) -> Parameter:
    """The parameter from which typer makes the option for a field of the recipe."""
    known = OPTIONS[name]
    required = begins and name not in DEFAULTS and known.default is None
    shown = _shown(name) if begins and DEFAULTS.get(name) not in (None, "", ()) else True
    option = typer.Option(
        ... if required else known.default if begins else None,
        *known.flags,
        help=help_of(name),
        rich_help_panel=known.panel,
        show_default=shown,
    )
    kind = known.kind or TYPES[name]
    return Parameter(name, Parameter.KEYWORD_ONLY, annotation=kind if required else kind | None, default=option)


def _shown(name: str) -> str:
    """A default as it is typed."""
    default = DEFAULTS[name]
    if isinstance(default, bool):
        return f"--{'' if default else 'no-'}{name.replace('_', '-')}"
    return written(default) if name == "height" else str(default)


def _joined(signature: Signature, options: list[Parameter], replaced: str = "settings") -> Signature:
    """The signature of a command with these options in the place of a parameter."""
    own = [parameter.replace(kind=Parameter.KEYWORD_ONLY) for parameter in signature.parameters.values()]
    place = [parameter.name for parameter in own].index(replaced)
    return signature.replace(parameters=[*own[:place], *options, *own[place + 1 :]])


def _used(others: list[str] | None = None, **settings: Any) -> Settings:
    """The settings that were given, those of --set last."""
    used = {name: value for name, value in settings.items() if value not in (None, [])}
    if str(used.get("loads", "")).startswith(PREFIX):
        used["loads"] = [use_of(str(used["loads"]))]
    if "height" in used:
        length_of(used["height"])  # refused before anything slow; its unit goes on to where settings are read
    with suppress(KeyError, ValueError):  # what is neither a number nor auto is refused where settings are
        used["amplitude"] = float(used["amplitude"])
    if others:
        from mechstyle.runs.recipes import typed  # noqa: PLC0415 — physics is loaded when something is run

        used |= dict(typed(text) for text in others)
    return used
