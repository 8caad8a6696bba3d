"""The drop as placed in figures, curves and a file for ParaView: energies add up, and an error of the balance is said."""

from __future__ import annotations

from dataclasses import replace

import meshio
import msgspec
import numpy as np
import pytest

from mechstyle.fea.drop import DropTest, drop
from mechstyle.fea.elements import LINEAR, with_nodes
from mechstyle.fea.permanent_set import at_nodes
from mechstyle.fea.snapshots import Snapshot
from mechstyle.records.material import LIBRARY
from mechstyle.simulation.drop_history import SHARES, Course, history_figures, history_picture, vtu_bytes
from mechstyle.simulation.impact import Impact
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
    return Course.of(dropped, impact, tets.vertices, 0.004)


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


@pytest.mark.parametrize(("error", "said"), [(0.004, "within 1 %"), (0.02, "NOT within 1 %"), (None, "could not be checked")])
def test_a_balance_that_does_not_close_is_said(course, error, said):
    words = msgspec.structs.replace(course, balance_error=error).words
    assert said in words
    assert ("NOT" in words) is (error == 0.02)


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


@pytest.mark.parametrize("each", [False, True])
def test_the_file_holds_stress_and_contact_of_the_flat_landing_and_the_largest_of_all(tets, dropped, each, tmp_path):
    still = Snapshot(with_nodes(tets, LINEAR), np.arange(len(tets.vertices)), 0.1, np.full((len(tets.vertices), 3), 2.0, np.float32))
    (tmp_path / "drop.vtu").write_bytes(vtu_bytes(tets, dropped, still, each=each))
    read = meshio.read(tmp_path / "drop.vtu")
    fields = np.stack([at_nodes(tets, LINEAR.at_corners(points)) for points in dropped.von_mises])
    np.testing.assert_allclose(read.point_data["stress"], fields[0], rtol=1e-5)
    np.testing.assert_allclose(read.point_data["stress_envelope"], fields.max(axis=0), rtol=1e-5)
    assert np.array_equal(read.point_data["contact"] > 0, dropped.contact[0])
    np.testing.assert_allclose(read.point_data["displacement"], 2.0)
    np.testing.assert_allclose(read.point_data["deformation"], 0.0, atol=1e-4)
    np.testing.assert_allclose(read.point_data["stays_bent"], dropped.permanent[0], rtol=1e-5, atol=1e-9)
    assert ("stress_01" in read.point_data) is each
