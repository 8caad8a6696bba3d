"""What a print shows is the relief alone: every style must be seen, and told from the others, without its colours."""

import numpy as np
import pytest

from mechstyle.pictures.camera import Camera
from mechstyle.pictures.colormap import PLAIN
from mechstyle.pictures.scene import render
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.library import names, style_named

WIDTH, HEIGHT, EDGE = 100.0, 80.0, 1.0  # of an upright board [mm]; the edge is about that of 100k vertices on a pen holder
DEPTH, SHARE = 0.6, 0.08  # relief between its lowest and its highest 2 % [mm], and over a feature: no more than a run makes unless told
PIXELS = 160
LEVELS = 8.0
"""Mean difference to the plain board that the eye takes for a relief [of 255 levels of grey]."""


@pytest.fixture(scope="module")
def board() -> SurfaceMesh:
    """An upright sheet that faces -y."""
    z, x = (EDGE * grid for grid in np.mgrid[: round(HEIGHT / EDGE) + 1, : round(WIDTH / EDGE) + 1])
    number = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (part.ravel() for part in (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]))
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return SurfaceMesh(np.stack([x.ravel(), np.zeros(x.size), z.ravel()], axis=1), faces)


@pytest.fixture(scope="module")
def grey(board):
    camera = Camera.named("three_quarter", board.vertices)

    def picture(mesh: SurfaceMesh, colour=PLAIN) -> np.ndarray:
        colours = np.broadcast_to(colour, mesh.vertices.shape)
        return render(mesh, camera=camera, width=PIXELS, height=PIXELS, colours=colours).astype(float).mean(axis=2)

    inside = picture(board, (0.0, 0.0, 0.0)) < 1.0
    return lambda mesh: picture(mesh)[inside]


def embossed(board: SurfaceMesh, name: str) -> SurfaceMesh:
    """The board with a style's relief, its features of their nominal size."""
    style = style_named(name)
    canvas = Canvas(board, seed=0)
    canvas = Canvas(board, seed=0, size=1.0 / canvas.scale)
    height = style.program(canvas).height
    low, high = np.quantile(height, [0.02, 0.98])
    return board.displaced(max(DEPTH, SHARE * style.feature_mm) * (height - height.mean()) / (high - low))


@pytest.mark.parametrize("name", names())
def test_a_style_is_seen_without_its_colours(name, board, grey):
    assert np.abs(grey(embossed(board, name)) - grey(board)).mean() > LEVELS


def test_no_two_styles_look_alike_in_grey(board, grey):
    pictures = np.array([grey(embossed(board, name)) for name in names()])
    alike = np.corrcoef(pictures - grey(board))
    np.fill_diagonal(alike, 0.0)
    assert alike.max() < 0.75
