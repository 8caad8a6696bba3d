"""The control selector: what it draws is what the loop does."""

import msgspec
import numpy as np
import pytest

from mechstyle.records import Recipe
from mechstyle.records.material import LIBRARY
from mechstyle_widgets.settings.control import ControlSelector

PLA = LIBRARY["PLA"]


def ends_at(selector: ControlSelector) -> float:
    """Stress where the drawn mask comes to 0 [MPa]."""
    stress, _, mask = selector.curve(2001)
    return float(stress[np.argmax(mask <= 0.0)])


def test_the_curve_ends_where_the_material_does():
    assert ends_at(ControlSelector(PLA, control="linear")) == pytest.approx(45.6, abs=0.1)


def test_the_curve_of_sigma_c_moves_with_lambda():
    selector = ControlSelector(PLA, control="linear", normalisation="sigma_c")
    assert ends_at(selector) == pytest.approx(0.2 * 45.6, abs=0.1)
    before = selector._plot.value
    selector._lambda.value = 0.5
    assert selector.material.safety_coefficient == 0.5
    assert ends_at(selector) == pytest.approx(0.5 * 45.6, abs=0.1)
    assert selector._plot.value != before


def test_the_curve_moves_with_threshold_and_normalisation():
    selector = ControlSelector(PLA, control="linear", normalisation="sigma_c", threshold=0.5)
    assert ends_at(selector) == pytest.approx(0.5 * 0.2 * 45.6, abs=0.1)
    selector.normalisation, selector.peak_stress, selector.threshold = "own_max", 30.0, 1.0
    assert ends_at(selector) == pytest.approx(30.0, abs=0.1)


def test_at_first_it_is_drawn_for_a_flat_landing():
    """ρ c v of PLA falling 1.5 m."""
    assert ControlSelector(PLA).typical_stress == pytest.approx(11.3, abs=0.1)


def test_it_takes_what_a_recipe_has():
    stricter = msgspec.structs.replace(PLA, safety_coefficient=0.4)
    recipe = Recipe.of(prompt="", material=stricter, control="linear", normalisation="sigma_c", threshold=0.7)
    selector = ControlSelector(PLA)
    selector.take(recipe)
    assert (selector.control, selector.normalisation, selector.threshold, selector._lambda.value) == ("linear", "sigma_c", 0.7, 0.4)
    selector.take(recipe.with_settings(control="none"))
    assert selector.freestyle
