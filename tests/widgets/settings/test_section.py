"""What every part of the settings column has from the recipe."""

import pytest
import traitlets

from mechstyle.records.recipe import CHOICES, DEFAULTS, LIMITS
from mechstyle.runs.recipes import MASKED
from mechstyle_widgets.settings.control import ControlSelector
from mechstyle_widgets.settings.drop import DropOptions
from mechstyle_widgets.studio import SECTIONS


def test_settings_begin_as_in_the_recipe_and_have_its_limits():
    settings = [(section, name) for section in SECTIONS for name in section.FIELDS if name in DEFAULTS]
    assert len(settings) > 20
    for section, name in settings:
        trait = section.class_traits()[name]
        begins = MASKED if name == "schedule" else DEFAULTS[name]  # the Studio shows the mask grow
        assert getattr(section(), name) == begins, name
        if name in LIMITS:
            assert (trait.min, trait.max) == LIMITS[name], name
        if name in CHOICES:
            assert set(trait.values) == set(CHOICES[name]) - ({"none"} if section is ControlSelector else set()), name


def test_a_wall_the_recipe_allows_is_kept_and_another_refused():
    options = DropOptions(minimum_wall=80.0)
    assert options.minimum_wall == 80.0
    with pytest.raises(traitlets.TraitError):
        options.minimum_wall = 200.0
