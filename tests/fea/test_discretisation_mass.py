"""The highest frequency bounded from above, and the mass that lowers the bound."""

import numpy as np
import pytest

from mechstyle.fea.discretisation import bound, discretise, lengthened
from mechstyle.fea.elements import ELEMENTS
from support.slivers import weighted, with_slivers

each_element = pytest.mark.parametrize("element", ELEMENTS.values(), ids=ELEMENTS)


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
@pytest.mark.parametrize("share", [0.0, 0.005, 0.05])
def test_no_more_mass_is_added_than_was_asked_for_and_the_bound_holds_for_the_heavier_body(share, element, box, pla):
    """The unsafe side: a bound below the truth is a step that blows up."""
    body = discretise(with_slivers(box((2, 2, 2), (6.0, 6.0, 6.0)), 1), pla, 0.0, element)
    masses, proof, highest = lengthened(body.stiffness.norms, body.masses, share)
    assert (masses >= body.masses).all()
    assert masses.sum() <= (1.0 + share) * body.masses.sum() * (1.0 + 1e-9)
    assert (proof > 0.0).all()
    assert (body.stiffness.norms @ proof <= highest * masses * proof * (1.0 + 1e-9)).all(), "Collatz and Wielandt, for that very vector"
    heavier = discretise(body.mesh.tets, pla, 0.0, element)
    object.__setattr__(heavier, "masses", masses)
    assert weighted(heavier, pla, np.ones(len(body.volumes)))[-1] <= highest * (1.0 + 1e-9)


def test_more_mass_allows_a_longer_step(box, pla):
    body = discretise(with_slivers(box((2, 2, 2), (6.0, 6.0, 6.0)), 1), pla, 0.0, ELEMENTS["tet4"])
    limits = [lengthened(body.stiffness.norms, body.masses, share)[2] for share in (0.0, 0.005, 0.05)]
    assert limits == sorted(limits, reverse=True)
    assert limits[0] > 1.2 * limits[2]
