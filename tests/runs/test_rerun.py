"""A run done again from its own folder, on a machine that remembers nothing of it."""

import contextlib
import os
import subprocess
import sys

import msgspec
import pytest

from mechstyle.cli.finished import rerun_command
from mechstyle.errors import BadInput
from mechstyle.loop.garbage import collect
from mechstyle.loop.store import Lane, Store
from mechstyle.runs.rerun import CLOSE, compared, rerun
from mechstyle.runs.run import Run
from support import ROOT
from support.kills import on_a_block
from support.lanes import lane_on_a_sheet
from support.records import UNKNOWN, row
from support.records import verdict as judged


@pytest.fixture(scope="module")
def block(tmp_path_factory):
    """A small real run with a relief, on tetrahedra made for it, and a branch of it."""
    run = on_a_block(tmp_path_factory.mktemp("block") / "run")
    run.branch(4, lane="soft", threshold=0.5).go()
    return run


@pytest.fixture
def elsewhere(tmp_path, monkeypatch):
    """A cache that holds nothing, as on another machine."""
    monkeypatch.setenv("MECHSTYLE_CACHE", str(tmp_path / "empty cache"))


def no_meshing(*_args, **_options):
    pytest.fail("fTetWild gives another mesh every time: a run folder must hold all of its tetrahedra")


@pytest.mark.slow
@pytest.mark.parametrize("lane", ["main", "soft"])
def test_a_run_repeats_to_the_same_bytes_where_nothing_is_remembered(block, elsewhere, monkeypatch, tmp_path, lane):
    monkeypatch.setattr("mechstyle.geometry.remeshing.filling.tetwild", no_meshing)
    found = rerun(Run(block.store, lane), tmp_path / "again")
    assert found.same_bytes
    assert found.equal
    assert found.drops >= 3
    assert "equal: every iteration" in found.words
    assert Run(block.store, lane).history[-1].digest == Run.open(tmp_path / "again", "cpu").history[-1].digest


@pytest.mark.slow
def test_gc_takes_nothing_from_a_run_that_is_being_repeated(block, elsewhere, monkeypatch, tmp_path):
    """The recipe of a branch is stored before the lane is moved to it."""
    move = Store.move

    def swept(store, *lane):
        with contextlib.suppress(BadInput):
            collect(Store(store.root))
        move(store, *lane)

    monkeypatch.setattr(Store, "move", swept)
    assert rerun(Run(block.store, "soft"), tmp_path / "again").same_bytes


@pytest.mark.slow
def test_a_run_that_goes_on_on_another_machine_keeps_the_tetrahedra_it_was_compared_on(block, elsewhere, monkeypatch):
    """The unstylized part has tetrahedra of its own: they were in the cache of one machine only, and peaks moved by some percent."""
    monkeypatch.setattr("mechstyle.geometry.remeshing.filling.tetwild", no_meshing)
    run = Run(block.store, "main")
    simulator = run.simulator(run.recipe)
    again = simulator.simulate(simulator.part.surface.vertices[:, 0].astype("f4") * 0, thorough=True)
    assert again.landings == run.simulation(0).landings


SCRIPT = """
import os, sys
os.sched_setaffinity(0, set(sorted(os.sched_getaffinity(0))[:int(sys.argv[3])]))
from pathlib import Path
from mechstyle.runs.rerun import rerun
from mechstyle.runs.run import Run
found = rerun(Run.open(sys.argv[1], "cpu"), Path(sys.argv[2]))
print(found.same_bytes, found.equal, found.words)
"""


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="this system gives a process no cores")
@pytest.mark.parametrize("cores", [1, 2])
def test_the_number_of_cores_does_not_matter(block, tmp_path, cores):
    environment = {**os.environ, "OMP_NUM_THREADS": str(cores), "PYTHONPATH": str(ROOT), "MECHSTYLE_CACHE": str(tmp_path / "cache")}
    command = [sys.executable, "-c", SCRIPT, str(block.store.root), str(tmp_path / "again"), str(cores)]
    said = subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout
    assert said.startswith("True True equal")


def test_where_it_differs_is_said():
    class Entry(msgspec.Struct):
        iteration: int
        digest: str
        verdict: object = None

    before = [Entry(0, "a", judged(row(0.1))), Entry(1, "b"), Entry(2, "c", judged(row(0.15)))]
    near = [*before[:2], Entry(2, "d", judged(row(0.15 * (1 + 0.5 * CLOSE))))]
    far = [*before[:2], Entry(2, "d", judged(row(0.15 * (1 + 2 * CLOSE))))]
    other = [*before[:2], Entry(2, "d", judged(row(0.15, outcome="FAILS")))]
    broken = [*before[:2], Entry(2, "d", UNKNOWN)]
    short = before[:2]
    assert compared(before, before, "").same_bytes
    assert compared(before, near, "").equal
    assert (compared(before, near, "").same_bytes, compared(before, near, "").first_other) == (False, 2)
    assert "other bytes from iteration 2 on" in compared(before, near, "").words
    assert [one.iteration for one in compared(before, far, "").differences] == [2]
    assert "FAILS, 0.15 mm, instead of HOLDS, 0.15 mm (flat)" in compared(before, other, "").words
    assert compared(before, short, "").first_other == 2
    assert [one.verdict_again for one in compared(before, broken, "").differences] == ["UNKNOWN"]
    assert compared(broken, broken, "").equal, "neither gave an answer"
    assert not compared(broken, before, "").equal


@pytest.mark.slow
def test_a_forged_figure_is_found_out(block, tmp_path, capsys):
    """A head that claims another bend than its recipe comes to."""
    store = block.store
    head = store.checkpoint(store.lane().head)
    *others, last = head.verdict.rows
    forged = msgspec.structs.replace(head.verdict, rows=(*others, msgspec.structs.replace(last, permanent_set=last.permanent_set + 0.5)))
    forged = store.objects.put_record(
        type(head)(**{**{name: getattr(head, name) for name in head.__dataclass_fields__}, "verdict": forged})
    )
    store.move("forged", Lane(recipe=store.lane().recipe, head=forged))
    with pytest.raises(SystemExit) as left:
        rerun_command(f"{store.root}@forged", tmp_path / "again", device="cpu")
    (store.root / "lanes" / "forged.json").unlink()
    assert left.value.code == 1
    assert "instead of" in capsys.readouterr().out


def test_a_folder_that_is_taken_is_left_alone(tmp_path):
    run = lane_on_a_sheet(tmp_path / "run", iterations=2)
    (tmp_path / "again").mkdir()
    (tmp_path / "again" / "thesis.txt").write_text("years of work")
    with pytest.raises(BadInput, match="is taken"):
        rerun(run, tmp_path / "again")
