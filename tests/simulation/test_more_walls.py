"""The thinnest wall that is printed, and what two more walls come to."""

from dataclasses import replace

import numpy as np
import pytest

from mechstyle.loop.objects import Memo, Objects
from mechstyle.records.load_cases import Load, LoadCase, Patch, Support
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.records.sentences import bend
from mechstyle.simulation.more_walls import shell_words, thinnest_shell, with_more_walls
from mechstyle.simulation.printed import plastic_share
from support.dropped_block import simulator
from support.records import recipe
from validation.meshes import box

PRINT = {"infill": 0.0, "walls": 1, "top": 1, "bottom": 1, "layer_height": 0.4}


def wedge(slope):
    """A block of 20 mm whose top leans by an angle [degrees]."""
    tets = box((4, 4, 4), (20.0, 20.0, 20.0))
    vertices = tets.vertices.copy()
    vertices[:, 2] *= 1.0 + np.tan(np.radians(slope)) * (vertices[:, 0] - 10.0) / 20.0
    moved = tets.moved(vertices)
    return SurfaceMesh(moved.vertices, moved.boundary_faces)


@pytest.mark.parametrize(("slope", "found"), [(0.0, 0.8), (30.0, max(1.26 * 0.5, 3**0.5 / 2.0)), (40.0, 1.26 * np.sin(np.radians(40.0)))])
def test_the_shell_is_thinnest_on_slopes(slope, found):
    assert thinnest_shell(wedge(slope), recipe(infill=0.15)) == pytest.approx(min(found, 0.8), abs=0.01)
    assert f"{min(found, 0.8):.2f} mm" in shell_words(wedge(slope), recipe(infill=0.15))


def test_a_slope_of_few_layers_is_thinner_than_walls_and_layers():
    steep = recipe(infill=0.15, top=5, bottom=20)
    assert thinnest_shell(wedge(0.0), steep) == pytest.approx(1.0)
    assert thinnest_shell(wedge(42.0), steep) == pytest.approx(0.843, abs=0.01)
    assert shell_words(wedge(42.0), recipe()) == ""


@pytest.fixture
def beam(tmp_path):
    """A simulator of a hollow beam that is printed in one wall, held at one end, with a force on the other [N]."""
    tets = box((12, 3, 3), (60.0, 10.0, 10.0))
    block, memo = (tets.boundary, tets), Memo(tmp_path / "memo", Objects(tmp_path / "objects"))
    near, far = Patch(plane=(0.0, 0.0, 0.0, -1.0, 0.0, 0.0)), Patch(plane=(60.0, 0.0, 0.0, 1.0, 0.0, 0.0))

    def made(force, **printed):
        case = LoadCase(name="push", supports=(Support(at=near),), loads=(Load(at=far, force=(0.0, 0.0, -force)),))
        return simulator(block, memo, orientations=1, element="tet10", height=50.0, loads=(case,), **{**PRINT, **printed})

    return made


def judged(one):
    """A simulator's part by itself, and the verdict on it."""
    return one.baseline, one.judge(one.baseline, alone=True)


def test_two_more_walls_are_offered_where_they_make_it_hold_as_tested(beam):
    one = beam(50.0)
    simulation, verdict = judged(one)
    assert verdict.outcome == "FAILS"
    thicker = replace(one, recipe=one.recipe.with_settings(walls=3))
    again = judged(thicker)[1]
    assert again.outcome == "HOLDS"
    words, tets, density = with_more_walls(one, simulation, verdict), one.part.tets, one.recipe.test.material.density
    more = density * tets.volumes.sum() * (plastic_share(tets, thicker.recipe) - plastic_share(tets, one.recipe))
    assert words.startswith("with 2 more walls it HOLDS: at worst ")
    assert words.endswith(f"and it weighs {more:.1f} g more")
    assert bend(again.deciding.permanent_set) in words


def test_nothing_is_offered_where_they_do_not_help_where_it_holds_or_of_a_solid_part(beam):
    hopeless, holds, solid = beam(300.0), beam(10.0), beam(300.0, infill=1.0)
    assert judged(hopeless)[1].outcome == "FAILS"
    assert with_more_walls(hopeless, *judged(hopeless)) == ""
    assert judged(holds)[1].outcome == "HOLDS"
    assert with_more_walls(holds, *judged(holds)) == ""
    assert judged(solid)[1].outcome == "FAILS"
    assert with_more_walls(solid, *judged(solid)) == ""
