"""The numpy reference against calculus and textbook solutions."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import eigh
from scipy.optimize import brentq
from scipy.spatial import Delaunay
from scipy.spatial.transform import Rotation

from mechstyle.errors import BadInput
from mechstyle.fea import elasticity
from mechstyle.fea.elasticity import LAWS, StableNeoHookean, equivalent_stress, law_named, von_mises
from mechstyle.fea.elements import ELEMENTS, LINEAR, QUADRATIC, with_nodes
from mechstyle.records.material import LIBRARY, Material
from mechstyle.records.mesh import TetMesh
from support import hyperelasticity

PLA = LIBRARY["PLA"]
SEEDS = st.integers(0, 2**32 - 1)
each_law = pytest.mark.parametrize("name", LAWS)
each_element = pytest.mark.parametrize("element", ELEMENTS.values(), ids=ELEMENTS)


def irregular_tets():
    """A Delaunay mesh of 27 random points about a grid."""
    grid = np.stack(np.meshgrid(*[np.arange(3.0)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    points = grid + 0.1 * np.random.default_rng(3).uniform(-1.0, 1.0, grid.shape)
    tets = Delaunay(points).simplices
    volumes = TetMesh(points, tets).volumes
    return TetMesh(points, np.where(volumes[:, None] > 0, tets, tets[:, [0, 2, 1, 3]])[np.abs(volumes) > 1e-2])


def random_gradients(seed, size):
    return size * np.random.default_rng(seed).standard_normal((5, 3, 3))


@each_law
@given(seed=SEEDS)
def test_stress_is_the_derivative_of_energy(name, seed):
    law, H, step = law_named(name, PLA), random_gradients(seed, 0.1), 1e-6
    numeric = np.empty_like(H)
    for i, j in np.ndindex(3, 3):
        change = np.zeros((3, 3))
        change[i, j] = step
        up, down = (hyperelasticity.energy_density(law, H + sign * change) for sign in (1.0, -1.0))
        numeric[:, i, j] = (up - down) / (2.0 * step)
    # Central differences: truncation ~1e-12 relative, rounding 1e-16 Ψ / step ~ 1e-7 MPa against stresses of 100 MPa.
    np.testing.assert_allclose(hyperelasticity.first_piola(law, H), numeric, rtol=1e-6, atol=1e-4)


@each_law
@each_element
@given(seed=SEEDS)
def test_force_is_minus_the_gradient_of_strain_energy(element, name, seed):
    mesh, law, step = with_nodes(irregular_tets(), element), law_named(name, PLA), 1e-6
    u = 0.05 * np.random.default_rng(seed).standard_normal(mesh.nodes.shape)
    forces = hyperelasticity.internal_forces(mesh, law, u)
    for vertex, axis in ((0, 0), (13, 1), (len(u) - 1, 2)):
        change = np.zeros_like(u)
        change[vertex, axis] = step
        up, down = (hyperelasticity.strain_energy(mesh, law, u + sign * change) for sign in (1.0, -1.0))
        assert forces[vertex, axis] == pytest.approx(-(up - down) / (2.0 * step), rel=1e-5, abs=1e-4)


@each_law
@each_element
def test_rigid_motion_gives_no_stress(element, name, block):
    law, Q, mesh = law_named(name, PLA), Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix(), with_nodes(block, element)
    u = mesh.nodes @ Q.T - mesh.nodes + [3.0, -2.0, 5.0]
    H = elasticity.displacement_gradients(mesh, u)
    # Rounding only: 1e-16 relative of numbers of order one, times moduli of 5000 MPa.
    assert np.abs(hyperelasticity.first_piola(law, H)).max() < 1e-9
    assert np.abs(hyperelasticity.internal_forces(mesh, law, u)).max() < 1e-8
    assert abs(hyperelasticity.strain_energy(mesh, law, u)) < 1e-9


@each_law
@given(seed=SEEDS)
def test_energy_does_not_see_a_rotation_and_stress_turns_with_it(name, seed):
    law, H = law_named(name, PLA), random_gradients(seed, 0.1)
    Q = Rotation.random(random_state=seed).as_matrix()
    turned = Q @ (np.eye(3) + H) - np.eye(3)
    np.testing.assert_allclose(hyperelasticity.energy_density(law, turned), hyperelasticity.energy_density(law, H), rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(hyperelasticity.first_piola(law, turned), Q @ hyperelasticity.first_piola(law, H), rtol=1e-9, atol=1e-7)


@each_law
def test_small_strain_is_hookes_law(name):
    law, H = law_named(name, PLA), random_gradients(0, 1e-7)
    strain = 0.5 * (H + H.transpose(0, 2, 1))
    hooke = 2.0 * PLA.shear_modulus * strain + PLA.lame_lambda * elasticity.trace(strain)[:, None, None] * np.eye(3)
    # The laws differ from Hooke's by the strain itself, 1e-7, times a few.
    np.testing.assert_allclose(hyperelasticity.first_piola(law, H), hooke, rtol=0, atol=3e-6 * np.abs(hooke).max())


@each_law
def test_uniaxial_tension_gives_youngs_modulus_and_poissons_ratio(name):
    law, axial = law_named(name, PLA), 1e-3

    def stress(lateral):
        return hyperelasticity.first_piola(law, np.diag([axial, lateral, lateral])[None])[0]

    lateral = brentq(lambda value: stress(value)[1, 1], -axial, 0.0, xtol=1e-15)
    assert stress(lateral)[0, 0] / axial == pytest.approx(PLA.youngs_modulus, rel=0.01)
    assert -lateral / axial == pytest.approx(PLA.poisson_ratio, rel=0.01)


def test_lame_constants_put_in_directly_would_be_a_quarter_too_soft():
    law = StableNeoHookean(PLA.shear_modulus, PLA.lame_lambda)

    def stress(lateral):
        return hyperelasticity.first_piola(law, np.diag([1e-6, lateral, lateral])[None])[0]

    lateral = brentq(lambda value: stress(value)[1, 1], -1e-6, 1e-6, xtol=1e-18)
    assert 0.70 < stress(lateral)[0, 0] / 1e-6 / PLA.youngs_modulus < 0.80


@given(young=st.floats(10.0, 1e5), poisson=st.floats(0.0, 0.49))
def test_lame_round_trip(young, poisson):
    material = Material(name="m", youngs_modulus=young, poisson_ratio=poisson, density=1e-3, yield_strength=0.02 * young)
    la, mu = material.lame_lambda, material.shear_modulus
    assert mu * (3 * la + 2 * mu) / (la + mu) == pytest.approx(young, rel=1e-9)
    assert la / (2 * (la + mu)) == pytest.approx(poisson, abs=1e-9)


@each_law
@each_element
def test_patch_test_an_affine_displacement_is_reproduced_without_inner_forces(element, name, block):
    mesh = with_nodes(block, element)
    gradient = np.array([[1e-3, 2e-4, 0.0], [-3e-4, 5e-4, 1e-4], [2e-4, 0.0, -8e-4]])
    u = mesh.nodes @ gradient.T
    found = elasticity.displacement_gradients(mesh, u)
    np.testing.assert_allclose(found, np.broadcast_to(gradient, (len(block.tets), element.points, 3, 3)), atol=1e-15)
    forces = hyperelasticity.internal_forces(mesh, law_named(name, PLA), u)
    inner = np.all((mesh.nodes > 1e-9) & (mesh.nodes < np.array([12.0, 10.0, 16.0]) - 1e-9), axis=1)
    assert inner.any()
    assert np.abs(forces[inner]).max() < 1e-11 * np.abs(forces).max() * len(block.tets)
    np.testing.assert_allclose(forces.sum(axis=0), 0.0, atol=1e-9)


@each_law
@each_element
def test_stiffness_matrix_is_the_linearisation_of_the_forces(element, name, block):
    mesh = with_nodes(block, element)
    law, u, step = law_named(name, PLA), np.random.default_rng(0).standard_normal(mesh.nodes.shape), 1e-6
    difference = hyperelasticity.internal_forces(mesh, law, step * u) - hyperelasticity.internal_forces(mesh, law, -step * u)
    numeric = -difference.ravel() / (2.0 * step)
    K = elasticity.stiffness_matrix(mesh, PLA)
    np.testing.assert_allclose(K @ u.ravel(), numeric, rtol=0, atol=1e-8 * np.abs(numeric).max())
    assert np.abs(K - K.T).max() < 1e-9


@each_element
def test_stiffness_matrix_knows_the_six_rigid_motions(element, block):
    mesh = with_nodes(block, element)
    K = elasticity.stiffness_matrix(mesh, PLA)
    for axis in np.eye(3):
        for motion in (np.broadcast_to(axis, mesh.nodes.shape), np.cross(axis, mesh.nodes)):
            assert np.abs(K @ motion.ravel()).max() < 1e-8


def test_element_frequency_is_the_largest_eigenvalue_of_the_element(block):
    closed = elasticity.element_frequencies(block, PLA)
    for index in (0, 100, 287):
        single = type(block)(block.vertices[block.tets[index]], np.arange(4)[None])
        assert closed[index] == pytest.approx(largest_frequency(with_nodes(single, LINEAR)), rel=1e-9)


def largest_frequency(single):
    """Of one element on its own, by its whole eigenproblem [rad/ms]."""
    masses = elasticity.lumped_masses(single, PLA.density * single.tets.volumes)
    root = np.repeat(masses, 3) ** -0.5
    K = elasticity.stiffness_matrix(single, PLA).toarray()
    return float(np.sqrt(eigh(root[:, None] * K * root, eigvals_only=True)[-1]))


@given(seed=SEEDS, flat=st.floats(0.02, 1.0))
def test_a_quadratic_element_vibrates_about_twice_as_fast_as_the_linear_one_whatever_its_shape(seed, flat):
    corners = np.random.default_rng(seed).standard_normal((4, 3))
    corners[3] = corners[:3].mean(axis=0) + flat * corners[3]
    order = [0, 1, 2, 3] if np.linalg.det(corners[1:] - corners[0]) > 0 else [0, 2, 1, 3]
    single = TetMesh(corners[order], [[0, 1, 2, 3]])
    ratio = largest_frequency(with_nodes(single, QUADRATIC)) / elasticity.element_frequencies(single, PLA)[0]
    assert 1.9 < ratio < 2.6, "slivers of linear elements are those of quadratic ones"


@each_element
def test_lumped_masses_add_up_to_the_mass(element, block):
    masses = elasticity.lumped_masses(with_nodes(block, element), PLA.density * block.volumes)
    assert masses.sum() == pytest.approx(PLA.density * 12.0 * 10.0 * 16.0, rel=1e-12)
    assert (masses > 0).all()


@pytest.mark.parametrize(
    ("stress", "expected"),
    [
        (np.diag([7.0, 0.0, 0.0]), 7.0),
        (np.diag([5.0, 5.0, 5.0]), 0.0),
        (np.diag([-3.0, 0.0, 3.0]), np.sqrt(27.0)),
        (np.array([[0.0, 2.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, 0.0]]), np.sqrt(12.0)),
    ],
)
def test_von_mises_of_textbook_states(stress, expected):
    assert elasticity.von_mises(stress[None])[0] == pytest.approx(expected, abs=1e-12)


@each_law
def test_cauchy_stress_is_symmetric_and_agrees_with_piola_at_small_strain(name):
    law = law_named(name, PLA)
    large, small = random_gradients(1, 0.1), random_gradients(1, 1e-8)
    sigma = hyperelasticity.cauchy_stress(large, hyperelasticity.first_piola(law, large))
    np.testing.assert_allclose(sigma, sigma.transpose(0, 2, 1), atol=1e-9 * np.abs(sigma).max())
    P = hyperelasticity.first_piola(law, small)
    np.testing.assert_allclose(hyperelasticity.cauchy_stress(small, P), P, atol=1e-6 * np.abs(P).max())


def test_an_unknown_law_is_named_with_the_known_ones():
    with pytest.raises(BadInput, match=r"'neo_hookean'.*stable_neo_hookean"):
        law_named("neo_hookean", PLA)


# --- printed layers -----------------------------------------------------------------------------------------------

LAYERS = np.array([0.0, 0.0, 1.0]) / 0.5


def pulled(direction, size=10.0):
    """Uniaxial stress [MPa]."""
    unit = np.asarray(direction, dtype=float) / np.linalg.norm(direction)
    return size * np.outer(unit, unit)


def test_a_pull_across_layers_counts_as_their_share_of_the_strength_asks_for():
    assert equivalent_stress(pulled([0, 0, 1]), LAYERS) == pytest.approx(20.0)
    assert equivalent_stress(pulled([1, 2, 0]), LAYERS) == pytest.approx(10.0), "along the layers nothing changes"
    assert equivalent_stress(pulled([0, 0, 1], -10.0), LAYERS) == pytest.approx(10.0), "pressure keeps layers together"
    assert equivalent_stress(pulled([0, 0, 1]), -LAYERS) == pytest.approx(20.0), "a direction and its opposite are one"


def test_shear_between_layers_counts_by_the_shear_strength_of_von_mises():
    shear = np.zeros((3, 3))
    shear[0, 2] = shear[2, 0] = 10.0
    assert equivalent_stress(shear) == pytest.approx(np.sqrt(3.0) * 10.0)
    assert equivalent_stress(shear, LAYERS) == pytest.approx(2.0 * np.sqrt(3.0) * 10.0)
    pull = shear + pulled([0, 0, 1], -1e4)
    assert equivalent_stress(pull, LAYERS) == pytest.approx(von_mises(pull)), "what is left of shear under pressure is small beside it"


def test_a_hydrostatic_pull_that_von_mises_does_not_see_pulls_layers_apart():
    assert von_mises(10.0 * np.eye(3)) == pytest.approx(0.0)
    assert equivalent_stress(10.0 * np.eye(3), LAYERS) == pytest.approx(20.0)


def test_layers_never_make_a_stress_look_smaller_and_turn_with_the_part():
    rng = np.random.default_rng(5)
    stress = rng.normal(size=(50, 3, 3))
    stress = stress + np.swapaxes(stress, 1, 2)
    turn, across = Rotation.from_rotvec([0.3, 1.0, -0.4]).as_matrix(), rng.normal(size=3)
    of_layers = equivalent_stress(stress, across)
    assert np.all(of_layers >= von_mises(stress))
    np.testing.assert_allclose(equivalent_stress(turn @ stress @ turn.T, turn @ across), of_layers)
    assert np.array_equal(equivalent_stress(stress), von_mises(stress))
    assert np.all(equivalent_stress(stress, 2.0 * across) >= of_layers), "weaker layers"
