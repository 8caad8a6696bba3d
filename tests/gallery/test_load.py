"""A part is opened in one way, be it a file or a model of the gallery, and says where it came from."""

from pathlib import Path

import numpy as np
import pytest

import mechstyle as ms
from mechstyle.errors import BadInput
from mechstyle.gallery import addressed
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.simulation.part import Origin
from support.part_files import put
from support.slicer_files import BESIDE, PLATE, mesh, model, package, thing


def test_a_model_is_loaded_by_its_address(models):
    vase = ms.load("gallery:vase")
    assert (vase.digest, vase.name, vase.notes) == (models["vase"].digest, "vase", ())
    assert vase.origin == Origin(model="gallery:vase")


@pytest.mark.parametrize("kind", [str, Path])
def test_a_file_is_loaded_by_its_path_with_what_was_done_to_it(tmp_path, cube, kind):
    path = ms.save(cube, tmp_path / "brick.stl")
    mesh = ms.load(kind(path), scale=2.5)
    assert np.allclose(mesh.extents, 2.5 * cube.extents)
    assert (mesh.name, mesh.origin) == ("brick", Origin(model="brick.stl", scale=2.5))
    assert mesh.notes[:2] == ("25 × 25 × 25 mm, 19 g in solid PLA", "converted to millimetres (times 2.5)")


@pytest.mark.parametrize(
    ("address", "scale", "said"),
    [
        ("gallery:vse", None, "unknown gallery model 'vse': did you mean 'vase'"),
        ("gallery:vase", 25.4, "gallery:vase: scale, unit, size, body and an axis for up are for files; gallery models are in millimetres"),
        ("vase", None, "vase is a model of the gallery: write gallery:vase"),
        ("cup", None, "cup does not exist in "),
    ],
)
def test_an_address_that_cannot_be_opened_is_refused(address, scale, said):
    with pytest.raises(BadInput, match=said):
        ms.load(address, scale=scale)


def test_what_is_made_from_a_loaded_surface_does_not_claim_to_be_it():
    vase = ms.load("gallery:vase")
    zero, grey = np.zeros(len(vase.vertices)), np.full(vase.vertices.shape, 0.5)
    for made in (vase.moved(vase.vertices), vase.displaced(zero), vase.coloured(grey)):
        assert type(made) is SurfaceMesh
        assert np.array_equal(made.faces, vase.faces)
    assert repr(vase) == repr(vase.moved(vase.vertices))


def test_a_body_of_a_file_is_remembered_with_how_it_was_read(tmp_path):
    both = thing(1, mesh(PLATE)) + thing(2, mesh(BESIDE))
    path = put(tmp_path, "plate.3mf", package(model(both, '<item objectid="1"/><item objectid="2"/>')))
    part = ms.load(path, body=2, unit="mm", up="-z")
    assert part.extents == pytest.approx((10, 10, 30))
    assert part.origin == Origin(model="plate.3mf", unit="mm", up="-z", body="2")
    assert part.origin.reading == {"unit": "mm", "up": "-z", "body": "2"}


@pytest.mark.parametrize(
    ("said", "extents", "origin"),
    [
        ("body=2", (10, 10, 30), {"body": "2"}),
        ("unit=cm,body=2", (100, 100, 300), {"unit": "cm", "body": "2"}),
        ("body=lid, left,size=60", (20, 20, 60), {"body": "lid, left", "size": 60.0}),
        ("scale=2,up=x,body=2", (20, 20, 60), {"scale": 2.0, "up": "x", "body": "2"}),
    ],
)
def test_an_address_says_how_its_file_is_read(tmp_path, said, extents, origin):
    """A study names many files, and a styled part its plain one: each says for itself which body of what unit it is."""
    both = thing(1, mesh(PLATE)) + thing(2, mesh(BESIDE), 'type="model" name="lid, left"')
    path = put(tmp_path, "plate.3mf", package(model(both, '<item objectid="1"/><item objectid="2"/>')))
    part = ms.load(f"{path}#{said}")
    assert sorted(part.extents) == pytest.approx(sorted(extents))
    assert (part.name, part.origin) == ("plate", Origin(model="plate.3mf", **origin))
    assert addressed(f"{path}#{said}") == (str(path), origin)


@pytest.mark.parametrize(
    ("address", "said"),
    [
        ("brick.stl#size=large", "size is 'large' in the address of 'brick.stl', but must be a number, such as size=25.4"),
        ("brick.stl#size=2\n\t[red]" + 600 * "x", r"size is '2\\n\\t\[red\]x{32}' in the address of 'brick.stl', but must be"),
        ("brick.stl#unit=parsec", "unknown unit 'parsec'"),
        ("brick.stl#unit=in,size=5", "a unit and a size are given"),
        ("brick.stl#colour=red", "unknown word on how a file is read 'colour': known are body, scale, size, unit, up"),
        ("brick\n.stl", "holds signs that are no letters: give the file another name"),
        ("brick.stl#body=" + "lid" * 2000, "holds no body"),
        ("brick" * 2000 + ".stl", "does not exist"),
    ],
)
def test_an_address_that_says_nonsense_is_refused(tmp_path, cube, address, said):
    ms.save(cube, tmp_path / "brick.stl")
    with pytest.raises(BadInput, match=said):
        ms.load(tmp_path / address)
