"""Every model of the gallery dropped and loaded as it is; writes docs/gallery.md and its picture.

python benchmarks/gallery.py                           # all, at full size: hours on a laptop
python benchmarks/gallery.py --jobs 16 --json gallery.json # in processes side by side; figures go into a file of its own
python benchmarks/gallery.py --vertices 1500 wall_hook # some; what was measured before is kept in docs/gallery.json
python benchmarks/gallery.py --read wall_hook.json s_hook.json # page and picture with what was measured elsewhere
python benchmarks/gallery.py --page                    # the page alone
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

import msgspec
from sheets import model_sheet

from mechstyle import gallery
from mechstyle.errors import MechStyleError
from mechstyle.records import sentences
from mechstyle.records.mesh import STANDARD_VERTICES
from mechstyle.simulation.part_test import simulate

DOCS = Path(__file__).parent.parent / "docs"
HEAD = """\
# The gallery

![Thirty models, each in a style that suits it](gallery.png)

Thirty things people print, each with measures to change (`gallery.make("wall_hook", reach=60)`, see the function of its name), in mm,
standing as printed. The picture shows them styled, the table plain. `mechstyle gallery` lists them with what one learns from each;
`--load gallery:NAME` puts the load of its use on a part besides the fall, and the regions are suggestions for `--protect`.

{about} [How MechStyle judges](how-mechstyle-judges.md).

A style needs room below the tolerance. What lies level and reaches out, or spans between two feet, goes on falling where its ends have
stopped, and is bent.

"""
ABOUT = """\
Made by `python benchmarks/gallery.py`, for solid PLA, a fall of 1.5 m and a tolerance of 0.2 mm. *Flat* and *nearly flat* are what stays
bent of the plain part, *strain* its most plastic strain in tension, *carries* how many times its load. Rows of 3000 vertices were
dropped on a GPU by `python benchmarks/as_printed.py`, without load."""
COLUMNS = (
    "model", "outcome", "flat", "nearly flat", "strain", "load", "stays bent", "carries", "what it teaches", "`--protect`", "vertices",
    "tetrahedra",
)  # fmt: skip
"""What was found stands first, where it is in sight."""


class Measured(msgspec.Struct):
    """Result of a model: what stays bent [mm], plastic strain, times its load, outcome and size of the test, None if unknown."""

    vertices: int
    tetrahedra: int | None
    flat: float | None
    nearly_flat: float | None
    strain: float
    loaded: float | None
    carries: float | None
    outcome: str


def measure(name: str, vertices: int, device: str) -> Measured:
    """Drop a model flat and nearly flat, and load it."""
    use = gallery.entry(name).use
    test = simulate(gallery.make(name), loads=[use] if use else [], vertices=vertices, device=device)
    rows = test.verdict.rows
    bent = (max((row.permanent_set for row in rows if row.test == kind), default=None) for kind in ("flat", "nearly flat"))
    strain = max((row.plastic_strain for row in rows), default=0.0)
    loaded = next(((row.permanent_set, row.carries) for row in rows if row.load), (None, None))
    count = len(test.part.surface.vertices), len(test.part.tets.volumes)
    return Measured(*count, *bent, strain, *loaded, test.verdict.outcome)


def page(known: dict[str, Measured]) -> str:
    """The page with what is known."""
    lines = [f"| {' | '.join(COLUMNS)} |\n", f"|{'---|' * len(COLUMNS)}\n"]
    for name in gallery.names():
        entry, one = gallery.entry(name), known.get(name)
        protect, use = ", ".join(f"`{region}`" for region in entry.protect), entry.use.name if entry.use else "–"
        cells = {"model": name.replace("_", " "), "what it teaches": entry.teaches, "`--protect`": protect, "load": use}
        if one is not None:
            flat, nearly, loaded = ("–" if bend is None else sentences.bend(bend) for bend in (one.flat, one.nearly_flat, one.loaded))
            carries = "–" if one.carries is None else f"{one.carries:.1f} ×"
            cells |= {"outcome": one.outcome, "flat": flat, "nearly flat": nearly, "strain": f"{one.strain:.1%}", "stays bent": loaded}
            cells |= {"carries": carries, "vertices": str(one.vertices), "tetrahedra": str(one.tetrahedra or "–")}
        lines.append(f"| {' | '.join(cells.get(column, '–') for column in COLUMNS)} |\n")
    holds = sum(one.outcome == "HOLDS" for one in known.values())
    return f"{HEAD.format(about=ABOUT)}{''.join(lines)}\n{holds} of {len(known)} hold.\n"


def main() -> None:
    """Measure, and write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("models", nargs="*", help="names; all of the gallery unless told")
    parser.add_argument("--vertices", type=int, default=STANDARD_VERTICES)
    parser.add_argument("--device", default="auto")
    parser.add_argument("--page", action="store_true", help="write the page and the picture from what was measured before")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--json", type=Path, help="where the figures are kept; in docs/gallery.json, with page and picture, unless told")
    parser.add_argument("--read", type=Path, nargs="+", help="figures that were measured elsewhere, which join those that are kept")
    given = parser.parse_args()
    kept = given.json or DOCS / "gallery.json"
    known = msgspec.json.decode(kept.read_bytes(), type=dict[str, Measured]) if kept.is_file() else {}
    if given.jobs > 1:
        os.environ |= {"MECHSTYLE_THREADS": "1", "OMP_NUM_THREADS": "1"}
    for path in given.read or ():
        known |= msgspec.json.decode(path.read_bytes(), type=dict[str, Measured])
    if given.read:
        kept.write_bytes(msgspec.json.format(msgspec.json.encode(known, order="sorted"), indent=1) + b"\n")
    wanted = [] if given.page or given.read else given.models or gallery.names()
    with ProcessPoolExecutor(given.jobs, mp_context=multiprocessing.get_context("spawn"), max_tasks_per_child=1) as pool:
        waiting = {pool.submit(measure, name, given.vertices, given.device): name for name in wanted}
        for job in as_completed(waiting):
            name = waiting[job]
            try:
                known[name] = job.result()
            except MechStyleError as error:
                print(f"{name}: {error}")
                continue
            print(name, known[name], flush=True)
            kept.write_bytes(msgspec.json.format(msgspec.json.encode(known, order="sorted"), indent=1) + b"\n")
    if given.json is None:
        (DOCS / "gallery.md").write_text(page(known), encoding="utf-8")
        model_sheet().save(DOCS / "gallery.png")


if __name__ == "__main__":
    main()
