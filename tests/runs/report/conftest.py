"""Lanes of real run directories, made by the real engine on a sheet whose stress is a known function of the relief."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import msgspec
import numpy as np
import pytest

from mechstyle.records.mesh import TetMesh
from mechstyle.runs.run import PartRecord, Run
from mechstyle.runs.summary import summarise
from mechstyle.simulation.part import Origin

_SPEC = importlib.util.spec_from_file_location("loop_bench", Path(__file__).parents[1] / "loop" / "conftest.py")
assert _SPEC is not None
assert _SPEC.loader is not None
loop_bench = importlib.util.module_from_spec(_SPEC)
sys.modules["loop_bench"] = loop_bench  # its dataclasses look themselves up there
_SPEC.loader.exec_module(loop_bench)

CORNER = TetMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2, 3]])


def lane_on_a_sheet(root: Path, *, name: str = "sheet", origin: Origin | None = None, gain: float = 50.0, **settings: object) -> Run:
    """A finished lane in `root`; stress = 20 MPa + gain · |relief|."""
    bench = loop_bench.Bench(root, gain=gain)
    engine = bench.engine(bench.recipe(**{"prompt": "brick", "schedule": "every", "every": 10, **settings}))
    for _ in engine.run():
        pass
    objects = engine.store.objects
    record = PartRecord(
        name=name, surface=objects.put_mesh(bench.surface), tets=objects.put_mesh(CORNER),
        thickness=objects.put_array(np.full(64, 4.0, np.float32)), stands=True, notes=(), origin=origin or Origin(),
    )  # fmt: skip
    (root / "part.json").write_bytes(msgspec.json.encode(record))
    run = Run(engine.store, "main", "cpu")
    run._save(summarise(engine, device="cpu", notes=("a note on the part",), seconds={}, files={}))
    return run


def carry_on(run: Run) -> None:
    """Carry a lane on a sheet on to its end."""
    for _ in loop_bench.Bench(run.store.root).engine(run.recipe, run.lane).run():
        pass


@pytest.fixture
def sheet(tmp_path):
    """Makes a lane: name, origin, gain and any setting of the recipe may be given."""
    return lambda **settings: lane_on_a_sheet(tmp_path / "run", **settings)


@pytest.fixture(scope="session")
def lane(tmp_path_factory) -> Run:
    """One lane for the tests that only look at it."""
    return lane_on_a_sheet(tmp_path_factory.mktemp("lanes") / "run", origin=Origin(model="gallery:pen_holder"))
