"""Words that no table has, by their meaning: only where an encoder is, only where it is sure, and never over what the reader knows."""

import sys
from importlib.util import find_spec
from types import SimpleNamespace

import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.runs.recipes import recipe_for
from mechstyle.styling import meaning
from mechstyle.styling import prompt as reader
from mechstyle.styling.prompt import read, suggestions

ENCODER = find_spec(meaning.MODULE)  # before the tables are tested without it
AXES = {"brick": 0, "moss": 1, "waves": 2, "rombos": 3}
LIKENESS = {
    "цегляна стіна": ("brick", 0.95),
    "ромбы": ("rombos", 0.95),
    "τοίχος": ("moss", 0.9),
    "ωκεανός": ("waves", 0.5),
    "brik": ("moss", 0.99),
    "qwerty brick": ("moss", 0.99),
}


def encode(texts):
    """A sentence encoder in four dimensions and one for all other texts."""
    vectors = np.zeros((len(texts), 6))
    for vector, text in zip(vectors, texts, strict=True):
        word, likeness = (text, 1.0) if text in AXES else LIKENESS.get(text, ("", 0.0))
        vector[AXES.get(word, 4 if text in LIKENESS else 5)] = likeness
        vector[4] += np.sqrt(1.0 - likeness**2) if text in LIKENESS else 0.0
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
    for prompt, style in (("цегляна стіна", "brick"), ("τοίχος", "moss")):
        reading = read(prompt)
        assert [wish.style for wish in reading.wishes] == [style]
        assert reading.notes == (f"read {prompt!r} as {style} by its meaning",)
        settled = recipe_for(prompt).style.prompt  # of the recipe, which machines without an encoder read as well
        assert settled == f"{prompt}, {style}"


@pytest.mark.usefixtures("encoder")
def test_words_that_are_not_surely_a_style_are_refused_with_what_comes_near():
    with pytest.raises(BadInput, match=r"names no style .*: try 'waves', "):
        read("ωκεανός")
    assert suggestions("ωκεανός")[0] == "waves"


@pytest.mark.usefixtures("encoder")
def test_what_the_reader_knows_is_never_overruled():
    assert [wish.style for wish in read("qwerty brick").wishes] == ["brick"]
    with pytest.raises(BadInput, match="only what is not"):
        read("not brick")


def test_between_two_styles_as_near_as_each_other_people_choose(monkeypatch):
    for module in (meaning, reader):
        monkeypatch.setattr(module, "nearest", lambda _: {"wood": 0.92, "bark": 0.91, "cork": 0.5})
    with pytest.raises(BadInput, match="try 'wood', 'bark', 'cork'"):
        read("φλοιός δέντρου")


@pytest.mark.usefixtures("encoder")
def test_a_word_is_compared_with_those_of_every_language():
    assert meaning.sure("ромбы") == "knurling"  # as rombos are, of the Spanish column


@pytest.mark.usefixtures("encoder")
def test_what_the_words_of_the_tables_mean_in_a_language_without_one_is_no_guess():
    for typed in ("marmorplatta för mig", "guldplatta för mig"):
        with pytest.raises(BadInput, match="no style"):
            read(typed)
    assert [wish.style for wish in read("brick för min mormor").wishes] == ["brick"]


@pytest.mark.usefixtures("encoder")
def test_embeddings_are_kept_and_a_damaged_file_is_made_again(tmp_path, monkeypatch):
    monkeypatch.setenv("MECHSTYLE_CACHE", str(tmp_path))
    first = meaning.nearest("τοίχος")
    (kept,) = tmp_path.glob("*.npy")
    kept.write_bytes(kept.read_bytes()[:100])
    meaning._known.cache_clear()
    assert meaning.nearest("τοίχος") == pytest.approx(first, abs=1e-3)
    assert len(np.load(kept)) == len(meaning._known()[0])


@pytest.mark.skipif(ENCODER is None, reason="the encoder of the extra `words` is not installed: nothing is measured")
def test_with_the_real_encoder_plain_words_of_other_languages_are_right_or_offered(monkeypatch):
    monkeypatch.delitem(sys.modules, meaning.MODULE)
    for words, style in (("шахматная доска", "checkers"), ("벽돌 벽", "brick"), ("romby", "knurling"), ("шахматы", "checkers")):
        assert style in [*meaning.nearest(words)][:3]
    assert meaning.sure("벽돌 벽") == "brick"


def test_without_an_encoder_the_words_are_refused():
    assert not meaning.nearest("τοίχος")
    assert not meaning.sure("τοίχος")
    with pytest.raises(BadInput, match="names no style in English"):
        read("τοίχος")
