"""The words of a prompt by the place they are said of: "outside: brick; rim: gold studs", or "brick with gold studs on the rim"."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field

from mechstyle.errors import BadInput
from mechstyle.styling import vocabulary as english
from mechstyle.styling.phrases import ADJECTIVES, Item, Length, Place, is_content, is_style, is_thing, meaning
from mechstyle.styling.words import Word, quoted

NO_PLACE = (
    "no place that is known on every part: known are outside, inside, rim, sides, top, bottom, left, right, front and back;"
    " give others in mm, such as `box 0 0 0 10 10 10: wood` or `segment x y z: wood` for the smooth piece nearest to a point"
)
"""Said of a place that cannot be found by its name."""


@dataclass
class Clause:
    """The items of one wish."""

    items: list[Item]  # what it says, its place included
    titled: bool = False  # whether its place stands before a colon
    # what it says of parts of the thing, such as "gold eyes": they do not have its style, and it does not have theirs
    parts: list[Item] = field(default_factory=list)

    @property
    def named(self) -> bool:
        """Whether it names a style."""
        return any(is_style(item) for item in self.items)

    @property
    def placed(self) -> bool:
        """Whether it names a place."""
        return any(isinstance(item, Place) and not item.spared for item in self.items)

    @property
    def whole(self) -> bool:
        """Whether it could be a wish of its own."""
        return self.named or (self.placed and self.described)

    @property
    def plain(self) -> bool:
        """Whether it asks for no relief."""
        return not self.named and any(meaning(item) in english.PLAIN | english.SMOOTH for item in self.items)

    @property
    def described(self) -> bool:
        """Whether it says what a place is to look like, though it may name no style."""
        return self.plain or any(isinstance(item, Length) or meaning(item) in ADJECTIVES for item in self.items)


def clauses_of(items: Sequence[Item], *, whole: bool = False) -> list[Clause]:
    """The items by the wish they belong to; BadInput if a place before a colon is not known.

    With `whole`, what is said of parts of the thing counts for all of it.
    """
    groups: list[Clause] = []
    for piece in _pieces(items):
        last = groups[-1] if groups else None
        if last is None or piece.titled or (last.whole and (piece.whole if last.placed else piece.whole and piece.placed)):
            groups.append(piece)
        elif _of_a_part(piece) and not whole and any(map(_speaks, last.items)):
            last.parts += filter(_speaks, piece.items)
        else:
            last.items += [Word(",", ","), *piece.items]
    return groups


def _of_a_part(piece: Clause) -> bool:
    """Whether a piece is of another thing: "black stone ears", "standing on a trunk", but not "japanese waves", and no place."""
    if meaning(piece.items[0]) in english.BESIDE and not piece.placed:
        return True
    content = [item for item in piece.items if _speaks(item) and meaning(item) not in english.BEYOND]
    if not any(map(is_thing, content)) or any(isinstance(item, Place) or meaning(item) in english.RECESSES for item in content):
        return False
    return is_thing(content[-1]) or not is_style(content[-1])


def _speaks(item: Item) -> bool:
    """Whether an item asks for something or is not understood."""
    return is_content(item) or not meaning(item)


def _pieces(items: Sequence[Item]) -> Iterator[Clause]:
    """What stands under a title each, and what stands between separators elsewhere."""
    for clause in _split(items, {";"}):
        titles = [_title(clause, at) for at, item in enumerate(clause) if meaning(item) == ":"]
        starts = [start for start in titles if start is not None]
        for piece in _split(clause[: starts[0] if starts else len(clause)], english.SEPARATORS | english.BESIDE | {":"}):
            yield from map(Clause, _alternating(piece))
        for start, end in itertools.pairwise([*starts, len(clause)]):
            yield Clause([item for item in clause[start:end] if meaning(item) != ":"], titled=True)


def _alternating(piece: Sequence[Item]) -> list[list[Item]]:
    """A piece in which a style follows each place, or a place each style, cut into as many; the piece itself if it is not so."""
    kinds = [(at, isinstance(item, Place)) for at, item in enumerate(piece) if isinstance(item, Place) or is_style(item)]
    if len(kinds) < 4 or len(kinds) % 2 or any(one[1] is other[1] for one, other in itertools.pairwise(kinds)):
        return [list(piece)]
    first_is_place = kinds[0][1]
    cuts = [at + (not first_is_place) for at, is_place in kinds if is_place]
    ends = [0, *cuts[1:], len(piece)] if first_is_place else [0, *cuts[:-1], len(piece)]
    return [list(piece[start:end]) for start, end in itertools.pairwise(ends)]


def _split(items: Sequence[Item], marks: Collection[str]) -> Iterator[list[Item]]:
    """The items between marks, where there are any; words such as "standing on" go with what follows."""
    part: list[Item] = []
    for item in [*items, Word("", ";")]:
        if meaning(item) in {*marks, ";"}:
            if part:
                yield part
            part = [item] if meaning(item) in english.BESIDE else []
        else:
            part.append(item)


def _title(clause: Sequence[Item], colon: int) -> int | None:
    """Where the title before a colon begins; None if it is none ("style: brick"); BadInput for a place that is not known."""
    start = colon
    while start and (isinstance(item := clause[start - 1], Place) or is_thing(item) or (not is_content(item) and meaning(item) != ":")):
        start -= 1
    title = clause[start:colon]
    if any(isinstance(item, Place) for item in title):
        return start
    strange = [item.text for item in title if isinstance(item, Word) and is_thing(item)]
    if strange:
        raise BadInput(f"{quoted(strange)} in the prompt is {NO_PLACE}")
    return None
