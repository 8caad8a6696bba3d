"""Every part of the gallery in even triangles, filled: count, quality, deviation, elements x steps: docs/meshing.json.

What was measured before is kept in its .json; a part takes some five CPU seconds.

python benchmarks/meshing.py                  # every part, 10 000 vertices asked for
python benchmarks/meshing.py lampshade vase   # some of them
python benchmarks/meshing.py --drops          # what a drop on their tetrahedra takes, the surfaces as measured before
python benchmarks/meshing.py --show           # the table of what was measured
"""

from __future__ import annotations

import argparse
import math
import time
from pathlib import Path

import msgspec
import numpy as np

from mechstyle import gallery
from mechstyle.fea.discretisation import discretise
from mechstyle.fea.drop import DropTest, scheme_for
from mechstyle.fea.elements import element_named
from mechstyle.fea.linear_solvers import lowest_period
from mechstyle.geometry.proximity import TriangleTree
from mechstyle.geometry.remeshing.crossings import crossings
from mechstyle.geometry.remeshing.evening import even
from mechstyle.records.material import LIBRARY
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.simulation.part import prepare

DOCS = Path(__file__).parent.parent / "docs"
ASKED = 10_000
PLACES = np.array([[1, 1, 1], [3, 0, 0], [1.5, 1.5, 0], [0, 1.5, 1.5], [1.5, 0, 1.5]]) / 3.0
"""Weights of a triangle's corners at the places whose distance from the other surface is measured."""
COLUMNS = ("part", "vertices", "edge [mm]", "quality", "crossing", "off [mm]", "CPU [s]", "tets", "steps", "product [million]")
"""Vertices and crossing pairs before and after; quality 4 √3 A / Σ l² of the triangles, its mean and what 1 % fall short of; the largest
distance of either surface from the other; steps of a drop through one lowest period, which a drop takes at least: it costs the product."""


class Measured(msgspec.Struct):
    """What became of a part; lengths in mm; tetrahedra and steps None where they were not counted."""

    vertices: tuple[int, int]
    edge: float
    quality: tuple[float, float]
    crossings: tuple[int, int]
    deviation: float
    seconds: float
    tetrahedra: int | None = None
    steps: int | None = None


def measure(name: str) -> Measured:
    """Bring a part of the gallery to even triangles."""
    part = gallery.make(name)
    begun = time.process_time()
    evened = even(part, ASKED)
    seconds = time.process_time() - begun
    sides = np.linalg.norm(np.roll(evened.corners, -1, axis=1) - evened.corners, axis=2)
    quality = 4.0 * np.sqrt(3.0) * evened.face_areas / np.square(sides).sum(axis=1)
    return Measured(
        vertices=(len(part.vertices), len(evened.vertices)),
        edge=float(sides.mean()),
        quality=(float(quality.mean()), float(np.percentile(quality, 1))),
        crossings=(crossings(part).pairs, crossings(evened).pairs),
        deviation=max(farthest(part, evened), farthest(evened, part)),
        seconds=seconds,
    )


def counted(name: str) -> tuple[int, int]:
    """Tetrahedra of a part as it is, and steps of a drop through its lowest period."""
    test, pla = DropTest(), LIBRARY["PLA"]
    tets = prepare(gallery.make(name), vertices=ASKED).tets
    body = discretise(tets, pla, test.added_mass, element_named(test.element))
    period = lowest_period(body)
    return len(tets.tets), math.ceil(period / scheme_for(body, pla, test, period).time_step)


def farthest(one: SurfaceMesh, other: SurfaceMesh) -> float:
    """Largest distance of places on a surface from another [mm]."""
    tree = TriangleTree(other.vertices, other.faces)
    return max(float(tree.nearest(np.einsum("k,fkj->fj", weights, one.corners)).distance.max()) for weights in PLACES)


def row(name: str, found: Measured) -> str:
    """A line of the table."""
    cells = (
        name.replace("_", " "), "{} → {}".format(*found.vertices), f"{found.edge:.2f}", "{:.2f}, {:.2f}".format(*found.quality),
        "{} → {}".format(*found.crossings), f"{found.deviation:.2f}", f"{found.seconds:.1f}", *work(found),
    )  # fmt: skip
    return "| " + " | ".join(cells) + " |"


def work(found: Measured) -> tuple[str, str, str]:
    """What a drop takes, in cells."""
    if found.tetrahedra is None or found.steps is None:
        return "–", "–", "–"
    return str(found.tetrahedra), str(found.steps), f"{found.tetrahedra * found.steps / 1e6:.0f}"


def main() -> None:
    """Measure the parts named, or all; print what is known of all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", choices=[*gallery.names(), []])
    parser.add_argument("--drops", action="store_true", help="measure what a drop takes, and not the surfaces")
    parser.add_argument("--show", action="store_true", help="print what was measured, and measure nothing")
    given = parser.parse_args()
    kept = DOCS / "meshing.json"
    known = msgspec.json.decode(kept.read_bytes(), type=dict[str, Measured]) if kept.is_file() else {}
    for name in [] if given.show else given.parts or gallery.names():
        found = known[name] if given.drops else measure(name)
        tetrahedra, steps = counted(name)
        known[name] = msgspec.structs.replace(found, tetrahedra=tetrahedra, steps=steps)
        print(row(name, known[name]), flush=True)
        kept.write_bytes(msgspec.json.format(msgspec.json.encode(known), indent=1))
    print("| " + " | ".join(COLUMNS) + " |", "|" + "---|" * len(COLUMNS), *(row(name, known[name]) for name in sorted(known)), sep="\n")


if __name__ == "__main__":
    main()
