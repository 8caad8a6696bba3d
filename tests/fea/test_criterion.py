"""Averages, percentiles and verdicts on fields whose answers are known."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mechstyle.errors import BadInput
from mechstyle.fea.criterion import BallAverage, exceedance, input_warning, judge, measures, percentile, robust_field
from mechstyle.fea.elements import GAUSS_A, GAUSS_B
from mechstyle.records import LoadResult, Measures, Simulation, Verdict
from mechstyle.records.material import LIBRARY

PLA = LIBRARY["PLA"]
Y = PLA.yield_strength


@pytest.fixture(scope="module")
def average(block):
    return BallAverage(block)


def simulation(peak=20.0, p99=15.0, p999=None, maximum=30.0, overall=10.0, failure=""):
    """A simulation with the given as-placed measures and 99th percentile over all orientations (None: not dropped)."""
    as_placed = Measures(peak=peak, p999=peak if p999 is None else p999, p99=p99, maximum=maximum, where=(1.0, 2.0, 3.0), volume=100.0)
    envelope = None if overall is None else msgspec.structs.replace(as_placed, p99=overall)
    one = np.zeros(1)
    return Simulation(
        displacement=one, stress=one, envelope=one, probability=one, contact=one > 0, as_placed=as_placed, overall=envelope,
        backed_off=0.0, deviation=0.0, time_step=1e-4, steps=100, added_mass=0.0, failure=failure,
    )


def test_the_average_of_a_constant_field_is_the_constant(block, average):
    np.testing.assert_allclose(average(block, np.full((len(block.tets), 4), 7.0)), 7.0, rtol=1e-6)


def test_the_average_is_the_volume_weighted_mean_over_the_ball(block, average):
    values = np.random.default_rng(0).uniform(0.0, 50.0, (len(block.tets), 1))
    points, averaged = average.points(block), average(block, values)
    assert points.shape == (len(block.tets), 8, 3)
    for tet, point in ((0, 0), (57, 3), (200, 7)):
        near = np.linalg.norm(points - points[tet, point], axis=2) <= 2.0
        assert near.sum() > 1
        weights = np.repeat(block.volumes[:, None], 8, axis=1)[near]
        assert averaged[tet, point] == pytest.approx(np.average(np.repeat(values, 8, axis=1)[near], weights=weights), rel=1e-5)


def test_sub_points_are_shares_of_the_volume_between_which_stress_is_linear(block):
    tiny = BallAverage(block, radius=1e-6)  # the value at the point itself
    gauss = np.full((4, 4), GAUSS_B) + (GAUSS_A - GAUSS_B) * np.eye(4)
    slope = np.array([1.0, -2.0, 0.5])
    at_gauss = np.einsum("qk,nkx,x->nq", gauss, block.vertices[block.tets], slope)
    np.testing.assert_allclose(tiny(block, at_gauss), tiny.points(block) @ slope, atol=1e-9)
    np.testing.assert_allclose(tiny.points(block).mean(axis=1), block.vertices[block.tets].mean(axis=1), atol=1e-12)


def test_a_fine_mesh_is_averaged_tetrahedron_by_tetrahedron(box):
    fine = box((8, 8, 8), (6.0, 6.0, 6.0))
    average, values = BallAverage(fine), np.random.default_rng(0).uniform(0.0, 50.0, (len(fine.tets), 4))
    assert average(fine, values).shape == (len(fine.tets), 1)
    centroids = fine.vertices[fine.tets].mean(axis=1)
    near = np.linalg.norm(centroids - centroids[100], axis=1) <= 2.0
    assert average(fine, values)[100, 0] == pytest.approx(values[near].mean(), rel=1e-5)


@pytest.mark.parametrize(("count", "points"), [(7.9, 8), (8.1, 1)])
@pytest.mark.parametrize("size", [1.0, 6.0])
def test_a_tetrahedron_is_taken_as_one_point_where_the_ball_holds_eight_of_them(box, size, count, points):
    """A ball of so many times the mean volume of a tetrahedron."""
    mesh = box((4, 4, 4), (size, size, 2.0 * size))
    radius = (count * mesh.volumes.mean() / (4.0 / 3.0 * np.pi)) ** (1.0 / 3.0)
    assert BallAverage(mesh, radius).points(mesh).shape == (len(mesh.tets), points, 3)


def test_the_average_keeps_its_neighbours_on_a_morph_but_weighs_with_its_volumes(block, average):
    values = np.random.default_rng(0).uniform(0.0, 50.0, (len(block.tets), 4))
    stretched = block.moved(block.vertices * [3.0, 1.0, 1.0])
    np.testing.assert_allclose(average(stretched, values), average(block, values), rtol=1e-5)
    bulged = block.moved(block.vertices * (1.0 + 0.05 * block.vertices[:, 2:]))
    assert np.abs(average(bulged, values) / average(block, values) - 1.0).max() > 1e-3


def test_the_robust_field_is_the_largest_average_around_a_vertex_and_its_maximum_the_peak(block, average):
    values = np.random.default_rng(0).uniform(0.0, 50.0, (len(block.tets), 4))
    field, averaged = robust_field(block, values, average), average(block, values)
    for vertex in (0, 40, 99):
        assert field[vertex] == averaged[(block.tets == vertex).any(axis=1)].max()
    assert field.max() == measures(block, values, average).peak


def test_a_part_without_stress_has_a_robust_field_of_nothing(block, average):
    assert not robust_field(block, np.zeros((len(block.tets), 4)), average).any()


def test_exceedance_is_the_probability_of_the_orientations_in_which_more_than_the_allowable_is_reached():
    fields = [[10.0, 50.0, 45.6], [46.0, 50.0, 45.6], [0.0, 60.0, 45.7]]
    assert exceedance(fields, [0.5, 0.3, 0.2], 45.6) == pytest.approx([0.3, 1.0, 0.2])


def test_percentiles_of_known_arrays():
    assert percentile([1.0, 2.0, 3.0, 4.0], [1.0, 1.0, 1.0, 1.0], 0.5) == 2.0
    assert percentile([4.0, 1.0, 3.0, 2.0], [1.0, 1.0, 1.0, 1.0], 0.75) == 3.0
    assert percentile([1.0, 100.0], [99.0, 1.0], 0.99) == 1.0
    assert percentile([1.0, 100.0], [99.0, 1.0], 1.0) == 100.0
    assert percentile([1.0, 3.0], [1.0, 1.0], 0.75) == 2.0


@given(values=st.lists(st.floats(0.0, 1e3), min_size=1, max_size=30), share=st.floats(0.01, 1.0), factor=st.floats(0.1, 10.0))
def test_percentiles_lie_among_the_values_and_do_not_see_the_unit_of_weight(values, share, factor):
    weights = np.linspace(1.0, 2.0, len(values))
    found = percentile(values, weights, share)
    assert min(values) <= found <= max(values)
    assert percentile(values, factor * weights, share) == pytest.approx(found, rel=1e-6, abs=1e-6)


def test_measures_find_peak_place_and_volume(block, average):
    values = np.zeros((len(block.tets), 4))
    values[123] = 40.0
    found = measures(block, values, average)
    assert found.maximum == 40.0
    assert 0.0 < found.peak < 40.0
    assert np.linalg.norm(np.array(found.where) - block.vertices[block.tets[123]].mean(axis=0)) <= 2.0
    assert found.volume == pytest.approx(12.0 * 10.0 * 16.0)
    assert found.p99 <= found.p999 <= found.maximum


def test_measures_weigh_percentiles_by_volume(box):
    """Where the stress is the share of the volume that has less, each percentile is its own share."""
    fine = box((8, 8, 8), (6.0, 6.0, 6.0), shake=0.3)
    order = np.random.default_rng(0).permutation(len(fine.tets))
    share = np.empty(len(order))
    share[order] = np.cumsum(fine.volumes[order]) / fine.volumes.sum()
    found = measures(fine, np.repeat(share[:, None], 4, axis=1), BallAverage(fine))
    assert found.p99 == pytest.approx(0.99, abs=5e-4)
    assert found.p999 == pytest.approx(0.999, abs=5e-4)
    assert found.maximum == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("peak", "own", "outcome", "marginal"),
    [
        (20.0, 10.0, "VIABLE", False),
        (38.0, 10.0, "VIABLE", False),  # 0.83 of the yield strength
        (39.0, 10.0, "VIABLE", True),
        (Y, 10.0, "VIABLE", True),
        (46.0, 10.0, "FAILS", True),
        (52.0, 10.0, "FAILS", True),
        (53.0, 10.0, "FAILS", False),  # 1.16 of the yield strength
        (60.0, 60.0, "VIABLE", True),  # the original's own peak is the limit
        (61.0, 60.0, "FAILS", True),
        (80.0, 60.0, "FAILS", False),
    ],
)
def test_as_placed_compares_the_peak_with_yield_or_the_originals_own(peak, own, outcome, marginal):
    verdict = judge(simulation(peak=peak, overall=None), simulation(peak=own), PLA, "robust")
    assert (verdict.as_placed.outcome, verdict.as_placed.marginal) == (outcome, marginal)
    assert verdict.outcome == outcome
    assert verdict.as_placed.limit == max(Y, own)
    assert verdict.as_placed.rule.endswith("≤ yield strength" if own < Y else "≤ the original's own peak")
    assert verdict.all_orientations is None
    assert ("MARGINAL" in verdict.words) == marginal


def test_the_edge_of_the_band_belongs_to_it():
    """15 % of a limit whose share is exact."""
    material = msgspec.structs.replace(PLA, yield_strength=100.0)
    for peak, marginal in ((84.9, False), (85.0, True), (115.0, True), (115.1, False)):
        assert judge(simulation(peak=peak, overall=None), simulation(), material, "robust").as_placed.marginal == marginal


def test_as_placed_is_marginal_where_percentile_and_peak_disagree():
    base = simulation(peak=10.0)
    assert judge(simulation(peak=30.0, p999=50.0), base, PLA, "robust").as_placed.marginal
    assert judge(simulation(peak=60.0, p999=40.0), base, PLA, "robust").as_placed.marginal
    for agreeing in (44.0, Y):
        assert not judge(simulation(peak=30.0, p999=agreeing), base, PLA, "robust").as_placed.marginal


@pytest.mark.parametrize(
    ("overall", "outcome", "marginal"),
    [
        (10.0, "VIABLE", False),
        (10.4, "VIABLE", False),
        (10.5, "VIABLE", True),
        (11.0, "VIABLE", True),
        (11.1, "FAILS", True),
        (11.6, "FAILS", False),
    ],
)
def test_all_orientations_compares_with_the_original(overall, outcome, marginal):
    verdict = judge(simulation(overall=overall), simulation(overall=10.0), PLA, "robust")
    spread = verdict.all_orientations
    assert spread is not None
    assert (spread.outcome, spread.marginal, spread.unit) == (outcome, marginal, "x the original")
    assert spread.value == pytest.approx(overall / 10.0)
    assert verdict.outcome == outcome


@pytest.mark.parametrize(("peak", "overall", "worst"), [(20, 10, "VIABLE"), (60, 10, "FAILS"), (20, 12, "FAILS"), (60, 12, "FAILS")])
def test_robust_is_the_worse_of_the_two(peak, overall, worst):
    assert judge(simulation(peak=peak, overall=overall), simulation(), PLA, "robust").outcome == worst


def test_paper_is_the_literal_rule_alone():
    base = simulation()
    assert judge(simulation(peak=60.0, maximum=45.0, overall=30.0), base, PLA, "paper").outcome == "VIABLE"
    fails = judge(simulation(peak=20.0, maximum=83.0), base, PLA, "paper")
    assert fails.outcome == "FAILS"
    assert fails.deciding is fails.literal
    assert "largest element stress is 83.0 MPa" in fails.words
    assert judge(simulation(maximum=83.0), base, PLA, "robust").literal.outcome == "FAILS"


@given(peak=st.floats(0.1, 500.0), p999=st.floats(0.1, 500.0), overall=st.floats(0.1, 500.0))
def test_zero_displacement_is_viable_by_construction(peak, p999, overall):
    base = simulation(peak=peak, p999=p999, overall=overall)
    assert judge(base, base, PLA, "robust").outcome == "VIABLE"


@pytest.mark.parametrize("criterion", ["robust", "paper"])
@pytest.mark.parametrize("bad", [np.nan, np.inf])
@pytest.mark.parametrize("field", ["peak", "p999", "p99", "maximum", "overall"])
def test_what_is_not_a_finite_number_is_unknown_never_viable(field, bad, criterion):
    for styled, base in ((simulation(**{field: bad}), simulation()), (simulation(), simulation(**{field: bad}))):
        verdict = judge(styled, base, PLA, criterion)
        assert verdict.outcome == verdict.as_placed.outcome == verdict.literal.outcome == "UNKNOWN"
        assert "not a finite number" in verdict.words
        for judgement in (verdict.as_placed, verdict.all_orientations, verdict.literal):
            assert (judgement.value, judgement.marginal) == (0.0, False)  # 0 stands for what is not known
        assert verdict.as_placed.limit == verdict.literal.limit == Y
        # Records travel as JSON, which knows no NaN.
        assert msgspec.json.decode(msgspec.json.encode(verdict), type=Verdict) == verdict


def test_a_failed_simulation_is_unknown_with_its_reason():
    reason = "the drop test is unstable in orientation 0 at 0.010 ms"
    verdict = judge(simulation(failure=reason), simulation(), PLA, "robust")
    assert verdict.outcome == "UNKNOWN"
    assert verdict.words == f"UNKNOWN: {reason}."
    verdict = judge(simulation(), simulation(failure=reason), PLA, "robust")
    assert verdict.outcome == "UNKNOWN"
    assert f"the original could not be simulated: {reason}" in verdict.words


def test_orientations_without_a_baseline_to_compare_with_are_unknown():
    assert judge(simulation(), simulation(overall=None), PLA, "robust").outcome == "UNKNOWN"
    assert judge(simulation(), simulation(overall=0.0), PLA, "robust").outcome == "UNKNOWN"


def test_words_hold_figures_place_limit_and_doubt():
    words = judge(simulation(peak=50.0, overall=10.2), simulation(), PLA, "robust").words
    assert words == (
        "FAILS, MARGINAL: dropped as placed its peak stress is 50.0 MPa at (1.0, 2.0, 3.0) mm, above (MARGINAL) the yield strength"
        " of 45.6 MPa; in all orientations 1.02 times the original's stress, within the limit of 1.10."
    )
    words = judge(simulation(peak=50.0, overall=None), simulation(peak=80.0), PLA, "robust").words
    assert "within the original's own peak of 80.0 MPa, which itself exceeds the yield strength of 45.6 MPa" in words


def test_words_name_the_load_that_governs():
    one = simulation(peak=40.0)
    cases = (("hand", 40.0), ("shelf", 12.0))
    loaded = tuple(LoadResult(name=name, peak=peak, where=(0.0, 0.0, 0.0), deflection=0.1) for name, peak in cases)
    governed = judge(replace(one, loaded=loaded), simulation(), PLA, "robust")
    assert "under the load 'hand' its peak stress is 40.0 MPa at" in governed.words
    dropped = judge(replace(one, loaded=loaded[1:]), simulation(), PLA, "robust")
    assert "dropped as placed, which is worse than any load, its peak stress is 40.0 MPa" in dropped.words
    assert "dropped as placed or under its loads its largest element stress" in judge(replace(one, loaded=loaded), one, PLA, "paper").words
    weak = msgspec.structs.replace(PLA, yield_strength=30.0)
    assert "under the load 'hand', above" in input_warning(replace(one, loaded=loaded), weak)


def test_the_input_is_warned_of_only_when_it_exceeds_yield_itself():
    assert input_warning(simulation(peak=45.0), PLA) == ""
    assert input_warning(simulation(peak=Y), PLA) == ""
    warning = input_warning(simulation(peak=52.0), PLA)
    assert "52.0 MPa at (1.0, 2.0, 3.0) mm" in warning
    assert "45.6 MPa" in warning
    assert "unstable" in input_warning(simulation(failure="the drop test is unstable"), PLA)


def test_an_unknown_criterion_is_refused():
    with pytest.raises(BadInput, match=r"'robst'.*robust"):
        judge(simulation(), simulation(), PLA, "robst")


def test_the_measures_of_a_failed_drop_are_never_viable(block, average):
    failed = measures(block, np.full((len(block.tets), 1), np.inf), average)
    assert judge(replace(simulation(), as_placed=failed), simulation(), PLA, "robust").outcome == "UNKNOWN"
