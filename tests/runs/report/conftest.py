"""Lanes on a sheet for the reports to tell of."""

from __future__ import annotations

import pytest

from mechstyle.runs.run import Run
from mechstyle.simulation.part import Origin
from support.lanes import lane_on_a_sheet


@pytest.fixture
def sheet(tmp_path):
    """Makes a lane: name, origin, gain and any setting of the recipe may be given."""
    return lambda **settings: lane_on_a_sheet(tmp_path / "run", **settings)


@pytest.fixture(scope="session")
def lane(tmp_path_factory) -> Run:
    """One lane for the tests that only look at it."""
    return lane_on_a_sheet(tmp_path_factory.mktemp("lanes") / "run", origin=Origin(model="gallery:pen_holder"))
