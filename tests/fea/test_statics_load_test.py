"""Load cases against beam and plate theory, balance of forces, and what cannot be solved."""

import msgspec
import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.fea import linear_solvers as solve
from mechstyle.fea.elasticity import displacement_gradients
from mechstyle.fea.elements import QUADRATIC, element_named, with_nodes
from mechstyle.fea.statics import StaticTest, stresses, weight
from mechstyle.records.load_cases import Load, LoadCase, Patch, Support

LENGTH, WIDTH, HEIGHT = 60.0, 5.0, 4.0
END = Patch(plane=(0, 0, 0, -1, 0, 0))
TIP = Patch(plane=(LENGTH, 0, 0, 1, 0, 0))
BELOW = Patch(plane=(0, 0, 0, 0, 0, -1))
CLAMPED = (Support(at=END),)
PULL = LoadCase(name="pull", supports=CLAMPED, loads=(Load(at=TIP, force=(0.0, 0.0, -2.0)),))
WEIGHT = LoadCase(name="weight", supports=CLAMPED, loads=(Load(gravity=3.0),))


@pytest.fixture(scope="module")
def beam(box):
    """60 x 5 x 4 mm along x."""
    return box((24, 2, 2), (LENGTH, WIDTH, HEIGHT))


@pytest.fixture(scope="module")
def responses(beam, pla):
    return StaticTest(beam, (PULL, WEIGHT)).run(beam, pla)


def deflection(beam, response):
    return -response.displacement[: len(beam.vertices)][beam.vertices[:, 0] > LENGTH - 1e-6, 2].mean()


def test_a_cantilever_bends_as_timoshenko_says(beam, pla, responses):
    """Deflection F L³/(3 E I) + F L/(κ G A), κ = 5/6; the clamped end adds 1 to 2 % of stiffness, as it holds the cross-section."""
    E, G, area, second_moment = pla.youngs_modulus, pla.shear_modulus, WIDTH * HEIGHT, WIDTH * HEIGHT**3 / 12.0
    expected = 2.0 * LENGTH**3 / (3.0 * E * second_moment) + 2.0 * LENGTH / (5.0 / 6.0 * G * area)
    assert deflection(beam, responses["pull"]) == pytest.approx(expected, rel=0.02)


def test_a_beam_bends_under_its_own_weight(beam, pla, responses):
    """Deflection q L⁴/(8 E I) + q L²/(2 κ G A) with q = 3 ρ g A."""
    E, G, area, second_moment = pla.youngs_modulus, pla.shear_modulus, WIDTH * HEIGHT, WIDTH * HEIGHT**3 / 12.0
    q = 3.0 * pla.density * 9.81e-3 * area
    expected = q * LENGTH**4 / (8.0 * E * second_moment) + q * LENGTH**2 / (5.0 / 3.0 * G * area)
    assert deflection(beam, responses["weight"]) == pytest.approx(expected, rel=0.02)


def test_bending_stress_is_moment_over_second_moment_at_the_gauss_points(beam, pla, responses):
    """σ = M z/I, half way along the beam, where neither end is felt; shear adds little far from the axis."""
    corners = beam.vertices[beam.tets]
    centre = corners.mean(axis=1)
    half = np.abs(centre[:, 0] - LENGTH / 2) < 3.0
    mean = responses["pull"].von_mises[half].mean(axis=1)
    expected = 2.0 * (LENGTH - centre[half, 0]) * np.abs(centre[half, 2] - HEIGHT / 2) / (WIDTH * HEIGHT**3 / 12.0)
    outer = np.abs(centre[half, 2] - HEIGHT / 2) > 1.0
    assert mean[outer] == pytest.approx(expected[outer], rel=0.1)


@pytest.mark.parametrize("name", ["pull", "weight"])
def test_reactions_balance_the_loads(beam, responses, name):
    nodes, response = with_nodes(beam, QUADRATIC).nodes, responses[name]
    total = response.loads + response.reactions
    size = np.abs(response.loads).sum()
    assert np.abs(total.sum(axis=0)).max() < 1e-9 * size
    assert np.abs(np.cross(nodes, total).sum(axis=0)).max() < 1e-9 * size * LENGTH
    assert not response.reactions[nodes[:, 0] > 1e-9].any()


def test_the_weight_is_that_of_the_part(block, pla):
    for name in ("tet4", "tet10"):
        forces = weight(with_nodes(block, element_named(name)), pla.density, np.array([0.0, 0.0, -9.81e-3]))
        assert forces.sum(axis=0) == pytest.approx([0.0, 0.0, -pla.density * 12 * 10 * 16 * 9.81e-3], abs=1e-15)


def test_quadratic_elements_share_the_weight_out_consistently(block, pla):
    """The work of a uniform load on a quadratic displacement is exact: ∫ x² dV over 12 x 10 x 16 mm."""
    mesh = with_nodes(block, QUADRATIC)
    forces = weight(mesh, pla.density, np.array([1.0, 0.0, 0.0]))
    assert forces[:, 0] @ mesh.nodes[:, 0] ** 2 == pytest.approx(pla.density * 160.0 * 12.0**3 / 3.0)


def test_linear_tetrahedra_are_several_times_too_stiff_in_bending(beam, pla, responses):
    linear = StaticTest(beam, (PULL,), "tet4").run(beam, pla)["pull"]
    assert (linear.von_mises.shape, responses["pull"].von_mises.shape) == ((len(beam.tets), 1), (len(beam.tets), 4))
    assert deflection(beam, linear) < 0.5 * deflection(beam, responses["pull"])


@pytest.mark.parametrize("name", ["tet4", "tet10"])
def test_a_uniform_stretch_is_in_uniform_stress(block, pla, name):
    """A stretch ε without change of width has σ_x − σ_y = 2μ ε, which is its von Mises stress."""
    mesh = with_nodes(block, element_named(name))
    stretch = mesh.nodes * [1e-3, 0.0, 0.0]
    assert stresses(pla, displacement_gradients(mesh, stretch)) == pytest.approx(2e-3 * pla.shear_modulus)


def test_a_pressed_block_on_rollers_is_in_uniform_compression(block, pla):
    """σ = −p along z and nothing across: von Mises p everywhere, shortening p L/E; the rollers leave it free to widen."""
    rollers = tuple(Support(at=Patch(plane=(0, 0, 0, *axis)), kind="roller") for axis in ((-1, 0, 0), (0, -1, 0), (0, 0, -1)))
    case = LoadCase(name="press", supports=rollers, loads=(Load(at=Patch(plane=(0, 0, 16, 0, 0, 1)), pressure=5.0),))
    response = StaticTest(block, (case,)).run(block, pla)["press"]
    assert response.von_mises == pytest.approx(np.full((len(block.tets), 4), 5.0), rel=1e-6)
    nodes = with_nodes(block, QUADRATIC).nodes
    assert response.displacement[nodes[:, 2] == 16.0, 2] == pytest.approx(-5.0 * 16.0 / pla.youngs_modulus, rel=1e-6)
    assert response.displacement[nodes[:, 0] == 12.0, 0] == pytest.approx(5.0 * 12.0 * pla.poisson_ratio / pla.youngs_modulus, rel=1e-6)
    assert response.reactions.sum(axis=0) == pytest.approx([0.0, 0.0, 5.0 * 120.0], abs=1e-6)


@pytest.mark.parametrize(("pressure", "expected"), [(-5.0, 10.0), (5.0, 5.0)], ids=["pulled", "pressed"])
def test_layers_of_half_the_strength_bear_half_the_pull_and_all_the_pressure(block, pla, pressure, expected):
    rollers = tuple(Support(at=Patch(plane=(0, 0, 0, *axis)), kind="roller") for axis in ((-1, 0, 0), (0, -1, 0), (0, 0, -1)))
    case = LoadCase(name="press", supports=rollers, loads=(Load(at=Patch(plane=(0, 0, 16, 0, 0, 1)), pressure=pressure),))
    response = StaticTest(block, (case,)).run(block, pla, (0.0, 0.0, 2.0))["press"]
    assert response.von_mises == pytest.approx(np.full((len(block.tets), 4), expected), rel=1e-6)


def test_a_clamped_plate_sags_under_pressure(box, pla):
    """Its centre sags by 0.00126 p a⁴/D (Timoshenko and Woinowsky-Krieger, table 35), plus a little shear at a/h = 25."""
    side, thick, p = 50.0, 2.0, 0.01
    plate = box((16, 16, 1), (side, side, thick))
    planes = ((0, 0, 0, -1, 0, 0), (side, 0, 0, 1, 0, 0), (0, 0, 0, 0, -1, 0), (0, side, 0, 0, 1, 0))
    rim = tuple(Support(at=Patch(plane=plane)) for plane in planes)
    case = LoadCase(name="press", supports=rim, loads=(Load(at=Patch(facet=(25, 25, thick)), pressure=p),))
    response = StaticTest(plate, (case,)).run(plate, pla)["press"]
    D = pla.youngs_modulus * thick**3 / (12.0 * (1.0 - pla.poisson_ratio**2))
    assert -response.displacement[:, 2].min() == pytest.approx(0.00126 * p * side**4 / D, rel=0.04)


def test_places_stay_where_they_were_when_the_part_is_morphed(beam, pla):
    """A relief must not shake off a support or change what a force adds up to."""
    rough = beam.moved(beam.vertices + np.array([0.05, 0.0, 0.1]) * np.sin(7.0 * beam.vertices.sum(axis=1))[:, None])
    test = StaticTest(beam, (PULL,))
    straight, morphed = test.run(beam, pla)["pull"], test.run(rough, pla)["pull"]
    assert np.array_equal(morphed.reactions.any(axis=1), straight.reactions.any(axis=1))
    assert morphed.loads.sum(axis=0) == pytest.approx(PULL.loads[0].force)
    assert not np.allclose(morphed.von_mises, straight.von_mises)


@pytest.mark.parametrize(
    ("supports", "words"),
    [
        ((Support(at=END, kind="roller"),), r"'pull': the supports do not hold the part: it can still (slide along|turn about)"),
        ((Support(at=END, kind="roller"), Support(at=BELOW, kind="roller")), r"slide along \(-?0.00, -?1.00, -?0.00\)"),
        ((Support(at=Patch(sphere=(99, 0, 0, 1))),), r"'pull': sphere \[99, 0, 0, 1\] selects no surface"),
    ],
)
def test_what_is_not_held_or_not_there_is_named_with_its_case(beam, pla, supports, words):
    with pytest.raises(BadInput, match=words):
        StaticTest(beam, (msgspec.structs.replace(PULL, supports=supports),)).run(beam, pla)


def test_loads_that_cancel_are_refused(beam, pla):
    both = tuple(Load(at=TIP, force=(0.0, 0.0, sign)) for sign in (1.0, -1.0))
    with pytest.raises(BadInput, match="cancel out"):
        StaticTest(beam, (msgspec.structs.replace(PULL, loads=both),)).run(beam, pla)


def test_cases_with_the_same_supports_are_solved_together_and_alike(beam, pla, responses, monkeypatch):
    factored, real = [], solve.splu

    def counting(*args, **options):
        factored.append(1)
        return real(*args, **options)

    monkeypatch.setattr(solve, "splu", counting)
    other = LoadCase(name="other", supports=(Support(at=TIP),), loads=(Load(gravity=1.0),))
    together = StaticTest(beam, (PULL, other, WEIGHT)).run(beam, pla)
    assert list(together) == ["pull", "other", "weight"]
    assert len(factored) == 2
    assert np.array_equal(together["weight"].displacement, responses["weight"].displacement)


def test_large_systems_are_solved_without_their_factors_and_alike(beam, pla, responses, monkeypatch):
    """Conjugate gradients; a clamp and rollers, which turn the frame of their nodes."""
    rollers = tuple(Support(at=Patch(plane=(0, 0, 0, *axis)), kind="roller") for axis in ((-1, 0, 0), (0, -1, 0), (0, 0, -1)))
    press = LoadCase(name="press", supports=rollers, loads=(Load(at=Patch(plane=(0, 0, HEIGHT, 0, 0, 1)), pressure=5.0),))
    direct = {**responses, **StaticTest(beam, (press,)).run(beam, pla)}
    monkeypatch.setattr(solve, "FACTORISED", 0)
    real = solve.splu

    def of_linear_fields(matrix, **options):
        assert matrix.shape[0] <= 3 * len(beam.vertices), "the whole system was factorised"
        return real(matrix, **options)

    monkeypatch.setattr(solve, "splu", of_linear_fields)
    for name, response in StaticTest(beam, (PULL, WEIGHT, press)).run(beam, pla).items():
        known = direct[name]
        assert np.abs(response.displacement - known.displacement).max() < 1e-7 * np.abs(known.displacement).max()
        assert np.abs(response.von_mises - known.von_mises).max() < 1e-6 * known.von_mises.max()
        np.testing.assert_allclose(response.reactions.sum(axis=0), known.reactions.sum(axis=0), atol=1e-6)


def test_what_does_not_converge_is_factorised(beam, pla, responses, monkeypatch):
    monkeypatch.setattr(solve, "FACTORISED", 0)
    monkeypatch.setattr(solve, "ITERATIONS", 1)
    found = StaticTest(beam, (PULL,)).run(beam, pla)["pull"]
    assert np.array_equal(found.displacement, responses["pull"].displacement)
