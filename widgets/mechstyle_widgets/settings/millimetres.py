"""A slider of lengths whose first place leaves the length to the part."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import ipywidgets
import traitlets

AUTO = "auto"
"""The first place, and what it is called by default."""


class Millimetres(ipywidgets.SelectionSlider):  # type: ignore[misc]  # ipywidgets has no types
    """A slider from "auto" through lengths.

    Attributes:
        length: What is chosen [mm], None at the first place; it may be any, and is then offered as well.
        auto: What the first place is called.
    """

    length: Any = traitlets.Float(None, allow_none=True)
    auto: Any = traitlets.Unicode(AUTO)

    def __init__(self, lengths: Sequence[float], **look: Any) -> None:
        """Offer these lengths; `look` is what any slider has."""
        self._lengths = frozenset(lengths)
        super().__init__(options=self._offered(), **look)
        self.observe(self._show, ("length", "auto"))
        self.observe(self._choose, "value")

    def _offered(self) -> list[tuple[str, Any]]:
        lengths = sorted(self._lengths | ({self.length} - {None}))
        return [(self.auto, AUTO), *((f"{length:g} mm", length) for length in lengths)]

    def _show(self, _change: object) -> None:
        self.unobserve(self._choose, "value")  # other options put the slider to its first place
        self.options = self._offered()
        self.value = AUTO if self.length is None else self.length
        self.observe(self._choose, "value")

    def _choose(self, _change: object) -> None:
        self.length = None if self.value == AUTO else self.value
