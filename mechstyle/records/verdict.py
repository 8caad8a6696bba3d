"""The verdict on a part: each rule applied to the measures, and the worst of the rules that count."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import msgspec

Outcome = Literal["VIABLE", "FAILS", "UNKNOWN"]


class Judgement(msgspec.Struct, frozen=True, kw_only=True):
    """One rule applied to one simulation.

    Attributes:
        rule: What was compared, in words.
        outcome: VIABLE, FAILS or UNKNOWN.
        value: The measure [unit].
        limit: What it may at most be [unit].
        unit: "MPa" or "x the original".
        marginal: Whether value and limit are closer than what another mesh of the same part changes.
    """

    rule: str
    outcome: Outcome
    value: float
    limit: float
    unit: str
    marginal: bool

    @property
    def short(self) -> str:
        """Value and limit, as they stand under a picture."""
        return f"{self.value:.0f} of {self.limit:.0f} MPa" if self.unit == "MPa" else f"{self.value:.2f} of {self.limit:.2f} times"

    @property
    def safety_factor(self) -> float:
        """Limit over value; infinite for a value of zero, NaN for NaN."""
        return float("inf") if self.value == 0 else self.limit / self.value


def doubtful(judgements: Sequence[Judgement]) -> bool:
    """Whether another mesh could turn an outcome: where none of them fails clearly, and one is close to its limit."""
    return any(rule.marginal for rule in judgements) and not any(rule.outcome == "FAILS" and not rule.marginal for rule in judgements)


class Verdict(msgspec.Struct, frozen=True, kw_only=True):
    """Whether the part survives, with the figures behind it.

    Attributes:
        outcome: The worst of the judgements that count under the criterion.
        criterion: `robust` or `paper`.
        as_placed: (A) peak stress of the drop as placed.
        all_orientations: (B) envelope over all orientations relative to the unstylized part, None if not run.
        literal: The published rule, max σ_vM ≤ S_yield, always shown, mesh-dependent.
        words: One sentence a person can act on.
        tilted: Surface stress of the drops nearly as placed, None if there was none.
        limits: Of each test as it stands, its load ("" for the drop) and what its stress nearest to a limit may at most be [MPa]; none
            where nothing could be judged, and in records of earlier versions.
    """

    outcome: Outcome
    criterion: str
    as_placed: Judgement
    all_orientations: Judgement | None
    literal: Judgement
    words: str
    tilted: Judgement | None = None
    limits: tuple[tuple[str, float], ...] = ()

    @property
    def each(self) -> tuple[tuple[str, float], ...]:
        """The limits of several tests that count by themselves; none where one limit is all there is, as under the published rule."""
        return self.limits if self.criterion != "paper" and len(self.limits) > 1 else ()

    @property
    def of_the_drop(self) -> float:
        """What the stress of the drop as placed may at most be, whichever test is told [MPa]."""
        return dict(self.each).get("", self.deciding.limit)

    @property
    def counting(self) -> tuple[Judgement, ...]:
        """The judgements that count under the criterion in force."""
        rules = (self.literal,) if self.criterion == "paper" else (self.as_placed, self.tilted, self.all_orientations)
        return tuple(rule for rule in rules if rule is not None)

    @property
    def tightest(self) -> Judgement:
        """The judgement that counts and has the least safety factor."""
        return min(self.counting, key=lambda rule: rule.safety_factor)

    @property
    def safety_factor(self) -> float:
        """The least of the safety factors of the judgements that count."""
        return self.tightest.safety_factor

    @property
    def marginal(self) -> bool:
        """Whether the outcome is not sure; see `doubtful`."""
        return doubtful(self.counting)

    @property
    def word(self) -> str:
        """The outcome in one word: MARGINAL where it is not sure."""
        return "MARGINAL" if self.marginal else self.outcome

    @property
    def told(self) -> str:
        """The outcome as it is told: that it is MARGINAL is told with it."""
        return f"{self.outcome}, MARGINAL" if self.marginal else self.outcome

    @property
    def deciding(self) -> Judgement:
        """The as-placed judgement under the criterion in force; its value is the peak, its limit the allowable stress."""
        return self.literal if self.criterion == "paper" else self.as_placed

    @property
    def viable(self) -> bool:
        """Whether the outcome is VIABLE."""
        return self.outcome == "VIABLE"
