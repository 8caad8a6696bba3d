"""Stylizers from elsewhere: found by name, checked before a run, documented by an example that works."""

from __future__ import annotations

import re
from pathlib import Path
from types import SimpleNamespace

import matplotlib.image
import numpy as np
import pytest

import mechstyle as ms
from mechstyle.errors import BadInput
from mechstyle.loop.engine import Bounds
from mechstyle.records import Recipe
from mechstyle.records.material import LIBRARY
from mechstyle.runs import stylizers
from mechstyle.runs.recipes import changed, recipe_for
from mechstyle.runs.run import Run
from mechstyle.styling.drawn import ProceduralStylizer, Target
from support import ROOT
from support.knob import knob

PAGE = ROOT / "docs" / "plug-in.md"


@pytest.fixture(autouse=True)
def alone(monkeypatch):
    """No stylizer is known but those of the test."""
    monkeypatch.setattr(stylizers, "_registered", {})


def flat(surface, bounds, recipe):
    count = len(surface.vertices)
    return ProceduralStylizer(surface, Target(np.zeros(count, np.float32), np.ones((count, 3), np.float32), ()))


def made(surface, factory):
    stylizers.register_stylizer("mine")(factory)
    recipe = Recipe.of(surface="s", tetrahedra="t", prompt="", material=LIBRARY["PLA"], stylizer="mine")
    full = np.ones(len(surface.vertices), np.float32)
    return stylizers.made(surface, Bounds(full, full, full, full), recipe)


def test_a_registered_function_makes_the_stylizer_of_its_name(cube):
    assert isinstance(made(cube, flat), ProceduralStylizer)


def test_an_installed_package_offers_its_stylizer(monkeypatch):
    point = SimpleNamespace(name="installed", load=lambda: flat)
    monkeypatch.setattr(stylizers, "entry_points", lambda name=None, **_: [point] if name in (None, "installed") else [])
    assert stylizers.known_stylizers() == ("installed",)
    assert stylizers.name_of("installed") == "installed"
    with pytest.raises(BadInput, match="unknown stylizer 'instaled': did you mean 'installed'"):
        stylizers.name_of("instaled")


def test_a_function_given_itself_is_registered_by_its_name():
    assert recipe_for("whatever it reads", stylizer=flat).style.stylizer == "flat"
    assert stylizers.known_stylizers() == ("flat",)


def test_the_built_in_styles_have_no_name_and_still_read_the_prompt():
    assert recipe_for("brick").style.stylizer == ""
    with pytest.raises(BadInput, match="no style"):
        recipe_for("whatever it reads", stylizer="")


def test_a_branch_to_the_built_in_styles_reads_its_prompt_again():
    mine = recipe_for("whatever it reads", stylizer=flat)
    assert changed(mine, {"prompt": "something else"}).style.prompt == "something else"
    with pytest.raises(BadInput, match="names no style"):
        changed(mine, {"prompt": "something else", "stylizer": ""})


def test_a_stylizer_that_is_not_here_is_refused_with_what_to_do():
    with pytest.raises(BadInput, match=r"the stylizer 'picture' is not here: .*docs/plug-in\.md"):
        recipe_for("brick", stylizer="picture")


def test_a_name_that_cannot_be_one_is_refused():
    with pytest.raises(BadInput, match="named by letters"):
        stylizers.register_stylizer("os:system")


def proposing(displacement, colour):
    return lambda *_: SimpleNamespace(proposal=lambda: SimpleNamespace(displacement=displacement, colour=colour))


@pytest.mark.parametrize(
    ("factory", "said"),
    [
        (proposing(np.zeros(7), np.zeros((8, 3))), r"shapes \(7,\) and \(8, 3\), not \(8,\) and \(8, 3\)"),
        (proposing(np.zeros(8), np.full((8, 3), np.nan)), "not finite numbers"),
        (lambda *_: 42, "the stylizer 'mine' is none"),
    ],
)
def test_what_is_no_stylizer_is_refused_before_the_run(cube, factory, said):
    with pytest.raises(BadInput, match=said):
        made(cube, factory)


def test_the_example_of_the_page_styles_a_part_and_goes_on_where_it_stopped(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MECHSTYLE_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(ms, "load", lambda _path: knob())
    light = np.zeros((40, 60, 3))
    light[:, 30:] = [1.0, 0.9, 0.2]
    matplotlib.image.imsave("picture.png", light)
    code = re.search(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)[1]
    code = code.replace('out="runs', 'iterations=4, orientations=1, nearly_flat=False, window=0.2, element="tet4", out="runs')
    names: dict[str, object] = {}  # the same run, only sooner
    exec(compile(code, PAGE.name, "exec"), names)
    run = names["run"]
    assert run.recipe.style.stylizer == "picture"
    state = run.checkpoint()
    side = np.abs(run.part.surface.vertex_normals[:, 2]) < 0.1
    high = side & (run.part.surface.vertices[:, 2] > 8.0) & (np.abs(run.part.surface.vertices[:, 1]) > 3.0)
    lit = run.part.surface.vertices[:, 1] > 0.0
    assert state.displacement[high & lit].min() > 0.0 > state.displacement[high & ~lit].max()
    assert Path("cup-with-picture.3mf").is_file()
    again = Run.open("runs/picture", "cpu")
    before = again.store.lane().head
    assert again.go().store.lane().head == before
    stylizers._registered.clear()
    with pytest.raises(BadInput, match="the stylizer 'picture' is not here"):
        Run.open("runs/picture", "cpu").go()
