"""The table of words of other languages: complete, without contradictions, and of use."""

import itertools

import pytest

from mechstyle.styling import words
from mechstyle.styling.languages import LANGUAGES, rows, words_of
from mechstyle.styling.library import names
from mechstyle.styling.prompt import read
from mechstyle.styling.vocabulary import COLOURS

TO_COME = {
    "art_deco", "bark", "brushed_metal", "bubbles", "cable_knit", "carbon_fibre", "celtic_knot", "concrete", "crystal", "dots", "feathers",
    "grid", "isogrid", "knurling", "low_poly", "moss", "quilting", "stripes", "topographic", "twill",
}  # fmt: skip
"""Styles that have a row, though the library may not have them yet."""
KEYS = [english for english, _ in rows()]


def test_every_style_has_a_row_in_every_language():
    missing = set(names()) - set(KEYS)
    assert not missing
    for english, others in rows():
        assert len(others) == len(LANGUAGES), english
        if english in {*names(), *TO_COME, *COLOURS} - {"gunmetal"}:
            assert all(others), english


def test_every_row_is_of_a_word_that_means_something():
    known = words.meanings() | {"not_before"} | TO_COME
    assert set(KEYS) <= known
    assert len(KEYS) == len(set(KEYS))


def test_every_colour_has_a_row_be_it_by_another_word():
    assert {COLOURS[word] for word in KEYS if word in COLOURS} == set(COLOURS.values())


@pytest.mark.parametrize("language", LANGUAGES)
def test_no_word_of_a_language_stands_for_two(language):
    column = LANGUAGES.index(language)
    written = [(words._folded(word), english) for english, others in rows() for word in others[column]]
    for (word, one), (same, other) in itertools.pairwise(sorted(written)):
        assert word != same or one == other, (word, one, other)


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("style", names())
def test_every_word_for_a_style_asks_for_it(language, style):
    for word in (word for word, english in words_of(language).items() if english == style):
        assert [wish.style for wish in read(word.replace("_", " ")).wishes] == [style], word


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_word_for_a_colour_asks_for_it_beside_a_style_of_that_language(language):
    brick = next(word for word, english in words_of(language).items() if english == "brick")
    for word, english in words_of(language).items():
        if english in COLOURS and english != "green":
            (wish,) = read(f"{brick} {word.replace('_', ' ')}").wishes
            digits = "".join(f"{round(255 * channel):02x}" for channel in wish.colour or ())
            assert (wish.style, digits) == ("brick", COLOURS[english]), word
