import pytest
import torch

from mechstyle.styling.learned import antialias
from mechstyle.styling.learned.antialias import antialiased
from mechstyle.styling.learned.tensors import edges_of, face_of, nearest_faces

SIZE = 10
FACES = torch.tensor([[0, 2, 1], [0, 3, 2]], dtype=torch.int32)  # rows run down, so this winding faces the viewer


def white(_ends, weights, _view):
    return torch.ones_like(weights[0])[:, None]


def covered(left, top, right, bottom, *, static):
    """Share of every pixel that a rectangle covers, by fading its outline."""
    corners = torch.stack([torch.stack([x, y]) for x, y in ((left, top), (right, top), (right, bottom), (left, bottom))])
    points = torch.cat([corners, torch.ones(4, 1, dtype=torch.float64)], dim=1)[None]
    buffer = nearest_faces(points, FACES, SIZE, SIZE)
    hard = (face_of(buffer) >= 0).double().view(1, -1)
    return antialiased(hard, points, edges_of(FACES), buffer, white, static=static).view(SIZE, SIZE)


@pytest.mark.parametrize("static", [False, True])
@pytest.mark.parametrize(("left", "right"), [(2.25, 6.75), (2.75, 6.25), (2.9, 7.1), (2.6, 6.4)])
def test_straight_sides_cover_their_exact_share_and_move_it_with_them(left, right, static):
    sides = torch.tensor([left, 3.1, right, 7.7], dtype=torch.float64, requires_grad=True)
    share = covered(*sides, static=static)
    columns, rows = torch.arange(SIZE), torch.arange(SIZE)
    across = (torch.minimum(columns + 1, sides[2]) - torch.maximum(columns, sides[0])).clamp(min=0.0)
    down = (torch.minimum(rows + 1, sides[3]) - torch.maximum(rows, sides[1])).clamp(min=0.0)
    assert torch.allclose(share[5], across, atol=1e-4)  # the grid of the z-buffer
    assert torch.allclose(share[:, 4], down, atol=1e-4)
    (slopes,) = torch.autograd.grad(share[5].sum() + 2.0 * share[:, 4].sum(), sides)
    assert torch.allclose(slopes, torch.tensor([-1.0, -2.0, 1.0, 2.0], dtype=torch.float64))


def test_where_no_shape_may_depend_on_the_picture_outlines_past_the_last_slot_stay_hard(monkeypatch):
    sides = torch.tensor([2.25, 3.1, 6.75, 7.7], dtype=torch.float64)
    monkeypatch.setattr(antialias, "MOST_PARTED", 50)  # 5 slots for 200 pairs, those on rows first
    soft, some_hard = covered(*sides, static=False), covered(*sides, static=True)
    assert some_hard[4, [2, 6]].tolist() == pytest.approx(soft[4, [2, 6]].tolist())  # the second row: pairs 3 and 4
    assert some_hard[6].tolist() == [float(2.25 < column + 0.5 < 6.75) for column in range(SIZE)]  # the fourth
