"""The validation cases as a user runs them, by name; their figures are held by the tests of the modules they are in."""

import importlib.util
import json
import math
import re

import msgspec
import pytest

from support import ROOT
from validation import calculix, suite
from validation.cases import Case, bounded, compared
from validation.suite import Figures, merged

_SPEC = importlib.util.spec_from_file_location("validate", ROOT / "benchmarks/validate.py")
RUNNER = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(RUNNER)


def test_without_calculix_its_cases_say_so(monkeypatch):
    monkeypatch.setattr(calculix.shutil, "which", lambda _: None)
    (result,) = suite.CASES["cantilever"].results()
    assert result.passed is None
    assert "calculix-ccx" in result.note


def test_the_runner_gives_figures_and_a_page(tmp_path):
    assert RUNNER.main(["--case", "patch", "--case", "devices", "--json", str(tmp_path / "figures"), "--page", str(tmp_path)]) == 0
    patch, devices = (json.loads((tmp_path / "figures").read_text())[name]["results"] for name in ("patch", "devices"))
    assert {"case", "measured", "reference", "error", "limit", "passed"} <= set(patch[0])
    assert (patch[0]["passed"], devices[0]["passed"]) == (True, None)
    page = (tmp_path / "validation.md").read_text()
    assert "patch" in page
    assert "passed" in page


def test_a_failing_figure_is_named_and_the_exit_is_not_zero(monkeypatch, capsys):
    def wrong():
        yield compared("wrong: mass", 2.0, 1.0, 0.01)

    monkeypatch.setitem(suite.CASES, "wrong", Case("wrong", "Wrong on purpose", wrong))
    assert RUNNER.main(["--case", "wrong"]) == 1
    assert "wrong: mass" in capsys.readouterr().err


def test_an_unknown_case_is_refused_with_the_nearest(capsys):
    with pytest.raises(SystemExit) as left:
        RUNNER.main(["--case", "pach"])
    assert left.value.code == 2
    assert "did you mean 'patch'" in capsys.readouterr().err


def test_the_page_in_docs_has_every_case():
    page = ROOT.joinpath("docs/validation.md").read_text()
    rows = re.findall(r"^\| `(\w+)` \| (.+?) \|", page.partition("\n## ")[0], re.MULTILINE)
    assert rows == [(name, case.title) for name, case in suite.CASES.items()]
    nearest = dict(re.findall(r"^\| `(\w+)` \| (.+)$", page.partition("\n## ")[2], re.MULTILINE))
    assert list(nearest) == list(suite.CASES)
    for name, row in nearest.items():
        fault = suite.CASES[name].fault
        assert fault in page
        assert fault or "**failed**" not in row, f"{name} fails, and nothing says why"


def test_every_quick_case_is_held_by_the_test_of_its_module():
    """What takes minutes is run by hand, see docs/validation.md."""
    here = ROOT / "tests" / "validation"
    for module in {case.run.__module__.rpartition(".")[2] for case in suite.CASES.values() if not case.slow}:
        assert f"quick({module})" in (here / f"test_{module}.py").read_text(), f"no test runs the quick cases of {module}"


def test_the_page_begins_with_how_many_figures_of_each_case_pass(tmp_path, monkeypatch):
    good, bad = compared("a: one", 1.02, 1.0, 0.04), bounded("a: two", 0.3, 0.1)
    missing = bounded("a: three", math.nan, 0.1)
    unasked = type(good)(case="a", measured=math.nan, reference=0.0, error=math.nan, limit=0.1, passed=None)
    cases = (
        (Case("a", "A bar: ρ c v", list), [good]),
        (Case("b", "Another", list), [good, bad]),
        (Case("c", "A third", list, fault="Known."), [good, bad]),
        (Case("d", "A fourth", list), [unasked]),
        (Case("e", "A fifth", list), [missing]),
    )
    monkeypatch.setattr(suite, "CASES", {case.name: case for case, _ in cases})
    page = suite.write_page(tmp_path / "page.md", {case.name: Figures("a machine", results) for case, results in cases}).read_text()
    assert [line for line in page.partition("\n## ")[0].splitlines() if line.startswith("| `")] == [
        "| `a` | A bar: ρ c v | 1 | 1 | 0.50 |",
        "| `b` | Another | 2 | **1** | 3.00 |",
        "| `c` | A third | 2 | 1, a known limit | 3.00 |",
        "| `d` | A fourth | – | not run | – |",
        "| `e` | A fifth | 1 | **0** | nan |",
    ]
    assert "| `b` | two | – | – | 0.3 | 0.1 | **failed** |" in page, "the figure nearest to its limit, or beyond it"


def of(error, passed=True):
    """Figures of a case with one error; passed is None where it was not run."""
    return Figures("a machine", [msgspec.structs.replace(bounded("a: one", error, 1.0), passed=passed)])


def test_figures_measured_elsewhere_stay_where_a_case_cannot_be_run_here():
    before, after = {"devices": of(0.1), "rod": of(0.2)}, {"devices": of(0.0, None), "rod": of(0.3), "patch": of(0.0, None)}
    found = merged(before, after)
    assert list(found) == [name for name in suite.CASES if name in found], "in the order of the page"
    assert (found["devices"], found["rod"], found["patch"]) == (before["devices"], after["rod"], after["patch"])


def test_what_another_machine_measured_is_taken_over_and_its_failures_count(tmp_path):
    theirs = suite.write(tmp_path / "gpu.json", {"devices": of(0.1), "rod": of(2.0, passed=False)})
    assert RUNNER.main(["--read", str(theirs), "--page", str(tmp_path)]) == 1
    page = (tmp_path / "validation.md").read_text()
    summary = page.partition("\n## ")[0]
    assert re.findall(r"^\| `(\w+)`", summary, re.MULTILINE) == ["rod", "devices"], "nothing else was measured"
