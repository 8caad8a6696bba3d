"""Base of the boxes of the settings column: style for either theme, a line for one sentence, settings in and out."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Any, ClassVar

import ipywidgets
import traitlets

from mechstyle.records import Recipe
from mechstyle.records.recipe import CHOICES, DEFAULTS, LIMITS, SETTINGS
from mechstyle_widgets.jupyter.frame import Framed
from mechstyle_widgets.jupyter.language import said
from mechstyle_widgets.jupyter.looks import lean, show
from mechstyle_widgets.state.troubles import sentence

WIDE = {"width": "auto"}
"""Layout of a control as wide as its column."""
NARROW_LABEL = {"description_width": "116px"}
"""Style of a control whose description stands at its left, all in one line."""


def setting(name: str) -> Any:
    """A trait for a field of the recipe, with its default and the names or numbers it may have."""
    default = DEFAULTS[name]
    if name in CHOICES:
        return traitlets.Enum(tuple(CHOICES[name]), default)
    if isinstance(default, bool):
        return traitlets.Bool(default)
    number: Any = traitlets.Int if isinstance(default, int) else traitlets.Float
    return number(default, allow_none=default is None, **range_of(name))


def range_of(name: str) -> dict[str, float]:
    """`min` and `max` of a field of the recipe, for a trait or a control."""
    return dict(zip(("min", "max"), LIMITS[name], strict=True))


class Words(ipywidgets.HTML):  # type: ignore[misc]  # ipywidgets has no types
    """A piece of HTML that takes no room while there is none."""

    def say(self, html: str) -> None:
        """Show it, or nothing."""
        self.value = html
        show(self, html)


class Section(Framed, ipywidgets.VBox):  # type: ignore[misc]  # ipywidgets has no types
    """Controls under each other with a note and a place for what is wrong.

    FIELDS are those of its traits that are settings of a recipe, but for those it only looks at, which a subclass names in SEEN; in OWN it
    names other settings of a run.
    """

    FIELDS: ClassVar[tuple[str, ...]] = ()
    SEEN: ClassVar[tuple[str, ...]] = ()
    OWN: ClassVar[tuple[str, ...]] = ()

    def __init_subclass__(cls, **options: Any) -> None:
        """Find the settings among the traits."""
        super().__init_subclass__(**options)
        cls.FIELDS = tuple(name for name in SETTINGS if isinstance(getattr(cls, name, None), traitlets.TraitType) and name not in cls.SEEN)

    def __init__(self, children: Sequence[Any]) -> None:
        """Show the controls in their order."""
        self._note, self._trouble = lean(Words), lean(Words)
        self.note("")
        self.complain("")
        super().__init__([*children, self._note, self._trouble])
        self.add_class("mechstyle-section")

    def __repr__(self) -> str:
        """What it is and what is chosen, which is all that a notebook without a kernel shows of it."""
        return f"{type(self).__name__}({self.brief})"

    def notify_change(self, change: Any) -> None:
        """Let nobody's error in hearing of a change end in a log only."""
        try:
            super().notify_change(change)
        except Exception as error:
            if "_trouble" not in vars(self):
                raise
            self.complain(sentence(error))

    @property
    def settings(self) -> dict[str, Any]:
        """The chosen settings, by the names of the recipe's fields."""
        return {name: getattr(self, name) for name in self.FIELDS}

    def take(self, recipe: Recipe) -> None:
        """Choose what a recipe has."""
        for name in self.FIELDS:
            setattr(self, name, recipe.settings[name])

    @property
    def brief(self) -> str:
        """What is chosen, in a few words; "" where there is nothing to tell."""
        return ""

    def note(self, words: str, warnings: Sequence[str] = ()) -> None:
        """Say something beside the matter, "" for nothing, and what to beware of, each on a line that is seen."""
        plain = f'<div class="mechstyle-note">{escape(said(words))}</div>' if words else ""
        self._note.say(plain + "".join(f'<div class="mechstyle-warning" role="status">{escape(said(one))}</div>' for one in warnings))

    def complain(self, words: str) -> None:
        """Say what is wrong, in one sentence; "" once it is right again."""
        self._trouble.say(f'<div class="mechstyle-trouble" role="alert">{escape(said(words))}</div>' if words else "")

    @property
    def trouble(self) -> str:
        """The error in one sentence, "" for none."""
        return self._trouble.value


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Rows of plain text as an HTML table."""
    top = "".join(f'<th scope="col">{escape(said(cell))}</th>' for cell in head)
    body = "".join("<tr>" + "".join(f"<td>{escape(said(cell))}</td>" for cell in row) + "</tr>" for row in rows)
    return f'<table class="mechstyle-table"><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>'
