"""The applications of the published method, and two runs side by side."""

import pytest

from mechstyle.errors import BadInput
from mechstyle.gallery import names
from mechstyle.records.mesh import STANDARD_VERTICES
from mechstyle.records.sentences import length
from mechstyle.records.written import written
from mechstyle.runs.recipes import FREESTYLE, draft
from mechstyle.study.applications import APPLICATIONS, Pair, application_named, apply
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
    assert draft("brick", protect=APPLICATIONS["pill_box"].protect).restraint.protect[0].words == "inside colour"


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
    assert free.recipe.style.prompt == fed.recipe.style.prompt == "floral patterns"
    model, part = "gallery:pill_box", "pill_box"
    assert (free.model, free.part, free.vertices) == (fed.model, fed.part, fed.vertices) == (model, part, STANDARD_VERTICES)
    assert {name for name, *_ in free.recipe.differences(fed.recipe)} <= set(FREESTYLE)
    assert (free.recipe.restraint.guarantee, fed.recipe.restraint.guarantee) == (False, True)
    assert (free.recipe.restraint.protect[0].words, free.recipe.schedule.iterations) == ("inside colour", 9)
    apply("pill_box", tmp_path, protect=[])
    assert asked[-1][0].recipe.restraint.protect == ()


@pytest.fixture(scope="module")
def pair(tmp_path_factory) -> Pair:
    """Two finished runs on a sheet whose stress is a known function of the relief."""
    roots = [tmp_path_factory.mktemp("pair") / label for label in ("freestyle", "mechstyle")]
    return Pair(*(lane_on_a_sheet(root, gain=gain) for root, gain in zip(roots, (90.0, 50.0), strict=True)))


def test_the_table_of_falls_has_what_all_three_survive_and_the_style_kept_last(pair):
    columns, rows = pair.table()
    assert columns == ("test", "plain", "Freestyle", "MechStyle", "asked")
    assert all(len(row) == len(columns) for row in rows)
    flat = pair.fed.verdict.row("flat")
    assert rows[0][:2] == ("flat", length(flat.original))
    assert rows[0][3].startswith(length(flat.height))
    assert rows[0][4] == written(flat.asked) == "1.5 m"
    assert rows[-1] == ("style kept", "–", f"{pair.free.summary.kept:.0%}", f"{pair.fed.summary.kept:.0%}", "–")


def test_a_comparison_is_written_as_picture_and_table(pair, tmp_path):
    files = pair.save(tmp_path)
    assert (tmp_path / "comparison.png").read_bytes().startswith(b"\x89PNG")
    page = (tmp_path / "comparison.md").read_text()
    assert "| test | plain | Freestyle | MechStyle | asked |" in page
    assert all(f"| {' | '.join(row)} |" in page for row in pair.table()[1])
    assert pair.fed.verdict.words in page
    assert set(files) == {"comparison", "table"}


def test_the_stress_in_a_picture_of_a_pair_names_its_landing(pair, monkeypatch):
    notes = []
    monkeypatch.setattr("mechstyle.pictures.panels.picture", lambda panels, **_: notes.extend(panel.note for panel in panels))
    pair.show()
    named = [run.verdict.deciding.landing for run in (pair.free, pair.fed)]
    assert all(any(landing in note for note in notes) for landing in named)
