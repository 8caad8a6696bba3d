"""Errors a user can cause: one family, and names suggested by nearness."""

import pytest

import mechstyle as ms
from mechstyle import errors
from mechstyle.errors import BadInput, MechStyleError, unknown


@pytest.mark.parametrize("name", ["BadInput", "DamagedStore", "MissingPiece", "SimulationFailed"])
def test_every_error_a_user_can_cause_is_caught_by_one_name(name):
    assert issubclass(getattr(errors, name), MechStyleError)


def test_a_defect_of_the_program_is_not_caught_by_that_name():
    assert not issubclass(MechStyleError, ValueError)
    assert not issubclass(ValueError, MechStyleError)


def test_unknown_suggests_the_nearest_name_first_and_then_lists_the_others_in_order():
    error = unknown("style", "brik", ["wood", "brick", "stone", "crochet"])
    assert isinstance(error, BadInput)
    assert str(error) == "unknown style 'brik': did you mean 'brick'? known are brick, crochet, stone, wood"


def test_unknown_suggests_nothing_when_nothing_is_near():
    assert str(unknown("material", "cheese", ["PLA", "PETG"])) == "unknown material 'cheese': known are PETG, PLA"


@pytest.mark.parametrize("typed", ["BRICK", "Brick", "bricks"])
def test_unknown_does_not_mind_capitals_in_what_was_typed(typed):
    assert "did you mean 'brick'?" in str(unknown("style", typed, ["brick", "stone"]))


@pytest.mark.parametrize(("typed", "meant"), [("pet-g", "PETG"), ("pla plus", "PLA+"), ("assa", "ASA")])
def test_unknown_does_not_mind_capitals_in_what_is_known(typed, meant):
    """Materials are written in capitals."""
    assert f"did you mean {meant!r}?" in str(unknown("material", typed, ["PLA+", "PETG", "ASA"]))


def test_unknown_lists_each_name_once():
    names = [f"style{k}" for k in range(8)]
    message = str(unknown("style", "style9", names))
    assert all(message.split("known are ")[1].count(name) == 1 for name in names)


def test_a_sentence_is_one_line_whatever_the_path_in_it_holds(tmp_path):
    with pytest.raises(BadInput, match=r"a\\nb/part\.stl does not exist; check the path") as refused:
        ms.load(tmp_path / "a\nb" / "part.stl")
    assert str(refused.value).isprintable()
