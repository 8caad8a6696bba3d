"""The criterion: stress averaged over a fixed physical radius, its measures, and the verdict in words.

Point contact is singular: the element maximum grows without bound as the mesh is refined, and even the unstylized part
exceeds yield there. The volume average over a ball of fixed radius converges (the volume method of the theory of critical
distances, Taylor 2007), so it is what drives the mask and what decides.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import coo_array, csr_array
from scipy.spatial import cKDTree

from mechstyle.errors import unknown
from mechstyle.fea.elements import GAUSS_A, GAUSS_B
from mechstyle.records import CRITERIA, Judgement, Measures, Outcome, Simulation, Verdict
from mechstyle.records.material import Material
from mechstyle.records.mesh import Floats, TetMesh

ALL_ORIENTATIONS_LIMIT = 1.10
"""Growth of the 99th percentile over all orientations that counts as unharmed; re-meshing alone changes it by 1 to 5 %."""

STRESS_BAND = 0.15
"""Relative distance to a stress limit below which a verdict is MARGINAL: what re-meshing changes a peak by."""

RATIO_BAND = 0.05
"""The same for the percentile relative to the original."""

_SEVERITY: dict[Outcome, int] = {"VIABLE": 0, "UNKNOWN": 1, "FAILS": 2}


ENOUGH = 8
"""Tetrahedra in the ball, on average, from which their means are points enough to average over."""

NEAR_CORNERS, NEAR_FACES = np.full((4, 4), GAUSS_B) + (GAUSS_A - GAUSS_B) * np.eye(4), np.full((4, 4), 7 / 24) - np.eye(4) / 6
SUB_POINTS = np.concatenate([NEAR_CORNERS, NEAR_FACES])
"""Barycentric coordinates of eight points that stand for an eighth of a tetrahedron each: the Gauss points and four between them, so
that nothing is extrapolated, shape [8, 4]."""


class BallAverage:
    """Volume average over what lies within `radius` [mm], as a sparse operator.

    A tetrahedron is taken as eight points, between which the stress is linear, or, where the mesh is fine, as one.
    Neighbours are those of the mesh given here, the undeformed one; weights are the volumes of the mesh averaged on, so
    that the operator serves every morph of that mesh.
    """

    def __init__(self, tets: TetMesh, radius: float = 2.0) -> None:
        in_ball = 4.0 / 3.0 * math.pi * radius**3 * len(tets.tets) / float(tets.volumes.sum())
        self.radius = radius
        self.coordinates = SUB_POINTS if in_ball < ENOUGH else np.full((1, 4), 0.25)
        points = self.points(tets).reshape(-1, 3)
        pairs = cKDTree(points).query_pairs(radius, output_type="ndarray").astype(np.int32)
        itself = np.arange(len(points), dtype=np.int32)
        rows = np.concatenate([pairs[:, 0], pairs[:, 1], itself])
        columns = np.concatenate([pairs[:, 1], pairs[:, 0], itself])
        self._near: csr_array = coo_array((np.ones(len(rows), dtype=np.float32), (rows, columns)), shape=(len(points),) * 2).tocsr()

    def points(self, tets: TetMesh) -> Floats:
        """The points averages are taken at [mm], shape [tet_count, sub_points, 3]."""
        return np.einsum("sk,nkx->nsx", self.coordinates, tets.vertices[tets.tets])

    def __call__(self, tets: TetMesh, values: ArrayLike) -> Floats:
        """Averages of `values` at the Gauss points, shape [tet_count, points], over `tets`, a morph of the mesh the operator was made for.

        Returns:
            Averages around the sub-points, shape [tet_count, sub_points].
        """
        at_points = np.asarray(values, dtype=np.float64) @ self._from_gauss(np.shape(values)[1]).T
        weights = np.repeat(tets.volumes, len(self.coordinates))
        return np.asarray((self._near @ (weights * at_points.ravel())) / (self._near @ weights)).reshape(at_points.shape)

    def _from_gauss(self, points: int) -> Floats:
        """Linear interpolation from Gauss points to sub-points, shape [sub_points, points]."""
        if points == 1:
            return np.ones((len(self.coordinates), 1))
        return np.asarray(self.coordinates @ np.linalg.inv(NEAR_CORNERS))


def robust_field(tets: TetMesh, von_mises: ArrayLike, average: BallAverage) -> Floats:
    """Largest average in the tetrahedra around each vertex [MPa], shape [vertex_count].

    The field that drives the mask and the verdict that decides must be the same field, or the mask sleeps while the
    verdict fails; hence the maximum, not another mean. Its own maximum is `Measures.peak`.
    """
    averaged = average(tets, von_mises).max(axis=1)
    field = np.zeros(len(tets.vertices))
    np.maximum.at(field, tets.tets.ravel(), np.repeat(averaged, 4))
    return field


def exceedance(fields: ArrayLike, weights: ArrayLike, allowable: float) -> Floats:
    """Probability that a random drop takes the stress beyond what is allowed, place by place (Langlois et al. 2016).

    Args:
        fields: Stress in each orientation [MPa], shape [orientations, ...].
        weights: Probability of each orientation, shape [orientations].
        allowable: What the stress may at most be [MPa].

    Returns:
        Probabilities, shape [...].
    """
    beyond = np.asarray(fields, dtype=np.float64) > allowable
    return np.asarray(np.einsum("o,o...->...", np.asarray(weights), beyond.astype(np.float64)))


def percentile(values: ArrayLike, weights: ArrayLike, share: float) -> float:
    """Value below which the given share of the weight lies, linear between the values' cumulative weights."""
    values, weights = np.asarray(values, dtype=np.float64), np.asarray(weights, dtype=np.float64)
    order = np.argsort(values, kind="stable")
    below = np.cumsum(weights[order])
    return float(np.interp(share * below[-1], below, values[order]))


def measures(tets: TetMesh, von_mises: ArrayLike, average: BallAverage) -> Measures:
    """Peak average, volume-weighted percentiles and literal maximum of one stress field [MPa], shape [tet_count, points]."""
    stress = np.asarray(von_mises, dtype=np.float64)
    weights = np.repeat(tets.volumes, stress.shape[1])
    averaged = average(tets, stress)
    highest = np.unravel_index(np.argmax(averaged), averaged.shape)
    x, y, z = average.points(tets)[highest]
    return Measures(
        peak=float(averaged[highest]),
        p999=percentile(stress.ravel(), weights, 0.999),
        p99=percentile(stress.ravel(), weights, 0.99),
        maximum=float(stress.max()),
        where=(float(x), float(y), float(z)),
        volume=float(tets.volumes.sum()),
    )


def judge(simulation: Simulation, baseline: Simulation, material: Material, criterion: str) -> Verdict:
    """Whether a part survives, under the criterion `robust` or `paper`.

    (A) as placed: peak ≤ max(S_yield, the original's own peak). (B) all orientations: 99th percentile of the envelope at
    most ALL_ORIENTATIONS_LIMIT times the original's. The literal published rule, maximum ≤ S_yield, is always shown.
    `robust` is the worse of A and B, `paper` the literal rule. What was not computed, or not to a finite number, is UNKNOWN.
    """
    if criterion not in CRITERIA:
        raise unknown("criterion", criterion, CRITERIA)
    trouble = _trouble(simulation, baseline)
    as_placed = _as_placed(simulation, baseline, material, trouble)
    spread = _all_orientations(simulation, baseline, trouble)
    literal = _judgement(
        "largest element stress as placed ≤ yield strength",
        simulation.as_placed.maximum, material.yield_strength, "MPa", STRESS_BAND, trouble,
    )
    place = f" at {_place(simulation)}"
    situation = _situation(simulation)
    counting = [(as_placed, _stress_clause(f"{situation} its peak stress", as_placed, place, baseline, material))]
    if spread is not None:
        clause = f"in all orientations {spread.value:.2f} times the original's stress, {_side(spread)} the limit of {spread.limit:.2f}"
        counting.append((spread, clause))
    if criterion == "paper":
        worst = "dropped as placed or under its loads" if simulation.loaded else "dropped as placed"
        counting = [(literal, _stress_clause(f"{worst} its largest element stress", literal, "", baseline, material))]
    outcome = max((judgement.outcome for judgement, _ in counting), key=_SEVERITY.__getitem__)
    doubt = ", MARGINAL" if any(judgement.marginal for judgement, _ in counting) else ""
    words = f"UNKNOWN: {trouble}." if trouble else f"{outcome}{doubt}: {'; '.join(clause for _, clause in counting)}."
    return Verdict(outcome=outcome, criterion=criterion, as_placed=as_placed, all_orientations=spread, literal=literal, words=words)


def input_warning(baseline: Simulation, material: Material) -> str:
    """One sentence if the unstylized part itself exceeds yield as placed or could not be tested, "" otherwise."""
    trouble = _trouble(baseline, baseline)
    if trouble:
        return f"The unstylized part could not be judged: {trouble}."
    peak = baseline.as_placed.peak
    if peak <= material.yield_strength:
        return ""
    when = f"under the load {baseline.governing!r}" if baseline.governing else "when dropped as placed"
    return (
        f"The unstylized part itself reaches {peak:.1f} MPa at {_place(baseline)} {when}, above the"
        f" {material.yield_strength:.1f} MPa yield strength of {material.name}; the style is held to that peak instead."
    )


def _trouble(simulation: Simulation, baseline: Simulation) -> str:
    """Why nothing can be judged, "" if it can."""
    for part, name in ((simulation, "the part"), (baseline, "the original")):
        if part.failure:
            return part.failure if part is simulation else f"the original could not be simulated: {part.failure}"
        for drop, which in ((part.as_placed, "as placed"), (part.overall, "in all orientations")):
            if drop is not None and not all(map(math.isfinite, (drop.peak, drop.p999, drop.p99, drop.maximum))):
                return f"the stress of {name} {which} is not a finite number"
    if simulation.overall is not None and (baseline.overall is None or baseline.overall.p99 <= 0.0):
        return "the original was not dropped in all orientations, so there is nothing to compare with"
    return ""


def _judgement(rule: str, value: float, limit: float, unit: str, band: float, trouble: str) -> Judgement:
    """Compare a value with a limit; 0 stands for a value that is not known, because records hold finite numbers only."""
    if trouble:
        return Judgement(rule=rule, outcome="UNKNOWN", value=0.0, limit=limit if math.isfinite(limit) else 0.0, unit=unit, marginal=False)
    marginal = abs(value - limit) <= band * limit
    return Judgement(rule=rule, outcome="VIABLE" if value <= limit else "FAILS", value=value, limit=limit, unit=unit, marginal=marginal)


def _as_placed(simulation: Simulation, baseline: Simulation, material: Material, trouble: str) -> Judgement:
    """Rule (A); MARGINAL also where 99.9th percentile and peak disagree about the limit."""
    own = baseline.as_placed.peak
    # Of a baseline without a finite peak only the yield strength is left; the outcome is UNKNOWN then anyway.
    limit = max(material.yield_strength, own) if math.isfinite(own) else material.yield_strength
    rule = "peak 2 mm average as placed ≤ " + ("yield strength" if limit == material.yield_strength else "the original's own peak")
    judged = _judgement(rule, simulation.as_placed.peak, limit, "MPa", STRESS_BAND, trouble)
    disagree = (simulation.as_placed.p999 <= limit) != (simulation.as_placed.peak <= limit)
    return Judgement(
        rule=judged.rule, outcome=judged.outcome, value=judged.value, limit=judged.limit, unit=judged.unit,
        marginal=judged.outcome != "UNKNOWN" and (judged.marginal or disagree),
    )


def _all_orientations(simulation: Simulation, baseline: Simulation, trouble: str) -> Judgement | None:
    """Rule (B), None if only one orientation was dropped."""
    if simulation.overall is None:
        return None
    rule = "99th percentile over all orientations relative to the original"
    ratio = 0.0 if trouble or baseline.overall is None else simulation.overall.p99 / baseline.overall.p99
    return _judgement(rule, ratio, ALL_ORIENTATIONS_LIMIT, "x the original", RATIO_BAND, trouble)


def _place(simulation: Simulation) -> str:
    """The place of the peak, in words."""
    x, y, z = simulation.as_placed.where
    return f"({x:.1f}, {y:.1f}, {z:.1f}) mm"


def _situation(simulation: Simulation) -> str:
    """The load that causes the deciding peak, in words: the drop as placed or a load case."""
    if simulation.governing:
        return f"under the load {simulation.governing!r}"
    return "dropped as placed, which is worse than any load," if simulation.loaded else "dropped as placed"


def _side(judgement: Judgement) -> str:
    """On which side of its limit a value lies, and whether that is sure."""
    return ("within" if judgement.outcome == "VIABLE" else "above") + (" (MARGINAL)" if judgement.marginal else "")


def _stress_clause(what: str, judgement: Judgement, place: str, baseline: Simulation, material: Material) -> str:
    """A judgement on a stress in words."""
    limit = f"the yield strength of {material.yield_strength:.1f} MPa"
    if judgement.limit > material.yield_strength:
        limit = f"the original's own peak of {baseline.as_placed.peak:.1f} MPa, which itself exceeds {limit}"
    return f"{what} is {judgement.value:.1f} MPa{place}, {_side(judgement)} {limit}"
