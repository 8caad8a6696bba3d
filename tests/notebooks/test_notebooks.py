"""Every notebook runs from top to bottom; the physical numbers are asserted inside them."""

from __future__ import annotations

import json
import re

import nbformat
import papermill
import pytest

from support import ROOT

NOTEBOOKS = sorted((ROOT / "notebooks").glob("0[1-9]*.ipynb"))  # lessons: 00 is the Studio alone

SMALL = {
    "02_what_the_drop_test_computes": {"finest": 3},
    "04_schedules": {"names": ["never", "geometry"]},
    "05_tuning_thresholds": {"tried": [0.1, 1.0]},
    "06_branch_and_compare": {"every": 10},
    "07_a_reproducible_report": {"prompt": "cactus", "vertices": 1000, "iterations": 20},
}
"""Parameters by notebook that are smaller than, or other than, the defaults in it."""


@pytest.mark.slow
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_runs(path, tmp_path, lessons):
    done = tmp_path / path.name
    papermill.execute_notebook(path, done, SMALL.get(path.stem), cwd=lessons, kernel_name="python3", progress_bar=False, log_output=False)
    notebook = nbformat.read(done, as_version=4)
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    shown = {kind for output in outputs for kind in output.get("data", {})}
    assert shown & {"image/png", "text/html"}, "a notebook without a picture teaches nobody"
    warnings = [output["text"] for output in outputs if output.get("name") == "stderr" and "Warning" in output["text"]]
    assert not warnings


@pytest.mark.parametrize("stem", SMALL)
def test_parameters_have_a_cell_that_names_them(stem):
    notebook = nbformat.read(next(path for path in NOTEBOOKS if path.stem == stem), as_version=4)
    (cell,) = [cell for cell in notebook.cells if "parameters" in cell.metadata.get("tags", [])]
    assert all(name in cell.source for name in SMALL[stem])


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_is_committed_clean_and_asserts_something(path):
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    assert not any(cell.get("execution_count") for cell in cells)
    assert "assert " in "".join("".join(cell["source"]) for cell in cells if cell["cell_type"] == "code")
    assert "will learn" in "".join(cells[0]["source"])
    assert "Exercises" in "".join(cells[-1]["source"])


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_stored_notebook_is_small_and_shows_all_its_pictures_and_no_failure(path):
    """Whoever browses the repository sees a result; docs/site/store.py stores them."""
    cells = nbformat.read(path, as_version=4).cells
    outputs = [(cell, output) for cell in cells for output in cell.get("outputs", [])]
    pictured = {cell.id for cell, output in outputs if "image/png" in output.get("data", {})}
    assert pictured == {cell.id for cell in cells if "alt" in cell.metadata}
    assert {output.output_type for _, output in outputs} <= {"stream", "display_data"}
    assert all(output.name == "stdout" for _, output in outputs if output.output_type == "stream")
    assert path.stat().st_size <= 500_000


def told(name: str) -> list[str]:
    """Cells of the row of a run in a table that lesson 1 shows."""
    cells = nbformat.read(ROOT / "notebooks" / "01_first_part.ipynb", as_version=4).cells
    shown = "\n".join(output.get("data", {}).get("text/plain", "") for cell in cells for output in cell.get("outputs", []))
    return re.split(r"\s{2,}", next(line for line in shown.splitlines() if line.startswith(name)))


@pytest.mark.parametrize("page", ["README.md", "docs/lesson-plan.md"])
def test_pages_tell_the_figures_that_lesson_1_shows(page):
    text = (ROOT / page).read_text(encoding="utf-8")
    for name in ("Freestyle", "MechStyle"):
        _, outcome, bend, _, kept, _ = told(name)
        assert (f"{bend} {outcome}" if page == "README.md" else bend.split(",")[0]) in text
        assert kept in text or name == "Freestyle"


def test_there_are_notebooks():
    assert NOTEBOOKS
