"""Curves over time as a picture."""

from __future__ import annotations

import io

import numpy as np
import pytest
from matplotlib.image import imread

from mechstyle.pictures.plots import Curve, Plot, plots_png

TIME = np.linspace(0.0, 1.5, 40)
STRESS = Plot("Stress", "MPa", (Curve("a", TIME, 30.0 * np.sin(TIME)), Curve("b", TIME, TIME, stepped=True)))
FORCE = Plot("Force", "N", (Curve("floor", TIME, np.zeros(40)),))


def pixels(*plots, **options):
    return imread(io.BytesIO(plots_png(plots, x_label="time [ms]", **options)))


def test_plots_stand_above_each_other_and_are_repeatable():
    one, two = pixels(STRESS), pixels(STRESS, FORCE)
    assert two.shape[1] == one.shape[1]
    assert two.shape[0] > 1.5 * one.shape[0]
    assert plots_png([STRESS], x_label="t") == plots_png([STRESS], x_label="t")


@pytest.mark.parametrize("more", [{"limit": (45.6, "limit")}, {"mark": (1.0, 20.0)}, {"words": "up to 3 N"}])
def test_limit_mark_and_words_are_drawn(more):
    marked = Plot(STRESS.title, STRESS.unit, STRESS.curves, **more)
    assert plots_png([marked], x_label="t") != plots_png([STRESS], x_label="t")
