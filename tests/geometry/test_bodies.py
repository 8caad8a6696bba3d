"""A part as two bodies: closed, together the part, apart where the style is."""

import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.geometry.bodies import DEPTH, SHARE, shell_and_rest

THICK = np.full(4098, 20.0)


def relief(sphere):
    return sphere.displaced(0.3 * np.sin(9.0 * np.arctan2(sphere.vertices[:, 1], sphere.vertices[:, 0])))


@pytest.mark.parametrize("part", ["all", "upper", "ragged"])
def test_shell_and_rest_are_closed_and_together_the_part(sphere, part):
    z = sphere.vertices[:, 2]
    free = {"all": z > -99.0, "upper": z > 1.0, "ragged": np.random.default_rng(0).random(len(z)) < 0.9}[part]
    shell, rest = shell_and_rest(sphere, relief(sphere), free, THICK)
    assert shell.is_closed
    assert rest.is_closed
    assert min(shell.volume, rest.volume) > 0.0
    assert shell.volume + rest.volume == pytest.approx(relief(sphere).volume, rel=1e-12)


def test_the_shell_is_two_lines_deep_below_the_unstylized_surface_but_no_deeper_than_the_wall_allows(sphere):
    everywhere = np.ones(len(sphere.vertices), dtype=bool)
    for thickness, depth in ((20.0, DEPTH), (1.0, SHARE)):
        _, rest = shell_and_rest(sphere, sphere, everywhere, np.full(len(sphere.vertices), thickness))
        assert np.linalg.norm(rest.vertices, axis=1) == pytest.approx(10.0 - depth, abs=0.01)


def test_what_the_style_may_not_move_is_of_the_rest(sphere):
    free = sphere.vertices[:, 2] > 0.0
    shell, rest = shell_and_rest(sphere, relief(sphere), free, THICK)
    assert shell.vertices[:, 2].min() > -0.01
    kept = {tuple(point) for point in relief(sphere).vertices[~free]}
    assert kept <= {tuple(point) for point in rest.vertices}


def test_a_part_without_style_has_no_shell(sphere):
    with pytest.raises(BadInput, match="nothing of the part is styled"):
        shell_and_rest(sphere, sphere, np.zeros(len(sphere.vertices), dtype=bool), THICK)
