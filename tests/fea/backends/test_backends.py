"""The two float32 implementations of a step against the float64 reference, and against each other."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mechstyle.fea import elasticity
from mechstyle.fea.backends.cpu import CoreBody
from mechstyle.fea.backends.gpu import DeviceBody
from mechstyle.fea.discretisation import discretise
from mechstyle.fea.elasticity import LAWS, law_named
from mechstyle.fea.elements import ELEMENTS
from mechstyle.fea.explicit import QUANTITIES, RECORD_EVERY
from support import hyperelasticity
from support.schemes import NORMALS, scheme_of, starts_of

each_law = pytest.mark.parametrize("name", LAWS)


def on_device(discretisation):
    """The kernels that CUDA runs, on the CPU, where this test can run too."""
    return DeviceBody(discretisation, "cpu")


each_body = pytest.mark.parametrize("body_type", [CoreBody, on_device])


@pytest.fixture(scope="module", params=ELEMENTS.values(), ids=ELEMENTS)
def discretisation(block, pla, request):
    return discretise(block, pla, 0.005, request.param)


def gradients(body, u, v=None, damping=None):
    """H of u + β v at the Gauss points in the order of the mesh; u, v and β in the order of computation."""
    H = elasticity.displacement_gradients(body.mesh, u[body.place])
    if v is None:
        return H
    of_mesh = np.empty_like(damping)
    of_mesh[body.tet_order] = damping
    return H + of_mesh[:, None, None, None] * elasticity.displacement_gradients(body.mesh, v[body.place])


def reference_forces(body, law, u, v=None, damping=None):
    """`hyperelasticity.internal_forces` in the order of computation."""
    forces = np.empty_like(u)
    forces[body.place] = hyperelasticity.forces_of(body.mesh, law, gradients(body, u, v, damping))
    return forces


def reference_stress(body, law, u, v=None, damping=None, across=(0.0, 0.0, 0.0)):
    """Equivalent stress at the Gauss points in the order of computation [MPa]."""
    H = gradients(body, u, v, damping)
    return elasticity.equivalent_stress(hyperelasticity.cauchy_stress(H, hyperelasticity.first_piola(law, H)), across)[body.tet_order]


def reference_drop(discretisation, scheme, normal, heights):
    """The scheme in float64 numpy: running σ_vM at the Gauss points, and per sample the reference's own energies."""
    masses = discretisation.masses[:, None]
    u, v = np.zeros((len(masses), 3)), np.tile(-scheme.speed * normal, (len(masses), 1))
    peak, impulse, lost, samples = np.zeros((1, 1)), 0.0, 0.0, []
    for step in range(scheme.stride * scheme.samples):
        now = (discretisation, scheme.law, u, v, scheme.damping)
        if step % RECORD_EVERY == 0:
            peak = np.maximum(peak, reference_stress(*now, across=scheme.across))
        before = v
        free = v + scheme.time_step * (reference_forces(*now) / masses - scheme.gravity * normal)
        if scheme.contact_stiffness:
            push = np.maximum(-(heights + u @ normal), 0.0)[:, None] * scheme.contact_stiffness * scheme.time_step / masses
        else:
            push = np.maximum(-(heights + (u + scheme.time_step * free) @ normal) / scheme.time_step, 0.0)[:, None]
        v = free + push * normal
        tangential = v - (v @ normal)[:, None] * normal
        v = v - tangential * np.minimum(1.0, scheme.friction * push / np.maximum(np.linalg.norm(tangential, axis=1, keepdims=True), 1e-12))
        impulse += float((masses * push).sum())
        lost -= float((0.5 * masses * (v - free) * (before + v)).sum())
        u = u + scheme.time_step * v
        if (step + 1) % scheme.stride == 0:
            kinetic = float((0.5 * masses * v**2).sum())
            power = -float((reference_forces(discretisation, scheme.law, u) * v).sum())
            strain = hyperelasticity.strain_energy(discretisation.mesh, scheme.law, u[discretisation.place])
            strain -= 0.5 * scheme.time_step * power
            highest = reference_stress(discretisation, scheme.law, u, across=scheme.across).max()
            shift, momentum = (masses * u).sum(axis=0), (masses * v).sum(axis=0)
            arms = discretisation.positions - (masses * discretisation.positions).sum(axis=0) / masses.sum()
            motion = (*shift, *momentum, *(masses * np.cross(arms + u, v)).sum(axis=0), *((masses * u).T @ arms).ravel())
            samples.append((kinetic, strain, impulse, lost, shift @ normal, momentum @ normal, highest**2, 0.0, *motion))
    return peak, np.array(samples)


@each_law
@each_body
@pytest.mark.parametrize("size", [1e-4, 0.3])
def test_internal_forces_agree_with_the_reference(body_type, name, size, discretisation, pla):
    law = law_named(name, pla)
    u = size * np.random.default_rng(0).standard_normal(discretisation.positions.shape)
    expected = reference_forces(discretisation, law, u)
    # float32 carries 6e-8; a force is a sum of some hundred products.
    np.testing.assert_allclose(body_type(discretisation).internal_forces(law, u), expected, rtol=0, atol=3e-6 * np.abs(expected).max())


@each_law
@each_body
def test_a_large_rotation_alone_gives_next_to_no_force(body_type, name, discretisation, pla):
    vertices, law = discretisation.positions, law_named(name, pla)
    turned = vertices @ Rotation.from_rotvec([0.0, 0.5, 0.3]).as_matrix().T - vertices
    strained = vertices * 1e-3
    scale = np.abs(reference_forces(discretisation, law, strained)).max()
    # Displacements of 10 mm in float32 (1e-6 mm) over edges of 3 mm: strain noise of some 1e-6 against 1e-3.
    assert np.abs(body_type(discretisation).internal_forces(law, turned)).max() < 1e-2 * scale


@each_law
@each_body
@pytest.mark.parametrize("changes", [{}, {"across": (0.6, -1.0, 1.5)}, {"contact_stiffness": 3000.0}], ids=["solid", "layers", "penalty"])
def test_a_drop_agrees_step_by_step_with_the_reference(body_type, name, changes, discretisation, pla):
    scheme, starts = scheme_of(discretisation, pla, name, **changes), starts_of(discretisation)
    batches = body_type(discretisation).batches(scheme, starts)
    for batch in batches:
        batch.advance(scheme.samples)
    peak = np.concatenate([batch.peak() for batch in batches])
    touched = np.concatenate([batch.touched() for batch in batches])
    history = np.concatenate([batch.history(0, scheme.samples) for batch in batches], axis=2)
    for index, normal in enumerate(NORMALS):
        expected, samples = reference_drop(discretisation, scheme, normal, starts.heights[index])
        # 32 steps of float32: the rounding of 6e-8 a step on displacements of 1e-2 mm, strains of 1e-2.
        np.testing.assert_allclose(peak[index], expected, rtol=0, atol=2e-4 * expected.max())
        scale = np.abs(samples).max(axis=0) + 1e-6 * np.abs(samples).max()
        for first, last in ((-18, -15), (-15, -12), (-12, -9), (-9, None)):  # of one vector or matrix
            scale[first:last] = scale[first:last].max()
        np.testing.assert_allclose(history[:, :, index] / scale, samples / scale, atol=1e-3)
        assert touched[index].any()
        assert not touched[index].all()


@pytest.mark.parametrize("stiffness", [0.0, 300.0], ids=["rigid", "penalty"])
def test_vectorised_and_gathering_kernels_agree_over_a_whole_bounce(stiffness, discretisation, pla):
    scheme, starts = scheme_of(discretisation, pla, samples=100, contact_stiffness=stiffness), starts_of(discretisation)
    results = []
    for body in (CoreBody(discretisation), on_device(discretisation)):
        batches = body.batches(scheme, starts)
        for batch in batches:
            batch.advance(scheme.samples)
        results.append(np.concatenate([batch.peak() for batch in batches]))
    # Different order of summation in float32 over 400 steps with contact.
    assert np.abs(results[0] - results[1]).max() < 1e-3 * results[0].max()


@each_body
def test_a_body_in_the_air_falls_and_feels_nothing(body_type, discretisation, pla):
    scheme = scheme_of(discretisation, pla)
    starts = starts_of(discretisation, NORMALS[1:2])
    (batch,) = body_type(discretisation).batches(scheme, replace(starts, heights=starts.heights + 1e3))
    batch.advance(scheme.samples)
    last = dict(zip(QUANTITIES, batch.history(0, scheme.samples)[-1, :, 0], strict=True))
    time, mass = scheme.samples * scheme.stride * scheme.time_step, discretisation.masses.sum()
    assert last["momentum"] == pytest.approx(-mass * (scheme.speed + scheme.gravity * time), rel=1e-5)
    assert last["height"] == pytest.approx(-mass * (scheme.speed * time + scheme.gravity * time**2 / 2), rel=1e-3)
    assert last["impulse"] == 0.0
    assert last["contact_loss"] == 0.0
    # Rounding of the velocities accumulates to a few 1e-6 mm between neighbours.
    assert batch.peak().max() < 0.05
    assert not batch.touched().any()


@each_body
def test_results_do_not_depend_on_what_runs_beside(body_type, discretisation, pla):
    scheme = scheme_of(discretisation, pla, samples=20)

    def peaks(which):
        batches = body_type(discretisation).batches(scheme, starts_of(discretisation, NORMALS[which]))
        for batch in batches:
            batch.advance(scheme.samples)
        return np.concatenate([batch.peak() for batch in batches])

    together = peaks([0, 1, 2])
    assert peaks([2]).tobytes() == together[2:].tobytes()
    assert peaks([1, 0]).tobytes() == together[[1, 0]].tobytes()
