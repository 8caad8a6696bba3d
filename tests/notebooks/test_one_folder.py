"""All notebooks are opened in one folder: where they ask for the same run directory, each finds its own run there."""

from __future__ import annotations

import ast
import logging
from typing import Any

import nbformat
import pytest

from mechstyle.runs.run import Run, started
from support import ROOT
from support.lanes import lane_on_a_sheet

STEMS = ("01_first_part", "03_control_strategies", "04_schedules", "05_tuning_thresholds", "06_branch_and_compare")
BEGIN = {"run", "stylize", "begin"}


def names_in(tree: ast.AST) -> set[str]:
    return {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}


def begins_a_run(statement: ast.stmt) -> bool:
    called = [node.func for node in ast.walk(statement) if isinstance(node, ast.Call)]
    return any((func.attr if isinstance(func, ast.Attribute) else getattr(func, "id", "")) in BEGIN for func in called)


def defined_by(statement: ast.stmt) -> set[str]:
    if isinstance(statement, ast.FunctionDef):
        return {statement.name}
    return {node.id for node in ast.walk(statement) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)}


def _is_import(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.Import | ast.ImportFrom)


def what_begins_runs(stem: str) -> ast.Module:
    """The statements of a notebook that begin runs, and those that they need."""
    cells = nbformat.read(ROOT / "notebooks" / f"{stem}.ipynb", as_version=4).cells
    statements = [statement for cell in cells if cell.cell_type == "code" for statement in ast.parse(cell.source).body]
    kept: list[ast.stmt] = []
    needed: set[str] = set()
    for statement in reversed(statements):
        made = defined_by(statement)
        makes = isinstance(statement, ast.Assign | ast.AugAssign | ast.FunctionDef)
        if _is_import(statement) or (makes and (begins_a_run(statement) or made & needed)):
            kept.append(statement)
            needed = (needed | names_in(statement)) - (set() if isinstance(statement, ast.AugAssign) else made)
    return ast.Module(kept[::-1], [])


@pytest.fixture
def begun(tmp_path, monkeypatch) -> list[Run]:
    """The runs that are begun from now on; none goes on, and no part is prepared."""
    part, begun = lane_on_a_sheet(tmp_path / "prepared", iterations=1).part, []
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(started.__kwdefaults__, "prepare", lambda *_, **__: part)
    monkeypatch.setattr(Run, "go", lambda run, *_: begun.append(run) or run)
    return begun


def carry_out(stem: str) -> dict[str, Any]:
    space: dict[str, Any] = {"__name__": stem}
    exec(compile(what_begins_runs(stem), stem, "exec"), space)
    return space


def test_notebooks_in_one_folder_find_runs_of_their_own(begun, caplog):
    found = {}
    for stem in STEMS:
        begun.clear()
        carry_out(stem)
        assert begun, f"{stem} begins no run"
        found[stem] = [(run.store.root, run.recipe.digest) for run in begun]
    assert any("holds a run with other settings" in record.message for record in caplog.records)
    caplog.clear()
    caplog.set_level(logging.CRITICAL)
    for stem in STEMS:  # an hour later
        begun.clear()
        carry_out(stem)
        assert [(run.store.root, run.recipe.digest) for run in begun] == found[stem]
