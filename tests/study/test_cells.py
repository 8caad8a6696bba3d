"""One cell, one row: what is kept, what is read again, and what becomes of a run that breaks."""

from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.study import cells as module
from benchmarks.study.cells import Cell, Rows, carry_out, figures_of, one_factor
from benchmarks.study.walk import walk
from mechstyle.errors import BadInput
from mechstyle.runs.recipes import recipe_for
from support.lanes import lane_on_a_sheet
from support.records import load_row, row, verdict

RUN = Cell.run


def cell(prompt="brick", **changes):
    return Cell(**{"model": "gallery:wall_hook", "arm": "masks", "recipe": recipe_for(prompt), "vertices": 1000, **changes})


@pytest.fixture
def runs(monkeypatch, tmp_path):
    """Runs without physics, and the cells that asked for them."""
    asked = []

    def run(self, out):
        asked.append(self)
        return lane_on_a_sheet(tmp_path / f"sheet-{len(asked)}", gain=50.0)

    monkeypatch.setattr(Cell, "run", run)
    return asked


def test_a_cell_is_named_by_all_that_decides_it_and_by_nothing_else():
    assert cell().key == cell(device="cpu", arm="other", folder="there").key
    different = [
        cell("stone"),
        cell(vertices=1001),
        cell(model="gallery:vase"),
        cell(recipe=recipe_for("brick", seed=1)),
        cell(one_factor=True),
    ]
    assert len({one.key for one in [cell(), *different, cell(load_share=0.85)]}) == 7


@pytest.mark.parametrize("version", ["PHYSICS_VERSION", "TETRAHEDRA"])
def test_a_study_that_goes_on_with_a_newer_version_does_not_mix_its_rows_with_older_ones(version, monkeypatch):
    before = cell().key
    monkeypatch.setattr(module, version, "of tomorrow")
    assert cell().key != before


def test_what_has_a_row_is_only_read(runs, tmp_path):
    first = carry_out(cell(), tmp_path)
    assert (first.outcome, first.status, first.starts, first.part, first.prompt) == ("HOLDS", "done", 1, "wall_hook", "brick")
    assert carry_out(cell(), tmp_path) == first == Rows(tmp_path).of(cell())
    assert len(runs) == 1


def test_a_row_that_a_killed_writer_broke_is_made_again(runs, tmp_path):
    whole = carry_out(cell(), tmp_path)
    path = Rows(tmp_path).path(cell())
    path.write_bytes(path.read_bytes()[:40])
    assert Rows(tmp_path).all() == []
    again = carry_out(cell(), tmp_path)
    assert again.starts == 2
    assert again.outcome == whole.outcome


def test_what_was_refused_is_tried_again(runs, monkeypatch, tmp_path):
    """A file that was put in its place since went on being told not to exist."""
    missing = cell(model=str(tmp_path / "none.stl"))
    with monkeypatch.context() as unpatched:
        unpatched.setattr(Cell, "run", RUN)
        assert carry_out(missing, tmp_path).status == "refused"
    assert [one.status for one in walk([missing], tmp_path)] == ["done"]
    assert Rows(tmp_path).of(missing).starts == 2


def test_a_run_that_breaks_is_a_row_and_its_traceback_is_kept(monkeypatch, tmp_path):
    def broken(self, out):
        raise ZeroDivisionError("nothing left")

    monkeypatch.setattr(Cell, "run", broken)
    found = carry_out(cell(), tmp_path)
    assert (found.status, found.refused, found.outcome) == ("failed", "ZeroDivisionError: nothing left", "")
    assert "nothing left" in (tmp_path / "failures" / f"{cell().key}.txt").read_text()


def test_the_figures_are_those_of_the_run(tmp_path):
    run = lane_on_a_sheet(tmp_path / "run", gain=90.0)
    found, worst = figures_of(run), run.verdict.deciding
    assert (found["outcome"], found["sure"], found["doubt"]) == (run.verdict.outcome, run.verdict.sure, run.verdict.doubt)
    assert (found["kept"], found["style_loss"]) == (run.summary.kept, run.summary.style_loss)
    bent = (worst.permanent_set, worst.plain_permanent_set, worst.allowed, worst.place)
    assert (found["permanent_set"], found["plain_permanent_set"], found["allowed"], found["place"]) == bent
    assert (found["decides"], found["simulations"]) == (worst.landing, len(run.summary.simulations))
    assert (found["load"], found["carries"]) == ("", None)


def test_the_worst_of_several_tests_is_in_the_row(tmp_path, monkeypatch):
    run = lane_on_a_sheet(tmp_path / "run", gain=50.0)
    loads = (load_row(0.05, load="pulled", carries=1.8), load_row(0.19, load="pushed", carries=1.2, plastic_strain=0.01))
    monkeypatch.setattr(type(run), "verdict", verdict(row(0.06, plastic_strain=0.02), *loads))
    found = figures_of(run)
    assert (found["decides"], found["permanent_set"], found["carries"], found["plastic_strain"]) == ("load pushed", 0.19, 1.2, 0.02)


@pytest.mark.parametrize(("passes_up_to", "left", "tests"), [(0.3, 0.25, 4), (1.0, 1.0, 0), (0.0, 0.0, 4)])
def test_one_factor_is_the_largest_that_passes_by_sixteenths(passes_up_to, left, tests):
    relief, tried = np.array([0.0, -2.0], np.float32), []

    class Simulator:
        baseline = np.zeros(2, np.float32)

        def simulate(self, displacement, *, thorough):
            assert thorough
            tried.append(displacement)
            return displacement

        def judge(self, displacement):
            return verdict(row(0.1 if displacement[1] >= -2.0 * passes_up_to else 0.3))

    summary = SimpleNamespace(kept=0.8, simulations=(1,))
    run = SimpleNamespace(
        simulator=lambda _: Simulator(), recipe=None, checkpoint=lambda: SimpleNamespace(displacement=relief), summary=summary,
        verdict=Simulator().judge(relief),
    )  # fmt: skip
    found = one_factor(run)
    assert (found["kept"], found["simulations"], found["outcome"]) == (pytest.approx(0.8 * left), 1 + tests, "HOLDS")
    assert len(tried) == tests
    assert all(one.dtype == np.float32 for one in tried)


def test_a_row_of_another_measure_is_made_again(runs, tmp_path):
    carry_out(cell(), tmp_path)
    path = Rows(tmp_path).path(cell())
    path.write_text('{"part": "wall_hook", "prompt": "brick", "arm": "masks", "verdict": "VIABLE", "peak": 40.0}')
    assert carry_out(cell(), tmp_path).outcome == "HOLDS"
    assert len(runs) == 2


def test_a_prompt_nobody_knows_is_refused_before_anything_runs():
    with pytest.raises(BadInput):
        recipe_for("")
