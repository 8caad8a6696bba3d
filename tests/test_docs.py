"""The pages: each is reached from the first, short, plain, names what exists; every link leads somewhere; generated pages are whole."""

import ast
import importlib
import json
import re
import sys
from pathlib import Path

import pytest
import typer

import mechstyle
from mechstyle.records.recipe import SETTINGS
from mechstyle.records.sentences import EXPLANATION, MEANINGS
from mechstyle.records.words import WORDS
from mechstyle.runs.recipes import recipe_for
from mechstyle.styling.prompt import reading_of
from support import ROOT

SITE = ROOT / "docs" / "site"
TOCTREE = re.compile(r"```\{toctree\}\n(.*?)```", re.DOTALL)


def generated(name):
    """A module of the folder that Sphinx is pointed at."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(SITE))
        patch.delitem(sys.modules, name, raising=False)
        return importlib.import_module(name)


with pytest.MonkeyPatch.context() as site:
    site.syspath_prepend(str(SITE))
    PROSE = generated("prose")
    importlib.import_module("generated")  # which the limits of generated pages ask
PAGES = PROSE.pages()


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_link_leads_to_a_place_that_is_there(page):
    assert PROSE.broken(page) == []


def test_a_link_that_leads_nowhere_is_found(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("# Here it is\n[a](#here-it-is) [b](#there) [c](other.md) [d](https://example.org) `[e](f)` ![g](g.png)")
    assert PROSE.broken(page) == ["#there", "other.md", "g.png"]


def test_every_page_is_reached_from_the_first():
    reached, todo = set(), [ROOT / "docs" / "index.md"]
    while todo:
        page = todo.pop()
        reached.add(page)
        listed = "\n".join(TOCTREE.findall(page.read_text(encoding="utf-8")))
        for entry in re.findall(r"^[^:\s]\S*$", listed, re.MULTILINE):
            file = next((path for suffix in (".md", ".ipynb") if (path := (page.parent / f"{entry}{suffix}").resolve()).is_file()), None)
            assert file is not None, f"{page.name} lists {entry}"
            todo += [file] if file.suffix == ".md" else []
            reached.add(file)
    assert len(reached) > 30
    assert {page.name for page in PAGES} - {page.name for page in reached} == {"README.md"}


def test_what_is_generated_names_every_command_setting_and_public_name():
    made = generated("generated")
    pages = {marker: make(Path("nowhere"), "off") for marker, make in made.PAGES.items()}
    for name, command in made.commands(typer.main.get_command(importlib.import_module("mechstyle.cli.app").app)):
        section = pages["every command"].partition(f"## `{name}`\n")[2].partition("\n## ")[0]
        options = {option for one in command.params if one.name != "help" for option in one.opts if option.startswith("-")}
        assert options <= set(re.findall(r"`(-[\w-]+)`", section))
    assert all(f"| `{name}` |" in pages["every setting"] for name in SETTINGS)
    sentences = re.sub(r"`[^`\n]*`", "", pages["every command"] + pages["every setting"])
    assert not re.search(r"(?<![\w-])--[a-z]", sentences), "an option in a sentence stays whole"
    assert all(f"{word}\n: " in pages["every word"] for word, _ in WORDS.values())
    assert all(f":: mechstyle.{name}\n" in pages["every name"] for name in mechstyle.__all__ if name not in {"LIBRARY", "lab"})
    assert all(f":: mechstyle.lab.{name}\n" in pages["every name"] for name in mechstyle.lab.__all__)
    asked = {marker for page in PAGES for marker in re.findall(r"<!-- (.+?) -->", PROSE.markdown(page))}
    assert set(pages) <= asked


def test_every_page_is_short_and_plain_and_names_what_exists():
    assert list(PROSE.found()) == []


def test_more_pages_words_and_links_than_may_be_are_found(monkeypatch):
    """The check is one that can fail."""
    for name, less in (("ALL", 10), ("GENERATED", 10), ("PAGES", 5), ("SIDEBAR", 5), ("WORDS", {"docs/index.md": 5})):
        monkeypatch.setattr(PROSE, name, less)
    said = [line.partition(" ")[2] for line in PROSE.large(12)]
    assert said == [
        "words are written in docs/, 10 at most", "words are generated, 10 at most", "pages are written in docs/, 5 at most",
        "links are in the sidebar, 5 at most", "words are in docs/index.md, 5 at most",
    ]  # fmt: skip


def test_every_texture_that_the_page_for_slicers_names_is_read_as_the_page_says():
    page = PROSE.markdown(ROOT / "docs" / "textures.md")
    rows = re.findall(r"^\| (`.+?`) \| ([a-z ]+) \|$", page, re.MULTILINE)
    assert len(rows) > 20
    for asked, style in rows:
        for name in re.findall(r"`(.+?)`", asked):
            reading = reading_of(recipe_for(prompt=name))
            assert reading.words.split(",")[0] == style, name
            assert reading.notes == (), name


@pytest.mark.parametrize(
    ("text", "wrong"),
    [
        ("One fact a sentence. Another one, beside it.", ["1: “beside”"]),
        ("# A page\n\n" + "Words " * 36 + "end.", ["3: a sentence of 37 words, 35 at most: " + "Words " * 5 + "…"]),
        ("Ten words make a sentence, and ten of these, too. " * 9, []),
        ("- " + "A sentence of five words. " * 20, ["1: a paragraph of 100 words, 90 at most: - A sentence of five words. A …"]),
        ("| a | b |\n|---|---|\n| no longer | it |", ["3: “no longer”"]),
        ("```text\nno longer than it was told\n```\n`told` [held](told.md)", []),
    ],
)  # fmt: skip
def test_what_is_hard_to_read_is_found(text, wrong):
    assert list(PROSE.unreadable(text)) == wrong


@pytest.mark.parametrize(
    ("text", "wrong"),
    [
        ("`mechstyle run cup.stl --relief 0.6`, `--relief`, `make docs`, `ms.load`", []),
        ("```sh\nmechstyle run cup.stl --depth 1  # deep\n```", ["'mechstyle run cup.stl --depth 1': no option --depth"]),
        ("`mechstyle class sums`", ["there is no command 'mechstyle class sums'"]),
        ("`--depth 1`", ["no command has the option --depth"]),
        ("`make money`", ["make has no target 'money'"]),
        ("`python benchmarks/dreams.py`", ["there is no benchmarks/dreams.py"]),
        ("`ms.sing()`", ["there is no ms.sing"]),
    ],
)
def test_what_a_page_names_and_does_not_exist_is_found(text, wrong):
    command = typer.main.get_command(importlib.import_module("mechstyle.cli.app").app)
    assert list(PROSE.missing(text, command, set(dir(mechstyle)))) == wrong


@pytest.mark.parametrize(
    ("text", "loads"),
    [
        ('<script src="https://example.org/a.js"></script>', True),
        ('<link href="//example.org/a.css" rel="stylesheet">', True),
        ("@import url(https://example.org/font.css)", True),
        ("body { background: url('http://example.org/a.png') }", True),
        ('<img alt="a" src="https://example.org/a.png">', True),
        ('<a href="https://example.org/">elsewhere</a> <script src="_static/a.js"></script>', False),
        ('<link rel="license" href="https://example.org/">', False),
    ],
)
def test_a_site_that_loads_from_a_network_is_refused(tmp_path, text, loads):
    (tmp_path / "page.html").write_text(text)
    assert bool(generated("check").loaded_from_elsewhere(tmp_path)) is loads


def test_a_page_runs_no_script_but_those_its_policy_names(tmp_path):
    page, check = generated("page"), generated("check")
    sealed = f"<head>{page.policy('<script>dark()</script>')}<script>dark()</script><script src='a.js'></script></head>"
    data = '<script type="application/json">{}</script>'
    assert page.stopped(sealed + data) == []
    assert page.stopped(sealed + "<script>other()</script>") == ["other()"]
    (tmp_path / "page.html").write_text("<p>no policy</p>")
    assert check.unsealed(tmp_path) == ["page.html: no Content-Security-Policy"]


def test_code_that_a_lesson_folds_is_folded_on_the_site_and_a_figure_keeps_its_words():
    lesson = json.loads(next((ROOT / "notebooks").glob("02_*.ipynb")).read_text(encoding="utf-8"))
    shown = json.loads(generated("page").as_in_lab(json.dumps(lesson)))
    folded = [bool(cell["metadata"].get("jupyter", {}).get("source_hidden")) for cell in lesson["cells"]]
    assert ["hide-input" in cell["metadata"].get("tags", []) for cell in shown["cells"]] == folded
    code = [cell for cell in lesson["cells"] if cell["cell_type"] == "code"]
    first = next(place for place, cell in enumerate(code) if "alt" in cell["metadata"])
    assert all(cell["metadata"]["jupyter"]["source_hidden"] for cell in code[: first + 1]), "it begins with a picture"
    words = [cell["metadata"]["mystnb"]["image"]["alt"] for cell in shown["cells"] if "alt" in cell["metadata"]]
    assert words == [cell["metadata"]["alt"] for cell in lesson["cells"] if "alt" in cell["metadata"]]


def test_the_citation_names_this_version():
    assert f"\nversion: {mechstyle.__version__}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")


JUDGES = {
    "permanent_set": "fea", "loading": "fea", "verdict": "records", "orientations": "fea", "simulation": "records", "phases": "fea",
}  # fmt: skip
"""Rooms of the modules whose constants can move an outcome."""


def test_the_table_of_constants_tells_their_values_and_has_a_dozen_at_most():
    rows = re.findall(r"^\| `(\w+)\.(\w+)` \| ([\d.]+)", PROSE.markdown(ROOT / "docs" / "sign.md"), re.MULTILINE)
    assert 8 <= len(rows) <= 12
    for module, name, told in rows:
        value = getattr(importlib.import_module(f"mechstyle.{JUDGES[module]}.{module}"), name)
        assert float(told) in (value.values() if isinstance(value, dict) else (value,)), name


def imported_by(module: str) -> set[str]:
    """Modules that a module imports something of, those included in which the names of a package are defined."""
    found = set()
    for node in ast.walk(ast.parse(Path(importlib.import_module(module).__file__).read_text())):
        for alias in node.names if isinstance(node, ast.ImportFrom) else ():
            value = getattr(importlib.import_module(node.module), alias.name, None)
            found |= {node.module, f"{node.module}.{alias.name}", getattr(value, "__module__", "")}
    return found


def test_the_walk_from_a_surface_to_its_verdict_is_short_and_leads_from_file_to_file():
    page = (ROOT / "docs" / "design.md").read_text().split("## From a surface to its verdict")[1].split("\n## ")[0]
    walk = [f"mechstyle.{name.replace('/', '.')}" for name in re.findall(r"^\d+\. `([\w/]+)`", page, re.MULTILINE)]
    assert 8 < len(walk) <= 12
    for place, module in enumerate(walk[1:], start=1):
        assert any(module in imported_by(above) for above in walk[:place]), f"nothing above it imports {module}"


def test_what_shows_that_nothing_is_passed_that_fails_is_there():
    page = PROSE.markdown(ROOT / "docs" / "sign.md")
    table = page.split("## Where it might pass what fails")[1].split("\n## ")[0]
    named = set(re.findall(r"`(\w+)`", table))
    tests = "".join(path.read_text() for path in (ROOT / "tests").rglob("test_*.py"))
    assert len(named) > 20
    for name in named:
        assert f"def {name}(" in tests, name


def test_the_page_on_verdicts_begins_with_the_sentences_of_the_program():
    page = PROSE.markdown(ROOT / "docs" / "how-mechstyle-judges.md")
    assert " ".join(page.split()).startswith(" ".join(("# How MechStyle judges", *EXPLANATION)))
    assert all(f"**{outcome}** | {meaning.removesuffix('.')}" in page for outcome, meaning in MEANINGS.items())
