"""Taking away: files reach the page whole, what cannot be made is said, and the filled button leads on."""

import io
import zipfile

import numpy as np
import pytest
import trimesh
from PIL import Image

from mechstyle.errors import BadInput
from mechstyle.geometry.files import save
from mechstyle.geometry.threemf import SLICERS
from mechstyle.runs.export import Exported
from mechstyle.runs.printing import Printing
from mechstyle.runs.run import Run
from mechstyle_widgets.jupyter.frame import Frame
from mechstyle_widgets.panels.take_away import TakeAway
from mechstyle_widgets.state.studio_state import StudioState


@pytest.fixture
def sent(monkeypatch):
    """What was sent to the page: messages with their bytes."""
    sent = []
    monkeypatch.setattr(Frame, "send", lambda _frame, message, buffers=(): sent.append((message, *buffers)))
    return sent


@pytest.fixture
def take_away(done):
    return TakeAway(StudioState(done), Frame())


def test_the_part_on_show_is_saved_for_the_slicer(take_away, sent, done, monkeypatch):
    monkeypatch.setattr(Run, "exported", lambda run, path, iteration, **_: save(run.surface(iteration), path))  # a sheet has no volume
    take_away.state.iteration = 8
    take_away._buttons["3MF"].click()
    message, data = sent[0]
    assert (message["kind"], message["name"], message["type"]) == ("file", "sheet-8.3mf", "model/3mf")
    assert zipfile.is_zipfile(io.BytesIO(data))
    take_away._buttons["GLB"].click()
    saved = trimesh.load(io.BytesIO(sent[1][1]), file_type="glb", force="mesh")
    np.testing.assert_allclose(np.sort(saved.extents), np.sort(1e-3 * done.surface(8).extents), rtol=1e-3)  # GLB is in metres
    assert "sheet-8.glb is saved" in take_away._note.value


@pytest.mark.parametrize("slicer", SLICERS)
def test_the_file_is_that_of_the_slicer_chosen_and_a_picture_of_none(take_away, sent, monkeypatch, slicer):
    asked = []

    def written(_run, path, _iteration, **how):
        asked.append(how)
        path.write_bytes(b"written")

    monkeypatch.setattr(Run, "exported", written)
    take_away._slicer.value = slicer
    take_away._buttons["3MF"].click()
    take_away._buttons["GLB"].click()
    assert asked == [{"printing": Printing(slicer=slicer)}, {}]
    assert len(sent) == 2


def test_what_the_maker_of_a_file_warns_of_is_said_and_the_branch_is_in_its_name(take_away, sent, monkeypatch):
    warned = Exported(file="", lane="", iteration=0, recipe="", verdict=None, quality=None, warnings=("walls of 0.3 mm will not print",))

    def written(_run, path, _iteration, **_how):
        path.write_bytes(b"solid")
        return warned

    monkeypatch.setattr(Run, "exported", written)
    take_away.state.lane = "soft"
    take_away._buttons["STL"].click()
    assert (sent[0][0]["name"], sent[0][0]["type"], sent[0][1]) == ("sheet-soft-12.stl", "model/stl", b"solid")
    assert "walls of 0.3 mm will not print" in take_away._note.value


def test_the_lines_of_code_are_shown_and_copied(take_away, sent):
    take_away._code.click()
    assert sent[0][0]["kind"] == "text"
    assert "ms.stylize(ms.load(&#x27;sheet.stl&#x27;)" in take_away._note.value
    assert "ms.stylize(ms.load('sheet.stl')" in sent[0][0]["text"]


def test_a_picture_is_one(take_away, sent, monkeypatch):
    monkeypatch.setattr("mechstyle.runs.run.bounds_for", lambda part, _recipe: (type("B", (), {"freedom": np.ones_like(part.thickness)}),))
    take_away._buttons["Picture"].click()
    assert Image.open(io.BytesIO(sent[0][1])).format == "PNG"


def test_what_cannot_be_made_is_said(take_away, sent, monkeypatch):
    def refuse(*_):
        raise BadInput("the disk is full: make room")

    monkeypatch.setattr(Run, "report", refuse)
    take_away._buttons["Report"].click()
    assert sent == []
    assert "the disk is full: make room" in take_away.trouble
    take_away.state.iteration = 4
    assert take_away.trouble == ""


def test_there_is_nothing_to_take_before_there_is_an_iteration(fake):
    assert TakeAway(StudioState(fake.run), Frame()).layout.display == "none"
