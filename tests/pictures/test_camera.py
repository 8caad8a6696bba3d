import numpy as np
import pytest

from mechstyle.pictures.camera import VIEWS, Camera


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("aspect", [0.5, 1.0, 2.0])
def test_a_fitted_camera_sees_all_and_wastes_nothing(view, aspect):
    points = np.random.default_rng(1).normal(size=(300, 3)) * (40, 10, 25) + (7, -3, 12)
    picture = Camera.named(view, points, aspect=aspect).project(points)
    reach = np.abs(picture[:, :2]).max(axis=0)
    assert reach.max() == pytest.approx(0.88, abs=1e-9)  # 6 % of the picture left free on each side
    assert (reach <= 0.88 + 1e-9).all()
    low, high = picture[:, :2].min(axis=0), picture[:, :2].max(axis=0)
    tight = reach.argmax()
    assert low[tight] == pytest.approx(-high[tight], abs=1e-9)
    assert (picture[:, 2] > 0).all()


@pytest.mark.parametrize(
    ("view", "point", "right", "up"),
    [
        ("front", (1, 0, 0), 1, 0),
        ("front", (0, 0, 1), 0, 1),
        ("side", (0, 1, 0), 1, 0),
        ("top", (1, 0, 0), 1, 0),
        ("top", (0, 1, 0), 0, 1),
    ],
)
def test_named_views_are_where_a_drawing_has_them(view, point, right, up):
    azimuth, elevation = VIEWS[view]
    x, y, _ = Camera(azimuth, elevation, (0, 0, 0), 1e6).project([point])[0]
    assert np.sign(np.round([x, y], 9)) == pytest.approx((right, up))


def test_directions_go_through_the_pixels_they_belong_to():
    camera = Camera(30, 20, (1, 2, 3), 80, aspect=2.0)
    spots = camera.eye + 55.0 * camera.directions(40, 20)
    x, y, depth = np.moveaxis(camera.project(spots.reshape(-1, 3)).reshape(20, 40, 3), -1, 0)
    assert depth == pytest.approx(55.0)
    assert x[3] == pytest.approx((2 * np.arange(40) + 1) / 40 - 1)
    assert y[:, 7] == pytest.approx(1 - (2 * np.arange(20) + 1) / 20)
