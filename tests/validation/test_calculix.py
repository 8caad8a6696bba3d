"""What is read from CalculiX's tables."""

import numpy as np
import pytest

from mechstyle.errors import MissingPiece
from mechstyle.fea.elements import QUADRATIC, with_nodes
from mechstyle.records.material import LIBRARY
from validation import calculix
from validation.meshes import box

TABLE = """
 displacements (vx,vy,vz) for set NALL and time  0.1000000E-04

         1  1.000000E+00  2.000000E+00 -3.000000E+00
         2  0.000000E+00  0.000000E+00 -5.000000E-01

 displacements (vx,vy,vz) for set NALL and time  0.2000000E-04

         1  4.000000E+00  5.000000E+00 -6.000000E+00
         2  0.000000E+00  0.000000E+00 -1.000000E+00
"""


def test_moments_come_with_their_times_in_milliseconds():
    time, displacement = calculix._read_moments(TABLE, 2)
    assert time == pytest.approx([0.01, 0.02])
    assert displacement.shape == (2, 2, 3)
    assert displacement[1, 0] == pytest.approx([4.0, 5.0, -6.0])
    assert displacement[:, 1, 2] == pytest.approx([-0.5, -1.0])


def test_a_landing_without_calculix_says_what_to_install(monkeypatch):
    monkeypatch.setattr(calculix.shutil, "which", lambda _: None)
    mesh = with_nodes(box((1, 1, 1), (2.0, 2.0, 2.0)), QUADRATIC)
    with pytest.raises(MissingPiece, match="calculix-ccx"):
        calculix.landing(mesh, LIBRARY["PLA"], 5.0, 0.01, 1e-4)


@pytest.mark.slow
def test_a_falling_block_is_pushed_back_with_its_momentum():
    """Long enough to leave the floor again: the impulse lies between once and twice the momentum of the fall."""
    if not calculix.available():
        pytest.skip("NO CALCULIX: its floor was NOT tried; apt-get install calculix-ccx")
    block, pla = box((2, 2, 2), (4.0, 4.0, 4.0)), LIBRARY["PLA"]
    found = calculix.landing(with_nodes(block, QUADRATIC), pla, 5.0, 0.01, 1e-4)
    momentum = pla.density * block.volumes.sum() * 5.0
    impulse = np.trapezoid(found.force, found.time)
    assert momentum < impulse < 2.0 * momentum
    assert found.force[-1] == 0.0
