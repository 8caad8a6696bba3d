"""The table of words of other languages: complete, without contradictions, and of use."""

import itertools
from pathlib import Path

import pytest

from mechstyle.errors import BadInput
from mechstyle.styling import words
from mechstyle.styling.library import names
from mechstyle.styling.prompt import read
from mechstyle.styling.vocabulary import COLOURS, LANGUAGES, SPACED, meanings, rows, small_words_abroad, styles, weak, words_of

ROWS = [row for row in rows("words") if any(row.words[1:])]


def test_every_style_of_the_library_has_words_in_every_language():
    spoken = {row.value for row in ROWS if row.kind in {"style", "describes", "last"} and all(row.words)}
    assert set(names()) <= spoken


def test_the_three_hundred_commonest_ideas_have_words_in_nearly_every_language():
    assert sum(sum(map(bool, row.words)) >= 6 for row in ROWS) >= 290
    assert len({row.words[0][0] for row in ROWS}) == len(ROWS)


@pytest.mark.parametrize("language", LANGUAGES)
def test_no_word_of_a_language_stands_for_two(language):
    column = 1 + LANGUAGES.index(language)
    written = [(words._bare(words._typed(word)), row.words[0][0]) for row in ROWS for word in row.words[column]]
    for (word, one), (same, other) in itertools.pairwise(sorted(written)):
        assert word != same or one == other, (word, one, other)


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_word_for_a_style_asks_for_it(language):
    others = [{word.lower(): means for word, means in words_of(other).items()} for other in LANGUAGES if other != language]
    for word, english in words_of(language).items():
        shared = word.lower() in meanings() or any(other.get(word.lower(), english) != english for other in others)  # llama, seta
        if english in styles() and not shared:
            assert [wish.style for wish in read(word.replace("_", " ")).wishes] == [styles()[english].style], word


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_word_for_a_colour_asks_for_it_beside_a_style_of_that_language(language):
    brick = next(word for word, english in words_of(language).items() if english == "brick")
    for word, english in words_of(language).items():
        if english in COLOURS and english != "green":
            (wish,) = read(f"{brick} {word.replace('_', ' ')}").wishes
            digits = "".join(f"{round(255 * channel):02x}" for channel in wish.colour or ())
            assert (wish.style, digits) == ("brick", COLOURS[english]), word


COMMON = dict(
    line.split(": ", 1) for line in Path(__file__).with_name("common_words.txt").read_text("utf-8").splitlines() if line[0] != "#"
)


def becomes(prompt):
    """The styles of a prompt, none if it is refused."""
    try:
        return [wish.style for wish in read(prompt).wishes]
    except BadInput:
        return []


@pytest.mark.parametrize("language", COMMON)
def test_a_common_word_becomes_a_style_only_where_the_tables_list_it_as_a_thing_that_looks_so(language):
    """Not by its letters without accents, its ending, a slip of the typist, or what another language than English has it for."""
    listed = {words._typed(word) for word, english in words_of(language).items()} if language != "English" else set()
    listed |= {*styles(), *weak()}
    common = COMMON[language].split()
    assert len(set(common)) >= 250
    assert [word for word in common if words._typed(word) not in listed and becomes(word)] == []


def test_no_small_word_of_a_language_without_a_table_becomes_a_style():
    """Swedish «och» was cable knit, by the Spanish word for it without its ending."""
    small = small_words_abroad()
    assert len(small) > 350
    assert [word for word in small if word != "jako" and any(word in words._dictionary(language) for language in ("", *SPACED))] == []
    assert [word for word in small if becomes(word)] == []


@pytest.mark.parametrize(
    ("prompt", "means"),
    [("tegel och sten", "tiles and stone"), ("tegel og sten", "tiles and stone"), ("sten utan mos", "stone without moss"),
     ("brick med moss", "brick with moss"), ("brick tanpa moss", "brick without moss")],
)  # fmt: skip
def test_a_small_word_joins_and_denies_in_languages_without_a_table_too(prompt, means):
    assert (read(prompt).words, len(read(prompt).notes)) == (read(means).words, len(read(means).notes))


@pytest.mark.parametrize(
    "prompt",
    ["verroest staal", "roestig staal", "verrosteter Stahl", "rostiges Metall", "acier rouillé", "acero oxidado", "hierro oxidado",
     "acciaio arrugginito", "aço enferrujado", "zardzewiała stal", "ржавая сталь", "paslı çelik", "녹슨 강철", "錆びた鋼", "生锈的钢"],
)  # fmt: skip
def test_rusty_steel_has_the_colour_of_rust_in_every_language(prompt):
    assert (read(prompt).words, read(prompt).notes) == (read("rusty steel").words, ())


@pytest.mark.parametrize(
    "prompt",
    ["Vase für Oma", "Ständer für mein Handy", "boîte à bijoux pour ma mère", "tapa de frasco", "for my father", "un cadeau pour mon père",
     "tampa de frasco", "un regalo para mi madre", "un regalo per mio padre", "手机支架", "给妈妈的礼物", "母への贈り物"],
)  # fmt: skip
def test_a_sentence_of_small_words_and_things_without_a_look_is_refused(prompt):
    assert becomes(prompt) == []
