"""Thirty styled parts as a painted 3MF and as an STL, each sliced by PrusaSlicer and by Slic3r: what opens, is closed, and becomes layers.

Needs prusa-slicer and slic3r on PATH, half a minute a part. Styles are drawn on small surfaces as runs draw them, without simulation:
slicers see the file alone. Keeps what was measured in docs/slicing.json.

python benchmarks/slicing.py                 # all of the gallery
python benchmarks/slicing.py coaster vase    # some of it
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any, cast

import msgspec
import numpy as np
import trimesh
from sheets import Specimen

import mechstyle as ms
from mechstyle.gallery import names
from mechstyle.geometry.files import save
from mechstyle.loop.bounds import unrestrained_relief
from mechstyle.records import Recipe
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.runs.printing import Printing, write_for_printing
from mechstyle.runs.recipes import recipe_for
from mechstyle.simulation.part import Shape, bounds_for
from mechstyle.styling.library import names as styles
from mechstyle.styling.prompt import read

DOCS = Path(__file__).parent.parent / "docs"
VERTICES, LAYER, NOZZLE = 3000, 1.0, 1.5
PRUSA = (
    "prusa-slicer", "--export-gcode", f"--nozzle-diameter={NOZZLE},{NOZZLE}", "--filament-diameter=1.75,1.75", "--temperature=210,210",
    "--single-extruder-multi-material", f"--layer-height={LAYER}", f"--first-layer-height={LAYER}", "--fill-density=0%", "--skirts=0",
)  # fmt: skip
SLIC3R = (
    "slic3r", f"--nozzle-diameter={NOZZLE}", f"--layer-height={LAYER}", f"--first-layer-height={LAYER}", "--fill-density=0",
    "--skirts=0", "--print-center", "100,100",
)  # fmt: skip
REPAIRED = re.compile("repair|manifold|error", re.IGNORECASE)


class Sliced(msgspec.Struct):
    """What became of a part: layers of each file in each slicer, and what was repaired."""

    style: str
    watertight: bool
    filaments: int
    layers: list[int]
    asked: int
    repairs: list[str]

    @property
    def whole(self) -> bool:
        """Whether everything is as it must be."""
        return self.watertight and not self.repairs and all(abs(layers - self.asked) <= 1 for layers in self.layers)


def measure(part: str, style: str, folder: Path) -> Sliced:
    """Style a part, write it twice and slice each file twice."""
    mesh, recipe = in_style(part, style)
    files = [folder / f"{part}.3mf", folder / f"{part}.stl"]
    plan = write_for_printing(files[0], mesh, cast("Any", None), recipe, Printing())  # the part is asked for two bodies alone
    save(mesh, files[1])
    layers, repairs = [], []
    for slicer in (PRUSA, SLIC3R):
        for file in files:
            gcode = file.with_suffix(f".{slicer[0]}.gcode")
            done = subprocess.run([*slicer, "-o", str(gcode), str(file)], capture_output=True, text=True, check=False)
            said = (done.stdout + done.stderr).splitlines()
            repairs += [f"{slicer[0]}: {line.strip()}" for line in said if REPAIRED.search(line)]
            layers.append(len(heights(gcode.read_text())) if gcode.exists() else 0)
    return Sliced(
        style=style,
        watertight=all(trimesh.load_mesh(file).is_watertight for file in files),
        filaments=len(plan.palette),
        layers=layers,
        asked=round(float(mesh.extents[2]) / LAYER),
        repairs=repairs,
    )


def in_style(part: str, style: str) -> tuple[SurfaceMesh, Recipe]:
    """A part of the gallery in a style, and the recipe of that."""
    specimen, recipe = Specimen.of(ms.load(f"gallery:{part}"), VERTICES), recipe_for(style)
    plain, (styled, _) = specimen.surface, specimen.styled(read(style).wishes[0])
    asked = np.einsum("ij,ij->i", styled.vertices - plain.vertices, plain.vertex_normals).astype(np.float32)
    bounds, _ = bounds_for(Shape(plain, specimen.thickness.astype(np.float32)), recipe)
    return plain.displaced(unrestrained_relief(asked, bounds, recipe)).coloured(styled.colours), recipe


def heights(gcode: str) -> set[float]:
    """The heights at which plastic is laid [mm]."""
    found, height = set[float](), 0.0
    for line in gcode.splitlines():
        if place := re.search(r"^G1 Z([\d.]+)", line):
            height = float(place[1])
        elif re.search(r"^G1 X\S+ Y\S+ E[\d.]", line):
            found.add(height)
    return found


def main() -> None:
    """Measure the parts named, or all; write what is known of all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", choices=[*names(), []])
    kept = DOCS / "slicing.json"
    spread = styles()[:: len(styles()) // len(names())]
    chosen = parser.parse_args().parts or names()
    if absent := [slicer for slicer in ("prusa-slicer", "slic3r") if shutil.which(slicer) is None]:
        parser.error(f"not on PATH: {', '.join(absent)}")
    for part in chosen:
        with tempfile.TemporaryDirectory() as folder:
            found = measure(part, spread[names().index(part)].replace("_", " "), Path(folder))
        print(part, found, flush=True)
        known = msgspec.json.decode(kept.read_bytes(), type=dict[str, Sliced]) if kept.is_file() else {}  # others may run beside
        known = dict(sorted({**known, part: found}.items()))
        kept.write_bytes(msgspec.json.format(msgspec.json.encode(known), indent=1))
    known = msgspec.json.decode(kept.read_bytes(), type=dict[str, Sliced])
    print(f"{sum(one.whole for one in known.values())} of {len(known)} are closed, and have the layers that they ask for in all four")


if __name__ == "__main__":
    main()
