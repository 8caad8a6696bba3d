"""Bodies with less than the properties of a solid: cellular ones, and those that hold solid and cellular places."""

from dataclasses import fields, replace

import msgspec
import numpy as np
import pytest

from mechstyle.fea import drop as module
from mechstyle.fea.backends.gpu import DeviceBody
from mechstyle.fea.discretisation import Relative, discretise
from mechstyle.fea.drop import DropTest, drop
from mechstyle.fea.elements import ELEMENTS, QUADRATIC
from mechstyle.fea.linear_solvers import lowest_period
from mechstyle.fea.orientations import directions
from mechstyle.fea.statics import StaticTest
from mechstyle.records.load_cases import RESTING_FACE, Load, LoadCase, Support

TEST = DropTest(height=12000.0, window=0.4)


def even(tets, element, density, stiffness, strength):
    """The same everywhere."""
    shape = (len(tets.tets), ELEMENTS[element].points)
    return Relative(np.full(shape, density), np.full(shape, stiffness), np.full(shape, strength))


def random(tets, points=4):
    """Solid here, cellular there."""
    shell = np.random.default_rng(3).random((len(tets.tets), points)).round()
    return Relative(0.2 + 0.8 * shell, 0.1 + 0.9 * shell, 0.15 + 0.85 * shell)


@pytest.mark.parametrize("element", ELEMENTS)
@pytest.mark.parametrize("across", [(0.0, 0.0, 0.0), (0.0, 0.0, 1.8)])
def test_a_cellular_body_is_one_of_another_material(block, pla, element, across):
    """Stress recorded is that of its solid parts, to be held against the strength of the solid."""
    weak = msgspec.structs.replace(
        pla, youngs_modulus=0.2 * pla.youngs_modulus, yield_strength=0.25 * pla.yield_strength, hardening=0.25 * pla.hardening,
        density=0.4 * pla.density,
    )  # fmt: skip
    test = replace(TEST, element=element, across=across, added_mass=0.0)
    found = drop(block, pla, directions(2), test, device="cpu", relative=even(block, element, 0.4, 0.2, 0.25))
    other = drop(block, weak, directions(2), test, device="cpu")
    assert found.plastic_strain.max() > 0.01
    np.testing.assert_allclose(found.von_mises, other.von_mises / 0.25, rtol=2e-3, atol=0.1)
    np.testing.assert_allclose(found.permanent, other.permanent, atol=2e-4)
    for name in ("kinetic", "strain", "plastic_work", "contact_force"):
        one, two = (getattr(each.history[0], name) for each in (found, other))
        np.testing.assert_allclose(one, two, atol=2e-3 * np.abs(two).max())
    np.testing.assert_allclose(found.history[0].peak_stress, other.history[0].peak_stress / 0.25, rtol=5e-3, atol=0.1)
    assert found.time_step == pytest.approx(other.time_step, rel=1e-6)


@pytest.mark.parametrize("plastic", [True, False])
@pytest.mark.parametrize("element", ELEMENTS)
def test_the_plain_kernels_agree_on_what_is_solid_here_and_cellular_there(block, pla, monkeypatch, element, plastic):
    test, relative = replace(TEST, element=element, window=0.2, plastic=plastic), random(block, ELEMENTS[element].points)
    ours = drop(block, pla, directions(2), test, device="cpu", relative=relative)
    monkeypatch.setattr(module, "CoreBody", lambda body: DeviceBody(body, "cpu"))
    theirs = drop(block, pla, directions(2), test, device="cpu", relative=relative)
    np.testing.assert_allclose(ours.von_mises, theirs.von_mises, rtol=5e-3, atol=0.2)
    np.testing.assert_allclose(ours.permanent, theirs.permanent, atol=5e-4)
    for name in (one.name for one in fields(ours.history[0])):
        one, two = (getattr(each.history[1], name) for each in (ours, theirs))
        np.testing.assert_allclose(one, two, atol=5e-3 * max(np.abs(two).max(), 1e-9))


def test_energy_is_conserved(block, pla):
    test = replace(TEST, damping=0.0, safety=0.6)
    found = drop(block, pla, directions(3), test, device="cpu", relative=random(block))
    assert found.failure == ""
    history = found.history[-1]
    assert np.abs(history.damping_loss).max() < 2e-3 * history.kinetic[0]
    assert history.plastic_work[-1] > 0.05 * history.kinetic[0]


def test_an_elastic_body_shows_the_stress_of_its_solid_parts(block, pla):
    test = replace(TEST, plastic=False)
    relative = even(block, "tet10", 1.0, 1.0, 0.5)
    solid, weak = (drop(block, pla, directions(1), test, device="cpu", relative=one) for one in (None, relative))
    np.testing.assert_allclose(weak.von_mises, 2.0 * solid.von_mises, rtol=1e-6)


def test_period_and_mass_follow(block, pla):
    solid = discretise(block, pla, 0.0, QUADRATIC)
    cellular = discretise(block, pla, 0.0, QUADRATIC, even(block, "tet10", 0.25, 0.01, 0.05))
    assert cellular.masses.sum() == pytest.approx(0.25 * solid.masses.sum())
    assert lowest_period(cellular) == pytest.approx(5.0 * lowest_period(solid), rel=1e-3)


def test_weight_is_that_of_the_plastic(block, pla):
    resting = LoadCase(name="lies", supports=(Support(at=RESTING_FACE),), loads=(Load(gravity=1.0, direction=(0.0, 0.0, -1.0)),))
    relative = even(block, "tet10", 0.25, 0.1, 0.1)
    reactions = StaticTest(block, (resting,)).run(block, pla, relative=relative)["lies"].reactions
    assert reactions[:, 2].sum() == pytest.approx(0.25 * pla.density * block.volumes.sum() * 9.81e-3, rel=1e-6)
