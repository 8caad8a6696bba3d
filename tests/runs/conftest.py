"""Parts whose walls are known, without tetrahedra that fill them, as recipes and stylizers look at none; and a knob in marble."""

import numpy as np
import pytest

from mechstyle.records.mesh import TetMesh
from mechstyle.runs.run import Run, stylize
from mechstyle.simulation.part import Workpiece
from support.knob import knob

QUICK = {"iterations": 6, "orientations": 1, "nearly_flat": False, "window": 0.2, "element": "tet4"}
QUICK |= {"schedule": "every", "every": 3}


@pytest.fixture
def part(cube):
    """The recipe takes digests from it and nothing else, so these tetrahedra need not fill it."""
    tets = TetMesh(np.vstack([np.zeros(3), 10.0 * np.eye(3)]), [[0, 1, 2, 3]])
    return Workpiece(cube, tets, thickness=np.full(8, 10.0, np.float32), stands=True)


@pytest.fixture(scope="module")
def ball(sphere):
    tets = TetMesh(np.vstack([np.zeros(3), 10.0 * np.eye(3)]), [[0, 1, 2, 3]])
    return Workpiece(sphere, tets, thickness=np.full(len(sphere.vertices), 20.0, np.float32), stands=False)


@pytest.fixture(scope="module")
def run(tmp_path_factory) -> Run:
    """A finished run of a knob, its top protected."""
    folder = tmp_path_factory.mktemp("knob")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MECHSTYLE_CACHE", str(folder / "cache"))
        yield stylize(knob(), "marble", out=folder / "run", protect="above 29.9 colour", amplitude=0.3, device="cpu", **QUICK)


@pytest.fixture
def dropless(monkeypatch):
    """Fails what drops anything."""
    monkeypatch.setattr("mechstyle.simulation.simulator.drop", lambda *_, **__: pytest.fail("it was dropped again"))
