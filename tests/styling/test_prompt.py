import itertools

import msgspec
import pytest

from mechstyle.errors import BadInput
from mechstyle.records.regions import Box, End, Inside, Outside, Rim
from mechstyle.styling import words
from mechstyle.styling.library import names
from mechstyle.styling.prompt import Reading, Wish, read, suggestions
from mechstyle.styling.vocabulary import AMOUNTS, COLOURS, DEGREES, FILLERS, SIZES, english, styles, weak


def wish(prompt) -> Wish:
    """The only wish of a prompt."""
    (only,) = read(prompt).wishes
    return only


def notes(prompt) -> tuple[str, ...]:
    return read(prompt).notes


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
        ("realistic", "realistic"),
        ("a realistic look", "realistic"),
        ("A 3D rendering of a brick wall in unreal engine.", "brick"),
    ],
)
def test_styles_are_found_by_word_plural_participle_and_synonym_without_fuss(prompt, style):
    assert read(prompt) == Reading((Wish(style),))


@pytest.mark.parametrize(
    ("prompt", "style"),
    [("birck", "brick"), ("stonewrk", "stone"), ("crotchet", "crochet"), ("catcus", "cactus"), ("realstic", "realistic")],
)
def test_a_misspelt_style_is_forgiven_with_a_note(prompt, style):
    assert wish(prompt).style == style
    (note,) = notes(prompt)
    assert note.startswith(f"read {prompt!r} as ")


def test_size_and_amount_words_are_factors_and_a_degree_is_an_exponent():
    assert wish("small bricks").size == SIZES["small"]
    assert wish("deep bricks").amount == AMOUNTS["deep"]
    assert wish("very deep bricks").amount == pytest.approx(AMOUNTS["deep"] ** 1.6)
    assert wish("slightly rough large bricks") == Wish("brick", size=pytest.approx(1.4), amount=pytest.approx(AMOUNTS["rough"] ** 0.5))
    assert wish("extremely tiny miniature bricks").size == 0.4
    assert wish("extremely extreme dramatic bricks").amount == 3.0


def rising(groups, value):
    """Whether synonyms, separated by spaces, are worth the same and each group is worth more than the one before."""
    worth = [{value(word) for word in group.split()} for group in groups]
    return all(len(values) == 1 for values in worth) and all(max(a) < min(b) for a, b in itertools.pairwise(worth))


def test_size_words_rise_from_tiny_to_huge_with_the_nominal_size_between():
    groups = ["tiny minute miniature micro", "small little fine dense thin", "tight narrow", "medium", "wide",
              "large big coarse chunky thick bulky", "huge giant massive"]  # fmt: skip
    assert sorted(" ".join(groups).split()) == sorted(SIZES)
    assert rising(groups, lambda word: wish(f"{word} bricks").size)
    assert wish("medium bricks").size == 1.0


def test_amount_words_rise_from_flat_to_extreme_with_the_nominal_amount_between():
    groups = ["flat faint", "subtle smooth barely_visible hardly_visible barely_there",
              "low gentle delicate shallow soft mild", "moderate", "pronounced rough", "rugged strong bold",
              "deep heavy", "dramatic", "extreme"]  # fmt: skip
    assert sorted(" ".join(groups).split()) == sorted(AMOUNTS)
    assert rising(groups, lambda word: wish(f"{word} bricks").amount)
    assert wish("moderate bricks").amount == 1.0


@pytest.mark.parametrize("prompt", ["tiny huge bricks", "tight wide bricks", "subtle extreme bricks"])
def test_opposite_words_undo_each_other(prompt):
    assert (wish(prompt).size, wish(prompt).amount) == pytest.approx((1.0, 1.0))


def test_degrees_rise_from_the_root_by_the_word_alone_to_the_square():
    power = {word: wish(f"{word} large bricks").size for word in DEGREES}
    large = wish("large bricks").size
    assert rising(["slightly", "somewhat"], power.get)
    assert power["somewhat"] < large < power["quite"]
    assert rising(["quite", "very really", "super", "extremely"], power.get)
    assert power["slightly"] == pytest.approx(large**0.5)
    assert power["extremely"] == pytest.approx(large**2)
    assert power["somewhat"] / power["slightly"] < large / power["somewhat"]  # nearer to "slightly" than to the word alone
    assert power["quite"] / large < power["very"] / power["quite"]  # nearer to the word alone than to "very"


def test_shades_rise_from_dark_to_pale_and_no_two_look_alike():
    own = {word: wish(f"{word} brick").shade for word in ("dark", "bright", "light", "pale")}
    assert rising(own, own.get)
    assert own["dark"] < 1.0 < own["bright"]
    assert own["pale"] / own["light"] < own["light"] / own["bright"]  # pale is a little more than light
    blue = {word: sum(wish(f"{word} blue brick").colour) for word in ("dark", "deep", "bright", "light", "pale")}
    blue[""] = sum(wish("blue brick").colour)
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
    assert (wish(prompt).size, wish(prompt).amount) == (size, amount)


def test_a_wish_is_not_changed_by_those_who_read_it():
    with pytest.raises(AttributeError):
        wish("brick").style = "stone"


def test_colour_words_colour_and_shade_words_belong_to_the_colour_after_them():
    blue = wish("blue bricks").colour
    assert blue == pytest.approx((0x2F / 255, 0x5F / 255, 0xA8 / 255))
    deep = wish("deep blue bricks")
    assert deep.amount == 1.0
    assert sum(deep.colour) < sum(blue) < sum(wish("light blue bricks").colour)
    assert wish("bricks").colour is None
    assert wish("bricks in deep blue") == deep
    assert wish("blue bricks, dark") == wish("dark blue bricks")


def test_a_plural_of_three_letters_is_read_and_what_two_would_be_left_of_is_not():
    assert wish("bricks in reds") == wish("bricks in red")
    assert notes("bricks with toes") == tuple(text for text in notes("bricks with toes") if "left out: 'toes'" in text)  # not "to"


def test_a_shade_without_a_colour_is_one_of_the_style_s_own_colours():
    assert wish("rough dark brick") == Wish("brick", amount=AMOUNTS["rough"], shade=0.55)
    assert wish("light knitted wool").shade > 1.0
    assert wish("deep brick") == Wish("brick", amount=AMOUNTS["deep"])
    assert wish("brick, dark") == Wish("brick", shade=0.55)
    assert wish("brick, deep") == wish("deep brick")
    assert wish("dark blue brick").shade == 1.0  # the blue is dark already


def test_the_combinations_people_ask_for():
    assert wish("small blue fish scales") == Wish("fish_scales", size=SIZES["small"], colour=wish("blue brick").colour)
    assert wish("mandala on mahogany") == Wish("mandala")
    assert notes("small blu fish scals") == ("read 'blu' as 'blue'", "read 'scals' as 'scale'")


def test_a_misspelt_word_beside_a_style_completes_its_phrase():
    assert wish("damascas steel").style == "damascus"
    assert wish("mandalla on wood").style == "mandala"


def test_green_is_a_style_alone_and_a_colour_beside_another_style():
    assert wish("green").colour is None
    assert wish("green bricks").style == "brick"
    assert wish("green bricks").colour is not None
    assert wish("dark green").style == "green"
    assert wish("dark green").colour is not None


def test_a_style_that_only_describes_gives_way_to_any_other():
    assert wish("old weathered brick").style == "brick"
    note, old = notes("old weathered brick")
    assert old == "left out: 'old'"
    assert note.startswith("one style at one place: took 'brick', left out 'weathered'")
    assert wish("old green").style == "realistic"
    assert wish("stripes and dots").style == "stripes"  # of two that describe, the first
    assert wish("weathered old").style == "weathered"
    assert wish("weathered").style == "weathered"


def test_only_the_first_style_counts_and_the_note_says_what_both_would_take():
    assert wish("brick and stone").style == "brick"
    both = "for both, give each its place, such as `outside: brick; rim: stone`"
    assert notes("brick and stone") == (f"one style at one place: took 'brick', left out 'stone'; {both}",)


def test_a_second_colour_is_that_of_the_recesses_and_a_third_is_left_out():
    three = wish("blue brick with red mortar and white joints")
    assert (three.colour, three.second) == (wish("blue brick").colour, wish("red brick").colour)
    assert any("left out 'white'" in note for note in notes("blue brick with red mortar and white joints"))
    assert wish("brick with red mortar").colour is None


def test_words_of_a_phrase_count_together_and_what_is_left_of_another_phrase_alone():
    assert wish("fish and dragon scales").style == "dragon_scales"  # words that stand together go first
    assert wish("scales of fish and dragon").style == "dragon_scales"
    assert wish("scales of brick and dragon").style == "dragon_scales"  # a phrase stands where it begins
    assert wish("mahogany wood").style == "wood"
    assert wish("mahogany wood").colour == wish("mahogany brick").colour is not None


def test_misspelt_colours_and_sizes_are_forgiven_too():
    misspelt = wish("smal bricks in turqoise")
    assert (misspelt.size, misspelt.colour) == (SIZES["small"], wish("turquoise bricks").colour)
    assert notes("smal bricks in turqoise") == ("read 'smal' as 'small'", "read 'turqoise' as 'turquoise'")


@pytest.mark.parametrize(
    ("typed", "meant", "slip"),
    [("brik", "brick", True), ("birck", "brick", True), ("bricck", "brick", True), ("brock", "brick", False), ("trick", "brick", False),
     ("marvle", "marble", True), ("damaskus", "damascus", True), ("feather", "leather", False), ("in", "ivy", False)],
)  # fmt: skip
def test_a_slip_of_a_typist_is_forgiven_where_it_makes_no_other_word(typed, meant, slip):
    assert words._slips(typed, meant) is slip


def test_words_not_understood_are_reported_together_in_one_line():
    assert notes("bricks on the moon, quietly, for my aunt") == ("left out: 'moon', 'quietly', 'aunt'",)


def test_a_word_near_a_style_does_not_compete_with_a_style_spelt_out():
    assert wish("brick store") == Wish("brick")
    assert "'store'" in notes("brick store")[0]


def test_a_word_only_somewhat_like_a_size_is_none():
    assert wish("stall bricks") == Wish("brick")
    assert "'stall'" in notes("stall bricks")[0]


def test_where_places_meet_a_place_that_only_gets_a_colour_keeps_the_style_and_its_measures():
    everywhere, rim = read("small 0.6 mm deep brick with a gold rim").wishes
    assert rim == msgspec.structs.replace(everywhere, colour=rgb_of("gold"), where=(Rim(),))
    plain = read("brick; rim: plain gold").wishes[1]
    assert plain == Wish("", colour=rgb_of("gold"), where=(Rim(),))


def rgb_of(word):
    return tuple(int(COLOURS[word][k : k + 2], 16) / 255 for k in (0, 2, 4))


def test_places_are_the_regions_that_can_be_protected():
    found = read("outside: brick; top 20 mm and rim: stone; box 0 0 0 10 20 30: wood; rest: knit but not inside").wishes
    assert [wish.where for wish in found] == [(Outside(),), (End("top", 20.0), Rim()), (Box((0, 0, 0), (10, 20, 30)),), ()]
    assert found[3].spared == (Inside(),)


def test_a_region_that_cannot_be_is_refused_as_where_it_is_protected():
    with pytest.raises(BadInput, match="first corner that is lower"):
        read("box 10 0 0 0 20 30: brick")


@pytest.mark.parametrize(
    "prompt", ["outside: brick; rim: studs", "everywhere but not rim: wood", "top 20 and inside: brick, features of 5 mm, relief of 0.6 mm"]
)
def test_how_a_prompt_was_read_can_be_typed_as_a_prompt(prompt):
    assert read(prompt).words == prompt
    assert not notes(prompt)


def test_a_prompt_of_more_than_500_characters_is_refused_shortly():
    assert wish("brick " * 83).style == "brick"
    with pytest.raises(BadInput, match="has 60000 characters, but may have 500") as refusal:
        read("brick " * 10_000)
    assert len(str(refusal.value)) < 120


@pytest.mark.parametrize("prompt", ["very small", "3d", "iv", "my own idea", "sleepy", "Steve Jobs"])
def test_a_prompt_without_a_style_is_refused_and_never_replaced(prompt):
    with pytest.raises(BadInput, match="names no style") as refusal:
        read(prompt)
    text = str(refusal.value)
    assert repr(prompt) in text
    assert "guidance 'clip' (`--guidance clip`)" in text
    assert "`mechstyle weights fetch ViT-B-32`" in text
    assert "\n" not in text
    assert len(text) < 300


@pytest.mark.parametrize("prompt", ["", "   "])
def test_an_empty_prompt_is_refused(prompt):
    with pytest.raises(BadInput, match="the prompt is empty: say in words what the part is to look like, or give a picture"):
        read(prompt)


@pytest.mark.parametrize(
    ("prompt", "among"),
    [("my saxophone", "wood"), ("a glider", "panels"), ("a waistcoat", "knit"), ("my nephew", "leather"), ("a diskette", "studs")],
)
def test_a_refusal_names_three_styles_that_come_near_what_was_meant(prompt, among):
    near = suggestions(prompt)
    assert len(set(near)) == 3
    assert set(near) <= set(names())
    with pytest.raises(BadInput) as refusal:
        read(prompt)
    assert ", ".join(repr(name.replace("_", " ")) for name in near) in str(refusal.value)


@pytest.mark.parametrize(
    ("colour", "said"), [("blue", "`blue brick`"), ("dark red", "`red brick`"), ("purple and white", "`purple brick`")]
)
def test_a_colour_alone_is_called_one_and_gets_a_style_to_go_with_it(colour, said):
    with pytest.raises(BadInput, match=f"only a colour and no style: try {said}"):
        read(colour)


def test_suggestions_are_always_as_many_as_asked_for():
    assert len(set(suggestions("", 3))) == 3
    assert len(set(suggestions("a dragon in a castle by the sea with a violin", 5))) == 5


def test_no_word_means_two_things():
    looks = {*styles(), *COLOURS, *(weak().keys() - english().keys())}  # terracotta is a stuff and a colour
    found = [word for table in (SIZES, AMOUNTS, FILLERS, looks) for word in table]
    assert len(found) == len(set(found))


# --- a picture of the user's ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("prompt", "words"),
    [
        ("", "picture"),
        ("picture", "picture"),
        ("my logo", "picture"),
        ("Bild", "picture"),
        ("gold", "picture, in #c99a2e"),
        ("0.8 mm deep", "picture, relief of 0.8 mm"),
        ("20 mm picture", "picture, features of 20 mm"),
        ("only the top", "top: picture"),
        ("outside: picture; rim: gold studs", "outside: picture; rim: studs, in #c99a2e"),
        ("outside: photo; rim: plain gold", "outside: picture; rim: plain, in #c99a2e"),
        ("brick; front: picture", "everywhere: brick; front: picture"),
        ("außen: Bild; Rand: Ziegel", "outside: picture; rim: brick"),
    ],
)
def test_with_a_picture_a_prompt_says_where_it_goes_and_in_what_colour(prompt, words):
    assert read(prompt, picture=True).words == words


@pytest.mark.parametrize("prompt", ["brick", "outside: brick; rim: gold"])
def test_a_prompt_that_leaves_a_picture_out_is_refused(prompt):
    with pytest.raises(BadInput, match="but not the picture"):
        read(prompt, picture=True)


def test_without_a_picture_a_prompt_for_one_says_how_to_give_it():
    with pytest.raises(BadInput, match="--image"):
        read("a picture of mine")
    assert any("--image" in note for note in read("brick with my logo").notes)
