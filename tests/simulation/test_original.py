"""The original on the tetrahedra of a relief: believed where the mesh reads more, not where a notch does."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from mechstyle.fea.verdict import judge
from mechstyle.records import LoadResult, Recipe
from mechstyle.records.limits import UNHARMED, Limits
from mechstyle.records.material import LIBRARY
from mechstyle.simulation.carrying import Carried
from mechstyle.simulation.original import CONFIRMED, FINER, asked, asked_everywhere, beside, confirmed, excuses, hopeless, raised
from mechstyle.simulation.simulator import DropSimulator
from mechstyle.simulation.under_loads import under_loads
from support.records import simulation

PLA = LIBRARY["PLA"]
FREELY = Recipe(surface="", tetrahedra="", prompt="", material=PLA, schedule="never", guarantee=False)
"""Nothing follows from what is simulated but a verdict."""


def simulated(surface, contact=10.0, tilted=20.0, p99=10.0):
    """A part with these stresses; its fields are as high everywhere."""
    one = simulation(failure="")
    own = {"p99": p99, "surface_where": (surface, 0.0, 0.0), "where": (surface, 0.0, 0.0)}
    placed = msgspec.structs.replace(one.as_placed, peak=max(surface, contact), surface=surface, contact=contact, **own)
    nearly = msgspec.structs.replace(one.as_placed, peak=tilted, surface=tilted, **own)
    fields = {"stress": np.full(len(one.stress), surface), "tilted_stress": np.full(len(one.stress), tilted)}
    return replace(one, as_placed=placed, tilted=nearly, overall=placed, **fields)


def test_what_the_mesh_reads_more_is_not_laid_to_the_style():
    """On the tetrahedra of its relief a pen holder reads 46 to 56 MPa in the middle of its floor, on its own 41 to 44."""
    own, here, styled = simulated(43.9), simulated(50.0), simulated(49.0)
    assert judge(styled, own, PLA, "robust").outcome == "FAILS"
    assert judge(styled, raised(own, here), PLA, "robust").viable


def test_a_notch_left_by_the_way_back_raises_no_limit_beyond_what_meshes_do():
    found = raised(simulated(40.0, contact=20.0, tilted=50.0), simulated(300.0, contact=200.0, tilted=400.0))
    assert (found.as_placed.surface, found.as_placed.contact, found.tilted.surface) == pytest.approx((FINER * 40, FINER * 20, FINER * 50))
    assert found.as_placed.surface_where == (300.0, 0.0, 0.0)
    assert found.stress.max() == pytest.approx(FINER * 40.0)
    assert judge(simulated(60.0), found, PLA, "robust").outcome == "FAILS"


def test_no_limit_is_lowered():
    own = simulated(40.0, contact=20.0, tilted=50.0, p99=25.0)
    found = raised(own, simulated(30.0, contact=10.0, tilted=20.0, p99=15.0))
    assert (found.as_placed, found.tilted, found.overall) == (own.as_placed, own.tilted, own.overall)
    assert np.array_equal(found.stress, own.stress)


def test_what_the_mesh_reads_more_in_all_orientations_is_not_laid_to_the_style_either():
    """A tealight holder without relief reads 57.2 MPa on its own tetrahedra, 63.8 on those of its bricks, of which it could keep none."""
    own, here, styled = simulated(20.0, p99=57.2), simulated(20.0, p99=63.8), simulated(20.0, p99=66.0)
    assert judge(styled, own, PLA, "robust").outcome == "FAILS"
    assert judge(styled, raised(own, here), PLA, "robust").all_orientations.value == pytest.approx(66.0 / 63.8)
    notched = raised(own, simulated(20.0, p99=300.0))
    assert notched.overall.p99 == pytest.approx(FINER * 57.2)
    assert raised(own, replace(here, overall=None)).overall == own.overall


def under_load(drop, surface):
    """A part with this surface stress under a load besides."""
    found = msgspec.structs.replace(drop.as_placed, peak=surface, surface=surface, contact=0.0)
    case = LoadResult(name="coat", peak=surface, where=found.where, deflection=0.1, measures=found)
    return under_loads(drop, [case], np.full((1, len(drop.stress)), surface, np.float32))


def test_the_drop_and_each_load_are_confirmed_and_raised_by_the_same_test_on_other_tetrahedra():
    own, here = under_load(simulated(300.0), 60.0), under_load(simulated(90.0), 200.0)
    believed = confirmed(own, here, PLA)
    assert (believed.drop.surface, believed.load("coat").surface) == pytest.approx((CONFIRMED * 90.0, 60.0))
    assert believed.as_placed.surface == believed.drop.surface
    found = raised(under_load(simulated(40.0), 20.0), under_load(simulated(20.0), 50.0))
    assert (found.drop.surface, found.load("coat").surface, found.as_placed.surface) == pytest.approx((40.0, FINER * 20.0, 40.0))
    assert found.load_stress("coat").max() == pytest.approx(FINER * 20.0)
    assert found.drop_stress.max() == found.stress.max() == pytest.approx(40.0)
    assert judge(under_load(simulated(20.0), 1.5 * PLA.yield_strength), believed, PLA, "robust").outcome == "FAILS"


def test_what_broke_down_raises_nothing():
    own = simulated(40.0)
    assert raised(own, replace(simulated(90.0), failure="it broke down")) is own


def test_a_splinter_in_the_tetrahedra_of_the_original_raises_no_limit():
    """The unsafe side: beside its foot a tealight holder read 642 MPa tilted on its own tetrahedra, 76 on others, and 706 was allowed."""
    own, here, styled = simulated(143.6, tilted=641.7), simulated(30.0, contact=12.0, tilted=76.0), simulated(40.0, tilted=180.0)
    assert judge(styled, own, PLA, "robust").viable
    found, strength = confirmed(own, here, PLA), PLA.yield_strength
    assert (found.as_placed.surface, found.as_placed.contact, found.tilted.surface) == pytest.approx((strength, 10, CONFIRMED * 76))
    assert (found.stress.max(), found.tilted_stress.max()) == pytest.approx((strength, CONFIRMED * 76))
    assert found.as_placed.peak == pytest.approx(strength)
    assert judge(styled, found, PLA, "robust").outcome == "FAILS"


@pytest.mark.parametrize(("tilted", "failure"), [(None, ""), (20.0, "it broke down"), (None, "it broke down")])
def test_a_splinter_raises_no_limit_where_nothing_is_tilted_or_the_other_mesh_breaks_down(tilted, failure):
    """The unsafe side: what could not be confirmed was believed, 642 MPa as placed."""
    own, here, styled = simulated(642.0), replace(simulated(33.0), failure=failure), simulated(500.0)
    own, here, styled = (one if tilted else replace(one, tilted=None) for one in (own, here, styled))
    assert judge(styled, own, PLA, "robust").viable
    found = beside(own, here, PLA)
    assert judge(styled, found, PLA, "robust").outcome == "FAILS"
    assert found.as_placed.surface == pytest.approx(PLA.yield_strength)
    assert judge(replace(styled, as_placed=simulated(40.0).as_placed), found, PLA, "robust").viable


def test_what_nobody_confirms_allows_nothing_beyond_the_strength_where_the_original_may_grow_either():
    """The unsafe side: held to its strength, an unconfirmed contact or tilted stress let a style bear 1.10 times that."""
    own, here = simulated(20.0, contact=100.0, tilted=100.0), simulated(20.0, contact=10.0, tilted=10.0)
    for found in (confirmed(own, here, PLA), confirmed(own, replace(here, failure="it broke down"), PLA)):
        limits = Limits.of(found, PLA)
        assert (limits.drop.contact, limits.drop.surface, limits.tilted) == pytest.approx((PLA.yield_strength,) * 3)
    halfway = Limits.of(confirmed(own, simulated(20.0, contact=60.0, tilted=70.0), PLA), PLA)
    assert (halfway.drop.contact, halfway.tilted) == pytest.approx((UNHARMED * CONFIRMED * 60.0, UNHARMED * CONFIRMED * 70.0))


@pytest.mark.parametrize(("tilted", "viable"), [(62.0, False), (47.0, True)])
def test_a_few_mpa_that_only_one_mesh_reads_excuse_no_style(tilted, viable):
    """The unsafe side, between the strength and twice that, where an original was believed without asking."""
    own, here = simulated(40.0, tilted=60.3), simulated(40.0, tilted=43.0)
    assert judge(simulated(40.0, tilted=62.0), own, PLA, "robust").viable
    assert judge(simulated(40.0, tilted=tilted), beside(own, here, PLA), PLA, "robust").viable is viable


def test_of_a_hopeless_part_other_tetrahedra_need_not_be_asked_unless_something_is_steered():
    own, styled = simulated(35.0), simulated(116.0)
    assert hopeless(styled, own, FREELY)
    assert not asked(styled, own, FREELY)
    for steering in ({"guarantee": True}, {"schedule": "every"}, {"schedule": "every", "control": "none", "retraction": True}):
        assert asked(styled, own, msgspec.structs.replace(FREELY, **steering))
    alone = {"schedule": "every", "control": "none", "retraction": False}
    assert not asked(styled, own, msgspec.structs.replace(FREELY, **alone))


def test_what_fails_in_all_orientations_alone_is_asked_about_up_to_what_meshes_do():
    own = simulated(18.0)
    assert not asked(simulated(20.0, p99=1.06 * UNHARMED * FINER * 10.0), own, FREELY)
    for p99 in (11.3, 12.3, 15.0):
        assert asked(simulated(20.0, p99=p99), own, FREELY)
    everywhere = [asked_everywhere(simulated(50.0, p99=p99), own, FREELY) for p99 in (10.9, 11.1)]
    assert everywhere == [False, True], "what fails elsewhere alone wants no more than those drops"
    by_the_paper = msgspec.structs.replace(FREELY, criterion="paper")
    assert not asked_everywhere(simulated(50.0, p99=11.1), own, by_the_paper), "there they decide nothing"


@pytest.mark.parametrize(
    ("own", "styled", "why"),
    [
        (simulated(43.0), simulated(59.0), "as placed it may turn out to hold"),
        (simulated(35.0), simulated(52.0), "it may turn out to be marginal"),
        (simulated(35.0, tilted=40.0), simulated(116.0, tilted=60.0), "tilted it may turn out to hold, which is a figure of its own"),
        (simulated(43.0, p99=10.0), simulated(59.0, p99=30.0), "so may it as placed, though it fails in all orientations"),
        (simulated(60.0), simulated(900.0), "what excuses a style is to be confirmed, or the limit told is too high"),
    ],
)  # fmt: skip
def test_where_a_rule_could_say_something_else_they_are_asked(own, styled, why):
    assert asked(styled, own, FREELY), why


def test_whatever_other_tetrahedra_read_a_hopeless_part_is_told_the_same():
    """The unsafe side of the short cut, looked for among two thousand cases, of which hundreds are called hopeless."""
    draw, found = np.random.default_rng(0), 0
    for _ in range(2_000):
        (own, here), styled = draw.uniform(1.0, 45.0, (2, 4)) * [[1.0], [3.0]], draw.uniform(1.0, 150.0, 4)
        original, other, part = (simulated(*(float(value) for value in values)) for values in (own, here, styled))
        if not asked(part, original, FREELY) and judge(part, original, PLA, "robust").outcome == "FAILS":
            found += 1
            one, two = judge(part, original, PLA, "robust"), judge(part, beside(original, other, PLA), PLA, "robust")
            outcomes = [[rule.outcome for rule in verdict.counting] for verdict in (one, two)]
            assert (one.outcome, one.marginal, outcomes[0]) == (two.outcome, two.marginal, outcomes[1])
    assert found > 200


def test_only_an_original_above_its_strength_wants_confirming():
    strength = PLA.yield_strength
    assert not excuses(simulated(0.9 * strength, tilted=0.9 * strength), PLA)
    assert excuses(simulated(1.1 * strength), PLA)
    assert excuses(simulated(40.0, tilted=1.1 * strength), PLA)


def test_an_original_above_its_strength_is_confirmed_although_the_style_passes_beside_it(monkeypatch, block):
    own, there = simulated(40.0, tilted=641.7), simulated(41.0, tilted=76.0)
    fakes = {"baseline": property(lambda _: own), "_without_relief": property(lambda _: there)}
    fakes |= {"_carried": lambda *_: Carried(1.0, None, 0.0), "_made_for_relief": property(lambda _: True), "_on": lambda self, _: self}
    for name, fake in fakes.items():
        monkeypatch.setattr(DropSimulator, name, fake)
    test = DropSimulator(*block, Recipe(surface="", tetrahedra=block[1].digest, prompt="", material=PLA), None)
    assert not test.judge(replace(simulated(40.0, tilted=180.0), mesh=block[1].digest)).viable
    assert test.judge(replace(simulated(40.0, tilted=90.0), mesh=block[1].digest)).viable


@pytest.mark.parametrize(("stands", "raises"), [(1.0, True), (0.5, False)])
def test_tetrahedra_that_cannot_come_back_to_the_original_raise_no_limit(stands, raises, monkeypatch, block):
    """The unsafe side: an original that stands on the few nodes that do come back bears more, and so could the style."""
    own, there, styled = simulated(40.0), simulated(50.0), replace(simulated(49.0), mesh=block[1].digest)
    fakes = {"baseline": property(lambda _: own), "_without_relief": property(lambda _: there)}
    fakes |= {"_carried": lambda *_: Carried(1.0, None, 0.0, stands), "_made_for_relief": property(lambda _: True)}
    for name, fake in fakes.items():
        monkeypatch.setattr(DropSimulator, name, fake)
    recipe = Recipe(surface="", tetrahedra=block[1].digest, prompt="", material=PLA)
    test = DropSimulator(*block, recipe, None)
    monkeypatch.setattr(DropSimulator, "_on", lambda self, _: self)
    assert (test.baseline_of(styled) is not own) is raises
    assert test.judge(styled).viable is raises


def test_what_tetrahedra_confirm_that_cannot_come_back_to_the_original_is_all_that_excuses_a_style(monkeypatch, block):
    """The unsafe side: where nothing was to be raised, nothing was confirmed either, and a splinter's 642 MPa were believed."""
    own, there = simulated(40.0, tilted=641.7), simulated(90.0, tilted=76.0)
    fakes = {"baseline": property(lambda _: own), "_without_relief": property(lambda _: there), "_on": lambda self, _: self}
    fakes |= {"_carried": lambda *_: Carried(1.0, None, 0.0, 0.5), "_made_for_relief": property(lambda _: True)}
    for name, fake in fakes.items():
        monkeypatch.setattr(DropSimulator, name, fake)
    test = DropSimulator(*block, Recipe(surface="", tetrahedra=block[1].digest, prompt="", material=PLA), None)
    found = test.baseline_of(replace(simulated(40.0, tilted=180.0), mesh=block[1].digest))
    assert (found.as_placed.surface, found.tilted.surface) == pytest.approx((40.0, CONFIRMED * 76.0))
    assert test.believed(block[1].digest).tilted == found.tilted
    assert test.believed("others") is own, "nobody knows these"
    assert not test.judge(replace(simulated(40.0, tilted=180.0), mesh=block[1].digest)).viable


def test_a_verdict_on_a_finer_surface_asks_the_tetrahedra_about_their_own(monkeypatch, block):
    """A fine file that failed was refused for the number of its vertices."""
    asked, finer = [], replace(simulated(49.0), mesh=block[1].digest)
    fakes = {"baseline": property(lambda _: simulated(40.0)), "_without_relief": property(lambda _: simulated(50.0))}
    fakes |= {"_carried": lambda _, displacement: asked.append(len(displacement)) or Carried(1.0, None, 0.0)}
    fakes |= {"_made_for_relief": property(lambda _: True), "_on": lambda self, _: self}
    for name, fake in fakes.items():
        monkeypatch.setattr(DropSimulator, name, fake)
    DropSimulator(*block, Recipe(surface="", tetrahedra=block[1].digest, prompt="", material=PLA), None).judge(finer)
    assert asked == [len(block[0].vertices)] != [len(finer.displacement)]
