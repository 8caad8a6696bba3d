import pytest

from mechstyle.errors import BadInput
from mechstyle.styling.library import library, names
from mechstyle.styling.prompt import AMOUNTS, COLOURS, FILLERS, SIZES, Wish, read


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


def test_colour_words_colour_and_shade_words_belong_to_the_colour_after_them():
    blue = read("blue bricks").colour
    assert blue == pytest.approx((0x2F / 255, 0x5F / 255, 0xA8 / 255))
    deep = read("deep blue bricks")
    assert deep.amount == 1.0
    assert sum(deep.colour) < sum(blue) < sum(read("light blue bricks").colour)
    assert read("bricks").colour is None


def test_a_shade_without_a_colour_is_one_of_the_style_s_own_colours():
    assert read("rough dark brick") == Wish("brick", amount=AMOUNTS["rough"], shade=0.55)
    assert read("light knitted wool").shade > 1.0
    assert read("deep brick") == Wish("brick", amount=AMOUNTS["deep"])
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


def test_only_the_first_style_and_colour_count_and_notes_say_so():
    wish = read("brick and stone in blue or red")
    assert wish.style == "brick"
    assert wish.colour == read("blue brick").colour
    assert wish.notes == ("one style at a time: took 'brick', left out 'stone'", "one colour at a time: took 'blue', left out 'red'")


def test_words_of_a_phrase_count_together_and_what_is_left_of_another_phrase_alone():
    wish = read("fish and dragon scales")
    assert wish.style == "fish_scales"
    assert wish.notes == ("one style at a time: took 'fish_scales', left out 'dragon_scales'",)
    assert read("mahogany wood").style == "wood"
    assert read("mahogany wood").colour == read("mahogany brick").colour is not None


def test_every_word_of_a_phrase_means_something_alone():
    phrases = [word for style in library().values() for word in (style.name, *style.words) if "_" in word]
    assert phrases
    for part in {part for phrase in phrases for part in phrase.split("_")}:
        assert part in COLOURS or read(part).style in names()


def test_misspelt_colours_and_sizes_are_forgiven_too():
    wish = read("smal bricks in turqoise")
    assert (wish.size, wish.colour) == (SIZES["small"], read("turquoise bricks").colour)
    assert wish.notes == ("read 'smal' as 'small'", "read 'turqoise' as 'turquoise'")


def test_words_not_understood_are_reported_together():
    assert read("bricks on the moon, quietly").notes == ("not understood and left out: 'moon', 'quietly'",)


def test_a_word_near_a_style_does_not_compete_with_a_style_spelt_out():
    assert read("brick store").style == "brick"


@pytest.mark.parametrize("prompt", ["mahogany zebra", "zebra", "", "   ", "blue", "very small", "3d"])
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


def test_no_word_means_two_things():
    tables = [SIZES, AMOUNTS, COLOURS, FILLERS]
    words = [word for table in tables for word in table]
    named = {word for style in library().values() for word in (style.name, *style.words)}
    assert not named & {*SIZES, *AMOUNTS, *FILLERS}
    assert len(words) == len(set(words))
