"""What the studies ask for."""

import pytest

from benchmarks.study.grids import ARMS, STUDY_CONTROLS, STUDY_SCHEDULES, STYLES, Factors, cells_of
from mechstyle import gallery
from mechstyle.errors import BadInput

SMALL = {"models": ["pen_holder", "wall_hook"], "styles": ["brick"], "iterations": 9, "vertices": 1000}


def test_the_formative_study_is_every_model_in_every_style_once():
    cells = cells_of("formative", Factors())
    assert len(cells) == 30 * 6
    assert {cell.part for cell in cells} == set(gallery.names())
    assert {cell.recipe.style.prompt for cell in cells} == set(STYLES)
    assert all(cell.recipe.settings.items() >= {"control": "none", "schedule": "never", "guarantee": False}.items() for cell in cells)
    assert len({cell.key for cell in cells}) == len(cells)


def test_the_evaluation_crosses_every_control_with_every_schedule_beside_the_style_alone():
    cells = cells_of("evaluation", Factors(**SMALL))
    assert len(cells) == 2 * (1 + 12)
    ways = {(cell.recipe.restraint.control, cell.recipe.schedule.when) for cell in cells if cell.arm != "freestyle"}
    assert ways == {(control, schedule) for control in STUDY_CONTROLS for schedule in STUDY_SCHEDULES}
    assert not any(cell.recipe.restraint.guarantee for cell in cells)
    assert {(cell.recipe.schedule.iterations, cell.vertices) for cell in cells} == {(9, 1000)}


def test_the_style_alone_is_the_same_cell_in_both_studies():
    formative, evaluation = (cells_of(study, Factors(**SMALL)) for study in ("formative", "evaluation"))
    assert {cell.key for cell in formative} < {cell.key for cell in evaluation}


def test_an_ablation_is_every_arm_under_each_condition_and_loads_only_what_carries_something():
    cells = cells_of("ablation", Factors(**{**SMALL, "models": ["wall_hook", "coaster"]}))
    asked = [(cell.part, cell.arm, cell.condition) for cell in cells]
    assert len(asked) == len(set(asked)) == len({cell.key for cell in cells}) == 5 * 3 + 5 * 2  # a coaster carries nothing
    assert {cell.arm for cell in cells} == set(ARMS)
    assert {cell.arm for cell in cells if cell.one_factor} == {"one-factor"}
    assert not [one for one in asked if one[0] == "coaster" and one[2] == "load"]
    for cell in cells:
        deep, loaded = cell.condition == "deep", cell.condition == "load"
        assert (cell.recipe.style.amplitude, cell.load_share) == (0.25 if deep else None, 0.85 * loaded)
        assert [case.name for case in cell.recipe.test.loads] == ["heavy coat"] * (cell.condition == "load")


def test_a_load_for_parts_that_carry_nothing_is_refused():
    with pytest.raises(BadInput, match="none of these parts carries a load"):
        cells_of("ablation", Factors(**{**SMALL, "models": ["coaster"]}, conditions=["load"]))


def test_cells_of_a_part_that_rest_on_the_same_tetrahedra_stand_apart():
    """Side by side they would make them at the same time."""
    cells = cells_of("ablation", Factors(**{**SMALL, "models": ["wall_hook"], "styles": ["brick", "cactus"]}, conditions=["drop", "deep"]))
    meshed = [(cell.recipe.style.prompt, cell.recipe.restraint.base, cell.recipe.style.amplitude) for cell in cells]
    assert all(len(set(meshed[first : first + 4])) == 4 for first in range(len(meshed) - 3))
