import numpy as np
import pytest

from mechstyle._colour import oklab
from mechstyle.pictures.colormap import Scale

# Linear RGB as seen without one kind of cone (Machado, Oliveira and Fernandes 2009, severity 1).
DEFICIENCIES = {
    "protanopia": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deuteranopia": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "tritanopia": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}
RAMP = Scale(0.0, 1.0).colours(np.linspace(0.0, 1.0, 256))


def test_oklab_of_white_and_of_pure_red():
    assert oklab([1.0, 1.0, 1.0]) == pytest.approx([1.0, 0.0, 0.0], abs=1e-6)
    assert oklab([1.0, 0.0, 0.0]) == pytest.approx([0.62796, 0.22486, 0.12585], abs=1e-4)  # Ottosson 2020


def test_equal_steps_look_equal():
    steps = np.linalg.norm(np.diff(oklab(RAMP), axis=0), axis=1)
    assert steps.min() > 0.85 * steps.mean()  # where the path through colour space bends, one step cuts the corner
    assert steps.max() < 1.05 * steps.mean()
    assert np.median(steps) == pytest.approx(steps.mean(), rel=0.01)


def test_the_ramp_is_told_in_grey_and_on_white():
    lightness = oklab(RAMP)[:, 0]
    assert (np.diff(lightness) < 0).all()
    assert lightness[0] < 0.97  # still darker than the page
    assert lightness[0] - lightness[-1] > 0.6


@pytest.mark.parametrize("kind", DEFICIENCIES)
def test_the_ramp_and_the_threshold_are_told_by_the_colour_blind(kind):
    lab = oklab(np.clip(RAMP @ np.transpose(DEFICIENCIES[kind]), 0, 1))
    apart = np.linalg.norm(lab[None, ::16] - lab[::16, None], axis=2)
    assert apart[~np.eye(len(apart), dtype=bool)].min() > 0.02  # a just noticeable difference in Oklab
    above = oklab(np.clip(Scale(0.0, 1.0, 0.9).colours(2.0) @ np.transpose(DEFICIENCIES[kind]), 0, 1))
    assert abs(above[0] - lab[-1, 0]) > 0.2  # lightness alone tells it from the dark end it borders on


def test_values_map_linearly_and_saturate():
    scale = Scale(0.0, 10.0)
    assert scale.colours([-5.0, 0.0]) == pytest.approx(RAMP[[0, 0]])
    assert scale.colours([10.0, 99.0]) == pytest.approx(RAMP[[-1, -1]])
    assert scale.colours(np.full((2, 3), 2.0)) == pytest.approx(np.broadcast_to(RAMP[51], (2, 3, 3)))


def test_the_ramp_ends_at_the_threshold_and_beyond_it_one_colour_rules():
    scale = Scale(0.0, 60.0, 45.6)
    assert scale.top == 45.6
    assert scale.colours(45.6) == pytest.approx(RAMP[-1])
    assert scale.beyond([45.6, 45.7, np.nan]).tolist() == [False, True, False]
    assert (scale.colours(46.0) == scale.colours(60.0)).all()
    assert np.abs(scale.colours(46.0) - RAMP).sum(axis=1).min() > 0.5


def test_a_value_that_is_not_a_number_is_grey():
    r, g, b = Scale(0.0, 1.0, 0.5).colours(np.nan)
    assert r == g == b
