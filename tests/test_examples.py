"""Every name of the front row has an example in its docstring, and each gives what it says."""

from __future__ import annotations

import doctest
import importlib
from collections.abc import Iterator

import pytest

import mechstyle


def examples_of(name: str) -> Iterator[doctest.DocTest]:
    """The examples of a public name; those of a table stand in the docstring of its module."""
    owner = importlib.import_module("mechstyle.records.material") if name == "LIBRARY" else getattr(mechstyle, name)
    return (test for test in doctest.DocTestFinder(recurse=False).find(owner, name, globs={"ms": mechstyle}) if test.examples)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """One folder for all: what one example has run, another opens."""
    return tmp_path_factory.mktemp("examples")


SIMULATED = {"PartTest", "simulate", "Verdict", "Run", "stylize"}
"""Names whose examples simulate a part; the first of them takes the time for all."""


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.slow] * (name in SIMULATED)) for name in mechstyle.__all__])
def test_the_example_of_a_name_gives_what_it_says(name, folder, monkeypatch):
    monkeypatch.chdir(folder)
    tests = list(examples_of(name))
    assert len(tests) == 1, f"ms.{name} has no example"
    told: list[str] = []
    result = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS | doctest.IGNORE_EXCEPTION_DETAIL).run(tests[0], out=told.append)
    assert result.failed == 0, "".join(told)
