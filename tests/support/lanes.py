"""Lanes of real run directories, made by the real engine on a sheet whose stress is a known function of the relief."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np

from mechstyle._files import write_whole
from mechstyle.records.mesh import TetMesh
from mechstyle.runs.folders import PartRecord
from mechstyle.runs.run import Run
from mechstyle.runs.summary import summarise
from mechstyle.simulation.part import Origin
from support.bench import Bench

CORNER = TetMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2, 3]])


def lane_on_a_sheet(  # one call, all keywords
    root: Path, *, name: str = "sheet", origin: Origin | None = None, gain: float = 50.0, side: int = 8, **settings: object
) -> Run:
    """A finished lane in `root`, of `side`² vertices; stress = 20 MPa + gain · |relief|."""
    bench = Bench(root, gain=gain, side=side)
    engine = bench.engine(bench.recipe(**{"prompt": "brick", "schedule": "every", "every": 10, **settings}))
    for _ in engine.run():
        pass
    objects = engine.store.objects
    record = PartRecord(
        name=name, surface=objects.put_mesh(bench.surface), tets=objects.put_mesh(CORNER),
        thickness=objects.put_array(np.full(side * side, 4.0, np.float32)), stands=True, notes=(), origin=origin or Origin(),
    )  # fmt: skip
    write_whole(root / "part.json", msgspec.json.encode(record))
    run = Run(engine.store, "main", "cpu")
    run._save(summarise(engine, device="cpu", notes=("a note on the part",), seconds={}, files={}))
    return run


def carry_on(run: Run) -> None:
    """Carry a lane on a sheet on to its end."""
    for _ in Bench(run.store.root).engine(run.recipe, run.lane).run():
        pass
