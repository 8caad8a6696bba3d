"""Styles by region: each place gets its own, and where they meet there is no step."""

import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.styling.combination import BLEND, combined, places
from mechstyle.styling.dimensions import Dimensions
from mechstyle.styling.drawn import NEUTRAL, Target, target
from mechstyle.styling.prompt import read

WALL = 3.0
SIZE = Dimensions(amplitude=0.3, side="both", nozzle=0.0)


def drawn(mesh, prompt) -> Target:
    reading, wall = read(prompt), np.full(len(mesh.vertices), WALL)
    targets = [target(mesh, wish, SIZE, seed=0, thickness=wall, inward=0.25 * wall, outward=wall) for wish in reading.wishes]
    return combined(mesh, targets, places(reading, mesh, wall).shares)


def shares(mesh, prompt):
    return places(read(prompt), mesh, np.full(len(mesh.vertices), WALL)).shares


@pytest.fixture(scope="module")
def both(holder) -> Target:
    return drawn(holder, "outside: brick; rim 8: gold studs")


def test_each_place_has_the_relief_and_the_colours_of_its_own_style(holder, both, outside):
    brick, studs = drawn(holder, "brick"), drawn(holder, "gold studs")
    z = holder.vertices[:, 2]
    wall, band = outside & (z < 80.0), z > 99.9
    assert np.abs(both.displacement - brick.displacement)[wall].max() < 0.02
    assert np.abs(both.colour - brick.colour)[wall].max() < 0.02
    assert np.abs(both.displacement - studs.displacement)[band].max() < 0.05
    assert np.abs(both.colour - studs.colour)[band].max() < 0.1
    assert np.abs(brick.colour - studs.colour)[band].max() > 0.3


def test_what_no_place_covers_stays_plain(holder, both):
    radius, z = np.hypot(holder.vertices[:, 0], holder.vertices[:, 1]), holder.vertices[:, 2]
    well = (radius < 37.1) & (z > 3.9) & (z < 80.0)
    assert not both.displacement[well].any()
    assert np.allclose(both.colour[well], NEUTRAL)


def test_one_style_passes_into_the_next_without_a_step(holder):
    share = shares(holder, "top: brick; bottom: stone")
    assert np.allclose(share.sum(axis=0), 1.0, atol=1e-9)
    a, b = holder.edges.T
    steepest = (np.abs(share[0, a] - share[0, b]) / np.linalg.norm(holder.vertices[a] - holder.vertices[b], axis=1)).max()
    edge = np.sqrt(holder.face_areas.mean() * 4.0 / np.sqrt(3.0))
    assert steepest < 1.0 / max(BLEND, edge)
    middle = holder.vertices[:, 2] - 50.0
    assert np.all(share[0, middle > 2.0 * edge] == 1.0)
    assert np.all(share[0, middle < -2.0 * edge] == 0.0)


def test_the_smaller_place_counts_in_whatever_order_they_are_named(holder):
    one, other = shares(holder, "rim: studs; rest: brick"), shares(holder, "rest: brick; rim: studs")
    assert np.allclose(one, other[::-1], rtol=0.0, atol=1e-12)
    assert one[0].max() > 0.9


def test_a_place_that_is_spared_stays_plain(holder):
    share = shares(holder, "brick but not the top 30 mm")
    z = holder.vertices[:, 2]
    assert share[0, z > 90.0].max() < 0.02
    assert share[0, z < 50.0].min() > 0.98


def test_a_plain_place_may_have_a_colour(holder):
    gold = drawn(holder, "rim: plain gold; rest: brick")
    rim = holder.vertices[:, 2] > 99.9
    assert np.abs(gold.displacement[rim]).max() < 0.05
    assert gold.colour[rim, 0].min() > gold.colour[rim, 2].max() + 0.2


def test_a_style_for_the_whole_part_is_drawn_as_ever(holder):
    wall = np.full(len(holder.vertices), WALL)
    (wish,) = read("brick").wishes
    alone = target(holder, wish, SIZE, seed=0, thickness=wall, inward=0.25 * wall, outward=wall)
    assert drawn(holder, "brick").displacement.tobytes() == alone.displacement.tobytes()


def test_the_relief_stays_within_its_limits_and_does_not_fold(holder, both):
    assert both.displacement.min() >= -0.25 * WALL - 1e-6
    turned = np.einsum("ij,ij->i", holder.displaced(both.displacement).face_normals, holder.face_normals)
    assert turned.min() > 0.16


def test_the_notes_tell_how_much_of_the_surface_each_place_is(holder):
    notes = places(read("top: brick; rest: stone"), holder, np.full(len(holder.vertices), WALL)).notes
    assert [note.split(",")[0] for note in notes] == ["top: brick", "everywhere else: stone"]
    assert all(note.endswith("% of the surface") for note in notes)


def test_a_place_that_others_cover_is_told(holder):
    notes = places(read("stone; top: brick; bottom: wood"), holder, np.full(len(holder.vertices), WALL)).notes
    assert notes[0] == "everywhere else: stone, nothing: smaller or later places cover it all"


def test_a_place_this_part_does_not_have_is_refused(sphere):
    with pytest.raises(BadInput, match="the region 'rim' holds nothing of this part"):
        shares(sphere, "brick; rim: gold studs")


def test_places_that_leave_nothing_are_refused(holder):
    with pytest.raises(BadInput, match="leave nothing of the part"):
        shares(holder, "brick but not the top and not the bottom")


def test_a_second_colour_lies_in_the_low_places(fine_wall):
    plain, gold = drawn(fine_wall, "brick"), drawn(fine_wall, "brick with blue mortar")
    assert np.array_equal(plain.displacement, gold.displacement)
    low, high = np.quantile(plain.displacement, [0.02, 0.98])
    mortar, brick = plain.displacement < low + 0.2 * (high - low), plain.displacement > high - 0.2 * (high - low)
    assert np.all(gold.colour[mortar].argmax(axis=1) == 2)
    assert np.array_equal(gold.colour[brick], plain.colour[brick])
