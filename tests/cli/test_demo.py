"""`application` and the contact sheet on the command line, as far as no simulation is needed."""


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


def test_a_sheet_that_cannot_be_written_is_refused_before_it_is_drawn(mechstyle):
    for path in ("styles.jpg", "nowhere/styles.png"):
        assert ".png file in a folder that exists" in mechstyle("styles", "--sheet", path, "--json", code=2).json["error"]
