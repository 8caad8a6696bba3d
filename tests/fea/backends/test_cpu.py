"""One drop on one core: damping as in a textbook, and numbers too small to mean anything."""

import numpy as np
import pytest
from scipy.sparse import diags_array
from scipy.sparse.linalg import eigsh

from mechstyle.fea import elasticity
from mechstyle.fea.backends.cpu import CoreBody, CoreDrop
from mechstyle.fea.discretisation import discretise
from mechstyle.fea.elasticity import law_named
from mechstyle.fea.elements import LINEAR
from mechstyle.fea.explicit import QUANTITIES, Scheme, Starts
from support.schemes import NORMALS, scheme_of, starts_of


def stiffness(body, material):
    """`elasticity.stiffness_matrix` in the order of computation."""
    number = np.empty(3 * len(body.place), dtype=int)
    number[(3 * body.place[:, None] + np.arange(3)).ravel()] = np.arange(3 * len(body.place))
    return elasticity.stiffness_matrix(body.mesh, material)[number][:, number]


def test_damping_lets_a_mode_decay_as_the_textbook_says(box, pla):
    """Amplitude ∝ exp(−β ω² t / 2), so energy ∝ exp(−β ω² t): an eigenmode released far from any floor."""
    body = discretise(box((1, 1, 8), (2.0, 2.0, 16.0)), pla, 0.0, LINEAR)
    root = np.repeat(body.masses, 3) ** -0.5
    values, vectors = eigsh(diags_array(root) @ stiffness(body, pla) @ diags_array(root), k=40)
    chosen = int(np.argmin(np.abs(np.sqrt(values) - 2500.0)))
    omega, mode = float(np.sqrt(values[chosen])), (root * vectors[:, chosen]).reshape(-1, 3)
    period, periods, samples, beta = 2.0 * np.pi / omega, 8, 8, 2e-5
    law = law_named("stable_neo_hookean", pla)
    damping = np.full(len(body.volumes), beta)
    scheme = Scheme(law, period / 80, damping, gravity=0.0, friction=0.0, speed=0.0, stride=80 // samples, samples=periods * samples)
    released = (1e-4 * mode / np.abs(mode).max())[None]
    (drop,) = CoreBody(body).batches(scheme, Starts(NORMALS[:1], np.full((1, len(mode)), 1e3), released, 0.0 * released))
    drop.advance(scheme.samples)
    rows = drop.history(0, scheme.samples)[:, :, 0]
    energy = (rows[:, QUANTITIES.index("kinetic")] + rows[:, QUANTITIES.index("strain")]).reshape(periods, samples).mean(axis=1)
    assert np.log(energy[0] / energy[-1]) == pytest.approx(beta * omega**2 * (periods - 1) * period, rel=0.02)


def test_numbers_below_the_normal_range_are_zero_in_a_drop_and_only_there(box, pla):
    """They appear ahead of the wave in a long part; processors compute with them a hundred times slower."""
    body = discretise(box((2, 2, 8), (4.0, 4.0, 16.0)), pla, 0.005)
    scheme, normals = scheme_of(body, pla, samples=1, gravity=0.0), NORMALS[:1]
    drop = CoreDrop(CoreBody(body), scheme, starts_of(body, normals, speed=0.0))
    tiny = np.finfo(np.float32).tiny
    drop.state.u.fill_(float(tiny) / 8.0)
    drop.advance(1)
    for field in (drop.state.u.numpy(), drop.state.v.numpy()):
        assert not np.any((field != 0.0) & (np.abs(field) < tiny))
    assert np.float32(tiny) * np.float32(0.5) != 0.0
