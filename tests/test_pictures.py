"""Pictures of README and pages are those that were noted, and none is older than the physics it shows."""

import hashlib
import importlib.util
import sys

import msgspec
import pytest
from PIL import Image

from mechstyle.simulation.physics import PHYSICS_VERSION
from support import ROOT
from support.records import row, verdict


@pytest.fixture(scope="module")
def pictures():
    spec = importlib.util.spec_from_file_location("pictures_of_docs", ROOT / "benchmarks" / "pictures.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(ROOT / "benchmarks")  # as where it runs as a script: it takes the sheets from beside it
        spec.loader.exec_module(module)
    yield module
    del sys.modules[spec.name]


@pytest.fixture(scope="module")
def listed(pictures):
    return msgspec.json.decode(pictures.LIST.read_bytes(), type=dict[str, pictures.Made])


def test_every_picture_of_a_page_is_noted_and_as_it_was_made(pictures, listed):
    assert set(listed) == pictures.shown_in_pages(), "make pictures, or python benchmarks/pictures.py --note"
    for name, made in listed.items():
        path = pictures.file_of(name)
        assert hashlib.sha256(path.read_bytes()).hexdigest() == made.digest, f"{path.name} is not the one that was noted"
        with Image.open(path) as opened:
            assert opened.size == tuple(made.size)


def test_no_picture_is_older_than_the_physics_it_shows(pictures, listed):
    for _, names, simulated in pictures.GROUPS.values():
        for name in names:
            if simulated and name in listed:
                assert listed[name].physics == PHYSICS_VERSION, f"{name}.png shows physics {listed[name].physics}: make pictures"
            elif name in listed:
                assert listed[name].physics is None


def test_a_picture_that_was_changed_by_hand_or_is_new_is_found(pictures, tmp_path, monkeypatch):
    monkeypatch.setattr(pictures, "DOCS", tmp_path)
    monkeypatch.setattr(pictures, "ROOT", tmp_path)
    monkeypatch.setattr(pictures, "LIST", tmp_path / "pictures.json")
    (tmp_path / "README.md").write_text("![a](docs/tutorial.png) ![b](leaf.png) ![c](gone.png)", encoding="utf-8")
    for name, colour in (("tutorial", "red"), ("leaf", "blue"), ("unused", "grey")):
        Image.new("RGB", (4, 3), colour).save(tmp_path / f"{name}.png")
    pictures.note({"tutorial": ("tutorial", [])})
    first = msgspec.json.decode((tmp_path / "pictures.json").read_bytes())
    assert {name: one["physics"] for name, one in first.items()} == {"tutorial": PHYSICS_VERSION, "leaf": None}
    Image.new("RGB", (4, 3), "green").save(tmp_path / "tutorial.png")
    pictures.note({})
    again = msgspec.json.decode((tmp_path / "pictures.json").read_bytes())
    assert again["tutorial"]["digest"] != first["tutorial"]["digest"]
    assert again["tutorial"]["physics"] == PHYSICS_VERSION


@pytest.mark.parametrize(("doubts", "words"), [((), "holds, 0.06 mm"), (("the mesh is thicker",), "holds, not sure, 0.06 mm")])
def test_a_picture_says_of_a_verdict_that_it_is_not_sure(pictures, doubts, words):
    assert pictures.in_three_words(verdict(row(0.06), doubts=doubts)) == words
