"""Statistics against published worked examples and computations of their own."""

import numpy as np
import pytest
from scipy import stats

from mechstyle.study.statistics import (
    bootstrap_over,
    cochran,
    friedman,
    games_howell,
    holm,
    mcnemar,
    welch_anova,
    wilson,
)


def test_the_interval_of_wilson_is_that_of_the_formula_and_leaves_room_below_all():
    count, total, z = 46, 180, stats.norm.ppf(0.975)
    share = count / total
    middle = (share + z**2 / (2 * total)) / (1 + z**2 / total)
    reach = z / (1 + z**2 / total) * np.sqrt(share * (1 - share) / total + z**2 / (4 * total**2))
    assert wilson(count, total) == pytest.approx((middle - reach, middle + reach))
    assert wilson(180, 180) == pytest.approx((180 / (180 + z**2), 1.0))
    assert wilson(81, 263) == pytest.approx((0.2553, 0.3662), abs=5e-5)  # Newcombe 1998, table I, method 3
    assert wilson(15, 148) == pytest.approx((0.0624, 0.1605), abs=5e-5)  # the same


def test_welch_with_two_groups_is_the_square_of_his_t_test():
    one, other = [3.1, 4.0, 5.2, 4.4, 3.8], [6.5, 9.1, 4.9, 8.8, 7.7, 5.1]
    found = welch_anova([one, other])
    student = stats.ttest_ind(one, other, equal_var=False)
    assert (found.statistic, found.p, found.within) == pytest.approx((student.statistic**2, student.pvalue, student.df))
    assert found.between == 1.0


def test_welch_is_worked_out_by_his_formula():
    groups = [np.array(group) for group in ([12.0, 15.0, 11.0, 14.0], [20.0, 28.0, 22.0, 30.0, 25.0], [13.0, 12.5, 13.4])]
    sizes, means, weights = (np.array([f(g) for g in groups]) for f in (len, np.mean, lambda g: len(g) / g.var(ddof=1)))
    grand = weights @ means / weights.sum()
    lost = ((1 - weights / weights.sum()) ** 2 / (sizes - 1)).sum()
    f = (weights @ (means - grand) ** 2 / 2) / (1 + 2 * 1 / 8 * lost)
    found = welch_anova(groups)
    assert (found.statistic, found.within) == pytest.approx((f, 8 / (3 * lost)))
    assert found.p == pytest.approx(stats.f.sf(f, 2, 8 / (3 * lost)))
    assert welch_anova([[1.0, 1.0], [2.0, 3.0]]) is None
    assert welch_anova([[1.0, 2.0]]) is None


def test_games_and_howell_is_worked_out_with_the_studentized_range():
    groups = {"a": [24.5, 23.5, 26.4, 27.1, 29.9], "b": [28.4, 34.2, 29.5, 32.2, 30.1], "c": [26.1, 28.3, 24.3, 26.2, 27.8]}
    found = {(pair.first, pair.second): pair for pair in games_howell(groups)}
    one, other = np.array(groups["a"]), np.array(groups["b"])
    a, b = one.var(ddof=1) / 5, other.var(ddof=1) / 5
    freedom = (a + b) ** 2 / (a**2 / 4 + b**2 / 4)
    q = abs(one.mean() - other.mean()) / np.sqrt((a + b) / 2)
    pair = found["a", "b"]
    assert (pair.difference, pair.p) == pytest.approx((one.mean() - other.mean(), stats.studentized_range.sf(q, 3, freedom)), rel=1e-6)
    assert pair.low < pair.difference < pair.high < 0.0
    assert len(found) == 3
    assert games_howell({"a": [1.0, 1.0], "b": [1.0, 2.0]}) == []


def test_mcnemar_counts_only_what_changed():
    before = [True] * 10 + [False] * 10
    after = [True] * 9 + [False] + [True] * 6 + [False] * 4  # one lost, six gained
    assert mcnemar(before, after) == pytest.approx(2 * (1 + 7) / 2**7)  # P(at most 1 of 7), both tails
    assert mcnemar(before, before) == 1.0


def test_cochran_is_mcnemar_without_correction_for_two_treatments():
    table = np.array([[1, 0]] * 8 + [[0, 1]] * 2 + [[1, 1]] * 5)
    q, p = cochran(table)
    assert (q, p) == pytest.approx(((8 - 2) ** 2 / (8 + 2), stats.chi2.sf(3.6, 1)))
    assert cochran(np.ones((5, 3))) is None


def test_cochran_is_the_permutation_statistic_of_friedman_on_two_values():
    table = np.random.default_rng(3).integers(0, 2, (25, 4))
    assert cochran(table)[0] == pytest.approx(friedman(table)[0])  # ranks of two values, with Friedman's correction for ties


def test_friedman_says_nothing_where_nothing_differs():
    assert friedman(np.ones((6, 3))) is None
    assert friedman([[1.0, 2.0]]) is None


def test_holm_steps_down_and_keeps_the_order():
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert holm([]) == []


def test_a_bootstrap_over_models_is_wider_than_one_over_runs():
    values = np.repeat([0.0, 1.0, 0.0, 1.0, 1.0, 0.0], 30)  # runs of a model agree
    models = np.repeat(list("abcdef"), 30)
    low, high = bootstrap_over(models, values, resamples=800)
    alone = bootstrap_over([str(k) for k in range(180)], values, resamples=800)
    assert low < 0.2
    assert high > 0.8
    assert alone[1] - alone[0] < 0.2
    assert bootstrap_over(models, values, resamples=800) == (low, high)
