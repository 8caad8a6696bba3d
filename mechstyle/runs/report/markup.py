"""HTML from templates whose values are escaped unless they are markup themselves, and the scripts of a page as one text."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from html import escape
from importlib.resources import files
from typing import Any

from mechstyle.records import sentences


class Markup(str):
    """Text that is HTML already."""

    __slots__ = ()


def fill(template: str, **values: object) -> Markup:
    """A template with `{name}` places filled in; whatever is not `Markup` is escaped."""
    return Markup(template.format(**{name: value if isinstance(value, Markup) else escape(str(value)) for name, value in values.items()}))


def joined(parts: Iterable[Markup]) -> Markup:
    """Markup one after another."""
    return Markup("\n".join(parts))


def table(heads: Iterable[str], rows: Iterable[Iterable[object]], caption: str, kind: str = "") -> Markup:
    """A table with a caption for screen readers; the first cell of a row is its head."""
    return fill(
        '<div class="scroll" tabindex="0" role="region" aria-label="{caption}"><table class="{kind}"><caption>{caption}</caption>'
        "<thead><tr>{heads}</tr></thead><tbody>{rows}</tbody></table></div>",
        caption=caption,
        kind=kind,
        heads=joined(fill('<th scope="col">{head}</th>', head=head) for head in heads),
        rows=joined(fill("<tr>{cells}</tr>", cells=cells(row)) for row in rows),
    )


def cells(row: Iterable[object]) -> Markup:
    """The cells of a row, the first of them its head."""
    first, *rest = row
    return joined([fill('<th scope="row">{cell}</th>', cell=first), *(fill("<td>{cell}</td>", cell=cell) for cell in rest)])


def with_code(text: str) -> Markup:
    """Text in which `what one types` stands between backticks, which become letters of their own."""
    parts = text.split("`")
    if len(parts) % 2 == 0:  # one of them is no quote
        return fill("{text}", text=text)
    return Markup("".join(fill("<code>{part}</code>" if k % 2 else "{part}", part=part) for k, part in enumerate(parts)))


def script_json(value: Any) -> Markup:
    """JSON that cannot end the script element it stands in."""
    text = json.dumps(value, separators=(",", ":"), ensure_ascii=True, allow_nan=False)
    return Markup(text.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e"))


SHAPES = {
    "HOLDS": '<circle r="6"/>',
    "NO WORSE": '<path d="M0-7 7 6-7 6Z"/>',
    "FAILS": '<path d="M-6-6 6 6M-6 6 6-6"/>',
    "UNKNOWN": '<path d="M0-7 7 0 0 7-7 0Z"/>',
}
"""A mark for each outcome: known by its shape, and only then by its colour."""

RING = '<circle class="doubt" r="10"/>'
"""Around the mark of an outcome that is not sure."""


def kind(outcome: str) -> str:
    """The class of an outcome in the style sheet."""
    return outcome.lower().replace(" ", "-")


def mark(outcome: str, *, sure: bool) -> Markup:
    """The shape of an outcome, in a ring if it is not sure."""
    return Markup(SHAPES[outcome] + ("" if sure or outcome == "UNKNOWN" else RING))


def badge(outcome: str, *, sure: bool = True) -> Markup:
    """An outcome in its colour, and in amber that it is not sure."""
    doubt = sentences.marked(outcome, sure=sure).removeprefix(outcome)
    more = fill('<span class="unknown">{doubt}</span>', doubt=doubt) if doubt else ""
    return fill('<span class="{kind}">{outcome}</span>{more}', kind=kind(outcome), outcome=outcome, more=more)


def legend() -> Markup:
    """Every mark with its outcome."""
    shown = [(kind(outcome), Markup(shape), outcome) for outcome, shape in SHAPES.items()]
    shown.append(("unknown", Markup(RING), sentences.NOT_SURE.strip("()")))
    return joined(
        fill('<svg viewBox="-11 -11 22 22" class="mark {kind}">{shape}</svg> {word}', kind=name, shape=shape, word=word)
        for name, shape, word in shown
    )


MODULES = ("replay_data", "shaders", "camera", "scene", "player")
"""ES modules of the replay, each importing only earlier ones."""

IN_A_REPORT = (*MODULES, "impact")
"""Those of a report."""

_IMPORT = re.compile(r'^import \{[^}]*\} from "\./(\w+)\.js";\n', re.MULTILINE)
_EXPORT = re.compile(r"^export (?=(?:async )?(?:function|class|const) )", re.MULTILINE)


def static(name: str) -> str:
    """The text of a file in `static`."""
    return files("mechstyle.runs.report").joinpath("static", name).read_text(encoding="utf-8")


def bundle(last: str, modules: Iterable[str] = MODULES) -> str:
    """The modules, then `last`, the text of one that imports them, as one script.

    Our modules share no top-level name, so joining them is dropping the import lines and the word `export`.
    """
    parts = [_EXPORT.sub("", _IMPORT.sub("", static(f"{name}.js"))) for name in modules]
    return "\n".join([*parts, _IMPORT.sub("", last)])
