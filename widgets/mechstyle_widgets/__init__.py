"""Notebook widgets of MechStyle: the Studio and its parts, views of a part and of a run. They import mechstyle, never the reverse."""

from typing import Any

from mechstyle._lazy import attached

_load, __dir__, __all__ = attached(__name__, __file__)


def __getattr__(name: str) -> Any:
    """Load what is asked for on first use: a process that only draws or prepares a part needs no widget library."""
    try:
        return _load(name)
    except ModuleNotFoundError as error:
        raise ModuleNotFoundError(
            f"the notebook widgets need {error.name}, which is not installed: pip install 'mechstyle[jupyter]'", name=error.name
        ) from error
