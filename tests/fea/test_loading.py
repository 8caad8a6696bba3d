"""Loads that are put on until a part gives way, against the plastic hinge, Euler, CalculiX with large displacements, and Hooke."""

from collections import deque
from types import SimpleNamespace

import msgspec
import numpy as np
import pytest

from mechstyle.fea import loading
from mechstyle.fea.loading import TILTED, tilted
from mechstyle.fea.statics import BEYOND, StaticTest
from mechstyle.records.load_cases import Load, LoadCase, Patch, Support
from mechstyle.records.mesh import TetMesh
from validation.meshes import box, grooved_bar, necked_bar

NEVER = 1e6
"""A tolerance that only what gives way exceeds [mm]."""


def loaded(tets, material, force, tolerance=0.2, **options):
    """What a force on its far end along x does to a part that is clamped at the near one."""
    low, high = tets.vertices[:, 0].min(), tets.vertices[:, 0].max()
    clamped, end = Patch(plane=(low, 0, 0, -1, 0, 0)), Patch(plane=(high, 0, 0, 1, 0, 0))
    case = LoadCase(name="load", supports=(Support(at=clamped),), loads=(Load(at=end, force=force),))
    found = StaticTest(tets, (case,)).loaded(tets, material, tolerance=tolerance, **options)["load"]
    return SimpleNamespace(
        **msgspec.structs.asdict(found.result), stress=found.stress, strain=found.strain, displacement=found.displacement
    )


@pytest.fixture(scope="module")
def perfect(pla):
    """PLA that does not harden."""
    return msgspec.structs.replace(pla, hardening=0.0)


@pytest.fixture(scope="module")
def beam():
    """60 x 6 x 6 mm along x."""
    return box((20, 2, 2), (60.0, 6.0, 6.0))


@pytest.fixture(scope="module")
def strut():
    """100 x 2 x 2 mm along x."""
    return box((30, 1, 1), (100.0, 2.0, 2.0))


def euler(material):
    """Of the strut, clamped at one end [N]."""
    return np.pi**2 * material.youngs_modulus * 2.0**4 / 12.0 / (4.0 * 100.0**2)


# --- where a part gives way -------------------------------------------------------------------------------------------


def test_a_cantilever_bears_its_plastic_moment(beam, perfect):
    """M_p = σ_y b h²/4 at the clamp; no hinge forms below, and none bears more."""
    hinge = perfect.yield_strength * 6.0**3 / 4.0 / 60.0
    found = loaded(beam, perfect, (0.0, 0.0, -hinge))
    assert found.factor == pytest.approx(1.0, abs=0.1)
    assert found.where[0] < 12.0 or found.where[0] > 48.0


@pytest.mark.slow
def test_a_grooved_bar_collapses_where_calculix_says(perfect):
    """8 x 8 mm, 2 mm deep all round: CalculiX with perfect plasticity levels off at 52 N, on a coarse mesh."""
    bar = grooved_bar()
    found = loaded(bar, perfect, (0.0, 0.0, -52.0), NEVER)
    assert found.factor == pytest.approx(1.0, abs=0.1)
    assert loaded(bar, perfect, (0.0, 0.0, -80.0)).collapses


@pytest.mark.slow
@pytest.mark.parametrize(("hardening", "bears"), [(1.0, 1095.0), (35.0, 1175.0)])
def test_a_neck_bears_no_more_than_the_most_that_calculix_finds(pla, hardening, bears):
    """4 x 4 x 1 mm between blocks, pulled, with large displacements: it becomes thinner. Small displacements promise 1375 N."""
    found = loaded(necked_bar(), msgspec.structs.replace(pla, hardening=hardening), (1375.0, 0.0, 0.0), NEVER)
    assert 1375.0 * found.factor == pytest.approx(bears, rel=0.05)
    assert found.collapses
    assert found.maximum < 1.5 * pla.yield_strength


@pytest.mark.parametrize("share", [0.5, 2.0])
def test_a_strut_bears_what_euler_says(strut, pla, share):
    """Elastic to the end: the stress is a fortieth of the yield strength when it buckles."""
    found = loaded(strut, pla, (-share * euler(pla), 0.0, 0.0))
    assert share * found.factor == pytest.approx(1.0, abs=0.1)
    assert (found.collapses, found.reached) == (share > 1.0, True)
    assert found.permanent_set == (BEYOND * 0.2 if share > 1.0 else 0.0)
    if found.collapses:
        assert found.where[0] > 90.0
        assert not found.displacement.any()


def test_a_strut_that_is_pulled_does_not_buckle(strut, pla):
    found = loaded(strut, pla, (2.0 * euler(pla), 0.0, 0.0))
    assert (found.factor, found.reached, found.collapses, found.permanent_set) == (loading.MOST, False, False, 0.0)


# --- what a load leaves -----------------------------------------------------------------------------------------------


def test_below_yield_it_bends_as_an_elastic_body_and_comes_back(beam, pla):
    low, high = beam.vertices[:, 0].min(), beam.vertices[:, 0].max()
    force = (0.0, 0.0, -5.0)
    found = loaded(beam, pla, force)
    case = LoadCase(name="load", supports=(Support(at=Patch(plane=(low, 0, 0, -1, 0, 0))),),
                    loads=(Load(at=Patch(plane=(high, 0, 0, 1, 0, 0)), force=force),))  # fmt: skip
    response = StaticTest(beam, (case,)).run(beam, pla)["load"]
    assert found.deflection == pytest.approx(response.deflection, rel=0.01)
    assert found.maximum == pytest.approx(response.von_mises.max(), rel=0.03)
    assert (found.permanent_set, found.plastic_strain) == (0.0, 0.0)
    assert not found.displacement.any()
    assert not found.strain.any()


def test_a_bar_that_is_pulled_beyond_yield_keeps_its_plastic_strain(box, pla):
    """F/A = σ_y + h ε_p, but for how the clamp holds it across; both ends keep half of ε_p L."""
    hardening, strain = 2000.0, 0.01
    bar = box((12, 1, 1), (60.0, 4.0, 4.0))
    stiff = msgspec.structs.replace(pla, hardening=hardening)
    stress = pla.yield_strength + hardening * strain
    found = loaded(bar, stiff, (16.0 * stress * np.exp(-strain - stress / pla.youngs_modulus), 0.0, 0.0))
    x = found.displacement[:, 0]
    assert np.ptp(x) == pytest.approx(60.0 * strain, rel=0.1)
    assert found.permanent_set == pytest.approx(0.5 * np.ptp(x), rel=0.1)
    assert 1.0 <= found.plastic_strain / strain < 1.25, "a hundredth of it, at the clamp, flows a little more"
    assert found.factor < 1.0


def test_more_load_leaves_more(beam, pla):
    found = [loaded(beam, pla, (0.0, 0.0, -force)).permanent_set for force in (20.0, 36.0, 40.0, 42.0)]
    assert found[0] == 0.0
    assert found == sorted(found)
    assert found[3] > 2.0 * found[1] > 0.0


def test_the_factor_is_where_the_tolerance_is_reached(beam, pla):
    found = loaded(beam, pla, (0.0, 0.0, -30.0), 0.1)
    at, beyond = (loaded(beam, pla, (0.0, 0.0, -30.0 * found.factor * more), 0.1).permanent_set for more in (1.0, 1.05))
    assert at <= 0.11
    assert beyond > 0.1


def test_a_bar_whose_layers_bear_less_pull_has_a_smaller_plastic_moment(beam, pla):
    """M_p ∝ 2 r/(1 + r) of a section that bears the share r of σ_y in tension and all of it in compression."""
    strong, weak = (loaded(beam, pla, (0.0, 0.0, -20.0), across=across) for across in ((0.0, 0.0, 0.0), (1.0 / 0.55, 0.0, 0.0)))
    assert weak.factor / strong.factor == pytest.approx(2.0 * 0.55 / 1.55, abs=0.07)


def test_numbering_does_not_matter(beam, pla):
    rng = np.random.default_rng(0)
    order = rng.permutation(len(beam.vertices))
    other = TetMesh(beam.vertices[order], np.argsort(order).astype(np.int32)[beam.tets[rng.permutation(len(beam.tets))]])
    usual, again = (loaded(mesh, pla, (0.0, 0.0, -40.0)) for mesh in (beam, other))
    assert again.permanent_set == pytest.approx(usual.permanent_set, rel=0.02)
    assert again.displacement == pytest.approx(usual.displacement[order], abs=0.02 * usual.permanent_set)
    assert again.stress == pytest.approx(usual.stress[order], abs=0.02 * pla.yield_strength)
    assert again.factor == pytest.approx(usual.factor, rel=0.02)


def test_what_never_yields_only_responds(beam, pla):
    found = loaded(beam, pla, (0.0, 0.0, -1000.0), elastic=True)
    assert found.maximum > 10.0 * pla.yield_strength
    assert (found.permanent_set, found.collapses, found.reached) == (0.0, False, False)


def test_progress_only_rises_and_may_cancel(beam, pla):
    done = list[float]()
    loaded(beam, pla, (0.0, 0.0, -40.0), progress=done.append)
    assert done == sorted(done)
    assert 0.0 <= done[0] <= done[-1] <= 1.0

    def cancel(_share):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        loaded(beam, pla, (0.0, 0.0, -40.0), progress=cancel)


# --- its parts --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("force", [(0.0, 0.0, -3.0), (1.0, 2.0, 2.0)])
def test_a_load_leans_by_a_small_angle(force):
    load = np.outer([1.0, 2.0, 0.5], force)
    aside = tilted(load) - load
    np.testing.assert_allclose(aside @ force, 0.0, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(aside, axis=1), TILTED * np.linalg.norm(load, axis=1), rtol=1e-9)


def test_the_way_along_a_known_step_is_that_step():
    """The secant equation: forces that fell by y along s drive by s."""
    rng = np.random.default_rng(1)
    memory = deque((step, 3.0 * step + 0.1 * rng.standard_normal(20)) for step in rng.standard_normal((4, 20)))
    step, fall = memory[-1]
    np.testing.assert_allclose(loading._direction(fall, memory, lambda right: 0.5 * right), step, rtol=1e-9)


@pytest.mark.parametrize("least", [0.02, 0.7, 1.0, 40.0])
def test_a_step_ends_where_little_force_is_left(least):
    """Along a line on which the force falls to nothing at some length, whatever lies beyond."""
    way = np.array([2.0])
    length, ahead = loading._length(lambda at: np.array([least - at if at < 100.0 else np.nan]), way, 2.0 * least)
    assert abs(float(ahead @ way)) <= 0.5 * 2.0 * least
    assert length == pytest.approx(least, rel=0.5)
