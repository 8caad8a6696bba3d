"""Where the time and memory of a run go, stage by stage: one JSON file a run, and the table of several.

A run is made from an empty cache, and the functions that its stages consist of are timed from outside: by the clock, and on the processor
with the child processes that have ended. A stage within another counts for itself alone. Memory is the most that this process, and any
one child, had by the end of a stage.

    python benchmarks/profile_stages.py gallery:pen_holder --vertices 12000 --json FILE [--prompt brick] [--set NAME=VALUE]
    python benchmarks/profile_stages.py --table FILE FILE …
"""

from __future__ import annotations

import argparse
import functools
import json
import os
import resource
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from mechstyle import gallery
from mechstyle.cli.run import finish
from mechstyle.fea.drop import resolve_device
from mechstyle.loop.engine import Engine, Event, Simulated
from mechstyle.records.mesh import STANDARD_VERTICES
from mechstyle.runs import run as runs
from mechstyle.runs import stylizers
from mechstyle.runs.recipes import recipe_for, typed
from mechstyle.simulation import meshes, part, simulator
from mechstyle.simulation.estimate import estimated
from mechstyle.styling.drawn import ProceduralStylizer

LEAST = 0.005
"""Share of the processor time below which a stage is left out of the table."""


class Profile:
    """Seconds of nested stages, each without those inside it.

    Attributes:
        stages: By name: how often, seconds by the clock and on the processor, memory [GB], and what is known of each time.
    """

    def __init__(self) -> None:
        self.stages: dict[str, dict[str, Any]] = {}
        self._inner: list[list[float]] = []

    @contextmanager
    def stage(self, name: str) -> Iterator[dict[str, Any]]:
        """Time a block; what it puts into the dictionary is kept."""
        begun, before, here = time.perf_counter(), on_processor(), dict[str, Any]()
        self._inner.append([0.0, 0.0])
        try:
            yield here
        finally:
            taken = time.perf_counter() - begun, on_processor() - before
            inside = self._inner.pop()
            total = self.stages.setdefault(name, {"times": 0, "clock": 0.0, "cpu": 0.0, "each": []})
            for which, (key, seconds) in enumerate(zip(("clock", "cpu"), taken, strict=True)):
                total[key] += seconds - inside[which]
                if self._inner:
                    self._inner[-1][which] += seconds
            total |= {"times": total["times"] + 1, "own_GB": most_memory()[0], "child_GB": most_memory()[1]}
            if here:
                total["each"].append({**here, "clock": taken[0], "cpu": taken[1]})

    def watch(self, holder: Any, name: str, stage: str, about: Callable[..., dict[str, Any]] | None = None) -> None:
        """Time a function where its callers find it; `about` says what is known of a call, from its result and arguments."""
        function = getattr(holder, name)

        @functools.wraps(function)
        def timed(*given: Any, **named: Any) -> Any:
            with self.stage(stage) as here:
                result = function(*given, **named)
                here.update({} if about is None else about(result, *given, **named))
            return result

        setattr(holder, name, timed)


def on_processor() -> float:
    """Seconds on the processor, with those of child processes that have ended."""
    return sum(os.times()[:4])


def most_memory() -> tuple[float, float]:
    """The most that this process and any one child had [GB]."""
    own, child = (resource.getrusage(who).ru_maxrss / 1e6 for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return own, child


def watched(profile: Profile) -> None:
    """Put the stages of a run under watch."""

    def filled(tets: Any, *_: Any, **__: Any) -> dict[str, Any]:
        return {"tetrahedra": len(tets.tets)}

    def dropped(found: Any, tets: Any, _material: Any, normals: Any, test: Any, **_: Any) -> dict[str, Any]:
        simulated = [round(sum(phase.end - phase.start for phase in phases), 3) for phases in found.phases]
        where = {"drops": len(normals), "height": round(test.height), "tetrahedra": len(tets.tets)}
        return {**where, "steps": found.steps, "step_ns": 1e6 * found.time_step, "ms": simulated, "failure": found.failure}

    profile.watch(part, "standardise", "evening", lambda surface, *_, **__: {"vertices": len(surface.vertices)})
    profile.watch(part, "local_thickness", "walls")
    profile.watch(part, "mesh_for_relief", "meshing of the styled and, meanwhile, the plain part", lambda found, *_, **__: filled(found[0]))
    profile.watch(meshes, "mesh_for_relief", "meshing again", lambda found, *_, **__: filled(found[0]))
    profile.watch(stylizers, "drawing_of", "style: drawing")
    profile.watch(ProceduralStylizer, "step", "style: iterations")
    profile.watch(Engine, "_moved", "style: iterations")
    profile.watch(Engine, "_save", "checkpoints")
    profile.watch(Engine, "_target", "style: what nothing restrains")
    profile.watch(runs, "picture", "pictures")
    profile.watch(runs, "untangled", "style: untangling")
    profile.watch(simulator, "drop", "drops", dropped)
    profile.watch(simulator, "period_of", "lowest period")
    profile.watch(simulator.DropSimulator, "_brought", "reading of stress")
    profile.watch(runs.Run, "exported", "delivery")
    profile.watch(runs.Run, "show", "pictures")


class Teller:
    """Says on stderr what a run does.

    Attributes:
        begun: When the first fall was about to begin [s].
        first: How long it was from there until the style had been tested once [s], None before.
        said: Notes of the part and its file.
    """

    begun = 0.0
    first: float | None = None

    def __init__(self) -> None:
        self.said: set[str] = set()

    def say(self, notes: Iterable[str]) -> None:
        """Notes of the part."""
        self.said.update(notes)

    def stage(self, what: str) -> None:
        """What begins."""
        print(f"… {what}", file=sys.stderr, flush=True)

    def event(self, event: Event) -> None:
        """What a test found."""
        if isinstance(event, Simulated):
            self.first = self.first or time.perf_counter() - self.begun
            print(f"  {event.reason}: {len(event.simulation.landings)} landings; {event.verdict.words}", file=sys.stderr, flush=True)

    def fraction(self, done: float) -> None:
        """How far a drop is, which nobody asks for here."""


def profiled(given: argparse.Namespace, folder: str) -> dict[str, Any]:
    """One run from an empty cache."""
    profile, teller, begun, loading = Profile(), Teller(), time.perf_counter(), on_processor()
    profile.stages["loading the program"] = {"times": 1, "clock": loading, "cpu": loading}
    os.environ["MECHSTYLE_CACHE"] = str(Path(folder, "cache"))
    watched(profile)
    with profile.stage("the rest"):
        with profile.stage("reading"):
            mesh = gallery.load(given.model)
        wanted = recipe_for(given.prompt, **dict(typed(text) for text in given.set))
        device, out = resolve_device(given.device), Path(folder, "run")
        run = runs.Draft(wanted, mesh, given.vertices, folder=out, device=device).ready(stage=teller.stage).begin()
        foreseen = estimated(wanted, given.vertices).seconds if device == "cpu" else None
        teller.begun = time.perf_counter()
        finish(run, teller)
    return {
        "model": given.model, "prompt": given.prompt, "vertices": given.vertices, "set": given.set, "device": device,
        "clock": loading + time.perf_counter() - begun, "cpu": on_processor(), "memory_GB": most_memory(),
        "outcome": run.verdict.outcome,
        "sure": run.verdict.sure, "verdict": run.verdict.words, "tests": len(run.summary.simulations),
        "foreseen": foreseen, "first_tests": teller.first, "vertices_made": len(run.part.surface.vertices),
        "kept": run.summary.kept, "stages": profile.stages,
    }  # fmt: skip


def table(profiles: Sequence[dict[str, Any]]) -> str:
    """Seconds on the processor by stage, a column for each run, in the order of the first run."""
    names = sorted({name for one in profiles for name in one["stages"]}, key=lambda name: -max(cpu_of(one, name) for one in profiles))
    names = [name for name in names if any(cpu_of(one, name) > LEAST * one["cpu"] for one in profiles)]
    heads = [f"{one['model'].removeprefix('gallery:').replace('_', ' ')}, {one['vertices']}" for one in profiles]
    lines = ["| stage | " + " | ".join(heads) + " |", "|---|" + "---|" * len(profiles)]
    lines += [f"| {name} | " + " | ".join(f"{cpu_of(one, name):.1f}" for one in profiles) + " |" for name in names]
    lines.append("| **all** | " + " | ".join(f"**{one['cpu']:.0f}**" for one in profiles) + " |")
    lines.append("| by the clock | " + " | ".join(f"{one['clock']:.0f}" for one in profiles) + " |")
    known = [one for one in profiles if one["foreseen"]]
    if len(known) == len(profiles):
        times = " | ".join(foreseen_and_taken(one) for one in known)
        lines.append(f"| foreseen, and taken, by the clock | {times} |")
    memory = ["{:.2f}, {:.2f}".format(*one["memory_GB"]) for one in profiles]
    lines.append("| most memory, own and of a child [GB] | " + " | ".join(memory) + " |")
    return "\n".join(lines)


def foreseen_and_taken(profile: dict[str, Any]) -> str:
    """The estimate of the run, and what it took [s]."""
    return f"{profile['foreseen']:.0f}, {profile['clock']:.0f}"


def cpu_of(profile: dict[str, Any], name: str) -> float:
    """Seconds of a stage on the processor, 0 where there was none."""
    return float(profile["stages"].get(name, {}).get("cpu", 0.0))


def main() -> None:
    """Profile one run, or print the table of several."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("model", nargs="?", default="gallery:pen_holder")
    parser.add_argument("--prompt", default="brick")
    parser.add_argument("--vertices", type=int, default=STANDARD_VERTICES)
    parser.add_argument("--device", default="cpu")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE")
    parser.add_argument("--json", type=Path, help="where the figures go")
    parser.add_argument("--table", type=Path, nargs="+", help="files whose table is printed")
    given = parser.parse_args()
    if given.table:
        print(table([json.loads(file.read_text()) for file in given.table]))
        return
    with tempfile.TemporaryDirectory() as folder:
        found = profiled(given, folder)
    if given.json:
        given.json.write_text(json.dumps(found, indent=1))
    print(table([found]), found["verdict"], f"kept {found['kept']:.3f}", sep="\n")


if __name__ == "__main__":
    main()
