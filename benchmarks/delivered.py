"""A delivered file simulated again with `--original`: does it come to the outcome of its run?

Each part is stylized, written as 3MF, read again and simulated beside its original, in a process of its own with one thread. Prints a
table: outcome and what stays bent flat and at worst, of the run and of the file. A cell that was measured before is read from --json.

python benchmarks/delivered.py --jobs 16 --json delivered.json                   # eight parts, 2000 to 25 000 vertices
python benchmarks/delivered.py --cells utensil_grip:2000 s_hook:3000 --style cactus
python benchmarks/delivered.py --read delivered-*.json                           # the table alone, of what was measured before
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from statistics import median

import msgspec

CELLS = (
    "pen_holder:25000", "phone_stand:12000", "wall_hook:12000", "pill_box:6000", "tealight_holder:6000", "drawer_knob:3000", "s_hook:3000",
    "utensil_grip:2000",
)  # fmt: skip
"""Parts with their vertices, those that take longest first."""


class Told(msgspec.Struct, frozen=True):
    """Outcome of a simulation, whether it is sure, and what stays bent in each test [mm]."""

    outcome: str = ""
    sure: bool = False
    bent: dict[str, float] = {}


class Found(msgspec.Struct, frozen=True, kw_only=True):
    """A run and its file.

    Attributes:
        cell: Part and vertices, a colon between.
        style: The prompt.
        run, file: What each of the two came to.
        kept: Share of the style that the run kept.
        seconds: CPU seconds of both.
        failure: Why there are no figures, "" if there are.
    """

    cell: str
    style: str
    run: Told = Told()
    file: Told = Told()
    kept: float = 0.0
    seconds: float = 0.0
    failure: str = ""


def found(cell: str, style: str, device: str) -> Found:
    """A run and its file, simulated again."""
    from mechstyle import gallery  # noqa: PLC0415 — in processes of their own, after their environment is set
    from mechstyle.errors import MechStyleError  # noqa: PLC0415
    from mechstyle.runs.run import stylize  # noqa: PLC0415
    from mechstyle.simulation.part_test import simulate  # noqa: PLC0415

    (part, vertices), began = cell.split(":"), time.process_time()
    plain = gallery.load(f"{gallery.PREFIX}{part}")
    with tempfile.TemporaryDirectory() as folder:
        try:
            run = stylize(plain, style, vertices=int(vertices), out=Path(folder) / "run", name=part, device=device)
            file = run.export(Path(folder) / f"{part}.3mf")
            again = simulate(gallery.load(str(file)), original=plain, vertices=int(vertices), device=device)
        except MechStyleError as error:
            return Found(cell=cell, style=style, failure=str(error))
        spent = time.process_time() - began
        return Found(cell=cell, style=style, run=told(run.verdict), file=told(again.verdict), kept=run.summary.kept, seconds=spent)


def told(verdict):  # noqa: ANN001, ANN201 — a Verdict, whose module is imported in the processes that use it
    """What a verdict comes to."""
    return Told(verdict.outcome, verdict.sure, {row.load or row.landing: row.permanent_set for row in verdict.rows})


def table(all_found: Sequence[Found]) -> Iterator[str]:
    """Runs beside their files, as Markdown."""
    yield "| part | vertices | kept | run | its file | same | flat: run [mm] | file | at worst: run [mm] | file |"
    yield "|---" * 10 + "|"
    for one in all_found:
        part, vertices = one.cell.split(":")
        if one.failure:
            yield f"| {part} | {vertices} | {one.failure} |" + " – |" * 7
            continue
        bent = (of(told.bent) for of in (_flat, _worst) for told in (one.run, one.file))
        outcomes = (f"{told.outcome}{'' if told.sure else ' (not sure)'}" for told in (one.run, one.file))
        cells = (part, vertices, f"{one.kept:.2f}", *outcomes, "yes" if one.run.outcome == one.file.outcome else "**no**")
        yield f"| {' | '.join((*cells, *('–' if value is None else f'{value:.3f}' for value in bent)))} |"
    same = sum(one.run.outcome == one.file.outcome for one in all_found if not one.failure)
    yield f"\n{same} of {len(all_found)} have the same outcome."


def _flat(bent: dict[str, float]) -> float | None:
    return next(iter(bent.values()), None)


def _worst(bent: dict[str, float]) -> float | None:
    return max(bent.values(), default=None)


def differences(all_found: Sequence[Found]) -> Iterator[str]:
    """How far what stays bent of files is from that of their runs, and how many doubts only one of the two leaves."""
    pairs = [(one.run, one.file) for one in all_found if not one.failure]
    apart = sorted(abs(file.bent[test] - run.bent[test]) for run, file in pairs for test in run.bent if test in file.bent)
    if apart:
        yield f"What stays bent differs by {median(apart):.3f} mm in the median and by {apart[-1]:.3f} mm at most."
    yield f"{sum(run.sure and not file.sure for run, file in pairs)} are sure in the run and not in the file."


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure what is asked for and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cells", nargs="+", default=CELLS, help="parts and vertices, such as s_hook:3000")
    parser.add_argument("--style", default="brick")
    parser.add_argument("--device", default="auto")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--read", type=Path, nargs="+", help="figures that were measured before; nothing is measured")
    options = parser.parse_args(arguments)
    if options.read:
        measured = [one for path in options.read for one in msgspec.json.decode(path.read_bytes(), type=list[Found])]
        print("\n".join(table(sorted(measured, key=lambda one: (one.style, one.cell)))))
        print("\n".join(differences(measured)))
        return 0
    os.environ |= {"MECHSTYLE_THREADS": "1", "OMP_NUM_THREADS": "1"}
    kept = options.json.read_bytes() if options.json is not None and options.json.is_file() else b"[]"
    known = {(one.cell, one.style): one for one in msgspec.json.decode(kept, type=list[Found]) if not one.failure}
    missing = [cell for cell in options.cells if (cell, options.style) not in known]
    with ProcessPoolExecutor(options.jobs, mp_context=multiprocessing.get_context("spawn"), max_tasks_per_child=1) as pool:
        for job in as_completed([pool.submit(found, cell, options.style, options.device) for cell in missing]):
            one = job.result()
            known[one.cell, one.style] = one
            outcomes = one.failure or f"{one.run.outcome}, {one.file.outcome}, {one.seconds:.0f} CPU s"
            print(f"{one.cell}: {outcomes}", file=sys.stderr, flush=True)
            if options.json is not None:
                options.json.write_bytes(msgspec.json.format(msgspec.json.encode(list(known.values()))))
    measured = [known[cell, options.style] for cell in options.cells]
    print("\n".join(table(measured)))
    return 1 if any(one.failure or one.run.outcome != one.file.outcome for one in measured) else 0


if __name__ == "__main__":
    sys.exit(main())
