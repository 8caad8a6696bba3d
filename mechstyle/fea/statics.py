"""Load cases on a body: places picked once on the unstylized part, loads and stresses worked out on every morph of it.

The outside of the body is looked at in points, many to a side: a piece that is smaller than the sides of the mesh, or cut off across them,
then has its own area; where a piece ends at the edges of sides, the integral over them is exact.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components

from mechstyle.errors import BadInput, SimulationFailed
from mechstyle.fea.discretisation import Relative, discretise
from mechstyle.fea.drop import GRAVITY
from mechstyle.fea.elasticity import displacement_gradients, equivalent_stress, stiffness_matrix, trace
from mechstyle.fea.elements import ElementMesh, at_vertices, element_named, with_nodes
from mechstyle.fea.explicit import Progress, no_progress
from mechstyle.fea.linear_solvers import Solver, linear_fields
from mechstyle.fea.loading import Held, Outcome, Ramp
from mechstyle.fea.permanent_set import Springback, measured
from mechstyle.records.load_cases import RESTING_FACE, LoadCase, Patch, Place, Support
from mechstyle.records.material import Material
from mechstyle.records.mesh import Bools, Floats, Indices, SurfaceMesh, TetMesh, in_ball, on_floor
from mechstyle.records.simulation import LoadResult

Across = tuple[float, float, float]
"""Normal of printed layers over their share of the strength; zero for a material without layers."""

SIDES: Indices = np.array([[0, 2, 1, 5, 4, 7], [0, 1, 3, 4, 6, 8], [0, 3, 2, 6, 5, 9], [1, 2, 3, 7, 8, 9]], dtype=np.int32)
"""Nodes of each side of a tetrahedron: corners a, b, c, anticlockwise seen from outside, then the middles of ab, ac, bc."""

SPLITS = 4
"""A side is looked at in SPLITS² equal triangles, three points each."""


def _points_of_a_triangle() -> Floats:
    """Barycentric coordinates of points of equal weight that integrate quadratic polynomials exactly, shape [3 SPLITS², 3].

    The three-point rule of degree two (Strang and Fix 1973) in each of the SPLITS² triangles that a regular division gives.
    """
    i, j = (index.ravel() for index in np.meshgrid(np.arange(SPLITS), np.arange(SPLITS), indexing="ij"))
    up, down = i + j < SPLITS, i + j < SPLITS - 1
    lowest = np.array([[0, 0], [1, 0], [0, 1]])
    triangles = [np.stack([i[up], j[up]], axis=1)[:, None] + lowest, np.stack([i[down], j[down]], axis=1)[:, None] + 1 - lowest]
    rule = np.full((3, 3), 1.0 / 6.0) + 0.5 * np.eye(3)
    plane = (rule @ np.concatenate(triangles) / SPLITS).reshape(-1, 2)
    return np.concatenate([1.0 - plane.sum(axis=1, keepdims=True), plane], axis=1)


POINTS = _points_of_a_triangle()


@dataclass(frozen=True, eq=False)
class Boundary:
    """The sides of a body that belong to one tetrahedron only."""

    mesh: ElementMesh

    @cached_property
    def sides(self) -> Indices:
        """Nodes of every side, in the order of SIDES, shape [side_count, 3 or 6]."""
        width = 3 if self.mesh.element.nodes == 4 else 6
        sides = self.mesh.connectivity[:, SIDES[:, :width]].reshape(-1, width)
        _, first, count = np.unique(np.sort(sides[:, :3], axis=1), axis=0, return_index=True, return_counts=True)
        return np.ascontiguousarray(sides[np.sort(first[count == 1])])

    @cached_property
    def area_vectors(self) -> Floats:
        """Outward normals times the area of the side [mm²], shape [side_count, 3]."""
        a, b, c = (self.mesh.nodes[self.sides[:, corner]] for corner in range(3))
        return 0.5 * np.cross(b - a, c - a)

    @cached_property
    def areas(self) -> Floats:
        """Areas of the sides [mm²], shape [side_count]."""
        return np.asarray(np.linalg.norm(self.area_vectors, axis=1))

    @cached_property
    def points(self) -> Floats:
        """The points of every side [mm], shape [side_count, point_count, 3]."""
        return np.einsum("pc,fcx->fpx", POINTS, self.mesh.nodes[self.sides[:, :3]])

    def forces(self, inside: Bools, traction: Floats) -> Floats:
        """Consistent nodal forces of a traction, f_a = ∫ N_a t dA [N], shape [node_count, 3].

        It acts at the points `inside`, shape [side_count, point_count]; `traction` is t times the area of the whole side [N].
        """
        N = POINTS  # L_i of a linear triangle; L_i (2 L_i − 1) at the corners and 4 L_i L_j at the middles of a quadratic one
        if self.sides.shape[1] > 3:
            first, second = np.triu_indices(3, k=1)
            N = np.concatenate([N * (2.0 * N - 1.0), 4.0 * N[:, first] * N[:, second]], axis=1)
        shares = inside @ N / len(POINTS)
        forces = np.zeros_like(self.mesh.nodes)
        np.add.at(forces, self.sides, shares[:, :, None] * traction[:, None, :])
        return forces


TOUCH = 1e-6
"""What lies on the border of a shape belongs to it, within this share of the body's size."""


@dataclass(frozen=True, eq=False)
class Picked:
    """A piece of a boundary: points of sides, shape [side_count, point_count], and nodes that a support there holds, shape [node_count]."""

    inside: Bools
    nodes: Bools

    def area(self, boundary: Boundary) -> float:
        """Its area on a body, the one it was picked on or a morph of it [mm²]."""
        return float(self.inside.mean(axis=1) @ boundary.areas)

    def normals(self, boundary: Boundary) -> Floats:
        """Mean outward unit normals of its sides at its nodes, shape [node_count, 3]; zero elsewhere."""
        sides = self.inside.any(axis=1) | self.nodes[boundary.sides].all(axis=1)
        total = np.zeros_like(boundary.mesh.nodes)
        np.add.at(total, boundary.sides[sides], boundary.area_vectors[sides][:, None, :])
        lengths = np.linalg.norm(total, axis=1, keepdims=True)
        return np.divide(total, lengths, out=np.zeros_like(total), where=lengths > 0.0)


def pick(boundary: Boundary, place: Place) -> Picked:
    """The piece of an undeformed boundary at a place; BadInput if there is none."""
    if not isinstance(place, Patch):
        picked = _of_sides(boundary, on_floor(SurfaceMesh(boundary.mesh.nodes, boundary.sides[:, :3])))
    elif place.facet is not None:
        picked = _of_sides(boundary, _facet(boundary, np.array(place.facet), place.angle))
    elif place.near is not None:
        picked = _near(boundary, np.array(place.near[:3]), place.near[3])
    else:
        touch = TOUCH * float(np.ptp(boundary.mesh.nodes, axis=0).max())
        picked = _within(boundary, partial(place.contains, margin=touch))
    if not picked.inside.any():
        if not isinstance(place, Patch):
            why = "because the part has no flat face to stand on: pick a place by sphere, box or facet"
            raise BadInput(f"{RESTING_FACE!r} selects nothing, {why}")
        low, high = boundary.mesh.nodes.min(axis=0), boundary.mesh.nodes.max(axis=0)
        span = ", ".join(f"{axis} {a:.1f} to {b:.1f}" for axis, a, b in zip("xyz", low, high, strict=True))
        raise BadInput(f"{place.words} selects no surface: the part spans {span} mm")
    return picked


def _within(boundary: Boundary, shape: Callable[[Floats], Bools]) -> Picked:
    """Boundary nodes in a shape; if fewer than three, the nodes of the faces it touches."""
    inside = shape(boundary.points)
    nodes = _nodes_of(boundary, np.ones(len(boundary.sides), dtype=bool)) & shape(boundary.mesh.nodes)
    return Picked(inside, nodes if nodes.sum() >= 3 else _nodes_of(boundary, np.asarray(inside.any(axis=1))))


def _near(boundary: Boundary, place: Floats, radius: float) -> Picked:
    """Boundary nodes around the nearest surface point, on faces that face the same way as the one there."""
    side, centre = _nearest(boundary, place)
    same = np.asarray(boundary.area_vectors @ boundary.area_vectors[side] > 0.0)
    whole = _within(boundary, lambda points: in_ball(points, centre, radius))
    return Picked(whole.inside & same[:, None], whole.nodes & _nodes_of(boundary, same))


def _of_sides(boundary: Boundary, sides: Bools) -> Picked:
    return Picked(np.repeat(sides[:, None], len(POINTS), axis=1), _nodes_of(boundary, sides))


def _nodes_of(boundary: Boundary, sides: Bools) -> Bools:
    nodes = np.zeros(len(boundary.mesh.nodes), dtype=bool)
    nodes[boundary.sides[sides]] = True
    return nodes


def _nearest(boundary: Boundary, place: Floats) -> tuple[int, Floats]:
    """The side with the point nearest to a place, and that point."""
    distance = np.linalg.norm(boundary.points - place, axis=-1)
    side, point = np.unravel_index(int(distance.argmin()), distance.shape)
    return int(side), boundary.points[side, point]


def _facet(boundary: Boundary, place: Floats, angle: float) -> Bools:
    """Sides that face as the one nearest to a place does, within an angle [degrees], and are connected with it by such sides."""
    side, _ = _nearest(boundary, place)
    normals = boundary.area_vectors / boundary.areas[:, None]
    alike = np.asarray(normals @ normals[side] >= np.cos(np.radians(angle)) - 1e-9)
    corners = boundary.sides[:, :3]
    _, edge = np.unique(np.sort(corners[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0, return_inverse=True)
    owner = np.repeat(np.arange(len(corners)), 3)
    kept = alike[owner]
    meets = coo_array((np.ones(kept.sum()), (owner[kept], edge.ravel()[kept])), shape=(len(corners), int(edge.max()) + 1)).tocsr()
    _, component = connected_components(meets @ meets.T, directed=False)
    return np.asarray(component == component[side])


RIGID = 1e-6
"""A body is held in a rigid motion if it moves the supports by more than this share of the motion."""

SAME_DIRECTION = 1e-4
"""Two rollers at a node hold it in one direction only, if their normals differ by less than about 1°."""


@dataclass(frozen=True, eq=False)
class Response:
    """Displacement and stress of an elastic body under a static load.

    Attributes:
        displacement: u [mm], shape [node_count, 3].
        von_mises: Equivalent stress at the Gauss points [MPa], von Mises unless layers are judged, shape [tet_count, points].
        loads: Nodal loads f [N], shape [node_count, 3].
        reactions: Forces of the supports r = K u − f [N], shape [node_count, 3]; zero where nothing is held.
    """

    displacement: Floats
    von_mises: Floats
    loads: Floats
    reactions: Floats

    @property
    def deflection(self) -> float:
        """Largest displacement [mm]."""
        return float(np.linalg.norm(self.displacement, axis=1).max())


@dataclass(frozen=True, eq=False)
class Loaded:
    """A load case: put on slowly and taken off; of an elastic body, its response.

    Attributes:
        result: Its figures, without the place in words.
        stress: Largest stress on the way to the load, at the vertices [MPa], shape [vertex_count].
        strain: Plastic strain there, shape [vertex_count].
        displacement: What stays bent [mm], shape [vertex_count, 3].
    """

    result: LoadResult
    stress: Floats
    strain: Floats
    displacement: Floats


BEYOND = 10.0
"""Times the tolerance that are said to stay bent at least, of a part that collapses."""


def stresses(material: Material, gradients: Floats, across: ArrayLike = (0.0, 0.0, 0.0)) -> Floats:
    """Equivalent stress of σ = λ tr(ε) I + 2μ ε [MPa], shape [...], of displacement gradients, shape [..., 3, 3]."""
    strain = 0.5 * (gradients + np.swapaxes(gradients, -1, -2))
    stress = material.lame_lambda * trace(strain)[..., None, None] * np.eye(3) + 2.0 * material.shear_modulus * strain
    return equivalent_stress(stress, across)


@dataclass(frozen=True, eq=False)
class Restraint:
    """Admissible nodal displacements u = Z q, Z of shape [3 node_count, free_count], and which nodes are held in some direction."""

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


class _HeldPart:
    """Equations of a part on supports; SimulationFailed if they cannot be factorised."""

    def __init__(self, mesh: ElementMesh, material: Material, restraint: Restraint, relative: Relative | None) -> None:
        self._mesh, self._material, self.restraint = mesh, material, restraint
        self._bears = 1.0 if relative is None else relative.bears
        Z, factors = restraint.basis, 1.0 if relative is None else relative.stiffness
        self._stiffness = stiffness_matrix(mesh, material, factors)
        try:
            self.solver = Solver(csr_array(Z.T @ self._stiffness @ Z), csr_array(Z.T @ linear_fields(mesh.connectivity, len(mesh.nodes))))
        except (RuntimeError, MemoryError) as error:
            raise SimulationFailed(f"the load cases could not be solved: {error}") from error

    def response(self, load: Floats, across: ArrayLike = (0.0, 0.0, 0.0)) -> Response:
        """The response to nodal loads [N], shape [node_count, 3]; `across` is that of `elasticity.equivalent_stress`."""
        Z = self.restraint.basis
        u = Z @ self.solver(Z.T @ load.ravel())
        if not np.isfinite(u).all():
            raise SimulationFailed("the load cases could not be solved: the displacement is not a finite number")
        displacement = u.reshape(-1, 3)
        reactions = np.where(self.restraint.held[:, None], (self._stiffness @ u).reshape(-1, 3) - load, 0.0)
        stress = stresses(self._material, displacement_gradients(self._mesh, displacement), across)
        return Response(displacement, stress / self._bears, load, reactions)


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
    """Load cases of one part, whose places are picked on the unstylized tetrahedra."""

    tets: TetMesh
    cases: tuple[LoadCase, ...]
    element: str = "tet10"

    def check(self) -> None:
        """Refuse now what needs no solution to be seen: a place that selects nothing, a case that does not hold the part."""
        _ = self._restraints

    def run(
        self, tets: TetMesh, material: Material, across: Across = (0.0, 0.0, 0.0), relative: Relative | None = None
    ) -> dict[str, Response]:
        """The elastic response of a morph of the part to every case, by the case's name.

        `across` is that of its printed layers, as for `elasticity.equivalent_stress`; `relative` what a morph that is not solid has of the
        solid's properties.

        Raises:
            BadInput: If a place selects nothing, a case does not hold the part, or its loads cancel out at every node.
            SimulationFailed: If the equations cannot be solved.
        """
        return {name: response for name, response, _ in self._solved(tets, material, across, relative)}

    def loaded(
        self, tets: TetMesh, material: Material, *, across: Across = (0.0, 0.0, 0.0), tolerance: float, elastic: bool = False,
        progress: Progress = no_progress, relative: Relative | None = None,
    ) -> dict[str, Loaded]:  # fmt: skip
        """What every case does to a morph of the part, by the case's name.

        Args:
            tets: The morph.
            material: What it is made of.
            across: As for `run`.
            tolerance: What may stay bent [mm].
            elastic: Whether the material is taken never to yield.
            progress: Called now and then with the fraction done; may raise to cancel.
            relative: As for `run`.

        Raises:
            BadInput: As `run`.
            SimulationFailed: If the equations cannot be solved.
        """
        body = discretise(tets, material, 0.0, element_named(self.element), relative)
        springback = Springback(body)
        found = dict[str, Loaded]()
        for number, (name, response, part) in enumerate(self._solved(tets, material, across, relative)):
            if elastic:
                found[name] = _elastically(tets, name, response)
                continue
            held = Held(body, part.restraint.basis, part.solver.nearly, across)
            first = material.yield_strength / max(float(response.von_mises.max()), 1e-30)
            ramp = Ramp(held, springback, response.loads, tolerance)
            outcome = ramp.put_on(first, partial(_share, progress, number, len(self.cases)))
            found[name] = _loaded(tets, name, outcome, tolerance)
        return found

    def _solved(
        self, tets: TetMesh, material: Material, across: Across, relative: Relative | None
    ) -> Iterator[tuple[str, Response, _HeldPart]]:
        """Every case's name, elastic response and part on its supports; one factorisation per set of supports."""
        boundary = Boundary(with_nodes(tets, element_named(self.element)))
        density = material.density * (1.0 if relative is None else relative.density.mean(axis=1))
        loads = {case.name: self._loads(boundary, density, case) for case in self.cases}
        parts = {supports: _HeldPart(boundary.mesh, material, restraint, relative) for supports, restraint in self._restraints.items()}
        for case in self.cases:
            part = parts[case.supports]
            yield case.name, part.response(loads[case.name], across), part

    def _loads(self, boundary: Boundary, density: Floats | float, case: LoadCase) -> Floats:
        """Nodal loads of a case [N], shape [node_count, 3], on a body of a density [g/mm³], everywhere or of shape [tet_count]."""
        total = np.zeros_like(boundary.mesh.nodes)
        for load in case.loads:
            if load.gravity is not None:
                down = np.array(load.direction) / np.linalg.norm(load.direction)
                total = total + weight(boundary.mesh, density, load.gravity * GRAVITY * down)
                continue
            assert load.at is not None, "a load case refuses a force or pressure without a place"
            picked = self._picked[load.at]
            if load.force is not None:
                traction = np.outer(boundary.areas / picked.area(boundary), load.force)
            else:
                assert load.pressure is not None, "a load is a force, a pressure or gravity"
                traction = -load.pressure * boundary.area_vectors
            total = total + boundary.forces(picked.inside, traction)
        if not total.any():
            raise BadInput(f"load case {case.name!r}: its loads cancel out everywhere; leave it out or change a load")
        return total

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


def _loaded(tets: TetMesh, name: str, outcome: Outcome, tolerance: float) -> Loaded:
    """What a load did, in figures and at the vertices."""
    at = outcome.at
    permanent_set, where, plastic_strain = at.figures
    if outcome.collapses:
        if not at.permanent.any():  # it buckles and springs back: where it gives way is where it moves
            where = measured(tets, at.displacement[: len(tets.vertices)], at.strain).where
        permanent_set = max(permanent_set, BEYOND * tolerance)
    result = LoadResult(
        name=name, permanent_set=permanent_set, plastic_strain=plastic_strain, where=where, maximum=float(outcome.stress.max()),
        deflection=float(np.linalg.norm(at.displacement, axis=1).max()), factor=outcome.factor, reached=outcome.reached,
        collapses=outcome.collapses,
    )  # fmt: skip
    return Loaded(result, at_vertices(tets, outcome.stress), at_vertices(tets, at.strain), at.permanent)


def _elastically(tets: TetMesh, name: str, response: Response) -> Loaded:
    """A response as what a load does to a part that never yields."""
    result = LoadResult(
        name=name, permanent_set=0.0, plastic_strain=0.0, where=(0.0, 0.0, 0.0), maximum=float(response.von_mises.max()),
        deflection=response.deflection, factor=1.0, reached=False,
    )  # fmt: skip
    return Loaded(result, at_vertices(tets, response.von_mises), np.zeros(len(tets.vertices)), np.zeros_like(tets.vertices))


def _share(progress: Progress, number: int, count: int, done: float) -> None:
    """Tell how much of several is done, when a share of one is."""
    progress((number + done) / count)


@contextmanager
def _naming(case: LoadCase) -> Iterator[None]:
    """Say which case a complaint is about."""
    try:
        yield
    except BadInput as error:
        raise BadInput(f"load case {case.name!r}: {error}") from error


def weight(mesh: ElementMesh, density: Floats | float, acceleration: Floats) -> Floats:
    """Nodal forces of a body force, f_a = ∫ N_a ρ g dV [N], shape [node_count, 3]; `acceleration` g [mm/ms²] is [3]."""
    shares = np.outer(density * mesh.tets.volumes, BODY_SHARES[mesh.element.name])
    return np.asarray(np.bincount(mesh.connectivity.ravel(), shares.ravel(), len(mesh.nodes))[:, None] * acceleration)
