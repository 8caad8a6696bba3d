import numpy as np
import torch

from mechstyle.pictures.visibility import visible
from mechstyle.styling.learned import tensors
from mechstyle.styling.learned.tensors import edges_of, face_of, nearest_faces, parting_edges

SIZE = 10
SQUARE = torch.tensor([[0, 2, 1], [0, 3, 2]], dtype=torch.int32)  # rows run down, so this winding faces the viewer


def square(left, top, right, bottom, depth=1.0):
    corners = [(left, top), (right, top), (right, bottom), (left, bottom)]
    return torch.tensor([[x, y, 1.0 / depth] for x, y in corners], dtype=torch.float64)


def outline(points, faces):
    """The ends of the edge between pixel (row, column) and its neighbour to the right, the same below, and which second ones are inside."""
    edges = edges_of(faces)
    edge, second = parting_edges(points[None], edges, nearest_faces(points[None], faces, SIZE, SIZE))

    def ends(found):
        return {(row, column): tuple(edges[found[row, column], :2].tolist()) for row, column in (found >= 0).nonzero().tolist()}

    return [ends(found) for found in edge[:, 0]], second[:, 0]


def test_an_outline_parts_the_pixels_it_passes_between_and_no_others():
    (right, below), second = outline(square(2.25, 3.0, 6.75, 7.0), SQUARE)
    rows = range(3, 7)
    assert right == {(row, 1): (0, 3) for row in rows} | {(row, 6): (1, 2) for row in rows}
    assert below == {(2, column): (0, 1) for column in range(2, 7)} | {(6, column): (2, 3) for column in range(2, 7)}
    assert second[0, 4, 1]  # the square begins right of that pixel
    assert not second[0, 4, 6]
    assert second[1, 2, 4]
    assert not second[1, 6, 4]


def test_a_hidden_outline_parts_nothing_and_one_in_front_does():
    faces = torch.cat([SQUARE, SQUARE + 4])
    screen, plate = square(0.2, 0.2, 9.8, 9.8, depth=2.0), square(3.2, 3.2, 6.8, 6.8, depth=1.5)
    behind = square(3.2, 3.2, 6.8, 6.8, depth=2.5)
    in_front, _ = outline(torch.cat([screen, plate]), faces)
    hidden, _ = outline(torch.cat([screen, behind]), faces)
    assert in_front[0] == {(row, 2): (4, 7) for row in range(3, 7)} | {(row, 6): (5, 6) for row in range(3, 7)}
    assert hidden == [{}, {}]


def test_the_z_buffer_is_that_of_the_pictures(sphere):
    shift = np.array([[(0.0, 0.0, 20.0)], [(3.0, -2.0, 17.0)]])
    points = sphere.vertices * (1.0, 1.0, -1.0) + shift  # z is depth here
    ndc = np.stack([points[..., 0] / points[..., 2], points[..., 1] / points[..., 2], points[..., 2]], axis=-1)
    pixels = torch.tensor(np.stack([(ndc[..., 0] + 1) * 32, (1 - ndc[..., 1]) * 32, 1 / ndc[..., 2]], axis=-1))
    faces = torch.tensor(sphere.faces, dtype=torch.int32)
    found = face_of(nearest_faces(pixels, faces, 64, 64, cull=False)).numpy()
    assert (found == visible(ndc, sphere.faces, 64, 64).face).mean() > 0.998  # the grids of the two differ in fineness


def test_compilers_are_told_the_truth_about_the_operators():
    points, nearness = tensors._snapped(square(2.0, 2.0, 8.0, 8.0)[None])
    utilities = ("test_schema", "test_faketensor")
    torch.library.opcheck(tensors._draw_op, (points, [1, SIZE, SIZE], nearness, SQUARE, True), test_utils=utilities)
    buffer = tensors._draw_op(points, [1, SIZE, SIZE], nearness, SQUARE, True)
    torch.library.opcheck(tensors._part_op, (buffer, points, nearness, edges_of(SQUARE)), test_utils=utilities)
