"""The verdict: a table of tests, each with what stays bent of the part, what may, and what stays bent of its original.

A landing or a load is one row. What decides is the permanent set, a length that a caliper reads, and whether the material cracks.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Literal

import msgspec
from msgspec.structs import replace

from mechstyle.records import sentences
from mechstyle.records.recipe import Recipe
from mechstyle.records.simulation import LEAST_GROUNDED, LIKE_ASKED, THICKER, VOLUME_ERROR, Landing, LoadResult, Place, Simulation

Outcome = Literal["HOLDS", "NO WORSE", "FAILS", "UNKNOWN"]
Test = Literal["flat", "nearly flat", "any landing", "load", "published rule"]

MORE_THAN_PLAIN = 0.05
"""What may stay bent beyond what stays bent of the original in the same test [mm]: a tenth of a printed line."""

REPEATS, REPEATS_SHARE = 0.02, 0.1
"""How far the permanent set of a part that is turned, mirrored or meshed again may differ: so much [mm], or this share of it."""

SMEARED = 1.55
"""How many times as much may stay bent of a print whose infill is meshed, sheet by sheet: 0.44 to 1.50 in docs/validation.md."""

LITERAL_REPEATS = 0.15
"""The same share of the largest stress in an element, which the published rule reads."""

MEASURE = 1
"""Counts measures that outcomes rest on; an outcome of another is none."""
OLDER = "it was judged by an older measure, which compared stress: test it again"

_SEVERITY: dict[Outcome, int] = {"HOLDS": 0, "NO WORSE": 1, "UNKNOWN": 2, "FAILS": 3}


class Row(msgspec.Struct, frozen=True, kw_only=True):
    """One test of a part.

    Attributes:
        test: One of `Test`.
        landing, load: Name of the landing or load case; the other is "".
        outcome: HOLDS, NO WORSE or FAILS.
        permanent_set: What stays bent [mm].
        plain_permanent_set: The same of the original in the same test [mm], None if there is none.
        allowed: What may stay bent [mm]: the tolerance, or MORE_THAN_PLAIN above the original's.
        plastic_strain, plain_plastic_strain: Plastic strain in tension, of the part and its original; cracks are where it exceeds
            `elongation`.
        elongation: Elongation at break of the material.
        cracks, collapses: Whether it cracks; whether it comes to no rest under its load.
        carries, most_tried: Times the load that it carries within the tolerance, None for a landing; whether no more was tried.
        where, place: Where it stays bent, [mm] and in words.
        stress, limit: Of the published rule alone: the largest stress in an element and the yield strength [MPa].
        decides: Whether the row counts for the outcome, as every row does.
    """

    test: Test
    landing: str = ""
    load: str = ""
    outcome: Outcome
    permanent_set: float = 0.0
    plain_permanent_set: float | None = None
    allowed: float = 0.0
    plastic_strain: float = 0.0
    plain_plastic_strain: float | None = None
    elongation: float = 0.0
    cracks: bool = False
    collapses: bool = False
    carries: float | None = None
    most_tried: bool = False
    where: Place = (0.0, 0.0, 0.0)
    place: str = ""
    stress: float | None = None
    limit: float | None = None
    decides: bool = True

    @property
    def used(self) -> float:
        """Share of what is allowed that is used, of bend or of strain, whichever is more: above 1 the test fails."""
        if self.stress is not None and self.limit is not None:
            return self.stress / self.limit
        strain = self.plastic_strain / self.strain_limit if self.elongation else 0.0
        used = max(self.permanent_set / self.allowed, strain)
        if self.collapses and self.outcome == "FAILS":  # what gives way later uses less, or no correction could see its effect
            return max(used, 1.0) / min(max(self.carries or 0.0, 1e-6), 0.999)
        return used

    @property
    def severity(self) -> tuple[int, float]:
        """What orders rows, the worst last; of those that hold, "at worst" is said of millimetres, whatever the strain."""
        return _SEVERITY[self.outcome], self.permanent_set if self.outcome == "HOLDS" and self.stress is None else self.used

    @property
    def strain_limit(self) -> float:
        """The elongation at break; none, infinity, where the original cracks as well."""
        return math.inf if (self.plain_plastic_strain or 0.0) > self.elongation else self.elongation

    @property
    def sure(self) -> bool:
        """Whether the same test of the same part meshed again would pass or fail as well."""
        if self.stress is not None and self.limit is not None:
            return abs(math.log(self.limit / self.stress)) > math.log1p(LITERAL_REPEATS)
        near = self.carries is not None and self.outcome != "NO WORSE" and abs(self.carries - 1.0) <= REPEATS_SHARE
        if self.collapses:
            return not near
        bend = not near and abs(self.permanent_set - self.allowed) > max(REPEATS, REPEATS_SHARE * self.allowed)
        limit, margin = self.elongation, REPEATS_SHARE * self.elongation
        strain = abs(self.plastic_strain - limit) > margin
        if self.strain_limit > limit:  # what excuses a crack is that of the original, which must be sure
            strain = self.plastic_strain < limit - margin or (self.plain_plastic_strain or 0.0) > limit + margin
        if self.outcome == "FAILS":  # one sure failure is enough
            return (bend and self.permanent_set > self.allowed) or (strain and self.plastic_strain > self.strain_limit)
        return bend and strain


class Doubt(msgspec.Struct, frozen=True, kw_only=True):
    """A reason why the outcome is not sure.

    Attributes:
        about: `limit`, a test closer to its limit than it repeats; `landings`, of which some were not dropped; `relief`, between
            which the mesh is thicker; `base`, of which it has less on the floor; `volume`, which is another; `pattern`, which is larger
            than asked, so that a finer surface has another relief.
        test, landing, load: The test and its landing or load, "" for all.
        value: Share used of what is allowed, number of landings left out, share of a wall by which the mesh is thicker, share of the
            base that is on the floor, relative error of volume, or times that the pattern is larger.
        of: Of `landings`, how many were asked for.
    """

    about: Literal["limit", "landings", "relief", "base", "volume", "pattern"]
    value: float
    of: int = 0
    test: str = ""
    landing: str = ""
    load: str = ""


class Verdict(msgspec.Struct, frozen=True, kw_only=True):
    """Whether a part survives, test by test.

    Attributes:
        outcome: HOLDS, every test that decides holds; NO WORSE, some only compared with the original; FAILS; or UNKNOWN.
        criterion: `robust` or `paper`.
        fall: Height of the fall asked for [mm].
        tolerance: The most that may stay bent [mm].
        material, strength: Name and yield strength [MPa] of the material.
        style: Short name of the style, "" for a part without one.
        contact_stiffness: Of the published rule alone: stiffness of its penalty floor at each node [N/mm], 0 for a rigid floor.
        printed: How the part is printed inside, in words; "solid" for all of plastic.
        rows: The tests; none where nothing could be tested.
        doubts: Why the outcome is not sure; none if it is.
        failure: Why there is no answer, "" if there is.
        measure: MEASURE of those who judged.

    Example:
        >>> verdict = ms.simulate(ms.load("gallery:drawer_knob"), vertices=500, device="cpu").verdict
        >>> verdict.material, verdict.fall
        ('generic PLA', 1500.0)
    """

    outcome: Outcome
    criterion: str
    fall: float
    tolerance: float = 0.0
    strength: float
    material: str
    style: str = ""
    contact_stiffness: float = 0.0
    printed: str = "solid"
    rows: tuple[Row, ...] = ()
    doubts: tuple[Doubt, ...] = ()
    failure: str = ""
    measure: int = 0

    def __post_init__(self) -> None:
        """What was judged by another measure is no answer."""
        if self.measure != MEASURE:
            for name, value in {"outcome": "UNKNOWN", "rows": (), "doubts": (), "failure": OLDER, "measure": MEASURE}.items():
                msgspec.structs.force_setattr(self, name, value)

    @property
    def passes(self) -> bool:
        """Whether the outcome is HOLDS or NO WORSE."""
        return self.outcome in ("HOLDS", "NO WORSE")

    @property
    def sure(self) -> bool:
        """Whether no doubt is left."""
        return not self.doubts and self.outcome != "UNKNOWN"

    @property
    def deciding(self) -> Row | None:
        """The worst of the rows, None where nothing could be tested."""
        return max(self.rows, key=lambda row: row.severity, default=None)

    def row(self, *, landing: str = "", load: str = "") -> Row | None:
        """The row of a landing or a load, None if there is none."""
        return next((row for row in self.rows if (row.landing, row.load) == (landing, load)), None)

    @property
    def short(self) -> str:
        """The outcome with its fall in a few words, as it stands on a badge."""
        return sentences.short(self)

    @property
    def head(self) -> str:
        """The outcome in one sentence."""
        return sentences.head(self)

    @property
    def doubt(self) -> str:
        """Why the outcome is not sure and what to do, in one sentence; "" if it is sure."""
        return sentences.doubt(self)

    @property
    def words(self) -> str:
        """The outcome, and the doubt if there is one, in sentences."""
        return " ".join(filter(None, (self.head, self.doubt)))


def judge(simulation: Simulation, original: Simulation | None, recipe: Recipe) -> Verdict:
    """Compare what stays bent of a part with the tolerance, and with what stays bent of its original.

    Every landing and load that was asked for decides, the worst of them for all. Under the criterion `paper` the published rule decides.

    Args:
        simulation: The test of the part.
        original: The same test of the unstyled part; None for a part that is tested by itself.
        recipe: What was asked for.
    """
    test, named = recipe.test, 0 < len(recipe.style.prompt) <= 20  # characters that serve as the name of a style
    empty = Verdict(
        outcome="UNKNOWN", criterion=test.criterion, fall=test.height, tolerance=test.tolerance, strength=test.material.yield_strength,
        material=test.material.label, style="" if original is None else recipe.style.prompt if named else "styled",
        contact_stiffness=test.floor, printed=recipe.printed.words, failure=_failure(simulation, original, recipe), measure=MEASURE,
    )  # fmt: skip
    if empty.failure:
        return empty
    landings = (_row(one, None if original is None else original.landing(one.name), recipe) for one in simulation.landings)
    loads = (_row(one, None if original is None else original.load(one.name), recipe) for one in simulation.loads)
    rows = (_published(simulation, recipe),) if test.criterion == "paper" else (*landings, *loads)
    outcome = max((row.outcome for row in rows), key=_SEVERITY.__getitem__)
    return replace(empty, outcome=outcome, rows=rows, doubts=tuple(_doubts(rows, outcome, simulation, original)))


def _failure(simulation: Simulation, original: Simulation | None, recipe: Recipe) -> str:
    """Why nothing can be judged, "" if it can."""
    for part, whose in ((simulation, "the part"), (original, "the original")):
        if part is None:
            continue
        if part.failure:
            return part.failure if part is simulation else f"the original could not be simulated: {part.failure}"
        if not part.landed("flat"):
            return f"{whose} was not dropped"
        tests: tuple[Landing | LoadResult, ...] = (*part.landings, *part.loads)
        for one in tests:
            if not all(math.isfinite(value) and value >= 0.0 for value in (one.permanent_set, one.plastic_strain, one.maximum)):
                return f"what stays bent of {whose} in the test {one.name!r} is not a finite number"
    if original is not None and original.landed("nearly flat") and not simulation.landed("nearly flat"):
        return "the part was not dropped nearly flat"
    missing = (case.name for case in recipe.test.loads if simulation.load(case.name) is None)
    return next((f"the part was not tested under the load {name!r}" for name in missing), "")


def _row(found: Landing | LoadResult, plain: Landing | LoadResult | None, recipe: Recipe) -> Row:
    """The row of a landing or a load, beside the same of the original."""
    tolerance, elongation = recipe.test.tolerance, recipe.test.material.elongation
    (cracks, collapses), (plain_cracks, plain_collapses) = (
        (one is not None and one.plastic_strain > elongation, isinstance(one, LoadResult) and one.collapses) for one in (found, plain)
    )
    row = Row(
        test="load", outcome="FAILS", permanent_set=found.permanent_set, plastic_strain=found.plastic_strain, elongation=elongation,
        allowed=tolerance if plain is None else max(tolerance, plain.permanent_set + MORE_THAN_PLAIN),
        plain_permanent_set=None if plain is None else plain.permanent_set, cracks=cracks, collapses=collapses,
        plain_plastic_strain=None if plain is None else plain.plastic_strain, where=found.where, place=found.place,
    )  # fmt: skip
    outcome: Outcome = "FAILS"
    if found.permanent_set <= tolerance and not cracks and not collapses:
        outcome = "HOLDS"
    elif plain is not None and found.permanent_set <= row.allowed and cracks <= plain_cracks and collapses <= plain_collapses:
        outcome = "NO WORSE"
    if isinstance(found, LoadResult):
        return replace(row, outcome=outcome, load=found.name, carries=found.factor, most_tried=not found.reached)
    return replace(row, outcome=outcome, test=found.way, landing=found.name)


def _published(simulation: Simulation, recipe: Recipe) -> Row:
    """The row of the published rule: the largest stress in an element, flat and under loads, against the yield strength."""
    limit, stress = recipe.test.material.yield_strength, max(simulation.maximum, 1e-9)
    outcome: Outcome = "HOLDS" if stress <= limit else "FAILS"
    return Row(test="published rule", landing=simulation.landings[0].name, outcome=outcome, stress=stress, limit=limit)


def _doubts(rows: Sequence[Row], outcome: Outcome, simulation: Simulation, original: Simulation | None) -> Iterable[Doubt]:
    """Why an outcome is not sure: one sure failure settles it, and what passes may not hide anything."""
    if outcome == "FAILS" and any(row.outcome == "FAILS" and row.sure for row in rows):
        return
    smeared = 1.0 if simulation.plastic_share == 1.0 else SMEARED
    near = (one for one in rows if not one.sure or one.permanent_set <= one.allowed < smeared * one.permanent_set)
    for row in (one for one in near if one.outcome == "FAILS" or outcome != "FAILS"):
        yield Doubt(about="limit", test=row.test, landing=row.landing, load=row.load, value=row.used)
    if outcome == "FAILS":
        return
    asked = {one.name for one in original.landings} if original is not None and rows[0].stress is None else set()
    missing = asked - {one.name for one in simulation.landings}  # a growing relief falls in few of them
    if missing:
        yield Doubt(about="landings", value=float(len(missing)), of=len(asked))
    if not simulation.thicker <= THICKER:
        yield Doubt(about="relief", value=simulation.thicker)
    if not simulation.grounded >= LEAST_GROUNDED:
        yield Doubt(about="base", value=simulation.grounded)
    if not abs(simulation.volume_error) <= VOLUME_ERROR:
        yield Doubt(about="volume", value=simulation.volume_error)
    if simulation.enlarged > LIKE_ASKED:
        yield Doubt(about="pattern", value=simulation.enlarged)
