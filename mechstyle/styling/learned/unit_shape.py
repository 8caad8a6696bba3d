"""A part as the style field sees it: centred, of radius 1, y up, with a displacement along its normals that knows its bounds in mm."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import ArrayLike

from mechstyle.records.mesh import SurfaceMesh

LARGEST_SHARE = 0.1
"""No displacement exceeds this share of the part's radius (Ma et al. 2023)."""
_SATURATION = 0.99  # of a bound: a start at the bound itself could never be left again
_Y_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])  # row vectors: (x, y, z) → (x, z, -y)


class Look(NamedTuple):
    """A styled part as tensors."""

    displacement: torch.Tensor  # along the original normals [mm], shape [n]
    colour: torch.Tensor  # display RGB in [0, 1], shape [n, 3]
    positions: torch.Tensor  # centred, of radius 1, y up, shape [n, 3]


class Logits(NamedTuple):
    """Colour, shape [n, 3], and displacement, shape [n], before their bounds; 0 is mid-grey and no relief."""

    colour: torch.Tensor
    displacement: torch.Tensor


@dataclass(frozen=True, eq=False)
class UnitShape:
    """The unstylized part, all tensors float32 on one device."""

    positions: torch.Tensor  # vertices about their mean, the farthest at distance 1, y up, shape [n, 3]
    normals: torch.Tensor  # unit normals in the same axes, shape [n, 3]
    radius: float  # what 1 is in the part [mm]
    inward: torch.Tensor  # largest displacement into the material [mm], at least 0, shape [n]
    outward: torch.Tensor  # the same outwards
    mask: torch.Tensor  # factor on the displacement from 0 to 1, shape [n]; where it is 0 there is no displacement and no gradient

    @classmethod
    def of(cls, part: SurfaceMesh, inward: ArrayLike, outward: ArrayLike, mask: ArrayLike, device: str = "cpu") -> UnitShape:
        """From a part and, per vertex, its bounds [mm] and mask."""
        centred = part.vertices - part.vertices.mean(axis=0)
        radius = float(np.linalg.norm(centred, axis=1).max())

        def tensor(values: ArrayLike) -> torch.Tensor:
            return torch.tensor(np.asarray(values), dtype=torch.float32, device=device)

        limit = LARGEST_SHARE * radius
        depth, height = (tensor(np.minimum(np.asarray(bound, dtype=np.float64), limit)) for bound in (inward, outward))
        return cls(tensor(centred @ _Y_UP / radius), tensor(part.vertex_normals @ _Y_UP), radius, depth, height, tensor(mask))

    def look(self, logits: Logits) -> Look:
        """The styled part; the mask acts on the bounded displacement, before the part is centred and scaled again, and on no colour."""
        share = logits.displacement.tanh()
        displacement = self.mask * share * torch.where(share > 0.0, self.outward, self.inward)
        return Look(displacement, 0.5 + 0.5 * logits.colour.tanh(), self.placed(displacement))

    def placed(self, displacement: torch.Tensor) -> torch.Tensor:
        """Positions of a displaced part [mm], shape [n], centred and scaled to radius 1 as the original was."""
        moved = self.positions + self.normals * (displacement / self.radius)[:, None]
        centred = moved - moved.mean(dim=0)
        return centred / centred.norm(dim=1).max()

    def logits(self, displacement: torch.Tensor, colour: torch.Tensor) -> Logits:
        """Logits of a displacement [mm], shape [n], and colour, shape [n, 3], as nearly as the bounds allow; 0 where the mask is."""
        bound = self.mask * torch.where(displacement > 0.0, self.outward, self.inward)
        share = torch.where(bound > 0.0, displacement / bound.clamp(min=1e-9), 0.0)
        return Logits(_inverse_tanh(2.0 * colour - 1.0), _inverse_tanh(share))


def _inverse_tanh(values: torch.Tensor) -> torch.Tensor:
    return values.clamp(-_SATURATION, _SATURATION).atanh()
