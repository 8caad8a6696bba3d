"""Words that no table has, by their meaning: only where an encoder is, only where it is sure, and never over what the reader knows."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.runs.recipes import draft
from mechstyle.styling import meaning
from mechstyle.styling.prompt import read, suggestions

AXES = {"brick": 0, "moss": 1, "waves": 2}
LIKENESS = {
    "кирпичная стена": ("brick", 0.95),
    "мох": ("moss", 0.9),
    "океан": ("waves", 0.5),
    "brik": ("moss", 0.99),
    "qwerty brick": ("moss", 0.99),
}


def encode(texts):
    """A sentence encoder in three dimensions and one for all other texts."""
    vectors = np.zeros((len(texts), 5))
    for vector, text in zip(vectors, texts, strict=True):
        word, likeness = (text, 1.0) if text in AXES else LIKENESS.get(text, ("", 0.0))
        vector[AXES.get(word, 3 if text in LIKENESS else 4)] = likeness
        vector[3] += np.sqrt(1.0 - likeness**2) if text in LIKENESS else 0.0
    return vectors


@pytest.fixture
def encoder(monkeypatch):
    """The package of the extra, with weights that are known."""
    model = lambda **_: SimpleNamespace(encode=encode)  # noqa: E731
    monkeypatch.setitem(sys.modules, meaning.MODULE, SimpleNamespace(USE=model, __spec__=object()))
    for cached in (meaning._encoder, meaning._known):
        cached.cache_clear()
    yield
    for cached in (meaning._encoder, meaning._known):
        cached.cache_clear()


@pytest.mark.usefixtures("encoder")
def test_words_that_surely_mean_a_style_are_read_as_it_and_the_note_says_so():
    for prompt, style in (("кирпичная стена", "brick"), ("мох", "moss")):
        reading = read(prompt)
        assert [wish.style for wish in reading.wishes] == [style]
        assert reading.notes == (f"read {prompt!r} as {style} by its meaning",)
        settled = draft(prompt).style.prompt  # of the recipe, which machines without an encoder read as well
        assert settled == f"{prompt}, {style}"


@pytest.mark.usefixtures("encoder")
def test_words_that_are_not_surely_a_style_are_refused_with_what_comes_near():
    with pytest.raises(BadInput, match=r"names no style .*: try 'waves', "):
        read("океан")
    assert suggestions("океан")[0] == "waves"


@pytest.mark.usefixtures("encoder")
def test_what_the_reader_knows_is_never_overruled():
    assert [wish.style for wish in read("qwerty brick").wishes] == ["brick"]
    with pytest.raises(BadInput, match="only what is not"):
        read("not brick")


def test_without_an_encoder_the_words_are_refused():
    assert not meaning.nearest("мох")
    assert not meaning.sure("мох")
    with pytest.raises(BadInput, match="names no style in English"):
        read("мох")
