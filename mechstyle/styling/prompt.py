"""Reading a prompt without a language model: which style, how large, how strong, in what colour — and what was not understood."""

from __future__ import annotations

import difflib
import math
import re
import unicodedata
from collections.abc import Iterable, Mapping

import msgspec

from mechstyle.errors import BadInput
from mechstyle.styling.drawing.colours import rgb, shaded
from mechstyle.styling.library import library, style_named

Rgb = tuple[float, float, float]

SIZES: dict[str, float] = {
    "tiny": 0.5, "minute": 0.5, "miniature": 0.5, "micro": 0.5, "small": 0.7, "little": 0.7, "fine": 0.7, "dense": 0.7,
    "tight": 0.8, "narrow": 0.8, "medium": 1.0, "wide": 1.25, "large": 1.4, "big": 1.4, "coarse": 1.4, "chunky": 1.4,
    "bulky": 1.4, "huge": 2.0, "giant": 2.0, "massive": 2.0,
}
AMOUNTS: dict[str, float] = {
    "flat": 0.4, "faint": 0.4, "subtle": 0.5, "smooth": 0.5, "low": 0.6, "gentle": 0.6, "delicate": 0.6, "shallow": 0.6, "soft": 0.6,
    "mild": 0.6, "moderate": 1.0, "pronounced": 1.4, "rough": 1.4, "rugged": 1.5, "strong": 1.5, "bold": 1.5, "deep": 1.6,
    "heavy": 1.6, "dramatic": 1.8, "extreme": 2.0,
}
COLOURS: dict[str, str] = {
    "red": "b8322a", "crimson": "a31631", "scarlet": "c8271c", "maroon": "6b1f2a", "burgundy": "6d1a36", "pink": "e58fb0",
    "rose": "d6708a", "orange": "dd7a22", "terracotta": "bf6443", "rust": "9c4a22", "rusty": "9c4a22", "copper": "b46a3c",
    "bronze": "8a6236", "brown": "7a4f2e", "chocolate": "4e2f1d", "tan": "c4a27a", "beige": "d9c8a5", "sand": "d3ba8a",
    "cream": "efe3c4", "ivory": "efe9d6", "yellow": "e3bf34", "gold": "c99a2e", "golden": "c99a2e", "mustard": "c59a1f",
    "lime": "9ac43a", "green": "4c8f3c", "olive": "75782f", "emerald": "1f8f5f", "mint": "9ad4b4", "teal": "1f7f80",
    "turquoise": "3bb5b0", "cyan": "35b3c9", "blue": "2f5fa8", "navy": "1f2f5c", "azure": "3f8fd0", "indigo": "3c3a86",
    "purple": "6f3f93", "violet": "7d55ad", "lavender": "b3a1d6", "magenta": "b8358a", "white": "ebeae6", "silver": "b9bcc0",
    "grey": "85868a", "gray": "85868a", "charcoal": "3b3c40", "black": "262629", "mahogany": "5e2318",
}
DEGREES: dict[str, float] = {
    "very": 1.6, "extremely": 2.0, "really": 1.6, "super": 1.8, "slightly": 0.5, "somewhat": 0.6, "quite": 1.2,
}
_FILLERS = """
    a an the of in on with from to for and or by as is it its this that my all over into out at made make turn like look looks looking
    style styled stylized stylised texture textures textured pattern patterns patterned surface finish effect covered coated built
    rendering rendered render 3d image photo art model object thing part unreal engine please some coloured colored colour color wall walls
    colourful colorful
"""
FILLERS = frozenset(_FILLERS.split())
_ENDINGS = (
    ("ies", "y"), ("ves", "f"), ("es", ""), ("s", ""), ("ed", ""), ("ed", "e"), ("ing", ""), ("ing", "e"), ("ish", ""), ("y", ""),
)
_SHADES = {"dark": 0.55, "deep": 0.7, "bright": 1.2, "light": 1.45, "pale": 1.6}
# How alike a word must be to be read as a style, as another word (or as a style beside one spelt out), and to be suggested.
_STYLE_TYPO, _TYPO, _NEAR = 0.8, 0.85, 0.6
_AMOUNT_RANGE, _SIZE_RANGE = (0.2, 3.0), (0.4, 3.0)


class Wish(msgspec.Struct, frozen=True):
    """A prompt as it was read.

    Attributes:
        style: Name of a style of the library.
        size: Factor on the size of its features.
        amount: Factor on the height of its relief.
        colour: Display RGB in [0, 1] of its body, None for the style's own colours.
        shade: Below 1 the style's own colours are darker, above 1 lighter; 1 beside a colour, which is shaded already.
        feature: Size of its features [mm], None if the prompt tells none.
        relief: Depth of its relief from its lowest to its highest [mm], None if the prompt tells none.
        notes: What was guessed or not understood, in sentences.
    """

    style: str
    size: float = 1.0
    amount: float = 1.0
    colour: Rgb | None = None
    notes: tuple[str, ...] = ()
    shade: float = 1.0
    feature: float | None = None
    relief: float | None = None


def read(prompt: str) -> Wish:
    """Read a prompt by its keywords; notes name whatever was guessed or left out.

    Raises:
        BadInput: If no style is named; it lists the nearest and all known ones.
    """
    words = _words(prompt)
    by_word = _style_words()
    known, notes = _spelled(words)
    known = _phrased(known, by_word)
    styles = [word for word in known if word in by_word]
    if not styles:
        raise _unknown_prompt(prompt, words, by_word)
    chosen = next((by_word[word] for word in styles if not style_named(by_word[word]).yields), by_word[styles[0]])
    others = sorted({by_word[word] for word in styles if word not in COLOURS} - {chosen})
    if others:
        notes.append(f"one style at a time: took {chosen!r}, left out {_quoted(others)}")
    colour, colour_notes = _colour(known, {word for word in styles if by_word[word] == chosen})
    left_out = [word for word, meant in zip(words, known, strict=True) if not meant]
    if left_out:
        notes.append(f"not understood and left out: {_quoted(left_out)}")
    return Wish(
        style=chosen,
        size=_factor(known, SIZES, _SIZE_RANGE),
        amount=_factor(known, AMOUNTS, _AMOUNT_RANGE),
        colour=colour,
        notes=(*notes, *colour_notes),
        shade=_own_shade(known) if colour is None else 1.0,
    )


def _words(prompt: str) -> list[str]:
    """The words of a prompt in lower case, without accents and punctuation."""
    plain = unicodedata.normalize("NFKD", prompt.lower())
    return re.findall(r"[a-z0-9]+", "".join(sign for sign in plain if not unicodedata.combining(sign)))


def _style_words() -> dict[str, str]:
    """Name of the style that each style word asks for."""
    styles = library().values()
    return {word: style.name for style in styles for word in style.words} | {style.name: style.name for style in styles}


def _forms(word: str) -> Iterable[str]:
    """The word and what it may be a plural or participle of, likeliest first."""
    yield word
    for ending, stem in _ENDINGS:
        if word.endswith(ending) and len(word) - len(ending) >= 3:
            yield word[: len(word) - len(ending)] + stem


def _spelled(words: list[str]) -> tuple[list[str], list[str]]:
    """The known word each word stands for ("": none), and a note for every misspelling forgiven."""
    styles = _style_words()
    others = [word for word in (*SIZES, *AMOUNTS, *COLOURS, *DEGREES, *_SHADES) if word not in styles]
    meant = {*styles, *others, *FILLERS}
    known = [next((form for form in _forms(word) if form in meant), "") for word in words]
    # Beside a style that is spelt out a misspelt word must be more like another to stand for it: "brick store" is not about stone.
    likeness = _TYPO if any(word in styles for word in known) else _STYLE_TYPO
    notes = []
    for place, word in enumerate(words):
        if not known[place]:
            known[place] = _closest(word, styles, likeness) or _closest(word, others, _TYPO)
            if known[place]:
                notes.append(f"read {word!r} as {known[place]!r}")
    return known, notes


def _closest(word: str, among: Iterable[str], likeness: float) -> str:
    """The word that is most like a misspelt word, or like what it may be a plural or participle of; "" if none is alike enough."""
    close = (difflib.get_close_matches(form, among, n=1, cutoff=likeness) for form in _forms(word) if len(form) >= 3)
    return next((found[0] for found in close if found), "")


def _phrased(known: list[str], by_word: Mapping[str, str]) -> list[str]:
    """The known words with those of a phrase ("dragon_scale") read as one, wherever they stand: "the scales of a dragon".

    The style takes the place of the first word and a filler that of the others; phrases of more words are read first.
    """
    phrases = {phrase: [_root(part) for part in phrase.split("_")] for phrase in by_word if "_" in phrase}
    roots, read = [_root(word) for word in known], list(known)
    for phrase, parts in sorted(phrases.items(), key=lambda item: (-len(item[1]), item[0])):
        if all(part in roots for part in parts):
            places = sorted(roots.index(part) for part in parts)
            for place in places:
                read[place], roots[place] = "the", ""
            read[places[0]] = phrase
    return read


def _root(word: str) -> str:
    """The word without a plural's s, so that "scales" and "scale" are alike."""
    return word.removesuffix("s")


def _factor(known: list[str], table: Mapping[str, float], limits: tuple[float, float]) -> float:
    """The product of the factors named, each to the power of a degree ("very") before it, within limits."""
    logarithm = 0.0
    for place, word in enumerate(known):
        if word in table and not _is_shade(known, place):
            before = known[place - 1] if place else ""
            logarithm += math.log(table[word]) * DEGREES.get(before, 1.0)
    return min(max(math.exp(logarithm), limits[0]), limits[1])


def _is_shade(known: list[str], place: int) -> bool:
    """Whether the word belongs to the colour after it: "deep blue" is no deep relief."""
    return known[place] in _SHADES and place + 1 < len(known) and known[place + 1] in COLOURS


def _colour(known: list[str], chosen: set[str]) -> tuple[Rgb | None, list[str]]:
    """The first colour named besides the words for the style, shaded by the word before it, and a note on any other."""
    with_shade = [place > 0 and _is_shade(known, place - 1) for place in range(len(known))]
    places = [place for place, word in enumerate(known) if word in COLOURS and (word not in chosen or with_shade[place])]
    if not places:
        return None, []
    first = places[0]
    code = COLOURS[known[first]]
    shade = _SHADES[known[first - 1]] if with_shade[first] else 1.0
    others = sorted({known[place] for place in places[1:]} - {known[first]})
    notes = [f"one colour at a time: took {known[first]!r}, left out {_quoted(others)}"] if others else []
    red, green, blue = shaded(rgb(code), shade).tolist()
    return (red, green, blue), notes


def _own_shade(known: list[str]) -> float:
    """The first shade named: "dark" makes a style's own colours darker; "deep" alone speaks of the relief."""
    return next((_SHADES[word] for word in known if word in _SHADES and word not in AMOUNTS), 1.0)


def _quoted(words: Iterable[str]) -> str:
    return ", ".join(repr(word) for word in dict.fromkeys(words))


def _unknown_prompt(prompt: str, words: list[str], by_word: Mapping[str, str]) -> BadInput:
    """The error for a prompt without a style, nearest styles first; it never picks one."""
    near = [close for word in words if word not in FILLERS for close in difflib.get_close_matches(word, by_word, n=3, cutoff=_NEAR)]
    nearest = list(dict.fromkeys(by_word[word] for word in near))[:3]
    hint = f"the nearest are {_quoted(nearest)}; " if nearest else ""
    return BadInput(
        f"the prompt {prompt!r} names no style that can be drawn offline: {hint}known are {', '.join(sorted(set(by_word.values())))}; "
        "any other prompt needs guidance 'clip' (`--guidance clip`) and the weights that `mechstyle weights fetch ViT-B-32` brings once"
    )
