"""The drop as placed in figures, curves and a file for ParaView: energies add up."""

from __future__ import annotations

from dataclasses import replace

import meshio
import msgspec
import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.fea.drop import DropTest, drop
from mechstyle.fea.elements import at_vertices
from mechstyle.records.material import LIBRARY
from mechstyle.simulation.drop_history import SHARES, Course, history_figures, history_picture, vtu_bytes, vtu_path
from mechstyle.simulation.impact import Impact
from support.records import landing
from validation.meshes import box

NORMALS = [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8]]


@pytest.fixture(scope="module")
def tets():
    return box((3, 2, 4), (12.0, 8.0, 16.0))


@pytest.fixture(scope="module")
def dropped(tets):
    return drop(tets, LIBRARY["PLA"], NORMALS, DropTest(window=0.2, element="tet4"), device="cpu")


@pytest.fixture(scope="module")
def impact(tets):
    """Three moments on the surface, the second with the highest stress, at vertex 5, and the shape that stays."""
    stress = np.ones((4, len(tets.vertices)), np.float32)
    stress[1, 5], stress[3] = 40.0, 45.0
    return Impact(np.array([0.0, 0.1, 0.2, 0.3]), np.zeros((4, len(tets.vertices), 3), np.float32), stress)


@pytest.fixture(scope="module")
def course(tets, dropped, impact):
    phases = dropped.phases[0]
    flat = landing(touches=tuple(phase.speed for phase in phases), ended=dropped.endings[0])
    return Course.of(dropped.history[0], flat, impact, tets.vertices)


def test_its_figures_are_those_of_the_drop(tets, dropped, impact, course):
    history = dropped.history[0]
    assert (course.peak_time, course.peak_stress) == (0.1, 40.0)
    assert course.peak_where == tuple(tets.vertices[5])
    assert course.peak_force == history.contact_force.max() > 0.0
    assert course.peak_force_time == history.time[history.contact_force.argmax()]
    assert history.contact_force[history.time > course.contact_time].max(initial=0.0) == 0.0
    assert course.energy == pytest.approx(LIBRARY["PLA"].density * 12.0 * 8.0 * 16.0 * 9.81e-3 * 1500.0, rel=0.02), "m g h"
    assert course.touches == ((0.0, pytest.approx(np.sqrt(2.0 * 9.81e-3 * 1500.0))),)


def test_what_became_of_the_energy_is_all_of_it(course):
    assert sum(getattr(course, name) for name in SHARES) == pytest.approx(1.0)


def test_further_touches_are_told_with_their_speed(course):
    again = msgspec.structs.replace(course, touches=((0.0, 5.4), (3.25, 1.5)), ended="nothing comes any more")
    assert again.touch_words == "It touches again after 3.2 ms at 1.5 m/s; nothing comes any more."


def test_the_curves_are_numbers_of_the_history(dropped):
    figures = history_figures(dropped.history[0])
    assert set(figures) >= {"time", "kinetic", "strain", "contact_force", "peak_stress"}
    assert all(len(values) == len(figures["time"]) for values in figures.values())
    assert figures["contact_force"] == dropped.history[0].contact_force.tolist()


def test_the_picture_is_drawn_also_where_the_part_flies(dropped, impact, course):
    history = dropped.history[0]
    flying = replace(history, phase=(history.time > 0.1).astype(np.int32))
    assert history_picture(flying, impact, course, 45.6).png.startswith(b"\x89PNG")


def test_the_file_holds_what_the_flat_landing_leaves_in_the_body(tets, dropped, tmp_path):
    (tmp_path / "drop.vtu").write_bytes(vtu_bytes(tets, dropped))
    read = meshio.read(tmp_path / "drop.vtu")
    np.testing.assert_array_equal(read.cells_dict["tetra"], tets.tets)
    np.testing.assert_allclose(read.point_data["stress"], at_vertices(tets, dropped.von_mises[0]), rtol=1e-5)
    np.testing.assert_allclose(read.point_data["stays_bent"], dropped.permanent[0], rtol=1e-5, atol=1e-9)
    assert np.array_equal(read.point_data["contact"] > 0, dropped.contact[0])
    np.testing.assert_array_equal(read.cell_data["von_mises"][0], dropped.von_mises[0].max(axis=1))


def test_other_endings_are_refused():
    with pytest.raises(BadInput, match=r"give part.vtu instead of part.vtk"):
        vtu_path("part.vtk")
