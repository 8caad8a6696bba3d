"""A picture as it lies on a part: what it shows at any place."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mechstyle.records.mesh import Floats
from mechstyle.styling.drawing.projection import Projection
from mechstyle.styling.drawing.raster import Raster, Sample


@dataclass(frozen=True, eq=False)
class PlacedPicture:
    """A picture on a part.

    Attributes:
        raster: The picture.
        projection: How it lies on the part.
        repeated: Whether it is repeated.
        raised: Whether its light and dark become relief.
        side: Where the relief goes from the surface, one of SIDES.
        coloured: Whether its colours are taken.
    """

    raster: Raster
    projection: Projection
    repeated: bool
    raised: bool
    side: str
    coloured: bool

    def seen(self, points: Floats, normals: Floats, footprint: float) -> Sample:
        """What it shows at points [mm] with unit normals, shapes [n, 3], each of which stands for a place of `footprint` [mm]."""
        height, colour, cover = np.zeros(len(points)), np.zeros((len(points), 3)), np.zeros(len(points))
        for layer in self.projection.layers(points, normals):
            here = np.flatnonzero(layer.share > 1e-4)
            shown = self.raster.at(layer.u[here], layer.v[here], footprint / self.projection.width, repeated=self.repeated)
            part = layer.share[here] * shown.cover
            height[here] += part * shown.height
            colour[here] += part[:, None] * shown.colour
            cover[here] += part
        whole = np.maximum(cover, 1e-9)
        return Sample(height / whole, colour / whole[:, None], np.minimum(cover, 1.0))
