"""A group of settings under a heading that tells what is chosen, folded away until it is pressed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import ipywidgets
import traitlets

from mechstyle_widgets.jupyter.language import word
from mechstyle_widgets.jupyter.looks import lean, show
from mechstyle_widgets.settings.section import Section


class Fold(ipywidgets.VBox):  # type: ignore[misc]  # ipywidgets has no types
    """Controls that are seldom needed, folded away under a line until it is pressed.

    Attributes:
        unfolded: Whether they are shown.
    """

    unfolded = traitlets.Bool(False)

    def __init__(self, title: str, controls: Sequence[Any]) -> None:
        """Put controls under a line."""
        self._head = lean(ipywidgets.Button, description=title, icon="angle-right")
        self._head.add_class("mechstyle-group-head")
        self._head.add_class("mechstyle-fold")
        self._controls = lean(ipywidgets.VBox, list(controls))
        super().__init__([self._head, self._controls])
        self._head.on_click(lambda _: setattr(self, "unfolded", not self.unfolded))
        self._turn()

    @traitlets.observe("unfolded")
    def _turn(self, _change: Any = None) -> None:
        self._head.icon = "angle-down" if self.unfolded else "angle-right"
        (self._head.add_class if self.unfolded else self._head.remove_class)("mechstyle-open")
        show(self._controls, self.unfolded)


class Group(ipywidgets.VBox):  # type: ignore[misc]  # ipywidgets has no types
    """A heading and a section.

    Attributes:
        unfolded: Whether the section is shown.
    """

    unfolded = traitlets.Bool(False)

    def __init__(self, title: str, section: Section, *, unfolded: bool = False, page: bool = False) -> None:
        """Put a section under a heading; one that is a page is gone back from."""
        self._title, self._section, self.page = word(title), section, page
        self._head = lean(ipywidgets.Button, icon="angle-right")
        self._head.add_class("mechstyle-group-head")
        super().__init__([self._head, section])
        self.add_class("mechstyle-group")
        self._head.on_click(lambda _: self._turn())
        section.observe(self._tell, (*section.FIELDS, *section.OWN) or ("name",))  # a part has a name and no setting
        self.unfolded = unfolded
        self._tell()

    def _turn(self) -> None:
        self.unfolded = not self.unfolded

    @traitlets.observe("unfolded")
    def _tell(self, _change: Any = None) -> None:
        """Show what is chosen where the section itself does not."""
        brief = "" if self.unfolded else self._section.brief
        self._head.description = f"{self._title}: {brief}" if brief else self._title
        self._head.icon = ("angle-left" if self.page else "angle-down") if self.unfolded else "angle-right"
        self._head.tooltip = word("Back to all settings (Escape)") if self.page and self.unfolded else ""
        (self._head.add_class if self.unfolded else self._head.remove_class)("mechstyle-open")
        show(self._section, self.unfolded)
