"""The stable step: of one oscillator, and of bodies with tetrahedra as bad as a mesher makes them."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigvalsh

from mechstyle.fea.discretisation import discretise
from mechstyle.fea.drop import DropTest, drop
from mechstyle.fea.elasticity import stiffness_matrix
from mechstyle.fea.elements import ELEMENTS
from mechstyle.fea.explicit import damped_step, stable_step
from mechstyle.fea.mass_scaling import bound
from mechstyle.fea.orientations import directions
from mechstyle.records.mesh import TetMesh

each_element = pytest.mark.parametrize("element", ELEMENTS.values(), ids=ELEMENTS)


def quality(tets):
    """6 sqrt(2) V over the cube of the root mean square edge: 1 for a regular tetrahedron, 0 for a flat one."""
    corners = tets.vertices[tets.tets]
    edges = corners[:, [0, 0, 0, 1, 1, 2]] - corners[:, [1, 2, 3, 2, 3, 3]]
    return 6.0 * np.sqrt(2.0) * tets.volumes / (edges**2).sum(axis=2).mean(axis=1) ** 1.5


def with_slivers(tets, seed):
    """Inner vertices moved at random, then one pressed against the face before it until a tetrahedron is a sliver of quality 0.05."""
    rng = np.random.default_rng(seed)
    vertices = tets.vertices.copy()
    inner = np.setdiff1d(np.arange(len(vertices)), tets.boundary_faces)
    cell = np.cbrt(tets.volumes.mean())
    vertices[inner] += 0.25 * cell * rng.uniform(-1.0, 1.0, (len(inner), 3))
    moved = tets.moved(vertices)
    chosen = int(rng.choice(np.flatnonzero(np.isin(moved.tets, inner).any(axis=1))))
    corner = next(vertex for vertex in moved.tets[chosen] if vertex in inner)
    others = moved.vertices[moved.tets[chosen][moved.tets[chosen] != corner]]
    start, centre = vertices[corner].copy(), others.mean(axis=0)
    for share in np.linspace(0.0, 1.0, 400):
        vertices[corner] = start + share * (centre - start)
        squeezed = tets.moved(vertices)
        if not (squeezed.volumes > 0.0).all():
            break
        moved = squeezed
        if quality(moved).min() < 0.05:
            break
    return moved


def weighted(body, material, weights):
    """Eigenvalues of M⁻¹ Σ w_e K_e by a dense solver, from the reference's stiffness of one tetrahedron after the other."""
    masses = np.repeat(body.masses[body.place], 3)
    total = np.zeros((len(masses), len(masses)))
    mesh = body.mesh
    for place, number in enumerate(body.tet_order):
        single = replace(mesh, tets=TetMesh(mesh.tets.vertices, mesh.tets.tets[[number]]), connectivity=mesh.connectivity[[number]])
        vars(single)["nodes"] = mesh.nodes
        total += weights[place] * stiffness_matrix(single, material).toarray()
    root = masses**-0.5
    return eigvalsh(root[:, None] * total * root)


@pytest.mark.parametrize(("omega", "beta"), [(4000.0, 0.0), (4000.0, 1e-4), (300.0, 1e-2)])
def test_the_stable_step_is_the_edge_between_decay_and_growth(omega, beta):
    def last_amplitude(step):
        u, v = 1.0, 0.0
        for _ in range(4000):
            v -= step * omega**2 * (u + beta * v)
            u += step * v
        return abs(u) + abs(v) / omega

    limit = stable_step(omega, beta)
    assert limit <= 2.0 / omega
    assert last_amplitude(0.99 * limit) < 50.0
    assert not last_amplitude(1.01 * limit) < 1e6, "infinite, or no longer a number"


@each_element
@pytest.mark.parametrize("seed", [None, 0, 1, 2])
def test_the_bound_is_above_the_largest_frequency_and_close(seed, element, box, pla):
    tets = box((2, 2, 2), (6.0, 6.0, 6.0), shake=0.2) if seed is None else with_slivers(box((2, 2, 2), (6.0, 6.0, 6.0)), seed)
    body = discretise(tets, pla, 0.0, element)
    weights = np.random.default_rng(0).uniform(0.5, 1.5, len(body.volumes))
    for each in (np.ones(len(weights)), weights):
        exact = weighted(body, pla, each)[-1]
        assert exact <= bound(body.stiffness.weighted_norms(each), body.masses, body.highest) < 1.6 * exact


@each_element
@pytest.mark.parametrize("seed", [0, 1])
def test_the_assembled_body_allows_the_damped_step_on_slivers(seed, element, box, pla):
    """Δt² K + 2 Δt C ≤ 4 M, by the reference."""
    body = discretise(with_slivers(box((2, 2, 2), (6.0, 6.0, 6.0)), seed), pla, 0.01, element)
    step, damping = damped_step(body, 0.1)
    assert weighted(body, pla, step**2 + 2.0 * step * damping)[-1] <= 4.0
    undamped, none = damped_step(body, 0.0)
    assert weighted(body, pla, np.full(len(none), undamped**2))[-1] <= 4.0
    assert not none.any()
    # (2/ω)(sqrt(1 + ξ²) − ξ), ω the same bound: never longer, and little shorter.
    assert 0.75 < step / (undamped * (np.sqrt(1.01) - 0.1)) <= 1.0 + 1e-12


def test_each_tetrahedron_is_damped_by_the_same_share_of_its_own_critical_damping(block, pla):
    body = discretise(block, pla, 0.01, ELEMENTS["tet10"])
    damping = damped_step(body, 0.1)[1]
    products = damping * body.frequencies
    np.testing.assert_allclose(products, products[0], rtol=1e-12)
    highest = int(body.frequencies.argmax())
    limit = bound(body.stiffness.norms, body.masses, body.highest)
    assert damping[highest] == pytest.approx(0.2 / np.sqrt(limit))


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("damping", [0.0, 0.1])
def test_no_drop_of_a_body_with_slivers_diverges(seed, damping, box, pla):
    tets = with_slivers(box((3, 3, 3), (9.0, 9.0, 9.0)), seed)
    assert quality(tets).min() < 0.06
    result = drop(tets, pla, directions(3), DropTest(window=0.15, damping=damping, added_mass=0.0), device="cpu")
    assert result.failure == ""


@each_element
@pytest.mark.parametrize("damping", [0.0, 0.1])
def test_a_step_a_twentieth_above_the_limit_is_found_out_by_its_energy(element, damping, box, pla):
    tets = box((2, 2, 2), (6.0, 6.0, 6.0), shake=0.2)
    body = discretise(tets, pla, 0.0, element)
    step, each = damped_step(body, damping)
    K, C = (weighted(body, pla, weights)[-1] for weights in (np.ones(len(each)), each))
    limit = (np.sqrt(C**2 + 4.0 * K) - C) / K  # Δt² K + 2 Δt C = 4; both are highest in the stiffest tetrahedron
    for share, stable in ((0.97, True), (1.05, False)):
        test = DropTest(window=0.3, damping=damping, added_mass=0.0, safety=share * limit / step, element=element.name)
        failure = drop(tets, pla, directions(2), test, device="cpu").failure
        assert failure == "" if stable else "unstable" in failure or "no longer finite" in failure
