"""Stylization by a drawn target: the relief and colours a prompt asks for, and gradient descent towards them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mechstyle.records import Recipe
from mechstyle.records.mesh import Floats, SurfaceMesh, frozen_array
from mechstyle.records.recipe import DEFAULTS
from mechstyle.styling.dimensions import Dimensions
from mechstyle.styling.drawing.canvas import Canvas, scale_by_area
from mechstyle.styling.drawing.colours import NEUTRAL, in_recesses
from mechstyle.styling.drawing.operators import unfolded
from mechstyle.styling.drawing.raster import Raster
from mechstyle.styling.library import style_named
from mechstyle.styling.picture import NAME as PICTURE
from mechstyle.styling.picture import notes_on, placed_on
from mechstyle.styling.prompt import Wish
from mechstyle.styling.style import Proposal, Relief

COLOUR_WEIGHT = 4.0
_LEFT = 0.005  # of the way to the target, at the end of a run of any number of iterations
_NOTICEABLE, _WORTH_A_NOTE = 0.1, 0.02  # share of the relief lost at a vertex, and of the surface where it is
_LEAST_AREA = 1e-9  # of the mean of all vertices: what has none follows its target like the others


class Target(NamedTuple):
    """The finished style.

    Attributes:
        displacement: Relief along the normals [mm], shape [n], float32.
        colour: Display RGB in [0, 1], shape [n, 3], float32.
        notes: What the user should know of the drawing, in sentences; those on the prompt are in the wish.
        enlarged: Times larger than asked the pattern is drawn, 1 if it is not.
    """

    displacement: NDArray[np.float32]
    colour: NDArray[np.float32]
    notes: tuple[str, ...]
    enlarged: float = 1.0

    def without(self, plain: NDArray[np.bool_] | bool, uncoloured: NDArray[np.float32] | float) -> Target:
        """The same where a part is not to be plain, shape [n], with a share of its own colour, shape [n, 1]."""
        relief, colour = np.where(plain, 0.0, self.displacement), (1.0 - uncoloured) * self.colour + uncoloured * NEUTRAL
        return self._replace(displacement=relief.astype(np.float32), colour=colour.astype(np.float32))


def target(
    mesh: SurfaceMesh, wish: Wish, dimensions: Dimensions, *, seed: int, thickness: ArrayLike, inward: ArrayLike, outward: ArrayLike,
    canvas: Canvas | None = None,
) -> Target:  # fmt: skip
    """Draw a style on a part, as deep as its walls bear and as is asked for, within limits, without folds.

    Args:
        mesh: The unstylized part.
        wish: What the prompt asks for.
        dimensions: What is asked of the size of the style.
        seed: Decides everything random in the style.
        thickness: Local wall thickness [mm], shape [n].
        inward: How far each vertex may go inwards [mm], at least 0, shape [n].
        outward: The same outwards.
        canvas: What to draw on; by default one for the wish, the dimensions and the seed.
    """
    if not wish.style:
        return _without_relief(wish, len(mesh.vertices))
    style = style_named(wish.style)
    canvas = canvas or dimensions.canvas(mesh, thickness, wish, seed)
    relief = style.program(canvas)
    tint = tinted(relief, wish).astype(np.float32)
    if not relief.height.any():
        return Target(np.zeros(len(mesh.vertices), np.float32), tint, tuple(canvas.notes))
    canvas.go_on()
    layout = dimensions.layout(canvas.operators, thickness, style.feature_mm * canvas.scale, wish.amount)
    raised = layout.depth * relief.height if relief.stands else layout.displacement(relief.height, mesh.vertex_areas, relief.cover)
    limited = np.clip(raised, -np.asarray(inward, dtype=np.float64), np.asarray(outward, dtype=np.float64))
    canvas.go_on()
    smooth = unfolded(canvas.operators, limited)
    notes = [*canvas.notes, *layout.notes]
    lowered = float(mesh.vertex_areas @ (np.abs(smooth - limited) > _NOTICEABLE * np.abs(limited))) / float(mesh.vertex_areas.sum())
    if lowered >= _WORTH_A_NOTE:
        notes.append(f"the relief was lowered on {lowered:.0%} of the surface, where it would have folded over itself")
    return Target(smooth.astype(np.float32), tint, tuple(notes), canvas.enlarged)


def tinted(relief: Relief, wish: Wish) -> Floats:
    """The colours of a relief as a wish has them, display RGB in [0, 1], shape [n, 3]."""
    colour = relief.colour if wish.second is None else in_recesses(relief.colour, relief.height, wish.second)
    return np.clip(colour, 0.0, 1.0)


def canvas_for(recipe: Recipe, wish: Wish, mesh: SurfaceMesh, thickness: ArrayLike, raster: Raster | None) -> Canvas:
    """What to draw a wish of a recipe on, with walls of a local thickness [mm], shape [n], and the recipe's picture, if it has one."""
    dimensions = Dimensions.of(recipe, wish)
    if wish.style != PICTURE or raster is None:
        return dimensions.canvas(mesh, thickness, wish, recipe.style.seed)
    width = dimensions.feature if recipe.style.image_size is None else recipe.style.image_size
    placed = placed_on(mesh, raster, recipe, width, wish.size, wish.where)
    detail = raster.detail * placed.projection.width
    canvas = Canvas(mesh, recipe.style.seed, detail / scale_by_area(mesh), wish.colour, wish.shade, nozzle=recipe.delivery.nozzle)
    canvas.picture = placed
    canvas.notes += notes_on(placed, canvas.edge, recipe.delivery.nozzle)
    return canvas


def _without_relief(wish: Wish, count: int) -> Target:
    """No relief, and the colour asked for or that of an uncoloured part."""
    colour = (NEUTRAL, NEUTRAL, NEUTRAL) if wish.colour is None else wish.colour
    return Target(np.zeros(count, np.float32), np.tile(np.array(colour, np.float32), (count, 1)), ())


class ProceduralStylizer:
    """Gradient descent of a displacement and a colour per vertex towards a target.

    The loss is Σ A_i [((s_i − s*_i)/s_ref)² + 4 ‖c_i − c*_i‖²] / Σ A_i with vertex areas A, displacements s, colours c and s_ref the
    root mean square of s*. It sees its own proposals only: fed with what a mask let through, it would push ever harder against the mask.
    Its rate follows the number of iterations, so that a run of any number arrives at its style.

    Args:
        mesh: The unstylized surface.
        target: The finished style.
        iterations: Iterations of the run.
    """

    def __init__(self, mesh: SurfaceMesh, target: Target, iterations: int = DEFAULTS["iterations"]) -> None:
        self._rate = 1.0 - _LEFT ** (1 / iterations)
        areas = np.maximum(mesh.vertex_areas, _LEAST_AREA * mesh.vertex_areas.mean())
        self._share = areas / areas.sum()
        self._target = target.displacement.astype(np.float64), target.colour.astype(np.float64)
        mean_square = float(self._share @ self._target[0] ** 2)
        self._reference = mean_square**0.5 if mean_square > 0 else 1.0
        self.start_from(np.zeros(len(mesh.vertices)), np.full((len(mesh.vertices), 3), NEUTRAL))

    def proposal(self) -> Proposal:
        """The current proposal; at first no displacement and a neutral light grey."""
        return Proposal(self._displacement, self._colour)

    def step(self) -> Proposal:
        """One iteration of descent, preconditioned by the areas so that all vertices approach their target alike."""
        slope, colour_slope = self._gradient()
        displacement = self._displacement - self._rate * slope * self._reference**2 / (2.0 * self._share)
        colour = self._colour - self._rate * colour_slope / (2.0 * COLOUR_WEIGHT * self._share[:, None])
        self.start_from(displacement, colour)
        return self.proposal()

    def start_from(self, displacement: ArrayLike, colour: ArrayLike) -> None:
        """Go on from any displacement [mm], shape [n], and colour, shape [n, 3], for example those another style left."""
        count = len(self._share)
        self._displacement = frozen_array(displacement, np.float32, (count,), "displacement")
        self._colour = frozen_array(colour, np.float32, (count, 3), "colour")

    def loss(self, displacement: ArrayLike, colour: ArrayLike) -> float:
        """Loss of any displacement [mm], shape [n], and colour, shape [n, 3], for example of what a mask let through."""
        relief = (np.asarray(displacement, dtype=np.float64) - self._target[0]) / self._reference
        tint = np.asarray(colour, dtype=np.float64) - self._target[1]
        return float(self._share @ (relief**2 + COLOUR_WEIGHT * (tint**2).sum(axis=1)))

    def state(self) -> dict[str, NDArray[np.float32]]:
        """State from which `restore` continues with the same bytes."""
        return {"displacement": self._displacement, "colour": self._colour}

    def restore(self, state: dict[str, NDArray[np.float32]]) -> None:
        """Go back to a `state` of a stylizer of the same mesh and target."""
        self.start_from(state["displacement"], state["colour"])

    def _gradient(self) -> tuple[Floats, Floats]:
        """∂loss/∂displacement [1/mm], shape [n], and ∂loss/∂colour, shape [n, 3]."""
        relief = 2.0 * self._share * (self._displacement - self._target[0]) / self._reference**2
        tint = 2.0 * COLOUR_WEIGHT * self._share[:, None] * (self._colour - self._target[1])
        return relief, tint
