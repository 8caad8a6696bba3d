from dataclasses import replace

import numpy as np
import pytest

from mechstyle.pictures.figure import Panel, figure

SMALL = {"panel_size": (140, 120)}


def words(sheet):
    return [text.get_text() for axes in sheet.axes for text in axes.texts] + [text.get_text() for text in sheet.texts]


def bars(sheet):
    return [axes for axes in sheet.axes if axes.axison]


def stress(part, top):
    return np.linspace(0.0, top, len(part.vertices))


def test_panels_of_one_field_share_a_bar_that_names_unit_and_limit(ball):
    panels = [Panel(ball, name, stress(ball, top), "MPa", "von Mises stress", threshold=45.6) for name, top in (("a", 20.0), ("b", 90.0))]
    sheet = figure(panels, title="both", **SMALL)
    assert len(bars(sheet)) == 1
    assert bars(sheet)[0].get_xlim() == pytest.approx((0.0, 90.0))
    assert {"a", "b", "both", "von Mises stress [MPa]", "limit 45.6"} <= set(words(sheet))


def test_the_greatest_value_is_marked_and_said_where_it_is_hidden(ball):
    values = np.zeros(len(ball.vertices))
    values[ball.vertices[:, 1].argmin()] = 33.3  # towards the viewer
    seen = words(figure([Panel(ball, "", values, "MPa", "stress", view="front")], **SMALL))
    assert "max 33.3 MPa" in seen
    hidden = words(figure([Panel(ball, "", values[_mirrored(ball)], "MPa", "stress", view="front")], **SMALL))
    assert "max 33.3 MPa (far side)" in hidden


def test_a_bar_says_what_its_threshold_is_and_two_kinds_have_two_bars(ball):
    """0.2 of stress was called a limit, and so was 45.6 of bend."""
    bend = Panel(ball, "", stress(ball, 0.3), "mm", "what stays bent", (0.0, 0.3), 0.2, edge="allowed")
    yields = Panel(ball, "", stress(ball, 90.0), "MPa", "stress", None, 45.6, edge="yields at")
    sheet = figure([bend, replace(bend, edge="limit"), yields], **SMALL)
    assert {"allowed 0.2", "limit 0.2", "yields at 45.6"} <= set(words(sheet))


def _mirrored(ball):
    """Index of the vertex opposite in y, so that a field turns to the far side."""
    flipped = ball.vertices * (1, -1, 1)
    return np.array([np.linalg.norm(ball.vertices - spot, axis=1).argmin() for spot in flipped])


def test_parts_of_one_place_and_size_share_a_camera_so_that_growth_shows(block):
    grown = block.moved(block.vertices * 1.05)
    far = block.moved(block.vertices * 2)
    pictures = [axes.images[0].get_array() for axes in figure([Panel(block), Panel(grown), Panel(far)], **SMALL).axes]
    dark = [(picture.min(axis=2) < 200).mean() for picture in pictures]
    assert dark[1] > 1.05 * dark[0]
    assert dark[2] == pytest.approx(dark[1], rel=0.02)  # alone in its box: fitted by itself


def test_pictures_are_drawn_pixel_by_pixel(block):
    sheet = figure([Panel(block, "x")], **SMALL)
    sheet.canvas.draw()
    drawn = np.asarray(sheet.canvas.buffer_rgba())[..., :3]
    picture = np.asarray(sheet.axes[0].images[0].get_array())
    box = sheet.axes[0].get_window_extent()
    top, left = drawn.shape[0] - round(box.y1), round(box.x0)
    assert (drawn[top : top + 120, left : left + 140] == picture).all()


@pytest.mark.parametrize("apart", [1, 2, 5])
def test_words_at_the_greatest_and_least_value_do_not_cover_each_other(ball, apart):
    values = np.full(len(ball.vertices), 10.0)
    nearest = np.linalg.norm(ball.vertices - ball.vertices[ball.vertices[:, 1].argmin()], axis=1).argsort()
    values[nearest[[0, apart]]] = (33.3, 1.1)
    sheet = figure([Panel(ball, "", values, "MPa", "stress", view="front")], panel_size=(300, 260))
    renderer = sheet.canvas.get_renderer()
    one, other = [text.get_window_extent(renderer) for text in sheet.axes[0].texts if text.get_text().startswith(("max", "min"))]
    assert not one.overlaps(other)
