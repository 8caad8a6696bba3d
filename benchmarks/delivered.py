"""Processor seconds that delivering the finer surface takes after a run's last iteration, less those of its own: a report, not a test.

What `mechstyle run` does between its last iteration and its end, without any drop: the part is cut smaller, the style drawn again and led
through the run, the file written with what is known of it, and the picture drawn. Stress is a known function of the relief meanwhile.

    python benchmarks/delivered.py [MODEL] [--prompt brick] [--vertices 25000]
"""

from __future__ import annotations

import argparse
import hashlib
import resource
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from mechstyle.gallery import make
from mechstyle.geometry.thickness import local_thickness
from mechstyle.loop.engine import Engine
from mechstyle.records.mesh import STANDARD_VERTICES, TetMesh
from mechstyle.runs import export
from mechstyle.runs.recipes import plan
from mechstyle.runs.refine import Refinement
from mechstyle.runs.run import Run, begin
from mechstyle.runs.stylizers import stylizer_for
from mechstyle.simulation.part import Workpiece, bounds_for, standardised

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from support.bench import LeverSimulator

ONE_TET = TetMesh(np.vstack([np.zeros(3), 10.0 * np.eye(3)]), [[0, 1, 2, 3]])
"""Nothing is dropped, so that these need not fill the part."""


def finished(model: str, prompt: str, vertices: int, folder: Path) -> Run:
    """A run that has ended, with what it knows of its part and style still at hand."""
    surface = standardised(make(model), vertices)
    part = Workpiece(surface, ONE_TET, local_thickness(surface).astype(np.float32), stands=True)
    recipe = plan(part, prompt, schedule="never")
    run = begin(part, recipe, folder, name=model, device="cpu")
    stylizer, _ = stylizer_for(run.part, recipe, objects=run.store.objects)
    simulator = LeverSimulator(len(surface.vertices), recipe, gain=1.0)
    for _ in Engine(recipe, surface, bounds_for(run.part, recipe)[0], stylizer, simulator, run.store, "main").run():
        pass
    return run


def seconds(what: str, work: Callable[[], object]) -> float:
    """Processor seconds of some work, told."""
    before = time.process_time()
    work()
    taken = time.process_time() - before
    print(f"{what:40s}{taken:7.2f} s", flush=True)
    return taken


def main() -> None:
    """Print what each part takes, the sum, and digests of what came out."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("model", nargs="?", default="pen_holder")
    parser.add_argument("--prompt", default="brick")
    parser.add_argument("--vertices", type=int, default=STANDARD_VERTICES)
    asked = parser.parse_args()
    # A finer surface without a test of its own is told to have none, instead of being dropped.
    export.drawn_finer = lambda _recipe, _entry: False
    with tempfile.TemporaryDirectory() as folder:
        run = finished(asked.model, asked.prompt, asked.vertices, Path(folder) / "run")
        refinement, entry = Refinement(run.store, run.part, run.simulator(run.recipe)), run.history[-1]
        file, picture, coarse = (Path(folder) / name for name in ("part.3mf", "part.png", "coarse.3mf"))
        own, _ = run.surface(), run.show(0)  # kernels and fonts are loaded for either
        run.exported(coarse, fine=False)
        less = seconds("its own surface: file", lambda: run.exported(coarse, fine=False)) + seconds("… picture", lambda: run.show(0))
        taken = seconds("cut smaller, drawn, led through the run", lambda: refinement.of(entry.digest, drop=False))
        taken += seconds("file, walls and crossing faces", lambda: run.exported(file))
        taken += seconds("picture", lambda: run.show().save(picture))
        found = refinement.of(entry.digest, drop=False)
        digests = [hashlib.sha256(path.read_bytes()).hexdigest()[:12] for path in (file, picture)]
        print(f"{len(own.vertices)} vertices, {len(found.styled.vertices)} delivered: {taken - less:.1f} s more")
    print(f"surface {found.styled.digest[:12]}, file {digests[0]}, picture {digests[1]}")
    print(f"at most {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MB")


if __name__ == "__main__":
    main()
