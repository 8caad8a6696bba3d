"""What a recipe's choice of guidance and field comes to: its weights identified before anything slow is done, and its stylizer.

Guidance (a drawn target or CLIP) and field (a value per vertex or the style field) are chosen independently; the default pair needs no
torch and is in `styling.procedural`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec
import numpy as np

from mechstyle.engine import Bounds, Stylizer
from mechstyle.errors import BadInput
from mechstyle.records import Recipe
from mechstyle.styling.extra import need_clip_extra
from mechstyle.styling.operators import Operators
from mechstyle.styling.procedural import Target, gradual_thickness
from mechstyle.styling.prompt import read
from mechstyle.styling.weights import located
from mechstyle.workpiece import Workpiece, clip_folder

if TYPE_CHECKING:
    from mechstyle.styling.guidance import Guidance
    from mechstyle.styling.unit_shape import UnitShape

TARGET_ROOM = 1.25
"""Bound of a field over the deepest place of a target it is to reach: at the bound itself a gradient would vanish."""


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


def towards_target(part: Workpiece, bounds: Bounds, recipe: Recipe, target: Target, device: str) -> Stylizer:
    """The style field, descending to a drawn target."""
    need_clip_extra()
    from mechstyle.styling.guidance import TargetGuidance  # noqa: PLC0415 — torch is loaded when it is wanted
    from mechstyle.styling.unit_shape import UnitShape  # noqa: PLC0415

    where = torch_device(device)
    reach = np.full(len(part.thickness), TARGET_ROOM * float(np.abs(target.displacement).max(initial=0.0)))
    shape = UnitShape.of(part.surface, reach, reach, bounds.protection > 0.0, where)
    return _stylizer(recipe, shape, TargetGuidance(target, part.surface.vertex_areas, recipe.prompt, device=where))


def towards_prompt(part: Workpiece, bounds: Bounds, recipe: Recipe, device: str) -> Stylizer:
    """A field, descending to what CLIP takes for the prompt; its relief is bounded by the amplitude times the local wall."""
    need_clip_extra()
    import torch  # noqa: PLC0415 — torch and transformers are loaded when they are wanted

    from mechstyle.styling.clip import Clip  # noqa: PLC0415
    from mechstyle.styling.clip_guidance import ClipGuidance  # noqa: PLC0415
    from mechstyle.styling.renderer import Renderer  # noqa: PLC0415
    from mechstyle.styling.unit_shape import UnitShape  # noqa: PLC0415

    where = torch_device(device)
    clip = Clip.load(located(recipe.clip, clip_folder()).folder, where)
    height = recipe.amplitude * gradual_thickness(Operators(part.surface), part.thickness.astype(np.float64))
    # Frozen vertices alone are in the field's own mask: the engine applies the ramps around them, and once is enough.
    free = bounds.protection > 0.0
    shape = UnitShape.of(part.surface, np.minimum(height, bounds.inward), np.minimum(height, bounds.outward), free, where)
    render = Renderer(torch.tensor(part.surface.faces), clip.picture_size, device=where)
    return _stylizer(recipe, shape, ClipGuidance(clip, recipe.prompt, render, crops=recipe.crops, device=where))


def _stylizer(recipe: Recipe, shape: UnitShape, guidance: Guidance) -> Stylizer:
    from mechstyle.styling.neural import FIELD_RATE, VERTEX_RATE, NeuralStylizer, VertexField  # noqa: PLC0415 — as above
    from mechstyle.styling.style_field import StyleField  # noqa: PLC0415

    if recipe.field == "vertex":
        return NeuralStylizer(shape, VertexField(len(shape.mask)), guidance, rate=VERTEX_RATE, seed=recipe.seed)
    field = StyleField(len(guidance.text), seed=recipe.seed)
    return NeuralStylizer(shape, field, guidance, rate=FIELD_RATE, seed=recipe.seed)


def torch_device(device: str) -> str:
    """The device torch computes on for a run's device: the processor where this build of torch knows no GPU."""
    import torch  # noqa: PLC0415 — as above

    return device if device.startswith("cuda") and torch.cuda.is_available() else "cpu"
