"""Load cases on a body: places picked once on the unstylized part, loads and stresses worked out on every morph of it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from mechstyle.errors import BadInput
from mechstyle.fea.drop import GRAVITY
from mechstyle.fea.elements import ElementMesh, element_named, with_nodes
from mechstyle.fea.statics.boundary import Boundary
from mechstyle.fea.statics.pick import Picked, pick
from mechstyle.fea.statics.solve import Response, Restraint, solve
from mechstyle.records.load_cases import Load, LoadCase, Place, Support
from mechstyle.records.material import Material
from mechstyle.records.mesh import Bools, Floats, TetMesh

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
        loads = {case.name: self._nodal_loads(case, boundary, material) for case in self.cases}
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
    def borders(self) -> dict[str, Bools]:
        """Vertices where a support or load of each case ends, by its name, shape [vertex_count]: stress has no limit there."""
        count, borders = len(self.tets.vertices), dict[str, Bools]()
        for case in self.cases:
            places = [support.at for support in case.supports] + [load.at for load in case.loads if load.at is not None]
            borders[case.name] = np.any([self._picked[place].border(self._undeformed)[:count] for place in places], axis=0)
        return borders

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

    def _nodal_loads(self, case: LoadCase, boundary: Boundary, material: Material) -> Floats:
        total = sum((self._nodal_load(load, boundary, material) for load in case.loads), np.zeros_like(boundary.mesh.nodes))
        if not total.any():
            raise BadInput(f"load case {case.name!r}: its loads cancel out everywhere; leave it out or change a load")
        return total

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
