"""A styled surface as a 3MF file for a slicer: its filaments, its bodies, and what that costs to print."""

from __future__ import annotations

import json
import zipfile

import msgspec
import numpy as np
import pytest
import trimesh

from mechstyle.errors import BadInput
from mechstyle.runs.export import Exported, sidecar
from mechstyle.runs.printing import Printing, asked_for


def test_a_3mf_is_painted_in_two_filaments_and_says_first_what_it_costs(run, tmp_path):
    plan = run.exported(tmp_path / "part.3mf").printing
    assert (plan.slicer, len(plan.palette)) == ("standard", 2)
    assert plan.cost.changes <= plan.cost.layers + 2
    assert plan.words.startswith(f"{plan.cost.changes} changes of filament in {plan.cost.layers} layers, ")
    assert [offer.changes for offer in plan.offers if len(offer.palette) == 1] == [0]
    assert plan.cost.layers == pytest.approx(30.0 / 0.2, abs=10)  # a knob 30 mm high
    assert plan.cost.changes > plan.offers[-1].changes
    assert b"mmu_segmentation" in zipfile.ZipFile(tmp_path / "part.3mf").read("3D/3dmodel.model")
    assert msgspec.json.decode(sidecar(tmp_path / "part.3mf").read_bytes(), type=Exported).printing == plan


@pytest.mark.parametrize(
    ("prompt", "palette"),
    [
        ("blue grid", ("#2F5FA8",)),
        ("outside: blue brick; rim: blue studs", ("#2F5FA8",)),
        ("gold and black honeycomb", ("#C99A2E", "#262629")),
        ("outside: blue brick; rim: gold studs", ("#2F5FA8", "#C99A2E")),
        ("outside: blue brick; rim: studs", ()),
        ("brick", ()),
    ],
)
def test_a_colour_asked_for_is_a_filament(run, prompt, palette):
    recipe = run.recipe.with_settings(prompt=prompt)
    assert asked_for(recipe) == palette
    assert asked_for(recipe.with_settings(stylizer="mine")) == ()
    mesh = run.surface()
    usual = Printing().filaments(mesh)
    assert Printing(slicer="bambu").filaments(mesh, palette) == (palette or usual)
    assert len(Printing(colours=5).filaments(mesh, palette)) == 5
    assert len(Printing(bodies=True).filaments(mesh, palette)) == 2
    assert len(Printing(bands=True).filaments(mesh, palette)) == 2


def test_more_colours_than_two_changes_a_layer_are_reduced_unless_they_are_counted(run):
    mesh = run.surface()
    asked = ("#2F5FA8", "#C99A2E", "#262629", "#EBEAE6")
    assert Printing().filaments(mesh, asked[:3]) == asked[:3]
    assert len(Printing().filaments(mesh, asked)) == 3
    assert len(Printing(colours=4).filaments(mesh, asked)) == 4


@pytest.mark.parametrize("slicer", ["standard", "bambu"])
def test_a_part_of_one_filament_is_not_painted_and_costs_no_change(run, tmp_path, slicer):
    plan = run.exported(tmp_path / "part.3mf", printing=Printing(palette="#2F5FA8", slicer=slicer)).printing
    assert (plan.cost.changes, plan.offers) == (0, ())
    assert plan.words.startswith("no change of filament")
    model = zipfile.ZipFile(tmp_path / "part.3mf").read("3D/3dmodel.model")
    assert b"#2F5FA8" in model
    assert not any(word in model for word in (b"mmu_segmentation", b"MmPainting", b"paint_color"))


def test_the_unstylized_part_is_in_no_colour_of_the_prompt(run):
    plain = run.part.surface.coloured(np.full((len(run.part.surface.vertices), 3), 0.75))
    assert Printing().filaments(plain, ("#2F5FA8",)) == ("#BFBFBF",)


def test_the_filaments_of_the_user_are_in_the_file_in_their_order(run, tmp_path):
    wanted = ("#00FF00", "#111111", "#F4F1E8")
    plan = run.exported(tmp_path / "part.3mf", printing=Printing(palette=wanted, slicer="bambu")).printing
    assert plan.palette == wanted
    assert "#00FF00" not in plan.cost.palette, "no marble is green, so slot 1 stays unused"
    settings = json.loads(zipfile.ZipFile(tmp_path / "part.3mf").read("Metadata/project_settings.config"))
    assert settings["filament_colour"] == [f"{colour}FF" for colour in wanted]


def test_bands_take_few_changes_and_offer_none(run, tmp_path):
    plan = run.exported(tmp_path / "part.3mf", printing=Printing(colours=3, bands=True)).printing
    assert len(plan.cost.palette) == 3
    assert plan.cost.changes < 2 * 15, "edges of 2 mm make a border 10 layers and more"
    assert plan.offers == ()


def test_two_bodies_fill_the_part_of_the_file(run, tmp_path):
    plan = run.exported(tmp_path / "part.3mf", printing=Printing(bodies=True)).printing
    assert len(plan.palette) == 2
    assert plan.cost.changes > 0.5 * plan.cost.layers, "most layers have shell and rest"
    written = trimesh.load_mesh(tmp_path / "part.3mf")
    assert written.volume == pytest.approx(run.surface().volume, rel=1e-6)
    assert len(written.faces) > len(run.part.surface.faces)


@pytest.mark.parametrize(
    ("name", "printing", "said"),
    [
        ("part.3mf", Printing(slicer="cura"), "cura"),
        ("part.stl", Printing(slicer="prusa"), "3MF only"),
        ("part.3mf", Printing(palette="#111111,#222222", colours=3), "contradict"),
        ("part.3mf", Printing(bands=True, bodies=True), "contradict"),
        ("part.3mf", Printing(colours=17), "1 to 16"),
        ("part.3mf", Printing(palette="#111111", bodies=True), "name those of both"),
        ("part.3mf", Printing(colours=1, bodies=True), "name those of both"),
    ],
)
def test_what_cannot_be_printed_is_refused_before_anything_is_drawn(run, tmp_path, name, printing, said):
    with pytest.raises(BadInput, match=said):
        run.exported(tmp_path / name, printing=printing)
    assert not (tmp_path / name).exists()
