"""Files for ParaView: quadratic cells whose middle nodes are where VTK expects them."""

from __future__ import annotations

import meshio
import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.fea.drop import DropTest, drop
from mechstyle.fea.elements import ELEMENTS, with_nodes
from mechstyle.fea.snapshots import snapshot, snapshots
from mechstyle.records.material import LIBRARY
from mechstyle.simulation.drop_history import on_nodes, vtu, vtu_path
from validation.meshes import box

VTK_EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))
"""Of VTK_QUADRATIC_TETRA, in the order of its nodes 4 to 9 (VTK file formats, figure 3)."""


@pytest.fixture(scope="module")
def block():
    return box((3, 4, 4), (12.0, 10.0, 16.0))


@pytest.fixture
def pla():
    return LIBRARY["PLA"]


@pytest.fixture
def read(tmp_path):
    def reader(content):
        (tmp_path / "part.vtu").write_bytes(content)
        return meshio.read(tmp_path / "part.vtu")

    return reader


def test_middle_nodes_lie_in_the_middle_of_the_edges_vtk_has_them_on(block, read):
    mesh = with_nodes(block, ELEMENTS["tet10"])
    found = read(vtu(mesh, {"height": mesh.nodes[:, 2]}, {"number": np.arange(len(block.tets))}))
    cells = found.cells_dict["tetra10"]
    for place, (start, end) in enumerate(VTK_EDGES, start=4):
        middle = found.points[cells[:, [start, end]]].mean(axis=1)
        np.testing.assert_allclose(found.points[cells[:, place]], middle, atol=1e-9)
    np.testing.assert_array_equal(cells[:, :4], block.tets)
    corners = found.points[cells[:, :4]]
    assert (np.linalg.det(corners[:, 1:] - corners[:, :1]) > 0.0).all()
    np.testing.assert_array_equal(found.point_data["height"], found.points[:, 2])
    np.testing.assert_array_equal(found.cell_data["number"][0], np.arange(len(block.tets)))


def test_linear_elements_are_linear_cells(block, read):
    found = read(vtu(with_nodes(block, ELEMENTS["tet4"]), {}, {}))
    np.testing.assert_array_equal(found.cells_dict["tetra"], block.tets)


@pytest.mark.parametrize("element", ELEMENTS.values(), ids=ELEMENTS)
def test_a_linear_field_is_known_at_every_node(block, element):
    mesh = with_nodes(block, element)
    slope = np.array([1.0, -2.0, 3.0])
    np.testing.assert_allclose(on_nodes(mesh, block.vertices @ slope), mesh.nodes @ slope, atol=1e-9)


def test_other_endings_are_refused():
    with pytest.raises(BadInput, match=r"give part.vtu instead of part.vtk"):
        vtu_path("part.vtk")


def test_a_drop_stopped_at_a_moment_is_where_its_snapshots_show_it(block, pla):
    test = DropTest(window=0.2)
    seen = snapshots(block, pla, test, frames=5)
    stopped = snapshot(block, pla, test, float(seen.time[2]))
    assert stopped.time == pytest.approx(seen.time[2])
    np.testing.assert_array_equal(stopped.displacement[: len(stopped.vertices)], seen.displacement[2][stopped.vertices])
    assert len(stopped.displacement) == len(stopped.mesh.nodes)
    ends = stopped.displacement[stopped.mesh.connectivity[:, [0, 1]]].mean(axis=1)
    middle = stopped.displacement[stopped.mesh.connectivity[:, 4]]
    assert 0.0 < np.abs(middle - ends).max() < 0.1 * np.abs(ends).max()  # edges bend, but not much
    assert snapshot(block, pla, test, 99.0).time == pytest.approx(test.window)


def test_a_drop_as_placed_is_that_moment_s_drop(block, pla):
    """Contact is with the vertices that are on the floor, in the numbering of the caller."""
    result = drop(block, pla, [[0.0, 0.0, 1.0]], DropTest(window=0.05), device="cpu")
    stopped = snapshot(block, pla, DropTest(window=0.05), 0.05)
    touched = result.contact[0][stopped.vertices]
    low = stopped.mesh.nodes[: len(touched), 2] < 1e-6
    np.testing.assert_array_equal(touched, low)
