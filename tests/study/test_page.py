"""The page of a study: made from a table, the same from the same table, and honest about what was not run."""

import itertools
import json

import msgspec
import numpy as np
import pytest
from PIL import Image
from scipy import stats

from benchmarks.study import page as module
from benchmarks.study.cells import Row, Rows, read_table, write_table
from benchmarks.study.figures import _cell, wilson
from benchmarks.study.grids import CONDITIONS, STUDY_CONTROLS, STUDY_SCHEDULES, STYLES
from benchmarks.study.page import SLIPS, write_page
from mechstyle.errors import BadInput
from mechstyle.records.sentences import EXPLANATION, MEANINGS, bend


def study():
    """A formative study, an evaluation and an ablation of three models, their figures drawn at random, once for all."""
    random, rows = np.random.default_rng(4), []
    ways = [("freestyle", "none", "never")]
    ways += [(f"{schedule} × {control}", control, schedule) for schedule, control in itertools.product(STUDY_SCHEDULES, STUDY_CONTROLS)]
    for (part, prompt), (arm, control, schedule) in itertools.product(itertools.product(("hook", "cup", "tray"), STYLES), ways):
        left = float(random.uniform(0.02, 0.4 if arm == "freestyle" else 0.25))
        asked = {"part": part, "prompt": prompt, "arm": arm, "control": control, "schedule": schedule, "recipe": f"{part}{prompt}{arm}"}
        size = {"iterations": 60, "vertices": 6000, "tetrahedra": 9000, "simulations": 3, "kept": 0.9, "fall": 1500.0}
        strength = {"permanent_set": left, "outcome": "HOLDS" if left <= 0.2 else "FAILS", "tolerance": 0.2, "allowed": 0.2}
        strength |= {"sure": left < 0.3, "plain_permanent_set": 0.03}
        loss, seconds = 1.0 + 0.01 * random.normal(), float(random.lognormal(3.0, 0.3))
        rows.append(Row(**asked, **size, **strength, style_loss=loss, cpu_seconds=seconds))
    arms = {"part": "hook", "prompt": "brick", "kept": 0.8, "tetrahedra": 9000, "fall": 1500.0, "sure": True}
    rows += [Row(**arms, arm=arm, outcome=outcome, recipe=arm) for arm, outcome in (("static", "FAILS"), ("masks", "NO WORSE"))]
    return [*rows, Row(**arms, arm="masks", condition="load", outcome="HOLDS", recipe="masks")]


@pytest.fixture(autouse=True)
def undrawn(monkeypatch):
    """Only the page of the module has its figures drawn, which takes seconds; of all others words and tables are read."""
    monkeypatch.setattr(module, "_pictures", lambda done, named=module._pictures: dict.fromkeys(named(done), lambda: b"a figure"))


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    folder = tmp_path_factory.mktemp("page")
    return write_page(study(), folder / "study.md", note="Figures drawn at random."), (folder / "study.md").read_text()


def test_the_page_counts_with_intervals_beside_the_published_figures(page):
    free = [row for row in study() if row.arm == "freestyle"]
    passes = sum(row.passes for row in free)
    low, high = wilson(passes, len(free))
    text = page[1]
    assert 0 < passes < 18
    assert f"| all | {passes} of 18 ({100 * passes / 18:.1f} %) | {100 * low:.1f} to {100 * high:.1f} % |" in text
    assert "25.55 % (46 of 180)" in text
    assert "80.2 %" in text
    assert SLIPS in text
    assert "Figures drawn at random." in text


def test_no_paragraph_of_the_page_is_long(page):
    assert [block for block in page[1].split("\n\n") if len(block.split()) > 90 and "|" not in block[:1]] == []


def test_a_part_that_was_also_run_coarsely_counts_once_in_the_style_alone(page, tmp_path):
    """Coarser runs stand beside the ways that were run as coarse."""
    coarse = [msgspec.structs.replace(row, vertices=2000, recipe=f"{row.recipe}!", outcome="HOLDS") for row in study()[:13]]
    write_page(study() + coarse, tmp_path / "two.md")
    counted = [line for line in page[1].splitlines() if line.startswith(("| all", "| passes, freestyle"))]
    assert len(counted) == 2
    assert set(counted) <= set((tmp_path / "two.md").read_text().splitlines())


def test_the_style_alone_is_counted_where_most_of_it_was_run(tmp_path):
    """An ablation of two parts at 12 000 vertices stood for a formative study of 180."""
    free = [row for row in study() if row.arm == "freestyle"]
    finer = [msgspec.structs.replace(row, vertices=12_000, recipe=f"{row.recipe}!") for row in free[:2]]
    write_page([*free, *finer], tmp_path / "study.md")
    text = (tmp_path / "study.md").read_text()
    assert f"{sum(row.passes for row in free)} of 18" in text
    assert text.index("How many parts survive") < text.index("Published: 25.55 %") < text.index("## How to read it")


def test_what_was_run_is_told_in_words(tmp_path):
    write_page(study()[:-3], tmp_path / "one.md")
    text, sure = (tmp_path / "one.md").read_text(), sum(row.sure for row in study()[:-3])
    assert "60 iterations, 6000 vertices, 9000 tetrahedra, one seed, " in text
    assert f"Asked for is a fall of 1.5 m. {sure} of 234 outcomes are sure." in text
    coarse = [msgspec.structs.replace(row, vertices=2000, iterations=40, seed=7, recipe=f"{row.recipe}!") for row in study()[:13]]
    write_page(study()[:-3] + coarse, tmp_path / "two.md")
    assert "40 or 60 iterations, 2000 or 6000 vertices, 9000 tetrahedra, 2 seeds, " in (tmp_path / "two.md").read_text()


def test_a_number_that_does_not_decide_is_explained_beside_its_figure(page):
    assert "✗ with a number below the tolerance: it cracks there." in page[1]


def test_the_page_says_how_to_read_it_and_what_its_table_measures(page):
    assert " ".join(EXPLANATION) in " ".join(page[1].split())
    assert all(f"* **{outcome}**: {meaning}" in page[1] for outcome, meaning in MEANINGS.items())
    assert "what stays bent in the worst test (columns `permanent_set`, `plain_permanent_set` and `allowed`, in mm)" in page[1]


def test_what_each_mechanism_is_worth_is_counted_by_condition(page):
    told = [line for line in page[1].splitlines() if line.startswith(("| drop |", "| load |"))]
    assert [[part.strip() for part in line.split("|")[1:4]] for line in told] == [
        ["drop", "masks", "1 of 1 (100.0 %)"], ["drop", "static", "0 of 1 (0.0 %)"], ["load", "masks", "1 of 1 (100.0 %)"],
    ]  # fmt: skip
    assert f"* **load**: {CONDITIONS['load'].about}." in page[1]
    assert "**deep**" not in page[1]


def test_a_mark_in_the_figure_stands_in_brackets_where_the_outcome_is_not_sure():
    known = {"part": "a", "prompt": "b", "arm": "c", "permanent_set": 1.234}
    outcomes = (("HOLDS", True), ("NO WORSE", False), ("UNKNOWN", False))
    text = [_cell(Row(**known, outcome=outcome, sure=sure))[0] for outcome, sure in outcomes]
    assert text == ["1.23 ✓", "1.23 (≈)", "1.23 ?"]


def test_processor_time_is_that_of_runs_without_a_gpu(page, tmp_path):
    """On a GPU the processor waits: twice as many runs there, ten times as fast, change nothing."""
    rows = [msgspec.structs.replace(row, device="cpu") for row in study()]
    there = [msgspec.structs.replace(row, device="cuda:0", part=f"{row.part} {copy}", cpu_seconds=0.1 * row.cpu_seconds)
             for row in rows for copy in (2, 3)]  # fmt: skip
    there[5] = msgspec.structs.replace(there[5], device="cpu", cpu_seconds=1e4)  # a way that was filled in, for it took too long there
    write_page([*rows, *there], tmp_path / "study.md")
    alike, both = (told[told.index("## Time") : told.index("## What each")] for told in (page[1], (tmp_path / "study.md").read_text()))
    assert "says little; of the 216 runs of 648 whose part and style were simulated without a GPU in every way.\n" in both
    assert both[both.index("|") :] == alike[alike.index("|") :]


def test_the_style_alone_is_told_style_by_style(page):
    told = [row for row in study() if row.arm == "freestyle" and row.prompt == "cactus"]
    passes, sure = sum(row.passes for row in told), sum(row.sure for row in told)
    (line,) = [line for line in page[1].splitlines() if line.startswith("| cactus |")]
    assert line.startswith(f"| cactus | {passes} of 3 ({100 * passes / 3:.1f} %) |")
    assert line.endswith(f" % | {sure} | {bend(float(np.median([row.permanent_set for row in told])))} | 0.03 mm |")


def test_every_figure_is_there_and_is_a_picture(page):
    files, text = page
    names = {"freestyle", "passes", "time", "arms", "kept"}
    assert set(files) == {"page", "table", *names}
    for name in names:
        with Image.open(files[name]) as picture:
            assert picture.size[0] == 1400
        assert f"study-{name}.png" in text


def test_the_page_made_of_its_own_table_is_the_same(page, tmp_path):
    files, text = page
    again = write_page(read_table(files["table"]), tmp_path / "study.md", note="Figures drawn at random.")
    assert (tmp_path / "study.md").read_text() == text
    assert read_table(again["table"]) == read_table(files["table"])


def test_what_did_not_run_is_told_with_its_reason(tmp_path):
    rows = [*study()[:3], Row(part="box", prompt="moss", arm="freestyle", status="refused", refused="it is not closed")]
    write_page(rows, tmp_path / "study.md")
    assert "* box as 'moss', freestyle: refused, it is not closed" in (tmp_path / "study.md").read_text()
    with pytest.raises(BadInput, match="none of these runs is finished"):
        write_page(rows[3:], tmp_path / "none.md")


def test_a_folder_of_rows_is_a_table(tmp_path):
    rows = Rows(tmp_path)
    rows.folder.joinpath("rows").mkdir()
    (rows.folder / "rows" / "broken.json").write_text("{")
    with pytest.raises(BadInput, match="holds no rows"):
        read_table(tmp_path)
    with pytest.raises(BadInput, match="does not exist"):
        read_table(tmp_path / "none")
    (tmp_path / "other.json").write_text('{"a": 1}')
    with pytest.raises(BadInput, match="no table of a study"):
        read_table(tmp_path / "other.json")


def test_a_table_of_an_older_measure_is_refused_in_one_sentence(tmp_path):
    old = {"part": "hook", "prompt": "brick", "arm": "full", "outcome": "HOLDS", "flat_height": 2400.0}
    (tmp_path / "old.json").write_text(json.dumps([old]))
    (tmp_path / "rows").mkdir()
    (tmp_path / "rows" / "old.json").write_text(json.dumps(old))
    with pytest.raises(BadInput, match=r"or of an older measure .*flat_height.*: run the study again"):
        read_table(tmp_path / "old.json")
    with pytest.raises(BadInput, match="holds no rows of a study in mm"):
        read_table(tmp_path)


def test_a_table_comes_back_as_it_was(tmp_path):
    rows = study()[:20]
    written = write_table(rows, tmp_path / "table")
    assert written.name == "table.json"
    assert read_table(written) == rows


def test_the_interval_of_wilson_is_that_of_the_formula_and_leaves_room_below_all():
    assert wilson(180, 180) == pytest.approx((180 / (180 + stats.norm.ppf(0.975) ** 2), 1.0))
    assert wilson(81, 263) == pytest.approx((0.2553, 0.3662), abs=5e-5)  # Newcombe 1998, table I, method 3
    assert wilson(15, 148) == pytest.approx((0.0624, 0.1605), abs=5e-5)  # the same
