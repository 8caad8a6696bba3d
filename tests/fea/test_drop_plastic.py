"""Drops that leave something: energy, steps, heights, and impacts one after the other."""

import re
from dataclasses import replace

import msgspec
import numpy as np
import pytest

from mechstyle.fea import drop as module
from mechstyle.fea import phases
from mechstyle.fea.backends.gpu import DeviceBody
from mechstyle.fea.drop import DropTest, drop
from mechstyle.fea.elements import ELEMENTS
from mechstyle.fea.orientations import directions
from mechstyle.fea.permanent_set import measured
from mechstyle.records.mesh import TetMesh
from support import ROOT
from validation.meshes import box, lattice

UPRIGHT = [0.0, 0.0, 1.0]
each_element = pytest.mark.parametrize("element", ELEMENTS)


def tilted(angle, towards=20.0):
    a, b = np.radians([angle, towards])
    return [np.sin(a) * np.cos(b), np.sin(a) * np.sin(b), np.cos(a)]


def without(mesh, gone):
    """The tetrahedra whose centre is not gone."""
    used, corners = np.unique(mesh.tets[~gone(*mesh.vertices[mesh.tets].mean(axis=1).T)], return_inverse=True)
    return TetMesh(mesh.vertices[used], corners.reshape(-1, 4).astype(np.int32))


def of_strength(material, strength):
    return msgspec.structs.replace(material, yield_strength=strength)


@pytest.fixture(scope="module")
def post():
    """A post 8 x 8 x 40 mm with a notch all round, 2 mm deep, and a head of 16 mm."""
    x, z = np.array([0.0, 4.0, 6.0, 8.0, 10.0, 12.0, 16.0]), np.array([0.0, 4.0, 8.0, 12.0, 16.0, 18.0, 20.0, 24.0, 28.0, 34.0, 40.0])

    def beside(x, y, z):
        return (z < 28.0) & (np.maximum(abs(x - 8.0), abs(y - 8.0)) > np.where(abs(z - 18.0) < 2.0, 2.0, 4.0))

    return without(lattice(x, x, z), beside)


@pytest.fixture(scope="module")
def bar():
    """A slender bar, 120 x 20 x 4 mm."""
    return box((15, 3, 1), (120.0, 20.0, 4.0))


@each_element
@pytest.mark.parametrize(("safety", "gained", "lost"), [(0.6, 1e-3, 1e-3), (0.95, 1e-3, 0.02)])
def test_with_plastic_work_energy_is_conserved(block, pla, element, safety, gained, lost):
    """What an undamped drop misses is the error of the integration, 2e-4; at the full step some is lost where tetrahedra are crushed."""
    found = drop(block, pla, directions(3), DropTest(window=0.4, damping=0.0, element=element, safety=safety), device="cpu")
    assert found.failure == ""
    history = found.history[-1]
    assert history.plastic_work[-1] > 0.3 * history.kinetic[0]
    assert history.damping_loss.min() > -gained * history.kinetic[0]
    assert history.damping_loss.max() < lost * history.kinetic[0]
    assert np.diff(history.plastic_work).min() >= 0.0


@each_element
def test_cores_and_kernels_leave_the_same(block, pla, element, monkeypatch):
    test = DropTest(window=0.2, element=element)
    ours = drop(block, pla, directions(3), test, device="cpu")
    monkeypatch.setattr(module, "body_on", lambda where, discretisation: DeviceBody(discretisation, where))
    theirs = drop(block, pla, directions(3), test, device="cpu")
    assert ours.plastic_strain.max() > 0.01
    for name in ("von_mises", "plastic_strain", "tension_strain", "flow"):
        mine, other = getattr(ours, name), getattr(theirs, name)
        np.testing.assert_allclose(mine, other, atol=2e-3 * np.abs(other).max(), err_msg=name)


STEPS = {
    "post": (tilted(10.0), 2000.0, 0.08, 0.01),
    "bar": (tilted(88.0, 50.0), 6000.0, 0.04, 0.01),
    "block": (tilted(35.0, 220.0), 6000.0, 0.3, 0.05),
}
"""How each part lands and from where, the plastic strain that it bears at least, and by how much that may differ with the step: of the
regular block all tetrahedra are the stiffest, and softer when they are crushed."""


@pytest.mark.parametrize("damping", [0.0, 0.1])
@pytest.mark.parametrize("part", STEPS)
def test_the_step_is_stable_where_it_bends_and_where_it_is_crushed(part, damping, request, pla):
    """The step of a drop leaves what a smaller one does: a notch, a slender bar, and a corner that is crushed."""
    tets, (way, height, strain, apart) = request.getfixturevalue(part), STEPS[part]
    tests = [DropTest(height=height, window=0.4, damping=damping, safety=safety) for safety in (0.95, 0.6)]
    full, small = (drop(tets, pla, [way], test, device="cpu") for test in tests)
    assert full.failure == small.failure == ""
    assert full.plastic_strain.max() > strain
    work = [each.history[0].plastic_work[-1] for each in (full, small)]
    assert work[0] == pytest.approx(work[1], rel=apart)
    assert np.linalg.norm(full.plastic_strain - small.plastic_strain) < apart * np.linalg.norm(small.plastic_strain)
    assert np.diff(full.history[0].damping_loss).min() > -1e-3 * full.history[0].kinetic[0]


HEIGHTS = 500.0, 1000.0, 2000.0


def test_twice_the_height_never_leaves_less(post, pla):
    kept = [drop(post, pla, [UPRIGHT, tilted(3.0), tilted(30.0)], DropTest(height=height), device="cpu") for height in HEIGHTS]
    work = np.array([[history.plastic_work[-1] for history in each.history] for each in kept])
    assert (np.diff(work, axis=0) >= 0.0).all()
    assert (work[-1] > work[0]).all()
    strain = np.array([np.sort(each.plastic_strain, axis=None)[-200:].mean() for each in kept])
    assert (np.diff(strain) > 0.0).all()


BAR = r"A bar of 100 × 10 × 10 mm .* 5° .*, reads (.+) % of strain from (.+) m and (.+) % from (.+) m; (.+) and (.+) mm stay bent"


def test_a_bar_reads_less_strain_from_twice_the_height_as_the_page_on_limits_says(pla):
    told = [float(word) for word in re.search(BAR, (ROOT / "docs" / "limits.md").read_text(encoding="utf-8")).groups()]
    bar, read = box((30, 3, 3), (100.0, 10.0, 10.0)), []
    for metres in (told[1], told[3]):
        found = drop(bar, pla, [tilted(5.0, 45.0)], DropTest(height=1000.0 * metres), device="cpu")
        read.append(measured(bar, found.permanent[0], found.tension_strain[0]))
    assert read[1].plastic_strain < read[0].plastic_strain
    assert [100.0 * each.plastic_strain for each in read] == pytest.approx([told[0], told[2]], abs=0.06)
    assert [each.permanent_set for each in read] == pytest.approx(told[4:], abs=0.006)


def test_a_body_that_never_yields_is_the_elastic_one(block, pla):
    """Its maximum is Kirchhoff's stress where that of the elastic body is Cauchy's: they differ by the change of volume."""
    strong, ways = of_strength(pla, 340.0), directions(3)
    elastic, plastic = (drop(block, strong, ways, DropTest(window=0.2, plastic=flows), device="cpu") for flows in (False, True))
    np.testing.assert_allclose(plastic.von_mises, elastic.von_mises, rtol=0.1, atol=0.01 * elastic.von_mises.max())
    assert not plastic.plastic_strain.any()
    assert not plastic.flow.any()
    for ours, theirs in zip(plastic.history, elastic.history, strict=True):
        np.testing.assert_allclose(ours.kinetic, theirs.kinetic, atol=1e-4 * theirs.kinetic[0])


def test_a_second_impact_adds_to_the_first(bar, pla):
    soft = of_strength(pla, 15.0)
    found = drop(bar, soft, [tilted(35.0, 3.0)], device="cpu")
    assert len(found.phases[0]) >= 2
    history = found.history[0]
    work = [history.plastic_work[history.phase == phase] for phase in range(2)]
    assert 0.0 < work[0][-1] == work[1][0] < work[1][-1]
    first = drop(bar, soft, [tilted(35.0, 3.0)], DropTest(window=found.phases[0][0].end), device="cpu")
    assert (found.plastic_strain >= first.plastic_strain - 1e-4).all()
    assert found.plastic_strain.max() > first.plastic_strain.max()
    begins = int(np.flatnonzero(history.phase == 1)[0])
    assert 0.0 <= history.strain[begins] < 0.05 * history.kinetic[begins], "of the stress that is locked in"
    assert np.diff(history.damping_loss[begins:]).min() > -1e-3 * history.kinetic[0], "the shape it goes on from gives no energy"


def test_what_has_flowed_goes_along_when_drops_are_packed(bar, pla, monkeypatch):
    monkeypatch.setattr(module, "body_on", lambda where, discretisation: DeviceBody(discretisation, where))
    soft, ways, test = of_strength(pla, 12.0), [UPRIGHT, tilted(1.0), tilted(35.0, 3.0), tilted(1.5)], DropTest(element="tet4")
    beside, alone = drop(bar, soft, ways, test, device="cpu"), drop(bar, soft, ways[2:3], test, device="cpu")
    assert alone.plastic_strain.max() > 0.003
    np.testing.assert_allclose(beside.plastic_strain[2], alone.plastic_strain[0], atol=0.01 * alone.plastic_strain.max())


def test_a_drop_that_bends_no_further_is_over_sooner_and_leaves_the_same(block, pla, monkeypatch):
    ways = [UPRIGHT, tilted(30.0), tilted(45.0, 200.0)]
    sooner = drop(block, pla, ways, device="cpu")
    monkeypatch.setattr(phases, "CALM_TIME", 1e9)
    later = drop(block, pla, ways, device="cpu")
    assert sum(each[0].end for each in sooner.phases) < 0.9 * sum(each[0].end for each in later.phases)
    for ours, theirs in zip(sooner.history, later.history, strict=True):
        assert ours.plastic_work[-1] == pytest.approx(theirs.plastic_work[-1], rel=0.02)


def test_an_elastic_drop_leaves_nothing(block, pla):
    found = drop(block, pla, directions(3), DropTest(window=0.2, plastic=False), device="cpu")
    assert found.von_mises.max() > pla.yield_strength
    for left in (found.plastic_strain, found.tension_strain, found.flow, found.permanent, found.history[0].plastic_work):
        assert not left.any()


def test_a_drop_that_failed_leaves_more_than_any_limit(block, pla):
    found = drop(block, pla, directions(2), DropTest(safety=2.0, element="tet4", window=0.5), device="cpu")
    assert found.failure
    for left in (found.von_mises, found.plastic_strain, found.tension_strain):
        assert np.isposinf(left).all()
    assert replace(found, failure="").flow.shape == (*found.von_mises.shape, 6)


def test_of_printed_layers_bending_takes_no_more_than_is_missing(block, pla):
    """They flow at a half of the strength, but their work was that of the whole: what damping took was less than nothing."""
    found = drop(block, pla, [UPRIGHT], DropTest(height=3e4, window=0.3, across=(0.0, 0.0, 2.0)), device="cpu")
    history = found.history[0]
    assert history.plastic_work[-1] > 0.1 * history.kinetic[0]
    assert history.damping_loss.min() >= -1e-6 * history.kinetic[0]
    given = history.kinetic[0] + history.gravity_work
    kept = history.kinetic + history.strain + history.plastic_work + history.contact_loss + history.damping_loss
    np.testing.assert_allclose(kept, given, rtol=1e-6)
