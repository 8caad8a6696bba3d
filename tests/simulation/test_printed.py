"""Walls and solid layers in tetrahedra, beside what a slicer would lay."""

import itertools

import numpy as np
import pytest

from mechstyle.records.infill import PATTERNS
from mechstyle.records.recipe import Printed
from mechstyle.simulation.printed import plastic_share, printed_body, shell_shares
from support.records import recipe
from validation.meshes import box

SIZE = (30.0, 25.0, 10.0)
UP = (0.0, 0.0, 1.0)


def share(tets, shell):
    return float(tets.volumes @ shell.mean(axis=1) / tets.volumes.sum())


@pytest.mark.parametrize("counts", [(8, 7, 3), (16, 14, 6)])
@pytest.mark.parametrize(("walls", "top", "bottom"), [(3, 5, 4), (1, 0, 0), (0, 10, 0), (0, 0, 0), (6, 2, 8)])
def test_the_shell_of_a_box_has_the_volume_that_a_slicer_fills(counts, walls, top, bottom):
    tets, printed = box(counts, SIZE), Printed(infill=0.15, walls=walls, top=top, bottom=bottom)
    wide, high = walls * 0.42, (top + bottom) * 0.2
    core = (SIZE[0] - 2.0 * wide) * (SIZE[1] - 2.0 * wide) * (SIZE[2] - high)
    assert share(tets, shell_shares(tets, printed, UP)) == pytest.approx(1.0 - core / np.prod(SIZE), abs=0.025)


def test_layers_lie_across_the_build_direction():
    tets, printed = box((16, 14, 6), SIZE), Printed(infill=0.15, walls=0, top=10, bottom=10)
    for axis, up in enumerate(np.eye(3)):
        assert share(tets, shell_shares(tets, printed, tuple(up))) == pytest.approx(4.0 / SIZE[axis], abs=0.025)
    tall, only_top = tets.vertices[tets.tets].mean(axis=1)[:, 2] > 5.0, Printed(infill=0.15, walls=0, top=10, bottom=0)
    assert shell_shares(tets, only_top, UP)[~tall].max() < 0.05 < shell_shares(tets, only_top, UP)[tall].max()
    assert shell_shares(tets, only_top, (0.0, 0.0, -2.0))[tall].max() < 0.05


def test_more_walls_never_mean_less_shell_and_a_thin_part_is_all_shell():
    tets = box((16, 14, 2), (30.0, 25.0, 1.7))
    assert shell_shares(tets, Printed(infill=0.15), UP).min() > 0.9
    tets = box((8, 7, 3), SIZE)
    shares = [shell_shares(tets, Printed(infill=0.15, walls=walls), UP) for walls in range(8)]
    assert all((more >= less).all() for less, more in itertools.pairwise(shares))


def test_what_each_place_has_lies_between_infill_and_plastic():
    tets, one = box((8, 7, 3), SIZE), recipe(infill=0.15)
    relative = printed_body(tets, one)
    density, stiffness, strength = PATTERNS["gyroid"].relative(0.15)
    for found, least in ((relative.density, density), (relative.stiffness, stiffness), (relative.strength, strength)):
        assert least - 1e-12 <= found.min() < found.max() <= 1.0 + 1e-12
    assert relative.stiffness.shape == relative.strength.shape == (len(tets.tets), 4)
    assert printed_body(tets, recipe(infill=0.15, element="tet4")).stiffness.shape == (len(tets.tets), 1)
    assert plastic_share(tets, one) == pytest.approx(tets.volumes @ relative.density.mean(axis=1) / tets.volumes.sum())


def test_a_solid_part_has_nothing_of_it():
    tets = box((4, 3, 2), SIZE)
    assert printed_body(tets, recipe()) is None
    assert printed_body(tets, recipe(walls=1, top=0)) is None
    assert plastic_share(tets, recipe()) == 1.0


@pytest.mark.parametrize("pattern", PATTERNS)
def test_infill_is_denser_stiffer_and_stronger_the_more_there_is_and_never_more_than_plastic(pattern):
    shares = np.linspace(0.0, 1.0, 41)
    found = np.array([PATTERNS[pattern].relative(share) for share in shares])
    assert (np.diff(found, axis=0) >= 0.0).all()
    assert (found[:, 1:] <= found[:, :1]).all()
    assert (found > 0.0).all()
    assert PATTERNS[pattern].source
