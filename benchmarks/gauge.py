"""How steady the permanent set is: parts that are turned, mirrored and meshed again, coarsely and finely, dropped flat, 3° and 10° off.

Each part in each way is prepared from its surface on and dropped in a process of its own with one thread. Of a part, the worst landing of
each kind is compared with the median over all ways and sizes.

python benchmarks/gauge.py --jobs 16 --json gauge.json                 # eight parts, five ways, about 3k, 8k and 20k tetrahedra
python benchmarks/gauge.py --parts wall_hook --vertices 1200           # one of them, coarsely
python benchmarks/gauge.py --read gauge.json                           # the table alone, of what was measured before
"""

from __future__ import annotations

import argparse
import itertools
import math
import multiprocessing
import os
import sys
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from statistics import median

import msgspec
import numpy as np

PARTS = ("wall_hook", "drawer_knob", "phone_stand", "pill_box", "tealight_holder", "napkin_ring", "bag_carrier", "tablet_stand")
WAYS = ("as it is", "turned 23°", "turned 51°", "mirrored", "meshed again")
VERTICES = (1200, 3000, 8000)
"""Which make about 3k, 8k and 20k tetrahedra."""
ANEW = 1.04
"""Vertices asked for over the others' where a part is only meshed again."""
TILT = 10.0
"""How far off flat a part lands besides [°]."""
AIMS = {"flat": (0.01, 0.0, 8), "nearly flat": (0.02, 0.1, 7), "10°": (0.02, 0.1, 6)}
"""What is allowed off the median [mm], as a share of it, and how many of eight parts must be within."""


class Found(msgspec.Struct, frozen=True, kw_only=True):
    """A part in one way: what stays bent in the worst landing of each kind [mm], and what it took."""

    part: str
    way: str
    vertices: int
    tetrahedra: int = 0
    bent: dict[str, float] = {}
    seconds: float = 0.0
    failure: str = ""


def found(part: str, way: str, vertices: int, device: str) -> Found:
    """A part in one way, by the drop test itself."""
    from mechstyle.errors import MechStyleError  # noqa: PLC0415 — in processes of their own, after their environment is set
    from mechstyle.fea.drop import DropTest, drop, resolve_device  # noqa: PLC0415
    from mechstyle.fea.orientations import landings  # noqa: PLC0415
    from mechstyle.fea.permanent_set import measured  # noqa: PLC0415
    from mechstyle.records.material import LIBRARY  # noqa: PLC0415
    from mechstyle.simulation.part import prepare  # noqa: PLC0415

    started, asked = time.process_time(), round(ANEW * vertices) if way == "meshed again" else vertices
    try:
        piece = prepare(surface_in(part, way), vertices=asked)
        where = landings(piece.surface, "fibonacci", 1, nearly_flat=True)
        nearly = where.normals[1:]
        level = nearly[:, :2] / np.linalg.norm(nearly[:, :2], axis=1, keepdims=True)
        turn = math.radians(TILT)
        tilted = np.column_stack([math.sin(turn) * level, np.full(len(nearly), math.cos(turn))])
        dropped = drop(piece.tets, LIBRARY["PLA"], np.concatenate([where.normals, tilted]), DropTest(), device=resolve_device(device))
    except MechStyleError as error:
        return Found(part=part, way=way, vertices=vertices, failure=str(error))
    if dropped.failure:
        return Found(part=part, way=way, vertices=vertices, failure=dropped.failure)
    each = [measured(piece.tets, *both).permanent_set for both in zip(dropped.permanent, dropped.tension_strain, strict=True)]
    kinds = np.array(["flat", *["nearly flat"] * len(nearly), *["10°"] * len(nearly)])
    worst = {kind: float(np.array(each)[kinds == kind].max()) for kind in AIMS}
    return Found(part=part, way=way, vertices=vertices, tetrahedra=len(piece.tets.tets), bent=worst, seconds=time.process_time() - started)


def surface_in(part: str, way: str):  # noqa: ANN201 — a SurfaceMesh, imported where it is used
    """The surface of a part in one way."""
    from mechstyle import gallery  # noqa: PLC0415
    from mechstyle.records.mesh import SurfaceMesh  # noqa: PLC0415

    surface = gallery.make(part)
    if way == "mirrored":
        return SurfaceMesh(surface.vertices * [-1.0, 1.0, 1.0], surface.faces[:, ::-1])
    angle = math.radians(float(way.removeprefix("turned ").removesuffix("°"))) if way.startswith("turned") else 0.0
    c, s = math.cos(angle), math.sin(angle)
    return SurfaceMesh(surface.vertices @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]), surface.faces)


def table(everything: Sequence[Found]) -> Iterator[str]:
    """The median of each part and how far off it the ways are, as Markdown; then how many parts are within what is aimed at."""
    yield f"| part | tests | tetrahedra | {' | '.join(f'{kind}: median, least to most [mm]' for kind in AIMS)} |"
    yield f"|---|---|---|{'---|' * len(AIMS)}"
    within = dict.fromkeys(AIMS, 0)
    parts = list(dict.fromkeys(one.part for one in everything))
    for part in parts:
        those = [one for one in everything if one.part == part and not one.failure]
        cells = [part.replace("_", " "), str(len(those)), " ".join(sorted({f"{one.tetrahedra / 1000:.0f}k" for one in those}))]
        for kind, (bend, share, _) in AIMS.items():
            values = [one.bent[kind] for one in those]
            if not values:
                cells.append("–")
                continue
            middle = median(values)
            off = max(abs(value - middle) for value in values) <= max(bend, share * middle)
            within[kind] += off
            cells.append(f"{middle:.3f}, {min(values):.3f} to {max(values):.3f}{'' if off else ' ✗'}")
        yield f"| {' | '.join(cells)} |"
    yield "\nWithin: " + ", ".join(f"{kind} {within[kind]} of {len(parts)} (aimed at {least} of 8)" for kind, (*_, least) in AIMS.items())


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure what is asked for and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--parts", nargs="+", default=PARTS)
    parser.add_argument("--ways", nargs="+", default=WAYS, choices=WAYS)
    parser.add_argument("--vertices", nargs="+", type=int, default=VERTICES)
    parser.add_argument("--device", default="auto")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--read", type=Path, nargs="+", help="figures that were measured before; nothing is measured")
    options = parser.parse_args(arguments)
    os.environ |= {"MECHSTYLE_THREADS": "1", "OMP_NUM_THREADS": "1"}
    measured = [one for path in options.read or () for one in msgspec.json.decode(path.read_bytes(), type=list[Found])]
    asked = [] if options.read else list(itertools.product(options.parts, options.ways, options.vertices))
    with ProcessPoolExecutor(options.jobs, mp_context=multiprocessing.get_context("spawn"), max_tasks_per_child=1) as pool:
        waiting = [pool.submit(found, *one, options.device) for one in sorted(asked, key=lambda one: -one[2])]
        for job in as_completed(waiting):
            one = job.result()
            measured.append(one)
            bent = one.failure or ", ".join(f"{kind} {value:.3f}" for kind, value in one.bent.items())
            print(f"{one.part}, {one.way}, {one.tetrahedra} tetrahedra: {bent}; {one.seconds:.0f} CPU s", file=sys.stderr, flush=True)
            if options.json is not None:
                options.json.write_bytes(msgspec.json.format(msgspec.json.encode(measured)))
    measured.sort(key=lambda one: (one.part, one.vertices, one.way))
    print("\n".join(table(measured)))
    return 1 if any(one.failure for one in measured) else 0


if __name__ == "__main__":
    sys.exit(main())
