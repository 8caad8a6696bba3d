"""One drop test of a part as it is: what it is held to, and what is refused before anything slow is done."""

from __future__ import annotations

from dataclasses import replace

import meshio
import msgspec
import numpy as np
import pytest

from mechstyle.errors import BadInput, SimulationFailed
from mechstyle.records import Measures, Simulation
from mechstyle.records.material import LIBRARY
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.simulation import part_test as module
from mechstyle.simulation import simulator
from mechstyle.simulation.part import Workpiece
from mechstyle.simulation.part_test import judge_alone, simulate
from mechstyle.simulation.simulator import DropSimulator
from mechstyle.simulation.validation.meshes import box

PLA = LIBRARY["PLA"]


def simulation(peak, maximum=100.0, failure=""):
    measured = Measures(peak=peak, surface=peak, p999=peak, p99=0.5 * peak, maximum=maximum, where=(1.0, 2.0, 3.0), volume=100.0)
    one = np.zeros(1)
    return Simulation(
        displacement=one, stress=one, envelope=one, probability=one, contact=one > 0, as_placed=measured, overall=measured,
        backed_off=0.0, deviation=0.0, time_step=1e-4, steps=100, added_mass=0.0, failure=failure,
    )  # fmt: skip


def test_a_part_above_yield_fails_although_it_is_its_own_original():
    verdict = judge_alone(simulation(1.3 * PLA.yield_strength), PLA, "robust")
    assert verdict.outcome == "FAILS"
    assert verdict.deciding.limit == PLA.yield_strength
    assert "above the 45.6 MPa at which generic PLA yields" in verdict.words


def test_a_part_below_yield_is_viable_whatever_its_literal_maximum():
    assert judge_alone(simulation(0.5 * PLA.yield_strength), PLA, "robust").outcome == "VIABLE"
    assert judge_alone(simulation(0.5 * PLA.yield_strength), PLA, "paper").outcome == "FAILS"


def test_tilted_landings_of_a_part_alone_are_told_but_not_judged():
    tilted = msgspec.structs.replace(simulation(20.0).as_placed, peak=90.0, surface=90.0)
    verdict = judge_alone(replace(simulation(20.0), tilted=tilted), PLA, "robust")
    assert (verdict.outcome, verdict.tilted) == ("VIABLE", None)
    assert verdict.words.endswith("Tilted by a few degrees its surface reaches 90.0 MPa and begins to yield.")
    calm = judge_alone(replace(simulation(20.0), tilted=simulation(30.0).as_placed), PLA, "robust")
    assert calm.words.endswith("its surface reaches 30.0 MPa.")


def test_there_is_nothing_to_compare_all_orientations_with():
    verdict = judge_alone(simulation(20.0), PLA, "robust")
    assert verdict.all_orientations is None
    assert "orientations" not in verdict.words


@pytest.mark.parametrize("broken", [simulation(0.0, failure="it blew up"), simulation(np.nan)], ids=["failed", "not a number"])
def test_what_was_not_computed_is_unknown(broken):
    assert judge_alone(broken, PLA, "robust").outcome == "UNKNOWN"


def test_the_peak_itself_is_left_as_it_was_measured():
    one = simulation(20.0)
    assert judge_alone(one, PLA, "robust").as_placed.value == 20.0


REFUSED = [
    ({"orientations": 0}, "orientations is 0"),
    ({"criterion": "robst"}, "did you mean 'robust'"),
    ({"poses": "restng"}, "did you mean 'resting'"),
    ({"standard": "en-71"}, "did you mean 'en71'"),
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

    def dropping(mesh=block.surface, **settings):
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv("MECHSTYLE_CACHE", str(tmp_path_factory.getbasetemp() / "memory"))
            patch.setattr(module, "prepare", lambda *_, **__: block)
            return simulate(mesh, device="cpu", **{"orientations": 3, **settings})

    return dropping


@pytest.fixture(scope="module")
def found(drop_it):
    return drop_it()


def test_beside_its_original_a_part_is_judged_as_in_a_run(drop_it, found, block):
    """Alone the other landings have nothing to be compared with; its own original bears exactly as much."""
    compared = drop_it(original=block.surface)
    assert compared.original.as_placed == compared.simulation.as_placed == found.simulation.as_placed
    assert found.verdict.tilted is None
    assert compared.verdict.tilted.limit >= compared.simulation.tilted.surface
    assert compared.verdict.all_orientations.value == pytest.approx(1.0)
    assert "1.00 times the original's stress" in compared.verdict.words
    assert compared.simulation.least_carried == 1.0, "what standardising changed is no relief"


def test_a_relief_that_the_tetrahedra_do_not_carry_is_marginal_beside_the_original(drop_it, block):
    x, y, z = block.surface.vertices.T
    relief = (0.2 * np.sin(x) * np.cos(y) * np.cos(z)).astype(np.float32)
    compared = drop_it(block.surface.displaced(relief), original=block.surface)
    assert compared.simulation.carried < 0.1
    assert (compared.strength.verdict, compared.strength.marginal) == ("VIABLE", True)
    assert "its tetrahedra carry only" in compared.verdict.words


def test_another_part_in_place_of_the_original_is_warned_of(drop_it, block):
    """A box twenty times as large raised the limit, and the part was VIABLE without a word."""
    compared = drop_it(original=block.surface.moved(20.0 * block.surface.vertices))
    assert compared.warning.startswith("The original is 240 x 200 x 320 mm and the part 12 x 10 x 16 mm: they seem to be different parts")
    assert "different parts" not in drop_it(original=block.surface).warning


def test_a_part_alone_is_judged_and_not_warned_of_as_if_a_style_were_to_come(drop_it, block, found):
    """It FAILS, and then it read that the style is held to that peak instead: there is none, and nothing is held."""
    weak = msgspec.structs.replace(LIBRARY["PLA"], yield_strength=0.8 * found.simulation.as_placed.peak)
    alone, beside = drop_it(material=weak), drop_it(material=weak, original=block.surface)
    assert alone.verdict.outcome == "FAILS"
    assert "style" not in alone.warning
    assert "the style is held to that peak instead" in beside.warning


@pytest.mark.parametrize(("others", "confirms"), [("as much", True), ("half", False), ("refused", False)])
def test_what_the_original_reads_above_its_strength_excuses_only_what_other_tetrahedra_confirm(
    drop_it, block, found, monkeypatch, others, confirms
):
    """The unsafe side: with `--original` a splinter in its tetrahedra was an excuse, which a run asks others about."""
    raised, own, real = block.tets.moved(block.tets.vertices + 1e-6), found.simulation.as_placed.surface, DropSimulator.simulate

    def made(*_):
        if others == "refused":
            raise SimulationFailed("fTetWild gave up")
        return raised

    def read(self, displacement, *, thorough):
        told = real(self, displacement, thorough=thorough)
        if self.tets is not raised or others != "half":
            return told
        half = {name: 0.5 * getattr(told.as_placed, name) for name in ("peak", "surface", "contact")}
        return replace(told, as_placed=msgspec.structs.replace(told.as_placed, **half))

    monkeypatch.setattr(module, "others_at_rest", made)
    monkeypatch.setattr(DropSimulator, "simulate", read)
    weak = msgspec.structs.replace(PLA, yield_strength=0.7 * own)
    compared = drop_it(original=block.surface, material=weak)
    assert (compared.original.as_placed.surface == pytest.approx(own)) is confirms
    assert compared.strength.verdict == ("VIABLE" if confirms else "FAILS")
    if others == "refused":
        assert compared.verdict.as_placed.limit == pytest.approx(weak.yield_strength)


def test_an_original_below_its_strength_is_meshed_once(drop_it, block, monkeypatch):
    monkeypatch.setattr(module, "others_at_rest", lambda *_: pytest.fail("it excuses nothing"))
    assert drop_it(original=block.surface).verdict.viable


def test_energy_goes_somewhere_and_adds_up(block, found):
    course = found.course
    mass = PLA.density * block.tets.volumes.sum() * (1.0 + found.simulation.added_mass)
    assert course.energy == pytest.approx(mass * 9.81e-3 * 1500.0, rel=1e-5)  # m g h
    assert course.kinetic + course.strain + course.contact_loss + course.damping_loss == pytest.approx(1.0, abs=1e-6)
    assert min(course.kinetic, course.strain, course.contact_loss, course.damping_loss) >= 0.0
    assert 0.0 < course.balance_error < 1e-3
    assert "within 1 %" in course.words
    assert "NOT within" in msgspec.structs.replace(course, balance_error=0.02).words


def test_the_peak_over_time_is_the_peak_of_the_drop(found):
    course = found.course
    # An average of maxima over the whole drop is no less than the largest average of maxima over a moment.
    assert 0.99 * found.simulation.stress.max() < course.peak_stress <= found.simulation.stress.max() * (1.0 + 1e-5)
    assert course.peak_time in found.impact.time
    assert 0.0 < course.peak_force_time <= course.contact_time < found.history.time[-1]
    assert len(found.history.kinetic) == len(found.history.time) > 20
    assert course.touches == ((0.0, pytest.approx(np.sqrt(2 * 9.81e-3 * 1500.0))),)
    assert course.touch_words == "It leaves the floor, no next touch."


def test_it_is_remembered_with_its_history(drop_it, found, monkeypatch):
    monkeypatch.setattr(simulator, "drop", lambda *_, **__: pytest.fail("it was dropped again"))
    again = drop_it()
    assert again.course == found.course
    assert np.array_equal(again.detail.drop.von_mises, found.detail.drop.von_mises)


def test_the_pictures_show_the_sides_and_the_history(drop_it, found):
    several, alone = found.show().png, drop_it(orientations=1).show().png
    height = [int.from_bytes(png[20:24], "big") for png in (several, alone)]
    assert height[0] > 1.5 * height[1], "the worst of all orientations and the probability are a row of their own"
    assert found.show_history().png[:4] == b"\x89PNG"


def test_the_file_for_paraview_holds_what_was_found(found, block, tmp_path):
    read = meshio.read(found.save_vtu(tmp_path / "block.vtu"))
    at_nodes, in_cells = read.point_data, {name: values[0] for name, values in read.cell_data.items()}
    assert set(at_nodes) == {"displacement", "deformation", "robust_stress", "contact", "robust_stress_envelope", "failure_probability"}
    assert at_nodes["robust_stress"].max() == pytest.approx(found.simulation.as_placed.peak, rel=1e-5)
    assert at_nodes["failure_probability"].max() <= found.simulation.failure_probability + 1e-6
    assert np.array_equal(in_cells["von_mises"], found.detail.drop.von_mises[0].max(axis=1))
    assert in_cells["von_mises_envelope"].max() == found.detail.drop.von_mises.max()
    assert np.array_equal(at_nodes["contact"] > 0, read.points[:, 2] < 1e-6)
    assert len(read.points) > len(block.tets.vertices)  # middle nodes
    moved = at_nodes["displacement"] - at_nodes["deformation"]
    spread = np.linalg.norm((read.points + moved)[:, None] - (read.points + moved)[None, ::50], axis=2)
    np.testing.assert_allclose(spread, np.linalg.norm(read.points[:, None] - read.points[None, ::50], axis=2), atol=1e-4)  # rigid
    assert 0.0 < np.abs(at_nodes["deformation"]).max() < 0.5


def test_every_orientation_is_added_on_request(found, tmp_path):
    read = meshio.read(found.save_vtu(tmp_path / "block.vtu", each_orientation=True))
    for number, landing in enumerate(found.simulation.landings):
        assert read.point_data[f"robust_stress_{number:02}"].max() == pytest.approx(landing.measures.peak, rel=1e-5)
        assert read.cell_data[f"von_mises_{number:02}"][0].max() == pytest.approx(landing.measures.maximum, rel=1e-5)
        assert read.point_data[f"contact_{number:02}"].any()


def test_a_drop_that_failed_has_no_course_and_says_why(drop_it, monkeypatch, tmp_path):
    real = simulator.drop
    monkeypatch.setattr(simulator, "drop", lambda *args, **options: replace(real(*args, **options), failure="it blew up"))
    broken = drop_it(orientations=2)
    assert broken.strength.verdict == "UNKNOWN"
    assert broken.course is None
    assert broken.simulation.failure_probability is None
    assert broken.show().png[:4] == b"\x89PNG"
    for wanted in (broken.show_history, lambda: broken.save_vtu(tmp_path / "x.vtu")):
        with pytest.raises(SimulationFailed, match="it blew up"):
            wanted()


def test_a_part_printed_in_layers_is_nowhere_further_from_its_limit(drop_it):
    alike, layered = drop_it(orientations=1), drop_it(orientations=1, build_direction="x")
    for name in ("von_mises", "corners"):
        solid, weak = (getattr(found.detail.drop, name) for found in (alike, layered))
        assert np.all(weak >= solid * (1.0 - 1e-6))
        assert (weak / solid).max() > 1.2
    assert layered.impact.stress.max() >= alike.impact.stress.max(), "the history judges layers too"
    with pytest.raises(BadInput, match="across its layers is not known"):
        drop_it(material="ABS", build_direction="z")


def test_landings_of_a_standard_are_named_and_no_probabilities(drop_it, tmp_path):
    dropped = drop_it(orientations=None, standard="ista-1a")
    names = [landing.name for landing in dropped.simulation.landings]
    boxed = [name for name in names if not name.startswith("tilted")]
    assert boxed[:3] == ["as placed, face 3 (bottom)", "corner 2-3-5", "edge 2-3"]
    assert (len(boxed), len(set(names))) == (10, len(names))
    assert dropped.recipe.drop_height == 760.0
    assert dropped.simulation.overall is not None
    assert dropped.simulation.failure_probability is None
    assert not dropped.simulation.probability.any()
    assert "failure_probability" not in meshio.read(dropped.save_vtu(tmp_path / "block.vtu")).point_data


def test_without_orientations_the_poses_bring_theirs(drop_it):
    for poses, drops in (("resting", 6), ("faces6", 6), ("fibonacci", 5)):
        names = [landing.name for landing in drop_it(orientations=None, poses=poses).simulation.landings]
        assert len([name for name in names if not name.startswith("tilted")]) == drops
