"""What teachers are given beside the notebooks: words for every figure, slides that load nothing, answers to every exercise."""

from __future__ import annotations

import re
import runpy

import nbformat
import pytest
from nbconvert import SlidesExporter
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook, new_output

from support import ROOT

NOTEBOOKS = sorted((ROOT / "notebooks").glob("0[1-9]*.ipynb"))  # lessons: 00 is the Studio alone
DRAWS = re.compile(r"subplots\(|^picture\(|teaching\.(axes|stress|look|bent)\(|\.show\(\)\)?$", re.MULTILINE)
LEAST = 40  # letters that say something of a figure
PIXEL = "iVBORw0KGgo="


def cells_of(path):
    return nbformat.read(path, as_version=4).cells


def slides(notebook) -> str:
    exporter = SlidesExporter(template_name="offline", extra_template_basedirs=[str(ROOT / "notebooks" / "slides")], exclude_input=True)
    return exporter.from_notebook_node(notebook)[0]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_every_figure_has_words_and_every_cell_its_place_in_the_slides(path):
    cells = cells_of(path)
    drawn = [cell for cell in cells if cell.cell_type == "code" and DRAWS.search(cell.source)]
    assert [cell.source for cell in drawn if len(cell.metadata.get("alt", "")) < LEAST] == []
    assert all("slide_type" in cell.metadata.get("slideshow", {}) for cell in cells)
    assert sum("print" in cell.metadata.get("tags", []) and "alt" in cell.metadata for cell in cells) <= 1


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_the_figure_for_the_wall_is_the_one_that_is_tagged(path):
    script = runpy.run_path(str(ROOT / "notebooks" / "print_figures.py"))
    notebook = nbformat.read(path, as_version=4)
    tagged = [cell.metadata["alt"] for cell in notebook.cells if "print" in cell.metadata.get("tags", [])]
    found = script["figures"](notebook)
    assert [words for _, words in found] == tagged
    assert all(png.startswith(b"\x89PNG") for png, _ in found)


def test_a_notebook_without_such_a_figure_is_not_executed_for_the_wall(tmp_path):
    script = runpy.run_path(str(ROOT / "notebooks" / "print_figures.py"))
    nbformat.write(new_notebook(cells=[new_code_cell("raise SystemError")]), tmp_path / "plain.ipynb")
    script["main"](tmp_path / "figures", [tmp_path / "plain.ipynb"])
    assert list((tmp_path / "figures").iterdir()) == []


def test_slides_load_nothing_and_keep_the_words_of_a_figure():
    figure = new_code_cell("secret = 1", metadata={"alt": "a front that runs up", "slideshow": {"slide_type": "-"}})
    figure.outputs = [new_output("display_data", {"image/png": PIXEL})]
    told = [new_output("stream", name="stdout", text="not for slides")]
    setup = new_code_cell("", metadata={"slideshow": {"slide_type": "skip"}}, outputs=told)
    title = new_markdown_cell(r"# Title $\rho c v$", metadata={"slideshow": {"slide_type": "slide"}})
    page = slides(new_notebook(cells=[title, setup, figure]))
    assert re.findall(r"""(?:src|href|from)=?\s*["']https?:""", page) == []
    assert 'alt="a front that runs up"' in page
    assert "secret" not in page
    assert "not for slides" not in page


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_every_exercise_has_an_answer(path):
    asked = re.findall(r"^(\d)\. ", cells_of(path)[-1].source, re.MULTILINE)
    answers = (ROOT / "notebooks" / "solutions" / f"{path.stem}.md").read_text(encoding="utf-8")
    assert re.findall(r"^(\d)\. ", answers, re.MULTILINE) == asked


def test_the_lesson_plan_adds_up_to_90_minutes():
    plan = (ROOT / "docs" / "lesson-plan.md").read_text(encoding="utf-8")
    minutes = [int(number) for number in re.findall(r"^\| \d+–\d+ \| (\d+) min", plan, re.MULTILINE)]
    assert sum(minutes) == 90
