"""The verdict: a table of tests, each with the fall or load the part survives, what is asked of it, and what its original survives.

The measure is σ_V (`fea.stressed_volume`). The height at which it reaches the yield strength is the critical drop height; the factor on a
load at which it does is the load factor.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Literal

import msgspec

from mechstyle.records import sentences
from mechstyle.records.recipe import Recipe
from mechstyle.records.simulation import LEAST_CARRIED, VOLUME_ERROR, WAYS, Landing, Simulation

Outcome = Literal["HOLDS", "NO WORSE", "FAILS", "UNKNOWN"]
Test = Literal["flat", "nearly flat", "load", "any landing", "published rule"]

NO_WORSE = 0.9
"""Share of the original's height or load factor from which a part is no worse than its original.

Also of a landing that is not flat it is taken at the fall asked for, by σ ∝ √h: a critical height far from there repeats worse.
"""

REPEATABILITY: dict[Test, float] = {"flat": 0.03, "nearly flat": 0.03, "load": 0.03, "any landing": 0.03, "published rule": 0.15}
"""Relative change of σ_V, or of the literal maximum, when a part is turned, mirrored or meshed again: `benchmarks/repeatability.py`."""

SHORT = 20
"""Characters of a prompt that serves as the name of its style."""

_SEVERITY: dict[Outcome, int] = {"HOLDS": 0, "NO WORSE": 1, "UNKNOWN": 2, "FAILS": 3}


class Row(msgspec.Struct, frozen=True, kw_only=True):
    """One test of a part.

    Attributes:
        test: One of `Test`.
        outcome: HOLDS, NO WORSE or FAILS.
        landing, load: Name of the landing or load case the figures are of; the other is "".
        stress, limit: σ_V at the fall or load asked for, under the published rule the literal maximum; and the most it may be [MPa].
        height: Critical drop height [mm]; None for a load and the published rule.
        factor: Load factor; of the published rule yield strength over maximum; None for a landing.
        asked: Height of the fall asked for [mm], or 1, the load itself.
        original: Height or factor of the original in the same test, None if there is none.
        decides: Whether the row counts for the outcome.
    """

    test: Test
    outcome: Outcome
    landing: str = ""
    load: str = ""
    stress: float
    limit: float
    height: float | None = None
    factor: float | None = None
    asked: float
    original: float | None = None
    decides: bool

    @property
    def survived(self) -> float:
        """Height [mm] or factor up to which the part survives."""
        return self.height if self.height is not None else self.factor or 0.0

    @property
    def reserve(self) -> float:
        """What is survived over what is needed, at the fall or load asked for: below 1 it fails.

        Of a landing it is (limit / σ_V)², the ratio of heights of a flat impact; of a load limit / σ_V.
        """
        return (self.limit / self.stress) ** (1.0 if self.height is None else 2.0)

    @property
    def sure(self) -> bool:
        """Whether the same test of the same part meshed again would pass or fail as well."""
        return abs(math.log(self.limit / self.stress)) > math.log1p(REPEATABILITY[self.test])


class Doubt(msgspec.Struct, frozen=True, kw_only=True):
    """A reason why the outcome is not sure.

    Attributes:
        about: `limit`, a test closer to its limit than it repeats; `relief`, which the mesh misses; `volume`, which is another.
        test, landing, load: The test and its landing or load, "" for all.
        value: Reserve of the test (see `Row.reserve`), share of the relief that the mesh follows, or relative error of volume.
    """

    about: Literal["limit", "relief", "volume"]
    value: float
    test: str = ""
    landing: str = ""
    load: str = ""


class Verdict(msgspec.Struct, frozen=True, kw_only=True):
    """Whether a part survives, test by test.

    Attributes:
        outcome: HOLDS, every test that decides holds; NO WORSE, some only compared with the original; FAILS; or UNKNOWN.
        criterion: `robust` or `paper`.
        fall: Height of the fall asked for [mm].
        material, strength: Name and yield strength [MPa] of the material.
        style: Short name of the style, "" for a part without one.
        rows: The tests; none where nothing could be tested.
        doubts: Why the outcome is not sure; none if it is.
        failure: Why there is no answer, "" if there is.
    """

    outcome: Outcome
    criterion: str
    fall: float
    strength: float
    material: str
    style: str = ""
    rows: tuple[Row, ...] = ()
    doubts: tuple[Doubt, ...] = ()
    failure: str = ""

    @property
    def passes(self) -> bool:
        """Whether the outcome is HOLDS or NO WORSE."""
        return self.outcome in ("HOLDS", "NO WORSE")

    @property
    def sure(self) -> bool:
        """Whether no doubt is left."""
        return not self.doubts and self.outcome != "UNKNOWN"

    @property
    def settled(self) -> bool:
        """Whether it passes, and in no test so closely that a part meshed again might not."""
        return self.passes and all(row.sure for row in self.rows if row.decides)

    @property
    def deciding(self) -> Row | None:
        """The row with the least reserve of those that decide, None where nothing could be tested."""
        return min((row for row in self.rows if row.decides), key=lambda row: row.reserve, default=None)

    @property
    def published(self) -> Row | None:
        """The row of the published rule, None where nothing could be tested."""
        return self.row("published rule")

    @property
    def safety_factor(self) -> float | None:
        """Least σ_y / σ_V of the rows that decide, None where it is not known; it may be below 1 where the original's is."""
        factors = [self.strength / row.stress for row in self.rows if row.decides and row.stress > 0.0]
        return min(factors, default=None)

    def row(self, test: Test, load: str = "") -> Row | None:
        """The row of a test, None if there is none."""
        return next((row for row in self.rows if row.test == test and row.load == load), None)

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


def judge(simulation: Simulation, original: Simulation | None, recipe: Recipe, reference: Simulation | None = None) -> Verdict:
    """Compare what a part survives with what is asked of it, and with what its original survives.

    Flat and every load decide. Nearly flat decides next to an original, as most plastic parts yield at an edge; so do all other landings
    where more than one was asked for, by their geometric mean. Under the criterion `paper` the published rule decides alone.

    Args:
        simulation: The test of the part.
        original: The same test of the unstyled part; None for a part that is tested by itself.
        recipe: What was asked for.
        reference: The original as it sets the limits, if that is read on more than one mesh.
    """
    test, named = recipe.test, 0 < len(recipe.style.prompt) <= SHORT
    empty = Verdict(
        outcome="UNKNOWN", criterion=test.criterion, fall=test.height, strength=test.material.yield_strength, material=test.material.label,
        style="" if original is None else recipe.style.prompt if named else "styled", failure=_failure(simulation, original, recipe),
    )  # fmt: skip
    if empty.failure:
        return empty
    rows = tuple(_rows(simulation, original, reference or original, recipe))
    counting = [row for row in rows if row.decides]
    outcome = max((row.outcome for row in counting), key=_SEVERITY.__getitem__)
    return msgspec.structs.replace(empty, outcome=outcome, rows=rows, doubts=tuple(_doubts(counting, outcome, simulation)))


def drop_limit(stress: float, strength: float) -> float:
    """What σ_V may at most be in a landing in which the original's is `stress` [MPa]: NO_WORSE of its height, by σ ∝ √h."""
    return max(strength, stress / math.sqrt(NO_WORSE))


def load_limit(stress: float, strength: float) -> float:
    """What σ_V may at most be under a load under which the original's is `stress` [MPa]."""
    return max(strength, stress / NO_WORSE)


def _failure(simulation: Simulation, original: Simulation | None, recipe: Recipe) -> str:
    """Why nothing can be judged, "" if it can."""
    for part, whose in ((simulation, "the part"), (original, "the original")):
        if part is None:
            continue
        if part.failure:
            return part.failure if part is simulation else f"the original could not be simulated: {part.failure}"
        if not part.of("flat"):
            return f"{whose} was not dropped"
        known = {one.name: [one.stress, one.maximum, one.critical_height] for one in part.landings}
        known |= {f"load {case.name}": [case.stress, case.maximum] for case in part.loads}
        for name, values in known.items():
            if not all(math.isfinite(value) and value > 0.0 for value in values):
                return f"the stress of {whose} in the test {name!r} is not a finite number above 0"
    if original is not None and original.of("nearly flat") and not simulation.of("nearly flat"):
        return "the part was not dropped nearly flat"
    missing = (case.name for case in recipe.test.loads if simulation.load(case.name) is None)
    return next((f"the part was not tested under the load {name!r}" for name in missing), "")


def _rows(simulation: Simulation, original: Simulation | None, reference: Simulation | None, recipe: Recipe) -> Iterable[Row]:
    """The rows of all tests that were made of a part."""

    def outcome(stress: float, limit: float) -> Outcome:
        return "HOLDS" if stress <= strength else "NO WORSE" if stress <= limit else "FAILS"

    strength, robust = recipe.test.material.yield_strength, recipe.test.criterion != "paper"
    for test in WAYS:
        parts = ([] if part is None else part.of(test) for part in (simulation, original, reference))
        hardest, theirs, limiting = (_hardest(found, mean=test == "any landing") if found else None for found in parts)
        if hardest is not None:
            limit = strength if limiting is None else drop_limit(limiting.stress, strength)
            yield Row(
                test=test, landing=hardest.name, stress=hardest.stress, limit=limit, height=hardest.critical_height,
                asked=recipe.test.height, original=None if theirs is None else theirs.critical_height,
                outcome=outcome(hardest.stress, limit), decides=robust and (test == "flat" or theirs is not None),
            )  # fmt: skip
    for case in simulation.loads:
        own, sets = (None if part is None else part.load(case.name) for part in (original, reference))
        limit = strength if sets is None else load_limit(sets.stress, strength)
        yield Row(
            test="load", load=case.name, stress=case.stress, limit=limit, factor=strength / case.stress, asked=1.0,
            original=None if own is None else strength / own.stress, outcome=outcome(case.stress, limit), decides=robust,
        )  # fmt: skip
    maximum = simulation.maximum
    yield Row(
        test="published rule", landing=simulation.landings[0].name, stress=maximum, limit=strength, factor=strength / maximum, asked=1.0,
        original=None if original is None else strength / original.maximum, outcome=outcome(maximum, strength),
        decides=not robust,
    )  # fmt: skip


def _hardest(landings: Sequence[Landing], *, mean: bool) -> Landing:
    """The landing with the highest stress, with the geometric means of all if `mean`."""
    hardest = max(landings, key=lambda landing: landing.stress)
    figures = ("stress", "critical_height") if mean else ()
    means = {name: math.exp(sum(math.log(getattr(one, name)) for one in landings) / len(landings)) for name in figures}
    return msgspec.structs.replace(hardest, **means)


def _doubts(rows: Sequence[Row], outcome: Outcome, simulation: Simulation) -> Iterable[Doubt]:
    """Why an outcome is not sure: one sure failure settles it, and what passes may not hide anything."""
    if outcome == "FAILS" and any(row.outcome == "FAILS" and row.sure for row in rows):
        return
    for row in rows:
        if not row.sure and (row.outcome == "FAILS" or outcome != "FAILS"):
            yield Doubt(about="limit", test=row.test, landing=row.landing, load=row.load, value=row.reserve)
    if outcome == "FAILS":
        return
    if not simulation.least_carried >= LEAST_CARRIED:
        yield Doubt(about="relief", value=simulation.least_carried)
    if not abs(simulation.volume_error) <= VOLUME_ERROR:
        yield Doubt(about="volume", value=simulation.volume_error)
