"""Legend of a view: colour bar with units, limit and extremes, and a scale bar in millimetres."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape
from itertools import zip_longest

import numpy as np
from numpy.typing import NDArray

from mechstyle._colour import linear_to_srgb
from mechstyle.pictures.colormap import ABOVE, ABSENT, STRIPE, Scale
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.records.regions import Point
from mechstyle_widgets.jupyter.language import said as translated
from mechstyle_widgets.jupyter.language import word
from mechstyle_widgets.viewer.layers import Layer
from mechstyle_widgets.viewer.scene import round_length

INK, FAINT = "var(--jp-ui-font-color1, #1c1c1e)", "var(--jp-ui-font-color2, #5f5f66)"
BAR_WIDTH = 260  # [pixels]
MOST_TICKS, CROWDED = 6, 0.12
"""Steps between ticks at most, and how near to the limit none stands, as a share of the bar."""
BEYOND = {"limit": "is above the limit of", "yields at": "has yielded, which begins at", "allowed": "stays bent by more than the allowed"}
"""What is said of a surface above a threshold, by what the threshold is."""


def colour_bar(layer: Layer, mesh: SurfaceMesh, bands: int = 0, *, brief: bool = False) -> str:
    """HTML of a layer's caption, colours (`bands`, 0 for all), ticks and limit, and of what is known of its surface.

    `brief` leaves out what is said of the surface, as where several share the bar.
    """
    scale, ticks = layer.scale, ""
    for place, words in _ticks(scale):  # a share of each number's own width stands at the same share of the bar
        shift = min(max(place, 0.0), 1.0)
        ticks += f'<span style="position:absolute;left:{place:.1%};transform:translateX(-{shift:.0%})">{words}</span>'
    beyond = ""
    if layer.threshold is not None and not brief and not layer.aged:
        there = scale.beyond(layer.values)
        share = f"{mesh.vertex_areas[there].sum() / mesh.vertex_areas.sum():.1%} of the surface" if there.any() else "nothing"
        beyond = escape(translated(f"{share} {BEYOND[layer.edge]} {layer.threshold:.3g} {layer.unit}".rstrip()))
    lines = [f"<div><b>{escape(translated(layer.caption))}</b></div>"]
    lines.append(f'<div style="width:{BAR_WIDTH}px;height:12px;border-radius:2px;background:{_gradient(scale, bands)}"></div>')
    lines.append(f'<div style="position:relative;width:{BAR_WIDTH}px;height:1.5em">{ticks}</div>')
    note = escape(translated(layer.note))
    said = () if brief else (" &emsp; ".join(filter(None, (_extremes(layer), note))), beyond)
    lines += [f'<div style="color:{FAINT};white-space:normal">{line}</div>' for line in said if line]
    return _block("".join(lines))


def scale_bar(pixels_per_mm: float, cell: float) -> str:
    """HTML of a bar of a round length [mm] as long as it is on screen, and how wide a cell of the floor is [mm]."""
    length = round_length(110.0 / pixels_per_mm)
    style = f"width:{length * pixels_per_mm:.0f}px;height:5px;border:solid {INK};border-width:0 1.5px 1.5px"
    bar = f'<div role="img" aria-label="{word("scale bar of {} mm").format(f"{length:g}")}" style="{style}"></div>'
    words = f'<span>{length:g} mm <span style="color:{FAINT}">· {word("grid")} {cell:g} mm</span></span>'
    return _block(f'<div style="display:flex;align-items:center;gap:8px">{bar}{words}</div>')


def protected(vertices: NDArray[np.bool_], mesh: SurfaceMesh) -> str:
    """HTML of what the grey hatch means and how much of the surface it covers, shape [vertex_count]; "" where it covers nothing."""
    if not vertices.any():
        return ""
    share = mesh.vertex_areas[vertices].sum() / mesh.vertex_areas.sum()
    grey = f"repeating-linear-gradient(45deg,{_css(ABSENT)} 0 2px,transparent 2px 5px)"
    box = f"display:inline-block;width:24px;height:10px;margin-right:8px;border:1px solid {_css(ABSENT)};background:{grey}"
    words = word("stays plain: {} of the surface").format(f"{share:.1%}")
    return _block(f'<span style="{box}"></span>{words}')


def said(tool: str, ends: Sequence[Point]) -> str:
    """HTML of the distance between two places [mm] and how it lies, else of what the tool in hand is for."""
    if len(ends) == 2:
        along = np.subtract(ends[1], ends[0])
        x, y, z = (f"{value:+.2f}" for value in along)
        return f"<span><b>{np.linalg.norm(along):.2f} mm</b> &ensp;{word('along')} x {x}, y {y}, z {z}</span>"
    which = "a second place" if ends else "a place"
    words = {
        "measure": f"Click {which} on the part to measure; Enter takes the cross, Esc leaves",
        "places": "A click keeps the place in the list; Enter takes the cross, Esc leaves",
    }
    return f"<span>{translated(words[tool])}</span>" if tool else ""


def titles(names: Sequence[str], outcomes: Sequence[str]) -> str:
    """HTML of names side by side, each in the middle of its share of the width, and under it the HTML of its verdict if it has one."""
    heads = zip_longest((escape(translated(name)) for name in names), outcomes[: len(names)], fillvalue="")
    cells = "".join(f'<div style="flex:1;min-width:0;text-align:center">{name} {outcome}</div>' for name, outcome in heads)
    return f'<div class="mechstyle-titles" style="color:{INK}">{cells}</div>'


def _block(inside: str) -> str:
    return f'<div style="margin:4px 8px;line-height:1.45;font-size:12px;white-space:nowrap;color:{INK}">{inside}</div>'


def _extremes(layer: Layer) -> str:
    """Markers of the extremes: a ring at the greatest value, a triangle at the least."""
    found = layer.extremes()
    if found is None:
        return ""
    words = escape(f"○ max {layer.text_at(found[0])}   ▽ min {layer.text_at(found[1])}").replace("   ", " &emsp; ")
    return f'<span title="{word("dashed where it is on the far side")}">{words}</span>'


def _ticks(scale: Scale) -> list[tuple[float, str]]:
    """Places along the bar, and what stands there: round values, and in bold the limit."""
    width, bold = scale.high - scale.low, scale.threshold if scale.split else None
    step = 2.5 * round_length(abs(width) / 9.0)
    step = next(one for one in (step / 2.5, step / 1.25, step, 2 * step) if abs(width) / one <= MOST_TICKS)
    first = math.ceil(min(scale.low, scale.high) / step - 1e-9)
    values = [step * number for number in range(first, math.floor(max(scale.low, scale.high) / step + 1e-9) + 1)]
    marked = {} if bold is None else {(bold - scale.low) / width: f"<b>{bold:.3g}</b>"}
    found = {(value - scale.low) / width: f"{value:.3g}" for value in values}
    apart = [one for one in found.items() if all(abs(one[0] - place) > CROWDED for place in marked)]
    return [*apart, *marked.items()]


def _gradient(scale: Scale, bands: int) -> str:
    """The scale as CSS, with a hard edge where the hatch begins."""
    end = 100.0 * (scale.top - scale.low) / (scale.high - scale.low)
    if bands:
        middles = (np.arange(bands) + 0.5) / bands
        colours = linear_to_srgb(scale.colours(scale.low + middles * (scale.top - scale.low)))
        edges = np.linspace(0.0, end, bands + 1)
        stops = [f"{_css(one)} {a:.1f}% {b:.1f}%" for one, a, b in zip(colours, edges[:-1], edges[1:], strict=True)]
    else:
        places = np.linspace(0.0, 1.0, 17)
        colours = linear_to_srgb(scale.colours(scale.low + places * (scale.top - scale.low)))
        stops = [f"{_css(colour)} {share * end:.1f}%" for share, colour in zip(places, colours, strict=True)]
    ramp = f"linear-gradient(to right,{','.join(stops)},transparent {end:.1f}%)"
    return f"{ramp},repeating-linear-gradient(135deg,{_css(STRIPE)} 0 2px,{_css(ABOVE)} 2px 6px)"


def _css(colour: tuple[float, ...]) -> str:
    r, g, b = np.rint(255 * np.asarray(colour)).astype(int).tolist()
    return f"rgb({r},{g},{b})"
