"""The stable step: of one oscillator, and of bodies with tetrahedra as bad as a mesher makes them."""

import numpy as np
import pytest

from mechstyle.fea.discretisation import bound, discretise
from mechstyle.fea.drop import DropTest, drop
from mechstyle.fea.elements import ELEMENTS
from mechstyle.fea.explicit import damped_step, stable_step
from mechstyle.fea.orientations import directions
from support.slivers import quality, weighted, with_slivers

each_element = pytest.mark.parametrize("element", ELEMENTS.values(), ids=ELEMENTS)


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


@each_element
def test_the_step_is_stable_with_every_node_on_a_penalty_floor(element, box, pla):
    """Δt² (K + k) + 2 Δt C ≤ 4 M, by the reference; a step that knows nothing of the floor is too long."""
    body = discretise(with_slivers(box((2, 2, 2), (6.0, 6.0, 6.0)), 0), pla, 0.01, element)
    floor = 1e5
    step, damping = damped_step(body, 0.1, floor)
    assert weighted(body, pla, step**2 + 2.0 * step * damping, step**2 * floor)[-1] <= 4.0
    ignorant = damped_step(body, 0.1)[0]
    assert weighted(body, pla, ignorant**2 + 2.0 * ignorant * damping, ignorant**2 * floor)[-1] > 4.0


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
