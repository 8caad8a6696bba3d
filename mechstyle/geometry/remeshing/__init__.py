"""Even triangles on a closed surface, and tetrahedra inside it.

`even(mesh, n)` gives a surface about n vertices. Needless ones go (Manifold), those of creases and narrow rounds are fixed (`evening`),
splits, collapses, flips and smoothing even out what lies between (`isotropic`; Botsch and Kobbelt 2004), and triangles that are then
folded, slivers or without area are mended (`cleaning`) where that makes no walls cross (`crossings`). A surface with more creases than
vertices wished for is decimated instead (`decimation`; Garland and Heckbert 1997).

`fill(mesh, n)` gives about n tetrahedra (`filling`). fTetWild, in a process of its own (`tetwild`), fills even triangles, or those of a
relief that are to be kept; the lowest of its tetrahedra are then made higher for the sake of the time step (`improvement`).

Apart from what fTetWild does, the same input gives the same bytes; the numbers that results depend on are in `tolerances`.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mechstyle.geometry.remeshing.evening import even
    from mechstyle.geometry.remeshing.filling import fill

__all__ = ["even", "fill"]


def __getattr__(name: str) -> Any:
    """Load the module of a function when that is first asked for: fTetWild's process needs none of these libraries."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{'evening' if name == 'even' else 'filling'}"), name)
