"""The words of a prompt, each with the word of the vocabulary it stands for, in whatever language and however spelt."""

from __future__ import annotations

import difflib
import itertools
import re
import unicodedata
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from typing import NamedTuple

from mechstyle.styling import vocabulary as english
from mechstyle.styling.vocabulary import SPACED, meanings, small_words_abroad, styles, weak, words_of

MARKS = {":": ":", ";": ";", "\n": ";", "&": "and", "+": "and", "/": "and", **dict.fromkeys(",.、。()–—", ",")}
"""Punctuation that means something; the other has no meaning."""
_EAST = "\u3040-\u30ff\u3400-\u9fff々〆"  # signs that are written without spaces between words
_TOKEN = re.compile(rf"3d\b|(?<![\w.])[-+]?\d+(?:\.\d+)?|\d+(?:\.\d+)?|[{_EAST}]+|[^\W\d_{_EAST}]+|[{re.escape(''.join(MARKS))}]")
_KANA = re.compile("[\u3040-\u30ff]")
_ENDINGS = (
    ("ies", "y"), ("ves", "f"), ("s", ""), ("es", ""), ("ed", ""), ("ed", "e"), ("ing", ""), ("ing", "e"), ("ish", ""), ("ish", "e"),
    ("er", ""), ("er", "e"), ("est", ""), ("est", "e"), ("y", ""), ("en", ""),
)  # fmt: skip
_MADE = (("er", ""), ("or", ""))  # what does something
_INFLECTED = 8  # so many of them only say number and time
_COMPARED = ("er", "est")  # rougher is rough, but a bagger is no bag
_PLURALS = ("ies", "es", "s", "ed")
_INFLECTION = {
    "German": re.compile("(?:en|er|es|em|e|n|s)$"),
    "Dutch": re.compile("(?:tjes|tje|en|es|er|e|n|s)$"),
    "Turkish": re.compile("(?:lar|ler)?(?:[ıiuü]|s[ıiuü]|[ıiuü]n|n[ıiuü]n|l[ıiuü]|d[ae]n?|t[ae]n?|y?[ae])?$"),
    "Korean": re.compile("(?:으로|[의로을를이가은는와과에도])$"),
    "Polish": re.compile("(?:owego|owymi|owych|owym|owej|owa|owe|owy|ami|ach|ego|emu|ymi|imi|ych|ich|ej|ym|im|om|ów|ie|ą|ę|a|e|i|o|u|y)$"),
    "Russian": re.compile(
        "(?:ами|ями|ого|его|ому|ему|ыми|ими|ая|яя|ое|ее|ые|ие|ый|ий|ой|ую|юю|ых|их|ым|им|ом|ем|ам|ям|ах|ях|ов|ев|ей|[аеиоуыьюя])$"
    ),
} | dict.fromkeys(("French", "Spanish", "Portuguese", "Italian"), re.compile("(?:[aeio]?s?|x)$"))
_LETTERS = frozenset("abcdefghijklmnopqrstuvwxyzàâäæáãçéèêëíìîïñóòôöõœúùûüÿßªºąćęłńśźżğışабвгдежзийклмнопрстуфхцчшщъыьэюя")
"""Letters of the languages of the tables, Korean aside."""
_HANGUL = re.compile("[가-힣]")
_LEAST_STEM = 3
_LEAST_STEMS = {"Dutch": 4, "Polish": 4, "Russian": 4, "Turkish": 4, "Korean": 1}  # those of three letters are everybody's: sera is evening
_LEAST_STYLE = 4
_LONGEST_PHRASE = 4  # words
_LONG, _SLIPS = 8, 2  # letters from which on so many slips are forgiven
_FIRM = 6  # letters from which on one of them may be another: shorter words are often words of their own


class Word(NamedTuple):
    """A word, number or mark of a prompt."""

    text: str  # as typed, in lower case
    means: str  # the English word of the vocabulary, or of a style, that it stands for; a mark or number for itself; "" for none
    shade: float = 1.0  # how light a colour is to be: below 1 darker, above 1 lighter

    @property
    def number(self) -> float | None:
        """Its value if it is a number."""
        return float(self.text) if re.fullmatch(r"[-+]?\d+(?:\.\d+)?", self.text) else None


def words_read(prompt: str) -> tuple[list[Word], list[str]]:
    """The words of a prompt, and a note for each that was guessed."""
    typed = _joined(_typed(prompt))
    eastern = ("Japanese", "Chinese") if _KANA.search(typed) else ("Chinese", "Japanese")
    tokens = [part for token in _TOKEN.findall(typed) for part in (_segmented(token, eastern) if _is_eastern(token) else [token])]
    language = language_of(tokens)
    read, notes = [], []
    while tokens:
        token = tokens[0]
        if _is_eastern(token):
            count, means, guess = 1, [_listed(token, eastern)], ""
        else:
            count, means, guess = _next_word(tokens, language)
        read += [Word(" ".join(tokens[:count]) if not at else "", meaning) for at, meaning in enumerate(means)]
        notes += [guess] if guess else []
        del tokens[:count]
    return read, notes


def abroad(prompt: str) -> bool:
    """Whether a prompt is in a language that no table has, as its letters or small words say: in it a plaster may be honeycomb."""
    typed = _typed(prompt)
    words = re.findall(r"[^\W\d_]{2,}", typed)
    small = not small_words_abroad().keys().isdisjoint(words)
    return small or any(set(_HANGUL.sub("", word)) - _LETTERS and not _is_eastern(word) for word in words)


def quoted(texts: Iterable[str]) -> str:
    """Some words for a sentence, each once."""
    return ", ".join(repr(text) for text in dict.fromkeys(texts))


def _bare(text: str) -> str:
    """The text without accents; й is no и."""
    signs = (sign for sign in unicodedata.normalize("NFKD", text.replace("ł", "l")) if sign == "\u0306" or not "\u0300" <= sign <= "\u036f")
    return unicodedata.normalize("NFC", "".join(signs))


def _typed(text: str) -> str:
    """The text in lower case, with what is written in more than one way written in one; of kana the marks stay."""
    plain = unicodedata.normalize("NFKC", text.casefold()).replace("n't", " not").replace("n’t", " not")
    plain = re.sub(r"(?<![\d.])(\d+)/([1-9]\d*)(?=\s*(?:in\b|inch|[\"″]))", lambda of: f"{int(of[1]) / int(of[2]):g}", plain)  # 1/4 inch
    plain = re.sub(r"(?<=\d)(?:in\b|\s*[\"″])", " inch", plain)  # 2in: two words would be "2", "inside"
    plain = re.sub(r"(?<=\d),(?=\d+\s*(?:mm|cm|milli|centi|毫米|ミリ))", ".", plain)  # a decimal comma
    return re.sub(r"[- ]ish\b", "", plain).replace("・", "").replace("ё", "е")


def _joined(typed: str) -> str:
    """A prompt with those words written as one whose hyphen stands after a letter or beside what is no word: a U-Boot is no boot."""

    def one(found: re.Match[str]) -> str:
        parts = found[0].split("-")
        words = (part for part in parts if not _english(part) and part not in _in_phrases())
        strange = (part for part in words if not any(_known(part, language) for language in ("", *SPACED)))
        return "".join(parts) if len(parts[0]) == 1 or any(strange) else found[0]

    return re.sub(rf"[^\W\d_{_EAST}]+(?:-[^\W\d_{_EAST}]+)+", one, typed)


@cache
def _in_phrases() -> frozenset[str]:
    """The words of all phrases: Saint-Jacques."""
    return frozenset(part for language in SPACED for word in words_of(language) for part in _typed(word).split("_") if "_" in word)


def _is_eastern(token: str) -> bool:
    return bool(re.match(f"[{_EAST}]", token))


def _listed(word: str, languages: Sequence[str]) -> str:
    """English word that the dictionary of the first of some languages that knows a word has for it; "" for none."""
    return next((_dictionary(language)[word] for language in languages if word in _dictionary(language)), "")


def _segmented(signs: str, languages: Sequence[str]) -> list[str]:
    """Words written without spaces: always the longest that comes next; signs that begin none are put together.

    A single sign for a thing or stuff beside one that is not known is half of a word that is not known: 机 is a desk, 手机 is none.
    """
    parts: list[tuple[str, str]] = []
    while signs:
        length = next((length for length in range(len(signs), 0, -1) if _listed(signs[:length], languages)), 0)
        parts.append((signs[: length or 1], _listed(signs[:length], languages) if length else ""))
        signs = signs[length or 1 :]
    strange = [not means for _, means in parts]
    for at, (part, means) in enumerate(parts):
        beside = any(strange[other] and not _KANA.match(parts[other][0]) for other in (at - 1, at + 1) if 0 <= other < len(parts))
        strange[at] |= beside and len(part) == 1 and (means in styles() or means in weak())
    runs = itertools.groupby(zip(parts, strange, strict=True), key=lambda one: one[1])
    found = [(unknown, [part for (part, _), _ in run]) for unknown, run in runs]
    return [text for unknown, texts in found for text in (["".join(texts)] if unknown else texts)]


def _next_word(tokens: list[str], language: str) -> tuple[int, list[str], str]:
    """How many tokens belong together, what they mean, and a note if that was guessed."""
    first = tokens[0]
    if first in MARKS:
        return 1, [MARKS[first]], ""
    if Word(first, "").number is not None:
        return 1, [first], ""
    count, found = max((_phrase(tokens, one) for one in dict.fromkeys([language, ""])), key=lambda phrase: phrase[0])
    if count and not (language and count == 1 and found in weak() and first not in _dictionary(language)):
        return count, [found], ""
    small = small_words_abroad().get(first, "")
    means, guess = ([small], "") if small else _unlisted(first, language)
    return 1, means, guess


@cache
def _dictionary(language: str) -> Mapping[str, str]:
    """English word by word of a language, as it is written and without its accents; "" for English itself."""
    if not language:
        return {word.replace("_", ""): word for word in meanings()} | {word: word for word in meanings()}
    written: dict[str, str] = {}
    bare: dict[str, str] = {}
    for word, means in words_of(language).items():
        written[_typed(word)] = means
        bare[_typed(word) if language == "German" else _bare(_typed(word))] = means  # "koper" is Dutch for copper, and no Köper
        bare[_bare(re.sub("([äöü])", r"\1e", word.casefold()))] = means  # ä written as ae
    known = meanings() | {english.NEGATED_BEFORE}
    return {word: means for word, means in (bare | written).items() if means in known}


@cache
def _stems(language: str) -> Mapping[str, str]:
    """English word by stem of a word of a language, as `_stem` gives it."""
    return {_stem(word, language): means for word, means in reversed(list(_dictionary(language).items())) if "_" not in word}


@cache
def _accented_stems(language: str) -> Mapping[str, str]:
    """English word by stem of a word of a language that is written with accents, without them."""
    written = {_typed(word): means for word, means in words_of(language).items()}
    return {_bare(_stem(word, language)): means for word, means in written.items() if word != _bare(word) and means in meanings()}


def _stem(word: str, language: str) -> str:
    """The word without the ending that number, gender and case give it; as it is if too little would be left."""
    stem = _INFLECTION[language].sub("", word)
    if language == "Dutch" and stem != word and stem[-2:-1] == stem[-1:]:
        stem = stem[:-1]  # vissen
    return stem if len(stem) >= _LEAST_STEMS.get(language, _LEAST_STEM) - (language == "Dutch") else word


def _forms(word: str, endings: Sequence[tuple[str, str]] = _ENDINGS) -> Iterator[str]:
    """The English word and what it may be a plural or participle of, likeliest first."""
    yield word
    for ending, stem in endings:
        if word.endswith(ending) and len(word) - len(ending) >= _LEAST_STEM:
            base = word[: len(word) - len(ending)]
            forms = [base + stem, *([base[:-1]] if not stem and base[-1] == base[-2] else [])]  # reddish
            yield from (form for form in forms if ending in _PLURALS or form not in english.FILLERS)


def _english(word: str) -> str:
    """What English has the word as, without the ending of a plural or participle; "" if it is no common English word."""
    forms = itertools.chain(_forms(word, _ENDINGS[:_INFLECTED]), _forms(word, _MADE))  # a steamer is no slip of a stream
    return next((form for form in forms if form in english.english()), "")


def _known(word: str, language: str) -> str:
    """English word that one word of a language stands for, whatever its ending; "" if it is none."""
    if word in small_words_abroad():
        return ""
    if not language:
        if word.endswith(_COMPARED) and word not in meanings():  # a bagger is no bag, and a bumper, which is a thing, no bump
            return "" if english.hints(word) else next((form for form in _forms(word) if form in meanings() and form not in weak()), "")
        return next((form for form in _forms(word) if form in meanings()), "")
    stem = _stem(word, language)
    return _dictionary(language).get(word) or _dictionary(language).get(stem) or _stems(language).get(stem, "")


def language_of(tokens: Sequence[str]) -> str:
    """The language, "" for English, that knows most of the words, and most of them as they are written; English if that is as likely."""
    western = [token for token in tokens if token.isalpha() and not _is_eastern(token) and token not in english.MILLIMETRES]
    if _covered(western, "")[:2] == (len(western), len(western)):  # no other can know more: its dictionary need not be read
        return ""
    return max(("", *SPACED), key=lambda language: _covered(western, language))


def _covered(tokens: Sequence[str], language: str) -> tuple[float, int, int]:
    """How many of some words a language knows, alone or in its phrases, how many as they are written, and how many ask for nothing.

    A word that English has but that says nothing here counts half: a Stein is also a stein.
    """
    at, covered, written, small = 0, 0.0, 0, 0
    while at < len(tokens):
        count, means = _phrase(tokens[at:], language)
        own = not language or tokens[at] not in english.english()  # a burger is no Burg, nor fog a fogo
        known = count or (own and bool(_known(tokens[at], language) or _compound(tokens[at], language)))
        covered += known or 0.5 * (not language and bool(_english(tokens[at])))
        written += count
        small += means in english.FILLERS
        at += count or 1
    return covered, written, small if language else len(tokens)


def _phrase(tokens: Sequence[str], language: str) -> tuple[int, str]:
    """How many tokens the longest entry of a dictionary is made of with which they begin, and its meaning; 0 if there is none."""
    dictionary = _dictionary(language)
    for count in range(min(_LONGEST_PHRASE, len(tokens)), 0, -1):
        last = _forms(tokens[count - 1]) if count > 1 and not language else tokens[count - 1 : count]
        found = next((means for form in last if (means := dictionary.get("_".join([*tokens[: count - 1], form]), ""))), "")
        if found:
            return count, found
    return 0, ""


def _unlisted(word: str, language: str) -> tuple[list[str], str]:
    """What a word means that no dictionary lists as it is, and a note if that was guessed: inflected, foreign, compound, misspelt."""
    if word != (bare := _bare(word)):
        return _unlisted_accented(word, bare, language)
    if found := _known(word, language) or (_known(word, "") if not language or _known(word, "") not in weak() else ""):
        return [found], ""
    if common := _english(word):  # a word of its own is no slip of another; in another language an English thing is offered, not taken
        return [common if common in weak() and not language else ""], ""
    seen = {
        *styles(),
        *weak(),
        *english.COLOURS,
        *english.SIZES,
        *english.AMOUNTS,
        *english.PLACES,
    }  # filling words of another language are often words of this one
    foreign = next((means for other in SPACED if (means := _dictionary(other).get(word, "")) in seen), "")
    if foreign and len(word) >= _LEAST_STYLE:
        return [foreign], f"read {word!r} as {foreign!r}"
    parts = _compound(word, language)
    if parts:
        return parts, ""
    close = _misspelt(word, language) or _begun(word)
    return [close], f"read {word!r} as {close!r}" if close else ""


def _unlisted_accented(word: str, bare: str, language: str) -> tuple[list[str], str]:
    """Likewise of a word with accents, which is no word of English: für is no fur. Another language must have it with those accents."""
    foreign = next((means for other in SPACED if (means := _dictionary(other).get(word, ""))), "")
    if foreign:
        return [foreign], ""
    if not language:
        return [_known(bare, "") if not any(bare in _dictionary(other) for other in SPACED) else ""], ""  # crochêt
    stem = _stem(word, language)
    known = _dictionary(language).get(stem) or _accented_stems(language).get(_bare(stem), "")
    return ([known], "") if known else (_compound(word, language) or [""], "")


def _compound(word: str, language: str) -> list[str]:
    """The meanings of the two words that are written as one in German and Dutch ("dunkelblau"); none if it is not of two."""
    if language not in {"German", "Dutch"}:
        return []
    for cut in range(len(word) - _LEAST_STEM, _LEAST_STEM - 1, -1):
        parts = [_known(word[:cut], language), _known(word[cut:], language)]
        plain = [part for part in parts if part not in english.FILLERS]
        if all(parts) and plain:
            return parts
    return []


def _begun(word: str) -> str:
    """The style or thing with which a longer German word begins: Schuppenpanzer, Holzkiste; "" if it is none.

    An English word begins no German one: dentelle is no dent. Of two English words the second is what it is: a hammerhead is no hammer.
    """
    if _of_two(word):
        return ""
    starts = (_dictionary("German").get(word[:cut], "") for cut in range(len(word) - _LEAST_STEM, _LEAST_STYLE - 1, -1))
    return next((means for means in starts if means in styles() or means in weak()), "")


def _of_two(word: str) -> bool:
    """Whether a word is of two English ones."""
    cuts = range(_LEAST_STYLE, len(word) - _LEAST_STEM + 1)
    return any(word[:cut] in english.english() and word[cut:] in english.english() for cut in cuts)


def _misspelt(word: str, language: str) -> str:
    """The word of a language that this one is a misspelling of; "" if it is none's, or too short to tell."""
    looks = {*weak(), *styles()}
    least = _LEAST_STYLE + bool(language)  # no list says which words of other languages are words of their own
    forms = [word] if language else list(_forms(word))
    for slipped in (_slips,) if _of_two(word) else (_slips, _scrambled):
        close = [
            (means not in looks, len(other) == len(form), other, means)
            for form in forms
            for other, means in _beginning_with(form[0], language)
            if (means not in looks or min(len(word), len(other)) >= least) and slipped(form, other)
        ]
        if close:
            return min(close)[3]
    return ""


@cache
def _beginning_with(letter: str, language: str) -> tuple[tuple[str, str], ...]:
    """The words of a language that a word with this first letter may be a misspelling of, and what they mean."""
    return tuple((word, means) for word, means in _dictionary(language).items() if word[0] == letter and means not in english.FILLERS)


def _slips(word: str, meant: str) -> bool:
    """Whether one slip of a typist makes a word of another: two letters swapped, one left out or too many; in long words also another."""
    if min(len(word), len(meant)) < _LEAST_STEM or word[0] != meant[0] or abs(len(word) - len(meant)) > 1:
        return False
    start = next((k for k, (a, b) in enumerate(zip(word, meant, strict=False)) if a != b), min(len(word), len(meant)))
    rest, other = word[start:], meant[start:]
    swapped = rest[:2] == other[:2][::-1] and rest[2:] == other[2:]
    dropped = rest == other[1:] or (rest[1:] == other and (other != "" or word[-1] == meant[-1]))  # a monstera is no monster
    changed = len(word) >= _FIRM and rest[1:] == other[1:]
    return swapped or dropped or changed


def _scrambled(word: str, meant: str) -> bool:
    """Whether a word is one of at least six letters in another order, or one of at least eight with two slips, both within its ends."""
    if min(len(word), len(meant)) < _FIRM or word[0] != meant[0]:
        return False
    if word[-1] == meant[-1] and sorted(word) == sorted(meant):
        return True
    if min(len(word), len(meant)) < _LONG or abs(len(word) - len(meant)) > _SLIPS:
        return False
    changes = difflib.SequenceMatcher(None, word, meant, autojunk=False).get_opcodes()
    return sum(max(i - h, k - j) for kind, h, i, j, k in changes if kind != "equal") <= _SLIPS
