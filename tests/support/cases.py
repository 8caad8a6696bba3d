"""Validation cases as tests: the quick ones of a module, and whether one of them holds."""

from __future__ import annotations

import os
from types import ModuleType

import pytest

from validation import calculix, suite

MAY_SKIP = {"devices": "no CUDA device", "instructions": "not for "}
WITH_CALCULIX = {"cantilever", "bar_calculix", "neck"}


def quick(module: ModuleType) -> list[str]:
    """Names of the cases of a module that take seconds."""
    return [name for name, case in suite.CASES.items() if case.run.__module__ == module.__name__ and not case.slow]


def held(name: str) -> None:
    """Fail unless a case passes, or has a fault that is known and there still."""
    if name in WITH_CALCULIX and not calculix.available() and not os.environ.get("MECHSTYLE_SKIP_NOTHING"):
        pytest.skip(f"NO CALCULIX: {name} was NOT compared; apt-get install calculix-ccx")
    case = suite.CASES[name]
    results = case.results()
    assert results
    assert all(MAY_SKIP[name] in result.note for result in results if result.passed is None)
    failed = [f"{result.case}: error {result.error:.3g}, limit {result.limit:.3g}" for result in results if result.passed is False]
    assert bool(failed) == bool(case.fault), failed or "its known fault is mended: delete the words that excuse it"
