"""A comparison: measured value, reference value and tolerance."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import msgspec

from mechstyle.errors import MissingPiece, unknown


class Result(msgspec.Struct, frozen=True, kw_only=True):
    """One figure of a case.

    Attributes:
        case: Name of the case and, after a colon, of the figure.
        measured: What the simulation gave [unit].
        reference: What it should be [unit].
        error: Their relative distance, or for a bound how far it is overstepped.
        limit: Largest error that passes.
        passed: Whether it does; None if it was not run.
        unit: Unit of measured and reference.
        note: What the reference is, or why it was not run.
    """

    case: str
    measured: float
    reference: float
    error: float
    limit: float
    passed: bool | None
    unit: str = ""
    note: str = ""


def compared(name: str, measured: float, reference: float, limit: float, unit: str = "", note: str = "") -> Result:
    """A figure against a reference: the error is relative; nothing but a finite error within the limit passes."""
    error = abs(measured / reference - 1.0)
    return Result(
        case=name, measured=measured, reference=reference, error=error, limit=limit,
        passed=math.isfinite(error) and error <= limit, unit=unit, note=note,
    )  # fmt: skip


def bounded(name: str, error: float, limit: float, note: str = "") -> Result:
    """A relative error that was computed as such, from fields."""
    passed = math.isfinite(error) and error <= limit
    return Result(case=name, measured=error, reference=0.0, error=error, limit=limit, passed=passed, note=note)


@dataclass(frozen=True)
class Case:
    """A question to the simulation.

    Attributes:
        name: How it is called on the command line.
        title: What is compared with what, for a reader.
        run: Gives the figures; raises MissingPiece if something it needs is not there.
        slow: Whether it takes minutes on two cores.
        fault: What is known to be wrong in the simulation and makes figures of this case fail, "" for nothing.
    """

    name: str
    title: str
    run: Callable[[], Iterator[Result]]
    slow: bool = False
    fault: str = ""

    def results(self) -> list[Result]:
        """The figures, or one that was not run with the reason."""
        try:
            return list(self.run())
        except MissingPiece as reason:
            return [Result(case=self.name, measured=0.0, reference=0.0, error=0.0, limit=0.0, passed=None, note=str(reason))]


def named(name: str, cases: dict[str, Case]) -> Case:
    """The case of a name; BadInput with the nearest names otherwise."""
    if name not in cases:
        raise unknown("case", name, cases)
    return cases[name]
