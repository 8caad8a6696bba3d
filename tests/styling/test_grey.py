"""What a print shows is the relief alone: every style must be seen, and told from the others, without its colours.

And it is drawn as in the version before: a run that is done again is to give the same part.
"""

import json
import os
from pathlib import Path

import numpy as np
import pytest

from mechstyle.pictures.camera import Camera
from mechstyle.pictures.colormap import PLAIN
from mechstyle.pictures.scene import render
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.styling.library import names, style_named
from mechstyle.styling.style import Relief

WIDTH, HEIGHT, EDGE = 100.0, 80.0, 1.0  # of an upright board [mm]; the edge is about that of 100k vertices on a pen holder
DEPTH, SHARE = 0.6, 0.08  # relief between its lowest and its highest 2 % [mm], and over a feature: no more than a run makes unless told
PIXELS = 160
LEVELS = 8.0
"""Mean difference to the plain board that the eye takes for a relief [of 255 levels of grey] …"""
FAINT = {"checkers": 7.0, "corrugated": 4.5, "half_timbered": 7.5, "kintsugi": 4.5}
"""… but for styles that are known by few edges: flat squares, a smooth wave, beams and seams with plain faces between them."""


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
        found = render(mesh, camera=camera, width=PIXELS, height=PIXELS, colours=colours, supersampling=2)
        return found.astype(float).mean(axis=2)

    inside = picture(board, (0.0, 0.0, 0.0)) < 1.0
    return lambda mesh: picture(mesh)[inside]


@pytest.fixture(scope="module")
def reliefs(board, blank) -> dict[str, Relief]:
    """Each style on the board, its features of their nominal size."""
    size = 1.0 / blank(board).scale
    return {name: style_named(name).program(blank(board, size=size)) for name in names()}


@pytest.fixture(scope="module")
def pictures(board, grey, reliefs) -> dict[str, np.ndarray]:
    """The board in grey with each style's relief, less the plain board."""
    plain, found = grey(board), {}
    for name, relief in reliefs.items():
        height = relief.height
        low, high = np.quantile(height, [0.02, 0.98])
        depth = max(DEPTH, SHARE * style_named(name).feature_mm) / (high - low)
        found[name] = grey(board.displaced(depth * (height - height.mean()))) - plain
    return found


@pytest.mark.parametrize("name", names())
def test_a_style_is_seen_without_its_colours(name, pictures):
    assert np.abs(pictures[name]).mean() > FAINT.get(name, LEVELS)


def test_no_two_styles_look_alike_in_grey(pictures):
    alike = np.corrcoef(list(pictures.values()))
    np.fill_diagonal(alike, 0.0)
    assert alike.max() < 0.75


STORED = Path(__file__).with_name("styles.json")
"""Mean and spread of each style's height and colours on the board; with $MECHSTYLE_STORE_STYLES at 1 they are those of now."""


@pytest.fixture(scope="module")
def before(reliefs) -> dict[str, list[float]]:
    if os.environ.get("MECHSTYLE_STORE_STYLES") == "1":
        lines = (f"{json.dumps(name)}: {json.dumps(figures_of(relief))}" for name, relief in reliefs.items())
        STORED.write_text("{\n" + ",\n".join(lines) + "\n}\n")
    return json.loads(STORED.read_text())


def figures_of(relief: Relief) -> list[float]:
    return [round(float(part), 4) for part in (relief.height.mean(), relief.height.std(), *relief.colour.mean(axis=0), relief.colour.std())]


@pytest.mark.parametrize("name", names())
def test_a_style_is_drawn_as_before_unless_its_change_is_stored(name, reliefs, before):
    """Whoever changes one looks at its picture, stores these and tells it in the change log: who prints it again gets another part."""
    assert figures_of(reliefs[name]) == pytest.approx(before[name], abs=1e-3)
