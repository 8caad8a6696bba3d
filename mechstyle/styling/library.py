"""The styles by name."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Mapping
from functools import cache

from mechstyle.errors import unknown
from mechstyle.styling import picture, styles
from mechstyle.styling.style import Style

FAMILIES: Mapping[str, tuple[str, ...]] = {
    "coats": ("camouflage", "fur", "giraffe", "leather", "leopard", "zebra"),
    "geometric": ("dots", "fuzzy", "low_poly", "paper", "stripes", "topographic"),
    "knitted": ("cable_knit", "crochet", "knit"),
    "lattices": ("bubbles", "circuit", "grid", "honeycomb", "isogrid", "voronoi"),
    "masonry": (
        "brick",
        "checkers",
        "concrete",
        "half_timbered",
        "herringbone",
        "realistic",
        "shingles",
        "stone",
        "terracotta",
        "terrazzo",
        "tiles",
    ),
    "metal": (
        "brushed_metal",
        "chainmail",
        "cones",
        "corrugated",
        "damascus",
        "diamond_plate",
        "grip",
        "hammered",
        "knurling",
        "panels",
        "spikes",
        "studs",
        "weathered",
    ),
    "minerals": ("cracked_earth", "crystal", "glass", "ice", "kintsugi", "lava", "marble"),
    "ornaments": ("celtic_knot", "fluted", "girih", "greek_key", "pleats", "spiral"),
    "plants": ("cactus", "floral", "green", "moss"),
    "scales": ("art_deco", "dragon_scales", "feathers", "fish_scales", "waves"),
    "wooden": ("bamboo", "bark", "cork", "mandala", "wood"),
    "woven": ("basket_weave", "carbon_fibre", "quilting", "tartan", "twill"),
}
"""Names of the styles in each module of several, known without loading any; every other module of `styles` holds one, of its own name."""


@cache
def names() -> tuple[str, ...]:
    """Names of all styles, sorted; imports none of them."""
    alone = {module.name for module in pkgutil.iter_modules(styles.__path__)} - FAMILIES.keys()
    return tuple(sorted(alone.union(*FAMILIES.values())))


@cache
def style_named(name: str) -> Style:
    """The style of that name; BadInput names the known ones, nearest first. A picture of the user's is one, though not in the library."""
    if name == picture.NAME:
        return picture.STYLE
    if name not in names():
        raise unknown("style", name, names(), lists="`mechstyle styles`")
    module = next((family for family, members in FAMILIES.items() if name in members), name)
    style: Style = getattr(importlib.import_module(f"{styles.__name__}.{module}"), name)
    return style


def library() -> dict[str, Style]:
    """All styles by name, in the order of their names."""
    return {name: style_named(name) for name in names()}
