"""What the catalogue says of the models is true of them: regions and loads are where the parts are."""

import numpy as np
import pytest

from mechstyle import gallery
from mechstyle.errors import BadInput
from mechstyle.geometry.proximity import TriangleTree
from mechstyle.geometry.region_selection import selected
from mechstyle.records.load_cases import Patch, read_loads
from mechstyle.records.regions import Inside, Outside, Rim, regions


def points_on(mesh, count=20_000):
    random = np.random.default_rng(0)
    chosen = random.choice(len(mesh.faces), count, p=mesh.face_areas / mesh.face_areas.sum())
    return np.einsum("ij,ijk->ik", random.dirichlet((1, 1, 1), count), mesh.corners[chosen])


def test_there_are_thirty_and_each_teaches_something():
    assert len(gallery.names()) == 30
    lessons = [gallery.entry(name).teaches for name in gallery.names()]
    assert len(set(lessons)) == 30
    assert all(lesson.endswith((".", "?")) and 30 < len(lesson) < 110 for lesson in lessons)


@pytest.mark.parametrize("name", gallery.names())
def test_the_region_of_its_function_is_a_part_of_it(name, models):
    mesh, given = models[name], regions(gallery.entry(name).protect)
    assert given
    places = points_on(mesh)
    for region in given:
        if isinstance(region, Inside | Outside | Rim):
            inside = selected(region, mesh, np.ones(len(mesh.vertices)))
            assert 0.0 < inside.mean() < 1.0
        else:
            share = region.contains(places).mean()
            assert 0.002 < share < 0.75, region.words


@pytest.mark.parametrize("name", [name for name in gallery.names() if gallery.entry(name).use])
def test_a_load_is_held_and_acts_on_the_part(name, models):
    mesh, use = models[name], gallery.entry(name).use
    tree, places = TriangleTree(mesh.vertices, mesh.faces), points_on(mesh)
    for place in [support.at for support in use.supports] + [load.at for load in use.loads if load.at is not None]:
        if not isinstance(place, Patch):
            continue
        spot = place.near or place.facet
        if spot is None:
            assert place.contains(places).sum() > 3, place.words
        else:
            found = tree.nearest([spot[:3]])
            nearest = np.einsum("i,ij->j", found.weights[0], mesh.vertices[mesh.faces[found.face[0]]])
            assert np.linalg.norm(nearest - spot[:3]) < 4.0, place.words


def test_a_use_is_what_a_load_file_would_say(tmp_path):
    file = tmp_path / "coat.toml"
    file.write_text(
        '[[case]]\nname = "heavy coat"\nsupports = [{ at = "resting face" }]\n'
        "loads = [{ at = { near = [0, -16, 38.5, 5] }, force = [0, -80, 0] }]\n"
    )
    assert read_loads(file) == (gallery.use_of("gallery:wall_hook"),)
    with pytest.raises(BadInput, match="coaster carries nothing in its use"):
        gallery.use_of("gallery:coaster")
    with pytest.raises(BadInput, match="did you mean 'wall_hook'"):
        gallery.use_of("gallery:wallhook")
