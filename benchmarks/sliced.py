"""Twenty gallery parts, plain and styled, sliced by PrusaSlicer, Slic3r and CuraEngine: what `--sliced` reads of them, and of half of them.

Needs prusa-slicer, slic3r and CuraEngine on PATH and Cura's fdmprinter.def.json (Debian's package cura). CuraEngine writes the way of the
nozzle alone: the settings after it are written here as Cura's own window writes them. Keeps what was read in docs/sliced.json.

python benchmarks/sliced.py --definitions /usr/share/cura/resources/definitions
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import msgspec
from slicing import in_style

import mechstyle as ms
from mechstyle.errors import BadInput
from mechstyle.geometry.files import save
from mechstyle.records.sliced import STRAIGHT, sliced

KEPT = Path(__file__).parent.parent / "docs" / "sliced.json"
PARTS, STYLE = ("cable_clip", "s_hook", "drawer_knob", "bag_clip", "napkin_ring"), "brick"
SLICERS = ("prusa-slicer", "slic3r", "CuraEngine")
DENSITIES, HEIGHTS, WIDTHS = (0.1, 0.15, 0.2, 0.35, 0.5), (0.12, 0.16, 0.2, 0.24, 0.28, 0.3), (0.4, 0.42, 0.45, 0.5)
PATTERNS = ("gyroid", "grid", "rectilinear")
SLIC3R = {
    "walls": "perimeters", "top": "top-solid-layers", "bottom": "bottom-solid-layers", "layer_height": "layer-height",
    "line_width": "perimeter-extrusion-width", "infill_pattern": "fill-pattern", "infill": "fill-density",
}  # fmt: skip
CURA = {
    "walls": "wall_line_count", "top": "top_layers", "bottom": "bottom_layers", "layer_height": "layer_height",
    "line_width": "wall_line_width_x", "infill_pattern": "infill_pattern", "infill": "infill_sparse_density",
}  # fmt: skip
"""Names of settings in each slicer."""


class Read(msgspec.Struct):
    """A file, what was asked of its slicer and what was read; and the sentence that half of it was refused with."""

    slicer: str
    part: str
    asked: dict[str, Any]
    read: dict[str, Any]
    cut: str

    @property
    def right(self) -> bool:
        """Whether it was read as asked, and half of it refused."""
        return self.read == self.asked and bool(self.cut)


def print_of(number: int) -> dict[str, Any]:
    """How a file is printed: all of them differ."""
    return {
        "walls": 1 + number % 6, "top": 2 + number % 7, "bottom": 1 + number % 5, "layer_height": HEIGHTS[number % len(HEIGHTS)],
        "line_width": WIDTHS[number // 2 % len(WIDTHS)], "infill": DENSITIES[number % len(DENSITIES)],
        "infill_pattern": PATTERNS[number % len(PATTERNS)],
    }  # fmt: skip


def sliced_by(slicer: str, part: Path, asked: Mapping[str, Any], definitions: Path) -> Path:
    """The G-code that a slicer makes of a part."""
    out, percent = part.with_suffix(".gcode"), f"{100.0 * asked['infill']:g}"
    if slicer != "CuraEngine":
        options = [f"--{SLIC3R[name]}={value}" for name, value in {**asked, "infill": f"{percent}%"}.items()]
        export = ["--export-gcode"] if slicer == "prusa-slicer" else []
        subprocess.run([slicer, *export, "--nozzle-diameter=0.4", *options, "-o", out, part], check=True, capture_output=True)
        return out
    values = {CURA[name]: value for name, value in asked.items()} | {
        "infill_sparse_density": percent, "infill_pattern": asked["infill_pattern"].replace("rectilinear", "lines"),
    }  # fmt: skip
    options = [word for name, value in values.items() for word in ("-s", f"{name}={value}")]
    profile = definitions / "fdmprinter.def.json"
    subprocess.run([slicer, "slice", "-j", profile, *options, "-l", part, "-o", out], check=True, capture_output=True)
    with out.open("a", encoding="utf-8") as file:
        file.writelines(as_cura_writes(values))
    return out


def as_cura_writes(values: Mapping[str, Any]) -> list[str]:
    """Settings in lines of 80 characters at most, those of the printer and those of its extruder."""
    height = {"layer_height": values["layer_height"]}
    chapters = [
        "[general]\nversion = 4\n\n[values]\n" + "".join(f"{name} = {value}\n" for name, value in sorted(of.items())) + "\n"
        for of in (height, {name: value for name, value in values.items() if name not in height})
    ]
    whole, extruder = (chapter.replace("\n", "\\n") for chapter in chapters)
    text = msgspec.json.encode({"global_quality": whole, "extruder_quality": [extruder]}).decode()
    width = 80 - len(";SETTING_3 ")
    return [f";SETTING_3 {text[start : start + width]}\n" for start in range(0, len(text), width)]


def refusal(file: Path) -> str:
    """The sentence that the first half of a file is refused with; "" if it is not."""
    cut = file.with_name(f"half-{file.name}")
    cut.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    try:
        sliced(cut)
    except BadInput as error:
        return str(error)
    return ""


def main() -> None:
    """Slice and read all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--definitions", type=Path, default=Path("/usr/share/cura/resources/definitions"), help="Cura's")
    definitions, found = parser.parse_args().definitions, list[Read]()
    if absent := [slicer for slicer in SLICERS if shutil.which(slicer) is None]:
        parser.error(f"not on PATH: {', '.join(absent)}")
    with tempfile.TemporaryDirectory() as folder:
        meshes = {part: ms.load(f"gallery:{part}") for part in PARTS} | {f"{part} in {STYLE}": in_style(part, STYLE)[0] for part in PARTS}
        for number, (name, mesh) in enumerate([*meshes.items(), *meshes.items()]):
            slicer, asked, part = SLICERS[number % len(SLICERS)], print_of(number), Path(folder) / f"{name.replace(' ', '_')}.stl"
            save(mesh, part)
            file = sliced_by(slicer, part, asked, definitions)
            expected = {**asked, "infill_pattern": STRAIGHT.get(asked["infill_pattern"], asked["infill_pattern"])}
            found.append(Read(slicer, name, expected, sliced(file), refusal(file)))
            print(slicer, name, "as asked" if found[-1].right else found[-1], flush=True)
    KEPT.write_bytes(msgspec.json.format(msgspec.json.encode(found), indent=1))
    print(f"{sum(one.right for one in found)} of {len(found)} are read as asked, and the first half of each is refused")


if __name__ == "__main__":
    main()
