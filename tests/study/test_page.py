"""The page of a study: made from a table, the same from the same table, and honest about what was not run."""

import itertools

import msgspec
import numpy as np
import pytest
from PIL import Image

from mechstyle.errors import BadInput
from mechstyle.study.cells import Row, Rows
from mechstyle.study.grids import STUDY_CONTROLS, STUDY_SCHEDULES, STYLES
from mechstyle.study.page import SLIPS, write_page
from mechstyle.study.statistics import wilson
from mechstyle.study.tables import read_table, write_table


def study():
    """A formative study, an evaluation and an ablation of three models, their figures drawn at random, once for all."""
    random, rows = np.random.default_rng(4), []
    ways = [("freestyle", "none", "never")]
    ways += [(f"{schedule} × {control}", control, schedule) for schedule, control in itertools.product(STUDY_SCHEDULES, STUDY_CONTROLS)]
    for (part, prompt), (arm, control, schedule) in itertools.product(itertools.product(("hook", "cup", "tray"), STYLES), ways):
        use = float(random.uniform(0.7, 1.6 if arm == "freestyle" else 1.1))
        asked = {"part": part, "prompt": prompt, "arm": arm, "control": control, "schedule": schedule, "recipe": f"{part}{prompt}{arm}"}
        size = {"iterations": 60, "vertices": 6000, "tetrahedra": 9000, "simulations": 3, "kept": 0.9}
        strength = {"as_placed": use, "verdict": "VIABLE" if use <= 1.0 else "FAILS", "literal": use + 0.2}
        loss, seconds = 1.0 + 0.01 * random.normal(), float(random.lognormal(3.0, 0.3))
        rows.append(Row(**asked, **size, **strength, style_loss=loss, cpu_seconds=seconds))
    arms = {"part": "hook", "prompt": "brick", "verdict": "VIABLE", "kept": 0.8, "tetrahedra": 9000}
    return rows + [Row(**arms, arm=arm, recipe=arm) for arm in ("static", "full")]


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    folder = tmp_path_factory.mktemp("page")
    return write_page(study(), folder / "study.md", note="Figures drawn at random."), (folder / "study.md").read_text()


def test_the_page_counts_with_intervals_beside_the_published_figures(page):
    free = [row for row in study() if row.arm == "freestyle"]
    viable = sum(row.viable for row in free)
    low, high = wilson(viable, len(free))
    text = page[1]
    assert f"| the verdict here | {viable} of 18 ({100 * viable / 18:.1f} %) | {100 * low:.1f} to {100 * high:.1f} % |" in text
    assert "25.55 % (46 of 180)" in text
    assert "80.2 %" in text
    assert SLIPS in text
    assert "Figures drawn at random." in text


def test_tests_are_told_with_what_they_rest_on(page):
    text = page[1]
    counted = ("Cochran's Q over 18 blocks", "18 pairs, exact McNemar after Holm", "Friedman over 18 blocks")
    for words in (*counted, "Welch: F(3, ", "Games–Howell p"):
        assert words in text
    assert text.count("shown, p") == 12


def test_runs_of_another_depth_are_no_partners(page, tmp_path):
    """Free runs twice as deep, which would stand for those as deep as the fed ones."""
    deep = {"amplitude": 0.5, "style_loss": 9.0, "verdict": "FAILS"}
    deeper = [msgspec.structs.replace(row, **deep, recipe=f"deep {row.recipe}") for row in study() if row.arm == "freestyle"]
    write_page([*study(), *deeper], tmp_path / "study.md")
    alike, both = (told[told.index("## Style loss") :] for told in (page[1], (tmp_path / "study.md").read_text()))
    assert both[: both.index("![")] == alike[: alike.index("![")]


def test_a_part_that_was_also_run_coarsely_counts_once_in_the_style_alone(page, tmp_path):
    """Coarser runs stand beside the ways that were run as coarse: pairs and their tests are of one surface."""
    coarse = [msgspec.structs.replace(row, vertices=2000, recipe=f"{row.recipe}!", verdict="VIABLE") for row in study()[:13]]
    write_page(study() + coarse, tmp_path / "two.md")
    counted = [line for line in page[1].splitlines() if line.startswith(("| the verdict here", "| viable, freestyle"))]
    assert len(counted) == 2
    assert set(counted) <= set((tmp_path / "two.md").read_text().splitlines())
    assert "19 pairs, exact McNemar" in (tmp_path / "two.md").read_text()


def test_what_was_run_is_told_in_words(tmp_path):
    write_page(study()[:-2], tmp_path / "one.md")
    assert "60 iterations, 6000 vertices, 9000 tetrahedra, one seed, " in (tmp_path / "one.md").read_text()
    coarse = [msgspec.structs.replace(row, vertices=2000, iterations=40, seed=7, recipe=f"{row.recipe}!") for row in study()[:13]]
    write_page(study()[:-2] + coarse, tmp_path / "two.md")
    assert "40 or 60 iterations, 2000 or 6000 vertices, 9000 tetrahedra, 2 seeds, " in (tmp_path / "two.md").read_text()


def test_a_number_below_one_that_fails_is_explained_beside_its_figure(page):
    assert "Numbers are the stress as placed over its limit; ✗ beside one below 1: another landing fails." in page[1]


def test_processor_time_is_that_of_runs_without_a_gpu(page, tmp_path):
    """On a GPU the processor waits: twice as many runs there, ten times as fast, change nothing."""
    rows = [msgspec.structs.replace(row, device="cpu") for row in study()]
    there = [msgspec.structs.replace(row, device="cuda:0", part=f"{row.part} {copy}", cpu_seconds=0.1 * row.cpu_seconds)
             for row in rows for copy in (2, 3)]  # fmt: skip
    there[5] = msgspec.structs.replace(there[5], device="cpu", cpu_seconds=1e4)  # a way that was filled in, for it took too long there
    write_page([*rows, *there], tmp_path / "study.md")
    alike, both = (told[told.index("## Time") : told.index("## Style loss")] for told in (page[1], (tmp_path / "study.md").read_text()))
    assert "says little; of the 216 runs of 648 whose part and style were simulated without a GPU in every way.\n" in both
    assert both[both.index("|") :] == alike[alike.index("|") :]


def test_the_style_alone_is_told_style_by_style(page):
    told = [row for row in study() if row.arm == "freestyle" and row.prompt == "cactus"]
    viable = sum(row.viable for row in told)
    assert f"| cactus | {viable} of 3 ({100 * viable / 3:.1f} %) |" in page[1]
    assert f" | {np.median([row.as_placed for row in told]):.2f} |\n" in page[1]


def test_every_figure_is_there_and_is_a_picture(page):
    files, text = page
    names = {"freestyle", "viable", "time", "loss", "arms", "kept"}
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


def test_too_little_is_told_and_not_tested(tmp_path):
    rows = [row for row in study() if row.part == "hook" and row.prompt in STYLES[:2]]
    write_page([*rows, rows[0]], tmp_path / "few.md")
    text = (tmp_path / "few.md").read_text()
    assert "2 blocks of part and style have every way: too few for a test" in text
    assert "McNemar" not in text
    assert "## Style loss" not in text


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


def test_a_table_comes_back_as_it_was_also_as_parquet(tmp_path, monkeypatch):
    rows = study()[:20]
    monkeypatch.setattr("mechstyle.study.tables._pyarrow", lambda: None)
    assert read_table(write_table(rows, tmp_path / "plain")) == rows
    (tmp_path / "table.parquet").write_bytes(b"PAR1")
    with pytest.raises(BadInput, match="needs pyarrow"):
        read_table(tmp_path / "table.parquet")
    monkeypatch.undo()
    pytest.importorskip("pyarrow")
    written = write_table(rows, tmp_path / "table")
    assert written.suffix == ".parquet"
    assert read_table(written) == rows
