"""The verdict: every rule applied to the measures of a part and its original, the worst of those that count, and both in words."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import msgspec

from mechstyle.errors import unknown
from mechstyle.records import CRITERIA, Judgement, Measures, Outcome, Simulation, Verdict
from mechstyle.records.limits import UNHARMED, Limits, OfTest
from mechstyle.records.material import Material
from mechstyle.records.simulation import LEAST_CARRIED, VOLUME_ERROR
from mechstyle.records.verdict import doubtful

SURFACE_BAND = 0.05
"""Relative distance to a limit below which a surface stress is MARGINAL: what another mesh of the same part changes it by."""

CONTACT_BAND = 0.15
"""The same for the average around a contact and for a literal maximum, which depend more on the mesh."""

RATIO_BAND = 0.05
"""The same for the percentile relative to the original."""

THROUGH = 1.5
"""Elastic surface stress over yield strength at which a rectangular wall in pure bending has yielded through (ASME VIII-2, Pm + Pb)."""

_SEVERITY: dict[Outcome, int] = {"VIABLE": 0, "UNKNOWN": 1, "FAILS": 2}


class _Stress(NamedTuple):
    """A stress of one test of a part as it stands, judged.

    Attributes:
        judgement: It beside its limit.
        test: What the part did in that test.
        before: The same stress of the original [MPa].
        bending: Whether it is the surface's, not that around a contact.
        load: The load case, "" for the drop.
    """

    judgement: Judgement
    test: Measures
    before: float
    bending: bool
    load: str

    @property
    def use(self) -> float:
        """Share of the limit that is used up."""
        return _use(self.judgement)


class Told(NamedTuple):
    """A judgement and the clause that tells it."""

    judgement: Judgement
    clause: str


def judge(simulation: Simulation, baseline: Simulation, material: Material, criterion: str) -> Verdict:
    """Whether a part survives, under the criterion `robust` or `paper`.

    (A) As placed and under each of its loads: the surface stress away from contacts, and the average around them, each at most the yield
    strength or what the original reaches in the same test: what it bears in a drop excuses nothing under a load. (T) Tilted a little:
    the surface stress at most the yield strength or UNHARMED times the original's. (B) All orientations: 99th percentile of the
    envelope at most UNHARMED times the original's. The literal published rule, maximum ≤ S_yield, is always shown. `robust` is the
    worst of A, T and B, `paper` the literal rule. What was not computed, or not to a finite number, is UNKNOWN; what tetrahedra tell
    that do not carry the relief is MARGINAL, and so is what elements too long beside supports and loads may hide.
    """
    if criterion not in CRITERIA:
        raise unknown("criterion", criterion, CRITERIA)
    trouble = _trouble(simulation, baseline)
    limits = Limits.of(baseline, material)
    tests = _tests(simulation, baseline, limits, material, trouble)
    placed = _at_borders(_as_placed(simulation, tests, material), simulation, limits)
    nearly = _tilted(simulation, baseline, limits, material, trouble)
    spread = _all_orientations(simulation, baseline, trouble)
    literal = _literal(simulation, material, trouble)
    hidden = "" if trouble else _hidden(simulation)
    if hidden:
        placed, literal, nearly, spread = _unsure(placed), _unsure(literal), nearly and _unsure(nearly), spread and _unsure(spread)
    counting = [literal] if criterion == "paper" else [told for told in (placed, nearly, spread) if told is not None]
    outcome = max((told.judgement.outcome for told in counting), key=_SEVERITY.__getitem__)
    doubt = ", MARGINAL" if doubtful([told.judgement for told in counting]) else ""
    clauses = [told.clause for told in counting] + ([hidden] if hidden and outcome == "VIABLE" else [])
    told = "; ".join(clauses)
    told += "" if material.label in told else f" ({material.label} yields at {material.yield_strength:.1f} MPa)"
    words = f"UNKNOWN: {trouble}." if trouble else f"{outcome}{doubt}: {told}."
    return Verdict(
        outcome=outcome,
        criterion=criterion,
        as_placed=placed.judgement,
        tilted=nearly and nearly.judgement,
        all_orientations=spread and spread.judgement,
        literal=literal.judgement,
        words=words,
        limits=() if trouble else tuple((test, max(both, key=lambda one: one.use).judgement.limit) for test, both in tests.items()),
    )


def input_warning(baseline: Simulation, material: Material) -> str:
    """One sentence if the unstylized part itself begins to yield as placed, or nearly, or could not be tested; "" otherwise."""
    trouble = _trouble(baseline, baseline)
    if trouble:
        return f"The unstylized part could not be judged: {trouble}."
    peak, strength = baseline.as_placed.peak, material.yield_strength
    if peak <= strength * (1.0 - SURFACE_BAND):
        return ""
    when = _when(baseline.governing)
    reached = f"The unstylized part itself reaches {peak:.1f} MPa at {_place(baseline.as_placed.where)} {when}"
    if peak <= strength:
        return f"{reached}: it is about to yield, whatever the style ({_strength(material)})."
    return f"{reached}, above {_strength(material)}; the style is held to that peak instead."


def _trouble(simulation: Simulation, baseline: Simulation) -> str:
    """Why nothing can be judged, "" if it can."""
    for part, name in ((simulation, "the part"), (baseline, "the original")):
        if part.failure:
            return part.failure if part is simulation else f"the original could not be simulated: {part.failure}"
        loads = ((case.measured, f"under the load {case.name!r}") for case in part.loaded)
        placed = ((part.drop, "as placed"), *loads, (part.as_placed, "as placed"))
        drops = (*placed, (part.tilted, "nearly as placed"), (part.overall, "in all orientations"))
        for drop, which in drops:
            if drop is not None and not all(map(math.isfinite, (drop.surface, drop.contact, drop.p999, drop.p99, drop.maximum))):
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


def _unsure(told: Told) -> Told:
    """The same, but not sure where it is within its limit."""
    judged = told.judgement
    return told._replace(judgement=msgspec.structs.replace(judged, marginal=True)) if judged.outcome == "VIABLE" else told


def _hidden(simulation: Simulation) -> str:
    """Why the tetrahedra may hide stress of the part, "" if they have its shape; shares that are no numbers are not enough."""
    if not simulation.least_carried >= LEAST_CARRIED:
        where = " under the part" if simulation.least_carried < simulation.carried else ""
        return f"its tetrahedra carry only {simulation.least_carried:.0%} of the relief{where}, and may hide stress of the rest"
    if not abs(simulation.volume_error) <= VOLUME_ERROR:
        return f"the volume of its tetrahedra differs by {simulation.volume_error:+.0%} from that of the part, and their stress may, too"
    return ""


def _tests(
    simulation: Simulation, baseline: Simulation, limits: Limits, material: Material, trouble: str
) -> dict[str, list[_Stress]]:
    """What is judged of the drop as placed, "", and under each load, by its name; of what is in trouble the drop stands for all."""
    found = {"": _both("", simulation.drop, baseline.drop, limits.drop, material, trouble)}
    for case in () if trouble else simulation.loaded:
        own, allowed = baseline.load(case.name), limits.under(case.name)
        found[case.name] = _both(case.name, case.measured, own, allowed, material, trouble)
    return found


def _as_placed(simulation: Simulation, tests: Mapping[str, list[_Stress]], material: Material) -> Told:
    """Rule (A), of surface and contact in the drop and under each load the one that is nearest to its limit, as sure as all of them."""
    loads_first = [one for test in sorted(tests, key=lambda load: load == "") for one in tests[test]]
    nearest, *others = sorted(loads_first, key=lambda one: one.use, reverse=True)
    judgement, clause = nearest.judgement, f"{_situation(nearest.load, simulation)} {_stress(nearest, material)}"
    decides = next((one for one in others if _overrules(one.judgement, judgement)), None)
    if decides is not None:
        judgement = msgspec.structs.replace(judgement, marginal=decides.judgement.marginal)
        when = "" if decides.load == nearest.load else f"{_when(decides.load)} "
        clause += f", and {when}{_stress(decides, material)}"
    return Told(judgement, clause)


def _at_borders(told: Told, simulation: Simulation, limits: Limits) -> Told:
    """Rule (A), not sure where a load's stress may be near its limit, or above, where a support or load ends and elements are too long."""
    near = [case for case in simulation.loaded if not case.border < (1.0 - CONTACT_BAND) * limits.under(case.name).surface]
    if not near or told.judgement.outcome != "VIABLE":
        return told
    most = max(near, key=lambda case: case.border)
    read = f"{_when(most.name)} elements where a support or load ends are too long to read its stress there"
    return _unsure(told)._replace(clause=f"{told.clause}, and {read}, which heads for {most.border:.1f} MPa")


def _overrules(other: Judgement, nearest: Judgement) -> bool:
    """Whether a judgement says how sure the outcome is instead of the one nearest to its limit, whose band may be the wider or narrower.

    What fails in its band is sure to fail where another fails beyond its own; what holds is in doubt where another is in its band.
    """
    if nearest.outcome == "FAILS":
        return nearest.marginal and other.outcome == "FAILS" and not other.marginal
    return not nearest.marginal and other.marginal


def _both(load: str, test: Measures, own: Measures | None, limits: OfTest, material: Material, trouble: str) -> list[_Stress]:
    """The stress on the surface and around contacts in one test, beside the original's in that very test."""
    stands = f"under the load {load!r}" if load else "as placed"
    told = (
        ("surface stress", test.surface, limits.surface, SURFACE_BAND, 0.0 if own is None else own.surface),
        ("average around the contact", test.contact, limits.contact, CONTACT_BAND, 0.0 if own is None else own.contact),
    )
    return [
        _Stress(_judgement(_rule(what, stands, limit, material), value, limit, "MPa", band, trouble), test, before, at == 0, load)
        for at, (what, value, limit, band, before) in enumerate(told)
    ]


def _tilted(simulation: Simulation, baseline: Simulation, limits: Limits, material: Material, trouble: str) -> Told | None:
    """Rule (T), None if no landing was tilted or the original was not dropped so."""
    if simulation.tilted is None or baseline.tilted is None:
        return None
    allowed = "yield strength" if limits.tilted <= material.yield_strength else f"{UNHARMED:.2f} times the original's"
    rule, value = f"surface stress tilted by a few degrees ≤ {allowed}", simulation.tilted.surface
    judged = _judgement(rule, value, limits.tilted, "MPa", SURFACE_BAND, trouble)
    where = _place(simulation.tilted.surface_where or simulation.tilted.where)
    clause = f"tilted by a few degrees {value:.1f} MPa at {where}, {_side(judged)} {judged.limit:.1f} MPa"
    return Told(judged, clause + ("" if allowed == "yield strength" else f", {allowed} own {baseline.tilted.surface:.1f} MPa"))


def _all_orientations(simulation: Simulation, baseline: Simulation, trouble: str) -> Told | None:
    """Rule (B), None if not all orientations were dropped."""
    if simulation.overall is None:
        return None
    rule = "99th percentile over all orientations relative to the original"
    ratio = 0.0 if trouble or baseline.overall is None else simulation.overall.p99 / baseline.overall.p99
    judged = _judgement(rule, ratio, UNHARMED, "x the original", RATIO_BAND, trouble)
    return Told(judged, f"in all orientations {ratio:.2f} times the original's stress, {_side(judged)} the limit of {UNHARMED:.2f}")


def _literal(simulation: Simulation, material: Material, trouble: str) -> Told:
    """The published rule."""
    rule, value = "largest element stress as placed ≤ yield strength", simulation.as_placed.maximum
    judged = _judgement(rule, value, material.yield_strength, "MPa", CONTACT_BAND, trouble)
    when = "dropped as placed or under its loads" if simulation.loaded else "dropped as placed"
    return Told(judged, f"{when} its largest element stress is {value:.1f} MPa, {_side(judged)} {_strength(material)}")


def _rule(what: str, when: str, limit: float, material: Material) -> str:
    return f"{what} {when} ≤ " + ("yield strength" if limit <= material.yield_strength else "the original's own")


def _use(judgement: Judgement) -> float:
    """Share of the limit that is used up."""
    return judgement.value / judgement.limit if judgement.limit > 0.0 else 0.0


def _stress(stress: _Stress, material: Material) -> str:
    """A judgement on a stress in words."""
    judgement, test, before, bending, _ = stress
    what, limit = "its surface stress" if bending else "the stress around the contact", _strength(material)
    if judgement.limit > material.yield_strength:
        told = f"the original's own {before:.1f} MPa"
        told += f", which itself exceeds {limit}" if before > material.yield_strength else ""
        limit = told if judgement.limit <= before else f"{judgement.limit:.1f} MPa, {judgement.limit / before:.2f} times {told}"
    where = test.surface_where if bending else test.contact_where
    told = f"{what} is {judgement.value:.1f} MPa at {_place(where or test.where)}, {_side(judgement)} {limit}"
    if before >= (1.0 - SURFACE_BAND) * judgement.limit and judgement.limit <= material.yield_strength:
        told += f", as that of the original, {before:.1f} MPa" if judgement.marginal and judgement.outcome == "VIABLE" else ""
        told += f", of which the original itself bears {before:.1f}" if judgement.outcome == "FAILS" else ""
    if judgement.outcome == "FAILS" and bending:
        told += ": the surface begins to yield there"
        told += f", and a wall yields through at {THROUGH * material.yield_strength:.1f} MPa" if material.ductile else ""
    return told


def _strength(material: Material) -> str:
    """The yield strength of a material, in words."""
    return f"the {material.yield_strength:.1f} MPa at which {material.label} yields"


def _place(where: tuple[float, float, float]) -> str:
    """A place, in words."""
    x, y, z = where
    return f"({x:.1f}, {y:.1f}, {z:.1f}) mm"


def _when(load: str) -> str:
    """A load case by its name, or for "" the drop as placed, in words."""
    return f"under the load {load!r}" if load else "when dropped as placed"


def _situation(load: str, simulation: Simulation) -> str:
    """What is nearest to its limit, in words: a load case or the drop as placed."""
    if load:
        return _when(load)
    return "dropped as placed, which is worse than any load," if simulation.loaded else "dropped as placed"


def _side(judgement: Judgement) -> str:
    """On which side of its limit a value lies, and whether that is sure."""
    return ("within" if judgement.outcome == "VIABLE" else "above") + (" (MARGINAL)" if judgement.marginal else "")
