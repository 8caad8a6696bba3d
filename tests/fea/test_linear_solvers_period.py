"""The lowest elastic period against beam theory and a dense solver."""

import numpy as np
import pytest
from scipy.linalg import eigvalsh

from mechstyle.fea.discretisation import discretise
from mechstyle.fea.elasticity import stiffness_matrix
from mechstyle.fea.elements import ELEMENTS, QUADRATIC
from mechstyle.fea.linear_solvers import lowest_period
from mechstyle.records.mesh import TetMesh


def test_a_slender_bar_swings_as_a_free_beam(box, pla):
    """ω = 22.373/L² sqrt(E I/(ρ A)) of Euler and Bernoulli; shear makes a bar of 1 : 30 slower by some per cent."""
    length, thickness = 120.0, 4.0
    body = discretise(box((24, 2, 1), (length, 8.0, thickness)), pla, 0.0, QUADRATIC)
    omega = 22.373 / length**2 * np.sqrt(pla.youngs_modulus * thickness**2 / 12.0 / pla.density)
    assert lowest_period(body) == pytest.approx(2.0 * np.pi / omega, rel=0.03)


@pytest.mark.parametrize("element", ELEMENTS.values(), ids=ELEMENTS)
def test_it_is_the_first_mode_past_the_rigid_ones(element, block, pla):
    body = discretise(block, pla, 0.01, element)
    root = np.repeat(body.masses[body.place], 3) ** -0.5
    values = eigvalsh(root[:, None] * stiffness_matrix(body.mesh, pla).toarray() * root)
    assert lowest_period(body) == pytest.approx(2.0 * np.pi / np.sqrt(values[6]), rel=1e-3)


@pytest.mark.parametrize("size", [(60.0, 60.0, 2.0), (60.0, 58.0, 2.0), (60.0, 60.0, 0.2), (12.0, 12.0, 6.0)])
def test_no_lower_mode_is_missed_and_no_period_is_told_too_short(box, pla, size):
    """The unsafe side: with a shorter period the impact would be over too soon. A square plate bends alike both ways.

    In thin plates of flat tetrahedra the preconditioner is no good, and what it took for found was 0.1 % short, or nothing at all.
    """
    body = discretise(box((5, 5, 1), size), pla, 0.0, QUADRATIC)
    root = np.repeat(body.masses, 3) ** -0.5
    values = eigvalsh(root[:, None] * body.stiffness.matrix().toarray() * root)
    assert lowest_period(body) == pytest.approx(2.0 * np.pi / np.sqrt(values[6]), rel=1e-4)


def test_pieces_apart_and_single_tetrahedra_have_one_too(block, pla):
    beside = block.moved(block.vertices + np.array([30.0, 0.0, 0.0]))
    pair = TetMesh(np.concatenate([block.vertices, beside.vertices]), np.concatenate([block.tets, block.tets + len(block.vertices)]))
    periods = [lowest_period(discretise(tets, pla, 0.0, QUADRATIC)) for tets in (block, pair)]
    assert periods[1] == pytest.approx(periods[0], rel=1e-3)
    single = TetMesh(np.eye(4, 3, -1) * 5.0, [[0, 1, 2, 3]])
    assert 0.0 < lowest_period(discretise(single, pla, 0.0, QUADRATIC)) < periods[0]


def test_the_same_body_has_the_same_period_to_the_last_digit(block, pla):
    body = discretise(block, pla, 0.01, QUADRATIC)
    assert lowest_period(body) == lowest_period(body)
