"""From a request to a recipe: presets, what overrides them, and what is refused before anything is computed."""

import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.loop.store import Store
from mechstyle.records import CONTROLS, POSES, Recipe
from mechstyle.records.load_cases import Load, LoadCase, Support
from mechstyle.records.material import LIBRARY, Material
from mechstyle.records.regions import HalfSpace, Inside
from mechstyle.runs.recipes import PAPER, brought, changed, check_settings, expected, idle, plan, recipe_for, typed

WITHOUT_OUR_ADDITIONS = {"base": "free", "guarantee": False}


def defaults(part, **settings):
    return Recipe.of(surface=part.surface.digest, tetrahedra=part.tets.digest, prompt="brick", material=LIBRARY["PLA"], **settings)


def test_loads_come_from_a_file_or_as_cases_and_are_the_same_recipe(part, tmp_path):
    file = tmp_path / "loads.toml"
    file.write_text("[[case]]\nname = 'rest'\nsupports = [{ at = 'resting face' }]\nloads = [{ gravity = 2 }]\n", encoding="utf-8")
    case = LoadCase(name="rest", supports=[Support(at="resting face")], loads=[Load(gravity=2)])
    from_file = plan(part, "brick", loads=file)
    assert from_file.digest == plan(part, "brick", loads=[case]).digest == plan(part, "brick", loads=case).digest
    assert from_file.digest != plan(part, "brick").digest
    with pytest.raises(BadInput, match="does not exist"):
        changed(from_file, {"loads": str(tmp_path / "none.toml")})


# --- presets ------------------------------------------------------------------------------------------------------


def test_a_plain_request_gets_the_defaults_of_the_recipe(part):
    assert plan(part, "brick") == defaults(part)


def test_the_recipe_names_part_prompt_and_material(part):
    one = plan(part, "small blue stones", "pla")
    assert (one.test.specimen.surface, one.test.specimen.tetrahedra) == (part.surface.digest, part.tets.digest)
    assert (one.style.prompt, one.test.material) == ("small blue stones", LIBRARY["PLA"])


def test_freestyle_is_stylization_without_feedback(part):
    one = plan(part, "brick", freestyle=True)
    assert one == defaults(part, control="none", schedule="never", **WITHOUT_OUR_ADDITIONS)
    assert not one.restraint.feedback


def test_the_paper_criterion_brings_the_published_method(part):
    theirs = {"normalisation": "sigma_c", "transfer": "nearest", "element": "tet4", "minimum_wall": 0.0}
    theirs |= {"nearly_flat": False, "schedule": "stress", "contact_stiffness": PAPER["contact_stiffness"]}
    expected = defaults(part, criterion="paper", **theirs, **WITHOUT_OUR_ADDITIONS)
    assert plan(part, "brick", criterion="paper") == expected


@pytest.mark.parametrize(
    ("settings", "told"),
    [({"criterion": "paper"}, True), ({}, False), ({"criterion": "paper", "freestyle": True}, False),
     ({"criterion": "paper", "normalisation": "headroom"}, False)],
)  # fmt: skip
def test_what_the_published_method_leaves_of_a_style_is_told_beforehand(part, settings, told):
    assert any("a fifth of the yield strength" in sentence for sentence in expected(plan(part, "brick", **settings))) is told


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"every": 5}, ["every does nothing without the schedule every"]),
        ({"every": 5, "schedule": "every"}, []),
        ({"travel": 0.2, "schedule": "never"}, ["travel does nothing without the schedule geometry or stress"]),
        ({"threshold": 0.5, "control": "none"}, ["threshold does nothing without masks: ask for a schedule such as stress"]),
        ({"poses": "box26", "orientations": 1}, ["poses does nothing without more than one orientation"]),
        ({"poses": "box26", "orientations": 2, "threshold": 0.5, "travel": 0.2, "schedule": "stress"}, []),
    ],
)
def test_settings_that_do_nothing_beside_the_others_are_named(given, told):
    assert list(idle(given, recipe_for("brick", **given))) == told


def test_freestyle_under_the_paper_criterion_is_both(part):
    one = plan(part, "brick", criterion="paper", freestyle=True)
    assert (one.restraint.control, one.schedule.when, one.test.transfer, one.test.criterion) == ("none", "never", "nearest", "paper")


@pytest.mark.parametrize(
    ("preset", "setting"),
    [
        ({"freestyle": True}, {"schedule": "quadratic"}),
        ({"freestyle": True}, {"control": "linear"}),
        ({"freestyle": True}, {"guarantee": True}),
        ({"criterion": "paper"}, {"nearly_flat": True}),
        ({"criterion": "paper"}, {"transfer": "barycentric"}),
        ({"criterion": "paper"}, {"normalisation": "headroom"}),
        ({"criterion": "paper", "freestyle": True}, {"base": "plain"}),
    ],
)
def test_what_is_asked_for_overrides_the_preset_and_nothing_else(part, preset, setting):
    expected = plan(part, "brick", **preset).with_settings(**setting)
    assert plan(part, "brick", **preset, **setting) == expected


def test_a_setting_of_none_is_not_given(part):
    """As the command line hands over options nobody typed."""
    assert plan(part, "brick", control=None, iterations=None) == plan(part, "brick")
    assert changed(plan(part, "brick"), {"control": None, "material": None, "prompt": None}) == plan(part, "brick")


# --- normalisation ------------------------------------------------------------------------------------------------

NORMALISATIONS = [
    ("robust", "linear", "headroom"),
    ("robust", "exponential", "headroom"),
    ("robust", "none", "headroom"),
    ("robust", "frozen", "own_max"),
    ("paper", "linear", "sigma_c"),
    ("paper", "exponential", "sigma_c"),
    ("paper", "none", "sigma_c"),
    ("paper", "frozen", "own_max"),
]
by_control = pytest.mark.parametrize(("criterion", "control", "normalisation"), NORMALISATIONS)


@by_control
def test_each_control_has_its_own_normalisation(part, criterion, control, normalisation):
    assert plan(part, "brick", criterion=criterion, control=control).restraint.normalisation == normalisation


@by_control
def test_another_control_brings_its_own_normalisation(part, criterion, control, normalisation):
    other = "headroom" if normalisation == "sigma_c" else "sigma_c"
    one = plan(part, "brick", criterion=criterion, control="linear", normalisation=other)
    assert changed(one, {"control": control}) == one.with_settings(control=control, normalisation=normalisation)


@pytest.mark.parametrize("control", CONTROLS)
def test_a_normalisation_asked_for_is_kept(part, control):
    assert plan(part, "brick", control=control, normalisation="sigma_c").restraint.normalisation == "sigma_c"
    assert changed(plan(part, "brick"), {"control": control, "normalisation": "sigma_c"}).restraint.normalisation == "sigma_c"


def test_another_control_and_criterion_at_once_follow_the_new_criterion(part):
    assert changed(plan(part, "brick"), {"control": "linear", "criterion": "paper"}).restraint.normalisation == "sigma_c"


def test_without_another_control_the_normalisation_stays(part):
    one = plan(part, "brick", control="frozen")
    assert changed(one, {"every": 5, "schedule": "every"}).restraint.normalisation == "own_max"


# --- changes ------------------------------------------------------------------------------------------------------


def test_changing_nothing_gives_the_same_recipe(part):
    one = plan(part, "brick", control="frozen", iterations=40)
    assert changed(one, {}).digest == one.digest


def test_changes_leave_everything_else_alone(part):
    one = plan(part, "brick", seed=3)
    assert changed(one, {"iterations": 300, "prompt": "stone"}) == one.with_settings(iterations=300, prompt="stone")


def test_a_material_is_changed_by_name_or_in_full(part):
    soft = Material(name="soft", youngs_modulus=1000.0, poisson_ratio=0.4, density=1.1e-3, yield_strength=20.0)
    one = changed(plan(part, "brick"), {"material": soft})
    assert one.test.material == soft
    assert changed(one, {"material": "pla"}).test.material == LIBRARY["PLA"]


# --- what is refused ----------------------------------------------------------------------------------------------


def both_ways(part, settings):
    """The recipe of these settings, asked for at the start and as a change."""
    return (lambda: plan(part, "brick", **settings)), (lambda: changed(plan(part, "brick"), settings))


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"iteration": 10}, "unknown setting 'iteration': did you mean 'iterations'"),
        ({"schedul": "every"}, "unknown setting 'schedul': did you mean 'schedule'"),
        ({"surface": "5" * 64}, "unknown setting 'surface': "),
        ({"tetrahedra": "5" * 64}, "unknown setting 'tetrahedra': "),
        ({"control": "exponental"}, "unknown control 'exponental': did you mean 'exponential'"),
        ({"normalisation": "head"}, "unknown normalisation 'head': did you mean 'headroom'"),
        ({"criterion": "papr"}, "unknown criterion 'papr': did you mean 'paper'"),
        ({"schedule": "stres"}, "unknown schedule 'stres': did you mean 'stress'"),
        ({"transfer": "nearst"}, "unknown transfer 'nearst': did you mean 'nearest'"),
        ({"iterations": 0}, "iterations is 0, but must lie between 1 and 100000"),
        ({"iterations": 10**400}, "iterations is beyond any float, but must lie between 1 and 100000"),
        ({"amplitude": -0.1}, "amplitude is -0.1, but must lie between 0 and 2"),
        ({"height": 1e6}, r"height is 1e\+06, but must lie between 1 and 100000"),
        ({"travel": float("nan")}, "travel is nan, but must lie between 0.001 and 10"),
        ({"iterations": "many"}, "iterations is 'many', but must be a whole number"),
        ({"iterations": 20.5}, "iterations is 20.5, but must be a whole number"),
        ({"orientations": True}, "orientations is True, but must be a whole number"),
        ({"amplitude": "high"}, "amplitude is 'high', but must be a number"),
        ({"nearly_flat": "no"}, "nearly flat is 'no', but must be True or False"),
        ({"height": 1.5}, 'a height of 1.5 would be 1.5 mm: write "1.5 m", "1.5 cm" or "1.5 mm"'),
        ({"height": "5 ft"}, "a height is in m, cm or mm, not in 'ft'"),
        ({"height": np.float64("nan")}, "a height of nan is no fall"),
        ({"tolerance": "0.2 m"}, "a tolerance is in mm or µm, not in 'm'"),
        ({"tolerance": 0}, "a tolerance of 0 is none"),
        ({"tolerance": "200"}, "tolerance is 200, but must lie between 0.01 and 100"),
        ({"tilts": 3}, "unknown setting 'tilts': "),
        ({"contact_stiffness": 300}, "contact stiffness is of the published method, elsewhere the floor is rigid"),
        ({"criterion": "paper", "contact_stiffness": -1}, "contact stiffness is -1, but must lie between 0 and 100000"),
        ({"criterion": "paper", "contact_stiffness": "soft"}, "contact stiffness is 'soft', but must be a number"),
    ],
    ids=str,
)
def test_a_setting_that_cannot_be_is_refused_in_one_sentence(part, settings, message):
    for ask in both_ways(part, settings):
        with pytest.raises(BadInput, match=f"^{message}") as caught:
            ask()
        assert "\n" not in str(caught.value)


def test_an_unknown_prompt_or_material_is_refused(part):
    with pytest.raises(BadInput, match="the prompt 'nonsense' names no style"):
        plan(part, "nonsense")
    with pytest.raises(BadInput, match="unknown material 'PLAA': did you mean 'PLA'"):
        plan(part, "brick", "PLAA")
    with pytest.raises(BadInput, match="'nonsense' names no style"):
        changed(plan(part, "brick"), {"prompt": "nonsense"})
    with pytest.raises(BadInput, match="unknown material 'PLAA': did you mean 'PLA'"):
        changed(plan(part, "brick"), {"material": "PLAA"})


def test_settings_can_be_checked_before_a_part_is_prepared():
    check_settings({"control": None, "iterations": 5, "prompt": "brick", "material": "PLA"})
    with pytest.raises(BadInput, match="unknown setting 'seeed': did you mean 'seed'"):
        check_settings({"seeed": 1})


# --- a recipe and its name on disk --------------------------------------------------------------------------------

NUMBERS = [
    {"height": 1000},
    {"travel": 1, "window": 2, "friction": 0},
    {"amplitude": np.linspace(0.1, 0.3, 3)[1]},
    {"amplitude": np.float32(0.25)},
    {"iterations": np.arange(40, 41)[0], "seed": np.uint32(2**32 - 1)},
    {"nearly_flat": np.bool_(0)},
    {"material": Material(name="ABS", youngs_modulus=2100, poisson_ratio=np.float64(0.35), density=1.05e-3, yield_strength=40)},
]


@pytest.mark.parametrize("settings", NUMBERS, ids=lambda settings: next(iter(settings)))
def test_any_kind_of_number_gives_a_recipe_that_is_found_again(part, tmp_path, settings):
    """1000 and 1000.0 are written differently: a lane named by one would never be finished by a run that read the other."""
    for ask in both_ways(part, settings):
        one = ask()
        back = Store(tmp_path).recipe(Store(tmp_path).put_recipe(one))
        assert back == one
        assert back.digest == one.digest


def test_equal_requests_have_equal_digests(part):
    assert plan(part, "brick", height=1000).digest == plan(part, "brick", height=1000.0).digest
    assert plan(part, "brick", height="1 m").digest == plan(part, "brick", height=1000.0).digest
    assert plan(part, "brick", every=np.int64(5)).digest == plan(part, "brick", every=5).digest


def test_branching_to_the_other_criterion_brings_its_presets(part):
    robust = plan(part, "brick")
    paper = changed(robust, {"criterion": "paper"})
    assert paper == plan(part, "brick", criterion="paper")
    assert changed(paper, {"criterion": "robust"}) == robust
    free = plan(part, "brick", freestyle=True)
    assert not changed(free, {"criterion": "paper"}).restraint.guarantee
    assert changed(changed(free, {"criterion": "paper"}), {"criterion": "robust"}) == free


# --- protected regions --------------------------------------------------------------------------------------------


def test_regions_in_words_and_as_records_are_one_recipe(part):
    said, meant = plan(part, "brick", protect=["above 5", "inside ramp 2"]), (HalfSpace((0, 0, 5), (0, 0, 1)), Inside(ramp=2))
    assert said == plan(part, "brick", protect=meant)
    assert said == plan(part, "brick", protect=list(said.restraint.protect))
    assert changed(said, {"protect": []}) == plan(part, "brick")


# --- landings, standards and layers ---------------------------------------------------------------------------------


@pytest.mark.parametrize(("poses", "drops"), POSES.items())
def test_poses_bring_their_number_of_drops_unless_told(poses, drops):
    assert recipe_for("brick", poses=poses).test.orientations == drops
    assert recipe_for("brick", poses=poses, orientations=3).test.orientations == 3
    assert changed(recipe_for("brick", orientations=3), {"poses": poses}).test.orientations == drops
    with pytest.raises(BadInput, match="unknown poses 'rest': did you mean 'resting'"):
        recipe_for("brick", poses="rest")


@pytest.mark.parametrize("given", ["z", "+Z", "0,0,1", "[0, 0, 1]", (0, 0, 1), np.array([0.0, 0.0, 1.0])])
def test_a_build_direction_is_an_axis_or_a_vector(given):
    recipe = recipe_for("brick", build_direction=given)
    assert recipe.test.build_direction == (0.0, 0.0, 1.0)
    assert recipe.test.across_layers == pytest.approx((0.0, 0.0, 1.0 / 0.55))
    assert recipe.digest == recipe_for("brick", build_direction="z").digest
    assert "(0, 0, 1) are judged with 0.55 of the strength across them (0.50 and 0.53 in two Polymaker" in recipe.test.layers_judged


def test_without_a_build_direction_layers_are_not_judged():
    assert recipe_for("brick").test.across_layers == (0.0, 0.0, 0.0)
    assert recipe_for("brick", "ABS").test.layers_judged == ""


@pytest.mark.parametrize(
    ("given", "material", "words"),
    [
        ("z", "ABS", "strength of generic ABS across its layers is not known: leave the build direction out, or give"),
        ("up", "PLA", "a direction is x, y, z or three numbers such as 0,0,1, not 'up'"),
        ("0,1", "PLA", "a direction is x, y, z"),
        ("0,0,0", "PLA", "must be x, y, z or a vector of some length"),
        ((0.0, np.inf, 0.0), "PLA", "must be x, y, z or a vector of some length"),
    ],
)
def test_a_build_direction_that_cannot_be_judged_is_refused(given, material, words):
    with pytest.raises(BadInput, match=words):
        recipe_for("brick", material, build_direction=given)


def test_a_standard_brings_its_landings_to_a_draft_and_to_a_branch():
    recipe = recipe_for("brick", standard="mil-810h")
    assert (recipe.test.standard, recipe.test.poses, recipe.test.orientations, recipe.test.height) == ("mil-810h", "box26", 27, 1220.0)
    other = changed(recipe, {"standard": "astm-f963"})
    assert (other.test.poses, other.test.orientations, other.test.height) == ("fibonacci", 10, 1372.0)
    assert "but poses resting" in changed(recipe, {"poses": "resting"}).test.after_standard


# --- the fall -------------------------------------------------------------------------------------------------------


def test_a_height_is_read_with_its_unit_wherever_settings_come_in():
    assert recipe_for("brick", height="1,2 m").test.height == 1200.0
    assert changed(recipe_for("brick"), {"height": "4 cm"}).test.height == 40.0
    assert brought({"height": "2 m"}, "exponential") == {"height": 2000.0}
    assert recipe_for("brick", **dict([typed("height=80 cm")])).test.height == 800.0
    assert recipe_for("brick", **dict([typed("height=4 cm")])).test.height == 40.0, "its unit is not lost on the way"


def test_a_height_set_by_name_is_asked_about_at_once():
    with pytest.raises(BadInput, match=r"would be 1\.5 mm"):
        typed("height=1.5")


def test_the_height_of_a_standard_is_left_where_another_is_written():
    assert recipe_for("brick", standard="mil-810h", height="1 m").test.height == 1000.0


# --- depths ---------------------------------------------------------------------------------------------------------


def test_a_depth_replaces_one_of_the_other_kind(part):
    told = plan(part, "brick", relief=0.8)
    assert (told.style.relief, told.style.amplitude) == (0.8, None)
    assert changed(told, {"amplitude": 0.2}) == plan(part, "brick", amplitude=0.2)
    both = changed(plan(part, "brick", amplitude=0.2), {"relief": 0.8})
    assert (both.style.relief, both.style.amplitude) == (0.8, 0.2), "a relief in mm goes before"
