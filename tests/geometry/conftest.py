"""A cup with a 3 mm wall, standardised and filled once: small, thin, curved, standing on a flat face."""

from __future__ import annotations

import manifold3d
import numpy as np
import pytest
import trimesh

from mechstyle.geometry.remeshing.evening import even, surface_of
from mechstyle.geometry.remeshing.filling import fill
from mechstyle.records.mesh import SurfaceMesh, TetMesh


def cup_body(wall: float = 3.0) -> manifold3d.Manifold:
    """A cup of 40 mm diameter and 30 mm height."""
    outer = manifold3d.Manifold.cylinder(30.0, 20.0, 20.0, 64)
    return outer - manifold3d.Manifold.cylinder(30.0, 20.0 - wall, 20.0 - wall, 64).translate((0.0, 0.0, wall))


@pytest.fixture(scope="session")
def cup() -> SurfaceMesh:
    return even(surface_of(cup_body()), 3000)


@pytest.fixture(scope="session")
def cup_tets(cup, cache) -> TetMesh:
    return fill(cup, 3000, cache=cache / "tets")


@pytest.fixture(scope="session")
def block() -> SurfaceMesh:
    """A 20 mm cube, filled in a second."""
    return even(surface_of(manifold3d.Manifold.cube((20.0, 20.0, 20.0))), 600)


@pytest.fixture(scope="session")
def embossed() -> tuple[SurfaceMesh, SurfaceMesh]:
    """A ball and the same under a relief 0.8 mm deep, whose creases alone have more vertices than are asked for below."""
    ball = trimesh.creation.icosphere(5, 20.0)
    plain, checks = SurfaceMesh(ball.vertices, ball.faces), np.floor(ball.vertices / 4.0).sum(axis=1) % 2
    return plain, plain.displaced((0.8 * checks - 0.4).astype(np.float32))
