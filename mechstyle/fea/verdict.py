"""The verdict: every rule applied to the measures of a part and its original, the worst of those that count, and both in words."""

from __future__ import annotations

import math
from typing import NamedTuple

import msgspec

from mechstyle.errors import unknown
from mechstyle.records import CRITERIA, Judgement, Measures, Outcome, Simulation, Verdict
from mechstyle.records.limits import UNHARMED, Limits
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


class Told(NamedTuple):
    """A judgement and the clause that tells it."""

    judgement: Judgement
    clause: str


def judge(simulation: Simulation, baseline: Simulation, material: Material, criterion: str) -> Verdict:
    """Whether a part survives, under the criterion `robust` or `paper`.

    (A) As placed and under its loads: the surface stress away from contacts, and the average around them, each at most the yield
    strength or what the original reaches in the same place's stead. (T) Tilted a little: the surface stress at most the yield strength
    or UNHARMED times the original's. (B) All orientations: 99th percentile of the envelope at most UNHARMED times the original's.
    The literal published rule, maximum ≤ S_yield, is always shown. `robust` is the worst of A, T and B, `paper` the literal rule.
    What was not computed, or not to a finite number, is UNKNOWN; what tetrahedra tell that do not carry the relief is MARGINAL.
    """
    if criterion not in CRITERIA:
        raise unknown("criterion", criterion, CRITERIA)
    trouble = _trouble(simulation, baseline)
    limits = Limits.of(baseline, material)
    placed = _as_placed(simulation, baseline, limits, material, trouble)
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
    words = f"UNKNOWN: {trouble}." if trouble else f"{outcome}{doubt}: {'; '.join(clauses)}."
    return Verdict(
        outcome=outcome,
        criterion=criterion,
        as_placed=placed.judgement,
        tilted=nearly and nearly.judgement,
        all_orientations=spread and spread.judgement,
        literal=literal.judgement,
        words=words,
    )


def input_warning(baseline: Simulation, material: Material) -> str:
    """One sentence if the unstylized part itself begins to yield as placed, or nearly, or could not be tested; "" otherwise."""
    trouble = _trouble(baseline, baseline)
    if trouble:
        return f"The unstylized part could not be judged: {trouble}."
    peak, strength = baseline.as_placed.peak, material.yield_strength
    if peak <= strength * (1.0 - SURFACE_BAND):
        return ""
    when = f"under the load {baseline.governing!r}" if baseline.governing else "when dropped as placed"
    reached = f"The unstylized part itself reaches {peak:.1f} MPa at {_place(baseline.as_placed.where)} {when}"
    if peak <= strength:
        return f"{reached}: it is about to yield, whatever the style ({_strength(material)})."
    return f"{reached}, above {_strength(material)}; the style is held to that peak instead."


def _trouble(simulation: Simulation, baseline: Simulation) -> str:
    """Why nothing can be judged, "" if it can."""
    for part, name in ((simulation, "the part"), (baseline, "the original")):
        if part.failure:
            return part.failure if part is simulation else f"the original could not be simulated: {part.failure}"
        drops = ((part.as_placed, "as placed"), (part.tilted, "nearly as placed"), (part.overall, "in all orientations"))
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


def _as_placed(simulation: Simulation, baseline: Simulation, limits: Limits, material: Material, trouble: str) -> Told:
    """Rule (A), of surface and contact the one that is nearer to its limit."""
    drop, own = simulation.as_placed, baseline.as_placed
    rule = _rule("surface stress", limits.surface, material)
    on_surface = _judgement(rule, drop.surface, limits.surface, "MPa", SURFACE_BAND, trouble)
    rule = _rule("average around the contact", limits.contact, material)
    at_contact = _judgement(rule, drop.contact, limits.contact, "MPa", CONTACT_BAND, trouble)
    surface = _use(on_surface) >= _use(at_contact)
    judgement, before = (on_surface, own.surface) if surface else (at_contact, own.contact)
    what = "its surface stress" if surface else "the stress around the contact"
    clause = f"{_situation(simulation)} {_stress(what, judgement, drop, before, material, bending=surface)}"
    if judgement.outcome == "VIABLE" and at_contact.marginal and not judgement.marginal:  # its band is the wider one
        judgement = msgspec.structs.replace(judgement, marginal=True)
        clause += f", and {_stress('the stress around the contact', at_contact, drop, own.contact, material, bending=False)}"
    return Told(judgement, clause)


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


def _rule(what: str, limit: float, material: Material) -> str:
    return f"{what} as placed ≤ " + ("yield strength" if limit <= material.yield_strength else "the original's own")


def _use(judgement: Judgement) -> float:
    """Share of the limit that is used up."""
    return judgement.value / judgement.limit if judgement.limit > 0.0 else 0.0


def _stress(what: str, judgement: Judgement, drop: Measures, before: float, material: Material, *, bending: bool) -> str:
    """A judgement on a stress in words."""
    limit = _strength(material)
    if judgement.limit > material.yield_strength:
        told = f"the original's own {before:.1f} MPa"
        told += f", which itself exceeds {limit}" if before > material.yield_strength else ""
        limit = told if judgement.limit <= before else f"{judgement.limit:.1f} MPa, {judgement.limit / before:.2f} times {told}"
    where = drop.surface_where if bending else drop.contact_where
    told = f"{what} is {judgement.value:.1f} MPa at {_place(where or drop.where)}, {_side(judgement)} {limit}"
    if judgement.outcome == "VIABLE" and judgement.marginal and before >= (1.0 - SURFACE_BAND) * judgement.limit:
        told += f", as that of the original, {before:.1f} MPa"
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


def _situation(simulation: Simulation) -> str:
    """What causes the deciding peak, in words: a load case or the drop as placed."""
    if simulation.governing:
        return f"under the load {simulation.governing!r}"
    return "dropped as placed, which is worse than any load," if simulation.loaded else "dropped as placed"


def _side(judgement: Judgement) -> str:
    """On which side of its limit a value lies, and whether that is sure."""
    return ("within" if judgement.outcome == "VIABLE" else "above") + (" (MARGINAL)" if judgement.marginal else "")
