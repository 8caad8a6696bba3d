"""The fall as a film to project: plain part and runs next to each other, in slow motion, with the stress that rises in them."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from mechstyle._colour import linear_to_srgb
from mechstyle._files import write_whole
from mechstyle.errors import BadInput
from mechstyle.fea.orientations import FLAT
from mechstyle.pictures.camera import Camera
from mechstyle.pictures.colormap import STRIPE, Scale, hatch
from mechstyle.pictures.scene import Field, render
from mechstyle.pictures.visibility import visible
from mechstyle.records import Simulation, sentences
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.runs.run import Run
from mechstyle.simulation.impact import AIR, FALLING, Impact, heights, impact_of

MOST = 4
"""Runs of a film: more are too narrow to see on a wall."""
PAUSE = 2500
"""How long the last frame stays [ms]."""
BENT, STAYS = 0.05, 0.1
"""Largest deformation that is drawn on the way and in the end, over the size of the part: what really happens is too small to see."""
BAND, BAR, EDGE = 30, 58, 12
"""Heights of the words above a part and of the colour bar below, and the gap between parts [pixels]."""
AZIMUTH = 30.0
UP = np.array([0.0, 0.0, 1.0])
PAPER, INK, FLOOR = (255, 255, 255), (28, 28, 30), (196, 196, 192)  # sRGB


@dataclass(frozen=True, eq=False)
class Scene:
    """One part that falls, as it is before [mm], and its landing; the title stands above it, and the ending in the last frame."""

    title: str
    ending: str
    surface: SurfaceMesh
    impact: Impact


def film(
    runs: Sequence[Run], path: str | Path, *, plain: bool = True, frames: int = 36, size: int = 360,
    progress: Callable[[float], None] = lambda _: None,
) -> Path:  # fmt: skip
    """Write the flat fall of finished runs as a GIF in slow motion.

    Args:
        runs: Runs of one part, at most `MOST`.
        path: The file.
        plain: Whether the part without a style falls first.
        frames: Moments from first touch on, 8 to 120.
        size: Width of each picture [pixels], 160 to 800.
        progress: Called with the fraction that is done; may raise to cancel.

    Raises:
        BadInput: If the file is no GIF, there are too many runs, or they are of other parts or falls.
        SimulationFailed: If a drop breaks down.
    """
    target = Path(path)
    if target.suffix.lower() != ".gif":
        raise BadInput(f"a film is written as GIF: give {target.with_suffix('.gif')} instead of {target}")
    if not (8 <= frames <= 120 and 160 <= size <= 800):
        raise BadInput(f"a film has 8 to 120 frames of 160 to 800 pixels, not {frames} of {size}")
    _check(runs)
    scenes = [scene for index, run in enumerate(runs) for scene in _scenes(run, plain=plain and not index, progress=progress)]
    strength = runs[0].recipe.test.material.yield_strength
    drawn = [one.convert("RGB") for one in _frames(scenes, strength, frames, size, progress)]
    write_whole(target, animated(drawn))
    return target


def animated(pictures: Sequence[Image.Image]) -> bytes:
    """Pictures of one size as a GIF that is repeated without end, all in the colours of the last, which has all of them."""
    palette = pictures[-1].quantize(192, Image.Quantize.MAXCOVERAGE, kmeans=1, dither=Image.Dither.NONE)
    small = [one.quantize(palette=palette, dither=Image.Dither.NONE) for one in pictures]
    stay = [80] * (len(small) - 1) + [PAUSE]
    written = io.BytesIO()
    small[0].save(written, "GIF", save_all=True, append_images=small[1:], duration=stay, loop=0, optimize=False)
    return written.getvalue()


def _check(runs: Sequence[Run]) -> None:
    """Refuse what cannot fall side by side."""
    if not 1 <= len(runs) <= MOST:
        raise BadInput(f"a film shows 1 to {MOST} runs, not {len(runs)}: choose those to compare")
    first = runs[0]
    for run in runs:
        where = f"{run.store.root}@{run.lane}"
        if not run.finished:
            raise BadInput(f"{where} is not finished: run the command that began it again, then film it")
        if run.record.surface != first.record.surface:
            raise BadInput(f"{where} is of another part than {first.store.root}: a film compares runs of one part")
        if (run.recipe.test.height, run.recipe.test.material) != (first.recipe.test.height, first.recipe.test.material):
            raise BadInput(f"{where} has another fall or material than {first.store.root}: a film compares runs of one fall")


def _scenes(run: Run, *, plain: bool, progress: Callable[[float], None]) -> list[Scene]:
    """A run, after its part without a style if that is wanted."""
    recipe, end = run.recipe, run.checkpoint()
    simulator = run.simulator(recipe, lambda _: progress(0.0))
    styled, row = run.simulation(), None if end.verdict is None else end.verdict.row(landing=FLAT)
    watched = recipe.restraint.guarantee or (recipe.schedule.when != "never" and recipe.restraint.feedback)
    title, known = f"{'MechStyle' if watched else 'Freestyle'}: {recipe.style.prompt[:28]}", row is not None

    def scene(title: str, simulation: Simulation, ending: str) -> Scene:
        impact = impact_of(simulator, simulation, FLAT, lambda _: progress(0.0))
        return Scene(title, ending if known else "", simulator.part.surface.displaced(simulation.displacement), impact)

    value, comma, cracks = sentences.found(row).partition(", ") if row is not None else ("", "", "")
    scenes = [scene(title, styled, f"{value} stays bent{comma}{cracks}")]
    if plain:
        base = simulator.baseline
        scenes.insert(0, scene("plain part", base, f"{sentences.bend(base.landings[0].permanent_set)} stays bent" if base.landings else ""))
    return scenes


def _frames(scenes: Sequence[Scene], strength: float, count: int, size: int, progress: Callable[[float], None]) -> list[Image.Image]:
    """Every picture of the film, all scenes in one scale of time, size and colour."""
    whole = np.concatenate([one.surface.vertices for one in scenes])
    span = float(np.ptp(whole, axis=0).max())
    last = min(float(one.impact.time[-1]) for one in scenes)
    end = min(max(1.6 * float(one.impact.time[one.impact.peak]) for one in scenes), last) or last
    moments = [*np.linspace(0.0, end, count - 1), np.inf]  # and the shape that stays
    scale = Scale(0.0, 1.25 * strength, strength)
    cloud = np.concatenate([whole, whole + UP * AIR * span, [[whole[:, 0].mean(), whole[:, 1].mean(), -0.06 * span]]])
    tall = round(1.15 * size)
    camera = Camera.fitted(cloud, AZIMUTH, 0.0, aspect=size / tall)
    on_the_way = _exaggerated(scenes, span * BENT, lambda impact: impact.peak)
    in_the_end = max(on_the_way, _exaggerated(scenes, span * STAYS, lambda impact: impact.end))
    pictures, air = [], heights(span, np.inf)
    for number in range(FALLING + count):
        time = None if number < FALLING else float(moments[number - FALLING])
        above = float(air[number]) if time is None else 0.0
        final = number == FALLING + count - 1
        factor = in_the_end if final else on_the_way
        page = Image.new("RGB", (len(scenes) * (size + EDGE) + EDGE, BAND + tall + BAR), PAPER)
        for place, one in enumerate(scenes):
            picture = _drawn(one, time, above, camera, scale, factor, (size, tall))
            left = EDGE + place * (size + EDGE)
            page.paste(Image.fromarray(picture), (left, BAND))
            ImageDraw.Draw(page).text((left, 6), one.ending if final and one.ending else one.title, INK, ImageFont.load_default(16))
        when = "" if time is None else "what stays bent" if final else f"{time:.2f} ms after first touch"
        _legend(page, scale, BAND + tall, when, factor)
        pictures.append(page)
        progress((number + 1) / (FALLING + count))
    return pictures


def _exaggerated(scenes: Sequence[Scene], drawn: float, moment: Callable[[Impact], int]) -> float:
    """The factor with which the largest deformation at a moment is drawn so large [mm], the same for all parts; at least 1."""
    motions = (one.impact.motion(one.surface.vertices, moment(one.impact)) for one in scenes)
    return max(1.0, drawn / max(1e-9, *(float(np.abs(one.deformation).max()) for one in motions)))


def _drawn(
    scene: Scene, time: float | None, above: float, camera: Camera, scale: Scale, factor: float, size: tuple[int, int]
) -> NDArray[np.uint8]:  # fmt: skip
    """A part at a moment since first touch [ms], or at a height above the floor [mm] before it, coloured by the stress so far."""
    impact, surface = scene.impact, scene.surface
    frame = 0 if time is None else int(np.searchsorted(impact.time, time, side="right")) - 1
    stress = np.zeros(len(surface.vertices), np.float32) if time is None else impact.stress[: frame + 1].max(axis=0)
    shape = impact.falling(surface, above) if time is None else impact.shape(surface, frame, factor)
    picture = render(shape, camera=camera, width=size[0], height=size[1], field=Field(stress, scale), supersampling=2)
    empty = visible(camera.project(shape.vertices), shape.faces, *size).face < 0
    reach = 4.0 * float(np.ptp(surface.vertices, axis=0).max())
    corners = camera.project([[-reach, -0.4 * reach, 0.0], [reach, -0.4 * reach, 0.0], [reach, reach, 0.0], [-reach, reach, 0.0]])
    floor = Image.new("1", size)
    outline = [((x + 1) * size[0] / 2, (1 - y) * size[1] / 2) for x, y, _ in corners]
    ImageDraw.Draw(floor).polygon(outline, fill=1)
    picture[empty & np.asarray(floor)] = FLOOR
    return picture


def _legend(page: Image.Image, scale: Scale, top: int, words: str, factor: float) -> None:
    """The colour bar below all parts, with the yield strength, and the time."""
    draw, small = ImageDraw.Draw(page), ImageFont.load_default(14)
    width = min(260, page.width // 2 - 2 * EDGE)
    values = np.tile(np.linspace(scale.low, scale.high, width), (12, 1))
    colours = linear_to_srgb(scale.colours(values))
    colours[scale.beyond(values) & hatch(12, width, 9)] = STRIPE
    page.paste(Image.fromarray(np.rint(255.0 * colours).astype(np.uint8)), (EDGE, top + 12))
    limit = EDGE + width * (scale.top - scale.low) / (scale.high - scale.low)
    draw.line([(limit, top + 10), (limit, top + 26)], INK, 2)
    draw.text((EDGE, top + 28), "0", INK, small)
    draw.text((limit, top + 28), f"yields, {scale.top:.0f} MPa", INK, small, anchor="ma")
    beside = EDGE + width + 2 * EDGE
    draw.text((beside, top + 8), words, INK, small)
    draw.text((beside, top + 28), f"deformation drawn {factor:.0f} times", INK, small)
