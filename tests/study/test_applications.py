"""The applications of the published method, and two runs side by side."""


import msgspec
import pytest

from mechstyle.errors import BadInput
from mechstyle.gallery import names
from mechstyle.runs.recipes import FREESTYLE, draft
from mechstyle.study import applications
from mechstyle.study.applications import APPLICATIONS, COLUMNS, Pair, application_named, apply
from mechstyle.study.cells import Cell
from mechstyle.styling.prompt import read
from support.lanes import lane_on_a_sheet


@pytest.mark.parametrize(
    ("name", "style"), [("eyeglasses", "fish_scales"), ("pill_box", "floral"), ("utensil_grip", "damascus"), ("lampshade", "mandala")]
)
def test_every_application_of_the_paper_is_there_and_its_prompt_is_understood_without_a_note(name, style):
    application = application_named(name)
    assert application.model in names()
    reading = read(application.prompt)
    assert ([wish.style for wish in reading.wishes], reading.notes) == ([style], ())
    assert application.about.endswith(".")


def test_there_are_no_others_and_only_the_pill_box_keeps_its_inside():
    assert len(APPLICATIONS) == 4
    assert [name for name, one in APPLICATIONS.items() if one.protect] == ["pill_box"]
    assert draft("brick", protect=APPLICATIONS["pill_box"].protect).protect[0].words == "inside colour"


def test_an_unknown_application_is_refused_with_the_nearest_first():
    with pytest.raises(BadInput, match="did you mean 'pill_box'"):
        application_named("pillbox")


def test_both_runs_get_the_same_part_prompt_and_regions(monkeypatch, tmp_path):
    asked = []
    monkeypatch.setattr(Cell, "run", lambda cell, out: asked.append((cell, out)))
    apply("pill_box", tmp_path, iterations=9)
    (free, free_out), (fed, fed_out) = asked
    assert free_out == fed_out == tmp_path
    assert (free.folder, fed.folder) == ("freestyle", "mechstyle")
    assert free.recipe.prompt == fed.recipe.prompt == "floral patterns"
    assert (free.model, free.part, free.vertices) == (fed.model, fed.part, fed.vertices) == ("gallery:pill_box", "pill_box", 25_000)
    assert {name for name, *_ in free.recipe.differences(fed.recipe)} == set(FREESTYLE) - {"memory", "retraction"}, "which are off unasked"
    assert (free.recipe.protect[0].words, free.recipe.iterations) == ("inside colour", 9)
    apply("pill_box", tmp_path, protect=[])
    assert asked[-1][0].recipe.protect == ()


@pytest.fixture(scope="module")
def pair(tmp_path_factory) -> Pair:
    """Two finished runs on a sheet whose stress is a known function of the relief."""
    roots = [tmp_path_factory.mktemp("pair") / label for label in ("freestyle", "mechstyle")]
    return Pair(*(lane_on_a_sheet(root, gain=gain) for root, gain in zip(roots, (90.0, 50.0), strict=True)))


def test_a_table_has_the_figures_of_all_three(pair):
    summary = pair.fed.summary
    came, free, fed = pair.rows()
    assert all(len(row) == len(COLUMNS) for row in (came, free, fed))
    assert came[1] == summary.baseline.verdict
    assert (fed[1].partition(", ")[0], fed[2]) == (summary.verdict, f"{summary.peak_stress:.1f}")
    assert fed[-1] == f"{summary.kept:.0%}"
    lines = pair.table().splitlines()
    assert len(lines) == 5
    assert all(line.count("|") == len(COLUMNS) + 1 for line in lines)


def test_a_figure_that_is_not_known_is_a_dash(pair):
    unknown = msgspec.structs.replace(pair.fed.summary.result, safety_factor=None, all_orientations=None)
    assert applications._figures(unknown)[-2:] == ("–", "–")


def test_a_verdict_too_close_to_a_limit_says_so_in_the_table(pair):
    """The demo's table said VIABLE, the words below it VIABLE, MARGINAL."""
    close = msgspec.structs.replace(pair.fed.summary.result, verdict="VIABLE", marginal=True)
    assert applications._figures(close)[0] == "VIABLE, MARGINAL"
    assert applications._figures(msgspec.structs.replace(close, marginal=False))[0] == "VIABLE"


def test_a_comparison_is_written_as_picture_and_table(pair, tmp_path):
    files = pair.save(tmp_path)
    assert (tmp_path / "comparison.png").read_bytes().startswith(b"\x89PNG")
    page = (tmp_path / "comparison.md").read_text()
    assert pair.table() in page
    assert pair.fed.summary.words in page
    assert set(files) == {"comparison", "table"}
