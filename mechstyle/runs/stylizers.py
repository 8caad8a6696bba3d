"""From a recipe to its stylizer: plugged in, drawn, or learned with CLIP or the style field.

Guidance (a drawn target or CLIP) and field (a value per vertex or the style field) are chosen independently; the default pair needs no
torch and is in `styling.drawn`.
"""

from __future__ import annotations

from typing import NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from mechstyle._files import clip_folder
from mechstyle.errors import BadInput
from mechstyle.loop.engine import Bounds, Stylizer, advanced
from mechstyle.records import Recipe
from mechstyle.records.mesh import Field
from mechstyle.runs.plugins import made
from mechstyle.simulation.part import Shape, Workpiece, bounds_for
from mechstyle.styling.combination import combined, places
from mechstyle.styling.dimensions import Dimensions
from mechstyle.styling.drawn import NEUTRAL, ProceduralStylizer, Target, target
from mechstyle.styling.learned.extra import need_clip_extra
from mechstyle.styling.learned.weights import located
from mechstyle.styling.prompt import Reading, read


def settled(recipe: Recipe, *, clip_asked_for: bool) -> Recipe:
    """A recipe whose style is known to be possible here, naming the very CLIP weights it needs.

    Raises:
        BadInput: If a prompt names no style that can be drawn, or settings contradict each other.
        MissingPiece: If libraries or weights are not on this machine.
    """
    if recipe.guidance != "clip":
        if clip_asked_for:
            raise BadInput(f"CLIP weights are of no use to guidance {recipe.guidance!r}: ask for guidance 'clip' as well")
        if recipe.field != "vertex":
            need_clip_extra()
        if not recipe.stylizer:  # a stylizer from elsewhere reads prompts its own way
            read(recipe.prompt)
        return msgspec.structs.replace(recipe, clip="")
    if recipe.stylizer:
        raise BadInput(f"the stylizer {recipe.stylizer!r} has its own guidance: leave out guidance 'clip'")
    if not recipe.prompt.strip():
        raise BadInput("the prompt is empty: say in words what the part is to look like")
    need_clip_extra()
    return msgspec.structs.replace(recipe, clip=located(recipe.clip, clip_folder()).identity)


def stylizer_for(part: Workpiece, recipe: Recipe, device: str = "cpu") -> tuple[Stylizer, tuple[str, ...]]:
    """The stylizer of a recipe, and what its user should know about how the prompt was read and what the mesh can carry."""
    bounds = bounds_for(part, recipe)[0]
    if recipe.stylizer:
        return made(part.surface, bounds, recipe), ()
    if recipe.guidance == "clip":
        return _towards_prompt(part, bounds, recipe, device), ()
    reading = read(recipe.prompt)
    aim = _drawn(part, bounds, recipe, reading)
    notes = (f"prompt read as {reading.words}", *reading.notes, *aim.notes)
    if recipe.field != "network":
        return ProceduralStylizer(part.surface, aim), notes
    need_clip_extra()
    from mechstyle.styling.learned.build import towards_target  # noqa: PLC0415 — torch is loaded when it is wanted

    return towards_target(part.surface, bounds, recipe, aim, device), notes


class FinishedStyle(NamedTuple):
    """What a recipe's style comes to if nothing restrains it.

    Attributes:
        relief: Relief along the normals [mm], shape [vertex_count].
        colour: Display RGB in [0, 1], shape [vertex_count, 3].
        spared: Whether each vertex is protected and stays where it is, shape [vertex_count].
        notes: What the user should know of it, one sentence each.
    """

    relief: Field
    colour: Field
    spared: NDArray[np.bool_]
    notes: tuple[str, ...]


def finished_style(part: Workpiece | Shape, recipe: Recipe) -> FinishedStyle | None:
    """The finished style of a recipe; None where only running it tells."""
    if recipe.stylizer or recipe.guidance == "clip" or recipe.field == "network":
        return None
    bounds = bounds_for(part, recipe)[0]
    aim = _drawn(part, bounds, recipe, read(recipe.prompt))
    wanted = bounds.freedom * bounds.levelled(aim.displacement)
    relief = advanced(np.zeros_like(wanted), np.ones_like(wanted), wanted, bounds, recipe)
    return FinishedStyle(relief, np.where(bounds.uncoloured, NEUTRAL, aim.colour), bounds.freedom == 0.0, aim.notes)


def finished_relief(part: Workpiece | Shape, recipe: Recipe) -> Field | None:
    """The relief of the finished style [mm], shape [vertex_count]; None where only running it tells."""
    style = finished_style(part, recipe)
    return None if style is None else style.relief


def _drawn(part: Workpiece | Shape, bounds: Bounds, recipe: Recipe, reading: Reading) -> Target:
    targets = [
        target(
            part.surface,
            wish,
            Dimensions.of(recipe, wish),
            seed=recipe.seed,
            thickness=part.thickness,
            inward=bounds.inward,
            outward=bounds.outward,
        )
        for wish in reading.wishes
    ]
    where = places(reading, part.surface, part.thickness)
    aim = combined(part.surface, targets, where.shares).without(bounds.plain)
    return aim._replace(notes=(*where.notes, *aim.notes))


def _towards_prompt(part: Workpiece, bounds: Bounds, recipe: Recipe, device: str) -> Stylizer:
    need_clip_extra()
    from mechstyle.styling.learned.build import towards_prompt  # noqa: PLC0415 — as above

    weights = located(recipe.clip, clip_folder()).folder
    return towards_prompt(part.surface, bounds, recipe, weights, device)
