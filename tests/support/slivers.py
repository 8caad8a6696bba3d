"""Bodies with tetrahedra as bad as a mesher makes them, and their eigenvalues by a dense solver."""

from dataclasses import replace

import numpy as np
from scipy.linalg import eigvalsh

from mechstyle.fea.elasticity import stiffness_matrix
from mechstyle.records.mesh import TetMesh


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


def weighted(body, material, weights, floor=0.0):
    """Eigenvalues of M⁻¹ (Σ w_e K_e + floor) by a dense solver, from the reference's stiffness of one tetrahedron after the other."""
    masses = np.repeat(body.masses[body.place], 3)
    total = floor * np.eye(len(masses))
    mesh = body.mesh
    for place, number in enumerate(body.tet_order):
        single = replace(mesh, tets=TetMesh(mesh.tets.vertices, mesh.tets.tets[[number]]), connectivity=mesh.connectivity[[number]])
        vars(single)["nodes"] = mesh.nodes
        total += weights[place] * stiffness_matrix(single, material).toarray()
    root = masses**-0.5
    return eigvalsh(root[:, None] * total * root)
