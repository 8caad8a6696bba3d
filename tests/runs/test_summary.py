"""What a run came to survives the way to disk and back, known or not."""

from __future__ import annotations

import msgspec
import pytest

from mechstyle.loop.history import Strength
from mechstyle.records import Judgement, Verdict
from mechstyle.runs.summary import hidden_by
from support.records import simulation


def test_an_unknown_verdict_has_no_safety_factor_and_can_be_read_back():
    nothing = Judgement(rule="peak", outcome="UNKNOWN", value=0.0, limit=45.6, unit="MPa", marginal=False)
    verdict = Verdict(
        outcome="UNKNOWN", criterion="robust", as_placed=nothing, all_orientations=None, literal=nothing, words="UNKNOWN: it broke down."
    )
    strength = Strength.of(verdict)
    assert strength.safety_factor is None
    assert msgspec.json.decode(msgspec.json.encode(strength), type=Strength) == strength


@pytest.mark.parametrize(("whole", "base", "told"), [(0.95, None, ""), (0.81, None, "81%"), (0.95, 0.79, "79%"), (0.95, 0.93, "")])
def test_a_verdict_on_tetrahedra_that_do_not_carry_the_relief_says_that_stress_may_be_hidden(whole, base, told):
    """The unsafe side: what tetrahedra do not carry bears no stress in them."""
    notes = hidden_by(simulation(carried=whole, carried_base=base))
    assert bool(notes) is bool(told)
    assert told in "".join(notes)
