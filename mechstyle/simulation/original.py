"""The original on tetrahedra that were made for a relief: no style is blamed for what the mesh does.

Where the waves of a flat landing meet, another mesh of the same fineness reads some per cent more or less, with a relief and without. So a
part that fails is held to what the original does on the part's own tetrahedra as well. But where the way back from half a relief would
turn tetrahedra inside out, the original is stood in for by a part with a little relief left, and a notch left over may bear several times
what the original does: so that is believed up to a limit only.

Where a part fails so clearly that this could change no outcome, and nothing is steered by the limits, other tetrahedra are not asked: they
take a third of the time of such a run.

The other way round, a tetrahedron like a splinter beside its foot may tell an original of its own tetrahedra several times its stress, and
would let a style bear as much. What an original reads above its strength excuses a style only as far as other tetrahedra confirm it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import msgspec
import numpy as np

from mechstyle.fea.verdict import CONTACT_BAND, judge
from mechstyle.records import LoadResult, Measures, Recipe, Simulation
from mechstyle.records.limits import UNHARMED
from mechstyle.records.material import Material
from mechstyle.records.mesh import Field
from mechstyle.simulation.under_loads import with_measures

FINER = 1.4
"""What other tetrahedra may read, over what those of the original do, and raise its limit; more is a notch."""

CONFIRMED = 1.1
"""What the original may read on its own tetrahedra, over what it does on others: five triangulations of a smooth cup differ by 1 %."""


def excuses(original: Simulation, material: Material) -> bool:
    """Whether an original reads more than its strength, as placed or its surface tilted, and so would let a style bear more than that."""
    tilted = 0.0 if original.tilted is None else original.tilted.surface
    return not original.failure and max(original.as_placed.peak, tilted) > material.yield_strength


def asked(simulation: Simulation, original: Simulation, recipe: Recipe) -> bool:
    """Whether it may matter what the original does on the tetrahedra of a part.

    It does where the original excuses a style, and where a part fails beside it: but not where the part is `hopeless`, and its verdict all
    that is wanted. What steers a style is to know the limits as well as can be.

    Args:
        simulation: Of the part.
        original: On tetrahedra of its own, in all orientations.
        recipe: What the part is judged by.
    """
    if excuses(original, recipe.material):
        return True
    fails = judge(simulation, original, recipe.material, recipe.criterion).outcome == "FAILS"
    return fails and (recipe.steered or not hopeless(simulation, original, recipe))


def asked_everywhere(simulation: Simulation, original: Simulation, recipe: Recipe) -> bool:
    """Whether it may matter what the original does on the tetrahedra of a part in all orientations: it fails by these, and they count.

    Args:
        simulation: Of the part.
        original: On tetrahedra of its own, in all orientations.
        recipe: What the part is judged by.
    """
    verdict = judge(simulation, original, recipe.material, recipe.criterion)
    spread = verdict.all_orientations
    return spread is not None and spread.outcome == "FAILS" and spread in verdict.counting


def hopeless(simulation: Simulation, original: Simulation, recipe: Recipe) -> bool:
    """Whether a part fails clearly, and every rule says the same whatever other tetrahedra read of an original that excuses nothing.

    Limits are only ever raised, by FINER at most: what a rule says with the original's own and with the highest it says with any between.
    """
    loaded = [_with(case, _highest(case.measured)) for case in original.loaded]
    tilted, overall = (one and _highest(one) for one in (original.tilted, original.overall))
    highest = with_measures(replace(original, tilted=tilted, overall=overall), _highest(original.drop), loaded)
    now, then = (judge(simulation, one, recipe.material, recipe.criterion) for one in (original, highest))
    outcomes = [[rule and rule.outcome for rule in (one.as_placed, one.tilted, *one.counting)] for one in (now, then)]
    failing = [rule for rule in then.counting if rule.outcome == "FAILS" and not rule.marginal]
    # As placed one of two stresses is told, and with limits between the two verdicts perhaps the other, whose band is the wider one.
    clear = any(rule is not then.as_placed or rule.value > (1.0 + CONTACT_BAND) * rule.limit for rule in failing)
    return clear and outcomes[0] == outcomes[1]


def beside(original: Simulation, here: Simulation, material: Material) -> Simulation:
    """The original as it is known from two meshes: confirmed where it excuses a style, and raised.

    Args:
        original: On tetrahedra of its own, in all orientations.
        here: On those that were made for a relief, as placed and tilted.
        material: What its stress is compared with.
    """
    return raised(confirmed(original, here, material) if excuses(original, material) else original, here)


def confirmed(original: Simulation, here: Simulation, material: Material) -> Simulation:
    """The original with its stresses as placed and tilted at most CONFIRMED times what it reads on other tetrahedra, or its strength.

    Of stresses that may grow to UNHARMED times it counts what sets that limit to the strength: what nobody confirms is to excuse nothing.

    Args:
        original: On tetrahedra of its own, in all orientations.
        here: On those that were made for a relief, as placed and tilted. Where that broke down nothing is confirmed.
        material: Whose strength needs no confirming.
    """
    if original.failure:
        return original
    placed, nearly = (None, None) if here.failure else (here.drop, here.tilted)
    cases = {case.name: None if here.failure else here.load(case.name) for case in original.loaded}
    held = replace(
        original,
        tilted_stress=_believed(original.tilted_stress, nearly, material),
        tilted=original.tilted and _at_most(original.tilted, nearly, material, grows=("surface", "contact")),
    )
    stresses = [_believed(original.load_stress(name), measures, material) for name, measures in cases.items()]
    loaded = [_with(case, _at_most(case.measured, cases[case.name], material, grows=("contact",))) for case in original.loaded]
    held = _with_stress(held, _believed(original.drop_stress, placed, material), stresses)
    return with_measures(held, _at_most(original.drop, placed, material, grows=("contact",)), loaded)


def raised(original: Simulation, here: Simulation) -> Simulation:
    """The original with its stresses as large as on other tetrahedra, but at most FINER times its own.

    Args:
        original: On tetrahedra of its own, in all orientations.
        here: On those that were made for a relief, as placed and tilted, or in all orientations.
    """
    if here.failure or original.failure:
        return original
    tilted = original.tilted
    if tilted is not None and here.tilted is not None:
        tilted = _larger(tilted, here.tilted)
    found = replace(
        original,
        tilted_stress=original.tilted_stress if tilted is None else _within(here.tilted_stress, original.tilted_stress, tilted),
        tilted=tilted,
    )
    stresses, loaded = list[Field](), list[LoadResult]()
    for case in original.loaded:
        there = here.load(case.name)
        stresses.append(_within(here.load_stress(case.name), original.load_stress(case.name), case.measured))
        loaded.append(case if there is None else _with(case, _larger(case.measured, there)))
    if original.overall is not None and here.overall is not None:
        envelope = _within(here.envelope, original.envelope, original.overall)
        p99 = _at_most_finer(original.overall, here.overall, "p99")
        found = replace(found, envelope=envelope, overall=msgspec.structs.replace(_larger(original.overall, here.overall), p99=p99))
    found = _with_stress(found, _within(here.drop_stress, original.drop_stress, original.drop), stresses)
    return with_measures(found, _larger(original.drop, here.drop), loaded)


def _with(case: LoadResult, measures: Measures) -> LoadResult:
    """A load case with other measures."""
    return msgspec.structs.replace(case, peak=measures.peak, where=measures.where, measures=measures)


def _with_stress(original: Simulation, dropped: Field, loaded: list[Field]) -> Simulation:
    """An original with other fields of the drop as placed and of each load case [MPa], shape [vertex_count] each, and their largest."""
    if not loaded:
        return replace(original, stress=dropped)
    return replace(original, stress=np.maximum.reduce([dropped, *loaded]), dropped_stress=dropped, loaded_stress=np.stack(loaded))


def _highest(own: Measures) -> Measures:
    """The most that `raised` makes of the measures of an original."""
    return msgspec.structs.replace(own, **{name: FINER * getattr(own, name) for name in ("peak", "surface", "contact", "p99")})


def _at_most(own: Measures, here: Measures | None, material: Material, *, grows: Sequence[str]) -> Measures:
    """The measures of one, surface and contact at most CONFIRMED times the other's, or what excuses nothing where that is more.

    Args:
        own: Of the original on tetrahedra of its own.
        here: On others; None confirms nothing.
        material: Of the original.
        grows: Those of the two whose limit is UNHARMED times the original's.
    """
    calm = {name: material.yield_strength / (UNHARMED if name in grows else 1.0) for name in ("surface", "contact")}
    other = {name: 0.0 if here is None else CONFIRMED * getattr(here, name) for name in calm}
    held = {name: min(getattr(own, name), max(other[name], least)) for name, least in calm.items()}
    larger = max(held, key=held.__getitem__)
    return msgspec.structs.replace(own, peak=held[larger], where=getattr(own, f"{larger}_where") or own.where, **held)


def _believed(own: Field, here: Measures | None, material: Material) -> Field:
    """A field of the original [MPa], shape [vertex_count], nowhere above what it may read anywhere."""
    most = 0.0 if here is None else CONFIRMED * here.peak
    return np.minimum(own, np.float32(max(most, material.yield_strength)))


def _within(here: Field, own: Field, most: Measures) -> Field:
    """The larger of two fields [MPa], shape [vertex_count], what is another mesh's nowhere above what the part may read anywhere."""
    return np.maximum(own, np.minimum(here, np.float32(FINER * most.peak)))


def _larger(own: Measures, here: Measures) -> Measures:
    """The measures of one, surface and contact as large as the other's, at most FINER times its own, and the places of those."""
    held = {name: _at_most_finer(own, here, name) for name in ("surface", "contact")}
    of = {f"{name}_where": getattr(own if held[name] == getattr(own, name) else here, f"{name}_where") for name in held}
    larger = max(held, key=held.__getitem__)
    return msgspec.structs.replace(own, peak=held[larger], where=of[f"{larger}_where"] or own.where, **held, **of)


def _at_most_finer(own: Measures, here: Measures, name: str) -> float:
    """A measure of one as large as the other's, at most FINER times its own [MPa]."""
    return max(getattr(own, name), min(getattr(here, name), FINER * getattr(own, name)))
