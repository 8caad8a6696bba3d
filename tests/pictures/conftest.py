import manifold3d
import numpy as np
import pytest

from mechstyle.records.mesh import SurfaceMesh


def surface(body):
    mesh = body.to_mesh64()
    return SurfaceMesh(np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts))


@pytest.fixture(scope="session")
def block():
    return surface(manifold3d.Manifold.cube((20.0, 20.0, 20.0)).translate((-10.0, -10.0, 0.0)))


@pytest.fixture(scope="session")
def ball():
    return surface(manifold3d.Manifold.sphere(10.0, 128).translate((0.0, 0.0, 10.0)))
