"""HTML from templates whose values are escaped unless they are markup themselves."""

from __future__ import annotations

import json
from collections.abc import Iterable
from html import escape
from typing import Any


class Markup(str):
    """Text that is HTML already."""

    __slots__ = ()


def fill(template: str, **values: object) -> Markup:
    """A template with `{name}` places filled in; whatever is not `Markup` is escaped."""
    return Markup(template.format(**{name: _safe(value) for name, value in values.items()}))


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


def _safe(value: object) -> str:
    return value if isinstance(value, Markup) else escape(str(value))
