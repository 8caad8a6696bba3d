"""What lessons and their answers share."""

import pytest


@pytest.fixture(scope="session")
def lessons(tmp_path_factory):
    """Where all of them run, as a class does: each opens what an earlier one ran."""
    return tmp_path_factory.mktemp("lessons")
