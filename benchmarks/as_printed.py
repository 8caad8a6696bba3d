"""What stays bent of gallery parts, solid and as printed with 3 walls and 15 % gyroid, plain and in brick.

Some minutes of a core for each part. Keeps what was measured in docs/as-printed.json.

python benchmarks/as_printed.py                      # all thirty parts, plain and in brick
python benchmarks/as_printed.py --plain coaster vase # some of them, plain alone
python benchmarks/as_printed.py --page               # write the table of docs/printing.md anew from what is kept
"""

from __future__ import annotations

import argparse
import re
import time
from collections.abc import Iterable
from pathlib import Path

import msgspec
import numpy as np
from sheets import Specimen

import mechstyle as ms
from mechstyle.fea.drop import resolve_device
from mechstyle.gallery import names
from mechstyle.loop.bounds import unrestrained_relief
from mechstyle.records import Simulation
from mechstyle.runs.recipes import recipe_for
from mechstyle.simulation.part import Workpiece, bounds_for, cached_memo, fitted, prepare
from mechstyle.simulation.simulator import DropSimulator
from mechstyle.styling.prompt import read

DOCS = Path(__file__).parent.parent / "docs"
KEPT, PAGE = DOCS / "as-printed.json", DOCS / "printing.md"
VERTICES, BRICK = 3000, "brick"
PRINTS = {"solid": {}, "printed": {"infill": "15 %"}}


class Measured(msgspec.Struct):
    """A part in all landings.

    Attributes:
        mass: As printed [g].
        flat: What stays bent flat [mm].
        tilted: The worst of the landings that are nearly flat [mm].
        strain: The largest plastic strain in tension of all.
        outcome: Of the part by itself.
        seconds: CPU time of its drops [s].
    """

    mass: float
    flat: float
    tilted: float
    strain: float
    outcome: str
    seconds: float


def measured(part: Workpiece, prompt: str, printed: dict[str, str], device: str) -> Measured:
    """Drop a part, plain for no prompt, else with its free relief."""
    recipe = fitted(recipe_for(prompt or BRICK, freestyle=True, **printed), part)
    memo, began = cached_memo(), time.process_time()
    simulator = DropSimulator(part, recipe, memo, memo, resolve_device(device))
    simulation = simulator.simulate(relief(part, prompt) if prompt else np.zeros(len(part.surface.vertices), np.float32), thorough=True)
    return figures(simulation, simulator, time.process_time() - began)


def figures(simulation: Simulation, simulator: DropSimulator, seconds: float) -> Measured:
    """The figures of a test."""
    density = simulator.recipe.test.material.density
    return Measured(
        mass=density * simulation.volume * simulation.plastic_share, flat=simulation.landings[0].permanent_set,
        tilted=max(one.permanent_set for one in simulation.landed("nearly flat")),
        strain=max(one.plastic_strain for one in simulation.landings),
        outcome=simulator.judge(simulation, alone=True).outcome, seconds=seconds,
    )  # fmt: skip


def relief(part: Workpiece, prompt: str) -> np.ndarray:
    """The free relief of a style on a part [mm], shape [vertex_count]."""
    plain = part.surface
    styled, _ = Specimen(plain, part.thickness.astype(np.float64)).styled(read(prompt).wishes[0])
    asked = np.einsum("ij,ij->i", styled.vertices - plain.vertices, plain.vertex_normals).astype(np.float32)
    recipe = recipe_for(prompt, freestyle=True)
    return np.asarray(unrestrained_relief(asked, bounds_for(part, recipe)[0], recipe), np.float32)


Kept = dict[str, dict[str, Measured]]


def kept() -> Kept:
    """What was measured, by part and print."""
    return msgspec.json.decode(KEPT.read_bytes(), type=Kept) if KEPT.is_file() else {}


def table(found: Kept) -> Iterable[str]:
    """The lines of the table."""
    yield "| part | mass, solid → printed | flat | 3° off flat | in brick, 3° off flat |"
    yield "|---|---|---|---|---|"
    for part, of in sorted(found.items()):

        def cell(name: str, prefix: str = "", of: dict[str, Measured] = of) -> str:
            both = [of.get(f"{prefix}{kind}") for kind in PRINTS]
            if None in both:
                return "–"
            figures = (f"{getattr(one, name):.{1 if name == 'mass' else 2}f}" for one in both if one)
            return f"{' → '.join(figures)} {'g' if name == 'mass' else 'mm'}"

        yield f"| {part.replace('_', ' ')} | {cell('mass')} | {cell('flat')} | {cell('tilted')} | {cell('tilted', BRICK + ' ')} |"


def main() -> None:
    """Measure the parts asked for, or write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", choices=[*names(), []])
    parser.add_argument("--plain", action="store_true", help="without brick")
    parser.add_argument("--device", default="cpu")
    parser.add_argument("--page", action="store_true", help="write the table of the page")
    asked = parser.parse_args()
    if asked.page:
        text, rows = PAGE.read_text(encoding="utf-8"), "\n".join(table(kept()))
        PAGE.write_text(re.sub(r"\| part \|.*?\n\n", lambda _: f"{rows}\n\n", text, flags=re.DOTALL), encoding="utf-8")
        return
    for name in asked.parts or names():
        part = prepare(ms.load(f"gallery:{name}"), vertices=VERTICES)
        for prompt in ("",) if asked.plain else ("", BRICK):
            for kind, printed in PRINTS.items():
                found = measured(part, prompt, printed, asked.device)
                print(name, prompt or "plain", kind, found, flush=True)
                known = kept()  # others may run at the same time
                known.setdefault(name, {})[f"{prompt} {kind}".strip()] = found
                KEPT.write_bytes(msgspec.json.format(msgspec.json.encode(dict(sorted(known.items()))), indent=1))


if __name__ == "__main__":
    main()
