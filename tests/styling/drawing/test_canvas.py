import numpy as np
import pytest

from mechstyle.records.mesh import SurfaceMesh
from mechstyle.styling.drawing.canvas import Canvas


@pytest.fixture(scope="module")
def canvas(holder) -> Canvas:
    return Canvas(holder, seed=0)


def test_features_have_their_nominal_size_on_a_part_of_100_mm_and_grow_with_it(holder):
    cube = SurfaceMesh(holder.vertices, holder.faces)
    area = cube.face_areas.sum()
    assert np.isclose(Canvas(cube, 0).scale, np.sqrt(area / 60_000.0))
    assert np.isclose(Canvas(cube.moved(2.0 * cube.vertices), 0).scale, 2.0 * Canvas(cube, 0).scale)
    assert np.isclose(Canvas(cube, 0, size=0.5).scale, 0.5 * Canvas(cube, 0).scale)
    assert Canvas(cube.moved(100.0 * cube.vertices), 0).scale == 4.0


def test_a_feature_too_fine_is_enlarged_to_what_the_mesh_carries_and_a_note_says_by_how_much(holder):
    canvas = Canvas(holder, 0)
    unit = canvas.unit("joints", 0.5 * canvas.edge, edges=2.0)
    assert np.isclose(unit * 0.5 * canvas.edge, 2.0 * canvas.edge)
    assert len(canvas.notes) == 1
    assert "joints" in canvas.notes[0]
    assert f"enlarged {unit / canvas.scale:.1f}x" in canvas.notes[0]


def test_a_bond_tells_places_in_cells_and_shifts_every_second_row(stand):
    bond = Canvas(stand, 0).bond(20.0, 10.0)
    assert np.abs(bond.x).max() <= 0.5
    assert np.abs(bond.y).max() <= 0.5
    front = (stand.vertex_normals[:, 1] < -0.9) & (np.abs(stand.vertices[:, 0] - 32.0) < 0.1)
    # The box is 60 mm wide: three cells of 20 mm, the middle of the second at 30 mm, or a border in the shifted rows.
    assert np.allclose(bond.x[front & ~bond.odd], 0.1)
    assert np.allclose(bond.x[front & bond.odd], -0.4)
    assert np.array_equal(bond.odd[front], np.floor(stand.vertices[front, 2] / 10.0 + 1e-9).astype(int) % 2 == 1)


def test_tools_of_one_seed_draw_the_same_and_of_another_seed_something_else(holder):
    def drawn(seed: int) -> list[bytes]:
        canvas = Canvas(holder, seed)
        cells = canvas.cells(15.0, at=canvas.warped(10.0, 3.0))
        return [canvas.noise(20.0).tobytes(), cells.edge.tobytes(), canvas.random(cells.identity).tobytes()]

    assert drawn(4) == drawn(4)
    assert all(mine != other for mine, other in zip(drawn(4), drawn(5), strict=True))


def test_pieces_are_parted_by_what_is_outside_and_by_labels(holder, canvas):
    z = holder.vertices[:, 2]
    radius = np.hypot(holder.vertices[:, 0], holder.vertices[:, 1])
    wall = np.abs(radius - 40.0) < 0.1
    pieces = canvas.pieces(wall & (np.abs(z - 50.0) > 5.0))
    assert len(np.unique(pieces[wall & (z > 56.0)])) == 1
    assert pieces[wall & (z > 56.0)][0] != pieces[wall & (z < 44.0)][0]
    parted = canvas.pieces(wall, z > 50.0)
    assert len(np.unique(parted[wall])) == 2
