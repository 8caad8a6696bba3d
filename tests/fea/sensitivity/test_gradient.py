"""The experimental derivative of the smooth peak against finite differences, and that nothing relies on it."""

import ast
from pathlib import Path

import numpy as np
import pytest

import mechstyle
from mechstyle.errors import BadInput
from mechstyle.fea.ball_average import BallAverage
from mechstyle.fea.drop import DropTest, drop
from mechstyle.fea.sensitivity.gradient import ShortDrop, SmoothPeak
from mechstyle.records.mesh import TetMesh

TILTED = (0.2, -0.3, 0.9)
TEST = {name: DropTest(window=0.02, element=name, friction=0.2) for name in ("tet4", "tet10")}


@pytest.fixture(scope="module", params=TEST)
def short(request, block, pla) -> ShortDrop:
    return ShortDrop(block, pla, TILTED, TEST[request.param], device="cpu")


@pytest.fixture(scope="module")
def sensitivity(short):
    return short.sensitivity()


def slope(short: ShortDrop, direction: np.ndarray, step: float = 1e-2) -> float:
    """Central difference of the smooth peak along a direction."""
    ahead, behind = (short.smooth_peak(short.tets.vertices + sign * step * direction) for sign in (1.0, -1.0))
    return (ahead - behind) / (2.0 * step)


@pytest.mark.parametrize("along", ["gradient", "random"])
def test_the_derivative_is_that_of_finite_differences(along, short, sensitivity):
    """1 %: 0.01 % were seen along the gradient; a random direction is nearly across it, so that rounding to float32 shows."""
    gradient = sensitivity.gradient
    direction = gradient if along == "gradient" else np.random.default_rng(1).standard_normal(gradient.shape)
    direction = direction / np.linalg.norm(direction)
    assert slope(short, direction) == pytest.approx(float((gradient * direction).sum()), rel=0.01)


def test_moving_the_whole_part_changes_nothing(sensitivity):
    """It lands as it did: heights are measured from its lowest vertex."""
    np.testing.assert_allclose(sensitivity.gradient.sum(axis=0), 0.0, atol=1e-3 * np.abs(sensitivity.gradient).sum())


def test_the_smooth_peak_bounds_the_peak_of_the_drop_test_as_it_says(short, sensitivity, pla):
    """Of order 64 a mean over the few recorded steps is nearly their maximum, so the motion is that of the drop test as well."""
    found = drop(short.tets, pla, [TILTED], short.test, device="cpu")
    stress, records = found.von_mises[0].astype(np.float64), found.steps / 4
    peak = BallAverage(short.tets)(short.tets, stress).max()
    volumes = short.tets.volumes
    places = 8 * volumes.sum() / volumes.min() * records
    assert sensitivity.smooth_peak <= peak <= sensitivity.smooth_peak * places ** (1.0 / 16.0)
    sharper = ShortDrop(short.tets, pla, TILTED, short.test, exponent=64.0, device="cpu").smooth_peak()
    assert sensitivity.smooth_peak < sharper <= peak
    of_maxima = SmoothPeak(short.tets).evaluated(short.tets, stress**64, 64.0)[0]
    assert sharper <= of_maxima <= sharper * records ** (1.0 / 64.0)


@pytest.mark.parametrize("slotted", [False, True])
@pytest.mark.parametrize("points", [1, 4])
def test_the_mean_of_order_p_has_the_derivative_it_says(points, slotted, block, comb):
    """Beside a slot one point may lie in the ball of another but not the other way round."""
    rng = np.random.default_rng(0)
    block = comb(1.2, 0.4, 1.0) if slotted else block
    assert (abs(SmoothPeak(block)._near - SmoothPeak(block)._near.T).nnz > 0) == slotted
    peak, powers = SmoothPeak(block), rng.uniform(0.5, 1.0, (len(block.tets), points)) ** 16
    _, by_power, by_volume = peak.evaluated(block, powers, 16.0)
    change = 1e-6 * powers * rng.standard_normal(powers.shape)
    ahead, behind = (peak.evaluated(block, powers + sign * change, 16.0)[0] for sign in (1.0, -1.0))
    assert (ahead - behind) / 2.0 == pytest.approx((by_power * change).sum(), rel=1e-4)
    inner = block.vertices + 1e-5 * rng.standard_normal(block.vertices.shape)
    morphs = block.moved(inner), block.moved(2.0 * block.vertices - inner)
    ahead, behind = (peak.evaluated(morph, powers, 16.0)[0] for morph in morphs)
    assert ahead - behind == pytest.approx(by_volume @ (morphs[0].volumes - morphs[1].volumes), rel=1e-4)


def test_a_vertex_without_tetrahedra_has_no_derivative(block, pla):
    crowded = TetMesh(np.vstack([[[99.0, 99.0, -99.0]], block.vertices]), block.tets + 1)
    test = DropTest(window=0.005, element="tet4")
    alone, plain = (ShortDrop(tets, pla, TILTED, test, device="cpu").sensitivity() for tets in (crowded, block))
    np.testing.assert_array_equal(alone.gradient[0], 0.0)
    np.testing.assert_array_equal(alone.gradient[1:], plain.gradient)


def test_what_cannot_be_differentiated_is_refused(block, pla):
    with pytest.raises(BadInput, match="exponent is 2, but must lie between 8 and 64"):
        ShortDrop(block, pla, TILTED, exponent=2.0, device="cpu")
    with pytest.raises(BadInput, match="shorten its window"):
        ShortDrop(block, pla, TILTED, DropTest(window=50.0), device="cpu")
    with pytest.raises(BadInput, match="points out of the floor"):
        ShortDrop(block, pla, (0.0, 0.0, 0.0), device="cpu")
    short = ShortDrop(block, pla, TILTED, TEST["tet4"], device="cpu")
    with pytest.raises(BadInput, match="move the vertices less"):
        short.smooth_peak(-block.vertices)


def test_nothing_of_the_package_relies_on_it():
    sources = {path: ast.parse(path.read_text()) for path in Path(mechstyle.__file__).parent.rglob("*.py")}
    importers = set()
    for path, tree in sources.items():
        for node in ast.walk(tree):
            module = (node.module or "") if isinstance(node, ast.ImportFrom) else ""
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import | ast.ImportFrom) else []
            if "sensitivity" in f"{module} {' '.join(names)}":
                importers.add(path.name)
    assert importers == {"gradient.py"}  # which imports its own kernels
