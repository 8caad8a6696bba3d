"""Weights on the command line: what there is, where it is, and what is said when it is not there."""


def test_the_list_names_what_can_be_fetched_and_the_path_of_ones_own_is_told(mechstyle, tiny_clip, monkeypatch):
    listed = mechstyle.here("weights", "list", "--json").json["weights"]
    assert {"name": "ViT-B-32", "source": "openai/clip-vit-base-patch32", "folder": None} in listed
    monkeypatch.setenv("MECHSTYLE_CLIP", str(tiny_clip))
    told = mechstyle.here("weights", "path", "--json").json
    assert told["folder"] == str(tiny_clip)
    assert told["identity"].startswith("tiny@")


def test_weights_that_are_not_there_are_an_error_with_the_command(mechstyle):
    outcome = mechstyle.here("weights", "path", code=2)
    assert "`mechstyle weights fetch ViT-B-32`" in outcome.stderr
    assert "did you mean 'ViT-B-32'" in mechstyle.here("weights", "fetch", "ViT-B32", code=2).stderr


def test_a_folder_that_is_no_clip_is_refused_with_a_sentence(mechstyle, tmp_path):
    (tmp_path / "pytorch_model.bin").touch()
    assert "pytorch_model.bin is pickled" in mechstyle.here("weights", "path", str(tmp_path), code=2).stderr
