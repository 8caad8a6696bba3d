"""How long a printer lays plastic: blocks whose lines can be counted, and what PrusaSlicer says."""

import numpy as np
import pytest
from manifold3d import Manifold

from mechstyle.geometry.bodies import shell_and_rest
from mechstyle.geometry.filaments import Painted
from mechstyle.geometry.print_time import COOL, CURVES, DENSITY, MOVE, SLOW, SOLID, SPARSE, SPEEDS, Slices, _cut
from mechstyle.geometry.remesh import surface_of
from mechstyle.geometry.threemf import Body, threemf_bytes, together
from support.slicer import hours_in, prusa_slicer

FOUR = ("#111111", "#F4F1E8", "#C0392B", "#2980B9")
SPACING = 0.45 - 0.2 * (1.0 - np.pi / 4.0)


def block(x, y, z):
    """A block in even triangles, standing on the floor."""
    return surface_of(Manifold.cube((x, y, z)).refine_to_length(0.8))


def halves(mesh):
    """One filament on each side of the middle."""
    return (mesh.vertices[:, 0] > mesh.vertices[:, 0].mean()).astype(np.int32)


def one(mesh):
    return np.zeros(len(mesh.vertices), np.int32)


def by_hand(x, y, spacing=SPACING):
    """Three walls around a rectangle: seconds, and the area within them."""
    walls = [2.0 * (x + y - 4.0 * spacing * (k + 0.5)) for k in range(3)]
    return CURVES * np.sum(walls / SPEEDS) + 3 * MOVE, (x - 6.0 * spacing) * (y - 6.0 * spacing)


@pytest.mark.parametrize(("height", "layers"), [(0.2, 60), (0.1, 120)])
def test_a_block_is_walls_solid_layers_and_infill(height, layers):
    spacing = 0.45 - height * (1.0 - np.pi / 4.0)
    walls, within = by_hand(40.0, 24.0, spacing)
    solid = 6 * 40.0 * 24.0
    filling = (solid / SOLID + (layers * within - solid) * DENSITY / SPARSE) / spacing
    mesh = block(40.0, 24.0, 12.0)
    assert Slices.of(mesh, height).seconds(one(mesh)) == pytest.approx(layers * walls + filling, rel=0.03)


def test_each_colour_of_a_layer_gets_walls_of_its_own():
    (whole, within), (half, within_half) = by_hand(40.0, 24.0), by_hand(20.0, 24.0)
    filling = (2.0 * within_half - within) * DENSITY / SPARSE / SPACING
    mesh = block(40.0, 24.0, 12.0)
    slices = Slices.of(mesh, 0.2)
    more = slices.seconds(halves(mesh)) - slices.seconds(one(mesh))
    assert more == pytest.approx(60 * (2.0 * half - whole + filling), rel=0.15)


def test_small_walls_are_slow_and_a_layer_takes_its_time_to_cool():
    rod = block(2.0, 2.0, 40.0)
    slowly, fast = 2.0 * 2.0 / SPACING / SLOW * CURVES, 200 * COOL
    assert 200 * slowly < Slices.of(rod, 0.2).seconds(one(rod)) == fast
    beam = block(9.0, 9.0, 40.0)
    _, within = by_hand(9.0, 9.0)
    lines = sum(4.0 * (9.0 - 2.0 * SPACING * (k + 0.5)) for k in range(3))
    filling = (6 * 81.0 / SOLID + (200 * within - 6 * 81.0) * DENSITY / SPARSE) / SPACING
    assert Slices.of(beam, 0.2).seconds(one(beam)) == pytest.approx(200 * (CURVES * lines / SLOW + 3 * MOVE) + filling, rel=0.06)


def test_a_layer_is_shared_out_to_the_nearest_places_of_its_outline(sphere):
    """Through the middle of a sphere in quarters: four sectors, each with two straight sides."""
    x, y, _ = sphere.vertices.T
    around, area = _cut(sphere, 0.1, 0.2).regions((2 * (x > 0.0) + (y > 0.0)).astype(np.int32))
    assert area == pytest.approx(4 * [25.0 * np.pi], rel=0.06)
    assert around == pytest.approx(4 * [20.0 + 5.0 * np.pi], rel=0.06)


def test_two_bodies_are_told_apart_where_they_meet(sphere):
    shell, rest = shell_and_rest(sphere, sphere, np.ones(len(sphere.vertices), dtype=bool), np.full(len(sphere.vertices), 20.0))
    paint = together((Body("shell", shell, 0), Body("rest", rest, 1)), FOUR[:2])
    around, area = _cut(paint.mesh, 0.1, 0.2).regions(paint.filament)
    assert sorted(area) == pytest.approx([np.pi * (100.0 - 9.16**2), np.pi * 9.16**2], rel=0.06)
    assert sorted(around) == pytest.approx([2.0 * np.pi * 9.16, 2.0 * np.pi * 19.16], rel=0.06)


@pytest.mark.parametrize("colours", ["one", "halves", "quarters"])
def test_prusaslicer_takes_about_as_long(colours, sphere, tmp_path):
    mesh = block(30.0, 24.0, 8.0) if colours == "halves" else sphere
    x, y, _ = mesh.vertices.T
    filament = {"one": one(mesh), "halves": halves(mesh), "quarters": (2 * (x > 0.0) + (y > 0.0)).astype(np.int32)}[colours]
    (tmp_path / "part.3mf").write_bytes(threemf_bytes(mesh, paint=Painted(mesh, FOUR, filament)))
    machine = ("--nozzle-diameter=0.4,0.4,0.4,0.4", "--filament-diameter=1.75,1.75,1.75,1.75", "--temperature=210,210,210,210")
    prusa_slicer("--export-gcode", *machine, "--layer-height=0.2", "-o", tmp_path / "part.gcode", tmp_path / "part.3mf")
    assert Slices.of(mesh, 0.2).seconds(filament) / 3600.0 == pytest.approx(hours_in((tmp_path / "part.gcode").read_text()), rel=0.3)
