"""Pictures of a part that can be differentiated by its vertices and colours: Warp decides what is seen, torch computes how it looks.

Light is that of X-Mesh (Ma et al. 2023): the first spherical harmonics with coefficients 1 (Kaolin's `spherical_harmonic_lighting`), in
the axes of each camera. The renderer takes its own liberties unless `kaolin_compat`: smooth normals, because the light of flat ones jumps
where faces meet; weights correct in perspective; outlines that fade, so that gradients know where the part ends.
"""

from __future__ import annotations

from dataclasses import dataclass

from mechstyle.errors import BadInput, MissingPiece

try:
    import torch
    from torch.nn import functional
except ModuleNotFoundError as error:
    raise MissingPiece("rendering with gradients needs torch: install it with `pip install 'mechstyle[clip]'`") from error

from mechstyle.raster.rows import added, taken
from mechstyle.raster.tensors import edges_of, face_of, nearest_faces
from mechstyle.styling.antialias import antialiased
from mechstyle.styling.cameras import Cameras, random_views

__all__ = ["Cameras", "Rendered", "Renderer", "random_views"]

AMBIENT = 0.28209479177387814  # Y_00 = 1 / (2 √π)
DIRECTED = 0.4886025119029199  # Y_1m = √(3 / 4π) times x, y or z
BACKGROUND = 1.0
KAOLIN_EPS = 1e-8


@dataclass(frozen=True, eq=False)
class Rendered:
    """Views of a part.

    Attributes:
        image: RGB in [0, 1] on white, row 0 at the top, shape [views, 3, size, size].
        coverage: Share of each pixel the part covers, shape [views, 1, size, size]; 0 or 1 without antialiasing.
    """

    image: torch.Tensor
    coverage: torch.Tensor


class Renderer:
    """Renders views of surfaces that share their faces.

    Args:
        faces: Vertex indices, anticlockwise seen from outside, shape [face_count, 3], any integers.
        size: Pixels of a picture each way.
        kaolin_compat: Pictures and gradients as the released X-Mesh gets them from Kaolin's DIB-R: flat normals, faces culled by
            them, weights linear in the picture, hard outlines without gradients.
        antialias: Whether outlines fade and have gradients; never with `kaolin_compat`.
        device: Of all tensors, "cpu" or "cuda".
        static: Whether no shape depends on what is seen, as CUDA graphs need; by default on CUDA only, since it costs a CPU time.

    Raises:
        BadInput: Faces or a size that cannot be drawn.
    """

    def __init__(
        self,
        faces: torch.Tensor,
        size: int = 224,
        *,
        kaolin_compat: bool = False,
        antialias: bool = True,
        device: str | torch.device = "cpu",
        static: bool | None = None,
    ) -> None:
        if faces.ndim != 2 or faces.shape[1] != 3 or not len(faces) or faces.is_floating_point():
            raise BadInput(f"faces must be integers of shape [face_count, 3], not {faces.dtype} of shape {tuple(faces.shape)}")
        if not 1 <= size <= 4096:
            raise BadInput(f"views of {size} x {size} pixels cannot be rendered: use 1 to 4096")
        self._faces = faces.to(device=device, dtype=torch.int32).contiguous()
        self._corners = self._faces.long().T.contiguous()
        self._least, self._most = int(faces.min()), int(faces.max())
        self._size, self._flat = size, kaolin_compat
        self._edges = edges_of(self._faces) if antialias and not kaolin_compat else None
        self._static = self._faces.is_cuda if static is None else static
        self._empty = torch.tensor([BACKGROUND, BACKGROUND, BACKGROUND, 0.0], device=device)

    def __call__(self, positions: torch.Tensor, colours: torch.Tensor, cameras: Cameras) -> Rendered:
        """Every view of a surface.

        Args:
            positions: Vertices in the unit sphere, y up, shape [n, 3], float32 or float64.
            colours: Display RGB, brought to [0, 1], shape [n, 3], or [views, n, 3] if views differ in it, of the same type.
            cameras: The views.

        Raises:
            BadInput: Shapes that do not fit each other or the faces.
        """
        self._check(positions, colours, len(cameras.elevation))
        axes = cameras.axes.to(positions)
        normals = self._normals(positions)
        pixels = cameras.project(positions, self._size)
        hidden = axes[:, 2] @ normals.detach().T < 0 if self._flat else None
        buffer = nearest_faces(pixels, self._faces, self._size, self._size, cull=not self._flat, hidden=hidden)
        picture = self._shaded(pixels, colours.clamp(0.0, 1.0), normals, axes.sum(dim=1), face_of(buffer).view(-1))
        if self._edges is not None:
            picture = antialiased(picture, pixels, self._edges, buffer, static=self._static)
        views = picture.view(4, -1, self._size, self._size).transpose(0, 1)
        return Rendered(views[:, :3], views[:, 3:])

    def _check(self, positions: torch.Tensor, colours: torch.Tensor, views: int) -> None:
        if positions.ndim != 2 or positions.shape[1] != 3 or colours.shape not in {positions.shape, (views, *positions.shape)}:
            shapes = f"{tuple(positions.shape)} and {tuple(colours.shape)}"
            raise BadInput(f"positions and the colours of a view must both have shape [vertex_count, 3], not {shapes}")
        if not 0 <= self._least <= self._most < len(positions):
            raise BadInput(f"the faces name vertices {self._least} to {self._most}, but there are {len(positions)} positions")

    def _normals(self, positions: torch.Tensor) -> torch.Tensor:
        """Unit normals of the faces if flat, else of the vertices, weighted by area, shape [face_count or n, 3]."""
        a, b, c = taken(positions, self._corners)
        across = torch.linalg.cross(b - a, c - a)
        if not self._flat:
            across = added(across.repeat(3, 1), self._corners.reshape(-1), len(positions))
        return functional.normalize(across, dim=1)

    def _shaded(
        self, pixels: torch.Tensor, colours: torch.Tensor, normals: torch.Tensor, light: torch.Tensor, face: torch.Tensor
    ) -> torch.Tensor:
        """RGB and coverage of all pixels, shape [4, views · size²], that see these faces (-1 for none) under one light per view."""
        count = self._size**2
        pixel = torch.arange(len(face), device=face.device) if self._static else (face >= 0).nonzero()[:, 0]
        seen = face[pixel] >= 0
        shown = torch.where(seen, face[pixel], pixel % len(self._faces))  # any face will do; one for all would be a queue of additions
        view = pixel // count
        corners = self._corners.index_select(1, shown) + view * pixels.shape[1]
        channels = [pixels, colours.expand_as(pixels)]
        if not self._flat:
            channels.append(normals.expand_as(pixels))
        at_corners = taken(torch.cat(channels, dim=2).flatten(0, 1), corners)
        weights = self._weights(at_corners[..., :3], pixel % count)
        blended = (weights[..., None] * at_corners[..., 3:]).sum(dim=0)
        turned = normals.index_select(0, shown) if self._flat else functional.normalize(blended[:, 3:], dim=1)
        lit = AMBIENT + DIRECTED * (turned * light.index_select(0, view)).sum(dim=1, keepdim=True)
        samples = torch.cat([(blended[:, :3] * lit).clamp(0.0, 1.0), torch.ones_like(lit)], dim=1)
        empty = self._empty.to(colours)
        if self._static:
            return torch.where(seen[:, None], samples, empty).T.contiguous()
        return empty.repeat(len(face), 1).index_copy(0, pixel, samples).T.contiguous()

    def _weights(self, corners: torch.Tensor, pixel: torch.Tensor) -> torch.Tensor:
        """Weights of the corners of faces at pixel centres, shape [3, k], from their columns, rows and 1 / depth, shape [3, k, 3]."""
        x, y = (pixel % self._size).to(corners) + 0.5, (pixel // self._size).to(corners) + 0.5
        (ax, ay, ai), (bx, by, bi), (cx, cy, ci) = (corner.unbind(dim=1) for corner in corners)
        ax, bx, cx, ay, by, cy = ax - x, bx - x, cx - x, y - ay, y - by, y - cy
        if self._flat:
            whole = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
            return _screen_weights(whole, cx * ay - cy * ax, ax * by - ay * bx, 0.5 * self._size)
        return _perspective_weights((bx * cy - by * cx) * ai, (cx * ay - cy * ax) * bi, (ax * by - ay * bx) * ci)


def _perspective_weights(*shares: torch.Tensor) -> torch.Tensor:
    """Parts of a triangle opposite its corners, each over the corner's depth, scaled to a sum of 1.

    A triangle may be so thin that rounding puts the pixel outside; its weights stay between 0 and 1 even so.
    """
    positive = torch.stack(shares).clamp(min=1e-20)
    return positive / positive.sum(dim=0)


def _screen_weights(whole: torch.Tensor, of_b: torch.Tensor, of_c: torch.Tensor, half: float) -> torch.Tensor:
    """Kaolin's weights, linear in the picture, with twice the areas [pixels²] brought to its picture from -1 to 1 first."""
    divisor = whole / half**2 + KAOLIN_EPS
    b, c = of_b / half**2 / divisor, of_c / half**2 / divisor
    return torch.stack([1.0 - b - c, b, c])
