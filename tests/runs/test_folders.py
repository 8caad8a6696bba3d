"""Where a run goes: nothing is overwritten, the same request finds its run again, and people are told of another folder."""

import logging
import re
import shlex

import pytest

from mechstyle.errors import BadInput
from mechstyle.runs.folders import folder_for
from mechstyle.runs.run import Draft
from mechstyle.simulation.part import fitted
from support.lanes import lane_on_a_sheet


@pytest.fixture
def run(tmp_path):
    return lane_on_a_sheet(tmp_path / "run", iterations=2)


def other(recipe, seed=7):
    return recipe.with_settings(seed=seed)


@pytest.mark.parametrize("beside", [False, True])
def test_a_free_folder_and_the_very_run_are_taken_as_they_are(run, tmp_path, caplog, beside):
    (tmp_path / "empty").mkdir()
    for name in ("new", "empty"):
        assert folder_for(tmp_path / name, run.recipe, beside=beside) == tmp_path / name
    meshed_anew = run.recipe.on(tetrahedra="5" * 64)
    assert folder_for(run.store.root, meshed_anew, beside=beside) == run.store.root
    assert not caplog.records


def test_another_run_goes_beside_the_one_that_is_there_and_is_found_there_again(run, caplog):
    root, part = run.store.root, run.part
    recipes = [fitted(other(run.recipe, seed), part) for seed in (7, 8)]
    first, second = (Draft(recipe, part, folder=root, device="cpu").begin() for recipe in recipes)
    assert [one.store.root.name for one in (first, second)] == ["run-2", "run-3"]
    assert [record.message for record in caplog.records] == [
        f"{root} holds a run with other settings: this one is in {root}-{number}" for number in (2, 3)
    ]
    assert Draft(recipes[1], part, folder=root, device="cpu").begin().store.root == second.store.root
    assert run.recipe.style.seed == 0


def test_what_is_no_run_is_never_written_to(run, tmp_path):
    (tmp_path / "run-2").mkdir()
    (tmp_path / "run-2" / "thesis.txt").write_text("years of work")
    (tmp_path / "run-3").write_text("a file")
    assert folder_for(run.store.root, other(run.recipe), beside=True) == tmp_path / "run-4"
    for name in ("run-2", "run-3"):
        with pytest.raises(BadInput, match="is not a run directory"):
            folder_for(tmp_path / name, run.recipe, beside=True)


def test_on_the_command_line_another_run_is_refused_with_advice(run):
    with pytest.raises(BadInput, match=r"other settings: choose another --out, or branch it with `mechstyle branch .*@ITERATION`"):
        folder_for(run.store.root, other(run.recipe), beside=False)


def test_the_advice_can_be_pasted_where_the_folder_has_a_space(run):
    recipe, spaced = other(run.recipe), run.store.root.rename(run.store.root.with_name("my run"))
    with pytest.raises(BadInput) as caught:
        folder_for(spaced, recipe, beside=False)
    command = re.search("`(.*)`", str(caught.value)).group(1)
    assert shlex.split(command) == ["mechstyle", "branch", f"{spaced}@ITERATION"]


def test_the_folder_one_is_in_has_a_name_as_well(run, monkeypatch, caplog):
    caplog.set_level(logging.ERROR)
    for place in (".", "objects/.."):
        monkeypatch.chdir(run.store.root)
        assert folder_for(type(run.store.root)(place), other(run.recipe), beside=True) == run.store.root.with_name("run-2")


def test_a_run_that_was_stopped_while_it_began_is_begun_again(run, tmp_path):
    """Its objects come first, its lane last: a folder with the one and not the other was refused as no run directory."""
    hardly = tmp_path / "hardly"
    (hardly / "objects" / "ab").mkdir(parents=True)
    for name in (".new-abc", "picture-0123abcd.png", "objects/ab/.new-x"):
        (hardly / name).write_bytes(b"half")
    assert folder_for(hardly, run.recipe, beside=False) == hardly
    (hardly / "thesis.txt").write_text("years of work")
    with pytest.raises(BadInput, match="is not a run directory"):
        folder_for(hardly, run.recipe, beside=False)
