"""How sure a verdict is, whatever several rules, stresses and loads say of one part."""

from dataclasses import replace
from itertools import product

import msgspec
import numpy as np
import pytest

from mechstyle.fea.verdict import CONTACT_BAND, RATIO_BAND, SURFACE_BAND, judge
from mechstyle.records import LoadResult, Measures, Simulation
from mechstyle.records.limits import UNHARMED
from mechstyle.records.material import LIBRARY

PLA = LIBRARY["PLA"]
Y = PLA.yield_strength

BANDS = {
    "surface": SURFACE_BAND, "contact": CONTACT_BAND, "load": SURFACE_BAND, "support": CONTACT_BAND, "tilted": SURFACE_BAND,
    "overall": RATIO_BAND,
}  # fmt: skip
"""What is judged of a part with one load case, and how far from its limit it is in doubt."""
CALM, CLOSE, OVER, CLEAR = "calm", "close", "over", "clear"


def use(what, level):
    """Share of its limit; what is clear for a surface is in doubt around a contact, and the other way round for what is calm."""
    band = BANDS[what]
    return {CALM: 1.0 - 1.2 * band, CLOSE: 1.0 - 0.8 * band, OVER: 1.0 + 0.8 * band, CLEAR: 1.0 + 1.2 * band}[level]


def measures(surface, contact):
    peak = max(surface, contact)
    return Measures(peak=peak, surface=surface, contact=contact, p999=1.0, p99=1.0, maximum=1.0, where=(0.0, 0.0, 0.0), volume=1.0)


def part(surface=0.1, contact=0.1, load=0.1, support=0.1, tilted=0.1, overall=1.0 / UNHARMED):
    """A part that uses these shares of its limits, beside an original that bears next to nothing but has a p99 of 1 MPa over all."""
    one, dropped, loaded = np.zeros(1), measures(surface * Y, contact * Y), measures(load * Y, support * Y)
    return Simulation(
        displacement=one, stress=one, envelope=one, probability=one, contact=one > 0, as_placed=dropped.or_worse(loaded), dropped=dropped,
        overall=msgspec.structs.replace(dropped, p99=UNHARMED * overall), tilted=measures(tilted * Y, 0.0),
        loaded=(LoadResult(name="coat", peak=loaded.peak, where=loaded.where, deflection=0.1, measures=loaded),),
        backed_off=0.0, deviation=0.0, time_step=1e-4, steps=100, added_mass=0.0,
    )  # fmt: skip


@pytest.mark.parametrize("drop", list(product((CALM, CLOSE, OVER, CLEAR), repeat=2)), ids="-".join)
def test_a_verdict_is_as_sure_as_what_decides_it(drop):
    """The unsafe side of it: a surface at 1.06 of its limit was MARGINAL where a contact was at 1.12, whose band is wider."""
    original = part()
    for others in product((CALM, CLOSE, OVER, CLEAR), repeat=4):
        said = (*drop, *others)
        shares = {what: use(what, level) for what, level in zip(BANDS, said, strict=True)}
        found = judge(part(**shares), original, PLA, "robust")
        fails = OVER in said or CLEAR in said
        doubt = CLEAR not in said and (fails or CLOSE in said)
        word = "MARGINAL" if doubt else "FAILS" if fails else "VIABLE"
        assert (found.outcome, found.word) == ("FAILS" if fails else "VIABLE", word), said
        assert found.words.startswith(f"{found.outcome}{', MARGINAL' if doubt else ''}: "), said
        assert found.safety_factor == pytest.approx(1.0 / max(shares.values())), said


@pytest.mark.parametrize(("where", "when"), [("surface", ""), ("load", "under the load 'coat' ")])
def test_what_fails_clearly_is_told_beside_what_is_further_beyond_its_limit_and_in_doubt(where, when):
    found = judge(part(contact=1.14, **{where: 1.08}), part(), PLA, "robust")
    assert found.words.startswith("FAILS: ")
    assert f"the stress around the contact is {1.14 * Y:.1f} MPa at (0.0, 0.0, 0.0) mm, above (MARGINAL) the" in found.words
    assert f"and {when}its surface stress is {1.08 * Y:.1f} MPa" in found.words
    assert (found.as_placed.value, found.as_placed.marginal) == (1.14 * Y, False)


def test_a_shape_that_hides_stress_does_not_make_what_fails_clearly_marginal():
    for surface, word in ((0.5, "MARGINAL"), (1.02, "MARGINAL"), (1.1, "FAILS")):
        assert judge(replace(part(surface=surface), carried=0.8), part(), PLA, "robust").word == word


@pytest.mark.parametrize(
    ("border", "surface", "word"), [(0.84, 0.5, "VIABLE"), (0.86, 0.5, "MARGINAL"), (np.nan, 0.5, "MARGINAL"), (2.0, 1.1, "FAILS")]
)
def test_what_elements_too_long_beside_a_support_may_hide_is_doubtful(border, surface, word):
    """The unsafe side: on a short arm of long elements a clamp at 100 MPa reads 65."""
    one = part(load=surface)
    (case,) = one.loaded
    found = judge(replace(one, loaded=(msgspec.structs.replace(case, border=border * Y),)), part(), PLA, "robust")
    assert found.word == word
    assert ("under the load 'coat' elements where a support or load ends are too long" in found.words) is (word == "MARGINAL")
