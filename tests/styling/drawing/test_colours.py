import numpy as np

from mechstyle.styling.drawing.colours import luminance, mix, ramp, recoloured, rgb, smoothstep


def test_smoothstep_rises_between_its_ends_and_falls_when_they_are_swapped():
    values = np.array([-1.0, 2.0, 3.0, 4.0, 9.0])
    assert smoothstep(2.0, 4.0, values).tolist() == [0.0, 0.0, 0.5, 1.0, 1.0]
    assert smoothstep(4.0, 2.0, values).tolist() == [1.0, 1.0, 0.5, 0.0, 0.0]


def test_mix_and_ramp_meet_their_ends():
    assert np.array_equal(mix(rgb("ff0000"), rgb("0000ff"), np.array([0.0, 1.0])), [[1, 0, 0], [0, 0, 1]])
    stops = ramp(["000000", "ff0000", "ffffff"], np.array([0.0, 0.25, 0.5, 1.0]))
    assert np.allclose(stops, [[0, 0, 0], [0.5, 0, 0], [1, 0, 0], [1, 1, 1]])


def test_recolouring_keeps_light_and_dark():
    colours = np.array([[0.2, 0.2, 0.2], [0.4, 0.4, 0.4], [0.6, 0.6, 0.6]])
    blue = recoloured(colours, (0.1, 0.2, 0.6))
    assert np.all(np.diff(luminance(blue)) > 0)
    assert np.allclose(blue[1], (0.1, 0.2, 0.6))
    assert (blue.argmax(axis=1) == 2).all()
