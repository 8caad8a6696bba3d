"""3MF packages: valid against what the specification asks of a mesh, exact, deterministic, with few colours."""

import io
import warnings
import zipfile
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from mechstyle.geometry import threemf
from mechstyle.geometry.threemf import MOST_COLOURS, reduced_colours, threemf_bytes

CORE = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"
MATERIAL = "{http://schemas.microsoft.com/3dmanufacturing/material/2015/02}"


def rainbow(count):
    """`count` different colours, shape [count, 3]."""
    return np.random.default_rng(4).random((count, 3)).astype(np.float32)


def model_of(mesh):
    with zipfile.ZipFile(io.BytesIO(threemf_bytes(mesh))) as package:
        return ET.fromstring(package.read("3D/3dmodel.model"))


def written_colours(model):
    """The colour of every face corner as in the file, shape [face_count, 3, 3], uint8."""
    group = model.find(f"{CORE}resources/{MATERIAL}colorgroup")
    palette = np.array([list(bytes.fromhex(colour.get("color")[1:])) for colour in group], dtype=np.uint8)
    triangles = model.findall(f".//{CORE}triangle")
    assert {triangle.get("pid") for triangle in triangles} == {group.get("id")}
    return palette[[[int(triangle.get(p)) for p in ("p1", "p2", "p3")] for triangle in triangles]]


# --- the package --------------------------------------------------------------------------------------------------


def test_the_package_has_its_three_parts_and_they_refer_to_each_other(cube):
    with zipfile.ZipFile(io.BytesIO(threemf_bytes(cube))) as package:
        assert package.testzip() is None
        assert package.namelist() == ["[Content_Types].xml", "_rels/.rels", "3D/3dmodel.model"]
        types = ET.fromstring(package.read("[Content_Types].xml"))
        relations = ET.fromstring(package.read("_rels/.rels"))
        assert {entry.get("Extension") for entry in types} == {"rels", "model"}
        assert [relation.get("Target").lstrip("/") for relation in relations] == ["3D/3dmodel.model"]
        assert relations[0].get("Type") == "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"


@pytest.mark.parametrize("coloured", [False, True])
def test_the_model_is_in_millimetres_and_builds_its_one_object(cube, coloured):
    model = model_of(cube.coloured(rainbow(8)) if coloured else cube)
    assert model.tag == f"{CORE}model"
    assert model.get("unit") == "millimeter"
    objects, items = model.findall(f"{CORE}resources/{CORE}object"), model.findall(f"{CORE}build/{CORE}item")
    assert [item.get("objectid") for item in items] == [thing.get("id") for thing in objects]
    ids = [resource.get("id") for resource in model.find(f"{CORE}resources")]
    assert len(ids) == len(set(ids)) == 1 + coloured
    assert ids.index(objects[0].get("id")) == coloured  # a resource stands before what refers to it
    assert objects[0].get("pid") == (ids[0] if coloured else None)


def test_vertices_and_faces_are_exact_to_nine_digits(sphere):
    turned = sphere.moved(sphere.vertices @ np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0] + 80.0)
    model = model_of(turned)
    vertices = np.array([[float(vertex.get(axis)) for axis in "xyz"] for vertex in model.iter(f"{CORE}vertex")])
    faces = np.array([[int(triangle.get(corner)) for corner in ("v1", "v2", "v3")] for triangle in model.iter(f"{CORE}triangle")])
    assert np.abs(vertices - turned.vertices).max() <= 5e-8  # half a unit of the ninth digit of 10 to 100 mm
    assert np.array_equal(faces, turned.faces)


def test_an_uncoloured_mesh_has_no_colours(cube):
    model = model_of(cube)
    assert model.find(f".//{MATERIAL}colorgroup") is None
    assert all(set(triangle.attrib) == {"v1", "v2", "v3"} for triangle in model.iter(f"{CORE}triangle"))


def test_few_colours_are_written_to_every_corner_exactly(cube):
    colours = rainbow(8)
    assert np.array_equal(written_colours(model_of(cube.coloured(colours))), np.round(colours * 255).astype(np.uint8)[cube.faces])


def test_many_colours_are_written_as_the_palette(sphere):
    colours = 0.5 + 0.05 * sphere.vertices.astype(np.float32)
    palette, index = reduced_colours(colours)
    model = model_of(sphere.coloured(colours))
    assert len(model.find(f".//{MATERIAL}colorgroup")) == len(palette) <= MOST_COLOURS
    assert np.array_equal(written_colours(model), palette[index][sphere.faces])


def test_the_same_mesh_gives_the_same_bytes(sphere):
    mesh = sphere.coloured(rainbow(len(sphere.vertices)))
    assert threemf_bytes(mesh) == threemf_bytes(mesh)


# --- the palette --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("count", [1, 2, MOST_COLOURS])
def test_few_colours_are_kept_exactly(count):
    colours = np.tile(rainbow(count), (3, 1))
    palette, index = reduced_colours(colours)
    assert len(palette) == count
    assert np.array_equal(palette[index], np.round(colours * 255).astype(np.uint8))


def test_colours_out_of_range_are_clipped():
    palette, index = reduced_colours(np.array([(-1.0, 0.5, 2.0)], dtype=np.float32))
    assert palette[index].tolist() == [[0, 128, 255]]


@pytest.mark.parametrize("most", [2, 5, 48])
def test_a_palette_has_no_more_colours_than_asked_for_all_used_and_different(most):
    palette, index = reduced_colours(rainbow(3000), most)
    assert 1 < len(palette) <= most
    assert np.array_equal(np.unique(index), np.arange(len(palette)))
    assert len(np.unique(palette, axis=0)) == len(palette)


def test_a_palette_stays_close_to_smooth_colours():
    """48 cells in the unit cube are about 48^(-1/3) = 0.28 wide, and a point of a cube is 0.48 of its width from the middle (rms)."""
    colours = rainbow(3000)
    palette, index = reduced_colours(colours)
    assert np.sqrt(((palette[index] / 255 - colours) ** 2).sum(axis=1).mean()) < 0.5 * MOST_COLOURS ** (-1 / 3) * 1.1


def test_separate_hues_are_told_apart():
    """Three clouds wide by a tenth, a palette of three: one colour each, near their middles."""
    middles = np.array([(0.9, 0.1, 0.1), (0.1, 0.9, 0.1), (0.1, 0.1, 0.9)])
    colours = np.repeat(middles, 200, axis=0) + np.random.default_rng(1).uniform(-0.1, 0.1, (600, 3))
    palette, index = reduced_colours(colours.astype(np.float32), 3)
    assert np.abs(palette[index].reshape(3, 200, 3) / 255 - middles[:, None]).max() < 0.02


def test_a_cluster_that_runs_empty_is_a_colour_less_and_no_warning(monkeypatch):
    """Rare, so the clustering stands in here; under pytest a warning would be an error."""

    def clusters(points, count, **_):
        warnings.warn("One of the clusters is empty.", stacklevel=1)
        return np.linspace(0, 1, count)[:, None].repeat(3, axis=1), np.full(len(points), 2)

    monkeypatch.setattr(threemf, "kmeans2", clusters)
    palette, index = reduced_colours(rainbow(100), 3)
    assert palette.tolist() == [[255, 255, 255]]
    assert index.tolist() == [0] * 100


def test_rare_colours_do_not_spoil_the_common_one():
    colours = np.full((5000, 3), 0.5, dtype=np.float32)
    colours[:60] += np.linspace(0, 0.4, 60, dtype=np.float32)[:, None]
    palette, index = reduced_colours(colours)
    assert len(palette) <= MOST_COLOURS
    assert np.abs(palette[index] / 255 - colours).max() < 0.03


def test_the_same_colours_give_the_same_palette():
    colours = rainbow(1000)
    first, second = reduced_colours(colours), reduced_colours(colours)
    assert np.array_equal(first[0], second[0])
    assert np.array_equal(first[1], second[1])
