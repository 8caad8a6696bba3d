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

from mechstyle import gallery
from mechstyle.errors import MechStyleError
from mechstyle.gallery.style_sheet import model_sheet
from mechstyle.records import sentences
from mechstyle.records.mesh import STANDARD_VERTICES
from mechstyle.simulation.part_test import simulate

DOCS = Path(__file__).parent.parent / "docs"
HEAD = """\
# The gallery

![thirty models](gallery.png)

Thirty things people print, each with measures to change (`gallery.make("wall_hook", reach=60)`, see the function of its name), in mm,
standing as printed. `mechstyle gallery` lists them with what one learns from each; `--load gallery:NAME` puts the load of its use on a part
besides the fall, and the regions are suggestions for `--protect`.

Made by `python benchmarks/gallery.py`, for solid PLA and a fall of 1.5 m. *Flat* and *nearly flat* are the heights from which the
plain part begins to yield. The load factor says how many times its load the part carries. [How MechStyle judges](how-mechstyle-judges.md).

A style needs room above the fall that is asked for. A part that just holds 1.5 m flat has little, and a smaller fall gives it more.
Shape decides in a flat landing, and thickness hardly. What lies level and reaches out, or spans between two feet, goes on falling where
its ends have stopped, and is bent.

"""
COLUMNS = (
    "model", "what it teaches", "`--protect`", "flat", "nearly flat", "load", "load factor", "outcome", "tetrahedra", "processor time [s]",
)  # fmt: skip


class Measured(msgspec.Struct):
    """Result of a model: critical drop heights [mm], load factor, outcome, size of the test and its processor time [s]."""

    vertices: int
    tetrahedra: int
    seconds: float
    flat: float | None
    nearly_flat: float | None
    factor: float | None
    outcome: str


def measure(name: str, vertices: int, device: str) -> Measured:
    """Drop a model flat and nearly flat, and load it."""
    began = sum(os.times()[:4])
    use = gallery.entry(name).use
    test = simulate(gallery.make(name), loads=[use] if use else [], vertices=vertices, device=device)
    rows = {row.test: row for row in test.verdict.rows}
    heights = (rows[kind].height if kind in rows else None for kind in ("flat", "nearly flat"))
    count = len(test.part.surface.vertices), len(test.part.tets.volumes)
    factor = rows["load"].factor if "load" in rows else None
    return Measured(*count, round(sum(os.times()[:4]) - began, 1), *heights, factor, test.verdict.outcome)


def page(known: dict[str, Measured]) -> str:
    """The page with what is known."""
    lines = [f"| {' | '.join(COLUMNS)} |\n", f"|{'---|' * len(COLUMNS)}\n"]
    for name in gallery.names():
        entry, one = gallery.entry(name), known.get(name)
        flat, nearly = (("–",) * 2 if one is None else ("–" if h is None else sentences.length(h) for h in (one.flat, one.nearly_flat)))
        factor = "–" if one is None or one.factor is None else f"{one.factor:.1f}"
        rest = ("–",) * 3 if one is None else (one.outcome, str(one.tetrahedra), f"{one.seconds:.0f}")
        protect, use = ", ".join(f"`{region}`" for region in entry.protect), entry.use.name if entry.use else "–"
        lines.append(f"| {' | '.join((name.replace('_', ' '), entry.teaches, protect, flat, nearly, use, factor, *rest))} |\n")
    return HEAD + "".join(lines)


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
