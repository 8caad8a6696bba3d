"""From a recipe to its stylizer: plugged in by a decorator or an entry point, drawn, or learned with CLIP or the style field.

Guidance (a drawn target or CLIP) and field (a value per vertex or the style field) are chosen independently; the default pair needs no
torch and is in `styling.drawn`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib.metadata import entry_points
from itertools import pairwise
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from mechstyle._files import clip_folder
from mechstyle.errors import BadInput, unknown
from mechstyle.geometry.cancelling import CancelCheck, never_cancel
from mechstyle.loop.bounds import Bounds, advanced
from mechstyle.loop.engine import Stylizer
from mechstyle.loop.objects import Objects
from mechstyle.records import Recipe
from mechstyle.records.mesh import Field, Floats, SurfaceMesh
from mechstyle.runs.images import raster_of
from mechstyle.simulation.part import Shape, Workpiece, bounds_for
from mechstyle.styling.combination import combined, places
from mechstyle.styling.dimensions import Dimensions
from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawn import ProceduralStylizer, Target, canvas_for, target
from mechstyle.styling.learned.weights import located, need_clip_extra
from mechstyle.styling.picture import NAME as PICTURE
from mechstyle.styling.prompt import Reading, reading_of

Factory = Callable[[SurfaceMesh, Bounds, Recipe], Stylizer]
"""Makes the stylizer of a run from the standardised part, how far its style may go, and the recipe (seed, prompt, amplitude …)."""

GROUP = "mechstyle.stylizers"
"""Entry points of installed packages that offer a `Factory` each."""

_registered: dict[str, Factory] = {}


def register_stylizer(name: str) -> Callable[[Factory], Factory]:
    """Decorate a factory, so that `stylizer=NAME` finds it in this process; a second one of the same name replaces the first.

    Example:
        >>> @ms.register_stylizer("my-dots")
        ... def dots(part, bounds, recipe):
        ...     raise NotImplementedError
    """
    if not (name.isidentifier() or name.replace("-", "_").isidentifier()):
        raise BadInput(f"a stylizer must be named by letters, digits, '-' and '_', not {name!r}")

    def register(factory: Factory) -> Factory:
        _registered[name] = factory
        return factory

    return register


def name_of(stylizer: str | Factory) -> str:
    """The name a recipe keeps of a stylizer; a function is registered under its own name; BadInput if there is no stylizer of that name."""
    if isinstance(stylizer, str):
        if stylizer:
            _source(stylizer)
        return stylizer
    name = getattr(stylizer, "__name__", type(stylizer).__name__)
    register_stylizer(name)(stylizer)
    return name


def made(surface: SurfaceMesh, bounds: Bounds, recipe: Recipe) -> Stylizer:
    """The plugged-in stylizer of a recipe, looked at before the run begins.

    BadInput if there is none of that name, or if what it proposes does not fit the part.
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


def settled(recipe: Recipe, *, clip_asked_for: bool) -> Recipe:
    """A recipe whose style is known to be possible here, naming the very CLIP weights it needs.

    Raises:
        BadInput: If a prompt names no style that can be drawn, or settings contradict each other.
        MissingPiece: If libraries or weights are not on this machine.
    """
    if recipe.style.image and not recipe.style.prompt.strip():
        recipe = recipe.with_settings(prompt=PICTURE)
    if recipe.style.image and (recipe.style.stylizer or recipe.style.guidance == "clip"):
        draws = f"the stylizer {recipe.style.stylizer!r}" if recipe.style.stylizer else "guidance 'clip'"
        raise BadInput(f"{draws} draws no pictures: leave it or the image out")
    if recipe.style.guidance != "clip":
        if clip_asked_for:
            raise BadInput(f"CLIP weights are of no use to guidance {recipe.style.guidance!r}: ask for guidance 'clip' as well")
        if recipe.style.field != "vertex":
            need_clip_extra()
        if not recipe.style.stylizer:  # a stylizer from elsewhere reads prompts its own way
            meant = reading_of(recipe).settled
            recipe = recipe.with_settings(prompt=meant) if meant else recipe  # read the same where no encoder is
        return recipe.with_settings(clip="")
    if recipe.style.stylizer:
        raise BadInput(f"the stylizer {recipe.style.stylizer!r} has its own guidance: leave out guidance 'clip'")
    if not recipe.style.prompt.strip():
        raise BadInput("the prompt is empty: say in words what the part is to look like")
    need_clip_extra()
    return recipe.with_settings(clip=located(recipe.style.clip, clip_folder()).identity)


def stylizer_for(
    part: Workpiece, recipe: Recipe, device: str = "cpu", objects: Objects | None = None, go_on: CancelCheck = never_cancel
) -> tuple[Stylizer, tuple[str, ...], float]:
    """The stylizer of a recipe, what its user should know of it, and how many times larger than asked its pattern is drawn.

    Learned styles are learned on `device`. The picture is among the objects of the run, or cached; what `go_on` raises ends a drawing.
    """
    bounds = bounds_for(part, recipe)[0]
    go_on()
    if recipe.style.stylizer:
        return made(part.surface, bounds, recipe), (), 1.0
    if recipe.style.guidance == "clip":
        need_clip_extra()
        from mechstyle.styling.learned.build import towards_prompt  # noqa: PLC0415 — torch is loaded when it is wanted

        return towards_prompt(part.surface, bounds, recipe, located(recipe.style.clip, clip_folder()).folder, device), (), 1.0
    reading = reading_of(recipe)
    aim = drawing_of(part, bounds, recipe, reading, objects, go_on).target
    notes = (f"prompt read as {reading.words}", *reading.notes, *aim.notes)
    if recipe.style.field != "network":
        return ProceduralStylizer(part.surface, aim, recipe.schedule.iterations), notes, aim.enlarged
    need_clip_extra()
    from mechstyle.styling.learned.build import towards_target  # noqa: PLC0415 — torch is loaded when it is wanted

    return towards_target(part.surface, bounds, recipe, aim, device), notes, aim.enlarged


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


def finished_style(part: Workpiece | Shape, recipe: Recipe, go_on: CancelCheck = never_cancel) -> FinishedStyle | None:
    """The finished style of a recipe; None where only running it tells. What `go_on` raises ends it."""
    if recipe.style.stylizer or recipe.style.guidance == "clip" or recipe.style.field == "network":
        return None
    bounds = bounds_for(part, recipe)[0]
    go_on()
    aim = drawing_of(part, bounds, recipe, reading_of(recipe), go_on=go_on).target
    wanted = bounds.freedom * bounds.levelled(aim.displacement)
    relief = advanced(np.zeros_like(wanted), np.ones_like(wanted), wanted, bounds, recipe)
    return FinishedStyle(relief, aim.colour, bounds.freedom == 0.0, aim.notes)


class Drawing(NamedTuple):
    """What a prompt asks for on a part, and how that was drawn.

    Attributes:
        target: The relief and the colours.
        canvases: What each wish was drawn on.
        shares: Of each wish at each vertex, shape [wish_count, vertex_count].
    """

    target: Target
    canvases: Sequence[Canvas]
    shares: Floats


_last: WeakKeyDictionary[SurfaceMesh, tuple[Recipe, Drawing]] = WeakKeyDictionary()
"""The last drawing on each surface and the recipe it is of: tetrahedra are made for it, and the loop goes towards it."""


def drawing_of(
    part: Workpiece | Shape, bounds: Bounds, recipe: Recipe, reading: Reading, objects: Objects | None = None,
    go_on: CancelCheck = never_cancel,
) -> Drawing:  # fmt: skip
    """What the prompt of a recipe asks for on a part, within its bounds; the last one on a part is remembered. Others as `stylizer_for`."""
    recipe = recipe.on(surface="", tetrahedra="")  # the same drawing before the part is meshed and after
    before, known = _last.get(part.surface, (None, None))
    if known is not None and before == recipe:
        return known
    raster = raster_of(recipe, objects)
    canvases = [canvas_for(recipe, wish, part.surface, part.thickness, raster) for wish in reading.wishes]
    for other, canvas in pairwise([*(known.canvases[:1] if known else ()), *canvases]):
        canvas.share(other)
    where = places(reading, part.surface, part.thickness)
    aim = drawn(recipe, reading, canvases, where.shares, bounds, go_on)
    found = Drawing(aim._replace(notes=(*where.notes, *aim.notes)), canvases, where.shares)
    _last[part.surface] = recipe, found
    return found


def drawn(
    recipe: Recipe, reading: Reading, canvases: Sequence[Canvas], shares: Floats, bounds: Bounds, go_on: CancelCheck = never_cancel
) -> Target:
    """What a prompt asks for, each wish drawn on a canvas of its own, all of one surface; what `go_on` raises ends it.

    `shares` are those of each wish at each vertex, shape [wish_count, vertex_count], as `styling.combination.places` gives them.
    """
    mesh, targets = canvases[0].mesh, []
    limits = {"thickness": bounds.thickness, "inward": bounds.inward, "outward": bounds.outward}
    for wish, canvas in zip(reading.wishes, canvases, strict=True):
        canvas.go_on = go_on
        try:
            targets.append(target(mesh, wish, Dimensions.of(recipe, wish), seed=recipe.style.seed, canvas=canvas, **limits))
        finally:
            canvas.go_on = never_cancel  # it is drawn on again, when whoever asked may have stopped
    return combined(mesh, targets, shares).without(bounds.plain, bounds.uncoloured)
