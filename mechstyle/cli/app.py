"""All commands together, their help and what is wrong with a command line."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated, Any

import typer
from rich.markup import escape
from typer.core import TyperGroup

from mechstyle import __version__
from mechstyle.cli import demo, doctor, finished, inspect_run, lists, run, simulate, studio, weights
from mechstyle.cli.console import print_json

UsageError: type[Exception] = typer.BadParameter.__bases__[0]
"""What is wrong with a command line: Click's, or that of the Click within newer versions of typer."""
NUMBERS = re.compile(r"Input should be a valid (integer|number), unable to parse string as (?:an integer|a number)")
NUMBER = {"integer": "give a whole number, such as 40", "number": "give a number, such as 1.5"}
"""What is said of a word where a number must stand."""
AS_JSON = "mechstyle.as_json"
"""What a context remembers of the command line, of which nothing is left once it is parsed."""
PANELS = {
    "Style and test": ("studio", "run", "freestyle", "branch", "simulate"),
    "Look at a run, take it out": ("log", "show", "report", "film", "export", "orient", "rerun", "gc"),
    "What there is to choose from": ("gallery", "styles", "materials", "protect", "weights", "doctor"),
    "Lessons and research": ("demo", "class"),
}
"""Every command, by the heading it has in the help."""


class PlainHelp(TyperGroup):
    """Commands whose help is plain text: [mm] in it is a unit, though typer would have rich read it as markup."""

    def __init__(self, **attributes: Any) -> None:
        """Take the commands over; their help is marked as plain and put under headings."""
        super().__init__(**attributes)
        _mark_as_plain(self)
        for panel, names in PANELS.items():
            for name in names:
                command = self.commands[name] = self.commands.pop(name)
                command.rich_help_panel = panel  # type: ignore[attr-defined]

    def make_context(self, info_name: str | None, args: list[str], parent: Any = None, **extra: Any) -> Any:
        """Parse what stands before the command."""
        as_json = "--json" in args
        with _usage_errors(as_json):
            context = super().make_context(info_name, args, parent, **extra)
        context.meta[AS_JSON] = as_json
        return context

    def invoke(self, ctx: Any) -> Any:
        """Parse the rest and run the command."""
        with _usage_errors(ctx.meta[AS_JSON]):
            return super().invoke(ctx)


@contextmanager
def _usage_errors(as_json: bool) -> Iterator[None]:
    """With --json what is wrong with a command line is JSON on standard output as well, as every other refusal is."""
    try:
        yield
    except UsageError as error:
        error.message = NUMBERS.sub(lambda found: NUMBER[found[1]], error.message)  # type: ignore[attr-defined]
        if as_json:
            print_json({"error": error.format_message()})  # type: ignore[attr-defined]
        raise


def _mark_as_plain(command: Any) -> None:
    """Escape the help of a command, of what it takes and of the commands below it."""
    for documented in (command, *command.params):
        if documented.help:
            documented.help = escape(documented.help)
    if getattr(command, "epilog", None):
        command.epilog = escape(command.epilog)
    for below in getattr(command, "commands", {}).values():
        _mark_as_plain(below)


app = typer.Typer(
    name="mechstyle",
    cls=PlainHelp,
    help="Style a 3D-printable model from a prompt while a drop test watches its strength. Lengths in mm, stresses in MPa.",
    context_settings={"help_option_names": ["-h", "--help"]},
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
)
for family in (run, simulate, demo, inspect_run, finished, lists, doctor, weights, studio):
    app.add_typer(family.app)


def _say_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"mechstyle {__version__}")
        raise typer.Exit


@app.callback()
def options_of_all(
    *,
    version: Annotated[bool, typer.Option("--version", callback=_say_version, is_eager=True, help="Show the version and exit.")] = False,
) -> None:
    """Options that stand before a command."""
