"""`application` and the contact sheet on the command line, as far as no simulation is needed."""

import pytest
from typer.testing import CliRunner

from mechstyle.cli.app import app


def test_applications_are_listed_with_model_and_style(mechstyle):
    listed = mechstyle("application", "--json").json["applications"]
    assert listed["pill_box"] == {
        "model": "pill_box",
        "prompt": "floral patterns",
        "about": "Only the outside is stylized: pills slide out of smooth, plain cells.",
        "protect": ["inside colour"],
    }
    assert set(listed) == {"eyeglasses", "pill_box", "utensil_grip", "lampshade"}


def test_an_unknown_application_is_one_sentence(mechstyle):
    refused = mechstyle("application", "eyeglass", "--json", code=2).json["error"]
    assert "did you mean 'eyeglasses'" in refused


@pytest.mark.parametrize("path", ["sheet.jpg", "nowhere/sheet.png"])
@pytest.mark.parametrize(("what", "drawn"), [("styles", "style_sheet.contact_sheet"), ("gallery", "model_sheet.model_sheet")])
def test_a_sheet_that_cannot_be_written_is_refused_before_it_is_drawn(what, drawn, path, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(f"mechstyle.gallery.{drawn}", lambda **_: pytest.fail("it was drawn, which takes minutes"))
    refused = CliRunner().invoke(app, [what, "--sheet", path, "--json"])
    assert refused.exit_code == 2
    assert ".png file in a folder that exists" in refused.output
