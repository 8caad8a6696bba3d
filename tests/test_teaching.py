"""The lessons' part: regular, closed, thin where it breaks; runs of a lesson find their own folders; tables escape what they show."""

from dataclasses import replace

import numpy as np
import pytest

from mechstyle import teaching
from mechstyle.errors import BadInput
from mechstyle.simulation.part import prepare
from mechstyle.simulation.simulator import DropSimulator


@pytest.mark.parametrize(("stem", "head", "lean"), [(10.0, 30.0, 12.0), (12.0, 28.0, 0.0), (9.0, 28.0, 8.0), (14.0, 36.0, 0.0)])
def test_the_trophy_is_closed_stands_on_a_foot_and_prints_without_support(stem, head, lean):
    part = teaching.trophy(stem, head, lean, (6, 24), 44)
    assert part.is_closed
    assert part.tets.volumes.min() > 0.0
    assert part.volume == pytest.approx(part.tets.volumes.sum(), rel=1e-6)
    x, y, z = part.vertices.T
    assert 2.0 * y[(z > 14.0) & (z < 50.0)].max() == pytest.approx(stem, abs=0.04)
    assert 2.0 * y[z > 51.0].max() == pytest.approx(head, rel=0.03)
    assert x[z > 60.0].mean() == pytest.approx(lean, abs=0.2)
    hangs = part.face_normals[:, 2][part.vertices[part.faces][:, :, 2].min(axis=1) > 0.0].min()
    assert hangs > -np.sin(np.radians(50.0)), "a cone of 40°, a little more where its smooth line turns"
    assert prepare(part).stands
    assert np.hypot(*part.centre_of_mass[:2]) < 0.5 * teaching.FOOT, "it does not fall over"


def test_every_class_has_the_same_part_however_many_vertices_it_asks_for():
    again = teaching.trophy.__wrapped__()
    for vertices in (900, 25_000):
        part = prepare(teaching.trophy(), vertices=vertices, relief=lambda shape, **_: np.ones(len(shape.surface.vertices), np.float32))
        assert part.tets.digest == again.tets.digest
        assert part.surface.digest == again.digest
        assert part.at is None
        assert part.stands


def test_tetrahedra_of_another_surface_are_refused():
    """The unsafe side: a thinner part would be judged by the tetrahedra of the thicker one."""
    part = teaching.trophy()
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
    assert {**masked.recipe.settings, "tolerance": teaching.STYLE["tolerance"]}.items() >= teaching.STYLE.items()
    with pytest.raises(BadInput):
        teaching.run(folder=tmp_path, no_such_setting=1)


def test_a_trophy_that_another_run_has_dropped_is_not_dropped_again(tmp_path, monkeypatch):
    dropped = DropSimulator.dropped
    falls = []
    monkeypatch.setattr(DropSimulator, "dropped", lambda *asked: (falls.append(asked), dropped(*asked))[1])
    quick = {"folder": tmp_path, "iterations": 2, "window": 0.1, "element": "tet4", "guarantee": False}
    first = teaching.run(**quick)
    before = len(falls)
    again = teaching.run(**quick, every=7)
    assert again.store.root != first.store.root
    assert len(falls) == before > 0
    assert again.simulation().landings == first.simulation().landings
    assert teaching.run(**quick, relief=1.0).finished
    assert len(falls) == before + 1, "another relief is another fall"


def test_a_table_is_even_in_a_terminal_and_plain_in_a_notebook():
    made = teaching.Table(("run", "why"), [("a", "<b>x</b>"), ("long name", "y & z")])
    assert repr(made).splitlines() == ["run        why", "a          <b>x</b>", "long name  y & z"]
    assert made._repr_html_().count("<tr>") == 3
    assert "&lt;b&gt;" in made._repr_html_()
