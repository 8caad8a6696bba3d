"""The pages of the site that are made of the code: every command, setting, public name and word, and a report."""

import inspect
import json
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import typer

import mechstyle
from mechstyle.cli.app import app
from mechstyle.records.recipe import CHAPTERS, CHOICES, DEFAULTS, LIMITS, described, settings_of
from mechstyle.records.words import WORDS
from mechstyle.runs.run import Run

ROOT = Path(__file__).resolve().parent.parent.parent
REPORT = "example-report.html"
DIRECTIVES = {"Functions": "autofunction", "Classes": "autoclass", "Errors": "autoexception"}
"""What Sphinx reads the docstrings of public names by."""


def commands(command: Any, name: str = "mechstyle") -> Iterator[tuple[str, Any]]:
    """Every command that does something, by what one types."""
    below = getattr(command, "commands", {})
    if not below:
        yield name, command
    for word, one in below.items():
        yield from commands(one, f"{name} {word}")


def command_line(*_: object) -> str:
    """A section for each command, with its arguments and options; an option is described where it comes first."""
    described: dict[str, str] = {}
    return "\n\n".join(_of_command(name, command, described) for name, command in commands(typer.main.get_command(app)))


def _of_command(name: str, command: Any, described: dict[str, str]) -> str:
    """Its section; `described` has the command in which an option was described, by the option with its help."""
    arguments = [one for one in command.params if one.param_type_name == "argument"]
    typed = " ".join([name, *map(_metavar, arguments), "[OPTIONS]"])
    rows, again = list[str](), dict[str, list[str]]()
    for one in (one for one in command.params if one.name != "help"):
        said = f"{_called(one)} {one.help}"
        if (first := described.setdefault(said, name)) == name:
            rows.append(f"| {_called(one)} | {_plain(one.help or '')} | {_default(one)} |")
        else:
            again.setdefault(first, []).append(_called(one))
    rows += [f"| {', '.join(options)} | as of `{first}` | |" for first, options in again.items()]
    table = ["| option | description | default |", "|---|---|---|", *rows] if rows else []
    return "\n".join([f"## `{name}`", "", _plain(command.help or ""), "", f"```text\n{typed}\n```", "", *table])


def _called(one: Any) -> str:
    if one.param_type_name == "argument":
        return f"`{_metavar(one)}`"
    return ", ".join(f"`{option}`" for option in (*one.opts, *one.secondary_opts))


def _metavar(argument: Any) -> str:
    return argument.metavar or argument.name.upper()


def _default(one: Any) -> str:
    shown = one.show_default if isinstance(getattr(one, "show_default", None), str) else one.default
    if shown is None or callable(shown) or one.required or shown in (False, (), ""):
        return "needed" if one.required else ""
    return f"`{shown}`"


def _plain(text: str) -> str:
    """Words that Markdown leaves alone in a cell of a table, options among them as code."""
    unmarked = text.replace("\\[", "[").replace("|", "\\|").replace("<", "&lt;").replace("*", "\\*").replace("_", "\\_")
    return re.sub(r"(?<![\w`-])--[a-z][a-z-]*", r"`\g<0>`", " ".join(unmarked.split()))


def settings(*_: object) -> str:
    """A table of its settings for each chapter of a recipe."""
    return "\n\n".join(_chapter(chapter, kind.__doc__) for chapter, kind in CHAPTERS.items())


def _chapter(chapter: str, documentation: str) -> str:
    rows = []
    for name in settings_of(chapter):
        default = "needed" if name not in DEFAULTS else "" if DEFAULTS[name] in (None, "", ()) else f"`{DEFAULTS[name]}`"
        low, high = LIMITS.get(name, (None, None))
        within = ", ".join(f"`{one}`" for one in CHOICES.get(name, ()) if one) or ("" if low is None else f"{low:g} to {high:g}")
        rows.append(f"| `{name}` | {_plain(described(name))} | {within} | {default} |")
    head = ["| setting | description | may be | default |", "|---|---|---|---|"]
    return "\n".join([f"## {chapter.capitalize()}", "", documentation.partition("\n")[0], "", *head, *rows])


def glossary(*_: object) -> str:
    """A definition for each word, in the order of the alphabet."""
    entries = sorted(WORDS.items(), key=lambda entry: entry[1][0].lower())
    return "\n\n".join(f"{word}\n: {_plain(sentence)} In code: {_in_code(name)}." for name, (word, sentence) in entries)


def _in_code(names: str) -> str:
    return ", ".join(f"`{name}`" for name in names.split(", "))


def names(*_: object) -> str:
    """Every public name with its docstring, the front row first."""
    materials = ", ".join(f"`{name}`" for name in mechstyle.LIBRARY)
    front = [*_documented(mechstyle), f"## Materials\n\n`ms.LIBRARY` holds materials by name: {materials}."]
    second = "## The second row\n\n`ms.lab` has names for studies, plug-ins and teaching."
    return "\n\n".join([*front, second, *_documented(mechstyle.lab, "### ")])


def _documented(module: ModuleType, level: str = "## ") -> list[str]:
    kinds: dict[str, list[str]] = {kind: [] for kind in DIRECTIVES}
    for name in module.__all__:
        if name not in {"LIBRARY", "lab"}:
            kinds[_kind(getattr(module, name))].append(f"{module.__name__}.{name}")
    return [f"{level}{kind}\n\n```{{eval-rst}}\n{_directives(kind, its)}\n```" for kind, its in kinds.items() if its]


def _kind(value: object) -> str:
    if inspect.isclass(value):
        return "Errors" if issubclass(value, Exception) else "Classes"
    return "Functions"


def _directives(kind: str, found: list[str]) -> str:
    more = "\n   :members:" if kind == "Classes" else ""
    return "\n\n".join(f".. {DIRECTIVES[kind]}:: {name}{more}" for name in found)


LEGIBLE = 8.0
"""Mean difference between grey pictures from which on a style is seen at a glance [levels of 255]."""


def legibility(*_: object) -> str:
    """A row for each cup: the least, the median and the most that its styles differ from it, and how many fall short."""
    known = json.loads((ROOT / "docs" / "legibility.json").read_text(encoding="utf-8"))
    lines = ["| cup | least | median | most |", "|---|---|---|---|"]
    for cup in dict.fromkeys(cup for figures in known.values() for cup in figures):
        row = sorted((figures[cup], style.replace("_", " ")) for style, figures in known.items() if cup in figures)
        (least, weakest), (most, strongest) = row[0], row[-1]
        lines.append(f"| {cup} | {least:.1f} ({weakest}) | {row[len(row) // 2][0]:.1f} | {most:.1f} ({strongest}) |")
    figures = [figure for row in known.values() for figure in row.values()]
    short = sum(figure < LEGIBLE for figure in figures)
    return "\n".join([*lines, "", f"{short or 'None'} of {len(figures)} pictures fall short of {LEGIBLE:g}."])


def report(cache: Path) -> None:
    """Write the report of the tutorial's run, which goes on where it stopped."""
    part = mechstyle.load("gallery:drawer_knob")
    run: Run = mechstyle.stylize(part, "brick", vertices=2000, iterations=60, out=cache / "knob", name="drawer knob", device="cpu")
    run.report(cache / "extra" / REPORT)


def report_frame(cache: Path, _execute: str) -> str:
    """The report in a frame, or its picture where none was made."""
    if not (cache / "extra" / REPORT).is_file():
        return "![A report: the verdict and its figures, the replay beside the original, the timeline](report.png)"
    return (
        "```{raw} html\n"
        f'<iframe class="report" src="../{REPORT}" title="A report: a drawer knob in brick, verdict and replay" loading="lazy"></iframe>\n'
        f'<p><a href="../{REPORT}">The report on a page of its own</a></p>\n```'
    )


PAGES: dict[str, Callable[[Path, str], str]] = {
    "every command": command_line, "every setting": settings, "every name": names, "every word": glossary,
    "a report": report_frame, "styles in grey": legibility,
}  # fmt: skip
"""What is made for each place that a page marks, in a comment."""
