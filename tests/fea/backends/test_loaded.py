"""A bar that is pulled slowly: Hooke's elongation, the yield strength, and what stays when the load is taken off."""

import numpy as np
import pytest

from mechstyle.fea.backends.cpu import CoreBody
from mechstyle.fea.backends.gpu import DeviceBody
from mechstyle.fea.discretisation import discretise
from mechstyle.fea.elements import ELEMENTS
from mechstyle.fea.explicit import QUANTITIES, STRAIN, TENSION, Loading
from support.schemes import scheme_of

LENGTH, SIDE = 12.0, 4.0
AREA = SIDE**2
HARDENING = 500.0
"""More than PLA's: with less than its strength a bar that is pulled necks as soon as it yields (Considère 1885)."""
PERIOD = 4.0 * LENGTH / 1680.0
"""Of the bar along its length [ms]."""


def kernels(discretisation):
    """The kernels that CUDA runs, on the CPU."""
    return DeviceBody(discretisation, "cpu")


@pytest.fixture(scope="module", params=ELEMENTS.values(), ids=ELEMENTS)
def bar(box, pla, request):
    """A bar along z."""
    return discretise(box((1, 1, 3), (SIDE, SIDE, LENGTH)), pla, 0.0, request.param)


def pulled(bar):
    """Its top pulled by 1 MPa, its base and two sides on rollers, so that it may become thinner."""
    free = (bar.positions > 1e-9).astype(float)
    top, forces = np.isclose(bar.positions[:, 2], LENGTH), np.zeros_like(bar.positions)
    for nodes in bar.connectivity:
        bearing = nodes[4:] if len(nodes) > 4 else nodes  # a uniform pull acts on the middles of a quadratic side alone
        face = bearing[top[bearing]]
        if len(face) == 3:
            forces[face, 2] += AREA / 2.0 / 3.0
    assert forces.sum() == pytest.approx(AREA)
    return Loading(forces, free[:, :, None] * np.eye(3), drag=3.0 / PERIOD)


def taken(bar, pla, body_type, factors, samples=60):
    """The bar after a load goes through some factors and is held at the last, and its history."""
    strides = samples * len(factors)
    scheme = scheme_of(bar, pla, samples=strides, stride=40, damping=np.zeros(len(bar.volumes)),
                       yield_strength=pla.yield_strength, hardening=HARDENING)  # fmt: skip
    body = body_type(bar).loaded(scheme, pulled(bar))
    for start, end in zip([0.0, *factors[:-1]], factors, strict=True):
        body.advance(samples, start, end)
    return body, body.history(0, strides)[:, :, 0]


def elongation(bar, body):
    top = np.isclose(bar.positions[:, 2], LENGTH)
    return float(body.motion()[0][0, top, 2].mean())


@pytest.mark.parametrize("body_type", [CoreBody, kernels])
def test_below_its_strength_it_follows_hooke_and_comes_back(body_type, bar, pla):
    stress = 0.5 * pla.yield_strength
    held, rows = taken(bar, pla, body_type, (stress, stress))
    assert elongation(bar, held) == pytest.approx(LENGTH * stress / pla.youngs_modulus, rel=0.01)
    assert held.peak() == pytest.approx(stress, rel=0.03)
    assert rows[-1, QUANTITIES.index("kinetic")] < 1e-4 * rows[-1, QUANTITIES.index("strain")]
    assert rows[-1, QUANTITIES.index("strain")] == pytest.approx(0.5 * stress**2 / pla.youngs_modulus * AREA * LENGTH, rel=0.02)
    off, _ = taken(bar, pla, body_type, (stress, 0.0, 0.0))
    assert abs(elongation(bar, off)) < 1e-4 * LENGTH
    assert not off.plastic().any()


@pytest.mark.parametrize("body_type", [CoreBody, kernels])
def test_beyond_its_strength_it_follows_the_hardening_and_the_strain_stays(body_type, bar, pla):
    """Kirchhoff stress is the pull times the stretch, τ = (F/A₀) exp(ε_p + τ/E)."""
    pull = 1.05 * pla.yield_strength
    off, rows = taken(bar, pla, body_type, (pull, pull, 0.0, 0.0), samples=100)
    plastic, peak = off.plastic()[0], off.peak().mean()
    strain = plastic[..., STRAIN].mean()
    assert peak == pytest.approx(pull * np.exp(strain + peak / pla.youngs_modulus), rel=0.003)
    assert peak == pytest.approx(pla.yield_strength + HARDENING * strain, rel=1e-3)
    np.testing.assert_allclose(plastic[..., STRAIN], strain, rtol=0.02)
    np.testing.assert_array_equal(plastic[..., TENSION], plastic[..., STRAIN])
    assert elongation(bar, off) == pytest.approx(LENGTH * np.expm1(strain), rel=0.01)
    work = AREA * LENGTH * (pla.yield_strength * strain + 0.5 * HARDENING * strain**2)
    assert rows[-1, QUANTITIES.index("plastic_work")] == pytest.approx(work, rel=1e-3)


def test_both_backends_agree(bar, pla):
    pull = 1.005 * pla.yield_strength
    (ours, rows), (theirs, others) = (taken(bar, pla, body_type, (pull, 0.2 * pull)) for body_type in (CoreBody, kernels))
    np.testing.assert_allclose(ours.motion()[0], theirs.motion()[0], atol=1e-3 * np.abs(theirs.motion()[0]).max())
    np.testing.assert_allclose(ours.plastic(), theirs.plastic(), atol=1e-3 * np.abs(theirs.plastic()).max())
    np.testing.assert_allclose(rows[:, 1], others[:, 1], atol=1e-3 * others[:, 1].max())


def test_what_is_held_stays_where_it_is(bar, pla):
    body, _ = taken(bar, pla, CoreBody, (0.5 * pla.yield_strength,))
    moved = body.motion()[0][0]
    assert not moved[bar.positions < 1e-9].any()
    assert moved.any()
