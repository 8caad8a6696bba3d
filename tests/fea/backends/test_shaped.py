"""A bar that is put into shapes: the force that Hooke asks for, the yield strength, and flow only to shapes that are kept."""

import numpy as np
import pytest

from mechstyle.fea.backends.cpu import CoreBody
from mechstyle.fea.backends.gpu import DeviceBody
from mechstyle.fea.discretisation import discretise
from mechstyle.fea.elements import ELEMENTS
from mechstyle.fea.explicit import FLOW, STRAIN, TENSION
from support.schemes import scheme_of

LENGTH, SIDE, HARDENING = 12.0, 4.0, 500.0


def kernels(discretisation):
    """The kernels that CUDA runs, on the CPU."""
    return DeviceBody(discretisation, "cpu")


@pytest.fixture(scope="module", params=ELEMENTS.values(), ids=ELEMENTS)
def bar(box, pla, request):
    """A bar along z."""
    return discretise(box((1, 1, 3), (SIDE, SIDE, LENGTH)), pla, 0.0, request.param)


@pytest.fixture(params=[CoreBody, kernels])
def shaped(bar, pla, request):
    scheme = scheme_of(bar, pla, samples=0, yield_strength=pla.yield_strength, hardening=HARDENING)
    return request.param(bar).shaped(scheme)


def stretched(bar, strain, across):
    """A stretch along z, and another across."""
    return bar.positions * np.expm1([across, across, strain])


def pull(bar, forces):
    """Force on its top."""
    return -forces[np.isclose(bar.positions[:, 2], LENGTH), 2].sum()


def test_below_its_strength_it_pulls_back_as_hooke_says_and_nothing_flows(shaped, bar, pla):
    strain = 0.5 * pla.yield_strength / pla.youngs_modulus
    shape = stretched(bar, strain, -pla.poisson_ratio * strain)
    assert pull(bar, shaped.forces(shape)) == pytest.approx(0.5 * pla.yield_strength * SIDE**2, rel=0.02)
    shaped.keep(shape)
    assert shaped.peak() == pytest.approx(0.5 * pla.yield_strength, rel=0.02)
    assert not shaped.plastic().any()


def test_beyond_its_strength_it_flows_and_only_a_shape_that_is_kept_counts(shaped, bar, pla):
    """In tension τ = σ_y + h ε_p, ε = ε_p + τ/E; across −ε_p/2 − ν τ/E, and the section shrinks with it."""
    plastic = 0.01
    stress = pla.yield_strength + HARDENING * plastic
    elastic = stress / pla.youngs_modulus
    shape = stretched(bar, plastic + elastic, -0.5 * plastic - pla.poisson_ratio * elastic)
    at_rest = np.zeros_like(shape)
    for _ in range(2):  # what was looked at leaves nothing
        assert pull(bar, shaped.forces(shape)) == pytest.approx(stress * np.exp(-plastic - elastic) * SIDE**2, rel=0.02)
        assert np.abs(shaped.forces(at_rest)).max() < 1e-3
        assert not shaped.plastic().any()
    assert not shaped.peak().any()
    shaped.keep(shape)
    found = shaped.plastic()[0]
    assert found[..., STRAIN] == pytest.approx(plastic, rel=0.03)
    flow = np.expm1([plastic, plastic, -2.0 * plastic, 0.0, 0.0, 0.0])
    assert found[..., :FLOW] == pytest.approx(np.broadcast_to(flow, found[..., :FLOW].shape), abs=0.03 * 2.0 * plastic)
    np.testing.assert_array_equal(found[..., TENSION], found[..., STRAIN])
    assert shaped.peak() == pytest.approx(stress, rel=0.01)
    released = stretched(bar, plastic, -0.5 * plastic)
    assert np.abs(shaped.forces(released)).max() < 0.03 * stress * SIDE**2
    assert pull(bar, shaped.forces(at_rest)) < 0.0


def test_both_backends_agree(bar, pla):
    scheme = scheme_of(bar, pla, samples=0, yield_strength=pla.yield_strength, hardening=HARDENING)
    shapes = 0.3 * np.random.default_rng(0).standard_normal((2, *bar.positions.shape))
    found = []
    for body_type in (CoreBody, kernels):
        shaped = body_type(bar).shaped(scheme)
        shaped.keep(shapes[0])
        found.append((shaped.forces(shapes[1]), shaped.plastic()))
    for ours, theirs in zip(*found, strict=True):
        np.testing.assert_allclose(ours, theirs, atol=1e-3 * np.abs(theirs).max())
