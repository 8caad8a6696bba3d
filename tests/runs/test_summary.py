"""What a run came to survives the way to disk and back, known or not."""

from __future__ import annotations

import msgspec

from mechstyle.loop.history import Strength
from mechstyle.records import Judgement, Verdict


def test_an_unknown_verdict_has_no_safety_factor_and_can_be_read_back():
    nothing = Judgement(rule="peak", outcome="UNKNOWN", value=0.0, limit=45.6, unit="MPa", marginal=False)
    verdict = Verdict(
        outcome="UNKNOWN", criterion="robust", as_placed=nothing, all_orientations=None, literal=nothing, words="UNKNOWN: it broke down."
    )
    strength = Strength.of(verdict)
    assert strength.safety_factor is None
    assert msgspec.json.decode(msgspec.json.encode(strength), type=Strength) == strength
