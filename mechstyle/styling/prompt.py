"""Reading a prompt without a language model: which style where, how large, how strong, in what colours — and what was not understood.

The grammar, whatever the language; what the words mean stands in the tables of `vocabulary`:

    prompt  =  clause (";" clause)*                  each a wish for its places, or for all of the part
    clause  =  [place ":"] piece (separator piece)*  a new clause begins where another place has its own style or colour
    piece   =  (style | thing | metal | colour | size | amount | length | place | negation | filler)*
    colour  =  (dark | deep | light | …)* colour [family]           said of the recess or style beside it, else of the body
    length  =  number unit [deep]                                   of features, or of the relief
    place   =  [length] name | name [length] | name numbers | length "from the" name
    separator  =  "," | and | with | wearing | …

1. `words`: each word becomes the English word it stands for; the longest phrase goes first. What is no word is mended by one letter, and
   shown; what is one is never.
2. `phrases`: colours with their shades, lengths, places; what is not wanted is taken out.
3. `clauses`: what is said of each place. A piece that names a thing, "gold eyes", is said of that thing alone, and left out with it.
4. Here: of the words for a style in a clause the strongest counts: a style before one that describes, that before what looks like one.
   Where no clause names any, a metal is hammered metal, a thing is the style it looks like, and "green" is leaves; where there is nothing
   either, what was said of parts of the thing is said of all of it. What then names no style is refused, with three that come near.
"""

from __future__ import annotations

import difflib
import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Any

import msgspec
from numpy.typing import ArrayLike

from mechstyle.errors import BadInput
from mechstyle.records.recipe import Recipe, check_prompt
from mechstyle.records.regions import End, Region, Rim, region
from mechstyle.styling import vocabulary as english
from mechstyle.styling.clauses import NO_PLACE, Clause, clauses_of
from mechstyle.styling.drawing.colours import rgb, shaded
from mechstyle.styling.meaning import nearest, sure
from mechstyle.styling.phrases import (
    LIKE,
    NOTHING,
    Item,
    Length,
    Place,
    is_style,
    is_thing,
    items_of,
    likened,
    meaning,
    style_of,
    unknown_stuff,
    with_stuff,
    without_negated,
)
from mechstyle.styling.picture import NAME as OWN
from mechstyle.styling.vocabulary import PICTURE
from mechstyle.styling.words import Word, abroad, quoted, words_read

Rgb = tuple[float, float, float]

FEATURES, RELIEFS = (0.2, 500.0), (0.0, 20.0)
"""Sizes of features and depths of relief that can be asked for [mm]."""
_NEAR, _LEAST_LETTERS = 0.75, 5  # how alike a word must be to a style's to be suggested, and how long
_WELL_KNOWN = ("brick", "honeycomb", "waves", "wood", "stone")
SUGGESTED = 3
"""Styles that a refusal suggests."""
_AMOUNT_RANGE, _SIZE_RANGE = (0.2, 3.0), (0.4, 3.0)
_DARK_RECESS, _LIGHT_RECESS = "charcoal", "off_white"  # joints that are asked for dark or light, in no colour


class Wish(msgspec.Struct, frozen=True):
    """What a prompt asks for at one place of a part, or all over it."""

    style: str  # name of a style of the library; "" for no relief
    size: float = 1.0  # factor on the size of its features
    amount: float = 1.0  # factor on the height of its relief
    colour: Rgb | None = None  # display RGB in [0, 1] of its body, None for the style's own colours
    shade: float = 1.0  # below 1 the style's own colours are darker, above 1 lighter; 1 beside a colour, which is shaded already
    second: Rgb | None = None  # display RGB in [0, 1] of the low places of its relief, such as joints, None for the style's own
    feature: float | None = None  # size of its features [mm], None if the prompt tells none
    relief: float | None = None  # depth of its relief from its lowest to its highest [mm], None if the prompt tells none
    # the regions it is to cover; none for all of the part. Where several wishes meet, the smaller place counts
    where: tuple[Region, ...] = ()
    spared: tuple[Region, ...] = ()  # regions it is not to cover

    @property
    def words(self) -> str:
        """What it asks for, in one line."""
        parts = [english.spoken(self.style) or "plain"]
        for what, length, factor in (("features", self.feature, self.size), ("relief", self.relief, self.amount)):
            if length is not None:
                parts.append(f"{what} of {length:g} mm")
            elif factor != 1.0:
                parts.append(f"{what} × {factor:.2g}")
        parts += [("darker" if self.shade < 1.0 else "lighter")] if self.shade != 1.0 else []
        parts += [f"in {_hexadecimal(self.colour)}"] if self.colour is not None else []
        parts += [f"recesses in {_hexadecimal(self.second)}"] if self.second is not None else []
        return ", ".join(parts)

    @property
    def place(self) -> str:
        """Where it is to be, in the notation of a prompt; "" for all of the part."""
        where = " and ".join(one.words for one in self.where) or ("everywhere" if self.spared else "")
        return where + "".join(f" but not {one.words}" for one in self.spared)


class Reading(msgspec.Struct, frozen=True):
    """A prompt as it was read."""

    wishes: tuple[Wish, ...]  # what it asks for, a wish for each place; at least one names a style
    notes: tuple[str, ...] = ()  # what was guessed, left out or not understood, and what it would take, in sentences
    # a prompt that any machine reads so, where this one was read by its meaning; else ""
    settled: str = ""

    @property
    def words(self) -> str:
        """How it was read, in one line; places and lengths are written as in a prompt."""
        several = len(self.wishes) > 1
        places = [wish.place or several * "everywhere" for wish in self.wishes]
        return "; ".join(f"{place}: {wish.words}" if place else wish.words for place, wish in zip(places, self.wishes, strict=True))


def reading_of(recipe: Recipe) -> Reading:
    """The prompt of a recipe as it is read."""
    return read(recipe.style.prompt, picture=bool(recipe.style.image))


def read(prompt: str, *, picture: bool = False) -> Reading:
    """Read a prompt by its words; notes name whatever was guessed or left out.

    Args:
        prompt: Words.
        picture: Whether there is a picture of the user's: a prompt may name it, and one that names no style is about it.

    Raises:
        BadInput: If it is too long or names no style, or leaves out a picture that is there; the refusal lists the nearest and all known
            styles.
    """
    check_prompt(prompt)
    found, notes = words_read(prompt)
    strange = abroad(prompt)
    if (strange or (notes and not any(_understood(word, notes) for word in found))) and (style := sure(prompt)):
        return _meant(prompt, style)  # a slip is guessed only where no meaning is sure
    if picture:
        meant = [word._replace(means=PICTURE) if word.means in english.PICTURES else word for word in found]
        found = meant if any(is_style(word) for word in meant) else [Word("picture", PICTURE), Word(";", ";"), *meant]
    items = items_of(found, notes)
    kept, unwanted = without_negated(items, adjectives_only=False)
    if not _clauses(kept, notes=[]) and any(is_style(item) for item in unwanted):
        kept, unwanted = without_negated(items, adjectives_only=True)
    kept = with_stuff(kept)
    _check_said(kept, unwanted)
    clauses = _clauses(kept, notes) if not strange or any(_names(word, notes) for word in found) else []
    if not clauses:
        if not unwanted and not picture and (style := sure(prompt)):
            return _meant(prompt, style)
        raise _unknown_prompt(prompt, found, [item for item in unwanted if is_style(item)])
    wishes = _apart(_inherited([_wish(clause, notes) for clause in clauses if clause.named or clause.described]), notes)
    if picture and all(wish.style != OWN for wish in wishes):
        names = quoted(_spoken(wish.style) for wish in wishes if wish.style)
        way = "give each its place, such as `outside: picture; rim: brick`"
        raise BadInput(f"the prompt {prompt!r} names {names}, but not the picture: {way}")
    return Reading(wishes, (*notes, *_left_out(clauses, unwanted, wishes)))


def _check_said(kept: Sequence[Item], unwanted: Sequence[Item]) -> None:
    """Refuse what would be drawn as if it had been said otherwise: a place to be spared that is not known, a stuff that is not known."""
    places = [item.text for item in unwanted if isinstance(item, Word) and meaning(item) in english.UNKNOWN_PLACES]
    if places:
        raise BadInput(f"{quoted(places)} in the prompt is {NO_PLACE}; `--protect` keeps such a place plain")
    if stuff := unknown_stuff(kept):
        near = ", ".join(repr(_spoken(name)) for name in suggestions(" ".join(stuff)))
        raise BadInput(
            f"the prompt asks for something made of {quoted(stuff)}, which is no style: try {near}; `mechstyle styles` lists them all"
        )


def _clauses(kept: Sequence[Item], notes: list[str]) -> list[Clause]:
    """The clauses of a prompt, none if it names no style even by its weaker words; notes are added on metals that were taken for one."""
    for whole in (False, True):
        clauses = clauses_of(kept, whole=whole)
        said = [item for clause in clauses for item in clause.items]
        ranks = {style.rank for item in said if (style := style_of(item))}
        first = itertools.takewhile(lambda item: meaning(item) != ",", said)
        metal = next((item for item in first if meaning(item) in english.METALS), None)
        if min(ranks, default=LIKE) == LIKE and isinstance(metal, Word) and not any(isinstance(item, Place) for item in said):
            notes.append(f"read {metal.text!r} as hammered {_spoken(metal.means)}")
            at = next(at for at, item in enumerate(kept) if item is metal)
            return clauses_of([*kept[: at + 1], Word("", "metal"), *kept[at + 1 :]], whole=whole)
        if ranks:
            return clauses
        like = [item for clause in clauses for item in likened(clause.items)]
        known = english.weak()
        ranked = ([(item, known[meaning(item)].rank) for item in items if meaning(item) in known] for items in (like, said))
        weak = next(filter(None, ranked), [])
        if weak:
            chosen = {id(item) for item, rank in weak if rank == min(rank for _, rank in weak)}
            named = [item._replace(means=f"~{item.means}") if isinstance(item, Word) and id(item) in chosen else item for item in kept]
            return clauses_of(named, whole=whole)
    return []


# --- one wish -----------------------------------------------------------------------------------------------------


def _wish(clause: Clause, notes: list[str]) -> tuple[Wish, bool]:
    """What the items of one place ask for, and whether they say of what style; notes are added on what a wish has no room for."""
    whole = clause.named or (clause.titled and not clause.plain)
    items = clause.items if whole else _measuring_its_place(clause.items, plain=clause.plain)
    style, alike, own = _style(items, notes)
    colour, second = _colours(items, alike, notes)
    loose = [item for at, item in enumerate(items) if not _of_recesses(items, at)]
    shades = english.SHADES.keys() - english.AMOUNTS.keys()  # "deep" alone speaks of the relief
    shade = next((english.SHADES[means] for means in map(meaning, loose) if means in shades), 1.0)
    if own and colour is second is None:
        colour, second = (*(_rgb(Word("", word)) for word in own), None)[:2]
    if colour is not None and shade != 1.0:
        colour, shade = _shaded(colour, shade), 1.0
    places = [item for item in items if isinstance(item, Place)]
    everywhere = any(place.region is None and not place.spared for place in places)
    wish = Wish(
        style=style, size=_factor(items, english.SIZES, _SIZE_RANGE), amount=_factor(items, english.AMOUNTS, _AMOUNT_RANGE), colour=colour,
        shade=shade, second=second, feature=_length(items, FEATURES, notes, deep=False), relief=_length(items, RELIEFS, notes, deep=True),
        where=() if everywhere else tuple(dict.fromkeys(place.region for place in places if place.region and not place.spared)),
        spared=tuple(dict.fromkeys(place.region for place in places if place.region and place.spared)),
    )  # fmt: skip
    return (msgspec.structs.replace(wish, amount=1.0) if clause.plain else wish), clause.named or clause.plain


def _measuring_its_place(items: Sequence[Item], *, plain: bool) -> list[Item]:
    """The items of a place without a style, where a length before the place is that of the place: "a 5 mm gold rim".

    So is one after it where there is to be no relief, which has no features: "rim smooth 8 mm".
    """
    first, *others = [at for at, item in enumerate(items) if isinstance(item, Length | Place)] or [0]
    if plain and others and isinstance(items[first], Place):
        first, others = others[0], [first]
    length, place = items[first], items[others[0]] if others else None
    if not isinstance(length, Length) or not isinstance(place, Place) or not isinstance(place.region, End | Rim):
        return list(items)
    sized = Place(region(f"{place.region.words.split()[0]} {length.mm:g}"), place.spared)
    return [sized if item is place else NOTHING if item is length else item for item in items]


def _style(items: Sequence[Item], notes: list[str]) -> tuple[str, set[str], tuple[str, ...]]:
    """The style of a wish, "" for none, the words that ask for it, and the colours that they mean."""
    read = [(item, style_of(item)) for item in (*items, NOTHING)]
    found = [(item, style) for item, style in read if style]
    # Beside another style a stuff before a colour says which colour: moss green leather is leather.
    tints = [item for item, following in itertools.pairwise(items) if meaning(following) in english.FAMILIES]
    free = {style.style for item, style in found if not any(item is tint for tint in tints)}
    found = [(item, style) for item, style in found if not free or style.style in free]
    if not found:
        return "", set(), ()
    strongest = [one for one in found if one[1].rank == min(style.rank for _, style in found)]
    if strongest[0][1].rank >= LIKE:
        strongest = [one for one in strongest if any(one[0] is item for item in likened(items))] or strongest
    describing = [  # the style that follows at once: cracked leather is leather, but cable knit stays
        item for (item, style), (_, following) in itertools.pairwise(read)
        if style and following and following.rank <= style.rank < LIKE and "_" not in meaning(item)
    ]  # fmt: skip
    word, chosen = next((one for one in strongest if not any(one[0] is item for item in describing)), strongest[0])
    others = sorted({style.style for item, style in found if not style.near and meaning(item) not in english.COLOURS} - {chosen.style})
    if others:
        took, *left = map(english.spoken, (chosen.style, *others))
        way = f"for both, give each its place, such as `outside: {took}; rim: {left[0]}`"
        notes.append(f"one style at one place: took {took!r}, left out {quoted(left)}; {way}")
    if chosen.near and isinstance(word, Word) and word.text.replace(" ", "_") != chosen.style:
        notes.append(f"read {word.text or word.means.removeprefix('~')!r} as {chosen.words}")
    return chosen.style, {meaning(item) for item, style in found if style.style == chosen.style}, chosen.colours


def _factor(items: Sequence[Item], table: Mapping[str, float], limits: tuple[float, float]) -> float:
    """The product of the factors named, each to the power of a degree ("very") before it, within limits."""
    logarithm = 0.0
    for at, item in enumerate(items):
        means = meaning(item)
        if means in table:
            before = meaning(items[at - 1]) if at else ""
            logarithm += math.log(table[means]) * english.DEGREES.get(before, 1.0)
    return min(max(math.exp(logarithm), limits[0]), limits[1])


def _length(items: Sequence[Item], limits: tuple[float, float], notes: list[str], *, deep: bool) -> float | None:
    """The first length of a kind [mm] that can be made; notes tell of the others."""
    what = "a relief" if deep else "features"
    lengths = [item.mm for item in items if isinstance(item, Length) and item.deep is deep]
    possible = [mm for mm in lengths if limits[0] <= mm <= limits[1] and mm > 0.0]
    notes += [
        f"{what} of {mm:g} mm cannot be made, only {limits[0]:g} to {limits[1]:g} mm: left out" for mm in lengths if mm not in possible
    ]
    if len(possible) > 1:
        notes.append(f"{what} of one size at one place: took {possible[0]:g} mm, left out {', '.join(f'{mm:g}' for mm in possible[1:])}")
    return possible[0] if possible else None


def _colours(items: Sequence[Item], alike: set[str], notes: list[str]) -> tuple[Rgb | None, Rgb | None]:
    """Colour of the body and of its recesses: the first named for each; words `alike` its style are no colours unless they are shaded."""
    body: Word | None = None
    recesses: Word | None = None
    left_out = []
    other_styles = english.styles().keys() - alike - english.COLOURS.keys()
    for at, item in enumerate(items):
        means, of_recesses = meaning(item).removeprefix("~"), _of_recesses(items, at)
        if means in english.SHADES and of_recesses and recesses is None:
            recesses = Word("", _DARK_RECESS if english.SHADES[means] < 1.0 else _LIGHT_RECESS)
        if not isinstance(item, Word) or means not in english.COLOURS or (item.means in alike and item.shade == 1.0):
            continue
        word = item._replace(means=means)
        before, after = _neighbours(items, at)
        if alike and ((after in other_styles and before not in alike) or (before in other_styles and after not in alike)):
            left_out.append(means)  # said of a style that is left out: "leather with brass studs"
        elif recesses is None and (of_recesses or (body is not None and before != "or")):
            recesses = word
        elif body is None and not of_recesses:
            body = word
        elif means not in {one.means for one in (body, recesses) if one}:
            left_out.append(means)
    if left_out:
        took = quoted(_spoken(one.means) for one in (body, recesses) if one)
        notes.append(f"one colour for a style and one for its recesses: took {took or 'its own'}, left out {quoted(left_out)}")
    return _rgb(body), _rgb(recesses)


def _neighbours(items: Sequence[Item], at: int) -> tuple[str, str]:
    """What the words before and after an item mean, without those that ask for nothing."""
    silent = {*english.FILLERS, *english.SHADES}
    around = ((meaning(item) for item in side if meaning(item) not in silent) for side in (reversed(items[:at]), items[at + 1 :]))
    before, after = (next(side, "") for side in around)
    return before, after


def _of_recesses(items: Sequence[Item], at: int) -> bool:
    """Whether a colour is said of the low places of a relief: "gold seams", "seams in gold"."""
    before, after = _neighbours(items, at)
    return after in english.RECESSES or (before in english.RECESSES and after not in english.styles())


_UNSAID = Wish("")


def _inherited(wishes: Sequence[tuple[Wish, bool]]) -> tuple[Wish, ...]:
    """The wishes, each with whether it is complete; one that only describes a place takes the rest from the one before."""
    given = [wish for wish, _ in wishes]
    complete = []
    for at, (wish, whole) in enumerate(wishes):
        model = next(other for other in (*reversed(given[:at]), *given[at:], wish) if other.style or whole)
        said = {name: value for name, value in msgspec.structs.asdict(wish).items() if value != getattr(_UNSAID, name)}
        places: dict[str, Any] = {"where": wish.where, "spared": wish.spared}
        colours = {"colour": None, "second": None, "shade": 1.0} if said.keys() & {"colour", "second", "shade"} else {}
        complete.append(wish if whole else msgspec.structs.replace(model, **colours | said | places))
    return tuple(complete)


def _apart(wishes: tuple[Wish, ...], notes: list[str]) -> tuple[Wish, ...]:
    """The wishes with one at most for all of the part, the last: "leather handle and wooden body"; a note is added on the others."""
    everywhere = [wish for wish in wishes if not wish.where and not wish.spared]
    if len({wish.style for wish in everywhere}) > 1:
        took, *others = (english.spoken(wish.style) for wish in reversed(everywhere))
        notes.append(f"one style at one place: took {took!r}, left out {quoted(others)}; give each a place")
    return tuple(wish for wish in wishes if wish not in everywhere[:-1])


# --- what was left out --------------------------------------------------------------------------------------------


def _left_out(clauses: Sequence[Clause], unwanted: Sequence[Item], wishes: Sequence[Wish]) -> list[str]:
    """Sentences on what is not drawn: what is not wanted, what a style cannot do and what would, and what is not understood."""
    notes = []
    if parts := [item.text for item in unwanted if isinstance(item, Word) and item.means in english.RECESSES]:
        notes.append(f"a style cannot be drawn without what belongs to it: {quoted(parts)}")
    if names := [item.means.replace("_", " ") for item in unwanted if isinstance(item, Word) and item.means not in english.RECESSES]:
        colours = any(name in english.COLOURS for name in names) and not any(wish.colour for wish in wishes)
        notes.append(f"not wanted and left out: {quoted(names)}" + colours * "; name the colour that is, or the style keeps its own")
    ways: dict[str, list[str]] = {}
    strange = []
    drawn = {wish.style for wish in wishes}
    said = [(item, of_part) for clause in clauses for items, of_part in ((clause.items, False), (clause.parts, True)) for item in items]
    for item, of_part in said:
        if not isinstance(item, Word) or not item.text:
            continue
        style = style_of(item)
        unseen = is_thing(item) and not (style and style.style in drawn)
        if item.means in english.BEYOND:
            ways.setdefault(english.BEYOND[item.means], []).append(item.text)
        elif item.number is not None:
            ways.setdefault("a number says nothing without its unit: write `5 mm`", []).append(item.text)
        elif unseen or item.means in english.NEEDS_NUMBERS or of_part:
            strange.append(item.text)
    notes += [f"left out {quoted(texts)}: {way}" for way, texts in ways.items()]
    return notes + [f"left out: {quoted(strange)}"] * bool(strange)


def _rgb(colour: Word | None) -> Rgb | None:
    return None if colour is None else _shaded(rgb(english.COLOURS[colour.means]), colour.shade)


def _shaded(colour: ArrayLike, shade: float) -> Rgb:
    red, green, blue = shaded(colour, shade).tolist()
    return red, green, blue


def _hexadecimal(colour: Rgb) -> str:
    return "#" + "".join(f"{round(255 * channel):02x}" for channel in colour)


def _spoken(style: str) -> str:
    return style.replace("_", " ")


def _unknown_prompt(prompt: str, found: Sequence[Word], unwanted: Sequence[Item]) -> BadInput:
    """The error for a prompt without a style, with those that come near it; it never picks one."""
    if not prompt.strip():
        return BadInput("the prompt is empty: say in words what the part is to look like, or give a picture with `--image` or image=")
    if any(word.means in english.PICTURES - english.FILLERS for word in found):
        return BadInput(f"the prompt {prompt!r} asks for a picture: give its file, with `--image` or image=")
    beyond = next((word for word in found if word.means in english.BEYOND), None)
    avoided = {style.style for item in unwanted if (style := style_of(item))}
    near = [_spoken(style) for style in suggestions(prompt, SUGGESTED + len(avoided)) if style not in avoided][:SUGGESTED]
    colour = next((word.text for word in found if word.means in english.COLOURS), "")
    said = "no style that can be drawn offline" if not colour else "only a colour and no style"
    listed = "; `mechstyle styles` lists them all"
    if not any(word.means or word.text in english.english() for word in found):
        said, listed = f"no style in English or one of {len(english.LANGUAGES)} other languages", ""
    if unwanted:
        said = f"no style that is wanted, only what is not ({quoted(_spoken(meaning(item)) for item in unwanted)})"
    ways = ", ".join(f"`{colour} {name}`" if colour else repr(name) for name in near)
    way = f" (left out {beyond.text!r}: {english.BEYOND[beyond.means]})" if beyond else ""
    return BadInput(
        f"the prompt {prompt!r} names {said}{way}: try {ways}{listed}; "
        "any other prompt needs guidance 'clip' (`--guidance clip`) and the weights that `mechstyle weights fetch ViT-B-32` brings once"
    )


def _understood(word: Word, notes: Sequence[str]) -> bool:
    """Whether a word is one of a language that is read, and was not guessed."""
    known = bool(word.means) or word.text in english.english()
    return known and not any(note.startswith(f"read {word.text!r} ") for note in notes)


def _names(word: Word, notes: Sequence[str]) -> bool:
    """Whether a word is the name of a style, and was not guessed."""
    style = style_of(word)
    return style is not None and style.rank == 0 and _understood(word, notes)


def _meant(prompt: str, style: str) -> Reading:
    said = f"read {prompt!r} as {english.spoken(style)} by its meaning"
    return Reading((Wish(style),), (said,), settled=f"{prompt}, {_spoken(style)}")


def suggestions(prompt: str, count: int = SUGGESTED) -> tuple[str, ...]:
    """Names of the styles that come nearest to a prompt by what its words mean, nearest first; always as many as asked for.

    Words that mean nothing are compared by their letters; what is missing then are styles that most people know.
    """
    found, _ = words_read(prompt)
    near: list[list[str]] = []
    for word in found:
        one = style_of(word) or english.weak().get(word.means or word.text)
        hints = english.hints(word.text) if one or not word.means else ()
        near.append([*([one.style] if one else []), *hints])
    by_meaning = list(nearest(prompt))[:count]
    letters = [word.text for word in found if not word.means and len(word.text) >= _LEAST_LETTERS]
    alike = [difflib.get_close_matches(text, english.styles(), n=1, cutoff=_NEAR) for text in letters]
    near += [by_meaning] if by_meaning else [[english.styles()[close].style for close in found] for found in alike]
    ordered = [name for rank in itertools.zip_longest(*near) for name in rank if name]
    return tuple(dict.fromkeys([*ordered, *_WELL_KNOWN]))[:count]
