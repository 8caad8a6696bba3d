"""Style programs: a style a file, or a family of short ones that share their ideas."""

from __future__ import annotations

from collections.abc import Mapping

FAMILIES: Mapping[str, tuple[str, ...]] = {
    "animals": ("camouflage", "fur", "giraffe", "leopard", "zebra"),
    "floors": ("herringbone", "shingles", "terrazzo", "tiles"),
    "ice_and_fire": ("glass", "ice", "lava"),
    "metalwork": ("chainmail", "diamond_plate", "grip", "panels", "spikes"),
    "ornaments": ("fluted", "girih", "greek_key", "pleats", "spiral"),
    "soft": ("cork", "fuzzy", "paper", "tartan"),
}
"""Names of the styles in each file that holds several, as `STYLES`; known without loading any. Every other file holds one, as `STYLE`."""
