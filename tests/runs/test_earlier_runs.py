"""A run directory written by an earlier version opens, tells the same and goes on; the same inputs give the same arrays today.

`data/earlier_run.zip` is a lane on a sheet with a branch at iteration 6, both finished, written before the modules were moved into rooms.
"""

import zipfile
from pathlib import Path

import pytest

from mechstyle.runs.run import Run
from mechstyle.simulation.part import Origin
from support.bench import Bench
from support.lanes import lane_on_a_sheet

EARLIER = Path(__file__).parent / "data" / "earlier_run.zip"


@pytest.fixture
def earlier(tmp_path) -> Path:
    """The directory, unpacked."""
    with zipfile.ZipFile(EARLIER) as packed:
        packed.extractall(tmp_path / "earlier")
    return tmp_path / "earlier"


def arrays_of(run: Run) -> set[str]:
    """Names of the stored arrays, which are the digests of their contents; records name the settings of their version."""
    objects = run.store.objects
    names = {path.parent.name + path.name for path in objects.root.rglob("*") if path.is_file()}
    return {name for name in names if objects.get(name).startswith(b"\x93NUMPY")}


def test_it_opens_with_its_lanes_verdict_and_summary(earlier):
    run, soft = Run.open(earlier), Run.open(f"{earlier}@soft")
    assert run.store.lanes() == ("main", "soft")
    assert (run.recipe.threshold, soft.recipe.control) == (0.5, "linear")
    assert run.finished
    assert run.verdict.outcome == run.summary.verdict == "VIABLE"
    assert run.summary.peak_stress == pytest.approx(run.verdict.as_placed.value)
    assert run.record.origin == Origin(model="gallery:pen_holder", vertices=4000)
    assert soft.history[6].digest == run.history[6].digest
    assert len(run.surface(7).vertices) == 64
    assert run.simulation().stress.shape == (64,)


def test_it_can_be_shown_reported_and_branched(earlier, tmp_path):
    run = Run.open(earlier)
    assert run.show(4).png.startswith(b"\x89PNG")
    assert "mechstyle run gallery:pen_holder" in run.report(tmp_path / "report.html").read_text(encoding="utf-8")
    branch = run.branch(3, lane="later", threshold=0.8)
    for _ in Bench(earlier, gain=200.0).engine(branch.recipe, "later").run():
        pass
    assert Run.open(f"{earlier}@later").history[-1].final


def test_the_same_inputs_give_the_same_arrays_today(earlier, tmp_path):
    origin = Origin(model="gallery:pen_holder", vertices=4000)
    run = lane_on_a_sheet(tmp_path / "today", origin=origin, iterations=12, every=4, gain=200.0, threshold=0.5)
    branch = run.branch(6, lane="soft", control="linear")
    for _ in Bench(run.store.root, gain=200.0).engine(branch.recipe, "soft").run():
        pass
    arrays = arrays_of(run)
    assert len(arrays) > 20
    assert arrays == arrays_of(Run.open(earlier))
    assert (run.store.root / "part.json").read_bytes() == (earlier / "part.json").read_bytes()
