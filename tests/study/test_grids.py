"""What the studies ask for."""

import pytest

from mechstyle import gallery
from mechstyle.errors import BadInput
from mechstyle.records.recipe import SETTINGS
from mechstyle.study.grids import ARMS, STUDIES, STUDY_ARMS, STUDY_CONTROLS, STUDY_SCHEDULES, STYLES, Factors, cells_of

SMALL = {"models": ["pen_holder", "wall_hook"], "styles": ["brick"], "iterations": 9, "vertices": 1000}


def test_the_formative_study_is_every_model_in_every_style_once():
    cells = cells_of("formative", Factors())
    assert len(cells) == 30 * 6
    assert {cell.part for cell in cells} == set(gallery.names())
    assert {cell.recipe.prompt for cell in cells} == set(STYLES)
    assert {(cell.recipe.control, cell.recipe.schedule, cell.recipe.guarantee) for cell in cells} == {("none", "never", False)}
    assert len({cell.key for cell in cells}) == len(cells)


def test_the_evaluation_crosses_every_control_with_every_schedule_beside_the_style_alone():
    cells = cells_of("evaluation", Factors(**SMALL))
    assert len(cells) == 2 * (1 + 12)
    ways = {(cell.recipe.control, cell.recipe.schedule) for cell in cells if cell.arm != "freestyle"}
    assert ways == {(control, schedule) for control in STUDY_CONTROLS for schedule in STUDY_SCHEDULES}
    assert not any(cell.recipe.guarantee for cell in cells)
    assert {(cell.recipe.iterations, cell.vertices) for cell in cells} == {(9, 1000)}


def test_the_style_alone_is_the_same_cell_in_both_studies():
    formative, evaluation = (cells_of(study, Factors(**SMALL)) for study in ("formative", "evaluation"))
    assert {cell.key for cell in formative} < {cell.key for cell in evaluation}


def test_an_ablation_is_run_at_each_depth_and_under_the_load_of_its_use():
    cells = cells_of("ablation", Factors(**{**SMALL, "models": ["wall_hook", "coaster"]}))
    told = [(cell.part, cell.arm, cell.recipe.amplitude, len(cell.recipe.loads)) for cell in cells]
    assert len(told) == 3 * 2 * 2 + 3 * 2  # a coaster carries nothing
    assert ("wall_hook", "masks", 0.5, 1) in told
    assert not [one for one in told if one[0] == "coaster" and one[3]]
    assert len(cells_of("ablation", Factors(**SMALL, loaded=False, amplitudes=[None]))) == 2 * 3


def test_the_strengthened_arm_differs_from_the_full_one_by_strengthening_alone():
    assert STUDY_ARMS.keys() - ARMS.keys() == {"strengthened"}
    assert set(STUDY_ARMS["strengthened"].settings) == {"strengthen"}
    assert all(name in SETTINGS for arm in STUDY_ARMS.values() for name in arm.settings)


def test_seeds_and_other_settings_reach_every_recipe():
    cells = cells_of("formative", Factors(**SMALL, seeds=[0, 7], settings={"orientations": 1}))
    assert [cell.recipe.seed for cell in cells] == [0, 7, 0, 7]
    assert {cell.recipe.orientations for cell in cells} == {1}


@pytest.mark.parametrize(
    ("study", "changes", "words"),
    [
        ("formativ", {}, "did you mean 'formative'"),
        ("formative", {"models": ["penholder"]}, "did you mean 'pen_holder'"),
        ("formative", {"models": ["vase", "gallery:penholder"]}, "did you mean 'pen_holder'"),
        *((study, {"models": ["vase", "none.stl"]}, r"none\.stl does not exist") for study in STUDIES),
        ("evaluation", {"controls": ["frosen"]}, "did you mean 'frozen'"),
        ("ablation", {"arms": ["statics"]}, "did you mean 'static'"),
    ],
)
def test_what_there_is_not_is_refused_before_anything_runs(study, changes, words):
    with pytest.raises(BadInput, match=words):
        cells_of(study, Factors(**{**SMALL, **changes}))
