"""The models that widgets have in the kernel."""

from __future__ import annotations

from ipywidgets.widgets.widget import _instances

from mechstyle_widgets.jupyter.looks import shared


def alive() -> set[str]:
    """Ids of those that belong to one widget; looks that all share stay."""
    return {name for name, widget in _instances.items() if not shared(widget)}
