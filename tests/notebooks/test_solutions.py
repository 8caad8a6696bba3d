"""Answers to the exercises: what they tell to write exists, and the figures that are arithmetic come out as they say."""

from __future__ import annotations

import ast
import inspect
import math
import re
from typing import Any, get_type_hints

import nbformat
import pytest

from mechstyle import teaching
from mechstyle.errors import BadInput
from mechstyle.fea.drop import DropTest
from mechstyle.records import SETTINGS
from mechstyle.records.material import material_named
from mechstyle.records.recipe import CHOICES
from mechstyle.runs.recipes import recipe_for
from mechstyle.runs.run import Run
from support import ROOT

KNOWN: dict[str, Any] = {"run": Run, "main": Run, "DropTest": DropTest, "teaching": teaching}
"""What the notebooks call by these names: an object of a class, or the class or function itself."""
WORDS = {str(value) for values in CHOICES.values() for value in values}
SOLUTIONS = sorted((ROOT / "notebooks" / "solutions").glob("*.md"))


def codes(path) -> list[str]:
    """Pieces of Python in the answers, and in the exercises they are about."""
    exercises = nbformat.read(ROOT / "notebooks" / f"{path.stem}.ipynb", as_version=4).cells[-1].source
    prose = re.sub(r"```.*?```", "", path.read_text(encoding="utf-8") + exercises, flags=re.DOTALL)
    return [code.replace("…", "1.0") for code in re.findall(r"`([^`]+)`", prose)]


def kind(node: ast.expr) -> Any:
    """The class of what an expression comes to, or the function it names; an error where there is none of that name."""
    if isinstance(node, ast.Name):
        return KNOWN[node.id]
    if isinstance(node, ast.Attribute):
        owner = kind(node.value)
        if node.attr in get_type_hints(owner):
            return get_type_hints(owner)[node.attr]
        found = getattr(owner, node.attr)
        return get_type_hints(found.fget)["return"] if isinstance(found, property) else found
    assert isinstance(node, ast.Call), ast.dump(node)
    return called(node)


def called(node: ast.Call) -> Any:
    """Check the arguments of a call; the class of its answer."""
    what = kind(node.func)
    if not inspect.isclass(what):
        parameters = inspect.signature(what).parameters
        settings = {word.arg: ast.literal_eval(word.value) for word in node.keywords if word.arg not in parameters}
        assert not settings or any(one.kind is one.VAR_KEYWORD for one in parameters.values())
        recipe_for("brick", **settings)  # refuses what is no setting, and a value it cannot have
        return get_type_hints(what)["return"]
    what(**{word.arg: ast.literal_eval(word.value) for word in node.keywords})
    return what


def right(code: str, notebook: str) -> bool:
    """Whether a piece of code says something that is there; errors say what is not. Paths and words of other languages are let pass."""
    if re.match(r"\w+=", code):  # settings, as they are given by name
        settings = {word.arg: ast.literal_eval(word.value) for word in ast.parse(f"dict({code})").body[0].value.keywords}
        recipe_for("brick", **settings)
        return settings.keys() <= set(SETTINGS)
    if code.isidentifier():
        return code in {*WORDS, *SETTINGS} or re.search(rf"\b{code}\b", notebook) is not None
    return re.match(r"\w*", code)[0] not in KNOWN or kind(ast.parse(code).body[0].value) is not None


@pytest.mark.parametrize("path", SOLUTIONS, ids=lambda path: path.stem)
def test_what_the_answers_tell_to_write_exists(path):
    notebook = nbformat.read(ROOT / "notebooks" / f"{path.stem}.ipynb", as_version=4)
    source = "\n".join(cell.source for cell in notebook.cells if cell.cell_type == "code")
    assert [code for code in codes(path) if not right(code, source)] == []


@pytest.mark.slow
@pytest.mark.parametrize("path", SOLUTIONS, ids=lambda path: path.stem)
def test_the_code_of_the_answers_runs_and_says_what_they_say(path, lessons, monkeypatch):
    monkeypatch.chdir(lessons)
    for block in re.findall(r"```python\n(.*?)```", path.read_text(encoding="utf-8"), flags=re.DOTALL):
        assert "assert " in block
        exec(compile(block, path.name, "exec"), {})


def test_code_that_does_not_exist_is_found():
    for wrong in ("main.brunch(8)", "run.summary.kopt", 'main.branch(8, contrl="linear")', 'base="fre"', "DropTest(hight=1.0)"):
        with pytest.raises((AttributeError, TypeError, BadInput)):
            right(wrong, "")
    assert not right("quadrtic", "")


def test_figures_that_are_arithmetic():
    pla, abs_ = material_named("PLA"), material_named("ABS")
    impact = DropTest().speed

    def wave(material, speed):
        return material.density * material.bar_wave_speed * speed

    assert wave(pla, impact) == pytest.approx(11.30, abs=0.01)
    assert wave(pla, impact / math.sqrt(2.0)) == pytest.approx(8.0, abs=0.02)
    assert pla.critical_stress == pytest.approx(9.12, abs=0.005)
    assert wave(pla, DropTest(height=977.0).speed) == pytest.approx(pla.critical_stress, rel=1e-3)
    assert pla.yield_strength / pla.critical_stress == pytest.approx(5.0, abs=0.01)
    assert wave(abs_, impact) / wave(pla, impact) == pytest.approx(0.76, abs=0.005)
    assert abs_.yield_strength == pytest.approx(33.0, abs=0.5)
