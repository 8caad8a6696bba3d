"""A page that is loaded again asks for every model there is, and gets an answer while others are being made.

JupyterLab asks on a thread of the kernel's own. ipywidgets (8.1) goes through its models there as they are, and fails when a drawing adds
one meanwhile; the page is left with models that refer to what it never got.
"""

from __future__ import annotations

from typing import Any

from ipywidgets.widgets import widget as library


class _Models(dict[str, Any]):
    """Models by id, listed as they were when they were asked for."""

    def values(self) -> Any:
        return list(super().values())

    def items(self) -> Any:
        return list(super().items())


def answer_while_drawing() -> None:
    """Let a page list the models of this kernel at any time."""
    if not isinstance(library._instances, _Models):  # noqa: SLF001 — the library has no other door
        library._instances = _Models(library._instances)  # noqa: SLF001 — as above
