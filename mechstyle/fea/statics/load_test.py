"""Load cases on a body: places picked once on the unstylized part, loads and stresses worked out on every morph of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse
from scipy.sparse import csr_array
from scipy.sparse.linalg import LinearOperator, cg, splu

from mechstyle.errors import BadInput, SimulationFailed
from mechstyle.fea.drop import GRAVITY
from mechstyle.fea.elasticity import corner_gradients, displacement_gradients, equivalent_stress, stiffness_matrix, trace
from mechstyle.fea.elements import ElementMesh, element_named, with_nodes
from mechstyle.fea.statics.boundary import Boundary, Picked, pick
from mechstyle.fea.stiffness import TwoLevel, linear_fields
from mechstyle.records.load_cases import Load, LoadCase, Place, Support
from mechstyle.records.material import Material
from mechstyle.records.mesh import Bools, Floats, TetMesh

RIGID = 1e-6
"""A body is held in a rigid motion if it moves the supports by more than this share of the motion."""

SAME_DIRECTION = 1e-4
"""Two rollers at a node hold it in one direction only, if their normals differ by less than about 1°."""


FACTORISED = 6_000
"""Unknowns up to which equations are factorised, which then takes a part of a second."""
LEFT_OVER, ITERATIONS = 1e-10, 400
"""Residual over the right side at which a solution is taken, as good as by factors; 25 to 40 iterations were counted."""


@dataclass(frozen=True, eq=False)
class Response:
    """Displacement and stress of a body under a static load.

    Attributes:
        displacement: u [mm], shape [node_count, 3].
        von_mises: Equivalent stress at the Gauss points [MPa], von Mises unless layers are judged, shape [tet_count, points].
        corners: The same at the corners of the tetrahedra [MPa], shape [tet_count, 4].
        loads: Nodal loads f [N], shape [node_count, 3].
        reactions: Forces of the supports r = K u − f [N], shape [node_count, 3]; zero where nothing is held.
    """

    displacement: Floats
    von_mises: Floats
    corners: Floats
    loads: Floats
    reactions: Floats

    @property
    def deflection(self) -> float:
        """Largest displacement [mm]."""
        return float(np.linalg.norm(self.displacement, axis=1).max())


def stresses(material: Material, gradients: Floats, across: ArrayLike = (0.0, 0.0, 0.0)) -> Floats:
    """Equivalent stress of σ = λ tr(ε) I + 2μ ε [MPa], shape [...], of displacement gradients, shape [..., 3, 3]."""
    strain = 0.5 * (gradients + np.swapaxes(gradients, -1, -2))
    stress = material.lame_lambda * trace(strain)[..., None, None] * np.eye(3) + 2.0 * material.shear_modulus * strain
    return equivalent_stress(stress, across)


@dataclass(frozen=True, eq=False)
class Restraint:
    """Admissible nodal displacements, u = Z q.

    Attributes:
        basis: Z, orthonormal columns, shape [3 node_count, free_count].
        held: Which nodes are held in some direction, shape [node_count].
    """

    basis: sparse.csc_array
    held: Bools

    @classmethod
    def of(cls, boundary: Boundary, supports: list[tuple[Support, Picked]]) -> Restraint:
        """The motion that supports leave; BadInput if the whole body could still move freely."""
        nodes = boundary.mesh.nodes
        across = np.zeros((len(nodes), 3, 3))  # Σ n ⊗ n over the directions a node is held in; supports may meet at a node
        for support, picked in supports:
            normals = picked.normals(boundary)
            held = normals[:, :, None] * normals[:, None, :] if support.kind == "roller" else np.eye(3)
            across += np.where(picked.nodes[:, None, None], held, 0.0)
        strength, directions = np.linalg.eigh(across)
        frames, fixed = np.swapaxes(directions, 1, 2), strength > SAME_DIRECTION
        _refuse_free_motion(nodes, frames, fixed)
        blocks = np.arange(len(directions) + 1)
        turned = sparse.bsr_array((directions, blocks[:-1], blocks)).tocsc()
        return cls(turned[:, np.flatnonzero(~fixed.ravel())], np.asarray(fixed.any(axis=1)))


def solve(
    mesh: ElementMesh, material: Material, restraint: Restraint, loads: list[Floats], across: ArrayLike = (0.0, 0.0, 0.0)
) -> list[Response]:
    """The response to each of several load vectors [N], each of shape [node_count, 3].

    `across` is that of `elasticity.equivalent_stress`.
    """
    K, Z = stiffness_matrix(mesh, material), restraint.basis
    try:
        solution = solver(csr_array(Z.T @ K @ Z), csr_array(Z.T @ linear_fields(mesh.connectivity, len(mesh.nodes))))
    except (RuntimeError, MemoryError) as error:
        raise SimulationFailed(f"the load cases could not be solved: {error}") from error
    responses = []
    for load in loads:
        u = Z @ solution(Z.T @ load.ravel())
        if not np.isfinite(u).all():
            raise SimulationFailed("the load cases could not be solved: the displacement is not a finite number")
        displacement = u.reshape(-1, 3)
        reactions = np.where(restraint.held[:, None], (K @ u).reshape(-1, 3) - load, 0.0)
        points, corners = (stresses(material, at(mesh, displacement), across) for at in (displacement_gradients, corner_gradients))
        responses.append(Response(displacement, points, corners, load, reactions))
    return responses


def solver(matrix: csr_array, fields: csr_array) -> Callable[[Floats], Floats]:
    """What solves A x = b for a symmetric positive definite matrix, again and again.

    Conjugate gradients, with the linear fields solved for directly: of 6500 tetrahedra the factors of A take ten times the memory and five
    times the time, and both grow faster than the mesh. Small systems, and one that does not converge, are factorised.

    Args:
        matrix: A, shape [n, n].
        fields: The linear fields, shape [n, m].

    Raises:
        RuntimeError, MemoryError: If A cannot be factorised.
    """

    def factors() -> Callable[[Floats], Floats]:
        return splu(matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}).solve

    some = np.flatnonzero(abs(fields).sum(axis=0))  # what is left of a field where supports hold all of it is none
    if matrix.shape[0] <= FACTORISED or len(some) >= matrix.shape[0]:
        return factors()
    try:
        nearly = TwoLevel(matrix, fields[:, some])
    except SimulationFailed:  # two fields are one where supports hold what tells them apart
        return factors()
    inverse = LinearOperator(matrix.shape, matvec=lambda right: nearly(right.reshape(-1, 1))[:, 0], dtype=np.float64)

    def solved(right: Floats) -> Floats:
        found, wrong = cg(matrix, right, rtol=LEFT_OVER, atol=0.0, M=inverse, maxiter=ITERATIONS)
        return factors()(right) if wrong else np.asarray(found)

    return solved


def _refuse_free_motion(nodes: Floats, frames: Floats, fixed: Bools) -> None:
    """BadInput that names the rigid motion the supports leave, if they leave one."""
    centre = nodes.mean(axis=0)
    size = float(np.linalg.norm(np.ptp(nodes, axis=0)))
    arms = (nodes - centre) / size
    turns = np.cross(np.eye(3)[None], arms[:, None]).transpose(0, 2, 1)
    motions = np.concatenate([np.broadcast_to(np.eye(3), turns.shape), turns], axis=2)
    at_supports = (frames @ motions)[fixed]
    held = at_supports.T @ at_supports / max(len(at_supports), 1)
    strength, free = np.linalg.eigh(held)
    if strength[0] > RIGID**2:
        return
    shift, turn = free[:3, 0], free[3:, 0]
    motion, axis = ("slide along", shift) if np.linalg.norm(turn) < np.linalg.norm(shift) else ("turn about", turn)
    x, y, z = axis / np.linalg.norm(axis) + 0.0
    raise BadInput(f"the supports do not hold the part: it can still {motion} ({x:.2f}, {y:.2f}, {z:.2f}); add a support or fix one")


BODY_SHARES = {"tet4": np.full(4, 1.0 / 4.0), "tet10": np.array([-1.0 / 20.0] * 4 + [1.0 / 5.0] * 6)}
"""∫ N_a dV / V by element: the share of a body force that goes to each node (Zienkiewicz and Taylor, vol. 1, §8.8)."""


@dataclass(frozen=True, eq=False)
class StaticTest:
    """The load cases of one part.

    Attributes:
        tets: The unstylized part, on which places are picked.
        cases: Its load cases.
        element: `tet10` or `tet4`; linear tetrahedra are several times too stiff in thin walls.
    """

    tets: TetMesh
    cases: tuple[LoadCase, ...]
    element: str = "tet10"

    def check(self) -> None:
        """Refuse now what needs no solution to be seen: a place that selects nothing, a case that does not hold the part."""
        _ = self._restraints

    def run(self, tets: TetMesh, material: Material, across: ArrayLike = (0.0, 0.0, 0.0)) -> dict[str, Response]:
        """The response of a morph of the part to every case, by the case's name; one factorisation per set of supports.

        Args:
            tets: A morph of the part.
            material: Its material.
            across: Of its printed layers, as for `elasticity.equivalent_stress`.

        Raises:
            BadInput: If a place selects nothing, a case does not hold the part, or its loads cancel out at every node.
            SimulationFailed: If the equations cannot be solved.
        """
        boundary = Boundary(with_nodes(tets, element_named(self.element)))
        loads: dict[str, Floats] = {}
        for case in self.cases:
            each = (self._nodal_load(load, boundary, material) for load in case.loads)
            loads[case.name] = sum(each, np.zeros_like(boundary.mesh.nodes))
            if not loads[case.name].any():
                raise BadInput(f"load case {case.name!r}: its loads cancel out everywhere; leave it out or change a load")
        responses: dict[str, Response] = {}
        for supports, restraint in self._restraints.items():
            names = [case.name for case in self.cases if case.supports == supports]
            responses |= zip(names, solve(boundary.mesh, material, restraint, [loads[name] for name in names], across), strict=True)
        return {case.name: responses[case.name] for case in self.cases}

    @cached_property
    def _undeformed(self) -> Boundary:
        return Boundary(with_nodes(self.tets, element_named(self.element)))

    @cached_property
    def _picked(self) -> dict[Place, Picked]:
        """Every place that a case names."""
        picked = dict[Place, Picked]()
        for case in self.cases:
            places = [support.at for support in case.supports] + [load.at for load in case.loads if load.at is not None]
            for place in places:
                if place not in picked:
                    with _naming(case):
                        picked[place] = pick(self._undeformed, place)
        return picked

    @cached_property
    def _restraints(self) -> dict[tuple[Support, ...], Restraint]:
        """The motion every set of supports leaves."""
        restraints = dict[tuple[Support, ...], Restraint]()
        for case in self.cases:
            if case.supports not in restraints:
                held = [(support, self._picked[support.at]) for support in case.supports]
                with _naming(case):
                    restraints[case.supports] = Restraint.of(self._undeformed, held)
        return restraints

    def _nodal_load(self, load: Load, boundary: Boundary, material: Material) -> Floats:
        """Consistent nodal forces of one load [N], shape [node_count, 3]."""
        if load.gravity is not None:
            down = np.array(load.direction) / np.linalg.norm(load.direction)
            return weight(boundary.mesh, material.density, load.gravity * GRAVITY * down)
        assert load.at is not None, "a load case refuses a force or pressure without a place"
        picked = self._picked[load.at]
        if load.force is not None:
            return boundary.forces(picked.inside, np.outer(boundary.areas / picked.area(boundary), load.force))
        assert load.pressure is not None, "a load is a force, a pressure or gravity"
        return boundary.forces(picked.inside, -load.pressure * boundary.area_vectors)


@contextmanager
def _naming(case: LoadCase) -> Iterator[None]:
    """Say which case a complaint is about."""
    try:
        yield
    except BadInput as error:
        raise BadInput(f"load case {case.name!r}: {error}") from error


def weight(mesh: ElementMesh, density: float, acceleration: Floats) -> Floats:
    """Nodal forces of a body force, f_a = ∫ N_a ρ g dV [N], shape [node_count, 3]; `acceleration` g [mm/ms²] is [3]."""
    shares = np.outer(density * mesh.tets.volumes, BODY_SHARES[mesh.element.name])
    return np.asarray(np.bincount(mesh.connectivity.ravel(), shares.ravel(), len(mesh.nodes))[:, None] * acceleration)
