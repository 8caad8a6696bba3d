import pytest

from mechstyle import gallery


@pytest.fixture(scope="session")
def models():
    """Every model of the gallery with its default measures."""
    return {name: gallery.make(name) for name in gallery.names()}
