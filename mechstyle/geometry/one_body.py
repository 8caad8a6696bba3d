"""One body of the objects of a file: what overlaps is united, what is cut out is taken away, one of what lies apart is chosen."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any, NamedTuple

import manifold3d
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from mechstyle.errors import BadInput
from mechstyle.geometry.pieces import Piece, Thing, quoted_name, size_words
from mechstyle.geometry.remeshing.evening import surface_of
from mechstyle.geometry.repair import HAIRLINE, counted, host_of, inside_out, overlaps_of, solids_of
from mechstyle.records.mesh import Floats, SurfaceMesh

SPECK, TINY, FEW, DUST = 1e-3, 1.0, 10, 0.2
"""A body apart is a speck if it has less than this share of the volume of the largest, is shorter than this [mm, about two lines of a
nozzle], and if no more than so many are: more of them may be letters or dots. What is shorter than the last [mm] no printer shows."""
CONTACT = 0.04
"""Area over which bodies touch so that they are one [mm²], the square of half a line of a nozzle."""
SEAM = 0.098
"""Gap that a slicer closes, so that what lies nearer is printed as one [mm]: twice the closing radius of PrusaSlicer and its kin."""
SAME = 1e-4
"""How far copies may differ, over their size."""
MOST_TURNS = 400
"""Rotations that are tried to lay a body on another one."""
SHOWN = 6
"""Bodies that a sentence names."""


class Body(NamedTuple):
    """A body of a file, apart from its others."""

    number: int  # its place in the file, from 1; copies of a body have that of the first
    name: str  # what its file calls it, "" if it does not
    extents: tuple[float, float, float]  # sides of the box around it [mm]
    volume: float  # of its material [mm³]
    copies: int  # how many of it there are
    solid: Any  # its closed surface, as a Manifold

    @property
    def words(self) -> str:
        """Number, name, size and copies."""
        name = f" {quoted_name(self.name)}" if self.name else ""
        return f"{self.number}{name} ({_size(self.solid)}{f', {self.copies} times' if self.copies > 1 else ''})"


def repaired(things: Sequence[Thing], name: str, body: str = "") -> tuple[SurfaceMesh, tuple[str, ...]]:
    """One closed body of the objects of a file [mm]; also returns what was done, one sentence each.

    Args:
        things: The objects.
        name: What to call the file in a refusal.
        body: Which of several bodies, by name or number; "" if there is one, or copies of one.

    Raises:
        BadInput: If it encloses nothing, cannot be closed, or holds separate bodies of which none or an unknown one is asked for.
    """
    notes: list[str] = []
    named = [thing for thing in things if body and thing.name.lower() == body.strip().lower()]
    found = bodies_of(named or things, name, notes)
    wanted = "" if named and len(found) == 1 else body.strip().lower()
    fitting = [one for one in found if one.name.lower() == wanted] or [one for one in found if str(one.number) == wanted]
    listed = _listed([one.words for one in found])
    if not wanted and len(found) > 1:
        unique = [one.name.lower() for one in found].count(found[0].name.lower()) == 1
        example = quoted_name(found[0].name) if found[0].name and unique else found[0].number
        way = f"a drop test needs one; choose it with --body {example}, or join them"
        raise BadInput(f"{name} holds {len(found)} separate bodies, {listed}: {way}")
    if len(fitting) > 1:
        raise BadInput(f"{name} holds {len(fitting)} bodies of the name {quoted_name(body)}: choose one by its number, of {listed}")
    if wanted and not fitting:
        raise BadInput(f"{name} holds no body {quoted_name(body)}: it has {listed}")
    chosen = fitting[0] if fitting else found[0]
    if chosen.copies > 1:
        notes.append(f"read one of {chosen.copies} equal copies")
    if len(found) > 1:
        others = [other.words for other in found if other is not chosen]
        notes.append(f"read body {chosen.words}, and left out {_listed(others)}")
    whole = surface_of(chosen.solid)
    return whole, (*notes, *overlaps_of(whole))


def bodies_of(things: Sequence[Thing], name: str, notes: list[str]) -> list[Body]:
    """The separate bodies of a file in its order, copies as one; what was done is added to the notes."""
    solids = [solid for thing in things for solid in _solids(thing, name, notes)]
    if len(solids) == 1 and not any(thing.cuts for thing in things):  # what is cut may fall apart
        return [_body(1, _one_name(things), [solids[0]])]
    pieces = [piece for thing in things for piece in thing.pieces]
    # The separate bodies of their union, each with its cavities, largest first.
    shells = manifold3d.Manifold.batch_boolean(solids, manifold3d.OpType.Add).decompose()
    apart = sorted((shell for shell in shells if shell.volume() > 0), key=lambda part: -part.volume())
    for cavity in (inside_out(shell) for shell in shells if shell.volume() < 0):
        if (host := host_of(cavity, apart)) is not None:
            apart[host] -= cavity
    parts = _touching_united(apart)
    if (made := len(solids) - len(parts)) > 0:
        names = list(dict.fromkeys(piece.name for piece in pieces if piece.name))
        named = f" ({_listed([quoted_name(name) for name in names])})" if len(names) > 1 else ""
        notes.append(f"united {len(solids) if len(parts) == 1 else made + 1} overlapping bodies{named}")
    parts = _without_specks(parts, notes)
    if len(parts) == 1:
        return [_body(1, _one_name(things), parts)]
    return _numbered(parts, pieces)


def _listed(words: Sequence[str]) -> str:
    return ", ".join(words[:SHOWN]) + (f" and {len(words) - SHOWN} more" if len(words) > SHOWN else "")


def _one_name(things: Sequence[Thing]) -> str:
    names = {thing.name for thing in things if thing.name}
    return names.pop() if len(names) == 1 else ""


# --- solids of an object ------------------------------------------------------------------------------------------


def _solids(thing: Thing, name: str, notes: list[str]) -> list[Any]:
    """The solids of an object, less what is cut out of it."""
    done: list[str] = []
    vertices, faces = joined(thing.pieces)
    solids = solids_of(vertices, faces, name, done)
    for cut in thing.cuts:
        tools = solids_of(cut.vertices, cut.faces, f"the negative volume {quoted_name(cut.name)} in {name}", done)
        tool = manifold3d.Manifold.batch_boolean(tools, manifold3d.OpType.Add)
        solids = [left for solid in solids if not (left := solid - tool).is_empty()]
        done.append(f"cut out the negative volume{f' {quoted_name(cut.name)}' if cut.name else ''} of {size_words(cut.corners)}")
        if not solids:
            raise BadInput(f"{name} has nothing left where its negative volumes are cut out: make them smaller, and save it again")
    notes += [note for note in done if note not in notes]
    return solids


def joined(pieces: Sequence[Piece]) -> tuple[Floats, NDArray[np.int64]]:
    """Vertices and faces of pieces, one after the other."""
    starts = np.cumsum([0, *(len(piece.vertices) for piece in pieces[:-1])])
    faces = [piece.faces + start for piece, start in zip(pieces, starts, strict=True)]
    return np.concatenate([piece.vertices for piece in pieces]), np.concatenate(faces)


# --- apart or together --------------------------------------------------------------------------------------------


def _touching_united(parts: list[Any]) -> list[Any]:
    """The same with those united that touch, or lie apart by no more than what a slicer closes."""
    reach = HAIRLINE * float(np.linalg.norm(np.ptp(_boxes(parts).reshape(-1, 3), axis=0)))
    furthest = max(reach, SEAM)
    apart, whole = parts[::-1], list[Any]()
    while apart:
        part = apart.pop(0)  # smallest first: what touches something larger becomes part of it
        low, high = _boxes([part])[0]
        boxes = _boxes(apart)
        near = np.flatnonzero((boxes[:, 0] <= high + furthest).all(axis=1) & (boxes[:, 1] >= low - furthest).all(axis=1))
        for host in near[::-1]:
            gap = part.min_gap(apart[host], furthest)
            union = _pressed(part, apart[host], gap, reach) if gap < furthest else None
            if union is not None:
                apart[host] = union
                break
        else:
            whole.append(part)
    return whole[::-1]


def _pressed(part: Any, host: Any, gap: float, reach: float) -> Any | None:
    """The union of two bodies, the first moved by a hairline into the second; None where they touch in points or edges only.

    What they share grows with the depth where they touch in an area, and with its square elsewhere.
    """
    ways = [np.array(way) / np.linalg.norm(way) for way in itertools.product((-1, 0, 1), repeat=3) if any(way)]
    way = max(ways, key=lambda way: (part.translate((gap + reach) * way) ^ host).volume())
    deep, barely = ((part.translate((gap + depth) * way) ^ host).volume() for depth in (reach, 0.1 * reach))
    if deep < CONTACT * reach or barely < 0.03 * deep:
        return None
    union = part.translate((gap + reach) * way) + host
    return union if len([shell for shell in union.decompose() if shell.volume() > 0]) == 1 else None


def _boxes(parts: list[Any]) -> Floats:
    """Lowest and highest corner of each, shape [n, 2, 3]."""
    return np.array([part.bounding_box() for part in parts], np.float64).reshape(-1, 2, 3)


def _without_specks(parts: list[Any], notes: list[str]) -> list[Any]:
    """The bodies but for few tiny ones, which are named with their size and place."""
    largest = max(part.volume() for part in parts)
    boxes = _boxes(parts)
    longest = np.ptp(boxes, axis=1).max(axis=1)
    small = [index for index, part in enumerate(parts) if part.volume() < SPECK * largest and longest[index] < TINY]
    if len(small) > FEW:
        small = [index for index in small if longest[index] < DUST]
    if not small:
        return parts
    where = [f"{_size(parts[index])} at ({', '.join(f'{x:.1f}' for x in boxes[index].mean(axis=0))})" for index in small]
    notes.append(f"left out {counted(len(small), 'speck', 'specks')} apart from the part: {_listed(where)}")
    return [part for index, part in enumerate(parts) if index not in small]


# --- names, numbers, copies ---------------------------------------------------------------------------------------


def _numbered(parts: list[Any], pieces: Sequence[Piece]) -> list[Body]:
    """The bodies in the order of the file, each with the name of the piece that it has most of; copies of one as one.

    Copies lie clearly apart: equal bodies that touch in a point or an edge, or nearly, are one part that is badly joined.
    """
    names = [piece.name for piece in pieces]
    label = np.repeat(np.arange(len(pieces)), [len(piece.vertices) for piece in pieces])
    tree = cKDTree(np.concatenate([piece.vertices for piece in pieces]))
    nearest = [tree.query(_points(part))[1] for part in parts]
    order = sorted(range(len(parts)), key=lambda index: int(nearest[index].min()))
    groups: list[list[int]] = []
    for index in order:
        group = next((group for group in groups if is_copy(parts[group[0]], parts[index]) and _clear_of(parts, index, group)), None)
        if group is None:
            groups.append([index])
        else:
            group.append(index)
    mostly = [names[int(np.bincount(label[near]).argmax())] for near in nearest]
    numbers = {group[0]: number for number, group in enumerate(groups, 1)}
    return [_body(numbers[group[0]], mostly[group[0]], [parts[index] for index in group]) for group in groups]


def _clear_of(parts: list[Any], index: int, others: list[int]) -> bool:
    """Whether a body lies further from others than a slicer closes."""
    return all(parts[index].min_gap(parts[other], 2.0 * SEAM) > SEAM for other in others)


def _body(number: int, name: str, copies: list[Any]) -> Body:
    low, high = _boxes(copies[:1])[0]
    x, y, z = (high - low).tolist()
    return Body(number, name, (x, y, z), float(copies[0].volume()), len(copies), copies[0])


def _points(solid: Any) -> Floats:
    return np.asarray(solid.to_mesh64().vert_properties[:, :3], np.float64)


def is_copy(one: Any, other: Any) -> bool:
    """Whether a body is another one, moved and turned; a mirrored one is none."""
    if one.num_vert() != other.num_vert() or abs(one.volume() - other.volume()) > SAME * one.volume():
        return False
    here, there = (points - points.mean(axis=0) for points in (_points(one), _points(other)))
    size = float(np.linalg.norm(here, axis=1).max())
    near = SAME * size
    first = int(np.linalg.norm(here, axis=1).argmax())
    second = int(np.linalg.norm(np.cross(here, here[first]), axis=1).argmax())
    frame, tree = _frame(here[first], here[second]), cKDTree(here)
    pairs = itertools.product(*(np.flatnonzero(abs(np.linalg.norm(there, axis=1) - np.linalg.norm(here[at])) < near)
                                for at in (first, second)))  # fmt: skip
    apart = float(np.linalg.norm(here[first] - here[second]))
    fitting = ((a, b) for a, b in pairs if abs(np.linalg.norm(there[a] - there[b]) - apart) < 2 * near)
    turns = (frame @ _frame(there[a], there[b]).T for a, b in itertools.islice(fitting, MOST_TURNS))
    return any(tree.query(there @ turn.T)[0].max() < 4 * near for turn in turns)


def _frame(a: Floats, b: Floats) -> Floats:
    """An orthonormal basis by two directions, as columns, shape [3, 3]."""
    x = a / np.linalg.norm(a)
    z = np.cross(a, b)
    z /= np.linalg.norm(z)
    return np.stack([x, np.cross(z, x), z], axis=1)


def _size(solid: Any) -> str:
    return size_words(_boxes([solid])[0])
