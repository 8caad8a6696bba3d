"""Writes parts on which a plain base alone fails, as STL: trophies, posts with a groove, cups and necks, their lengths in their names.

python benchmarks/ablation_parts.py build/parts
python -m benchmarks.study ablation --models build/parts/*.stl --styles brick
    --conditions drop --set relief=3 --set side=inwards --set feature=8
"""

from __future__ import annotations

import argparse
from pathlib import Path

import trimesh

from mechstyle.geometry.files import save
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.teaching import trophy


def box(across: float, height: float, base: float = 0.0) -> trimesh.Trimesh:
    """A square bar that stands upright [mm]."""
    return trimesh.creation.box((across, across, height), trimesh.transformations.translation_matrix((0.0, 0.0, base + 0.5 * height)))


def neck(thickness: float, length: float) -> trimesh.Trimesh:
    """A head of 20 mm on a neck [mm]."""
    return trimesh.boolean.union([box(20.0, 6.0), box(thickness, length + 2.0, 5.0), box(20.0, 20.0, 6.0 + length)], engine="manifold")


def post(width: float, depth: float) -> trimesh.Trimesh:
    """A post of 8 mm with a groove around it, and a head on it [mm]."""
    upper = 16.0 + width
    foot, head, groove = box(24.0, 5.0), box(24.0, 16.0, upper + 12.0), box(8.0 - 2.0 * depth, width + 2.0, 15.0)
    return trimesh.boolean.union([foot, box(8.0, 12.0, 4.0), groove, box(8.0, 14.0, upper), head], engine="manifold")


def cup(wall: float) -> trimesh.Trimesh:
    """A cup of ø 80 × 100 mm."""
    outside, inside = (trimesh.creation.cylinder(radius, 100.0, 96) for radius in (40.0, 40.0 - wall))
    outside.apply_translation((0.0, 0.0, 50.0))
    inside.apply_translation((0.0, 0.0, 50.0 + wall))
    return trimesh.boolean.difference([outside, inside], engine="manifold")


PARTS = {
    **{
        f"trophy-{stem}-{head}": (trophy, (float(stem), float(head), 0.0, (6, 24), 44))
        for stem, head in ((10, 28), (11, 28), (12, 28), (13, 32), (14, 36))
    },
    "post": (post, (1.4, 0.0)),
    **{f"post-groove-{depth:g}": (post, (1.4, depth)) for depth in (0.5, 1.0)},
    **{f"cup-{wall:g}": (cup, (wall,)) for wall in (1.2, 1.6)},
    **{f"neck-{thickness:g}": (neck, (thickness, 10.0)) for thickness in (6.0, 8.0)},
}
"""What makes a part, and its lengths [mm], by its name."""


def made(name: str) -> SurfaceMesh:
    """A part of PARTS."""
    how, lengths = PARTS[name]
    part = how(*lengths)
    return part if isinstance(part, SurfaceMesh) else SurfaceMesh(part.vertices, part.faces)


def main() -> None:
    """Write them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder
    folder.mkdir(parents=True, exist_ok=True)
    for name in PARTS:
        save(made(name), folder / f"{name}.stl")
        print(folder / f"{name}.stl")


if __name__ == "__main__":
    main()
