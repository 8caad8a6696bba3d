import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.pictures.camera import Camera
from mechstyle.pictures.colormap import ABOVE, LINE, STRIPE, Scale
from mechstyle.pictures.scene import BACKGROUND, Field, render

SIZE = {"width": 96, "height": 96}


def silhouette(picture):
    return (np.abs(picture.astype(int) - np.rint(np.array(BACKGROUND) * 255)).max(axis=2) > 40).mean()


def test_the_picture_has_the_part_in_the_middle_and_clean_corners(ball):
    picture = render(ball, camera=Camera.named("front", ball.vertices), **SIZE)
    assert picture.shape == (96, 96, 3)
    assert picture.dtype == np.uint8
    assert (picture[[0, 0, -1, -1], [0, -1, 0, -1]] == np.rint(np.array(BACKGROUND) * 255)).all()
    assert silhouette(picture) == pytest.approx(np.pi / 4 * 0.88**2, rel=0.03)  # a disc that fills 88 % of the picture


def test_colours_are_taken_from_the_argument_then_the_part_then_grey(ball):
    camera = Camera.named("front", ball.vertices)
    red = np.tile((0.9, 0.1, 0.1), (len(ball.vertices), 1))
    grey = render(ball, camera=camera, **SIZE)[48, 48].astype(int)
    own = render(ball.coloured(red), camera=camera, **SIZE)[48, 48].astype(int)
    given = render(ball.coloured(red), camera=camera, colours=red[:, ::-1], **SIZE)[48, 48].astype(int)
    assert np.ptp(grey) < 8
    assert own[0] > own[2] + 100
    assert given[2] > given[0] + 100


def near(picture, colour, reach=60):
    return (np.abs(picture.astype(int) - np.array(colour) * 255).max(axis=2) < reach).mean()


def test_a_field_is_hatched_above_its_threshold_and_outlined_at_it(block):
    camera = Camera.named("top", block.vertices)
    height = block.vertices[:, 0]  # -10 to 10 from left to right
    shown = {limit: render(block, camera=camera, field=Field(height, Scale(-10, 12, limit)), **SIZE) for limit in (0.0, 11.0)}
    red, stripe, line = (near(shown[0.0], colour, reach) for colour, reach in ((ABOVE, 60), (STRIPE, 60), (LINE, 50)))
    assert 1.2 < red / stripe < 2.8  # a third of the hatch is stripes
    assert 0.003 < line < 0.05
    assert near(shown[0.0][:, 50:], ABOVE) > 0.2
    assert near(shown[0.0][:, :46], ABOVE) == 0
    assert near(shown[11.0], ABOVE) == 0


def test_colours_and_fields_must_fit_the_part(ball):
    camera = Camera.named("front", ball.vertices)
    with pytest.raises(BadInput, match="one RGB row for each"):
        render(ball, camera=camera, colours=np.zeros((3, 3)), **SIZE)
    with pytest.raises(BadInput, match="one value for each"):
        render(ball, camera=camera, field=Field(np.zeros(3), Scale(0, 1)), **SIZE)


def test_where_a_field_has_no_value_it_is_grey_and_hatched(ball):
    """Protected regions are shown so; grey alone could be a colour of the scale to some eyes."""
    values = np.where(ball.vertices[:, 0] > 0.0, np.nan, 0.5)
    camera = Camera.named("front", ball.vertices)
    picture = render(ball, camera=camera, field=Field(values, Scale(0.0, 1.0)), **SIZE).astype(int)
    without, known = picture[30:66, 52:76].reshape(-1, 3), picture[30:66, 20:44].reshape(-1, 3)
    assert np.ptp(without, axis=1).max() <= 3, "grey"
    assert np.ptp(known, axis=1).min() > 20, "coloured"
    assert np.ptp(without.mean(axis=1)) > 40, "in two tones"
