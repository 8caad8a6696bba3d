"""Elements at rest: what must hold exactly, thin walls against beam theory, and the same matrices in CalculiX."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import eigsh, splu

from mechstyle.fea import elasticity
from mechstyle.fea.elasticity import LAWS, law_named
from mechstyle.fea.elements import ELEMENTS, QUADRATIC, ElementMesh, with_nodes
from mechstyle.records.material import LIBRARY, Material
from mechstyle.records.mesh import Floats, TetMesh
from support import hyperelasticity
from validation import calculix
from validation.cases import Result, bounded, compared
from validation.meshes import box

PLA = LIBRARY["PLA"]
EXACT = 1e-6
LENGTH, WIDTH, THICKNESS = 40.0, 20.0, 2.0
"""Of the thin plate [mm]."""


def patch() -> Iterator[Result]:
    """An affine displacement gives its own gradient everywhere and no force inside (Irons and Razzaque 1972)."""
    gradient = np.array([[1e-3, 2e-4, 0.0], [-3e-4, 5e-4, 1e-4], [2e-4, 0.0, -8e-4]])
    for name, element in ELEMENTS.items():
        mesh = with_nodes(_shaken(), element)
        u = mesh.nodes @ gradient.T
        inside = np.all((mesh.nodes > 1e-9) & (mesh.nodes < np.array([12.0, 10.0, 16.0]) - 1e-9), axis=1)
        for law in LAWS:
            found = elasticity.displacement_gradients(mesh, u)
            forces = hyperelasticity.internal_forces(mesh, law_named(law, PLA), u)
            error = max(np.abs(found - gradient).max() / np.abs(gradient).max(), np.abs(forces[inside]).max() / np.abs(forces).max())
            yield bounded(f"patch: {name}, {law}", float(error), EXACT, "affine displacement of a shaken block")


def rigid() -> Iterator[Result]:
    """A large rotation with a shift strains nothing; forces are measured by those of a stretch of one per cent."""
    turn = _rotation()
    for name, element in ELEMENTS.items():
        mesh = with_nodes(_shaken(), element)
        moved = mesh.nodes @ turn.T - mesh.nodes + [3.0, -2.0, 5.0]
        for law_name in LAWS:
            law = law_named(law_name, PLA)
            scale = np.abs(hyperelasticity.internal_forces(mesh, law, 0.01 * mesh.nodes)).max()
            force = np.abs(hyperelasticity.internal_forces(mesh, law, moved)).max()
            yield bounded(f"rigid: {name}, {law_name}", float(force / scale), EXACT, "rotation of 79° and a shift of 6 mm")


def frame() -> Iterator[Result]:
    """Forces on a body that is deformed and then turned are the forces turned: stress does not depend on who looks."""
    turn = _rotation()
    for name, element in ELEMENTS.items():
        mesh = with_nodes(_shaken(), element)
        u = 0.05 * np.random.default_rng(0).standard_normal(mesh.nodes.shape)
        for law_name in LAWS:
            law = law_named(law_name, PLA)
            straight = hyperelasticity.internal_forces(mesh, law, u)
            turned = hyperelasticity.internal_forces(mesh, law, (mesh.nodes + u) @ turn.T - mesh.nodes)
            error = np.abs(turned - straight @ turn.T).max() / np.abs(straight).max()
            yield bounded(f"frame: {name}, {law_name}", float(error), EXACT, "a deformed block, turned by 79°")


def plate() -> Iterator[Result]:
    """A plate one element thick, edges 2.5 times the thickness, clamped at an end: what a printed wall is meshed like.

    Against beam theory (Timoshenko, shear factor 5/6) with ν = 0, where it is exact but for the clamped edge; and as PLA, where a
    wide plate is neither beam nor cylinder, against the same element in three layers of a third of the edge.
    """
    limp = Material(name="no lateral strain", youngs_modulus=3500.0, poisson_ratio=0.0, density=1.24e-3, yield_strength=45.6)
    inertia, area = WIDTH * THICKNESS**3 / 12.0, WIDTH * THICKNESS
    deflection = LENGTH**3 / (3.0 * limp.youngs_modulus * inertia) + LENGTH / (5.0 / 6.0 * area * limp.shear_modulus)
    frequency = 1.8751**2 * np.sqrt(limp.youngs_modulus * inertia / (limp.density * area * LENGTH**4))
    coarse = _bent_plate((8, 4, 1), limp)
    yield compared("plate: deflection", coarse.deflection, deflection, 0.05, "mm", "Timoshenko beam, force of 1 N at the edge")
    yield compared("plate: first frequency", coarse.frequency, float(frequency), 0.04, "rad/ms", "Euler–Bernoulli beam")
    yield compared("plate: surface stress", coarse.stress_ratio, 1.0, 0.05, "", "rms over the middle half, beam theory M z / I")
    coarse, fine = _bent_plate((8, 4, 1), PLA), _bent_plate((24, 12, 3), PLA)
    note = "three layers, a third of the edges"
    yield compared("plate: deflection of PLA", coarse.deflection, fine.deflection, 0.05, "mm", note)
    yield compared("plate: first frequency of PLA", coarse.frequency, fine.frequency, 0.04, "rad/ms", note)
    yield compared("plate: surface stress of PLA", coarse.stress_ratio, fine.stress_ratio, 0.05, "", note)


class BentPlate(NamedTuple):
    """The plate under a force of 1 N at its free edge.

    Attributes:
        deflection: Mean of the loaded edge [mm].
        frequency: First eigenfrequency [rad/ms].
        stress_ratio: Axial stress at the surface over M z / I, rms over the middle half.
    """

    deflection: float
    frequency: float
    stress_ratio: float


def _bent_plate(counts: tuple[int, int, int], material: Material) -> BentPlate:
    mesh = with_nodes(box(counts, (LENGTH, WIDTH, THICKNESS)), QUADRATIC)
    fixed, tip = mesh.nodes[:, 0] < 1e-9, mesh.nodes[:, 0] > LENGTH - 1e-9
    u = solved(mesh, material, fixed, _edge_load(mesh, 1.0))
    L = np.full((4, 4), (1.0 - 1.0 / np.sqrt(5.0)) / 4.0) + np.eye(4) / np.sqrt(5.0)
    points = np.einsum("qk,nkx->nqx", L, mesh.tets.vertices[mesh.tets.tets])
    height = points[..., 2] - 0.5 * THICKNESS
    stress = -linear_stress(mesh, material, u)[..., 0, 0] * 0.5 * THICKNESS / height
    far = np.abs(height) > 0.25 * THICKNESS
    x, stress = points[..., 0][far], stress[far]
    middle = (x > 0.25 * LENGTH) & (x < 0.75 * LENGTH)
    theory = (LENGTH - x) * 0.5 * THICKNESS / (WIDTH * THICKNESS**3 / 12.0)
    ratio = float(np.sqrt((stress[middle] ** 2).sum() / (theory[middle] ** 2).sum()))
    free = np.repeat(~fixed, 3)
    K = elasticity.stiffness_matrix(mesh, material)[free][:, free].tocsc()
    masses = np.repeat(elasticity.lumped_masses(mesh, material.density * mesh.tets.volumes), 3)[free]
    lowest = eigsh(K, k=1, M=sparse.diags_array(masses).tocsc(), sigma=0.0, return_eigenvectors=False)
    return BentPlate(float(u[tip, 2].mean()), float(np.sqrt(lowest[0])), ratio)


def cantilever() -> Iterator[Result]:
    """A clamped bar under a force at its end: the same elements in CalculiX."""
    for name, element in ELEMENTS.items():
        mesh = with_nodes(box((3, 3, 20), (10.0, 10.0, 60.0)), element)
        fixed, tip = mesh.nodes[:, 2] < 1e-9, mesh.nodes[:, 2] > 60.0 - 1e-9
        forces = np.zeros_like(mesh.nodes)
        forces[tip, 0] = 10.0 / tip.sum()
        u, theirs = solved(mesh, PLA, fixed, forces), calculix.static(mesh, PLA, fixed, forces)
        stress = linear_stress(mesh, PLA, u)
        note = f"CalculiX C3D{element.nodes}"
        yield bounded(f"cantilever: {name}, displacement", _distance(u, theirs.displacement), EXACT, note)
        yield bounded(f"cantilever: {name}, stress", _distance(stress, theirs.stress), EXACT, note)


def solved(mesh: ElementMesh, material: Material, fixed: NDArray[np.bool_], forces: Floats) -> Floats:
    """Displacement at rest [mm], shape [node_count, 3], of a body held at some nodes under forces [N]."""
    free = np.repeat(~fixed, 3)
    K = elasticity.stiffness_matrix(mesh, material)[free][:, free]
    u = np.zeros(3 * len(mesh.nodes))
    u[free] = splu(K.tocsc()).solve(forces.ravel()[free])
    return u.reshape(-1, 3)


def linear_stress(mesh: ElementMesh, material: Material, u: Floats) -> Floats:
    """Hooke's stress at the Gauss points [MPa], shape [tet_count, points, 3, 3]."""
    H = elasticity.displacement_gradients(mesh, u)
    strain = 0.5 * (H + np.swapaxes(H, -1, -2))
    spherical = material.lame_lambda * elasticity.trace(strain)[..., None, None] * np.eye(3)
    return 2.0 * material.shear_modulus * strain + spherical


def _distance(one: Floats, other: Floats) -> float:
    """Largest difference relative to the largest value."""
    return float(np.abs(one - other).max() / np.abs(other).max())


def _edge_load(mesh: ElementMesh, force: float) -> Floats:
    """A shear force along z [N] spread over the end face x = LENGTH as a uniform traction."""
    forces = np.zeros_like(mesh.nodes)
    between = {(0, 1): 4, (0, 2): 5, (0, 3): 6, (1, 2): 7, (1, 3): 8, (2, 3): 9}
    for row in mesh.connectivity:
        at_end = [corner for corner in range(4) if mesh.nodes[row[corner], 0] > LENGTH - 1e-9]
        if len(at_end) == 3:
            a, b, c = at_end
            corners, middles = mesh.nodes[row[at_end]], row[[between[a, b], between[a, c], between[b, c]]]
            area = 0.5 * np.linalg.norm(np.cross(corners[1] - corners[0], corners[2] - corners[0]))
            forces[middles, 2] += force * area / (WIDTH * THICKNESS) / 3.0  # a uniform traction acts on the middles only
    return forces


def _shaken() -> TetMesh:
    """A block of 12 x 10 x 16 mm, its inner vertices moved."""
    block = box((4, 3, 4), (12.0, 10.0, 16.0))
    inside = np.all((block.vertices > 1e-9) & (block.vertices < np.array([12.0, 10.0, 16.0]) - 1e-9), axis=1)
    moved = block.vertices.copy()
    moved[inside] += 0.6 * np.random.default_rng(1).uniform(-1.0, 1.0, (int(inside.sum()), 3))
    return block.moved(moved)


def _rotation() -> Floats:
    """A rotation by 79° about an oblique axis (Rodrigues)."""
    x, y, z = np.array([0.4, -1.1, 0.7]) / np.linalg.norm([0.4, -1.1, 0.7])
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    angle = np.radians(79.0)
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
