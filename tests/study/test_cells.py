"""One cell, one row: what is kept, what is read again, and what becomes of a run that breaks."""

import msgspec
import pytest

from mechstyle import records
from mechstyle.errors import BadInput
from mechstyle.runs.recipes import draft
from mechstyle.study import cells as module
from mechstyle.study.cells import Cell, Row, Rows, carry_out, figures_of
from mechstyle.study.walk import walk
from support.lanes import lane_on_a_sheet

RUN = Cell.run


def cell(prompt="brick", **changes):
    return Cell(**{"model": "gallery:wall_hook", "arm": "masks", "recipe": draft(prompt), "vertices": 1000, **changes})


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
    different = [cell("stone"), cell(vertices=1001), cell(model="gallery:vase"), cell(recipe=draft("brick", seed=1))]
    assert len({one.key for one in [cell(), *different, cell(load_share=0.85)]}) == 6


@pytest.mark.parametrize("version", ["PHYSICS_VERSION", "TETRAHEDRA"])
def test_a_study_that_goes_on_with_a_newer_version_does_not_mix_its_rows_with_older_ones(version, monkeypatch):
    before = cell().key
    monkeypatch.setattr(module, version, "of tomorrow")
    assert cell().key != before


def test_a_cell_travels_as_json_without_loss():
    one = cell(recipe=draft("brick", protect=["inside"], orientations=2))
    assert msgspec.json.decode(msgspec.json.encode(one), type=Cell) == one


def test_what_has_a_row_is_only_read(runs, tmp_path):
    first = carry_out(cell(), tmp_path)
    assert (first.outcome, first.status, first.starts, first.part, first.prompt) == ("HOLDS", "done", 1, "wall_hook", "brick")
    assert carry_out(cell(), tmp_path) == first == Rows(tmp_path).of(cell())
    assert len(runs) == 1


def test_a_row_that_a_killed_writer_broke_is_made_again(runs, tmp_path):
    row = carry_out(cell(), tmp_path)
    path = Rows(tmp_path).path(cell())
    path.write_bytes(path.read_bytes()[:40])
    assert Rows(tmp_path).all() == []
    again = carry_out(cell(), tmp_path)
    assert again.starts == 2
    assert again.outcome == row.outcome


def test_a_part_that_cannot_be_used_is_a_row_with_its_reason(tmp_path):
    row = carry_out(cell(model=str(tmp_path / "none.stl")), tmp_path)
    assert row.status == "refused"
    assert "none.stl" in row.refused


def test_what_was_refused_is_tried_again(runs, monkeypatch, tmp_path):
    """A file that was put in its place since went on being told not to exist."""
    missing = cell(model=str(tmp_path / "none.stl"))
    with monkeypatch.context() as unpatched:
        unpatched.setattr(Cell, "run", RUN)
        assert carry_out(missing, tmp_path).status == "refused"
    assert [row.status for row in walk([missing], tmp_path)] == ["done"]
    assert Rows(tmp_path).of(missing).starts == 2


def test_a_run_that_breaks_is_a_row_and_its_traceback_is_kept(monkeypatch, tmp_path):
    def broken(self, out):
        raise ZeroDivisionError("nothing left")

    monkeypatch.setattr(Cell, "run", broken)
    row = carry_out(cell(), tmp_path)
    assert (row.status, row.refused, row.outcome) == ("failed", "ZeroDivisionError: nothing left", "")
    assert "nothing left" in (tmp_path / "failures" / f"{cell().key}.txt").read_text()


def test_the_figures_are_those_of_the_run(tmp_path):
    run = lane_on_a_sheet(tmp_path / "run", gain=90.0)
    found, flat, decides = figures_of(run), run.verdict.row("flat"), run.verdict.deciding
    assert (found["outcome"], found["sure"], found["doubt"]) == (run.verdict.outcome, run.verdict.sure, run.verdict.doubt)
    assert (found["kept"], found["style_loss"]) == (run.summary.kept, run.summary.style_loss)
    assert (found["flat_stress"], found["flat_height"], found["plain_flat_height"]) == (flat.stress, flat.height, flat.original)
    assert (found["decides"], found["reserve"]) == (decides.test, decides.reserve)
    assert found["safety_factor"] == run.verdict.safety_factor
    assert found["simulations"] == len(run.summary.simulations)
    assert (found["load"], found["load_factor"], found["plain_load_factor"]) == ("", None, None)


def test_of_several_loads_the_one_with_the_least_factor_is_in_the_row(tmp_path, monkeypatch):
    run = lane_on_a_sheet(tmp_path / "run", gain=50.0)
    load = {"test": "load", "outcome": "HOLDS", "stress": 20.0, "limit": 45.6, "asked": 1.0, "decides": True}
    cases = (records.Row(load="pulled", factor=1.8, original=2.5, **load), records.Row(load="pushed", factor=1.2, original=2.0, **load))
    verdict = msgspec.structs.replace(run.verdict, rows=(*run.verdict.rows, *cases))
    monkeypatch.setattr(type(run), "verdict", verdict)
    assert (figures_of(run)["load_factor"], figures_of(run)["plain_load_factor"]) == (1.2, 2.0)


def test_loads_are_scaled_in_the_study_folder_before_a_run_begins(monkeypatch, tmp_path):
    asked = {}

    class Begun:
        def go(self):
            return "finished"

    def with_loads(recipe, model, vertices, **how):
        asked.update(how, vertices=vertices, model=model.name)
        return recipe.with_settings(seed=77)

    monkeypatch.setattr(module, "with_loads", with_loads)
    monkeypatch.setattr(module, "started", lambda recipe, *_, **__: asked.update(seed=recipe.style.seed) or Begun())
    cell(load_share=0.85).run(tmp_path)
    assert asked == {"share": 0.85, "folder": tmp_path / "loads", "vertices": 1000, "model": "wall_hook", "seed": 77}
    asked.clear()
    cell().run(tmp_path)
    assert asked == {"seed": 0}


def test_a_run_goes_where_the_cell_says(monkeypatch, tmp_path):
    asked = {}

    class Begun:
        def go(self):
            return "finished"

    monkeypatch.setattr(module, "started", lambda *_, **settings: asked.update(settings) or Begun())
    assert cell(folder="wall_hook-brick/masks").run(tmp_path) == "finished"
    assert asked["out"] == tmp_path / "wall_hook-brick" / "masks"
    cell(arm="stress × frozen").run(tmp_path)
    assert asked["out"].parent == tmp_path / "runs"
    assert asked["out"].name.startswith("wall_hook-brick-drop-stress-frozen-")


def test_the_published_rule_and_the_outcome_are_not_the_same():
    row = Row(part="a", prompt="b", arm="c", outcome="NO WORSE", fall=1500.0, flat_height=1400.0, published_factor=1.1)
    assert (row.passes, row.holds_flat, row.passes_published) == (True, False, True)
    fails = Row(part="a", prompt="b", arm="c", outcome="FAILS", fall=1500.0, flat_height=1600.0, published_factor=0.9)
    assert (fails.passes, fails.holds_flat, fails.passes_published) == (False, True, False)
    unknown = Row(part="a", prompt="b", arm="c", outcome="UNKNOWN")
    assert (unknown.passes, unknown.holds_flat, unknown.passes_published) == (False, False, False)


def test_a_row_of_another_measure_is_made_again(runs, tmp_path):
    carry_out(cell(), tmp_path)
    path = Rows(tmp_path).path(cell())
    path.write_text('{"part": "wall_hook", "prompt": "brick", "arm": "masks", "verdict": "VIABLE", "peak": 40.0}')
    assert carry_out(cell(), tmp_path).outcome == "HOLDS"
    assert len(runs) == 2


def test_a_prompt_nobody_knows_is_refused_before_anything_runs():
    with pytest.raises(BadInput):
        draft("")
