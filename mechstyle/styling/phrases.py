"""The words of a prompt put together: numbers with their units, places with their numbers, and what is not wanted taken out."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import NamedTuple

from mechstyle.records.regions import Region, region
from mechstyle.styling import vocabulary as english
from mechstyle.styling.vocabulary import COLOURS, UNKNOWN_PLACES, Meaning, apart, styles, weak
from mechstyle.styling.words import Word


class Length(NamedTuple):
    """A length in a prompt [mm], and whether it is one of the relief's depth."""

    mm: float
    deep: bool


class Place(NamedTuple):
    """A place named in a prompt, None for all of the part, and whether it is to be spared."""

    region: Region | None
    spared: bool = False


Item = Word | Length | Place
NOTHING = Word("", "the")
"""In the place of what has been read."""
ADJECTIVES = english.SIZES.keys() | english.AMOUNTS.keys() | english.SHADES.keys() | english.COLOURS.keys()
"""Words that describe a style."""
_LARGE = {"wide", "large", "big"}
_LINKS, _NOUNS = {"of", "in", "the"}, {"depth", "relief"}
"""Words between a length and the second ones that say it is one of depth: "1 mm of depth", but "5 mm in deep blue"."""
_MADE = {"made", "built"}
_LIKENESS, _COSTUMES = {"like", *_MADE}, {"suit", "costume", "outfit"}
_NO_CONTENT = {"", "or", ":", ";"} | english.FILLERS | english.SEPARATORS | english.BESIDE | english.DEGREES.keys()


def meaning(item: Item | None) -> str:
    """The word an item stands for; "the" for what is none."""
    return item.means if isinstance(item, Word) else "the"


LIKE = 2
"""Rank of a word that only looks like a style."""


def style_of(item: Item) -> Meaning | None:
    """What an item says that names a style, None if it names none."""
    means = meaning(item)
    return weak()[means[1:]] if means.startswith("~") else styles().get(means)


def is_style(item: Item) -> bool:
    """Whether an item names a style."""
    return style_of(item) is not None


def is_thing(item: Item) -> bool:
    """Whether an item names a thing, which may have a colour and a style of its own: an eye, a door, a castle."""
    means, style = meaning(item), style_of(item)
    return not means or means in UNKNOWN_PLACES or (means in weak() and means not in COLOURS) or (style is not None and style.rank == LIKE)


def likened(items: Sequence[Item]) -> list[Item]:
    """What something is to be like, is made of or dressed as: "like an owl", "a cat in an astronaut suit"; none if nothing is said."""
    dressed = [item for item, following in itertools.pairwise(items) if meaning(following) in _COSTUMES]
    return dressed or list(itertools.dropwhile(lambda item: meaning(item) not in _LIKENESS, items))


def unknown_stuff(items: Sequence[Item]) -> list[str]:
    """The words that are not known of what something is to be made of; none if a style, colour or thing that is known is among them."""
    after = list(itertools.dropwhile(lambda item: meaning(item) not in _MADE, items))[1:]
    said = [item for item in itertools.takewhile(lambda item: not _ends_scope(item), after) if is_content(item) or not meaning(item)]
    if any(is_style(item) or meaning(item) in {*weak(), *COLOURS} for item in said):
        return []
    return [item.text for item in said if isinstance(item, Word) and not item.means and item.text]


def with_stuff(items: Sequence[Item]) -> list[Item]:
    """Items where what is made of something that only weaker words know is that, and not the thing: a robot made of vegetables."""
    first = next((at for at, item in enumerate(items) if meaning(item) in _MADE), len(items))
    after = list(itertools.takewhile(lambda item: not _ends_scope(item), items[first + 1 :]))
    if any(is_style(item) or meaning(item) in COLOURS for item in after) or not any(meaning(item) in weak() for item in after):
        return list(items)
    things = [item._replace(means="") if isinstance(item, Word) and is_style(item) and is_thing(item) else item for item in items[:first]]
    return [*things, *items[first:]]


def items_of(found: Sequence[Word], notes: list[str]) -> list[Item]:
    """The words with those that belong together as one: phrases, lengths, places; notes are added on numbers left out."""
    read = _with_shades(_with_phrases(found), notes)
    # What is a style alone, such as lines, is said of the recesses of the style beside it: "brick with gold lines".
    beside = any(is_style(word) and word.means not in english.RECESSES for word in read)
    seams = [word._replace(means="seam") if beside and word.means in english.RECESSES else word for word in read]
    return _with_places(_with_lengths(seams, notes))


def _with_phrases(found: Sequence[Word]) -> list[Word]:
    """The words with those of a style's phrase ("dragon_scale") read as one, wherever they stand: "the scales of a dragon".

    The style takes the place of the first word and a filler that of the others; phrases of more words are read first.
    """
    read = list(found)
    for parts in apart():
        if all(part in (means := [word.means for word in read]) for part in parts):
            first, *others = sorted(means.index(part) for part in parts)
            if not {":", ";"} & set(means[first : max(others)]):
                read[first] = read[first]._replace(means="_".join(parts))
                for other in others:
                    read[other] = NOTHING
    return read


def _with_shades(found: Sequence[Word], notes: list[str]) -> list[Word]:
    """The words with every colour as light as the word before it says: "deep blue", which is no deep relief; "emerald green" is emerald."""
    read: list[Word] = []
    for word in found:
        last = next((at for at in range(len(read) - 1, -1, -1) if read[at].means not in english.SHADES), -1)
        if word.means in english.FAMILIES and read and read[-1].means in english.COLOURS.keys() - english.FAMILIES:
            notes.append(f"read '{read[-1].means} {word.means}' as {read[-1].means!r}")
            read.append(NOTHING)
        elif word.means in english.COLOURS and last < len(read) - 1:
            text = " ".join(shade.text for shade in read[last + 1 :])
            read[last + 1 :] = [Word(f"{text} {word.text}", word.means, english.SHADES[read[-1].means])]
        else:
            read.append(word)
    return read


def _with_lengths(found: Sequence[Word], notes: list[str]) -> list[Item]:
    """The words with every number that has a unit read as a length, together with the word that says of what."""
    items: list[Item] = []
    rest = list(found)
    while rest:
        word = rest.pop(0)
        if word.number is None or not rest or rest[0].means not in english.MILLIMETRES:
            items.append(word)
            continue
        mm = word.number * english.MILLIMETRES[rest.pop(0).means]
        at = next((at for at in range(len(items) - 1, -1, -1) if meaning(items[at]) not in english.FILLERS), None)
        before = items[at] if at is not None else NOTHING
        deep = _says_deep(rest)
        while deep and rest[0].means in _LINKS:  # 1 mm of depth
            rest.pop(0)
        if deep or (rest and rest[0].means in _LARGE):
            rest.pop(0)
        of_what_follows = meaning(before) in ADJECTIVES and bool(rest) and is_style(rest[0])  # "deep 5 mm bricks"
        if at is not None and not deep and meaning(before) in english.DEPTHS and not of_what_follows:
            deep, items[at] = True, NOTHING
        elif at is not None and isinstance(before, Word) and before.number is not None:
            notes.append(f"a size is one length: took {mm:g} mm, left out {before.text}")
            items[at] = NOTHING
        if meaning(before) != "thickness":  # of a wall, which no style changes
            items.append(Length(mm, deep))
    return items


def _says_deep(rest: Sequence[Word]) -> bool:
    """Whether the next word makes the length before it one of depth, and is not said of a length that follows: "4 mm, relief 1 mm"."""
    if not rest:
        return False
    links = next((at for at, word in enumerate(rest) if word.means not in _LINKS), 0)
    says = _NOUNS if links else english.DEPTHS
    return rest[links].means in says and not (len(rest) > links + 1 and rest[links + 1].number is not None)


def _with_places(given: Sequence[Item]) -> list[Item]:
    """The items with the words of a place, and the numbers that say how far it reaches, read as a place."""
    items: list[Item] = []
    rest = list(given)
    while rest:
        item = rest.pop(0)
        kind = english.PLACES.get(meaning(item), "")
        bare = bool(items) and isinstance(items[-1], Word) and items[-1].text in {"on", "at"}  # without an article, as in "on top"
        if meaning(item) in english.EVERYWHERE:
            items.append(Place(None))
        elif isinstance(item, Length):
            items.append(_reach(item, rest) or _sized(item, rest) or item)
        elif kind and (numbers := _numbers_after(kind, rest, bare=bare)) is not None:
            items.append(Place(region(" ".join([kind, *(f"{number:g}" for number in numbers)]))))
        else:
            items.append(item)
    return items


def _reach(length: Length, rest: list[Item]) -> Place | None:
    """Take "from the bottom" after a length, and make it the place that reaches so far."""
    texts = [item.text if isinstance(item, Word) else "" for item in rest[:2]]
    at = 2 if texts == ["from", "the"] else 1
    kind = english.PLACES.get(meaning(rest[at]), "") if texts[:1] == ["from"] and at < len(rest) else ""
    if kind not in english.TAKES_A_NUMBER:
        return None
    del rest[: at + 1]
    return Place(region(f"{kind} {length.mm:g}"))


def _sized(length: Length, rest: list[Item]) -> Place | None:
    """Take the place right after a length that is no depth, and has no length of its own: "a 5 mm rim"."""
    kind = english.PLACES.get(meaning(rest[0]), "") if rest else ""
    own = len(rest) > 1 and (isinstance(rest[1], Length) or (isinstance(rest[1], Word) and rest[1].number is not None))
    if length.deep or own or kind not in english.TAKES_A_NUMBER:
        return None
    del rest[0]
    return Place(region(f"{kind} {length.mm:g}"))


def _numbers_after(kind: str, rest: list[Item], *, bare: bool) -> list[float] | None:
    """Take the numbers that belong to a place from what stands after its first word; None if it needs more than there are.

    With no article (`bare`) a length rather belongs to what follows: "on top 5 mm bricks".
    """
    needed = english.NEEDS_NUMBERS.get(kind, 0)
    most = needed or int(kind in english.TAKES_A_NUMBER)
    taken = 0
    numbers: list[float] = []
    for at, item in enumerate(rest):
        number = item.number if isinstance(item, Word) else item.mm if isinstance(item, Length) and not item.deep else None
        if len(numbers) == most or (number is None and meaning(item) != "z"):
            break
        if number is not None:
            numbers.append(number)
            taken = at + 1
    if len(numbers) < needed:
        return None
    if not needed and bare and taken < len(rest) and is_content(rest[taken]):
        return []
    del rest[:taken]
    return numbers


def without_negated(items: Sequence[Item], *, adjectives_only: bool) -> tuple[list[Item], list[Item]]:
    """The items with nothing in the place of what is not wanted, and what that is; a place that is not wanted is spared.

    Args:
        items: What was read.
        adjectives_only: Whether "not deep bricks" are bricks that are not deep, rather than no bricks.
    """
    kept: list[Item] = []
    unwanted: list[Item] = []
    scope = False
    for at, item in enumerate(items):
        means = meaning(item)
        if means == english.NEGATED_BEFORE:
            start = max((k + 1 for k, other in enumerate(kept) if _ends_scope(other)), default=0)
            unwanted += [other for other in kept[start:] if is_content(other)]
            kept[start:] = [_spared(other) for other in kept[start:]]
        elif means == "nothing" and not any(map(is_content, itertools.takewhile(lambda other: not _ends_scope(other), items[at + 1 :]))):
            kept.append(item._replace(means="plain") if isinstance(item, Word) else item)  # outside bark, inside nothing
        elif means in english.NEGATIONS or (means == "but" and _excepts_a_place(items[at + 1 :])):
            scope = True
            kept.append(NOTHING)
        elif _ends_scope(item):
            scope = False
            kept.append(item)
        elif scope and is_content(item):
            unwanted.append(item)
            kept.append(_spared(item))
            scope = not (adjectives_only and means in ADJECTIVES)
        else:
            kept.append(item)
    return kept, unwanted


def _ends_scope(item: Item) -> bool:
    return meaning(item) in {*english.SEPARATORS, ";", ":", "just", "only", "rather", "instead"}


def is_content(item: Item) -> bool:
    """Whether an item asks for something."""
    return not isinstance(item, Word) or item.means not in _NO_CONTENT


def _spared(item: Item) -> Item:
    return item._replace(spared=True) if isinstance(item, Place) else NOTHING if is_content(item) else item


def _excepts_a_place(rest: Sequence[Item]) -> bool:
    """Whether only a place comes up to the next comma: "all over but the rim"."""
    end = next((at for at, item in enumerate(rest) if _ends_scope(item)), len(rest))
    content = [item for item in rest[:end] if is_content(item)]
    stopped = end < len(rest) and meaning(rest[end]) not in {",", ";"}
    return bool(content) and not stopped and all(isinstance(item, Place) for item in content)
