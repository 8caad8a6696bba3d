import numpy as np

from mechstyle.styling.drawing.noise import fbm, perlin, random_of

PLACES = np.random.default_rng(1).uniform(-500.0, 500.0, (20_000, 3))


def test_random_numbers_are_uniform_and_the_same_for_the_same_identity():
    numbers = random_of(np.arange(50_000), seed=3)
    counts, _ = np.histogram(numbers, bins=10, range=(0.0, 1.0))
    # 5000 in each tenth; five standard deviations of a binomial count are 335.
    assert np.abs(counts - 5000).max() < 335
    assert np.array_equal(random_of(np.array([7, 7, 9]), seed=3), numbers[[7, 7, 9]])


def test_perlin_noise_is_smooth():
    step = 1e-4
    beside = PLACES[:2000] + np.array([step, 0.0, 0.0])
    slope = (perlin(beside, 2) - perlin(PLACES[:2000], 2)) / step
    assert np.abs(slope).max() < 4.0  # gradients are at most sqrt(2), fades add at most 15/8 times the difference of two


def test_fbm_has_three_deviations_at_one():
    for octaves in (1, 4):
        values = fbm(PLACES, 30.0, octaves, seed=0)
        assert abs(values.mean()) < 0.02
        assert 0.28 < values.std() < 0.39
