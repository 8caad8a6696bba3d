"""Statistics of a study, with SciPy: intervals, the published tests, tests that respect that runs come in blocks, and equivalence."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import stats

Floats = NDArray[np.float64]


def wilson(count: int, total: int) -> tuple[float, float]:
    """Wilson's score interval of a proportion at 95 % (Wilson 1927)."""
    found = stats.binomtest(count, total).proportion_ci(0.95, method="wilson")
    return float(found.low), float(found.high)


@dataclass(frozen=True)
class Welch:
    """Welch's analysis of variance (Welch 1951), which does not ask for equal variances.

    Attributes:
        statistic: F.
        between, within: Degrees of freedom.
        p: Its probability if all means are equal.
    """

    statistic: float
    between: float
    within: float
    p: float


def welch_anova(groups: Sequence[ArrayLike]) -> Welch | None:
    """Whether the means of groups differ; None where a group has no spread, fewer than two values, or there is but one group."""
    samples = [np.asarray(group, dtype=np.float64) for group in groups]
    if len(samples) < 2 or any(len(sample) < 2 or np.ptp(sample) == 0.0 for sample in samples):
        return None
    found = stats.f_oneway(*samples, equal_var=False)
    weights = np.array([len(sample) / sample.var(ddof=1) for sample in samples])
    lost = sum((1 - weight / weights.sum()) ** 2 / (len(sample) - 1) for weight, sample in zip(weights, samples, strict=True))
    return Welch(float(found.statistic), len(samples) - 1.0, float((len(samples) ** 2 - 1) / (3 * lost)), float(found.pvalue))


@dataclass(frozen=True)
class Pairwise:
    """Two groups compared.

    Attributes:
        first, second: Their names.
        difference: Mean of the first less that of the second.
        low, high: Its 95 % interval, for all pairs together.
        p: Probability of such a difference if there is none, for all pairs together.
    """

    first: str
    second: str
    difference: float
    low: float
    high: float
    p: float


def games_howell(groups: Mapping[str, ArrayLike]) -> list[Pairwise]:
    """Every pair of groups by Games and Howell (1976), which does not ask for equal variances; groups without spread are left out."""
    samples = {name: np.asarray(group, dtype=np.float64) for name, group in groups.items()}
    samples = {name: sample for name, sample in samples.items() if len(sample) > 1 and np.ptp(sample) > 0.0}
    if len(samples) < 2:
        return []
    found = stats.tukey_hsd(*samples.values(), equal_var=False)
    interval = found.confidence_interval(0.95)
    return [
        Pairwise(one, other, *(float(values[i, j]) for values in (found.statistic, interval.low, interval.high, found.pvalue)))
        for (i, one), (j, other) in combinations(enumerate(samples), 2)
    ]


def mcnemar(first: ArrayLike, second: ArrayLike) -> float:
    """Exact McNemar test of two yes-or-no outcomes of the same cases: probability of so lopsided a change; 1 if nothing changed."""
    one, other = np.asarray(first, dtype=bool), np.asarray(second, dtype=bool)
    only_one, only_other = int((one & ~other).sum()), int((other & ~one).sum())
    changed = only_one + only_other
    return 1.0 if changed == 0 else float(stats.binomtest(only_one, changed, 0.5).pvalue)


def cochran(outcomes: ArrayLike) -> tuple[float, float] | None:
    """Cochran's Q (1950) of yes-or-no outcomes, shape [cases, treatments], and its probability; None where no case differs between them."""
    table = np.asarray(outcomes, dtype=np.float64)
    count = table.shape[1]
    columns, rows = table.sum(axis=0), table.sum(axis=1)
    spread = float(count * rows.sum() - (rows**2).sum())
    if spread == 0.0:
        return None
    q = (count - 1) * float(count * (columns**2).sum() - columns.sum() ** 2) / spread
    return q, float(stats.chi2.sf(q, count - 1))


def friedman(blocks: ArrayLike) -> tuple[float, float] | None:
    """Friedman's test of measurements, shape [blocks, treatments]: statistic and probability; None for fewer than three treatments."""
    table = np.asarray(blocks, dtype=np.float64)
    if table.shape[1] < 3 or np.ptp(table, axis=1).max() == 0.0:
        return None
    found = stats.friedmanchisquare(*table.T)
    return float(found.statistic), float(found.pvalue)


def holm(probabilities: Sequence[float]) -> list[float]:
    """Probabilities of several tests, adjusted so that one of them errs no more often than the level says (Holm 1979), in their order."""
    order = np.argsort(probabilities)
    scaled = [min(1.0, (len(order) - rank) * probabilities[place]) for rank, place in enumerate(order)]
    adjusted = np.empty(len(order))
    adjusted[order] = np.maximum.accumulate(scaled)
    return [float(value) for value in adjusted]


def bootstrap_over(clusters: Sequence[str], values: ArrayLike, *, resamples: int = 4000) -> tuple[float, float]:
    """95 % percentile interval of a mean when whole clusters are drawn: runs of one model are not independent of each other."""
    sample, random = np.asarray(values, dtype=np.float64), np.random.default_rng(0)
    names = list(dict.fromkeys(clusters))
    own = [sample[np.array([cluster == name for cluster in clusters])] for name in names]
    found = [np.concatenate([own[k] for k in random.integers(0, len(own), len(own))]).mean() for _ in range(resamples)]
    low, high = np.quantile(found, [0.025, 0.975])
    return float(low), float(high)
