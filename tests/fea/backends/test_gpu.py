"""The CUDA path (`mechstyle.fea.backends.gpu`) against the CPU path; runs where there is a CUDA device, and says so where there is none."""

import numpy as np
import pytest
import warp as wp

from mechstyle.fea.drop import DropTest, drop
from mechstyle.fea.elasticity import LAWS
from mechstyle.fea.elements import ELEMENTS
from mechstyle.fea.orientations import directions

pytestmark = pytest.mark.skipif(
    not wp.get_cuda_device_count(), reason="NO CUDA DEVICE: the GPU drop test, its graphs and its agreement with the CPU were NOT tested"
)


@pytest.fixture(scope="module")
def tube_foot(box):
    """A plate-like part, 40 x 40 x 6 mm, 8640 tetrahedra: bending, contact of a face and of corners."""
    return box((20, 24, 3), (40.0, 40.0, 6.0), shake=0.1)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("element", ELEMENTS)
def test_cuda_and_cpu_agree(tube_foot, pla, element, law, friction):
    test = DropTest(law=law, friction=friction, window=0.3, element=element, plastic=law == "stable_neo_hookean")
    cpu, cuda = (drop(tube_foot, pla, directions(8), test, device=device) for device in ("cpu", "cuda"))
    assert cpu.failure == cuda.failure == ""
    assert cuda.time_step == pytest.approx(cpu.time_step, rel=1e-3)
    # Two orders of summation in float32 over a whole bounce.
    difference = np.linalg.norm(cuda.von_mises - cpu.von_mises, axis=(1, 2)) / np.linalg.norm(cpu.von_mises, axis=(1, 2))
    assert difference.max() < 1e-3
    left = np.linalg.norm(cuda.plastic_strain - cpu.plastic_strain)
    assert left <= 5e-3 * np.linalg.norm(cpu.plastic_strain)
    assert cpu.plastic_strain.any() == test.plastic
    for ours, theirs in zip(cuda.history, cpu.history, strict=True):
        assert np.abs(ours.kinetic - theirs.kinetic).max() < 1e-3 * theirs.kinetic[0]
    assert (cuda.contact != cpu.contact).mean() < 1e-3


@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("stiffness", [30.0, 300.0, 3000.0])
def test_cuda_and_cpu_agree_on_a_penalty_floor(tube_foot, pla, stiffness, friction):
    test = DropTest(friction=friction, window=0.3, element="tet4", plastic=False, contact_stiffness=stiffness)
    cpu, cuda = (drop(tube_foot, pla, directions(8), test, device=device) for device in ("cpu", "cuda"))
    assert cpu.failure == cuda.failure == ""
    difference = np.linalg.norm(cuda.von_mises - cpu.von_mises, axis=(1, 2)) / np.linalg.norm(cpu.von_mises, axis=(1, 2))
    assert difference.max() < 2e-3
    for ours, theirs in zip(cuda.history, cpu.history, strict=True):
        assert np.abs(ours.contact_loss - theirs.contact_loss).max() < 1e-3 * theirs.kinetic[0]


def test_cuda_gives_the_same_bytes_twice_and_whatever_runs_beside(tube_foot, pla):
    test = DropTest(window=0.1)
    first, second = (drop(tube_foot, pla, directions(8), test, device="cuda") for _ in range(2))
    alone = drop(tube_foot, pla, directions(8)[3:4], test, device="cuda")
    assert first.von_mises.tobytes() == second.von_mises.tobytes()
    assert first.flow.tobytes() == second.flow.tobytes()
    assert first.history[3].kinetic.tobytes() == second.history[3].kinetic.tobytes()
    assert alone.von_mises[0].tobytes() == first.von_mises[3].tobytes()


def test_cuda_names_an_unstable_step(tube_foot, pla):
    result = drop(tube_foot, pla, directions(2), DropTest(safety=2.0), device="cuda")
    assert "unstable" in result.failure or "no longer finite" in result.failure
    assert np.isposinf(result.von_mises).all()


def test_cuda_follows_orientations_through_phases_of_their_own_as_the_cpu_does(box, pla):
    bar = box((15, 3, 1), (120.0, 20.0, 4.0))
    tilts = [[np.sin(angle), 0.0, np.cos(angle)] for angle in np.radians([0.0, 35.0, 35.0, 55.0])]
    cpu, cuda = (drop(bar, pla, tilts, device=device) for device in ("cpu", "cuda"))
    assert [len(phases) for phases in cuda.phases] == [len(phases) for phases in cpu.phases]
    assert len({len(phases) for phases in cpu.phases}) > 1
    for ours, theirs in zip(cuda.phases, cpu.phases, strict=True):
        np.testing.assert_allclose([phase.speed for phase in ours], [phase.speed for phase in theirs], rtol=0.01)
    peaks = [dropped.von_mises.max(axis=(1, 2)) for dropped in (cuda, cpu)]
    np.testing.assert_allclose(*peaks, rtol=0.05)
