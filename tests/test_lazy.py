"""Public names by the stub beside a module: loaded when asked for, the same object each time."""

import sys

import pytest

from mechstyle import _lazy


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A package that hands out a name of another module and a module of its own, and has a third that nobody asks for."""
    folder = tmp_path / "shelf"
    folder.mkdir()
    (folder / "__init__.py").write_text(
        "from mechstyle._lazy import attached\n\n__getattr__, __dir__, __all__ = attached(__name__, __file__)\n"
    )
    (folder / "__init__.pyi").write_text("from shelf import books as books\nfrom shelf.inks import Ink as Ink\n")
    (folder / "books.py").write_text("")
    (folder / "inks.py").write_text("class Ink: ...\n")
    monkeypatch.syspath_prepend(tmp_path)
    yield __import__("shelf")
    for name in [name for name in sys.modules if name.partition(".")[0] == "shelf"]:
        del sys.modules[name]


def test_names_are_listed_without_loading_anything(package):
    assert package.__all__ == dir(package) == ["Ink", "books"]
    assert not {"shelf.inks", "shelf.books"} & sys.modules.keys()


def test_a_name_is_loaded_when_asked_for_and_stays_the_same(package):
    assert package.Ink is package.Ink is sys.modules["shelf.inks"].Ink
    assert package.books is sys.modules["shelf.books"]


def test_a_name_that_the_stub_does_not_give_is_none(package):
    with pytest.raises(AttributeError, match="module 'shelf' has no attribute 'Paper'"):
        package.Paper  # noqa: B018
    assert _lazy.attached("shelf", package.__file__)[2] == ["Ink", "books"]
