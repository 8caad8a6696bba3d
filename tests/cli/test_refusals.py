"""Bad input gets one clear sentence, a non-zero exit, and leaves nothing behind."""

from __future__ import annotations

import json

import numpy as np
import pytest
import trimesh


def box(tmp_path, name="box.stl", extents=(40.0, 30.0, 20.0)):
    path = tmp_path / name
    trimesh.creation.box(extents).export(path)
    return path


def refused(mechstyle, *arguments, code=2):
    """The sentence a command was refused with; nothing may be left in the folder."""
    before = sorted(path.name for path in mechstyle.folder.iterdir())
    outcome = mechstyle.here(*arguments, code=code)
    assert outcome.stdout == ""
    assert "Traceback" not in outcome.stderr
    assert sorted(path.name for path in mechstyle.folder.iterdir()) == before
    lines = [line for line in outcome.stderr.splitlines() if line.startswith("error:")]
    assert len(lines) == 1
    return lines[0]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--prompt", "brik wall", "--material", "PLAA"), "unknown material 'PLAA': did you mean"),
        (("--prompt", "zzyzx"), "zzyzx"),
        (("--prompt", "brick", "--control", "exponental"), "did you mean 'exponential'"),
        (("--prompt", "brick", "--schedule", "stres"), "did you mean 'stress'"),
        (("--prompt", "brick", "--criterion", "robst"), "did you mean 'robust'"),
        (("--prompt", "brick", "--iterations", "0"), "iterations is 0, but must lie between 1 and"),
        (("--prompt", "brick", "--amplitude", "-1"), "amplitude is -1"),
        (("--prompt", "brick", "--orientations", "0"), "orientations is 0"),
        (("--prompt", "brick", "--infill", "15"), 'an infill of 15 is no share of the inside: write "15 %"'),
        (("--prompt", "brick", "--infill", "15 %", "--walls", "-1"), "walls is -1, but must lie between 0 and 100"),
        (("--prompt", "brick", "--infill", "15 %", "--infill-pattern", "gyriod"), "did you mean 'gyroid'"),
        (("--prompt", "brick", "--sliced", "gone.gcode"), "gone.gcode: No such file or directory: name the G-code"),
        (("--prompt", "brick", "--minimum-wall", "-1"), "minimum wall is -1"),
        (("--prompt", "brick", "--load", "none.toml"), "load file none.toml does not exist"),
        (("--prompt", "brick", "--device", "cuda"), "device"),
        (("--prompt", "brick", "--device", "tpu"), "unknown device 'tpu'"),
        (("--prompt", "brick", "--guidance", "clp"), "unknown guidance 'clp': did you mean 'clip'"),
        (("--prompt", "zebra", "--guidance", "clip"), "`mechstyle weights fetch ViT-B-32`"),
    ],
)
def test_values_out_of_the_question(mechstyle, arguments, said):
    assert said in refused(mechstyle, "run", "gallery:pen_holder", *arguments, "--out", "part")


def test_an_unknown_gallery_model_names_the_nearest(mechstyle):
    assert "did you mean 'pen_holder'" in refused(mechstyle, "run", "gallery:pen_holdr", "--prompt", "brick")


def test_a_missing_file(mechstyle):
    assert "nowhere.stl" in refused(mechstyle, "run", "nowhere.stl", "--prompt", "brick")


def test_an_empty_file(mechstyle):
    (mechstyle.folder / "empty.stl").touch()
    assert "empty.stl" in refused(mechstyle, "run", "empty.stl", "--prompt", "brick")


def test_a_truncated_file(mechstyle):
    path = box(mechstyle.folder, "cut.stl")
    path.write_bytes(path.read_bytes()[:-70])
    assert "cut.stl" in refused(mechstyle, "run", "cut.stl", "--prompt", "brick")


def test_something_that_is_no_mesh(mechstyle):
    (mechstyle.folder / "letter.obj").write_text("Dear Sir or Madam\n")
    assert "letter.obj" in refused(mechstyle, "run", "letter.obj", "--prompt", "brick")


def test_a_mesh_with_nan(mechstyle):
    mesh = trimesh.creation.box((40, 30, 20))
    text = trimesh.exchange.obj.export_obj(mesh).replace("20.00000000", "nan", 1)
    assert "nan" in text
    (mechstyle.folder / "holes.obj").write_text(text)
    assert "holes.obj" in refused(mechstyle, "run", "holes.obj", "--prompt", "brick")


def test_a_part_in_metres_is_told_its_size_and_the_unit(mechstyle):
    box(mechstyle.folder, "tiny.stl", (0.04, 0.03, 0.02))
    assert "--unit m" in refused(mechstyle, "run", "tiny.stl", "--prompt", "brick")


def test_two_separate_bodies(mechstyle):
    a, b = trimesh.creation.box((20, 20, 20)), trimesh.creation.box((20, 20, 10))
    b.apply_translation((60, 0, 0))
    trimesh.util.concatenate([a, b]).export(mechstyle.folder / "two.stl")
    assert "choose it with --body 1" in refused(mechstyle, "run", "two.stl", "--prompt", "brick")
    assert "holds no body 'lid'" in refused(mechstyle, "simulate", "two.stl", "--body", "lid")
    looked = mechstyle.here("protect", "two.stl", "--body", "2", "--protect", "above 900", code=2)
    assert "two.stl: 20 × 20 × 10 mm, 5 g in solid PLA" in looked.stderr
    assert "reaches from 50 -10 -5 to 70 10 5" in looked.stderr


def test_a_surface_that_is_wide_open(mechstyle):
    mesh = trimesh.creation.icosphere(subdivisions=3, radius=20)
    mesh.update_faces(mesh.triangles_center[:, 2] < 2.0)
    mesh.update_faces(np.abs(mesh.triangles_center[:, 0]) > 4.0)
    mesh.export(mechstyle.folder / "shell.stl")
    outcome = mechstyle("run", "shell.stl", "--prompt", "brick", code=None)
    assert outcome.code == 2
    assert "shell.stl" in outcome.stderr


def test_a_bad_scale(mechstyle):
    box(mechstyle.folder)
    assert "scale" in refused(mechstyle, "run", "box.stl", "--prompt", "brick", "--scale", "0")


def test_a_bad_material_file(mechstyle):
    (mechstyle.folder / "wood.toml").write_text('name = "wood"\nyoungs_modulus = "stiff"\n')
    assert "wood.toml" in refused(mechstyle, "run", "gallery:pen_holder", "--prompt", "brick", "--material", "wood.toml")


def test_a_folder_that_is_no_run(mechstyle):
    (mechstyle.folder / "photos").mkdir()
    assert "is not a run directory" in refused(mechstyle, "log", "photos")


def test_a_directory_with_something_else_in_it_is_not_written_to(mechstyle):
    (mechstyle.folder / "photos").mkdir()
    (mechstyle.folder / "photos" / "cat.jpg").write_bytes(b"meow")
    said = refused(mechstyle, *mechstyle.styled, "--out", "photos")
    assert "is not a run directory" in said


def test_with_json_the_sentence_is_json_too(mechstyle):
    outcome = mechstyle.here("run", "nowhere.stl", "--prompt", "brick", "--json", code=2)
    assert "nowhere.stl" in json.loads(outcome.stdout)["error"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("run", "gallery:vase", "--nonsense"), "--nonsense"),
        (("run", "gallery:vase", "--prompt", "brick", "--iterations", "many"), "--iterations"),
        (("run",), "MODEL"),
        (("rum",), "rum"),
        (("--nonsense",), "--nonsense"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_with_json_a_wrong_command_line_is_json_too(mechstyle, arguments, said):
    assert said in json.loads(mechstyle.here(*arguments, "--json", code=2).stdout)["error"]


def test_a_picture_is_a_png_and_called_so(finished, tmp_path):
    line, root, _ = finished
    said = line.here("show", root, "--out", tmp_path / "part.jpg", code=2).stderr
    assert f"give {tmp_path / 'part.png'} instead of {tmp_path / 'part.jpg'}" in said
    assert not (tmp_path / "part.jpg").exists()


def test_a_log_is_of_whole_lanes(finished):
    line, root, _ = finished
    assert "lists whole lanes" in line.here("log", f"{root}@main:3", code=2).stderr
    assert "unknown lane" in line.here("log", f"{root}@mian", code=2).stderr


def test_an_unknown_export_format(finished):
    line, root, _ = finished
    assert "did you mean" in line.here("export", f"{root}", "--format", "3fm", code=2).stderr


def test_a_damaged_object_is_named(finished, tmp_path):
    import shutil  # noqa: PLC0415 — used here only

    line, root, _ = finished
    copy = tmp_path / "damaged"
    shutil.copytree(root, copy)
    for path in (copy / "objects").rglob("*"):
        if path.is_file():
            path.write_bytes(b"rust")
    assert "restore it" in line.here("log", copy, code=2).stderr


@pytest.mark.parametrize("command", ["materials", "styles", "gallery", "doctor"])
def test_lists_print_one_json_object(mechstyle, command):
    assert mechstyle.here(command, "--json").json
    assert mechstyle.here(command).stdout.strip()


@pytest.mark.parametrize("command", ["materials", "styles", "gallery"])
def test_lists_are_printed_whatever_signs_a_terminal_has(mechstyle, monkeypatch, command):
    """As under Windows' cp1252, which has no ρ: ascii, which lacks even more and can be read back by anybody."""
    known = mechstyle.here(command, "--json").json
    monkeypatch.setenv("PYTHONIOENCODING", "ascii")
    assert mechstyle.here(command, "--json").json == known
    assert mechstyle.here(command).stdout.strip()
