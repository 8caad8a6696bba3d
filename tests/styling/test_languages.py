"""The table of words of other languages: complete, without contradictions, and of use."""

import itertools

import pytest

from mechstyle.styling import words
from mechstyle.styling.library import names
from mechstyle.styling.prompt import read
from mechstyle.styling.vocabulary import COLOURS, LANGUAGES, meanings, rows, styles, words_of

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
    written = [(words._folded(word), row.words[0][0]) for row in ROWS for word in row.words[column]]
    for (word, one), (same, other) in itertools.pairwise(sorted(written)):
        assert word != same or one == other, (word, one, other)


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_word_for_a_style_asks_for_it(language):
    others = [words_of(other) for other in LANGUAGES if other != language]
    for word, english in words_of(language).items():
        shared = word.lower() in meanings() or any(other.get(word, english) != english for other in others)  # llama, seta
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
