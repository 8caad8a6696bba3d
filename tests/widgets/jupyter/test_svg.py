"""Tiny plots: places, shares and words."""

from xml.etree import ElementTree as ET

import numpy as np
import pytest

from mechstyle_widgets.jupyter.svg import Frame, drawing, shares


def test_a_drawing_is_xml_that_a_screen_reader_can_tell():
    frame = Frame(0.0, 10.0)
    parts = [frame.axes("x < y [MPa]", (0.0, 10.0)), frame.curve([0, 10], [0, 1]), frame.bars([1, 0, 0.5]), frame.mark(3.0, "a & b")]
    svg = ET.fromstring(drawing(frame, parts, 'so "many" <things>'))
    assert (svg.get("role"), svg.get("aria-label")) == ("img", 'so "many" <things>')


@pytest.mark.parametrize("value", [0.0, 0.4, 1.0])
def test_words_at_a_mark_stay_inside(value):
    frame = Frame(0.0, 1.0)
    words = "a rather long remark on it"
    head = ET.fromstring(f"<g>{frame.mark(value, words)}</g>")[1]
    half = 0.5 * 5.2 * len(words)
    assert half <= float(head.get("x")) <= frame.width - half


def test_shares_add_up_and_outliers_count_to_the_nearest():
    found = shares(np.array([-1.0, 0.1, 0.6, 5.0]), 0.0, 1.0, 2)
    assert found.tolist() == [0.5, 0.5]
