"""What the words of a prompt mean: `words.tsv`, an idea a row in thirteen languages, and `english.tsv`, what English words come near.

`abroad.tsv` has small words of languages that no other table has, so that none of them is taken for a word of another one.

A row of `words.tsv` has a kind, a value and the words for it; the first English one stands for them all. "_" joins words that mean it only
next to each other, "+" those that do so in any order. The kinds of rows and their values:

    style, describes  a style: any other beside one that describes is the one meant ("old brick")
    like              a stuff or thing that looks like a style, which the reader is shown; yields as well
    thing             a thing that looks like one, if nothing else in the prompt does
    mood              a mood, a season or a time, if nothing else names a style
    last              a style, if there is no thing either: "green", "realistic"
    colour, metal     six hexadecimal digits; a metal alone is hammered metal
    size, relief      factors on the size of features and on the height of the relief
    shade, degree     how light (below 1 darker); power of the factor of the word that follows
    mm                length of a unit [mm]
    place             first word of the notation of a region
    beyond            what a drawn style cannot do, and what it would take
    others            words of grammar, by what they do

After a style may stand the colours of a thing, of its body and of its recesses: `stripes yellow/black` is a wasp.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from importlib.resources import files
from typing import NamedTuple

from mechstyle.records.regions import ENDS
from mechstyle.styling import picture

LANGUAGES = (
    "German",
    "French",
    "Spanish",
    "Portuguese",
    "Italian",
    "Chinese",
    "Japanese",
    "Dutch",
    "Polish",
    "Russian",
    "Turkish",
    "Korean",
)
"""The columns of `words.tsv` after the English words."""
SPACED = tuple(language for language in LANGUAGES if language not in {"Chinese", "Japanese"})
"""Those that write spaces between words."""
PICTURE = "own picture"
"""What stands for a picture of the user's where there is one; no word of a prompt has a space."""
_STYLES = ("style", "describes", "like", "thing", "mood", "last")  # kinds of rows, strongest first


class Row(NamedTuple):
    """A row of a table: its kind, its value, and the words for it in English and in each of LANGUAGES."""

    kind: str
    value: str
    words: tuple[tuple[str, ...], ...]


class Meaning(NamedTuple):
    """What a word says about the style."""

    style: str  # name of a style of the library
    rank: int  # how strong the word is: 0 names it, larger numbers yield to smaller ones
    near: bool = False  # whether the word only comes near the style
    colours: tuple[str, ...] = ()  # words for the colours of what it means, of its body and of its recesses; none for the style's own

    @property
    def words(self) -> str:
        """The style with its colours, as one says it."""
        return " and ".join(self.colours) + " " * bool(self.colours) + spoken(self.style)


def spoken(style: str) -> str:
    """A style as one says it, so that it is taken for no colour."""
    return "leaves" if style == "green" else style.replace("_", " ")


@cache
def rows(table: str) -> tuple[Row, ...]:
    """The rows of `words` or `english`, which has no other languages."""
    lines = files(__package__).joinpath(f"{table}.tsv").read_text("utf-8").splitlines()[1:]
    cells = [line.split("\t") for line in lines]
    width = 1 + len(LANGUAGES)
    return tuple(Row(kind, value, tuple(tuple(cell.split()) for cell in (words + [""] * width)[:width])) for kind, value, *words in cells)


@cache
def words_of(language: str) -> Mapping[str, str]:
    """English word that each word of a language stands for."""
    column = 1 + LANGUAGES.index(language)
    return {word: row.words[0][0] for row in rows("words") for word in row.words[column]}


@cache
def small_words_abroad() -> Mapping[str, str]:
    """English word that each small word of languages that no table has stands for."""
    lines = files(__package__).joinpath("abroad.tsv").read_text("utf-8").splitlines()[1:]
    return {word: means for means, words in (line.split("\t") for line in lines) for word in words.split()}


def _values(*kinds: str) -> dict[str, str]:
    """Value by English word, of rows of some kinds."""
    return {word: row.value for row in rows("words") if row.kind in kinds for word in row.words[0]}


def _numbers(kind: str) -> Mapping[str, float]:
    return {word: float(value) for word, value in _values(kind).items()}


COLOURS, METALS = _values("colour", "metal"), frozenset(_values("metal"))
SIZES, AMOUNTS, SHADES, DEGREES, MILLIMETRES = map(_numbers, ("size", "relief", "shade", "degree", "mm"))
PLACES, BEYOND = _values("place"), _values("beyond")
FILLERS, NEGATIONS, SEPARATORS, BESIDE, PLAIN, SMOOTH, EVERYWHERE, UNKNOWN_PLACES, RECESSES, DEPTHS, PICTURES = (
    frozenset(_values(kind))
    for kind in ("filler", "not", "separator", "beside", "plain", "smooth", "everywhere", "nowhere", "recess", "depth", "picture")
)
NEGATED_BEFORE = "not_before"
"""What stands before it is not wanted; only other languages have such a word."""
FAMILIES = frozenset(["red", "orange", "yellow", "green", "blue", "purple", "pink", "brown", "white", "grey", "gray", "black"])
"""Colours that only say of what kind another one is that stands before them: emerald green."""
NEEDS_NUMBERS: Mapping[str, int] = {"above": 1, "below": 1, "box": 6, "sphere": 4, "plane": 6, "segment": 3}
"""How many numbers the notation of a place needs, by its first word."""
TAKES_A_NUMBER = frozenset([*ENDS, "rim"])
"""First words of the notation of places that may be followed by a length."""


def _meant(table: str) -> Iterator[tuple[str, str, Meaning]]:
    """The words of a table that say anything about the style, with the kinds of their rows."""
    for row in rows(table):
        if row.kind in _STYLES:
            style, _, colours = row.value.partition(" ")
            own = tuple(filter(None, colours.split("/"))) if table == "words" else ()
            meaning = Meaning(style, _STYLES.index(row.kind), row.kind in {"like", "thing", "mood"}, own)
            yield from ((word, row.kind, meaning) for word in row.words[0])


@cache
def styles() -> Mapping[str, Meaning]:
    """What each English word says that names a style wherever it stands."""
    found = {word.replace("+", "_"): meaning for word, kind, meaning in _meant("words") if kind in _STYLES[:3]}
    return {PICTURE: Meaning(picture.NAME, 0), **found}


@cache
def weak() -> Mapping[str, Meaning]:
    """What each English word says that names a style only where nothing else does."""
    found = {word: meaning for table in ("english", "words") for word, kind, meaning in _meant(table) if kind in _STYLES[3:]}
    other = {word for row in rows("words") if row.kind not in _STYLES[3:] for word in row.words[0]}
    return {word: meaning for word, meaning in found.items() if word not in other or _STYLES[meaning.rank] == "last"}


def called(style: str) -> tuple[str, ...]:
    """The English words that name a style, its own name aside."""
    return tuple(word for word, meaning in styles().items() if meaning[:3:2] == (style, False) and word not in {style, PICTURE})


@cache
def looks() -> Mapping[str, str]:
    """Style of each English word of `words` that says anything about one."""
    return {word.replace("+", " ").replace("_", " "): meaning.style for word, _, meaning in _meant("words")}


@cache
def foreign_looks() -> Mapping[str, str]:
    """Style of each word of another language of `words` that says anything about one."""
    said = ((word, row.value.split()[0]) for row in rows("words") if row.kind in _STYLES for words in row.words[1:] for word in words)
    return {word.replace("_", " "): style for word, style in said}


@cache
def apart() -> tuple[tuple[str, ...], ...]:
    """The phrases whose words may stand apart from each other, those of most words first."""
    phrases = [tuple(word.split("+")) for word, *_ in _meant("words") if "+" in word]
    return tuple(sorted(phrases, key=lambda phrase: (-len(phrase), phrase)))


@cache
def english() -> Mapping[str, tuple[str, ...]]:
    """Common English words, each with the styles that come near it, nearest first; none if nothing does."""
    return {word: tuple(row.value.split()) for row in rows("english") for word in row.words[0]}


def hints(word: str) -> tuple[str, ...]:
    """The styles that come near an English word, nearest first."""
    forms = (word, word.removesuffix("s"), word.removesuffix("es"))
    return next((english()[form] for form in forms if english().get(form)), ())


@cache
def meanings() -> frozenset[str]:
    """All English words that mean something."""
    known = {word.replace("+", "_") for row in rows("words") for word in row.words[0]} | styles().keys()
    names = {word for row in rows("english") for word in row.words[0] if "_" in word}  # things of several words: barn_owl
    return frozenset(known | names) - {PICTURE}
