"""What coarse elements may hide where a support ends, against beam theory."""

import numpy as np
import pytest

from mechstyle.fea.statics.border_doubt import heading_for
from mechstyle.fea.verdict import CONTACT_BAND
from mechstyle.simulation.validation.bending import CLAMP, bent
from mechstyle.simulation.validation.meshes import box

COARSE = [((8, 4, 1), (24.0, 12.0, 3.0)), ((4, 2, 1), (24.0, 12.0, 4.0)), ((5, 3, 1), (15.0, 9.0, 3.0)), ((3, 2, 1), (15.0, 9.0, 4.0)),
          ((6, 3, 1), (18.0, 9.0, 3.0)), ((4, 3, 1), (18.0, 12.0, 5.0)), ((20, 4, 1), (60.0, 12.0, 3.0))]  # fmt: skip


@pytest.mark.parametrize(("counts", "size"), COARSE)
def test_what_a_short_arm_of_long_elements_heads_for_is_within_the_band_of_its_clamp(counts, size, pla):
    """Read are 65 to 90 MPa of the 100 that beam theory has there, and that is what a verdict would go by."""
    found = bent(box(counts, size), CLAMP, pla)
    heading = heading_for(found.mesh, found.border, found.load.field)
    assert found.load.peak < heading
    assert heading >= (1.0 - CONTACT_BAND) * CLAMP


def test_a_long_arm_heads_for_no_more_than_its_clamp(pla):
    found = bent(box((20, 4, 1), (60.0, 12.0, 3.0)), CLAMP, pla)
    assert heading_for(found.mesh, found.border, found.load.field) < 1.05 * CLAMP


@pytest.mark.parametrize(("counts", "size"), [((24, 12, 3), (24.0, 12.0, 3.0)), ((15, 9, 2), (15.0, 9.0, 3.0))])
def test_elements_short_enough_to_read_the_stress_leave_nothing_to_guess(counts, size, pla):
    found = bent(box(counts, size), CLAMP, pla)
    assert heading_for(found.mesh, found.border, found.load.field) == 0.0


def test_without_stress_or_border_there_is_nothing_to_head_for(pla):
    found = bent(box((8, 4, 1), (24.0, 12.0, 3.0)), CLAMP, pla)
    nothing = np.zeros(len(found.mesh.vertices))
    assert heading_for(found.mesh, found.border, nothing) == heading_for(found.mesh, nothing > 0.0, found.load.field) == 0.0
