"""The shapes models are made of, against areas and volumes known in closed form."""

import math

import numpy as np
import pytest
from manifold3d import CrossSection, Error, Manifold

from mechstyle.errors import BadInput
from mechstyle.gallery import _solids


def sound(body):
    assert body.status() == Error.NoError
    assert len(body.decompose()) == 1
    return body


@pytest.mark.parametrize("radius", [0.5, 3.0, 20.0, 60.0])
def test_circles_are_as_round_as_promised(radius):
    sides = _solids.segments(radius)
    assert sides % 8 == 0
    assert radius * (1 - math.cos(math.pi / sides)) <= max(_solids.SAGITTA, 0.3 * radius / 8) + 1e-9


def test_softening_rounds_outer_corners_and_fills_inner_ones():
    square = CrossSection.square((20, 20))
    assert _solids.softened(square, 3.0, 1.0).area() == pytest.approx(400 - (4 - math.pi) * 9, rel=1e-3)
    notched = square - CrossSection.square((10, 10))
    filled = _solids.softened(notched, 1e-3, 2.0).area() - notched.area()
    assert filled == pytest.approx((1 - math.pi / 4) * 4, rel=0.05)


def test_a_slab_is_a_prism_less_its_chamfer_and_round():
    radius, height, foot, top = 20.0, 10.0, 1.0, 2.0
    body = sound(_solids.slab(_solids.disc(radius), height, foot=foot, top=top))
    # Pappus: section times the way of its centroid; a triangle below, a square less a quarter disc above.
    chamfer = foot**2 / 2 * 2 * math.pi * (radius - foot / 3)
    round_ = (1 - math.pi / 4) * top**2 * 2 * math.pi * (radius - top * (1 - 2 / 3 / (4 - math.pi)))
    assert body.volume() == pytest.approx(math.pi * radius**2 * height - chamfer - round_, rel=3e-3)
    assert body.bounding_box() == pytest.approx((-20, -20, 0, 20, 20, 10))


def test_a_bar_is_its_side_view_times_its_width():
    side = CrossSection.square((20, 8))
    assert sound(_solids.bar(side, 12.0, 0.0)).volume() == pytest.approx(20 * 8 * 12)
    body = sound(_solids.bar(_solids.softened(side, 2.0, 1.0), 12.0, 1.0))
    assert body.bounding_box() == pytest.approx((0, -6, 0, 20, 6, 8), abs=1e-3)


def test_a_pocket_leaves_a_round_lip_and_floor():
    block = Manifold.cube((60, 60, 20), center=True).translate((0, 0, -10))
    body = sound(block - _solids.pocket(_solids.box(30, 30, 8), 12.0, floor=4.0, flare=1.0))
    assert body.slice(-1e-6).area() == pytest.approx(3600 - _solids.box(32, 32, 9).area(), rel=1e-3)
    assert body.slice(-6.0).area() == pytest.approx(3600 - _solids.box(30, 30, 8).area(), rel=1e-3)
    assert body.slice(-12.0 - 1e-6).area() == pytest.approx(3600)


def test_turning_a_line_gives_a_cylinder_and_a_sphere():
    assert sound(_solids.turned([(10, 0), (10, 7)])).volume() == pytest.approx(math.pi * 700, rel=3e-3)
    turn = np.linspace(-math.pi / 2 + 1e-3, math.pi / 2 - 1e-3, 60)
    arc = np.column_stack([10 * np.cos(turn), 10 * np.sin(turn)])
    assert sound(_solids.turned(arc)).volume() == pytest.approx(4000 / 3 * math.pi, rel=5e-3)


def test_a_closed_skin_is_a_torus():
    u, v = np.linspace(0, 2 * math.pi, 90, endpoint=False), np.linspace(0, 2 * math.pi, 40, endpoint=False)
    radius = 20 + 5 * np.cos(v)[:, None]
    rings = np.stack([radius * np.cos(u), radius * np.sin(u), np.broadcast_to(5 * np.sin(v)[:, None], (40, 90))], axis=-1)
    torus = sound(_solids.skinned(rings, closed=True))
    assert torus.genus() == 1
    assert torus.volume() == pytest.approx(2 * math.pi**2 * 20 * 25, rel=1e-2)


def test_a_swept_bar_has_its_section_and_length():
    body = sound(_solids.swept([(0, 0), (0, 10), (0, 30)], np.full((3, 2), (8.0, 4.0)), power=2.0))
    assert body.volume() == pytest.approx(math.pi * 4 * 2 * 30, rel=2e-2)
    assert body.bounding_box() == pytest.approx((-4, -2, 0, 4, 2, 30))


def test_what_is_not_one_body_is_refused():
    apart = Manifold.cube((1, 1, 1)) + Manifold.cube((1, 1, 1)).translate((5, 0, 0))
    for body in (apart, Manifold()):
        with pytest.raises(BadInput, match="one solid body"):
            _solids.standing(body)
