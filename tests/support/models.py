"""The models that widgets have in the kernel."""

from __future__ import annotations

from ipywidgets.widgets import widget as library


def alive() -> set[str]:
    """Their ids."""
    return set(library._instances)
