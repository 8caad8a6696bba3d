"""The lessons' part: regular, closed, thin where it breaks; runs of a lesson find their own folders; tables escape what they show."""

from dataclasses import replace

import numpy as np
import pytest

from mechstyle import teaching
from mechstyle.errors import BadInput
from mechstyle.simulation.part import prepare


def test_the_pawn_is_closed_stands_and_is_thinnest_at_its_neck():
    part = teaching.pawn()
    assert part.is_closed
    assert part.vertices[:, 2].min() == 0.0
    assert part.volume == pytest.approx(part.tets.volumes.sum(), rel=1e-6)
    x, y, z = part.vertices.T
    neck = (z > 21.0) & (z < 37.0)
    assert np.hypot(x, y)[neck].max() < 8.6
    assert np.hypot(x, y)[~neck].max() == pytest.approx(15.0)


@pytest.mark.parametrize(("stem", "head"), [(12.0, 28.0), (9.0, 28.0), (14.0, 36.0)])
def test_the_trophy_is_closed_stands_on_a_foot_and_prints_without_support(stem, head):
    part = teaching.trophy(stem, head)
    assert part.is_closed
    assert part.tets.volumes.min() > 0.0
    assert part.volume == pytest.approx(part.tets.volumes.sum(), rel=1e-6)
    x, y, z = part.vertices.T
    radius = np.hypot(x, y)
    assert radius[(z > 14.0) & (z < 50.0)].max() == pytest.approx(0.5 * stem, abs=0.02)
    assert radius[z > 51.0].max() == pytest.approx(0.5 * head, rel=0.03)
    hangs = part.face_normals[:, 2][part.vertices[part.faces][:, :, 2].min(axis=1) > 0.0].min()
    assert hangs > -np.sin(np.radians(50.0)), "a cone of 40°, a little more where its smooth line turns"
    assert prepare(part).stands


def test_every_class_has_the_same_part_however_many_vertices_it_asks_for():
    again = teaching.turned(teaching.PROFILE, teaching.RINGS, teaching.LAYERS)
    for vertices in (900, 25_000):
        part = prepare(teaching.pawn(), vertices=vertices, relief=lambda shape, **_: np.ones(len(shape.surface.vertices), np.float32))
        assert part.tets.digest == again.digest
        assert part.surface.digest == again.boundary.digest
        assert part.at is None
        assert part.stands


def test_tetrahedra_of_another_surface_are_refused():
    """The unsafe side: a thinner part would be judged by the tetrahedra of the thicker one."""
    part = teaching.pawn()
    with pytest.raises(BadInput, match="fill another surface: leave them out"):
        prepare(replace(part, vertices=part.vertices * [0.5, 0.5, 1.0]))


@pytest.mark.parametrize("rings", [(6, 12, 18, 24, 30, 36), (6, 18, 36)])
def test_a_cylinder_has_its_volume_and_no_tetrahedron_is_inside_out(rings):
    body = teaching.turned([(5.0, 0.0), (5.0, 20.0)], rings, 12)
    assert body.volumes.min() > 0.0
    polygon = 0.5 * 36 * 25.0 * np.sin(2 * np.pi / 36) * 20.0
    assert body.volumes.sum() == pytest.approx(polygon, rel=1e-9)
    assert len(body.boundary.vertices) == 2 * (1 + sum(rings)) + 11 * 36


def test_runs_with_other_settings_have_folders_of_their_own_and_the_same_is_found(tmp_path, monkeypatch):
    monkeypatch.setattr(teaching.Run, "go", lambda run, *_: run)
    free, masked, again = (teaching.run(folder=tmp_path, **given) for given in ({"freely": True}, {}, {"freely": True}))
    assert free.store.root == again.store.root != masked.store.root
    assert not free.recipe.restraint.feedback
    assert (masked.recipe.style.relief, masked.recipe.schedule.iterations, masked.recipe.schedule.when) == (3.0, 40, "stress")
    with pytest.raises(BadInput):
        teaching.run(folder=tmp_path, no_such_setting=1)


def test_runs_that_land_flat_fall_from_higher_and_in_one_way(tmp_path, monkeypatch):
    monkeypatch.setattr(teaching.Run, "go", lambda run, *_: run)
    recipe = teaching.flat(folder=tmp_path).recipe
    assert (recipe.test.nearly_flat, recipe.test.height, recipe.test.tolerance) == (False, 12_000.0, 0.1)
    assert teaching.flat(folder=tmp_path, height="6 m").recipe.test.height == 6000.0


def test_a_table_is_even_in_a_terminal_and_plain_in_a_notebook():
    made = teaching.Table(("run", "why"), [("a", "<b>x</b>"), ("long name", "y & z")])
    assert repr(made).splitlines() == ["run        why", "a          <b>x</b>", "long name  y & z"]
    assert made._repr_html_().count("<tr>") == 3
    assert "&lt;b&gt;" in made._repr_html_()
