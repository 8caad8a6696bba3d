"""The options that commands share; those that are settings are made from the chapters of the recipe, so that both say the same."""

from __future__ import annotations

import difflib
import functools
import inspect
from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass
from functools import partial
from inspect import Parameter, Signature
from pathlib import Path
from typing import Annotated, Any

import typer

from mechstyle.errors import BadInput
from mechstyle.gallery import PREFIX, use_of
from mechstyle.records.mesh import QUICK_VERTICES, STANDARD_VERTICES
from mechstyle.records.recipe import CHAPTER_OF, DEFAULTS, OPTIONS, SETTINGS, TYPES, described
from mechstyle.records.regions import KINDS
from mechstyle.records.sliced import SLICERS
from mechstyle.records.written import READERS, written

MACHINE = "Part and machine"
"""Heading of the options that are no settings; those that are stand under their chapter's name."""
DEFAULTS_MAY_CHANGE = "Defaults in parentheses are the recipe's; --control, --criterion, --poses and --standard may bring others."

Model = Annotated[str, typer.Argument(metavar="MODEL", help="A file (STL, OBJ, PLY, GLB, 3MF, STEP) or gallery:NAME.")]
READ_AS = 'Add "#unit=in", "#size=120" or "#body=lid" to a file to say how it is read.'
OF_MACHINE = partial(typer.Option, rich_help_panel=MACHINE)
DETAIL = "Vertices of the surface, 500 to 400 000; beyond 25 000 only as many as edges of 0.6 mm need."
Vertices = Annotated[int, OF_MACHINE(help=DETAIL)]
RunVertices = Annotated[
    int | None, OF_MACHINE("--vertices", help=DETAIL, show_default=f"{STANDARD_VERTICES}; {QUICK_VERTICES} with --quick")
]
Quick = Annotated[bool, OF_MACHINE("--quick", help="A first answer in about a minute: the same tests on fewer vertices.")]
Device = Annotated[str, OF_MACHINE(help="auto, cpu or cuda.")]
REGIONS = f"A region is one of: {', '.join(KINDS.values())}; then, if wanted, ramp MM and colour."
Folder = Annotated[Path | None, OF_MACHINE("--out", help="Run directory; the same command goes on where it stopped.")]
Others = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE", help="Any other setting of the recipe, such as travel=0.2. May be given several times."),
]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object on stdout and nothing else.")]
Details = Annotated[bool, typer.Option("--details", help="Print every landing, note, file and time as well.")]


def _help_all(context: typer.Context, wanted: bool) -> None:
    """Show the help with the options that it leaves out otherwise."""
    if wanted:
        for option in context.command.params:
            option.hidden = False  # type: ignore[attr-defined]
        typer.echo(context.get_help())
        raise typer.Exit


HelpAll = Annotated[
    bool, typer.Option("--help-all", callback=_help_all, is_eager=True, help="Show every option, also those that few need, and exit.")
]
COMMON = frozenset(("prompt", "image", "relief", "feature", "protect", "control", "material", "height", "tolerance", "loads", "strengthen"))
"""Settings whose options stand in the short help of a command that has a long one."""

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
    """How a setting is typed on the command line, where that is not as the recipe has it.

    Attributes:
        flags: What is typed; the setting's name by default.
        kind: Type of what is typed; the setting's own by default.
        hint: What is to be known on the command line besides the setting's description.
        default: What it is by default, for a setting without a default.
    """

    flags: tuple[str, ...] = ()
    kind: Any = None
    hint: str = ""
    default: Any = None


TYPED: dict[str, RecipeOption] = {
    "prompt": RecipeOption(("--prompt", "-p"), hint="Not needed with --image.", default=""),
    "image": RecipeOption(kind=str),
    "projection": RecipeOption(("--project", "--projection")),
    "guidance": RecipeOption(hint="clip takes any prompt; see `mechstyle weights list`."),
    "clip": RecipeOption(hint="A name of `mechstyle weights list`, or a folder as transformers saves one."),
    "material": RecipeOption(("--material", "-m"), str, "One of the library (see `mechstyle materials`), or a .toml or .json file.", "PLA"),
    "height": RecipeOption(kind=str, hint='In m, cm or mm, such as "1.5 m"; a bare number is in mm.'),
    "tolerance": RecipeOption(kind=str, hint='In mm or µm, such as "0.2 mm".'),
    "build_direction": RecipeOption(kind=str),
    "infill": RecipeOption(kind=str, hint='Such as "15 %".'),
    "loads": RecipeOption(("--load",), Path, "A .toml file, or gallery:NAME for the load of that model's use."),
    "protect": RecipeOption(
        kind=list[str],
        hint='Such as inside, holes, "rim 5" or "bottom 3"; the help of `mechstyle protect` lists all. May be given several times.',
    ),
}
"""The options that are typed otherwise than the recipe has them."""


def panel_of(name: str) -> str:
    """The heading a setting stands under in the help: its chapter's name."""
    return CHAPTER_OF[name].capitalize()


def recipe_options(
    *names: str, begins: bool = True, others: bool = False, short: bool = False
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Give a command an option for each of these fields of the recipe; those that were used reach it as one dict, `settings`.

    Args:
        names: Settings of a recipe.
        begins: Whether a recipe begins here: what has no default must be given then, and defaults are shown. Else a recipe is changed.
        others: Whether --set takes the other fields.
        short: Whether the help leaves out what is not COMMON; --help-all then shows it.
    """
    options = [_parameter(name, begins=begins, hidden=short and name not in COMMON) for name in OPTIONS if name in names]
    options += [Parameter("help_all", Parameter.KEYWORD_ONLY, annotation=HelpAll, default=False)] if short else []
    options += [_sliced(hidden=short)] if "infill" in names else []
    options += [Parameter("others", Parameter.KEYWORD_ONLY, annotation=Others, default=None)] if others else []

    def decorate(function: Callable[..., None]) -> Callable[..., None]:
        @functools.wraps(function)
        def wrapped(**given: Any) -> None:
            settings = {option.name: given.pop(option.name) for option in options}
            settings.pop("help_all", None)
            _check_no_option(settings.get("others") or (), {*given, *READING} - {"reading", "model"})
            function(**given, settings=_used(**settings))

        wrapped.__signature__ = _joined(inspect.signature(function, eval_str=True), options)  # type: ignore[attr-defined]
        return wrapped

    return decorate


def reads_a_part(function: Callable[..., None]) -> Callable[..., None]:
    """Give a command the options that say how its file is read; those that were used reach it as one dict, `reading`."""
    options, short = [], any(one.name == "help_all" for one in inspect.signature(function, eval_str=True).parameters.values())
    for name, (kind, default, what) in READING.items():
        option = OF_MACHINE(default, help=what, show_default=False, hidden=short)
        options.append(Parameter(name, Parameter.KEYWORD_ONLY, annotation=kind, default=option))

    @functools.wraps(function)
    def wrapped(**given: Any) -> None:
        reading = {name: value for name in READING if (value := given.pop(name)) not in (None, "")}
        function(**given, reading=reading)

    wrapped.__signature__ = _joined(inspect.signature(function, eval_str=True), options, "reading")  # type: ignore[attr-defined]
    return wrapped


def _parameter(name: str, *, begins: bool, hidden: bool = False) -> Parameter:
    """The parameter from which typer makes the option for a field of the recipe."""
    known = TYPED.get(name, RecipeOption())
    required = begins and name not in DEFAULTS and known.default is None
    default: Any = DEFAULTS.get(name)
    shown = str(default)  # as it is typed
    if isinstance(default, bool):
        shown = f"--{'' if default else 'no-'}{name.replace('_', '-')}"
    elif name in READERS:
        shown = f"{100.0 * default:g} %" if name == "infill" else written(default)
    option = typer.Option(
        ... if required else known.default if begins else None,
        *known.flags,
        help=f"{described(name)} {known.hint}".rstrip(),
        rich_help_panel=panel_of(name),
        hidden=hidden,
        show_default=shown if begins and default not in (None, "", ()) else True,
    )
    kind = known.kind or TYPES[name]
    return Parameter(name, Parameter.KEYWORD_ONLY, annotation=kind if required else kind | None, default=option)


def _sliced(*, hidden: bool) -> Parameter:
    """The option that reads how a part is printed from what a slicer made of it."""
    known = f"Read walls, layers and infill from the G-code of {', '.join(SLICERS)}; options beside it go before it."
    option = typer.Option("--sliced", metavar="FILE", help=known, rich_help_panel=panel_of("infill"), hidden=hidden)
    return Parameter("sliced", Parameter.KEYWORD_ONLY, annotation=Annotated[Path | None, option], default=None)


def _joined(signature: Signature, options: list[Parameter], replaced: str = "settings") -> Signature:
    """The signature of a command with these options in the place of a parameter."""
    own = [parameter.replace(kind=Parameter.KEYWORD_ONLY) for parameter in signature.parameters.values()]
    place = [parameter.name for parameter in own].index(replaced)
    return signature.replace(parameters=[*own[:place], *options, *own[place + 1 :]])


def _check_no_option(others: Iterable[str], options: Collection[str]) -> None:
    """Refuse for --set what is an option by itself, however misspelt, and no setting of the recipe."""
    for name in (text.partition("=")[0] for text in others):
        near = difflib.get_close_matches(name, [*SETTINGS, *options], n=1)
        if near and near[0] in options:
            raise BadInput(f"--set {name}: no setting of the recipe, but an option of its own: write --{near[0].replace('_', '-')}")


def _used(others: list[str] | None = None, **settings: Any) -> Settings:
    """The settings that were given, those of --set last."""
    used = {name: value for name, value in settings.items() if value not in (None, [])}
    if str(used.get("loads", "")).startswith(PREFIX):
        used["loads"] = [use_of(str(used["loads"]))]
    for name, read in READERS.items():
        if name in used:
            read(used[name])  # refused before anything slow; its unit goes on to where settings are read
    if others:
        from mechstyle.runs.recipes import typed  # noqa: PLC0415 — physics is loaded when something is run

        used |= dict(typed(text) for text in others)
    return used
