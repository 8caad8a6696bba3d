"""The models that widgets have in the kernel."""

from __future__ import annotations

from ipywidgets.widgets import widget as library

from mechstyle_widgets.jupyter.looks import shared


def alive() -> set[str]:
    """Ids of those that belong to one widget; looks that all share stay."""
    return {name for name, widget in library._instances.items() if not shared(widget)}
