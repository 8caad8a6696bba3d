"""One drop test of a part as it is: what it is held to, and what is refused before anything slow is done."""

from __future__ import annotations

from dataclasses import replace

import meshio
import msgspec
import numpy as np
import pytest

from mechstyle.errors import BadInput, SimulationFailed
from mechstyle.geometry.subdivision import subdivided
from mechstyle.records import sentences
from mechstyle.records.material import LIBRARY
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.simulation import meshes, simulator
from mechstyle.simulation import part_test as module
from mechstyle.simulation.drop_history import SHARES
from mechstyle.simulation.part import Workpiece
from mechstyle.simulation.part_test import simulate
from validation.meshes import box

PLA = LIBRARY["PLA"]


REFUSED = [
    ({"orientations": 0}, "orientations is 0"),
    ({"criterion": "robst"}, "did you mean 'robust'"),
    ({"poses": "restng"}, "did you mean 'resting'"),
    ({"standard": "en-71"}, "did you mean 'en71'"),
    ({"tolerance": "a hair"}, "tolerance"),
    ({"tolerance": -0.1}, "tolerance"),
]


@pytest.mark.parametrize(("setting", "said"), REFUSED)
def test_settings_are_refused_before_the_part_is_prepared(monkeypatch, cube, setting, said):
    monkeypatch.setattr(module, "prepare", lambda *_, **__: pytest.fail("the part was prepared first"))
    with pytest.raises(BadInput, match=said):
        simulate(cube, **setting)


# --- a whole drop of a block --------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def block():
    """A 12 x 10 x 16 mm block made ready without meshing it."""
    tets = box((4, 3, 4), (12.0, 10.0, 16.0))
    used, faces = np.unique(tets.boundary_faces, return_inverse=True)
    surface = SurfaceMesh(tets.vertices[used], faces.reshape(-1, 3))
    return Workpiece(surface, tets, np.full(len(used), 10.0, np.float32), stands=True)


@pytest.fixture(scope="module")
def drop_it(block, tmp_path_factory):
    """Drops the block, with a memory of its own."""

    def dropping(mesh=block.surface, part=block, **settings):
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv("MECHSTYLE_CACHE", str(tmp_path_factory.getbasetemp() / "memory"))
            patch.setattr(module, "prepare", lambda *_, **__: part)
            patch.setattr(module, "standardised", lambda *_: part.surface)
            return simulate(mesh, device="cpu", **{"orientations": 3, **settings})

    return dropping


@pytest.fixture(scope="module")
def found(drop_it):
    return drop_it()


def test_beside_its_original_a_part_is_judged_as_in_a_run(drop_it, found, block):
    """Alone it is judged by the same landings; its own original bends exactly as much."""
    compared = drop_it(original=block.surface)
    assert compared.original.landings == compared.simulation.landings == found.simulation.landings
    assert [row.landing for row in found.verdict.rows] == [row.landing for row in compared.verdict.rows]
    assert all(row.plain_permanent_set is None for row in found.verdict.rows)
    for row in compared.verdict.rows:
        assert row.plain_permanent_set == row.permanent_set
        assert row.outcome != "FAILS"
    assert (compared.simulation.carried, compared.simulation.thicker) == (1.0, 0.0), "what standardising changed is no relief"


def test_a_relief_that_the_tetrahedra_do_not_follow_leaves_a_doubt_beside_the_original(drop_it, block, monkeypatch):
    def refuse(*_, **__):
        raise SimulationFailed("fTetWild gave up")

    monkeypatch.setattr(meshes, "mesh_for_relief", refuse)
    finer = subdivided(block.surface, 4)
    part = replace(block, surface=finer, thickness=np.full(len(finer.vertices), 3.0, np.float32))
    relief = np.where(np.arange(len(finer.vertices)) < len(block.surface.vertices), 0.0, -0.2).astype(np.float32)
    compared = drop_it(finer.displaced(relief), part, original=finer, tolerance=50.0)
    assert compared.simulation.carried < 0.5
    assert (compared.verdict.passes, compared.verdict.sure) == (True, False)
    assert "the mesh is" in compared.verdict.doubt


def test_another_part_in_place_of_the_original_is_refused(drop_it, block):
    """The unsafe side: a box twenty times as large would raise the limit."""
    with pytest.raises(BadInput, match="is not its original"):
        drop_it(block.surface.moved(20.0 * block.surface.vertices), original=block.surface)


def test_what_bends_more_than_the_tolerance_fails_alone_and_is_no_worse_than_itself(drop_it, block):
    hard = {"height": "20 m", "tolerance": "0.01 mm"}
    alone, beside = drop_it(**hard), drop_it(**hard, original=block.surface)
    assert (alone.verdict.outcome, alone.verdict.deciding.allowed) == ("FAILS", 0.01)
    assert beside.verdict.outcome == "NO WORSE"
    assert {row.allowed for row in drop_it(height="20 m", tolerance=50.0).verdict.rows} == {50.0}


def test_energy_goes_somewhere_and_adds_up(block, found):
    course = found.course
    mass = PLA.density * block.tets.volumes.sum() * (1.0 + found.simulation.added_mass)
    assert course.energy == pytest.approx(mass * 9.81e-3 * 1500.0, rel=1e-5)  # m g h
    shares = [getattr(course, name) for name in SHARES]
    assert sum(shares) == pytest.approx(1.0, abs=1e-6)
    assert min(shares) >= 0.0


def test_the_peak_over_time_is_the_peak_of_the_drop(found):
    course = found.course
    # An average of maxima over the whole drop is no less than the largest average of maxima over a moment.
    assert 0.99 * found.simulation.landing_stress[0].max() < course.peak_stress <= found.simulation.landing_stress[0].max() * (1.0 + 1e-5)
    assert course.peak_time in found.impact.time
    assert 0.0 < course.peak_force_time <= course.contact_time < found.history.time[-1]
    assert len(found.history.kinetic) == len(found.history.time) > 20
    assert course.touches == ((0.0, pytest.approx(np.sqrt(2 * 9.81e-3 * 1500.0))),)
    assert course.touch_words == "It leaves the floor, no next touch."


def test_it_is_remembered_with_its_history(drop_it, found, monkeypatch):
    monkeypatch.setattr(simulator, "drop", lambda *_, **__: pytest.fail("it was dropped again"))
    again = drop_it()
    assert again.course == found.course
    assert np.array_equal(again.history.kinetic, found.history.kinetic)


def test_the_picture_is_of_the_worst_test_and_shows_what_stays_bent(drop_it, monkeypatch):
    """Its caption told what the verdict compared, under a picture of something else."""
    pictures, titles, bent = [], [], drop_it(height="20 m")
    with monkeypatch.context() as patch:
        patch.setattr(module, "picture", lambda shown, *, title, **_: (pictures.append(shown), titles.append(title)))
        bent.show()
        replace(bent, verdict=msgspec.structs.replace(bent.verdict, doubts=("Not sure: the mesh.",))).show()
    assert titles == [bent.verdict.short, f"{bent.verdict.short} (not sure)"]
    worst, panels = bent.verdict.deciding, pictures[0]
    assert [panel.title.partition(", drawn × ")[0] for panel in panels] == ["stress", "from the front", "from below", "what stays bent"]
    assert panels[0].note.startswith(f"{worst.landing}: ")
    assert panels[0].note.endswith("% of the surface yields")
    assert np.array_equal(panels[0].values, bent.simulation.stress_of(landing=worst.landing))
    assert panels[3].note == sentences.figures(worst)
    assert np.abs(panels[3].mesh.vertices - bent.surface.vertices).max() > 2.0 * worst.permanent_set, "exaggerated"
    assert bent.show().png[:4] == b"\x89PNG"
    assert bent.show_history().png[:4] == b"\x89PNG"


def test_the_file_for_paraview_holds_what_was_found(found, block, tmp_path):
    read = meshio.read(found.save_vtu(tmp_path / "block.vtu"))
    nodes, in_cells = read.point_data, {name: values[0] for name, values in read.cell_data.items()}
    assert set(nodes) == {"stays_bent", "stress", "contact"}
    assert in_cells["von_mises"].max() == pytest.approx(found.simulation.flat.maximum, rel=1e-6)
    assert np.array_equal(nodes["contact"] > 0, read.points[:, 2] < 1e-6)
    assert np.array_equal(read.points, block.tets.vertices)


def test_a_drop_that_failed_has_no_course_and_says_why(drop_it, monkeypatch, tmp_path):
    real = simulator.drop
    monkeypatch.setattr(simulator, "drop", lambda *args, **options: replace(real(*args, **options), failure="it blew up"))
    broken = drop_it(orientations=2)
    assert broken.verdict.head == "UNKNOWN: in the landing 'direction 1' it blew up."
    assert broken.course is None
    assert broken.show().png[:4] == b"\x89PNG"
    for wanted in (broken.show_history, lambda: broken.save_vtu(tmp_path / "x.vtu")):
        with pytest.raises(SimulationFailed, match="it blew up"):
            wanted()


def test_a_part_printed_in_layers_bends_no_less(drop_it):
    alike, layered = (drop_it(orientations=1, height="5 m", **more) for more in ({}, {"build_direction": "z"}))
    bends = np.array([[row.permanent_set for row in found.verdict.rows] for found in (alike, layered)])
    assert (bends[1] >= 0.98 * bends[0]).all()
    assert bends[1].sum() > bends[0].sum()
    with pytest.raises(BadInput, match="across its layers is not known"):
        drop_it(material="ABS", build_direction="z")


def test_landings_of_a_standard_are_named(drop_it):
    dropped = drop_it(orientations=None, standard="ista-1a")
    names = [landing.name for landing in dropped.simulation.landings]
    boxed = ["flat", *(landing.name for landing in dropped.simulation.landed("any landing"))]
    assert boxed[:3] == ["flat", "corner 2-3-5", "edge 2-3"]
    assert (len(boxed), len(set(names))) == (10, len(names))
    assert dropped.recipe.test.height == 760.0
    assert all(landing.fall == 760.0 for landing in dropped.simulation.landings)


def test_without_orientations_the_poses_bring_theirs(drop_it):
    for poses, drops in (("resting", 6), ("faces6", 6), ("fibonacci", 5)):
        found = drop_it(orientations=None, poses=poses).simulation
        assert 1 + len(found.landed("any landing")) == drops
        assert found.landed("nearly flat")


def test_without_nearly_flat_and_poses_it_is_dropped_flat_alone(drop_it):
    assert [landing.way for landing in drop_it(orientations=1, nearly_flat=False).simulation.landings] == ["flat"]
