"""A part made ready: bounds from its walls, protection of what it stands on, and a cache that changes nothing."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from mechstyle.errors import BadInput, SimulationFailed
from mechstyle.loop.bounds import unrestrained_relief
from mechstyle.records import Recipe
from mechstyle.records.material import LIBRARY
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.records.recipe import BASES
from mechstyle.simulation import part as module
from mechstyle.simulation.part import prepare


def block() -> SurfaceMesh:
    box = trimesh.creation.box((30.0, 20.0, 12.0))
    box.apply_translation((0, 0, 6.0))
    return SurfaceMesh(box.vertices, box.faces)


@pytest.fixture(scope="module")
def ready(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MECHSTYLE_CACHE", str(tmp_path_factory.mktemp("cache")))
        first = prepare(block(), vertices=1200)
        patch.setattr(module, "standardise", None)  # a second preparation must not need it
        second = prepare(block(), vertices=1200)
    return first, second


def test_a_second_preparation_gives_the_same_bytes_from_the_cache(ready):
    first, second = ready
    assert first.surface.digest == second.surface.digest
    assert first.tets.digest == second.tets.digest
    assert np.array_equal(first.thickness, second.thickness)


def test_what_rests_on_tetrahedra_made_otherwise_is_not_recalled(tmp_path, monkeypatch):
    monkeypatch.setenv("MECHSTYLE_CACHE", str(tmp_path))
    module.cached_memo().remember("rest-of-a-part", "a digest")
    assert module.cached_memo().recall("rest-of-a-part", str) == "a digest"
    monkeypatch.setattr(module, "TETRAHEDRA", "of tomorrow")
    assert module.cached_memo().recall("rest-of-a-part", str) is None


def test_the_wall_of_a_block_is_its_shortest_side(ready):
    surface, thickness = ready[0].surface, ready[0].thickness
    top = np.abs(surface.face_normals[:, 2]) > 0.99
    middle = np.unique(surface.faces[top])
    inner = middle[(np.abs(surface.vertices[middle, 0]) < 8) & (np.abs(surface.vertices[middle, 1]) < 3)]
    assert thickness[inner] == pytest.approx(12.0, rel=0.02)


@pytest.mark.parametrize("base", BASES)
def test_relief_cuts_at_most_a_quarter_of_the_wall_but_for_the_base(ready, base):
    bounds, above = ready[0].shape.bounds(base, 0.8), ready[0].surface.vertices[:, 2] > 0.5
    assert np.all(bounds.inward[above] <= 0.25 * ready[0].thickness[above] + 1e-6)


def test_a_base_of_no_kind_is_refused(ready):
    """It was taken for a level one, whose relief goes into the part."""
    with pytest.raises(BadInput, match="base"):
        ready[0].shape.bounds("protected", 0.8)


def test_a_plain_base_is_not_free_and_all_above_it_is(ready):
    part = ready[0]
    on_floor, freedom = part.surface.vertices[:, 2] < 1e-6, part.shape.bounds("plain", 0.8).freedom
    assert part.stands
    assert freedom.dtype == np.float32
    assert np.any(on_floor)
    assert np.all(freedom[on_floor] == 0.0)
    assert np.all(freedom[~on_floor] == 1.0)
    assert np.all(part.shape.bounds("free", 0.8).freedom == 1.0)


def test_a_style_on_a_plain_base_leaves_what_it_stands_on_as_it_is(ready):
    part, recipe = ready[0], Recipe.of(prompt="brick", material=LIBRARY["PLA"])
    wild = np.random.default_rng(0).normal(0.0, 3.0, len(part.thickness)).astype(np.float32)
    relief = unrestrained_relief(wild, part.shape.bounds("plain", 0.8), recipe)
    assert np.all(relief[part.shape.level_base.standing] == 0.0)
    assert np.abs(relief[~part.shape.level_base.standing]).max() > 1.0


@pytest.mark.parametrize("minimum", [0.0, 0.8, 5.0, 30.0])
def test_a_level_base_may_be_cut_by_half_of_what_the_wall_has_above_the_minimum(ready, minimum):
    part = ready[0]
    bounds, within = part.shape.bounds("level", minimum), part.shape.level_base.resting == 1.0
    assert np.all(bounds.inward >= 0.0)
    assert bounds.inward[within] == pytest.approx(np.maximum(0.5 * (part.thickness[within] - minimum), 0.0), abs=1e-5)


@pytest.mark.parametrize("base", ["plain", "level"])
def test_a_base_that_is_plain_or_level_is_never_below_the_floor_whatever_is_proposed(ready, base):
    part = ready[0]
    wild = np.random.default_rng(0).normal(0.0, 3.0, len(part.thickness)).astype(np.float32)
    bounds, below = part.shape.bounds(base, 0.8), part.surface.vertices[:, 2].min()
    for relief in (bounds.clipped(wild), bounds.clipped(bounds.levelled(wild))):
        assert part.surface.displaced(relief).vertices[:, 2].min() >= below - 1e-6
    free = part.shape.bounds("free", 0.8)
    assert part.surface.displaced(free.clipped(wild)).vertices[:, 2].min() < below - 0.1


def test_a_ball_stands_on_nothing_and_says_so(tmp_path, monkeypatch):
    monkeypatch.setenv("MECHSTYLE_CACHE", str(tmp_path))
    monkeypatch.setattr(module, "undeformed_mesh", lambda *_: None)
    ball = trimesh.creation.icosphere(subdivisions=3, radius=15.0)
    part = prepare(SurfaceMesh(ball.vertices, ball.faces), vertices=1500)
    assert not part.stands
    assert np.all(part.shape.bounds("plain", 0.8).freedom == 1.0)
    assert "no flat face" in part.notes[0]


def test_walls_are_told_before_the_part_is_filled_which_takes_minutes_if_they_are_thin(tmp_path, monkeypatch):
    def filled(*_: object) -> None:
        raise SimulationFailed(f"filled after {told}")

    told: list[str] = []
    monkeypatch.setenv("MECHSTYLE_CACHE", str(tmp_path))
    monkeypatch.setattr(module, "undeformed_mesh", filled)
    with pytest.raises(SimulationFailed, match=r"filled after \['the part itself has a wall of .*, thinner than the 15 mm minimum"):
        prepare(block(), vertices=1200, measured=lambda shape: told.extend(shape.too_thin(15.0)))


def test_the_plain_part_is_filled_meanwhile(tmp_path, monkeypatch):
    """It is dropped as well, and its tetrahedra are known when it is."""
    filled = []

    def carried(shape, relief, _go_on):
        filled.append(("styled", shape.surface.digest))
        return None, relief

    def raised(shape, **_go_on):
        return np.ones(len(shape.surface.vertices), np.float32)

    monkeypatch.setenv("MECHSTYLE_CACHE", str(tmp_path))
    monkeypatch.setattr(module, "undeformed_mesh", lambda surface, _go_on: filled.append(("plain", surface.digest)))
    monkeypatch.setattr(module, "mesh_for_relief", carried)
    part = prepare(block(), vertices=1200, relief=raised)
    assert sorted(filled) == [("plain", part.surface.digest), ("styled", part.surface.digest)]


def test_an_open_surface_is_refused():
    closed = block()
    with pytest.raises(BadInput, match="not closed"):
        prepare(SurfaceMesh(closed.vertices, closed.faces[:-1]))


@pytest.mark.parametrize(
    ("size", "wanted", "least", "most"),
    [(20.0, 4000, 950, 1050), (60.0, 4000, 3800, 4200), (60.0, 100_000, 12_000, 16_000)],
    ids=["no finer than a printer shows", "as fine as asked", "as fine as a printer shows"],
)
def test_beyond_even_faces_a_surface_is_cut_smaller_as_far_as_a_printer_shows(tmp_path, monkeypatch, size, wanted, least, most):
    """A drawer knob of 100 000 vertices had edges of 0.2 mm and took three times the steps."""
    monkeypatch.setenv("MECHSTYLE_CACHE", str(tmp_path))
    monkeypatch.setattr(module, "EVEN", 1000)
    monkeypatch.setattr(module, "EDGE", {20.0: 1.65, 60.0: 1.4}[size])
    box = trimesh.creation.box((size, size, size))
    surface = module.standardised(SurfaceMesh(box.vertices, box.faces), wanted)
    assert least <= len(surface.vertices) <= most
    assert surface.is_closed
    assert surface.volume == pytest.approx(size**3, rel=1e-3)
