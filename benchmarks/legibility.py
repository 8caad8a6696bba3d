"""Every style in plain grey on cups of several walls and sizes: by how much its picture differs from that of the cup without it.

The figure is the mean difference over the pixels of the part, in levels of 255; styles that are meant to have relief should reach 8.
Writes docs/legibility.json, of which the page of evidence has a table, and a contact sheet.

python benchmarks/legibility.py                      # every style on every cup
python benchmarks/legibility.py brick fish_scales    # some of them
"""

from __future__ import annotations

import argparse
from pathlib import Path

import msgspec
import numpy as np
from sheets import Specimen, lettered, png

from mechstyle.geometry.remeshing.evening import surface_of
from mechstyle.pictures.colormap import PLAIN
from mechstyle.pictures.scene import BACKGROUND, Camera, render
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.styling.library import names
from mechstyle.styling.prompt import Wish

DOCS = Path(__file__).parent.parent / "docs"
CUPS = {
    "20 mm, 1.2 mm wall": (20.0, 1.2),
    "100 mm, 0.7 mm wall": (100.0, 0.7),
    "100 mm, 1.2 mm wall": (100.0, 1.2),
    "100 mm, 3 mm wall": (100.0, 3.0),
    "250 mm, 3 mm wall": (250.0, 3.0),
}
"""Height and wall of each cup [mm]."""
PIXELS, LINE = 220, 26
BARE = 4
"""Levels between a pixel of the part and the background from which it counts as one."""


def cup(height: float, wall: float) -> SurfaceMesh:
    """A round cup without fillets, as wide as it is high times 0.8 [mm]."""
    from manifold3d import Manifold  # noqa: PLC0415

    radius = 0.4 * height
    inside = Manifold.cylinder(height, radius - wall, circular_segments=128).translate((0.0, 0.0, wall))
    return surface_of(Manifold.cylinder(height, radius, circular_segments=128) - inside)


def grey(mesh: SurfaceMesh, camera: Camera) -> np.ndarray:
    """Its picture without colours, shape [PIXELS, PIXELS], levels of 255."""
    colours = np.broadcast_to(PLAIN, mesh.vertices.shape)
    return render(mesh, camera=camera, width=PIXELS, height=PIXELS, colours=colours).astype(float).mean(axis=2)


def difference(plain: np.ndarray, styled: np.ndarray) -> float:
    """Mean difference over the pixels of the part [levels of 255]."""
    nothing = 255.0 * float(np.mean(BACKGROUND))
    part = (np.abs(plain - nothing) > BARE) | (np.abs(styled - nothing) > BARE)
    return float(np.abs(styled - plain)[part].mean())


def main() -> None:
    """Measure, and draw the sheet."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("styles", nargs="*", choices=[*names(), []])
    asked = parser.parse_args()
    path, sheets = DOCS / "legibility.json", DOCS.parent / "build" / "legibility"
    known = msgspec.json.decode(path.read_bytes(), type=dict[str, dict[str, float]]) if path.exists() else {}
    sheets.mkdir(parents=True, exist_ok=True)
    for told, (height, wall) in CUPS.items():
        part = Specimen.of(cup(height, wall))
        camera = Camera.named("three_quarter", part.surface.vertices)
        plain = grey(part.surface, camera)
        for style in asked.styles or names():
            styled = grey(part.styled(Wish(style))[0], camera)
            np.save(sheets / f"{style}-{list(CUPS).index(told)}.npy", styled.astype(np.uint8))
            known.setdefault(style, {})[told] = round(difference(plain, styled), 1)
            print(f"{style} on {told}: {known[style][told]}", flush=True)
    path.write_bytes(msgspec.json.format(msgspec.json.encode(dict(sorted(known.items()))), indent=1) + b"\n")
    shown = [index for index in range(len(CUPS)) if all((sheets / f"{style}-{index}.npy").exists() for style in known)]
    if shown:
        (DOCS / "legibility.png").write_bytes(sheet(sheets, sorted(known), shown))


def sheet(folder: Path, styles: list[str], cups: list[int]) -> bytes:
    """The pictures of some cups below each other in columns, a row for each style, as PNG."""
    cell, columns = PIXELS // 2, max(10 // len(cups), 1)
    deep, wide = -(-len(styles) // columns), cell * len(cups)
    pixels = np.full((deep * (cell + LINE), columns * wide, 3), 247, np.uint8)
    places = []
    for index, style in enumerate(styles):
        column, line = divmod(index, deep)
        left, top = column * wide, line * (cell + LINE)
        row = np.hstack([np.load(folder / f"{style}-{cup}.npy") for cup in cups])
        row = row.reshape(cell, 2, wide, 2).mean(axis=(1, 3))
        pixels[top + LINE : top + LINE + cell, left : left + wide] = row[..., None]
        places.append((left + 8, top))
    return png(lettered(pixels, places, [(style.replace("_", " "), "") for style in styles]))


if __name__ == "__main__":
    main()
