"""The page of a study: made from a table, the same from the same table, and honest about what was not run."""

import itertools
import json

import msgspec
import numpy as np
import pytest
from PIL import Image
from scipy import stats

from benchmarks.study import page as module
from benchmarks.study.cells import Row, read_table, write_table
from benchmarks.study.figures import wilson
from benchmarks.study.grids import CONDITIONS, STUDY_CONTROLS, STUDY_SCHEDULES, STYLES
from benchmarks.study.page import SLIPS, write_page
from mechstyle.errors import BadInput


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


def test_the_style_alone_is_counted_where_most_of_it_was_run(tmp_path):
    """An ablation of two parts at 12 000 vertices stood for a formative study of 180."""
    free = [row for row in study() if row.arm == "freestyle"]
    finer = [msgspec.structs.replace(row, vertices=12_000, recipe=f"{row.recipe}!") for row in free[:2]]
    write_page([*free, *finer], tmp_path / "study.md")
    text = (tmp_path / "study.md").read_text()
    assert f"{sum(row.passes for row in free)} of 18" in text
    assert text.index("How many parts survive") < text.index("Published: 25.55 %") < text.index("## How to read it")


def test_what_each_mechanism_is_worth_is_counted_by_condition(page):
    told = [line for line in page[1].splitlines() if line.startswith(("| drop |", "| load |"))]
    assert [[part.strip() for part in line.split("|")[1:4]] for line in told] == [
        ["drop", "masks", "1 of 1 (100.0 %)"], ["drop", "static", "0 of 1 (0.0 %)"], ["load", "masks", "1 of 1 (100.0 %)"],
    ]  # fmt: skip
    assert f"* **load**: {CONDITIONS['load'].about}." in page[1]
    assert "**deep**" not in page[1]


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
