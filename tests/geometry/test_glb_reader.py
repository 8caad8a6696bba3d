"""GLB as it is exported: what is packed is read, or refused by its name; what has no surface stands in nobody's way."""

import json
import struct

import numpy as np
import pytest

from mechstyle.geometry.files import bodies, read
from support.gltf_files import besides, fans, glb, packed, quantised, rod, sparse
from support.part_files import put, refusal

AREA = 12 * np.sin(2 * np.pi / 24)  # of a regular 24-gon over its radius squared
VOLUME = AREA * 20**2 * 90


@pytest.mark.parametrize(
    ("content", "near"),
    [
        (glb(rod()[0], *rod()[1:]), 1e-5),
        (quantised(), 1e-3),
        (quantised(normalised=False), 1e-3),
        (quantised("<i1"), 0.05),
        (sparse(), 1e-5),
        (sparse(based=False), 1e-5),
        (fans(), 1e-5),
        (besides(), 1e-5),
    ],
    ids=["plain", "normalised", "quantised", "in bytes", "sparse", "sparse alone", "fans and a strip", "empty ones besides"],
)
def test_the_same_rod_however_its_numbers_are_written(tmp_path, content, near):
    part = read(put(tmp_path, "rod.glb", content))
    assert part.mesh.volume == pytest.approx(VOLUME, rel=near)
    assert part.mesh.extents == pytest.approx((40, 90, 40), rel=near)


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (packed("KHR_draco_mesh_compression"), "is compressed with Draco (KHR_draco_mesh_compression): export it without that, or as STL"),
        (packed("EXT_meshopt_compression", view=True), "is compressed with meshopt (EXT_meshopt_compression)"),
        (packed("KHR_meshopt_compression", view=True), "is compressed with meshopt (KHR_meshopt_compression)"),
        (packed("ACME_spirals"), "needs an extension that is not read here (ACME_spirals)"),
    ],
)
def test_what_is_packed_is_refused_by_its_name(tmp_path, content, says):
    """It was said to claim more than it can hold, or read as points that all coincide."""
    assert says in refusal(put(tmp_path, "rod.glb", content))


@pytest.mark.parametrize("extension", ["KHR_draco_mesh_compression", "EXT_meshopt_compression"])
def test_what_is_packed_and_does_not_say_that_it_must_be_unpacked_is_refused_as_well(tmp_path, extension):
    content = packed(extension, view="meshopt" in extension)
    length = struct.unpack_from("<I", content, 12)[0]
    silent = content[20 : 20 + length].replace(b'"extensionsRequired"', b'"extensionsUntold__"')
    assert extension in refusal(put(tmp_path, "rod.glb", content[:20] + silent + content[20 + length :]))


def test_a_shape_in_many_places_is_refused_by_the_name_of_its_extension(tmp_path):
    document, points, faces = rod()
    document["nodes"][0]["extensions"] = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0}}}
    assert "places one shape many times over (EXT_mesh_gpu_instancing)" in refusal(put(tmp_path, "rod.glb", glb(document, points, faces)))


def test_a_scene_with_nothing_in_it_is_refused_as_one(tmp_path):
    document, points, faces = rod()
    document["scenes"].append({})
    document["scene"] = 1
    assert "has nothing in the scene that it shows" in refusal(put(tmp_path, "rod.glb", glb(document, points, faces)))


def test_extensions_of_the_look_alone_stand_in_nobodys_way(tmp_path):
    document, points, faces = rod()
    document["extensionsRequired"] = ["KHR_materials_unlit", "KHR_texture_transform", "KHR_lights_punctual", "EXT_texture_webp"]
    assert read(put(tmp_path, "rod.glb", glb(document, points, faces))).mesh.volume == pytest.approx(VOLUME, rel=1e-5)


@pytest.mark.parametrize(
    ("material", "said"),
    [
        ({"pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.8, 0.8, 1.0]}}, False),
        ({"pbrMetallicRoughness": {"baseColorFactor": [1.0, 0.2, 0.0, 1.0]}}, True),
        ({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}, True),
        ({"emissiveFactor": [0.0, 0.0, 0.0]}, False),
        ({"emissiveFactor": [1.0, 0.0, 0.0]}, True),
        ({"extensions": {"KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [1.0, 0.0, 0.0, 1.0]}}}, True),
        ({"extensions": {"KHR_materials_pbrSpecularGlossiness": {"diffuseTexture": {"index": 0}}}}, True),
    ],
)
def test_colours_that_are_left_out_are_said(tmp_path, material, said):
    document, points, faces = rod()
    document["materials"] = [material]
    notes = read(put(tmp_path, "rod.glb", glb(document, points, faces))).notes
    assert ("its colours are left out: a style brings its own" in notes) is said


def test_a_skeleton_that_is_not_applied_is_said(tmp_path):
    document, points, faces = rod()
    document["nodes"][0]["skin"] = 0
    document["skins"] = [{"joints": [0]}]
    notes = read(put(tmp_path, "rod.glb", glb(document, points, faces))).notes
    assert "it is read as it was modelled: its skeleton and its morphs are not applied" in notes


def changed(content, **fields):
    """A sparse rod whose listing says something else."""
    length = struct.unpack_from("<I", content, 12)[0]
    document = json.loads(content[20 : 20 + length])
    document["accessors"][0]["sparse"] |= fields
    words = json.dumps(document).encode()
    words += b" " * (-len(words) % 4)
    rest = content[20 + length :]
    return content[:8] + struct.pack("<I", 20 + len(words) + len(rest)) + struct.pack("<I4s", len(words), b"JSON") + words + rest


@pytest.mark.parametrize(
    "fields",
    [
        {"count": 10**9},
        {"count": -4},
        {"indices": {"bufferView": 2, "componentType": 5123, "byteOffset": 10**9}},
        {"values": {"bufferView": 9}},
    ],
    ids=["too many", "less than none", "beyond its end", "elsewhere"],
)
def test_a_listing_that_lies_is_refused(tmp_path, fields):
    refusal(put(tmp_path, "rod.glb", changed(sparse(), **fields)))


def test_bodies_are_numbered_in_the_order_of_the_file(tmp_path):
    document, points, faces = rod()
    document["nodes"] += [{"mesh": 0, "name": name, "translation": [x, 0, 0], "scale": [1, x, 1]} for name, x in (("b", 0.5), ("c", 0.8))]
    document["nodes"].append({"children": [1, 2]})
    document["scenes"] = [{"nodes": [0, 3]}]
    assert [one.name for one in bodies(put(tmp_path, "rod.glb", glb(document, points, faces)))] == ["rod", "b", "c"]
