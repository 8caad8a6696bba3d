"""Parts of the gallery styled, written for the slicer and sliced by PrusaSlicer: watertight, warnings, walls, changes.

Needs prusa-slicer on PATH, lib3mf, and minutes a part. What was measured is kept in docs/print-benchmark.json.

python benchmarks/printing.py                  # the parts of PARTS
python benchmarks/printing.py drawer_knob      # some of them
python benchmarks/printing.py --show           # the table of what was measured
python benchmarks/printing.py --picture RUN    # docs/printing.png
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import msgspec
from lib3mf import get_wrapper

import mechstyle as ms
from mechstyle.geometry.filaments import clustered, in_bands, painted, palette_of, print_cost
from mechstyle.pictures.figure import Panel
from mechstyle.pictures.panels import picture
from mechstyle.runs.run import Run
from pictures import keep

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

DOCS = Path(__file__).parent.parent / "docs"
PARTS = {
    "drawer_knob": "brick",
    "key_turner": "knurling",
    "napkin_ring": "voronoi",
    "coaster": "celtic knot",
    "door_stop": "bamboo",
    "s_hook": "dragon scales",
}
SIZE = {"vertices": 12_000, "iterations": 30, "orientations": 2}
MACHINE = (
    *("--nozzle-diameter", "0.4,0.4,0.4,0.4", "--filament-diameter", "1.75,1.75,1.75,1.75", "--temperature", "210,210,210,210"),
    *("--single-extruder-multi-material", "--layer-height", "0.2"),
)
COLUMNS = (
    "part", "style", "watertight", "slicer warnings", "thinnest wall [mm]", "crossing pairs", "layers",
    "changes, counted", "changes, sliced",
)  # fmt: skip


class Measured(msgspec.Struct):
    """What became of a part."""

    style: str
    watertight: bool
    warnings: list[str]
    thinnest: tuple[float, float]
    crossings: tuple[int, int]
    layers: int
    changes: tuple[int, int]


def measure(name: str, style: str, folder: Path) -> Measured:
    """Style a part, write it and slice it."""
    run: Run = ms.stylize(ms.load(f"gallery:{name}"), style, **SIZE, name=name, out=folder / name)
    written = run.exported(folder / f"{name}.3mf", printing=ms.Printing(colours=4))
    sound, said = sliceable(folder / f"{name}.3mf")
    gcode = (folder / f"{name}.gcode").read_text()
    plan, quality = written.printing, written.quality
    tools = len(re.findall(r"^T\d", gcode, re.MULTILINE))
    return Measured(
        style=style,
        watertight=sound,
        warnings=said,
        thinnest=(quality.thinnest_before, quality.thinnest),
        crossings=(quality.crossings_before, quality.crossings),
        layers=plan.cost.layers,
        changes=(plan.cost.changes, max(tools - 1, 0)),  # the first loads, and changes nothing
    )


def sliceable(path: Path) -> tuple[bool, list[str]]:
    """Whether a file is strict and watertight for both readers, and what the slicer said while it wrote the G-code beside it."""
    model = get_wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromFile(str(path))
    meshes, sound = model.GetMeshObjects(), reader.GetWarningCount() == 0
    while meshes.MoveNext():
        sound = sound and meshes.GetCurrentMeshObject().IsManifoldAndOriented()
    told = subprocess.run(["prusa-slicer", "--info", str(path)], capture_output=True, text=True, check=True).stdout
    sound = sound and "manifold = yes" in told
    mended = r"open_edges|facets_(degenerate|removed|reversed)|edges_fixed|backwards"
    repaired = [line for line in told.splitlines() if re.match(mended, line)]
    command = ["prusa-slicer", "--export-gcode", *MACHINE, "-o", str(path.with_suffix(".gcode")), str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    lines = (done.stdout + done.stderr).splitlines()
    told_of = [line for line in lines if re.search(r"warning|error|repair|empty layer", line, re.IGNORECASE)]
    said = sorted({re.sub(r"^(\[.*?\]\s*)+", "", line).strip() for line in told_of})  # without the clock and the number of the thread
    return sound, [*repaired, *said]


def row(name: str, found: Measured) -> str:
    """A line of the table."""
    cells = (
        name.replace("_", " "), found.style, "yes" if found.watertight else "**no**", "; ".join(found.warnings) or "none",
        f"{found.thinnest[0]:.2f} → {found.thinnest[1]:.2f}", f"{found.crossings[0]} → {found.crossings[1]}",
        found.layers, *found.changes,
    )  # fmt: skip
    return "| " + " | ".join(map(str, cells)) + " |"


def draw(run: Run) -> None:
    """The part of a run in its own colours, in filaments chosen for it, in some of a user's, and in bands."""
    surface = run.surface()
    own, mine = clustered(surface.colours, 4), palette_of("#2b2b2b, #f4f1e8, #c0392b")
    looks = (
        (surface, "as styled", ""),
        *((paint.shown, title, print_cost(paint)) for paint, title in (
            (painted(surface, own), "4 filaments, chosen"),
            (painted(surface, mine), "3 filaments in the printer"),
            (in_bands(surface, mine), "the same in bands"),
        )),
    )  # fmt: skip
    panels = [Panel(mesh, title, note=f"{cost.changes} changes" if cost else "") for mesh, title, cost in looks]
    keep("printing", picture(panels, title=""))


def main() -> None:
    """Measure the parts named, or all; print what is known of all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", choices=[*PARTS, []])
    parser.add_argument("--show", action="store_true", help="print what was measured, and measure nothing")
    parser.add_argument("--picture", metavar="RUN", help="draw docs/printing.png of a run, and nothing else")
    given = parser.parse_args()
    if given.picture:
        draw(Run.open(given.picture))
        return
    kept = DOCS / "print-benchmark.json"
    known = msgspec.json.decode(kept.read_bytes(), type=dict[str, Measured]) if kept.is_file() else {}
    for name in [] if given.show else given.parts or PARTS:
        with tempfile.TemporaryDirectory() as folder:
            known[name] = measure(name, PARTS[name], Path(folder))
        print(row(name, known[name]), flush=True)
        kept.write_bytes(msgspec.json.format(msgspec.json.encode(known), indent=1))
    lines = [row(name, known[name]) for name in PARTS if name in known]
    print("| " + " | ".join(COLUMNS) + " |", "|" + "---|" * len(COLUMNS), *lines, sep="\n")


if __name__ == "__main__":
    main()
