"""Protected regions and fine files from the command line, on the finished small run."""

from __future__ import annotations

import json
import shutil

import numpy as np
import pytest
import trimesh

from mechstyle.runs.run import Run


def test_protect_shows_what_regions_hold(finished):
    line, _, _ = finished
    regions = ("--protect", "inside", "--protect", "above 99 ramp 3")
    told = line.here("protect", "gallery:pen_holder", "--vertices", "2000", *regions, "--json").json
    assert told["notes"][0].startswith("protected: inside, 4")
    assert 0.4 < told["share"] < 0.6
    assert (line.folder / told["files"]["picture"]).read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((), "say what to protect"),
        (("--protect", "insde"), "did you mean 'inside'"),
        (("--protect", "box 0 0 0"), "write box x y z x y z"),
        (("--protect", "sphere 900 0 0 5"), "holds nothing of this part"),
    ],
)
def test_a_region_that_cannot_be_is_refused(finished, arguments, said):
    line, _, _ = finished
    assert said in line.here("protect", "gallery:pen_holder", "--vertices", "2000", *arguments, code=2).stderr


@pytest.fixture(scope="module")
def protected(finished, tmp_path_factory):
    """A branch that protects the top of the box, with a quick drop, and its file."""
    line, root, _ = finished
    copy = tmp_path_factory.mktemp("protected") / "part"
    shutil.copytree(root, copy)
    quick = ("--orientations", "1", "--set", "element=tet4", "--set", "window=0.2", "--set", "nearly_flat=False", "--schedule", "never")
    line.here("branch", f"{copy}@0", "--lane", "outside", "--protect", "above 5 colour", *quick, "--json")
    fine = line.here("export", f"{copy}@outside", "--out", copy / "part.ply", "--json").json
    return copy, fine


def test_what_is_protected_does_not_move_and_keeps_its_colour(protected):
    run = Run.open(f"{protected[0]}@outside", "cpu")
    state, start = run.checkpoint(), run.checkpoint(0)
    held = run.part.surface.vertices[:, 2] > 6.0
    assert held.any()
    assert not state.displacement[held].any()
    assert np.array_equal(state.colour[held], start.colour[held])
    assert state.displacement[~held].any()
    assert any(note.startswith("protected: above 5 colour") for note in run.summary.notes)


def test_a_file_comes_with_its_own_verdict(protected):
    root, told = protected
    assert told["export"]["verdict"]["outcome"] in {"HOLDS", "NO WORSE"}
    assert told["export"]["verdict"]["rows"][0]["test"] == "flat"
    assert json.loads((root / "part.ply.json").read_text()) == told["export"]
    faces = len(Run.open(root, "cpu").part.surface.faces)
    assert len(trimesh.load(root / "part.ply", process=False).faces) == faces


def test_an_unknown_stylizer_is_refused(finished):
    line, _, _ = finished
    said = line.here("run", "gallery:pen_holder", "--prompt", "brick", "--stylizer", "picture", code=2).stderr
    assert "stylizer 'picture'" in said  # what is known beside it depends on what else this process registered
