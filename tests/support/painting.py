"""Reading painted triangles back, written from the slicers' description and not from our writer."""

from __future__ import annotations


def decoded(word):
    """The tree of a painted triangle: a state, or (special side, [children, the first first])."""
    digits = [int(digit, 16) for digit in reversed(word)]
    tree = _read(digits)
    assert not digits, "nothing is left over"
    return tree


def _read(digits):
    number = digits.pop(0)
    sides, rest = number & 0b11, number >> 2
    if sides == 0:
        return rest if rest < 3 else digits.pop(0) + 3
    return rest, [_read(digits) for _ in range(sides + 1)][::-1]


def state_at(tree, place):
    """The state of a painted triangle at a place, as its three shares of the corners."""
    if isinstance(tree, int):
        return tree
    special, children = tree
    turned = [place[(special + k) % 3] for k in range(3)]
    first, second, third = (share > 0.5 for share in turned)
    if len(children) == 4:  # three corners and the middle
        return state_at(children[0 if first else 1 if second else 2 if third else 3], ())
    assert len(children) == 3, "a corner and two that share the rest"
    assert children[1] == children[2]
    return state_at(children[0 if first else 1], ())
