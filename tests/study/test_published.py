"""The published study again: what is run, how it is counted, and the tests the published figures are drawn with."""

import numpy as np
import pytest
from scipy import stats

from benchmarks.study.cells import Row, meshed
from benchmarks.study.grids import FLOORS, MOVED, NAMED, cells_of
from benchmarks.study.published import PARTS, factors_of, floors_of, games_howell, page, shares, viable, welch
from mechstyle.geometry.remeshing import filling
from mechstyle.simulation import part


def reading(stress, arm="freestyle", floors=(), **changes):
    return Row(part="vase", prompt="brick", arm=arm, stress=stress, strength=45.6, kept=1.0, floors=floors, **changes)


def asked(name, **changes):
    return cells_of(PARTS[name].study, factors_of(name, ["vase"], ["brick"], **changes))


def test_every_cell_is_judged_by_the_published_rule_on_its_floor():
    cells = [cell for name in PARTS for cell in asked(name, tetrahedra=28_000)]
    assert {cell.recipe.test.criterion for cell in cells} == {"paper"}
    assert all(cell.recipe.test.floor > 0.0 for cell in cells)
    assert {cell.tetrahedra for cell in asked("free", tetrahedra=28_000)} == {28_000}


def test_the_floor_is_calibrated_on_the_two_cells_that_are_described_and_on_no_share():
    cells = asked("calibration")
    assert [(cell.part, cell.recipe.style.prompt) for cell in cells] == list(NAMED)
    assert {cell.floors for cell in cells} == {FLOORS}


def test_what_moves_the_share_is_moved_one_thing_at_a_time():
    cells = asked("sensitivity", tetrahedra=28_000)
    first = cells[0].recipe.settings
    for cell in cells[1 : len(MOVED)]:
        differs = {name for name, value in cell.recipe.settings.items() if value != first[name]}
        assert differs == set(MOVED[cell.arm])
    assert all(cell.recipe == cells[0].recipe for cell in cells[len(MOVED) :])
    assert len({cell.key for cell in cells}) == len(cells)


def test_the_yield_strength_itself_is_viable_and_what_broke_down_is_not():
    rows = [reading(45.6), reading(45.7), reading(None), reading(20.0, floors=((10.0, 9.0, 8.0), (0.0, np.inf, 50.0)))]
    assert viable(rows) == (2, 3)
    assert viable(rows, 10.0) == (1, 1)
    assert viable(rows, 0.0) == (0, 1)
    assert "| rigid | 0 of 1 (0.0%) | inf | 50.0 |" in floors_of(rows)
    assert "| free | 2 of 3 (66.7%) |" in shares({"free": rows})


def test_games_and_howell_is_that_of_the_formula():
    draw = np.random.default_rng(0)
    groups = {name: draw.normal(mean, spread, count) for name, mean, spread, count in (("a", 0, 1, 9), ("b", 1, 3, 14), ("c", 2, 1, 6))}
    of = {name: (values.mean(), values.var(ddof=1) / len(values), len(values) - 1) for name, values in groups.items()}
    for one, other, difference, p in games_howell(groups):
        (mean, error, freedom), (mean_2, error_2, freedom_2) = of[one], of[other]
        welch_df = (error + error_2) ** 2 / (error**2 / freedom + error_2**2 / freedom_2)
        q = abs(mean - mean_2) / np.sqrt(0.5 * (error + error_2))
        assert difference == pytest.approx(mean - mean_2)
        assert p == pytest.approx(stats.studentized_range.sf(q, 3, welch_df), abs=1e-9)
    two = [groups["a"], groups["b"]]
    assert welch(dict(zip("ab", two, strict=True)))[1] == pytest.approx(stats.ttest_ind(*two, equal_var=False).pvalue)
    assert np.isnan(welch({"a": [1.0, 1.0], "b": [2.0, 3.0]})[0]), "of values that are all alike there is no test"


def test_a_mesh_of_another_size_is_that_of_the_cell_alone():
    usual = part.TETS, filling.KEPT
    with meshed(28_000):
        assert (part.TETS, filling.KEPT) == (28_000, (24_000,))
    with meshed(0):
        assert usual == (part.TETS, filling.KEPT)
    assert usual == (part.TETS, filling.KEPT)


def test_the_page_names_what_did_not_run_and_tests_the_ways():
    times = iter(np.random.default_rng(0).uniform(10.0, 20.0, 8))
    ways = [
        reading(40.0, f"{when} × linear", control="linear", schedule=when, seconds=next(times), style_loss=next(times))
        for when in ("every", "stress") for _ in range(2)
    ]  # fmt: skip
    text = "\n".join(page({"ways": [*ways, reading(None, status="refused", refused="no such part")]}))
    assert "4 of 5 runs" in text
    assert "refused, no such part" in text
    assert "Welch: F = " in text
    assert "| every | stress |" in text
