"""σ_V of parts of the gallery that are turned, mirrored, renumbered and meshed again: how far flat and nearly flat landings scatter.

Each part in each way is prepared from its surface on and dropped flat and in all its nearly flat landings, in a process of its own with one
thread. Prints a table of coefficients of variation: of σ_V flat, of the hardest σ_V nearly flat, and of its critical height.

python benchmarks/repeatability.py                                     # seven parts, seven ways, 12 000 vertices: hours on two cores
python benchmarks/repeatability.py --parts wall_hook s_hook --vertices 3000 --jobs 2
python benchmarks/repeatability.py --jobs 16 --json repeatability.json  # figures of every landing as well
python benchmarks/repeatability.py --read repeatability-*.json --page   # of what was measured before, and into docs/how-mechstyle-judges.md
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import sys
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

import msgspec
import numpy as np

PARTS = ("pen_holder", "wall_hook", "phone_stand", "tealight_holder", "drawer_knob", "pill_box", "s_hook")
WAYS = ("as it is", "turned 17°", "turned 51°", "turned 90°", "mirrored", "renumbered", "meshed again")
PAGE = Path(__file__).parent.parent / "docs" / "how-mechstyle-judges.md"
ANEW = 1.04
"""Vertices asked for over the usual where a part is only meshed again."""
FLAT, NEARLY = 0.02, 0.05
"""Coefficients of variation that are aimed at."""


class Found(msgspec.Struct, frozen=True, kw_only=True):
    """A part in one way.

    Attributes:
        part: Name of the part.
        way: One of WAYS.
        vertices: Vertices asked for.
        flat: σ_V of the flat landing [MPa].
        nearly: σ_V of each nearly flat landing by its name [MPa].
        exponent: p of σ_V ∝ height^p of the hardest of them.
        height: Least critical height nearly flat [mm].
        seconds: CPU seconds it took.
        failure: Why there are no figures, "" if there are.
    """

    part: str
    way: str
    vertices: int
    flat: float = np.nan
    nearly: dict[str, float] = {}
    exponent: float = np.nan
    height: float = np.nan
    seconds: float = 0.0
    failure: str = ""


def found(part: str, way: str, vertices: int, material: str, device: str) -> Found:
    """A part in one way, by the simulator itself."""
    from mechstyle.errors import MechStyleError  # noqa: PLC0415 — in processes of their own, after their environment is set
    from mechstyle.fea.drop import resolve_device  # noqa: PLC0415
    from mechstyle.records import Recipe  # noqa: PLC0415
    from mechstyle.records.material import material_named  # noqa: PLC0415
    from mechstyle.simulation.part import cached_memo, fitted, prepare  # noqa: PLC0415
    from mechstyle.simulation.simulator import DropSimulator  # noqa: PLC0415

    started = time.process_time()
    asked = round(ANEW * vertices) if way == "meshed again" else vertices
    try:
        piece = prepare(surface_in(part, way), vertices=asked)
        recipe = fitted(Recipe.of(prompt="", material=material_named(material)), piece)
        where = resolve_device(device)
        simulator = DropSimulator(piece, recipe, cached_memo(), device=where)
        simulation = simulator.baseline
    except MechStyleError as error:
        return Found(part=part, way=way, vertices=asked, failure=str(error))
    flat, nearly = simulation.flat, simulation.of("nearly flat")
    if simulation.failure or flat is None or not nearly:
        return Found(part=part, way=way, vertices=asked, failure=simulation.failure or "it was not dropped nearly flat")
    lowest = min(nearly, key=lambda landing: landing.critical_height)
    return Found(
        part=part, way=way, vertices=asked, flat=flat.stress, nearly={one.name: one.stress for one in nearly}, exponent=lowest.exponent,
        height=lowest.critical_height, seconds=time.process_time() - started,
    )  # fmt: skip


def surface_in(part: str, way: str):  # noqa: ANN201 — a SurfaceMesh, imported where it is used
    """The surface of a part in one way."""
    from mechstyle import gallery  # noqa: PLC0415
    from mechstyle.records.mesh import SurfaceMesh  # noqa: PLC0415

    sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
    from validation.repeatability import about_z, transformed  # noqa: PLC0415

    surface = gallery.make(part)
    if way.startswith("turned"):
        return transformed(surface, about_z(float(way.removeprefix("turned ").removesuffix("°"))))
    if way == "mirrored":
        return transformed(surface, np.diag([-1.0, 1.0, 1.0]))
    if way == "renumbered":
        order = np.random.default_rng(0).permutation(len(surface.vertices))
        place = np.argsort(order).astype(np.int32)
        faces = np.random.default_rng(1).permutation(place[surface.faces])
        return SurfaceMesh(surface.vertices[order], faces)
    return surface


def cv(values: Sequence[float]) -> float:
    """Standard deviation over the mean."""
    return float(np.std(values) / np.mean(values)) if values else np.nan


def table(all_found: Sequence[Found]) -> Iterator[str]:
    """The scatter of each part, as Markdown."""
    yield "| part | ways | flat, mean σ_V | cv | nearly flat, mean σ_V of the hardest | cv | mean h* | cv |"
    yield "|---|---|---|---|---|---|---|---|"
    worst = [0.0, 0.0]
    for part in dict.fromkeys(one.part for one in all_found):
        those = [one for one in all_found if one.part == part and not one.failure]
        columns = [[one.flat for one in those], [max(one.nearly.values()) for one in those], [one.height / 1000.0 for one in those]]
        if not those:
            yield f"| {part} | none |" + " – |" * 6
            continue
        worst = [max(before, cv(column)) for before, column in zip(worst, columns, strict=False)]
        units = ("MPa", "MPa", "m")
        shown = " | ".join(f"{np.mean(column):.3g} {unit} | {cv(column):.3f}" for column, unit in zip(columns, units, strict=True))
        yield f"| {part} | {len(those)} | {shown} |"
    yield f"\nWorst: flat {worst[0]:.3f} of {FLAT:g}, nearly flat {worst[1]:.3f} of {NEARLY:g}."


HEAD = "| part | flat: σ_V [MPa] | coefficient of variation | hardest nearly flat: σ_V [MPa] | coefficient of variation |"
"""First line of the table in docs/how-mechstyle-judges.md."""


def on_the_page(all_found: Sequence[Found]) -> None:
    """Put the scatter into the table of the page, in place of what is there."""
    lines = [HEAD, "|---|---|---|---|---|"]
    for part in dict.fromkeys(one.part for one in all_found):
        columns = [[of(one) for one in all_found if one.part == part and not one.failure] for of in (_flat, _hardest)]
        shown = " | ".join(f"{np.mean(column):.1f} | {cv(column):.3f}" for column in columns)
        lines.append(f"| {part.replace('_', ' ')} | {shown} |")
    before, _, after = PAGE.read_text(encoding="utf-8").partition(HEAD)
    rest = after.split("\n\n", 1)[1]
    PAGE.write_text(before + "\n".join(lines) + "\n\n" + rest, encoding="utf-8")


def _flat(one: Found) -> float:
    return one.flat


def _hardest(one: Found) -> float:
    return max(one.nearly.values())


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure what is asked for and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--parts", nargs="+", default=PARTS)
    parser.add_argument("--ways", nargs="+", default=WAYS, choices=WAYS)
    parser.add_argument("--vertices", type=int, default=12_000)
    parser.add_argument("--material", default="PLA")
    parser.add_argument("--device", default="auto")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--read", type=Path, nargs="+", help="figures that were measured before; nothing is measured")
    parser.add_argument("--page", action="store_true", help="put the table into the docs as well")
    options = parser.parse_args(arguments)
    os.environ |= {"MECHSTYLE_THREADS": "1", "OMP_NUM_THREADS": "1"}
    measured = [one for path in options.read or () for one in msgspec.json.decode(path.read_bytes(), type=list[Found])]
    asked = [] if options.read else [(part, way) for part in options.parts for way in options.ways]
    with ProcessPoolExecutor(options.jobs, mp_context=multiprocessing.get_context("spawn"), max_tasks_per_child=1) as pool:
        waiting = [pool.submit(found, part, way, options.vertices, options.material, options.device) for part, way in asked]
        for job in as_completed(waiting):
            one = job.result()
            measured.append(one)
            outcome = one.failure or f"flat {one.flat:.1f}, nearly flat {max(one.nearly.values()):.1f} MPa, {one.seconds:.0f} CPU s"
            print(f"{one.part}, {one.way}: {outcome}", file=sys.stderr, flush=True)
            if options.json is not None:
                options.json.write_bytes(msgspec.json.format(msgspec.json.encode(measured)))
    order = {way: number for number, way in enumerate(WAYS)}
    parts = list(dict.fromkeys([*options.parts, *(one.part for one in measured)]))
    measured.sort(key=lambda one: (parts.index(one.part), order[one.way]))
    print("\n".join(table(measured)))
    if options.page:
        on_the_page(measured)
    return 1 if any(one.failure for one in measured) else 0


if __name__ == "__main__":
    sys.exit(main())
