"""Kinds of prompts rather than prompts: each holds for every word of the table, or for words that no table was made for."""

import itertools

import pytest

from mechstyle.errors import BadInput
from mechstyle.styling import words
from mechstyle.styling.library import names
from mechstyle.styling.prompt import read, suggestions
from mechstyle.styling.vocabulary import COLOURS, METALS, english, rows, styles, weak

KINDS = {"style", "describes", "like", "thing"}
STYLES = [(word.replace("+", "_"), row) for row in rows("words") if row.kind in KINDS for word in row.words[0]]


def only(prompt):
    """The only wish of a prompt, and its notes."""
    reading = read(prompt)
    (wish,) = reading.wishes
    return wish, reading.notes


def test_the_table_has_fifteen_hundred_ideas_and_english_brings_as_many_more():
    assert len({word for word, _ in STYLES}) >= 1500
    assert len(weak().keys() & english().keys()) >= 1500


def test_every_word_and_phrase_of_the_table_asks_for_its_style_whatever_its_parts_mean():
    for word, row in STYLES:
        wish, notes = only(word.replace("_", " "))
        assert wish.style == (styles().get(word) or weak()[word]).style, word
        assert not any(note.startswith("left out") for note in notes), word
        if row.kind == "style":
            assert not notes, word


@pytest.mark.parametrize(
    ("prompt", "style"),
    [("lego brick", "studs"), ("diamond plate steel", "diamond_plate"), ("tree rings", "wood"), ("a cow print vase", "giraffe"),
     ("orange peel", "dots"), ("water lily", "floral"), ("corrugated iron", "corrugated"), ("sea urchins", "spikes")],
)  # fmt: skip
def test_a_phrase_goes_before_its_words(prompt, style):
    wish, _ = only(prompt)
    assert wish.style == style


MATERIALS = (("brick", "brick"), ("wooden", "wood"), ("knitted", "knit"), ("marble", "marble"))
THINGS = ("teapot", "submarine", "wombat", "lantern")  # a thing in words.tsv, in english.tsv, in neither
PARTS = ("gold eyes", "a black door", "pale green buttons", "two dark red wheels", "silver teeth")


@pytest.mark.parametrize(("material", "thing", "part"), list(itertools.product(MATERIALS, THINGS, PARTS)))
def test_a_colour_goes_with_its_noun_and_both_are_left_out_in_one_line(material, thing, part):
    word, style = material
    wish, notes = only(f"a {word} {thing} with {part}")
    assert (wish.style, wish.colour, wish.second, wish.shade) == (style, None, None, 1.0)
    (note,) = notes
    assert note.startswith("left out: ")
    assert all(text in note for text in (*part.removeprefix("a ").removeprefix("two ").split(), thing))


@pytest.mark.parametrize("part", ["marble eyes", "black stone ears", "wooden wheels and leather straps", "a golden crown"])
def test_a_stuff_of_a_part_is_not_that_of_the_whole(part):
    assert only(f"knitted wombat with {part}")[0].style == "knit"
    gold, notes = only(f"a gold wombat with {part}")
    assert (gold.style, gold.colour) == ("hammered", only("gold knit")[0].colour)
    assert notes[0] == "read 'gold' as hammered gold"


@pytest.mark.parametrize(
    "prompt",
    ["Ziegelhaus mit einer schwarzen Lampe", "maison en brique avec une lampe noire", "casa de ladrillo con una lámpara negra",
     "casa de tijolo com uma janelinha preta", "casa di mattoni con una lampada nera"],
)  # fmt: skip
def test_a_colour_goes_with_its_noun_in_other_languages(prompt):
    wish, _ = only(prompt)
    assert (wish.style, wish.colour) == ("brick", None)


@pytest.mark.parametrize("prompt", ["a kettle with wooden knobs", "a submarine standing on bricks", "my gearbox with leather straps"])
def test_what_is_said_of_a_part_counts_where_nothing_is_said_of_the_whole(prompt):
    assert only(prompt)[0].style in {"wood", "brick", "leather", "hammered", "brushed_metal"}


def test_a_colour_of_the_thing_itself_is_that_of_the_style_and_a_thing_has_its_own_without():
    assert only("a yellow brick wombat")[0].colour == only("yellow brick")[0].colour
    ladybird, notes = only("a ladybird")
    assert (ladybird.style, ladybird.colour) == ("dots", only("red dots")[0].colour)
    assert notes == ("read 'ladybird' as red dots",)
    assert only("a blue ladybird")[0].colour == only("blue dots")[0].colour


@pytest.mark.parametrize("stuff", ["brick", "crochet", "knurling", "striped", "old weathered", "fiery"])
@pytest.mark.parametrize("thing", ["cat", "owl", "dragon", "castaway", "gecko"])
def test_a_thing_yields_to_whatever_is_named_beside_it(stuff, thing):
    assert only(f"{stuff} {thing}")[0].style == only(stuff)[0].style


@pytest.mark.parametrize("thing", ["an owl", "a hedgehog", "a shark"])
@pytest.mark.parametrize("use", ["bottle holder", "window box", "a cabinet that looks", "phone stand shaped"])
def test_what_something_is_to_be_like_goes_before_what_it_is(use, thing):
    assert only(f"{use} like {thing}")[0].style == only(thing)[0].style
    assert only(f"{thing} made of cardboard")[0].style == only("robot made of cardboard")[0].style == only("cardboard")[0].style


@pytest.mark.parametrize("wearer", ["a soldier", "an image of a wombat", "my castle"])
@pytest.mark.parametrize("costume", ["astronaut suit", "robot costume", "zebra outfit"])
def test_what_something_is_dressed_as_goes_before_what_it_is(wearer, costume):
    assert only(f"{wearer} in a {costume}")[0].style == only(costume.split()[0])[0].style


@pytest.mark.parametrize("metal", sorted(METALS))
def test_a_metal_alone_is_hammered_and_beside_a_style_a_colour(metal):
    spoken = metal.replace("_", " ")
    assert only(spoken)[0].style == only(f"{spoken} otter")[0].style == only(f"an otter made of {spoken}")[0].style == "hammered"
    beside, notes = only(f"{spoken} honeycomb")
    assert (beside.style, beside.colour, notes) == ("honeycomb", only(f"{spoken} brick")[0].colour, ())


COMMON = [word for row in rows("english") if row.kind != "thing" for word in row.words[0] if len(word) >= 4]


@pytest.mark.parametrize("start", range(4))
def test_no_letter_of_an_english_word_is_mended(start):
    for word in COMMON[start::60]:
        _, notes = words.words_read(word)
        assert not notes, word


@pytest.mark.parametrize("word", ["fire", "face", "river", "three", "grove", "pants", "trick", "brink", "bread", "marvel", "later"])
def test_what_looks_like_a_slip_and_is_a_word_is_no_style_by_its_letters(word):
    assert not words.words_read(f"a {word}")[1]
    assert only(f"a wooden {word}")[0].style == "wood"


@pytest.mark.parametrize("style", ["honeycomb", "knurling", "terracotta", "leather", "crochet", "carbon", "marble"])
def test_a_slip_that_makes_no_word_is_mended_and_shown(style):
    for at in range(1, len(style) - 1):
        slip = style[:at] + style[at + 1 :]
        if slip not in english():
            wish, notes = only(f"{slip} owl")
            assert wish.style == only(style)[0].style, slip
            assert any(note.startswith(f"read {slip!r} as ") for note in notes), slip


@pytest.mark.parametrize(
    ("typed", "style"),
    [("leapord", "leopard"), ("mabrle", "marble"), ("cammoflage", "camouflage"), ("topografic", "topographic"),
     ("herrinbgone", "herringbone"), ("wheathered", "weathered"), ("hexigonel", "honeycomb"), ("croccodyle", "dragon_scales")],
)  # fmt: skip
def test_letters_in_another_order_and_two_slips_in_a_long_word_are_mended_and_shown(typed, style):
    wish, notes = only(f"{typed} vase")
    assert wish.style == style
    assert any(note.startswith(f"read {typed!r} as ") for note in notes)


@pytest.mark.parametrize("word", ["charlatan", "marathon", "terraforming", "monstera", "wavelength", "Mississippi", "Alexander"])
def test_a_long_word_that_is_not_one_of_the_table_is_not_made_one(word):
    assert not any(note.startswith("read ") for note in words.words_read(word)[1])


@pytest.mark.parametrize("word", ["burger", "fog", "dad", "mole", "pine", "corner", "pal", "ran"])
def test_a_word_that_english_has_is_no_stem_of_another_language(word):
    assert not words.language_of([word])


@pytest.mark.parametrize("stuff", ["moss", "brick", "stone", "ocean", "walnut", "concrete", "denim", "glacier"])
def test_a_stuff_before_a_colour_beside_another_style_says_which_colour(stuff):
    wish, notes = only(f"{stuff} green cable knit vase")
    assert (wish.style, wish.colour, notes) == ("cable_knit", only("green brick")[0].colour, ())
    assert only(f"{stuff} green vase")[0].style == only(stuff)[0].style


@pytest.mark.parametrize(
    ("prompt", "style"),
    [("barn owl", "feathers"), ("house cat", "fur"), ("sea lion", "fur"), ("mountain lion", "fur"), ("zebra finch", "feathers"),
     ("butterfly fish", "fish_scales"), ("oak tree bark", "bark"), ("rooster comb", "feathers")],
)  # fmt: skip
def test_the_name_of_an_animal_or_plant_is_not_read_by_its_first_word(prompt, style):
    assert only(prompt)[0].style == style


MOODS = [(word, row.value.split()[0]) for row in rows("words") if row.kind == "mood" for word in row.words[0]]


@pytest.mark.parametrize(("word", "style"), MOODS, ids=[word for word, _ in MOODS])
def test_a_mood_asks_for_a_style_only_where_nothing_else_does(word, style):
    spoken = word.replace("_", " ")
    wish, notes = only(f"something {spoken}")
    assert wish.style == style
    assert any(note.startswith(f"read {spoken!r} as ") for note in notes)
    assert only(f"{spoken} owl")[0].style == "feathers"
    assert only(f"{spoken} brick vase")[0].style == "brick"


@pytest.mark.parametrize("prompt", ["цегляна стіна", "τούβλο", "žulová dlaždice"])
def test_a_prompt_of_no_known_word_is_refused_with_the_languages_that_are_read(prompt):
    with pytest.raises(BadInput, match=r"names no style in English or one of 12 other languages"):
        read(prompt)


@pytest.mark.parametrize("row", [row for row in rows("english") if row.kind == "hint"], ids=lambda row: row.words[0][0])
def test_what_no_style_is_like_gets_three_suggestions_that_come_near(row):
    unread = [word for word in row.words[0] if not words.words_read(word)[0][0].means]
    for word in unread[:: max(len(unread) // 3, 1)]:
        near = suggestions(f"my {word}")
        assert near[0] == row.value.split()[0], word
        assert len(set(near)) == 3
        assert set(near) <= set(names())
        with pytest.raises(BadInput) as refusal:
            read(f"my {word}")
        assert all(name.replace("_", " ") in str(refusal.value) for name in near)


def test_the_tables_name_styles_of_the_library_and_colours():
    assert {row.value.split()[0] for _, row in STYLES} == set(names())
    assert {name for near in english().values() for name in near} <= set(names())
    tints = {colour for _, row in STYLES for colour in row.value.partition(" ")[2].split("/") if colour}
    assert tints <= COLOURS.keys()


def test_a_hyphen_joins_what_is_no_word_alone():
    for prompt in ("U-Boot", "sous-marin"):  # no boot, and nothing of that blue
        assert only(prompt)[0].style == "panels"
    assert only("coquille Saint-Jacques")[0].style == "fluted"  # of a phrase each is a word
    assert only("a moss-covered wall")[0].style == "moss"


def test_a_word_without_its_dots_is_no_german_one():
    assert only("koper")[0].style == "hammered"  # Dutch for copper
    assert only("Köper")[0].style == only("Koeper")[0].style == "twill"


@pytest.mark.parametrize(
    ("prompt", "style"),
    [("rieten mand", "basket_weave"), ("деревянную", "wood"), ("plaster miodu 6 mm", "honeycomb"), ("kamienny mur", "stone"),
     ("tuğla duvar", "brick"), ("용의 비늘", "dragon_scales"), ("vissen schubben", "fish_scales"), ("knurled steel", "knurling"),
     ("dentelle", "crochet")],
)  # fmt: skip
def test_other_languages_are_read_with_their_endings_and_a_stuff_yields_to_what_describes_it(prompt, style):
    assert only(prompt)[0].style == style


def test_an_english_thing_in_a_prompt_of_another_language_is_offered_and_not_taken():
    with pytest.raises(BadInput, match="try 'quilting'"):
        read("ein Geschenk für den Chef")
