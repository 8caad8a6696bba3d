"""Stylizers from elsewhere: named by a decorator in this process, or by an installed package through an entry point."""

from __future__ import annotations

from collections.abc import Callable
from importlib.metadata import entry_points

import numpy as np

from mechstyle.errors import BadInput, unknown
from mechstyle.loop.bounds import Bounds
from mechstyle.loop.engine import Stylizer
from mechstyle.records import Recipe
from mechstyle.records.mesh import SurfaceMesh

Factory = Callable[[SurfaceMesh, Bounds, Recipe], Stylizer]
"""Makes the stylizer of a run from the standardised part, how far its style may go, and the recipe (seed, prompt, amplitude …)."""

GROUP = "mechstyle.stylizers"
"""Entry points of installed packages that offer a `Factory` each."""

_registered: dict[str, Factory] = {}


def register_stylizer(name: str) -> Callable[[Factory], Factory]:
    """Decorate a factory, so that `stylizer=NAME` finds it in this process; a second one of the same name replaces the first."""
    if not (name.isidentifier() or name.replace("-", "_").isidentifier()):
        raise BadInput(f"a stylizer must be named by letters, digits, '-' and '_', not {name!r}")

    def register(factory: Factory) -> Factory:
        _registered[name] = factory
        return factory

    return register


def name_of(stylizer: str | Factory) -> str:
    """The name a recipe keeps of a stylizer; a function is registered under its own name.

    Raises:
        BadInput: If there is no stylizer of that name.
    """
    if isinstance(stylizer, str):
        if stylizer:
            _source(stylizer)
        return stylizer
    name = getattr(stylizer, "__name__", type(stylizer).__name__)
    register_stylizer(name)(stylizer)
    return name


def made(surface: SurfaceMesh, bounds: Bounds, recipe: Recipe) -> Stylizer:
    """The plugged-in stylizer of a recipe, looked at before the run begins.

    Raises:
        BadInput: If there is none of that name, or if what it proposes does not fit the part.
    """
    stylizer = _source(recipe.style.stylizer)(surface, bounds, recipe)
    count = len(surface.vertices)
    try:
        first = stylizer.proposal()
        found = np.shape(first.displacement), np.shape(first.colour)
    except AttributeError as error:
        raise BadInput(f"the stylizer {recipe.style.stylizer!r} is none: {error}; docs/plug-in.md shows what one must have") from error
    if found != ((count,), (count, 3)):
        shapes = f"{found[0]} and {found[1]}, not ({count},) and ({count}, 3)"
        raise BadInput(f"the stylizer {recipe.style.stylizer!r} proposes displacement and colour of shapes {shapes}")
    if not (np.isfinite(first.displacement).all() and np.isfinite(first.colour).all()):
        raise BadInput(f"the stylizer {recipe.style.stylizer!r} proposes displacements or colours that are not finite numbers")
    return stylizer


def known_stylizers() -> tuple[str, ...]:
    """Names of the stylizers that are plugged in, sorted."""
    return tuple(sorted({*_registered, *(point.name for point in entry_points(group=GROUP))}))


def _source(name: str) -> Factory:
    """The factory of a name. A recipe never names code by itself: only what was registered here or is installed is run."""
    if name in _registered:
        return _registered[name]
    for point in entry_points(group=GROUP, name=name):
        factory: Factory = point.load()
        return factory
    if not known_stylizers():
        raise BadInput(f"the stylizer {name!r} is not here: install the package that brings it, or register it as docs/plug-in.md shows")
    raise unknown("stylizer", name, known_stylizers())
