"""Preview of protected regions before a run."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mechstyle.fea.explicit import no_progress
from mechstyle.geometry.region_selection import Protection, protection
from mechstyle.geometry.thickness import local_thickness
from mechstyle.pictures.fields import RESTRAINT
from mechstyle.pictures.panels import Picture, field_panel, picture, with_protected
from mechstyle.records.mesh import STANDARD_VERTICES, SurfaceMesh
from mechstyle.records.regions import Region, regions
from mechstyle.simulation.part import Stage, standardised


@dataclass(frozen=True, eq=False)
class ProtectedPart:
    """The standardised surface of a part, and what its protected regions leave to the style."""

    surface: SurfaceMesh
    protection: Protection

    @property
    def frozen(self) -> NDArray[np.bool_]:
        """Whether each vertex may not move at all, shape [vertex_count]."""
        return self.protection.freedom == 0.0

    @property
    def share(self) -> float:
        """Share of the surface that may not move."""
        return float(self.surface.vertex_areas @ self.frozen / self.surface.vertex_areas.sum())

    def show(self) -> Picture:
        """The regions in hatched grey and the ramps around them, from three sides: a notebook displays it, `.save(path)` writes the PNG."""
        held = RESTRAINT.made(self.protection.freedom)
        views = (("three_quarter", "what is protected"), ("top", "from above"), ("below", "from below"))
        panels = [field_panel(self.surface, RESTRAINT, held, title=title, view=view) for view, title in views]
        title = textwrap.shorten("; ".join(self.protection.notes), 130, placeholder=" …")
        return picture([with_protected(panel, self.frozen) for panel in panels], title=title)


def protect(
    mesh: SurfaceMesh, protect: str | Region | Sequence[str | Region], *, vertices: int = STANDARD_VERTICES, stage: Stage = no_progress
) -> ProtectedPart:
    """See what regions hold before a run is begun: `ms.protect(part, ["inside", ms.Box((0, 0, 0), (9, 9, 9), ramp=2)]).show()`.

    The resting face is protected besides, unless a run asks otherwise; it is not shown here.

    Args:
        mesh: A closed surface [mm], z up, as it stands.
        protect: Regions, as records or in words.
        vertices: Vertices of the standardised surface.
        stage: Called with what is being done, in words.

    Raises:
        BadInput: If a region cannot be read or holds nothing of the part.

    Example:
        >>> held = ms.protect(ms.load("gallery:drawer_knob"), ["top 5"], vertices=500)
        >>> 0.0 < held.share < 1.0
        True
    """
    chosen = regions(protect)
    stage("standardising the surface")
    surface = standardised(mesh, vertices)
    stage("finding the regions")
    return ProtectedPart(surface, protection(chosen, surface, local_thickness(surface)))
