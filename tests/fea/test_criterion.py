"""Measures and percentiles on fields whose answers are known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mechstyle.fea.criterion import exceedance, measures, percentile
from mechstyle.fea.surface_stress import Deciding


def deciding(surface=0.0, contact=0.0):
    """A deciding stress of given maxima."""
    return Deciding(np.zeros(1), np.zeros(1), surface, contact, max(surface, contact), 0.0, (1.0, 2.0, 3.0), (4.0, 5.0, 6.0))




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


@pytest.mark.parametrize(("surface", "contact"), [(40.0, 30.0), (0.0, 30.0), (40.0, 0.0)])
def test_the_peak_is_the_larger_of_surface_and_contact_percentiles_are_of_the_volume(block, surface, contact):
    values = np.zeros((len(block.tets), 4))
    values[123] = 50.0
    found = measures(block, values, deciding(surface, contact))
    assert (found.peak, found.surface, found.contact) == (max(surface, contact), surface, contact)
    assert found.where == (found.surface_where if surface > contact else found.contact_where)
    assert (found.surface_where, found.contact_where) == ((1.0, 2.0, 3.0), (4.0, 5.0, 6.0))
    assert found.maximum == 50.0
    assert found.volume == pytest.approx(12.0 * 10.0 * 16.0)
    assert found.p99 <= found.p999 <= found.maximum


def test_measures_weigh_percentiles_by_volume(box):
    """Where the stress is the share of the volume that has less, each percentile is its own share."""
    fine = box((8, 8, 8), (6.0, 6.0, 6.0), shake=0.3)
    order = np.random.default_rng(0).permutation(len(fine.tets))
    share = np.empty(len(order))
    share[order] = np.cumsum(fine.volumes[order]) / fine.volumes.sum()
    found = measures(fine, np.repeat(share[:, None], 4, axis=1), deciding())
    assert found.p99 == pytest.approx(0.99, abs=5e-4)
    assert found.p999 == pytest.approx(0.999, abs=5e-4)
    assert found.maximum == pytest.approx(1.0)
