"""Plastic flow of one element along prescribed paths, in both backends: against the reference, closed forms, and turned as a whole."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from mechstyle.fea.backends.cpu import CoreBody
from mechstyle.fea.backends.gpu import DeviceBody
from mechstyle.fea.discretisation import discretise
from mechstyle.fea.elasticity import energy_density, law_named, softened
from mechstyle.fea.elements import ELEMENTS
from mechstyle.fea.explicit import FLOW, STRAIN, TENSION
from mechstyle.records.mesh import TetMesh
from support import hyperelasticity
from support.plasticity import Point
from support.schemes import scheme_of

CORNERS = np.array([[0.0, 0.0, 0.0], [3.0, 0.2, 0.0], [0.1, 2.0, -0.3], [0.4, 0.5, 2.5]])
I = np.eye(3)


def kernels(discretisation):
    """The kernels that CUDA runs, on the CPU."""
    return DeviceBody(discretisation, "cpu")


@pytest.fixture(scope="module", params=ELEMENTS.values(), ids=ELEMENTS)
def body(pla, request):
    return discretise(TetMesh(CORNERS, [[0, 1, 2, 3]]), pla, 0.0, request.param)


class Element:
    """One element under a uniform deformation gradient."""

    def __init__(self, body, material, body_type, **changes):
        self.body = body
        strengths = {"yield_strength": material.yield_strength, "hardening": material.hardening} | changes
        self.shaped = body_type(body).shaped(scheme_of(body, material, **strengths))

    def to(self, F):
        """Brought to F; the Kirchhoff stress there [MPa], from Σ f ⊗ X = −V P."""
        moved = self.body.positions @ (F - I).T
        forces = self.shaped.forces(moved)
        self.shaped.keep(moved)
        return -(forces.T @ self.body.positions) / self.body.volumes.sum() @ F.T

    @property
    def flowed(self):
        """What has flowed, which has to be the same at all points."""
        states = self.shaped.plastic()[0, 0]
        np.testing.assert_allclose(states, np.broadcast_to(states[0], states.shape), atol=2e-6)
        return states[0]


@pytest.fixture(params=[CoreBody, kernels])
def element(body, pla, request):
    return Element(body, pla, request.param)


@pytest.fixture
def point(pla):
    return Point(law_named("stable_neo_hookean", pla), pla.yield_strength, pla.hardening)


def pulled(point, stretch):
    """F of uniaxial tension, the sides free of stress."""

    def side(lateral):
        return point.at(np.diag([stretch, lateral, lateral]))[1][1, 1]

    lateral = brentq(side, 0.7 * stretch**-0.5, 1.3 * stretch**-0.5, xtol=1e-14)
    return np.diag([stretch, lateral, lateral])


def sheared(amount):
    return I + amount * np.outer([1.0, 0.0, 0.0], [0.0, 1.0, 0.0])


def back_and_forth(size):
    return np.concatenate([np.linspace(0.0, size, 60), np.linspace(size, -size, 120), np.linspace(-size, size, 120)])


TURN = Rotation.from_rotvec([0.2, -0.3, 1.4])
SKEW = 0.05 * np.random.default_rng(1).standard_normal((3, 3))
PATHS = {
    "shear": [sheared(amount) for amount in np.linspace(0.0, 0.4, 200)],
    "cyclic shear": [sheared(amount) for amount in back_and_forth(0.08)],
    "cyclic stretch": [np.diag([1.0 + amount, 1.0 - 0.4 * amount, 1.0 - 0.5 * amount]) for amount in back_and_forth(0.06)],
    "crushed": [np.diag([stretch**-0.5, stretch**-0.5, 0.99 * stretch]) for stretch in np.linspace(1.0, 0.4, 300)],
    "skew and turned": [
        Rotation.from_rotvec(share * TURN.as_rotvec()).as_matrix() @ (I + share * SKEW) for share in np.linspace(0.0, 1.0, 200)
    ],
}


@pytest.mark.parametrize("path", PATHS)
def test_along_a_path_it_is_the_reference(path, element, point):
    for F in PATHS[path]:
        point, expected = point.at(F)
        found = element.to(F)
        # Moduli of 5000 MPa times the rounding of F, 1e-7, a few times, and the third order of elastic strain in what is called ε_p.
        np.testing.assert_allclose(found, expected, atol=0.05)
    plastic = element.flowed
    inverse = point.inverse - I
    np.testing.assert_allclose(plastic[:FLOW], inverse[[0, 1, 2, 0, 1, 2], [0, 1, 2, 1, 2, 0]], atol=2e-5 + 1e-4 * np.abs(inverse).max())
    np.testing.assert_allclose(plastic[[STRAIN, TENSION]], [point.strain, point.tension], rtol=2e-3, atol=2e-6)
    assert point.strain > 0.02


def test_tension_follows_the_hardening(element, point, pla):
    """True stress σ_y + h ε_p, with ln λ = ε_p + τ/E; the elastic law departs from Hooke's by a hundredth at these strains."""
    for stretch in np.linspace(1.0, 1.2, 100):
        F = pulled(point, stretch)
        point, _ = point.at(F)
        stress = element.to(F)
    strain = element.flowed[STRAIN]
    assert strain == element.flowed[TENSION]
    assert strain == pytest.approx(np.log(1.2) - stress[0, 0] / pla.youngs_modulus, rel=0.01)
    assert stress[0, 0] == pytest.approx(pla.yield_strength + pla.hardening * strain, rel=0.01)
    assert np.abs(stress - np.diag([stress[0, 0], 0.0, 0.0])).max() < 0.05


def test_shear_yields_at_the_strength_over_root_three(element, pla):
    for F in PATHS["shear"]:
        stress = element.to(F)
    strain = element.flowed[STRAIN]
    assert stress[0, 1] * np.sqrt(3.0) == pytest.approx(pla.yield_strength + pla.hardening * strain, rel=0.02)
    assert strain == pytest.approx((0.4 - stress[0, 1] / pla.shear_modulus) / np.sqrt(3.0), rel=0.02)


def test_pressure_alone_bends_nothing_and_what_is_crushed_is_not_in_tension(body, pla):
    element = Element(body, pla, CoreBody)
    element.to(0.9 * I)
    assert not element.shaped.plastic().any()
    for F in PATHS["crushed"]:
        element.to(F @ (0.97 * I))
    assert element.flowed[STRAIN] > 0.5
    assert element.flowed[TENSION] == 0.0


@pytest.mark.parametrize("body_type", [CoreBody, kernels])
def test_until_it_yields_it_is_the_elastic_law(body_type, body, pla):
    law, elastic = law_named("stable_neo_hookean", pla), Element(body, pla, body_type, yield_strength=1e9)
    F = I + 0.1 * np.random.default_rng(2).standard_normal((3, 3))
    np.testing.assert_allclose(elastic.to(F), hyperelasticity.first_piola(law, F - I) @ F.T, atol=0.01)
    assert not elastic.shaped.plastic().any()


def test_turned_as_a_whole_it_bears_the_same_stress_and_flows_no_further(element):
    F = PATHS["cyclic stretch"][70]
    for share in np.linspace(0.0, 1.0, 50):
        element.to(I + share * (F - I))
    F = I + 0.9 * (F - I)  # a little back, so that it is elastic again
    stress, before = element.to(F), element.flowed.copy()
    for angle in np.radians([30.0, 90.0, 180.0]):
        Q = Rotation.from_rotvec([0.0, 0.6 * angle, 0.8 * angle]).as_matrix()
        np.testing.assert_allclose(Q.T @ element.to(Q @ F) @ Q, stress, atol=0.02)
        np.testing.assert_array_equal(element.flowed, before)


@pytest.mark.parametrize("body_type", [CoreBody, kernels])
def test_layers_that_bear_less_flow_sooner(body_type, body, pla):
    """Pulled across layers of half the strength it flows at half the stress; along them as if there were none."""
    strains = []
    for across in ((0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (0.0, 0.0, 2.0)):
        element = Element(body, pla, body_type, across=across)
        for stretch in np.linspace(1.0, 1.03, 100):
            stress = element.to(np.diag([stretch, stretch**-0.5, stretch**-0.5]))
        strains.append(element.flowed[STRAIN])
        assert element.shaped.peak().max() == pytest.approx(pla.yield_strength + pla.hardening * strains[-1], rel=0.02)
        if across == (2.0, 0.0, 0.0):
            assert 2.0 * stress[0, 0] == pytest.approx(pla.yield_strength, rel=0.05)
    assert strains[1] > 1.1 * strains[0], "by the elastic strain that it bears no longer"
    assert strains[2] == pytest.approx(strains[0], rel=1e-4)


@pytest.mark.parametrize("body_type", [CoreBody, kernels])
def test_where_the_step_asks_for_it_a_crushed_element_is_softer(body_type, body, pla):
    """By the same factor in both backends, and by as much as is said; its strength is the same."""
    F = np.diag([2.0**0.5, 2.0**0.5, 0.5])
    hard, soft = (Element(body, pla, body_type, shares=share) for share in (0.0, 0.9))
    for element in (hard, soft):
        for share in np.linspace(0.0, 1.0, 200):
            element.to(I + share * (F - I))
    A = soft.flowed[None, :FLOW].astype(float)
    factor = float(softened(A, 0.9)[0])
    assert 0.2 < factor < 0.4
    eased = F @ np.diag([1.0, 1.0, 1.002])
    law = law_named("stable_neo_hookean", pla)
    assert energy_density(law, (F - I)[None], A, np.array(0.9)) == pytest.approx(
        factor * energy_density(law, (F - I)[None], A, np.array(0.0)))  # fmt: skip
    slopes = [(element.to(eased) - before)[2, 2] for element, before in ((element, element.to(F)) for element in (soft, hard))]
    assert slopes[0] == pytest.approx(slopes[1] * factor, rel=0.1)
    assert soft.shaped.peak().max() == pytest.approx(pla.yield_strength + pla.hardening * soft.flowed[STRAIN], rel=0.02)


def test_the_energy_of_what_has_not_flowed_is_that_of_the_elastic_law(pla):
    law, H = law_named("stable_neo_hookean", pla), 0.1 * np.random.default_rng(3).standard_normal((5, 3, 3))
    found = energy_density(law, H, np.zeros((5, 6)), np.array(0.9))
    np.testing.assert_allclose(found, hyperelasticity.energy_density(law, H), rtol=1e-12)


def test_stress_after_flow_is_the_derivative_of_the_energy(point):
    F = PATHS["skew and turned"][-1]
    point, _ = point.at(F)
    assert point.strain > 0.0
    A = (point.inverse - I)[[0, 1, 2, 0, 1, 2], [0, 1, 2, 1, 2, 0]]
    elastic = replace(point, strength=1e9)
    for i, j in np.ndindex(3, 3):
        change = np.zeros((3, 3))
        change[i, j] = 1e-6
        up, down = (energy_density(point.law, F - I + sign * change, A, np.array(0.0)) for sign in (1.0, -1.0))
        P = elastic.at(F)[1] @ np.linalg.inv(F).T
        assert (up - down) / 2e-6 == pytest.approx(P[i, j], abs=1e-4)
