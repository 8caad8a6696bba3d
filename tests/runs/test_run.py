"""A run begun: what it was begun with is in its record, whoever began it."""

from dataclasses import replace

import pytest

import mechstyle as ms
from mechstyle.errors import BadInput
from mechstyle.geometry.files import save
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.runs import run as module
from mechstyle.runs.recipes import recipe_for
from mechstyle.runs.report.reproduce import command_for
from mechstyle.runs.run import Draft, Run, stylize
from mechstyle.simulation.part import Origin, prepare
from support.knob import knob
from support.lanes import lane_on_a_sheet


@pytest.fixture
def asked(tmp_path, monkeypatch):
    """Vertices asked for by each preparation; nothing is prepared, simulated or styled."""
    part, asked = lane_on_a_sheet(tmp_path / "prepared", iterations=1).part, []
    monkeypatch.setattr(Run, "go", lambda run, _on_event=None, _progress=None: run)
    monkeypatch.chdir(tmp_path)

    def prepared(_mesh, *, vertices, stage, relief, go_on, measured):
        asked.append(vertices)
        stage("filling it with tetrahedra")
        return part

    monkeypatch.setitem(Draft.ready.__kwdefaults__, "prepare", prepared)
    return asked


def test_a_model_of_the_gallery_is_named_in_the_record_and_made_again_by_the_command(asked):
    run = stylize(ms.load("gallery:vase"), "brick", vertices=900, out="vase")
    assert run.record.origin == Origin(model="gallery:vase", vertices=900)
    assert command_for(run, run.history) == "mechstyle run gallery:vase --prompt brick --vertices 900 --out again-part"
    assert asked == [900]


@pytest.mark.parametrize(
    "given", [lambda: ms.stylize("cup.stl", "brick"), lambda: ms.simulate("cup.stl"), lambda: ms.lab.prepare("cup.stl")]
)
def test_a_name_in_place_of_a_surface_says_what_opens_it(given, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(BadInput, match=r"not 'cup\.stl': open it with ms\.load first"):
        given()
    assert list(tmp_path.iterdir()) == []


def test_a_file_is_named_with_its_scale(asked, cube, tmp_path):
    save(cube, tmp_path / "files" / "cup.stl")
    run = stylize(ms.load(tmp_path / "files" / "cup.stl", scale=2.5), "brick", out="cup")
    assert run.record.origin == Origin(model="cup.stl", scale=2.5)


def test_a_surface_that_was_changed_since_is_not_said_to_be_that_of_the_file(asked):
    vase = ms.load("gallery:vase")
    for number, mesh in enumerate((vase.moved(2.0 * vase.vertices), SurfaceMesh(vase.vertices, vase.faces))):
        assert stylize(mesh, "brick", out=f"changed-{number}").record.origin == Origin()


def test_a_part_at_hand_is_run_on_the_tetrahedra_that_it_came_with(tmp_path):
    """A second run filled it anew, and the part without a style survived another fall from then on."""
    brick, stone = (recipe_for(prompt, feature=9.0) for prompt in ("brick", "stone"))
    first = Draft(brick, prepare(knob()), folder=tmp_path / "first").ready().begin()
    parts = knob(), first.part, Run.open(first.store.root).part
    later = [Draft(stone, part, folder=tmp_path / f"later-{number}").ready().begin() for number, part in enumerate(parts)]
    assert {run.recipe.test.specimen.tetrahedra for run in (first, *later)} == {knob().tets.digest}


def test_what_was_thickened_before_is_not_thickened_again(tmp_path, monkeypatch):
    """The Studio hands the part of one run on to the next, with another style."""
    thicker = replace(lane_on_a_sheet(tmp_path / "prepared", iterations=1).part, mass_gained=2.0)
    monkeypatch.setattr(module, "refilled", lambda given, *_: given)
    assert Draft(recipe_for("brick", strengthen=2.0), thicker, device="cpu").ready(prepare=pytest.fail).part is thicker
