"""The report: what is in it, that nothing typed by a person becomes markup, and that it loads nothing."""

import base64
import gzip
import hashlib
import html
import itertools
import json
import re
from dataclasses import replace
from html.parser import HTMLParser

import msgspec
import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.loop.history import largest_mask_change, rows, steps
from mechstyle.records import Doubt, sentences
from mechstyle.records.landings import STANDARDS
from mechstyle.records.recipe import described
from mechstyle.runs.report import texts
from mechstyle.runs.report.markup import cells
from mechstyle.runs.report.outcomes import RING, SHAPES, kind
from mechstyle.runs.report.page import _limits, _row, report_page, write_report
from mechstyle.runs.report.replay_data import replay_data
from mechstyle.runs.report.timeline import ticks, timeline
from support.records import UNKNOWN, row
from support.records import verdict as judged


class Reader(HTMLParser):
    """Elements and visible text of a page; complains about elements that are not closed."""

    EMPTY = frozenset({"meta", "img", "circle", "path", "line", "polyline", "input", "br"})

    def __init__(self, page):
        super().__init__()
        self.open, self.elements, self.text, self.scripts = [], [], "", []
        self.feed(page)
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        self.elements.append((tag, dict(attributes)))
        if tag not in self.EMPTY:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.elements.append((tag, dict(attributes)))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] == "script":
            self.scripts.append(data)
        elif self.open and self.open[-1] != "style":
            self.text += data


@pytest.fixture(scope="module")
def page(lane):
    return report_page(lane)


@pytest.fixture(scope="module")
def read(page):
    return Reader(page)


def test_it_says_what_a_reader_must_know(read, lane):
    verdict, recipe = lane.verdict, lane.recipe
    for words_ in (
        verdict.head, *sentences.EXPLANATION, *sentences.MEANINGS.values(), recipe.digest, recipe.test.material.source,
        "a note on the part", *texts.LIMITS, "mechstyle run gallery:pen_holder --prompt brick",
    ):  # fmt: skip
        assert words_ in read.text
    for name in ("surface", "tetrahedra", *recipe.settings):
        assert name == "material" or name.replace("_", " ") in read.text


def test_it_says_what_the_material_and_the_standard_leave_open(sheet):
    run = sheet(iterations=3, standard="mil-810h", build_direction=(0.0, 0.0, 1.0))
    text = Reader(report_page(run)).text
    assert "generic PLA; what is sold under the name lies apart (strength 23 to 65 MPa" in text
    assert "Simulated orientations after MIL-STD-810H, method 516.8, procedure IV (transit drop), but" in text
    assert STANDARDS["mil-810h"].departs in text
    assert "0.55 of that along them" in text
    assert "Layers printed along (0, 0, 1) are judged with 0.55" in text
    assert not [words for words in _limits(run.recipe) if "pass" in words.lower()], "it is no test to the standard"


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


def test_the_verdict_stands_there_once_with_its_table_and_its_doubt(sheet):
    """It stood there five times: word, meaning, sentence, boxes and rules."""
    run = sheet(iterations=20, gain=30.0, schedule="never", guarantee=False)
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
    assert len(rows) == len(verdict.rows) == 3


def step_of(lane, judged, iteration=0):
    step = steps(lane.store, rows(lane.store))[0]
    return msgspec.structs.replace(step, iteration=iteration, verdict=judged)


def test_an_outcome_that_is_not_sure_has_a_ring_and_says_so(lane):
    doubt = Doubt(about="limit", value=1.01, test="flat", landing="flat")
    unsure = step_of(lane, msgspec.structs.replace(judged(row()), doubts=(doubt,)))
    drawn = str(timeline([unsure], 1))
    assert 'class="mark holds"' in drawn
    assert "HOLDS (not sure), flat: " in drawn
    assert RING in drawn
    assert '<span class="holds">HOLDS</span><span class="unknown"> (not sure)</span>' in cells(_row(unsure))
    sure = step_of(lane, judged(row()))
    assert RING not in str(timeline([sure], 1))
    assert '<span class="holds">HOLDS</span></td>' in cells(_row(sure))


def test_a_test_without_an_answer_is_drawn_as_one(lane):
    drawn = str(timeline([step_of(lane, UNKNOWN)], 1))
    assert SHAPES["UNKNOWN"] in drawn
    assert "UNKNOWN; original part" in drawn
    assert "limit 45.6 MPa" in drawn


@pytest.mark.parametrize(
    "peaks", [(26, 27, 27, 27), (30, 60, 55, 45.4), (20, 44, 45, 45.5), (60, 44, 47, 44), (45, 46, 45, 46, 44, 46, 45, 80)], ids=str
)
def test_the_name_of_the_limit_stands_where_the_curve_is_not(lane, peaks):
    """Far below the limit of 45.6 MPa, falling to it, rising to it, across it, and along it."""
    told = [step_of(lane, judged(row(stress=float(peak), limit=45.6)), iteration) for iteration, peak in enumerate(peaks)]
    drawn = str(timeline(told, len(peaks) - 1))
    right, base = (float(re.search(rf'class="limit-name"[^>]* {name}="([-.\d]+)"', drawn)[1]) for name in "xy")
    line = [tuple(map(float, point.split(","))) for point in re.search(r'class="peaks" points="([^"]+)"', drawn)[1].split()]
    curve = np.concatenate([np.linspace(one, other, 200) for one, other in itertools.pairwise(line)])
    for points, room in ((curve, 2.0), (np.array(line), 8.0)):
        beside = np.maximum(right - 95.0 - points[:, 0], points[:, 0] - right)
        over_or_under = np.maximum(base - 11.0 - points[:, 1], points[:, 1] - base - 3.0)
        assert np.maximum(beside, over_or_under).min() >= room


def test_each_simulation_is_drawn_against_its_own_limit(lane):
    """Where a load decides first and a landing at the end, the mark of either stood beside the limit of the last."""
    told = [step_of(lane, judged(row(stress=0.5 * limit, limit=limit)), iteration) for iteration, limit in enumerate((45.6, 91.2))]
    drawn = str(timeline(told, 1))
    heights = [float(y) for y in re.findall(r"V([-.\d]+)", re.search(r'class="limit" d="([^"]+)"', drawn)[1])]
    marks = [float(y) for y in re.findall(r'class="mark [^"]*" transform="translate\([-.\d]+ ([-.\d]+)\)', drawn)]
    assert [204.0 - y for y in marks] == pytest.approx([0.5 * (204.0 - y) for y in heights], abs=0.1)


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


def test_what_people_typed_never_becomes_markup(sheet):
    evil = "brick </script><script>alert(1)</script><img src=x onerror=alert(2)>{name}"
    run = sheet(iterations=3, prompt=evil, name="<b>cup</b>&amp;")
    read = Reader(report_page(run))
    assert [tag for tag, _ in read.elements].count("script") == 3
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
    header, payload, _ = read.scripts
    assert json.loads(header) == json.loads(json.dumps(played.header))
    assert gzip.decompress(base64.b64decode(payload)) == gzip.decompress(played.payload)


def test_a_small_run_makes_a_small_file_and_the_same_one_each_time(lane, tmp_path):
    path = write_report(lane, tmp_path / "out.html")
    assert path.stat().st_size < 400_000
    assert path.read_bytes() == write_report(lane, tmp_path / "again.html").read_bytes()


@pytest.mark.parametrize("name", ["out", "out.pdf", "folder.html"])
def test_a_path_that_is_no_html_file_is_refused(lane, tmp_path, name):
    (tmp_path / "folder.html").mkdir()
    with pytest.raises(BadInput, match=r"a report is an HTML file"):
        lane.report(tmp_path / name)


def test_an_unfinished_lane_has_a_report_as_well(sheet):
    run = sheet(iterations=20)
    branch = run.branch(10, lane="later", seed=3)
    text = Reader(report_page(branch)).text
    assert "stands at iteration 10 of 20" in text
    assert "--lane later --seed 3" in text


def test_a_notebook_without_a_kernel_shows_a_picture_and_a_table(lane):
    shown = lane._repr_mimebundle_()
    read = Reader(shown["text/html"])
    assert [tag for tag, _ in read.elements].count("img") == 2
    assert "script" not in [tag for tag, _ in read.elements]
    for text in (read.text, shown["text/plain"]):
        assert lane.verdict.words in text
        assert "every 10 iterations" in text


def test_a_notebook_without_a_kernel_and_the_replay_say_where_a_verdict_is_not_sure(sheet):
    run = sheet(iterations=20, gain=30.0, control="none", guarantee=False)
    told = [step.verdict for step in steps(run.store, rows(run.store))]
    assert {verdict.sure for verdict in told} == {True, False}
    shown, last = run._repr_mimebundle_(), replay_data(run).header["frames"][-1]
    for text in (Reader(shown["text/html"]).text, shown["text/plain"]):
        assert text.replace(run.verdict.words, "").count(sentences.NOT_SURE) == sum(not verdict.sure for verdict in told)
    assert last["outcome"].endswith(" (not sure)")
    assert " (not sure); " in last["words"]


@pytest.mark.parametrize(("top", "about", "wanted"), [(60, 6, [0, 10, 20, 30, 40, 50, 60]), (51, 4, [0, 20, 40]), (1, 10, None)])
def test_ticks_are_round_numbers(top, about, wanted):
    found = list(ticks(top, about))
    assert found[0] == 0
    assert found[-1] <= top * (1 + 1e-9)
    assert wanted is None or found == wanted
