"""The mutation run itself: what it changes, that it sees what tests see, and that its explanations are not out of date."""

import importlib.util
import json
import sys
from pathlib import Path

import pytest

from support import ROOT

_SPEC = importlib.util.spec_from_file_location("mutants", ROOT / "benchmarks/mutants.py")
mutants = importlib.util.module_from_spec(_SPEC)
sys.modules["mutants"] = mutants  # its dataclasses look themselves up
_SPEC.loader.exec_module(mutants)

THING = '''"""A thing."""

LIMIT: int = 3


def clamped(value: int | str) -> int:
    """Not 4."""
    return min(value, LIMIT) if value > -1.5 and not value is None else 0


def doubled(values):
    """Nobody tests it."""
    values[0] += 1
    values *= 2
    return None if values else 1e-9
    return None
'''
TESTS = """
from house.thing import clamped


def test_what_is_too_large_is_clamped():
    assert [clamped(value) for value in (2, 3, 4)] == [2, 3, 3]
"""


@pytest.fixture
def house(tmp_path):
    """A package of one module, of which one function is tested."""
    for path, text in {"house/__init__.py": "", "house/thing.py": THING, "tests/test_thing.py": TESTS}.items():
        (tmp_path / path).parent.mkdir(exist_ok=True)
        (tmp_path / path).write_text(text)
    return tmp_path


def changed(house, line, text):
    """The mutant that turns one line of the thing into another."""
    (one,) = [mutant for mutant in mutants.mutants(house, "house/thing.py") if mutant.key(house)[1:] == (line, text)]
    return one


def test_a_change_that_tests_notice_is_killed_and_one_they_do_not_survives_and_no_file_is_touched(house):
    files = {path: path.read_bytes() for path in house.rglob("*") if path.is_file()}
    seen = changed(house, "LIMIT: int = 3", "LIMIT: int = 4")
    unseen = changed(house, "values *= 2", "pass")
    assert mutants.passes(house, None, ["tests/test_thing.py"], 60.0)
    assert not mutants.passes(house, seen, ["tests/test_thing.py"], 60.0)
    assert mutants.passes(house, unseen, ["tests/test_thing.py"], 60.0)
    assert {path: path.read_bytes() for path in house.rglob("*") if path.is_file()} == files


def test_a_change_after_which_tests_never_end_is_killed(house):
    (house / "tests/test_thing.py").write_text("import house.thing\n\ndef test_for_ever():\n    while True:\n        pass\n")
    assert not mutants.passes(house, None, ["tests/test_thing.py"], 1.0)


def test_what_reads_the_source_of_a_function_as_warp_does_reads_that_of_the_mutant(house):
    (house / "tests/test_thing.py").write_text(
        "import inspect\nimport house.thing\n\ndef test_source():\n    assert '*= 2' in inspect.getsource(house.thing.doubled)\n"
    )
    assert mutants.passes(house, None, ["tests/test_thing.py"], 60.0)
    assert not mutants.passes(house, changed(house, "values *= 2", "values *= 3"), ["tests/test_thing.py"], 60.0)


def test_what_is_drawn_is_of_all_modules_and_the_same_for_a_seed(house, monkeypatch):
    monkeypatch.setattr(mutants, "PRODUCT", {"house": "tests"})
    every = mutants.mutants(house, "house/thing.py")
    drawn = mutants.draw(house, 5, 3)
    assert len(set(drawn)) == 5
    assert set(drawn) <= set(every)
    assert drawn == mutants.draw(house, 5, 3)
    assert drawn != mutants.draw(house, 5, 4)
    assert mutants.draw(house, 1000, 0) == every


def test_a_module_has_the_files_of_its_name_or_those_that_import_it_or_those_of_the_nearest_folder(house, monkeypatch):
    monkeypatch.setattr(mutants, "PRODUCT", {"house": "tests"})
    for path, text in {
        "tests/test_thing_large.py": "",
        "tests/test_user.py": "from house.room import other\n",
        "tests/room/test_stranger.py": "import house.room.another\n",
        "house/room/other.py": "",
        "house/room/nook/alone.py": "",
    }.items():
        (house / path).parent.mkdir(parents=True, exist_ok=True)
        (house / path).write_text(text)
    assert mutants.tests_of(house, "house/thing.py") == ("tests/test_thing.py", "tests/test_thing_large.py")
    assert mutants.tests_of(house, "house/room/other.py") == ("tests/test_user.py",)
    assert mutants.tests_of(house, "house/room/nook/alone.py") == ("tests/room/test_stranger.py",)


@pytest.fixture
def unseen(house, monkeypatch):
    """A run over the house in which no test notices anything; calling it with explanations and the allowed share gives its status."""
    monkeypatch.setattr(mutants, "ROOT", house)
    monkeypatch.setattr(mutants, "MODULES", ("house/thing.py",))
    monkeypatch.setattr(mutants, "PRODUCT", {"house": "tests"})
    monkeypatch.setattr(mutants, "passes", lambda *_: True)
    monkeypatch.setattr(sys, "argv", ["mutants.py", "--per-module", "3"])

    def run(explained, most):
        monkeypatch.setattr(mutants, "EXPLAINED", explained)
        monkeypatch.setattr(mutants, "MOST_SURVIVORS", most)
        return mutants.main()

    return run


def explained(house, chosen):
    entries = [dict(zip(("module", "line", "mutant"), mutant.key(house), strict=True)) for mutant in chosen]
    lines = ["survivor = []"] * (not entries)
    for entry in entries:
        lines += ["[[survivor]]", *(f"{name} = {json.dumps(text)}" for name, text in entry.items()), 'why = "Nobody looks."']
    (house / "explained.toml").write_text("\n".join(lines))
    return house / "explained.toml"


def test_each_survivor_must_be_explained(house, unseen, capsys):
    chosen = mutants.sample(house, "house/thing.py", 3, 0)
    assert unseen(explained(house, chosen[:2]), most=1.0) == 1
    told = capsys.readouterr().out
    assert "3 of 3 survive (100.0%), 1 not explained" in told
    assert "NOT EXPLAINED" in told
    assert f"{chosen[2].line(house)}: " in told
    assert unseen(explained(house, chosen), most=1.0) == 0
    assert "NOT EXPLAINED" not in capsys.readouterr().out


@pytest.mark.parametrize("module", mutants.MODULES)
def test_mutants_of_a_listed_module_are_python_and_the_module_has_tests(module):
    mirrored = (ROOT / "tests").joinpath(*Path(module).parts[1:-1], f"test_{Path(module).name}")
    assert mirrored.relative_to(ROOT).as_posix() in mutants.tests_of(ROOT, module)
    assert len(mutants.mutants(ROOT, module)) > 20
    for mutant in mutants.sample(ROOT, module, 60, 0):
        compile(mutant.source(ROOT), module, "exec")


def test_every_explanation_speaks_of_a_mutant_that_there_is():
    explained = mutants.explanations()
    known = {mutant.key(ROOT) for module in {module for module, _, _ in explained} for mutant in mutants.mutants(ROOT, module)}
    for key, why in explained.items():
        assert key in known, key
        assert why.endswith("."), key
