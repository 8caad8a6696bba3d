"""Learned stylizers from their parts: values per vertex or the style field, descending to a drawn target or to CLIP's view of a prompt."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import torch

from mechstyle.loop.bounds import Bounds
from mechstyle.loop.engine import Stylizer
from mechstyle.records import Recipe
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.styling.dimensions import Dimensions
from mechstyle.styling.drawing.operators import Operators
from mechstyle.styling.drawn import Target
from mechstyle.styling.learned.clip import Clip
from mechstyle.styling.learned.guidance import ClipGuidance, Guidance, TargetGuidance
from mechstyle.styling.learned.renderer import Renderer
from mechstyle.styling.learned.style_field import StyleField
from mechstyle.styling.learned.stylizer import FIELD_RATE, VERTEX_RATE, NeuralStylizer, VertexField
from mechstyle.styling.learned.unit_shape import UnitShape

TARGET_ROOM = 1.25
"""Bound of a field over the deepest place of a target it is to reach: at the bound itself a gradient would vanish."""


def towards_target(surface: SurfaceMesh, bounds: Bounds, recipe: Recipe, target: Target, device: str) -> Stylizer:
    """The field of a recipe, descending to a drawn target."""
    where = torch_device(device)
    reach = np.full(len(surface.vertices), TARGET_ROOM * float(np.abs(target.displacement).max(initial=0.0)))
    shape = UnitShape.of(surface, reach, reach, bounds.freedom > 0.0, where)
    return _stylizer(recipe, shape, TargetGuidance(target, surface.vertex_areas, recipe.style.prompt, device=where))


def towards_prompt(surface: SurfaceMesh, bounds: Bounds, recipe: Recipe, weights: Path, device: str) -> Stylizer:
    """The field of a recipe, descending to what CLIP, of weights in a folder, takes for the prompt, bounded as a drawn relief."""
    where = torch_device(device)
    clip = Clip.load(weights, where)
    inward, outward = Dimensions.of(recipe).layout(Operators(surface), bounds.thickness, None).reach
    # Frozen vertices alone are in the field's own mask: the engine applies the ramps around them, and once is enough.
    free = bounds.freedom > 0.0
    shape = UnitShape.of(surface, np.minimum(inward, bounds.inward), np.minimum(outward, bounds.outward), free, where)
    render = Renderer(torch.tensor(surface.faces), clip.picture_size, device=where)
    return _stylizer(recipe, shape, ClipGuidance(clip, recipe.style.prompt, render, crops=recipe.style.crops, device=where))


def _stylizer(recipe: Recipe, shape: UnitShape, guidance: Guidance) -> Stylizer:
    if recipe.style.field == "vertex":
        return NeuralStylizer(shape, VertexField(len(shape.mask)), guidance, rate=VERTEX_RATE, seed=recipe.style.seed)
    field = StyleField(len(guidance.text), seed=recipe.style.seed)
    return NeuralStylizer(shape, field, guidance, rate=FIELD_RATE, seed=recipe.style.seed)


def torch_device(device: str) -> str:
    """The device torch computes on for a run's device: the CPU where this build of torch knows no GPU."""
    return device if device.startswith("cuda") and torch.cuda.is_available() else "cpu"
