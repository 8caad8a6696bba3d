"""Whether other numbers of tetrahedra or vertices come to the same outcome: every part of the gallery, in a style without feedback.

python benchmarks/sizes.py --sizes 8000 25000 --jobs 14 --json sizes.json           # all parts in brick, 100 000 vertices
python benchmarks/sizes.py --sizes 0 --vertices 2000 25000 --json vertices.json     # as many tetrahedra as a run makes by itself
python benchmarks/sizes.py wall_hook --sizes 8000 25000 --vertices 25000            # one of them
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import tempfile
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import replace
from itertools import combinations, product
from pathlib import Path

import msgspec

from mechstyle import gallery
from mechstyle.errors import MechStyleError
from mechstyle.geometry.remeshing import filling
from mechstyle.geometry.remeshing.tolerances import TOL
from mechstyle.records.mesh import STANDARD_VERTICES
from mechstyle.runs.run import stylize
from mechstyle.simulation import part


class Found(msgspec.Struct):
    """What became of a part with a number of tetrahedra.

    Attributes:
        outcome, sure: Of its verdict.
        bends: What stays bent of the plain and of the styled part by landing [mm].
        tetrahedra: Those of the styled part.
        thicker: Share by which they make a wall thicker.
        seconds: Processor time with meshing [s].
    """

    outcome: str
    sure: bool
    bends: dict[str, tuple[float, float]]
    tetrahedra: int
    thicker: float
    seconds: float


def found(name: str, size: int, vertices: int, prompt: str, device: str) -> Found:
    """One part with one number of tetrahedra, from an empty cache: as many triangles are kept as these make, whatever the relief needs.

    With 0 tetrahedra they are those that a run makes by itself.
    """
    if size:
        part.TETS, filling.KEPT = size, (round(0.75 * size),)
        vars(filling)["TOL"] = replace(TOL, finest_input=size)
    began = sum(os.times()[:4])
    with tempfile.TemporaryDirectory() as folder:
        os.environ["MECHSTYLE_CACHE"] = str(Path(folder, "cache"))
        run = stylize(gallery.make(name), prompt, freestyle=True, vertices=vertices, out=Path(folder, "run"), device=device)
        rows = {row.landing: (row.plain_permanent_set or 0.0, row.permanent_set) for row in run.verdict.rows}
        simulation, count = run.simulation(), len(run.part.tets.tets)
        verdict = run.verdict
    return Found(verdict.outcome, verdict.sure, rows, count, simulation.thicker, round(sum(os.times()[:4]) - began, 1))


def main() -> None:
    """Measure, and say where sure outcomes differ."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("models", nargs="*", help="names; all of the gallery unless told")
    parser.add_argument("--sizes", type=int, nargs="+", default=[part.TETS, 25_000], help="tetrahedra; 0 for those of a run")
    parser.add_argument("--vertices", type=int, nargs="+", default=[STANDARD_VERTICES])
    parser.add_argument("--prompt", default="brick")
    parser.add_argument("--device", default="cpu")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--json", type=Path, help="where the figures are kept, and what was measured before is found")
    given = parser.parse_args()
    known = msgspec.json.decode(given.json.read_bytes(), type=dict[str, Found]) if given.json and given.json.is_file() else {}
    os.environ |= {"MECHSTYLE_THREADS": "1", "OMP_NUM_THREADS": "1"} if given.jobs > 1 else {}
    names, ways = given.models or gallery.names(), list(product(given.sizes, given.vertices))
    wanted = [(name, *way) for way in ways for name in names if _key(name, *way) not in known]
    with ProcessPoolExecutor(given.jobs, mp_context=multiprocessing.get_context("spawn"), max_tasks_per_child=1) as pool:
        waiting = {pool.submit(found, *one, given.prompt, given.device): one for one in wanted}
        for job in as_completed(waiting):
            key = _key(*waiting[job])
            try:
                known[key] = job.result()
            except MechStyleError as error:
                print(f"{key}: {error}", flush=True)
                continue
            print(key, known[key], flush=True)
            if given.json:
                given.json.write_bytes(msgspec.json.format(msgspec.json.encode(known, order="sorted"), indent=1))
    for one, other in combinations(ways, 2):
        pairs = [
            (known[_key(name, *one)], known[_key(name, *other)]) for name in names if {_key(name, *one), _key(name, *other)} <= set(known)
        ]
        sure = [(a, b) for a, b in pairs if a.sure and b.sure]
        print(
            f"{one} and {other}: {sum(a.outcome == b.outcome for a, b in sure)} of {len(sure)} sure outcomes agree, of {len(pairs)} parts"
        )


def _key(name: str, size: int, vertices: int) -> str:
    """What a figure is kept under."""
    return f"{name} {size} tetrahedra, {vertices} vertices"


if __name__ == "__main__":
    main()
