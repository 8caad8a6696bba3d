"""Loads scaled to a share of what the plain part carries, so that parts as different as a hook and a box are loaded as hard."""

from __future__ import annotations

import hashlib
import math
from pathlib import Path

import msgspec

from mechstyle._files import exclusive, write_whole
from mechstyle.fea.statics.load_test import StaticTest
from mechstyle.fea.stressed_volume import LOADED, Walls, at_nodes, exceeded
from mechstyle.records import Recipe
from mechstyle.records.load_cases import Load, LoadCase
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.simulation.part import prepare


class LoadFactor(msgspec.Struct, frozen=True, kw_only=True):
    """What a plain part carries of one load case.

    Attributes:
        case: Name of the case.
        stress: σ_V under the case [MPa].
        factor: Load factor: how many times the case before σ_V is the yield strength.
    """

    case: str
    stress: float
    factor: float


def with_loads(recipe: Recipe, model: SurfaceMesh, vertices: int, *, share: float, folder: Path) -> Recipe:
    """A recipe whose load cases are each a share of what the plain part carries.

    Args:
        recipe: It names the cases and the material.
        model: The part.
        vertices: Vertices of the standardised surface.
        share: Load asked for over the load at which σ_V is the yield strength.
        folder: Where the load factors of the plain part are kept, so that all runs of a study ask for the same load.

    Raises:
        BadInput: If the part or a case cannot be used.
        SimulationFailed: If the part cannot be meshed or the equations cannot be solved.
    """
    asked = (model.digest, vertices, recipe.test.loads, recipe.test.material, recipe.test.element, recipe.test.across_layers)
    name = hashlib.sha256(msgspec.json.encode(asked)).hexdigest()[:24]
    path = folder / f"{name}.json"
    with exclusive(folder / "locks" / name, f"the load of {recipe.test.loads[0].name!r}", wait=True):
        try:
            known = msgspec.json.decode(path.read_bytes(), type=tuple[LoadFactor, ...])
        except (OSError, msgspec.MsgspecError):
            known = load_factors(recipe, model, vertices)
            write_whole(path, msgspec.json.format(msgspec.json.encode(known), indent=1))
    cases = tuple(scaled(case, share * one.factor) for case, one in zip(recipe.test.loads, known, strict=True))
    return recipe.with_settings(loads=cases)


def load_factors(recipe: Recipe, model: SurfaceMesh, vertices: int) -> tuple[LoadFactor, ...]:
    """Load factors of a plain part, one for each load case of a recipe; arguments and errors as for `with_loads`."""
    part = prepare(model, vertices=vertices)
    test = recipe.test
    responses = StaticTest(part.tets, test.loads, test.element).run(part.tets, test.material, test.across_layers)
    weights, found = Walls(part.surface.vertices, part.thickness).weights(part.tets), []
    for name, response in responses.items():
        stress = exceeded(part.tets, at_nodes(part.tets, response.corners), weights, LOADED**3).stress
        found.append(LoadFactor(case=name, stress=stress, factor=recipe.test.material.yield_strength / stress))
    return tuple(found)


def scaled(case: LoadCase, factor: float) -> LoadCase:
    """A load case with all its loads multiplied."""
    loads = []
    for load in case.loads:
        if load.force is not None:
            x, y, z = load.force
            loads.append(msgspec.structs.replace(load, force=(factor * x, factor * y, factor * z)))
        elif load.pressure is not None:
            loads.append(msgspec.structs.replace(load, pressure=factor * load.pressure))
        else:
            assert load.gravity is not None, "a load is a force, a pressure or gravity"
            loads.append(msgspec.structs.replace(load, gravity=factor * load.gravity))
    return msgspec.structs.replace(case, loads=tuple(loads))


def words_of(case: LoadCase) -> str:
    """Name and size of a load case, such as "heavy coat, 703 N"."""
    return ", ".join((case.name, *map(_size, case.loads)))


def _size(load: Load) -> str:
    if load.force is not None:
        size = math.hypot(*load.force)
        return f"{size:.0f} N" if size >= 100.0 else f"{size:.3g} N"
    return f"{load.gravity:.3g} × its weight" if load.gravity is not None else f"{load.pressure:.3g} MPa"
