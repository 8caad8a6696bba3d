import itertools
import re

import pytest

from mechstyle.errors import BadInput
from mechstyle.styling import prompt as reading
from mechstyle.styling.library import library, names
from mechstyle.styling.prompt import AMOUNTS, COLOURS, DEGREES, FILLERS, SIZES, Wish, read


@pytest.mark.parametrize(
    ("prompt", "style"),
    [
        ("brick", "brick"),
        ("Bricks!", "brick"),
        ("BRICKWORK", "brick"),
        ("stone", "stone"),
        ("stonework", "stone"),
        ("rocks", "stone"),
        ("made of cobblestones", "stone"),
        ("cacti", "cactus"),
        ("a cactus", "cactus"),
        ("crocheted", "crochet"),
        ("Crochêt", "crochet"),
        ("yarn", "crochet"),
        ("knitted wool", "knit"),
        ("fish scales", "fish_scales"),
        ("fish_scales", "fish_scales"),
        ("scales", "fish_scales"),
        ("dragon scales", "dragon_scales"),
        ("the scales of a dragon", "dragon_scales"),
        ("Damascus steel", "damascus"),
        ("steel", "hammered"),
        ("hammered metal", "hammered"),
        ("wood grain", "wood"),
        ("floral patterns", "floral"),
        ("basket weave", "basket_weave"),
        ("cracked earth", "cracked_earth"),
        ("weathered", "weathered"),
        ("colorful mandala texture on mahogany wood", "mandala"),
        ("mandala on wood", "mandala"),
        ("green", "green"),
        ("leaves", "green"),
        ("ivy", "green"),
        ("diamond knurling", "knurling"),
        ("carbon fiber weave", "carbon_fibre"),
        ("polka dots", "dots"),
        ("bubbles", "bubbles"),
        ("gemstones", "crystal"),
        ("ribbed", "stripes"),
        ("a waffle", "grid"),
        ("jeans", "twill"),
        ("low poly", "low_poly"),
        ("cable knit", "cable_knit"),
        ("tree bark", "bark"),
        ("feathers", "feathers"),
        ("diamond quilted", "quilting"),
        ("a Celtic knot", "celtic_knot"),
        ("knotwork", "celtic_knot"),
        ("cement", "concrete"),
        ("brushed steel", "brushed_metal"),
        ("moss", "moss"),
        ("art deco", "art_deco"),
        ("topographic lines", "topographic"),
        ("contour map", "topographic"),
        ("isogrid", "isogrid"),
        ("realistic", "realistic"),
        ("a realistic look", "realistic"),
        ("A 3D rendering of a brick wall in unreal engine.", "brick"),
    ],
)
def test_styles_are_found_by_word_plural_participle_and_synonym_without_fuss(prompt, style):
    assert read(prompt) == Wish(style)


@pytest.mark.parametrize(
    ("prompt", "style"),
    [("birck", "brick"), ("stonewrk", "stone"), ("crotchet", "crochet"), ("catcus", "cactus"), ("realstic", "realistic")],
)
def test_a_misspelt_style_is_forgiven_with_a_note(prompt, style):
    wish = read(prompt)
    assert wish.style == style
    assert len(wish.notes) == 1
    assert wish.notes[0].startswith(f"read {prompt!r} as ")


def test_size_and_amount_words_are_factors_and_a_degree_is_an_exponent():
    assert read("small bricks").size == SIZES["small"]
    assert read("deep bricks").amount == AMOUNTS["deep"]
    assert read("very deep bricks").amount == pytest.approx(AMOUNTS["deep"] ** 1.6)
    assert read("slightly rough large bricks") == Wish("brick", size=pytest.approx(1.4), amount=pytest.approx(AMOUNTS["rough"] ** 0.5))
    assert read("extremely tiny miniature bricks").size == 0.4
    assert read("extremely extreme dramatic bricks").amount == 3.0


def rising(groups, value):
    """Whether synonyms, separated by spaces, are worth the same and each group is worth more than the one before."""
    worth = [{value(word) for word in group.split()} for group in groups]
    return all(len(values) == 1 for values in worth) and all(max(a) < min(b) for a, b in itertools.pairwise(worth))


def test_size_words_rise_from_tiny_to_huge_with_the_nominal_size_between():
    groups = ["tiny minute miniature micro", "small little fine dense", "tight narrow", "medium", "wide",
              "large big coarse chunky bulky", "huge giant massive"]  # fmt: skip
    assert sorted(" ".join(groups).split()) == sorted(SIZES)
    assert rising(groups, lambda word: read(f"{word} bricks").size)
    assert read("medium bricks").size == 1.0


def test_amount_words_rise_from_flat_to_extreme_with_the_nominal_amount_between():
    groups = ["flat faint", "subtle smooth", "low gentle delicate shallow soft mild", "moderate", "pronounced rough", "rugged strong bold",
              "deep heavy", "dramatic", "extreme"]  # fmt: skip
    assert sorted(" ".join(groups).split()) == sorted(AMOUNTS)
    assert rising(groups, lambda word: read(f"{word} bricks").amount)
    assert read("moderate bricks").amount == 1.0


@pytest.mark.parametrize("prompt", ["tiny huge bricks", "tight wide bricks", "subtle extreme bricks"])
def test_opposite_words_undo_each_other(prompt):
    wish = read(prompt)
    assert (wish.size, wish.amount) == pytest.approx((1.0, 1.0))


def test_degrees_rise_from_the_root_by_the_word_alone_to_the_square():
    power = {word: read(f"{word} large bricks").size for word in DEGREES}
    large = read("large bricks").size
    assert rising(["slightly", "somewhat"], power.get)
    assert power["somewhat"] < large < power["quite"]
    assert rising(["quite", "very really", "super", "extremely"], power.get)
    assert power["slightly"] == pytest.approx(large**0.5)
    assert power["extremely"] == pytest.approx(large**2)
    assert power["somewhat"] / power["slightly"] < large / power["somewhat"]  # nearer to "slightly" than to the word alone
    assert power["quite"] / large < power["very"] / power["quite"]  # nearer to the word alone than to "very"


def test_shades_rise_from_dark_to_pale_and_no_two_look_alike():
    own = {word: read(f"{word} brick").shade for word in ("dark", "bright", "light", "pale")}
    assert rising(own, own.get)
    assert own["dark"] < 1.0 < own["bright"]
    assert own["pale"] / own["light"] < own["light"] / own["bright"]  # pale is a little more than light
    blue = {word: sum(read(f"{word} blue brick").colour) for word in ("dark", "deep", "bright", "light", "pale")}
    blue[""] = sum(read("blue brick").colour)
    assert rising(["dark", "deep"], blue.get)
    assert blue["deep"] < blue[""] < blue["bright"]
    assert rising(["bright", "light", "pale"], blue.get)
    assert blue["deep"] > 1.1 * blue["dark"]
    assert blue["deep"] - blue["dark"] < blue[""] - blue["deep"]  # deep is a kind of dark


@pytest.mark.parametrize(
    ("prompt", "size", "amount"),
    [("extremely huge giant bricks", 3.0, 1.0), ("extremely tiny micro bricks", 0.4, 1.0),
     ("extremely extreme heavy bricks", 1.0, 3.0), ("extremely flat faint bricks", 1.0, 0.2)],
)  # fmt: skip
def test_however_words_add_up_size_and_amount_stay_within_what_can_be_drawn(prompt, size, amount):
    assert (read(prompt).size, read(prompt).amount) == (size, amount)


def test_a_wish_is_not_changed_by_those_who_read_it():
    with pytest.raises(AttributeError):
        read("brick").style = "stone"


def test_colour_words_colour_and_shade_words_belong_to_the_colour_after_them():
    blue = read("blue bricks").colour
    assert blue == pytest.approx((0x2F / 255, 0x5F / 255, 0xA8 / 255))
    deep = read("deep blue bricks")
    assert deep.amount == 1.0
    assert sum(deep.colour) < sum(blue) < sum(read("light blue bricks").colour)
    assert read("bricks").colour is None
    assert read("bricks in deep blue") == deep
    assert read("blue bricks, dark").colour == blue  # "dark" is not before the blue


def test_a_plural_of_three_letters_is_read_and_what_two_would_be_left_of_is_not():
    assert read("bricks in reds") == read("bricks in red")
    assert read("bricks with toes").notes == ("not understood and left out: 'toes'",)  # not "to"


def test_a_shade_without_a_colour_is_one_of_the_style_s_own_colours():
    assert read("rough dark brick") == Wish("brick", amount=AMOUNTS["rough"], shade=0.55)
    assert read("light knitted wool").shade > 1.0
    assert read("deep brick") == Wish("brick", amount=AMOUNTS["deep"])
    assert read("brick, dark") == Wish("brick", shade=0.55)
    assert read("brick, deep") == read("deep brick")
    assert read("dark blue brick").shade == 1.0  # the blue is dark already


def test_the_combinations_people_ask_for():
    assert read("small blue fish scales") == Wish("fish_scales", size=SIZES["small"], colour=read("blue brick").colour)
    assert read("mandala on mahogany") == Wish("mandala")
    assert read("small blu fish scals").notes == ("read 'blu' as 'blue'", "read 'scals' as 'scaly'")


def test_a_misspelt_word_beside_a_style_completes_its_phrase():
    assert read("damascas steel").style == "damascus"
    assert read("mandalla on wood").style == "mandala"


def test_green_is_a_style_alone_and_a_colour_beside_another_style():
    assert read("green").colour is None
    assert read("green bricks").style == "brick"
    assert read("green bricks").colour is not None
    assert read("dark green").style == "green"
    assert read("dark green").colour is not None


def test_a_style_that_only_describes_gives_way_to_any_other():
    wish = read("old weathered brick")
    assert wish.style == "brick"
    assert wish.notes == ("one style at a time: took 'brick', left out 'realistic', 'weathered'",)
    assert read("old green").style == "realistic"
    assert read("weathered old").style == "weathered"  # of two that describe, the first
    assert read("weathered").style == "weathered"


def test_only_the_first_style_and_colour_count_and_notes_say_so():
    wish = read("brick and stone in blue or red")
    assert wish.style == "brick"
    assert wish.colour == read("blue brick").colour
    assert wish.notes == ("one style at a time: took 'brick', left out 'stone'", "one colour at a time: took 'blue', left out 'red'")


def test_words_of_a_phrase_count_together_and_what_is_left_of_another_phrase_alone():
    wish = read("fish and dragon scales")
    assert wish.style == "fish_scales"
    assert wish.notes == ("one style at a time: took 'fish_scales', left out 'dragon_scales'",)
    assert read("scales of brick and dragon").style == "dragon_scales"  # a phrase stands where it begins
    assert read("mahogany wood").style == "wood"
    assert read("mahogany wood").colour == read("mahogany brick").colour is not None


def test_the_phrase_of_most_words_is_read_first_however_long_they_are():
    styles = {"bee_on_ivy": "honeycomb", "chrysanthemum_ivy": "floral", "bee": "honeycomb", "ivy": "green", "chrysanthemum": "floral"}
    assert reading._phrased(["chrysanthemum", "bee", "on", "ivy"], styles) == ["chrysanthemum", "bee_on_ivy", "the", "the"]


def test_every_word_of_a_phrase_means_something_alone():
    phrases = [word for style in library().values() for word in (style.name, *style.words) if "_" in word]
    assert phrases
    for part in {part for phrase in phrases for part in phrase.split("_")}:
        assert part in COLOURS or part in AMOUNTS or part in FILLERS or read(part).style in names()


def test_misspelt_colours_and_sizes_are_forgiven_too():
    wish = read("smal bricks in turqoise")
    assert (wish.size, wish.colour) == (SIZES["small"], read("turquoise bricks").colour)
    assert wish.notes == ("read 'smal' as 'small'", "read 'turqoise' as 'turquoise'")


def test_words_not_understood_are_reported_together():
    assert read("bricks on the moon, quietly").notes == ("not understood and left out: 'moon', 'quietly'",)


def test_a_word_near_a_style_does_not_compete_with_a_style_spelt_out():
    assert read("brick store") == Wish("brick", notes=("not understood and left out: 'store'",))


def test_a_word_only_somewhat_like_a_size_is_none():
    assert read("stall bricks") == Wish("brick", notes=("not understood and left out: 'stall'",))


@pytest.mark.parametrize("prompt", ["mahogany zebra", "zebra", "", "   ", "blue", "very small", "3d", "castle", "tower", "forest", "iv"])
def test_a_prompt_without_a_style_is_refused_and_never_replaced(prompt):
    with pytest.raises(BadInput, match="names no style") as refusal:
        read(prompt)
    text = str(refusal.value)
    assert repr(prompt) in text
    assert all(name in text for name in names())
    assert "guidance 'clip' (`--guidance clip`)" in text
    assert "`mechstyle weights fetch ViT-B-32`" in text
    assert "\n" not in text


def test_the_refusal_names_the_nearest_styles_first():
    with pytest.raises(BadInput, match="the nearest are 'cactus'"):
        read("octopus cat us cacao")


@pytest.mark.parametrize(
    ("prompt", "nearest"),
    [("castle", 3), ("castle tower forest", 3), ("tower", 2), ("forest", 1), ("dinosaur", 0), ("unicorn music", 0)],
)
def test_the_refusal_names_three_styles_at_most_and_none_that_is_far(prompt, nearest):
    with pytest.raises(BadInput) as refusal:
        read(prompt)
    found = re.search(r"offline: (?:the nearest are (.*?); )?known are", str(refusal.value))
    named = found[1].split(", ") if found[1] else []
    assert len(named) == len(set(named)) == nearest
    assert {name.strip("'") for name in named} <= set(names())


def test_no_word_means_two_things():
    tables = [SIZES, AMOUNTS, COLOURS, FILLERS]
    words = [word for table in tables for word in table]
    named = {word for style in library().values() for word in (style.name, *style.words)}
    assert not named & {*SIZES, *AMOUNTS, *FILLERS}
    assert len(words) == len(set(words))
