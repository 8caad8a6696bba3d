"""Base of the boxes of the settings column: style for either theme, a line for one sentence, settings in and out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from html import escape
from typing import Any, ClassVar

import ipywidgets
import traitlets

from mechstyle.records import Recipe
from mechstyle.records.recipe import CHOICES, DEFAULTS, LIMITS, SETTINGS
from mechstyle_widgets.jupyter.frame import Framed
from mechstyle_widgets.jupyter.language import said, word
from mechstyle_widgets.jupyter.looks import lean, show, unheard
from mechstyle_widgets.state.troubles import sentence

WIDE = {"width": "auto"}
NARROW_LABEL = {"description_width": "108px"}
"""Layout of a control as wide as its column, and style of one whose description stands at its left, all in one line."""
CHECK = {"style": {}, "indent": False}
"""Look of a box to tick, whose description stands at its right."""


class Figure(traitlets.Float[Any, Any]):
    """A number, within its limits if it has any; NaN is none, and lies between all limits for who compares with them."""

    def validate(self, obj: Any, value: Any) -> Any:
        """The number."""
        if value != value:  # noqa: PLR0124 — only NaN is not what it is
            self.error(obj, value)
        return super().validate(obj, value)


def setting(name: str) -> Any:
    """A trait for a field of the recipe, with its default and the names or numbers it may have."""
    default = DEFAULTS[name]
    if name in CHOICES:
        return traitlets.Enum(tuple(CHOICES[name]), default)
    if isinstance(default, bool):
        return traitlets.Bool(default)
    number: Any = traitlets.Int if isinstance(default, int) else Figure
    return number(default, allow_none=default is None, **range_of(name))


class Read(traitlets.Any):
    """A trait whose value a function reads from whatever is set; what cannot be used is its BadInput."""

    def __init__(self, read: Callable[[Any], object], default: object) -> None:
        """Read with a function; `default` is what is there at first."""
        super().__init__(default)
        self._read = read

    def validate(self, _obj: Any, value: Any) -> Any:
        """What was read."""
        return self._read(value)


def range_of(name: str) -> dict[str, float]:
    """`min` and `max` of a field of the recipe, for a trait or a control."""
    return dict(zip(("min", "max"), LIMITS[name], strict=True))


def control(kind: Any, description: str, **look: Any) -> Any:
    """A control of a kind of ipywidgets as wide as its column, its description at the left."""
    return lean(kind, description=description, **{"style": NARROW_LABEL, "layout": WIDE, **look})


def linked(owner: traitlets.HasTraits, name: str, kind: Any, description: str, **look: Any) -> Any:
    """As `control`, linked both ways to a trait of its owner; a bounded number has the range of the setting of that name."""
    bounds = range_of(name) if "min" in kind.class_traits() and "min" not in look else {}
    made = control(kind, description, **{**bounds, **look})
    traitlets.link((owner, name), (made, "length" if "length" in kind.class_traits() else "value"))
    return made


AUTO = "auto"
"""The first place, and what it is called by default."""


class Millimetres(ipywidgets.SelectionSlider):  # type: ignore[misc]  # ipywidgets has no types
    """A slider from "auto" through lengths.

    Attributes:
        length: What is chosen [mm], None at the first place; it may be any, and is then offered as well.
        auto: What the first place is called.
    """

    length: Any = Figure(None, allow_none=True)
    auto: Any = traitlets.Unicode(AUTO)

    def __init__(self, lengths: Sequence[float], **look: Any) -> None:
        """Offer these lengths; `look` is what any slider has."""
        self._lengths = frozenset(lengths)
        super().__init__(options=[(self.auto, AUTO)], **look)
        self.observe(self._show, ("length", "auto"))
        self.observe(self._choose, "value")
        self._show()

    def _show(self, _change: object = None) -> None:
        lengths = sorted(self._lengths | ({self.length} - {None}))
        with unheard(self, self._choose):  # other options put the slider to its first place
            self.options = [(self.auto, AUTO), *((f"{length:g} mm", length) for length in lengths)]
            self.value = AUTO if self.length is None else self.length

    def _choose(self, _change: object) -> None:
        self.length = None if self.value == AUTO else self.value


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


class Fold(ipywidgets.VBox):  # type: ignore[misc]  # ipywidgets has no types
    """Something that is seldom needed, folded away under a line until it is pressed.

    Attributes:
        unfolded: Whether it is shown.
    """

    unfolded = traitlets.Bool(False)
    page = False

    def __init__(self, title: str, content: ipywidgets.Widget, look: str = "mechstyle-fold") -> None:
        """Put something under a line, which has a class of its own in the sheet."""
        self._head, self._content = lean(ipywidgets.Button, description=title), content
        for name in ("mechstyle-group-head", look):
            self._head.add_class(name)
        super().__init__([self._head, content])
        self._head.on_click(lambda _: setattr(self, "unfolded", not self.unfolded))
        self._tell()

    @traitlets.observe("unfolded")
    def _tell(self, _change: Any = None) -> None:
        self._head.icon = ("angle-left" if self.page else "angle-down") if self.unfolded else "angle-right"
        (self._head.add_class if self.unfolded else self._head.remove_class)("mechstyle-open")
        show(self._content, self.unfolded)


class Group(Fold):
    """A heading and a section; one that is a page is gone back from."""

    def __init__(self, title: str, section: Section, *, unfolded: bool = False, page: bool = False) -> None:
        """Put a section under a heading."""
        self._title, self._section, self.page = word(title), section, page
        super().__init__(title, section, "mechstyle-group-head")
        self.add_class("mechstyle-group")
        section.observe(self._tell, (*section.FIELDS, *section.OWN) or ("name",))  # a part has a name and no setting
        self.unfolded = unfolded

    @traitlets.observe("unfolded")
    def _tell(self, change: Any = None) -> None:
        """Show what is chosen where the section itself does not."""
        super()._tell(change)
        brief = "" if self.unfolded else self._section.brief
        self._head.description = f"{self._title}: {brief}" if brief else self._title
        self._head.tooltip = word("Back to all settings (Escape)") if self.page and self.unfolded else ""


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Rows of plain text as an HTML table."""
    top = "".join(f'<th scope="col">{escape(said(cell))}</th>' for cell in head)
    body = "".join("<tr>" + "".join(f"<td>{escape(said(cell))}</td>" for cell in row) + "</tr>" for row in rows)
    return f'<table class="mechstyle-table"><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>'
