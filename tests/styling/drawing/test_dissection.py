import numpy as np
import pytest
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from mechstyle.geometry.subdivision import subdivided
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.styling.drawing import operators
from mechstyle.styling.drawing.operators import Factors, Operators, dissected


def heat(mesh: SurfaceMesh, length: float = 5.0) -> sp.csr_array:
    """A step of heat flow over a length [mm]."""
    return sp.diags_array(mesh.vertex_areas) + 0.5 * length**2 * Operators(mesh).laplacian


def fill(matrix: sp.csr_array, order: np.ndarray) -> int:
    """Numbers in the factors of a matrix that is eliminated in an order."""
    inner = sp.csc_array(matrix[order][:, order])
    return int(splu(inner, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True}).nnz)


def test_every_vertex_is_eliminated_once(holder):
    order = dissected(holder.vertices, holder.edges)
    assert np.array_equal(np.sort(order), np.arange(len(holder.vertices)))


def test_what_parts_a_piece_comes_after_both_of_its_halves():
    """A row of vertices longer than a piece: the last to be eliminated parts it in the middle."""
    count = 2 * operators.LEAST
    line = np.stack([np.arange(count), np.zeros(count), np.zeros(count)], axis=1)
    order = dissected(line.astype(float), np.stack([np.arange(count - 1), np.arange(1, count)], axis=1).astype(np.int32))
    assert order[-1] == count // 2 - 1


def test_factors_grow_little_faster_than_the_surface(sphere):
    """As n log n (George 1973): with four times the vertices less than six times, where n√n would be eight."""
    few, many = (subdivided(sphere, parts) for parts in (1, 2))
    small, large = (fill(heat(mesh), dissected(mesh.vertices, mesh.edges)) for mesh in (few, many))
    assert 4.0 < large / small < 6.0


@pytest.mark.parametrize("shape", [(), (3,)])
def test_a_system_is_solved_for_one_side_and_for_several(holder, shape):
    matrix, right = heat(holder), np.random.default_rng(0).normal(size=(len(holder.vertices), *shape))
    found = Factors(matrix, dissected(holder.vertices, holder.edges)).solve(right)
    assert np.abs(matrix @ found - right).max() < 1e-10


def test_vertices_in_one_place_are_parted_all_the_same():
    count = 5 * operators.LEAST
    order = dissected(np.zeros((count, 3)), np.stack([np.arange(count - 1), np.arange(1, count)], axis=1).astype(np.int32))
    assert np.array_equal(np.sort(order), np.arange(count))
