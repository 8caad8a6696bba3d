"""Drawings as pixels: areas are known from geometry, and a file reads nothing but itself."""

import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.styling.image_files.decode import pixels_of
from mechstyle.styling.image_files.svg import LONGEST
from mechstyle.styling.image_files.svg_path import outline_of_path


def drawn(body: str, root: str = 'viewBox="0 0 10 10"'):
    return pixels_of(f'<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" {root}>{body}</svg>'.encode())


def area(body: str) -> float:
    """Area that is painted, in square units of a drawing 10 units wide."""
    return float(drawn(body)[..., -1].mean()) / 255.0 * 100.0


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ('<rect x="1" y="2" width="3" height="4"/>', 12.0),
        ('<rect x="1" y="2" width="4" height="4" rx="1"/>', 16.0 - (4.0 - np.pi)),
        ('<circle cx="5" cy="5" r="3"/>', 9.0 * np.pi),
        ('<ellipse cx="5" cy="5" rx="4" ry="2"/>', 8.0 * np.pi),
        ('<polygon points="1,1 9,1 1,9"/>', 32.0),
        ('<line x1="1" y1="5" x2="9" y2="5" stroke="red" stroke-width="0.5"/>', 4.0),
        ('<polyline points="1,5 9,5" fill="none" stroke="red" stroke-linecap="square"/>', 9.0),
        ('<path d="M1 1h8v8h-8zM3 3h4v4h-4z"/>', 64.0),
        ('<path d="M1 1h8v8h-8zM3 3h4v4h-4z" fill-rule="evenodd"/>', 48.0),
        ('<path d="M1 1h8v8h-8zM3 3h4v4h-4zM4 4h2v2h-2z" style="fill-rule:evenodd"/>', 52.0),
        ('<path d="M1 1h8v8h-8zm2 2v4h4v-4z"/>', 48.0),
        ('<path d="M2 5a3 3 0 1 1 6 0 3 3 0 01-6 0"/>', 9.0 * np.pi),
        ('<path d="M1 5A4 2 0 0 1 9 5z"/>', 4.0 * np.pi),
        ('<path d="M5 1A2 4 90 0 1 5 1.0z M1 5A2 4 90 1 1 9 5z"/>', 4.0 * np.pi),
        ('<path d="M0 0Q5 10 10 0z"/>', 100.0 / 3.0),
        ('<path d="M0 0C0 10 10 10 10 0z"/>', 60.0),
        ('<path d="M0 5q2.5-5 5 0t5 0V10H0z"/>', 50.0),
        ('<g transform="translate(5 5) rotate(30) scale(2)"><rect x="-1" y="-1" width="2" height="2"/></g>', 16.0),
        ('<rect width="4" height="4" transform="matrix(1 0 0.5 1 1 1)"/>', 16.0),
        ('<rect width="4" height="4" transform="skewX(20) translate(2,2)"/>', 16.0),
        ('<defs><rect id="a" width="2" height="2"/></defs><use href="#a" x="1"/><use xlink:href="#a" y="5"/>', 8.0),
        ('<symbol id="s"><rect width="2" height="2"/></symbol><use href="#s"/>', 4.0),
        ('<g fill="none"><rect width="4" height="4"/><rect width="2" height="2" fill="blue"/></g>', 4.0),
        ('<rect width="4" height="4" opacity="0.5"/>', 8.0),
        ('<rect width="9" height="9" display="none"/><rect width="9" height="9" visibility="hidden"/><rect width="1" height="1"/>', 1.0),
        ('<path d="M1 1h4v4h-4z M6 6 Lnonsense"/>', 16.0),
    ],
)  # fmt: skip
def test_a_shape_covers_its_area(body, expected):
    assert area(body) == pytest.approx(expected, abs=0.15)


@pytest.mark.parametrize(
    ("paint", "colour"),
    [
        ('fill="#f00"', (255, 0, 0)), ('fill="rgb(0,128,255)"', (0, 128, 255)), ('fill="rgb(100%,0%,0%)"', (255, 0, 0)),
        ('style="fill:lime"', (0, 255, 0)), ('class="b a"', (0, 0, 255)), ('fill="red" class="a"', (0, 0, 255)),
        ('fill="currentColor" color="yellow"', (255, 255, 0)), ('fill="url(#g)"', (128, 128, 0)), ('fill="url(#h)"', (128, 128, 0)),
    ],
)  # fmt: skip
def test_a_colour_may_be_said_in_many_ways(paint, colour):
    known = (
        "<style>.a, .c { fill: blue } /* .a{fill:red} */</style>"
        '<linearGradient id="g"><stop stop-color="red"/><stop offset="1" style="stop-color:lime"/></linearGradient>'
        '<radialGradient id="h" xlink:href="#g"/>'
    )
    assert np.abs(drawn(f'{known}<rect x="-1" y="-1" width="12" height="12" {paint}/>')[5, 5].astype(int) - colour).max() <= 1


def test_its_proportions_are_those_of_the_view():
    square = '<rect x="2" y="3" width="4" height="2"/>'
    assert drawn(square, 'viewBox="2 3 4 2"').shape == (LONGEST // 2, LONGEST, 1)
    assert drawn(square, 'width="20mm" height="1cm"').shape[:2] == (LONGEST // 2, LONGEST)


@pytest.mark.parametrize(
    ("body", "why"),
    [
        ('<image href="file:///etc/passwd" width="10" height="10"/>', "an embedded picture"),
        ('<use href="other.svg#a"/>', "nothing else is read"),
        ('<use href="http://127.0.0.1:9/x.svg#a"/>', "nothing else is read"),
        ("<text>brick</text>", "holds text"),
        ('<rect width="2" height="2" clip-path="url(#c)"/>', "clipping"),
        ('<rect width="2" height="2" style="filter:url(#c)"/>', "a filter"),
        ('<pattern id="p"/><rect width="2" height="2" fill="url(#p)"/>', "a pattern"),
        ('<rect width="2" height="2" fill="url(http://127.0.0.1:9/)"/>', "no colour"),
        ('<rect width="2" height="2" transform="wobble(3)"/>', "wobble"),
        ('<g id="a"><use href="#a"/></g>', "nested deeper|shapes"),
        ('<g id="z">' + '<rect width="1" height="1"/>' * 30 + "</g>" + "".join(
            f'<g id="{"zyxwv"[k + 1]}">' + f'<use href="#{"zyxwv"[k]}"/>' * 30 + "</g>" for k in range(4)), "shapes"),
        ("<g>" * 60 + "</g>" * 60, "nested deeper"),
        ("", "transparent all over"),
    ],
    ids=["image", "file", "network", "text", "clip", "filter", "pattern", "paint", "transform", "itself", "multiplied", "deep", "nothing"],
)  # fmt: skip
def test_what_is_not_drawn_is_named_and_nothing_outside_is_read(body, why):
    with pytest.raises(BadInput, match=why):
        drawn(body)


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (b'<!DOCTYPE svg [<!ENTITY e SYSTEM "file:///etc/passwd">]><svg viewBox="0 0 1 1"><title>&e;</title></svg>', "entities"),
        (b'<!DOCTYPE svg [<!ENTITY a "b"><!ENTITY c "&a;&a;">]><svg viewBox="0 0 1 1"/>', "entities"),
        (b'<svg viewBox="0 0 1 1"><rect', "cut off"),
        (b"<html><body/></html>", "XML of another kind"),
        (b'<svg xmlns="http://www.w3.org/2000/svg"><rect/></svg>', "viewBox"),
        (b'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1e9 1"><rect/></svg>', "viewBox"),
        (b'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 nan 1"><rect/></svg>', "viewBox"),
    ],
)
def test_a_file_that_is_hostile_or_none_is_refused(content, why):
    with pytest.raises(BadInput, match=why):
        pixels_of(content)


def test_a_doctype_without_entities_is_read_without_loading_it():
    head = b'<?xml version="1.0"?><!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://127.0.0.1:9/svg11.dtd">'
    assert pixels_of(head + b'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 2 2"><circle cx="1" cy="1" r="1"/></svg>').shape[2] == 2


@pytest.mark.parametrize("flags", ["00", "01", "10", "11"])
def test_an_arc_begins_and_ends_where_it_is_told_and_keeps_its_radius(flags):
    large, sweep = flags
    outline = outline_of_path(f"M1 2 A3 3 0 {large}{sweep} 4 5")
    assert np.allclose(outline.vertices[[0, -1]], [(1, 2), (4, 5)])
    corners = outline.to_polygons(closed_only=False)[0]
    turn = np.diff(np.unwrap(np.arctan2(*np.diff(corners, axis=0).T[::-1])))
    assert (turn.sum() > 0.0) == (sweep == "1")
    length = np.linalg.norm(np.diff(corners, axis=0), axis=1).sum()
    small = 2.0 * np.arcsin(np.sqrt(18.0) / 6.0) * 3.0
    assert length == pytest.approx(6.0 * np.pi - small if large == "1" else small, rel=0.01)
