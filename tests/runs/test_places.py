"""A prompt with a style for each place, from the request to the surface."""

from __future__ import annotations

import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.runs.run import Run, stylize
from support.knob import knob

QUICK = {"iterations": 60, "orientations": 1, "nearly_flat": False, "window": 0.2, "element": "tet4", "schedule": "never",
         "base": "free"}  # fmt: skip


@pytest.fixture(scope="module")
def run(tmp_path_factory) -> Run:
    folder = tmp_path_factory.mktemp("places")
    return stylize(knob(), "top 8 mm: blue stone; zeppelin", out=folder / "run", amplitude=0.3, device="cpu", **QUICK)


def test_the_style_lies_where_it_was_asked_for(run):
    state = run.checkpoint()
    z = run.part.surface.vertices[:, 2] - run.part.surface.vertices[:, 2].max()
    assert np.abs(state.displacement[z < -14.0]).max() < 0.02
    assert np.abs(state.displacement[z > -4.0]).max() > 0.2
    assert np.ptp(state.colour[z < -14.0]) < 0.02
    assert np.all(state.colour[z > -2.0].mean(axis=0).argmax() == 2)


def test_the_summary_says_what_was_understood_and_what_was_not(run):
    notes = run.summary.notes
    assert any(note.startswith("prompt read as top 8: stone, in #2f5fa8") for note in notes)
    assert any("left out: 'zeppelin'" in note for note in notes)
    assert any(note.startswith("top 8: stone") and note.endswith("of the surface") for note in notes)


def test_a_prompt_that_is_too_long_is_refused_before_anything_is_meshed(tmp_path):
    with pytest.raises(BadInput, match="the prompt has 600 characters, but may have 500"):
        stylize(knob(), "brick " * 100, out=tmp_path / "run", **QUICK)
    assert not (tmp_path / "run").exists()
