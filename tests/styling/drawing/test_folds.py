import numpy as np

from mechstyle.styling.drawing.operators import Operators, unfolded


def turns(mesh, displacement):
    return np.einsum("ij,ij->i", mesh.displaced(displacement).face_normals, mesh.face_normals)


def test_relief_that_folds_is_lowered_until_it_does_not(stand):
    relief = np.random.default_rng(0).uniform(-4.0, 8.0, len(stand.vertices))
    assert turns(stand, relief).min() < -0.5
    smooth = unfolded(Operators(stand), relief)
    assert turns(stand, smooth).min() >= 0.17
    assert np.all(smooth * relief >= 0.0)
    assert np.all(np.abs(smooth) <= np.abs(relief))


def test_relief_that_does_not_fold_is_left_alone(stand):
    relief = np.random.default_rng(0).uniform(-0.3, 0.3, len(stand.vertices))
    assert np.array_equal(unfolded(Operators(stand), relief), relief)


def test_an_inner_corner_may_not_be_overgrown(stand):
    # Both plates of the L grow by 30 mm and would cross at their inner corner.
    assert turns(stand, unfolded(Operators(stand), np.full(len(stand.vertices), 30.0))).min() >= 0.17
