"""The report: what is in it, that nothing typed by a person becomes markup, and that it loads nothing."""

import base64
import gzip
import hashlib
import html
import json
import re
from dataclasses import replace

import pytest

from mechstyle.errors import BadInput
from mechstyle.loop.history import largest_mask_change, rows, steps
from mechstyle.pictures.panels import Picture
from mechstyle.records import sentences
from mechstyle.records.landings import STANDARDS
from mechstyle.records.recipe import described
from mechstyle.runs.report.markup import RING, SHAPES, kind
from mechstyle.runs.report.page import LIMITS, _limits, report_page, write_report
from mechstyle.runs.report.replay_data import replay_data
from mechstyle.runs.run import Run
from support.reader import Reader


@pytest.fixture(scope="module")
def page(lane):
    return report_page(lane)


@pytest.fixture(scope="module")
def read(page):
    return Reader(page)


@pytest.fixture
def undrawn(monkeypatch):
    """Words are read: drawing the part takes a second or two for each report."""
    drawn = Picture(b"a picture")
    monkeypatch.setattr("mechstyle.runs.report.page.picture", lambda *_, **__: drawn)
    monkeypatch.setattr(Run, "show", lambda *_, **__: drawn)


def test_it_says_what_a_reader_must_know(read, lane):
    verdict, recipe = lane.verdict, lane.recipe
    for words_ in (
        verdict.head, *sentences.EXPLANATION, *sentences.MEANINGS.values(), recipe.digest, recipe.test.material.source,
        "a note on the part", *LIMITS, "mechstyle run gallery:pen_holder --prompt brick",
    ):  # fmt: skip
        assert words_ in read.text
    for name in ("surface", "tetrahedra", *recipe.settings):
        assert name == "material" or name.replace("_", " ") in read.text


@pytest.mark.usefixtures("undrawn")
def test_it_says_what_the_material_and_the_standard_leave_open(sheet):
    run = sheet(iterations=3, standard="mil-810h", build_direction=(0.0, 0.0, 1.0))
    text = Reader(report_page(run)).text
    assert "generic PLA; what is sold under the name lies apart (strength 23 to 65 MPa" in text
    assert "Simulated orientations after MIL-STD-810H, method 516.8, procedure IV (transit drop), but" in text
    assert STANDARDS["mil-810h"].departs in text
    assert "0.55 of that along them" in text
    assert "Layers printed along (0, 0, 1) are judged with 0.55" in text
    assert not [words for words in _limits(run.recipe) if "pass" in words.lower()], "it is no test to the standard"


@pytest.mark.usefixtures("undrawn")
def test_a_part_that_was_thickened_first_is_not_taken_for_the_one_it_was(sheet):
    run = sheet(iterations=3)
    assert "thickened first" not in Reader(report_page(run)).text
    run.__dict__["part"] = replace(run.part, mass_gained=1.5)  # a cached property
    text = Reader(report_page(run)).text
    assert "thickened first" in text
    assert "+1.5 g" in text


def test_every_setting_is_explained(read, lane):
    for name in lane.recipe.settings:
        assert name == "material" or described(name).replace("`", "") in read.text
    assert "`" not in read.text, "what one types is set apart by its letters"
    assert "height of the fall" in read.text.lower()


def test_every_simulation_has_a_mark_and_a_row_with_its_reason(read, lane):
    told = steps(lane.store, rows(lane.store))
    marks = [given for tag, given in read.elements if tag == "g" and "data-iteration" in given]
    table = [given for tag, given in read.elements if tag == "tr" and "data-iteration" in given]
    wanted = [str(step.iteration) for step in told]
    assert [mark["data-iteration"] for mark in marks] == [row["data-iteration"] for row in table] == wanted
    for step, mark in zip(told, marks, strict=True):
        assert step.reason in mark["aria-label"]
        assert step.verdict.outcome in mark["aria-label"]
        assert (sentences.NOT_SURE in mark["aria-label"]) is not step.verdict.sure
        assert sentences.figures(step.verdict.deciding) in mark["aria-label"]
        assert kind(step.outcome) in mark["class"].split()
        assert mark["tabindex"] == "0"


@pytest.mark.usefixtures("undrawn")
def test_the_verdict_stands_there_once_with_its_table_and_its_doubt(sheet):
    """It stood there five times: word, meaning, sentence, boxes and rules."""
    run = sheet(iterations=20, gain=28.5, schedule="never", guarantee=False)
    verdict, page = run.verdict, report_page(run)
    text = Reader(page).text
    assert verdict.doubt
    for words in (verdict.head, verdict.doubt):
        assert text.count(words) == 1
    shown = re.search(r'<table class="tests">.*?</table>', page, re.DOTALL)[0]
    cells = re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", shown.replace("\n", ""))
    headings, rows = sentences.tabulated(verdict)
    assert [re.sub("<[^>]+>", "", html.unescape(cell)).removesuffix(f" {sentences.NOT_SURE}") for cell in cells] == [
        *headings, *(cell for row in rows for cell in row),
    ]  # fmt: skip
    assert len(rows) == len(verdict.rows) == 2


def test_the_legend_tells_every_mark(page):
    for word, shape in SHAPES.items():
        assert f'class="mark {kind(word)}">{shape}</svg> {word}' in page
    assert f'class="mark unknown">{RING}</svg> not sure' in page


def test_every_outcome_has_a_mark_and_a_colour_of_its_own(page):
    assert set(SHAPES) == set(sentences.MEANINGS)
    assert len(set(SHAPES.values())) == len(SHAPES), "in grey the colour does not tell"
    style = page.partition("</style>")[0]
    found = [re.search(rf"\.{kind(word)} {{ color: var\(--([a-z-]+)\)", style)[1] for word in SHAPES]
    assert len({re.search(rf"--{name}: (#[0-9a-f]+)", style)[1] for name in found}) == len(SHAPES)


def test_the_story_of_the_mask_counts_vertices(lane):
    told = steps(lane.store, rows(lane.store))
    for step in told:
        assert step.restrained == int((lane.store.checkpoint(step.digest).mask < 0.5).sum())
    jump = largest_mask_change(told)
    assert jump is not None
    assert jump.added == max(step.added for step in told[1:])


def test_it_loads_nothing_from_anywhere(page, read):
    for tag, given in read.elements:
        for name in ("src", "href", "data", "action", "poster"):
            assert given.get(name, "data:").startswith("data:"), f"{tag} {name}"
    assert not re.search(r"@import|url\(|\bimport\s*\(|\bfetch\s*\(|XMLHttpRequest|https?://", page.replace("http-equiv", ""))
    assert "default-src 'none'" in page


@pytest.mark.usefixtures("undrawn")
def test_what_people_typed_never_becomes_markup(sheet):
    evil = "brick </script><script>alert(1)</script><img src=x onerror=alert(2)>{name}"
    run = sheet(iterations=3, prompt=evil, name="<b>cup</b>&amp;")
    read = Reader(report_page(run))
    assert [tag for tag, _ in read.elements].count("script") == 4, "what is replayed, in two, the result for a class, and the program"
    assert not [given for tag, given in read.elements if "onerror" in given or tag == "b"]
    assert evil in read.text
    assert "<b>cup</b>&amp;" in read.text
    assert json.loads(read.scripts[0])["prompt"] == evil


def test_no_script_runs_but_the_one_it_was_written_with(page, read):
    policy = next(given["content"] for _, given in read.elements if given.get("http-equiv") == "Content-Security-Policy")
    rules = dict(rule.strip().split(" ", 1) for rule in policy.split(";"))
    own = base64.b64encode(hashlib.sha256(read.scripts[-1].encode()).digest()).decode()
    assert rules["script-src"] == f"'sha256-{own}'"
    assert (rules["default-src"], rules["base-uri"], rules["form-action"]) == ("'none'",) * 3
    assert policy in page.replace("&#x27;", "'").replace("&#39;", "'")
    assert not [name for _, given in read.elements for name in given if name.startswith("on")], "a handler in an attribute would not run"


def test_the_replay_inside_is_that_of_the_lane(read, lane):
    played = replay_data(lane)
    header, payload, *_ = read.scripts
    assert json.loads(header) == json.loads(json.dumps(played.header))
    assert gzip.decompress(base64.b64decode(payload)) == gzip.decompress(played.payload)


@pytest.mark.slow
def test_a_small_run_makes_a_small_file_and_the_same_one_each_time(lane, tmp_path):
    path = write_report(lane, tmp_path / "out.html")
    assert path.stat().st_size < 400_000
    assert path.read_bytes() == write_report(lane, tmp_path / "again.html").read_bytes()


@pytest.mark.parametrize("name", ["out", "out.pdf", "folder.html"])
def test_a_path_that_is_no_html_file_is_refused(lane, tmp_path, name):
    (tmp_path / "folder.html").mkdir()
    with pytest.raises(BadInput, match=r"a report is an HTML file"):
        lane.report(tmp_path / name)


@pytest.mark.usefixtures("undrawn")
def test_an_unfinished_lane_has_a_report_as_well(sheet):
    run = sheet(iterations=20)
    branch = run.branch(10, lane="later", seed=3)
    text = Reader(report_page(branch)).text
    assert "stands at iteration 10 of 20" in text
    assert "--lane later --seed 3" in text
