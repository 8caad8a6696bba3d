"""The lessons' part: regular, closed, thin where it breaks; runs of a lesson find their own folders; tables escape what they show."""

import numpy as np
import pytest

from mechstyle import teaching
from mechstyle.errors import BadInput


def test_the_trophy_is_closed_stands_and_is_thinnest_at_its_neck():
    part = teaching.trophy()
    surface, body = part.surface, part.tets
    assert surface.is_closed
    assert surface.vertices[:, 2].min() == 0.0
    assert surface.volume == pytest.approx(body.volumes.sum(), rel=1e-6)
    x, y, z = surface.vertices.T
    neck = (z > 20.0) & (z < 32.0)
    assert np.hypot(x, y)[neck].max() < 6.6
    assert part.thickness[neck].mean() < 0.6 * part.thickness[z > 48.0].mean()


def test_every_class_has_the_same_part():
    again = teaching.turned(teaching.PROFILE, teaching.RINGS, teaching.LAYERS)
    assert again.digest == teaching.trophy().tets.digest


def test_a_cylinder_has_its_volume_and_no_tetrahedron_is_inside_out():
    body = teaching.turned([(5.0, 0.0), (5.0, 20.0)], 6, 12)
    assert body.volumes.min() > 0.0
    polygon = 0.5 * 36 * 25.0 * np.sin(2 * np.pi / 36) * 20.0
    assert body.volumes.sum() == pytest.approx(polygon, rel=1e-9)
    assert len(body.tets) == 6 * 6**2 * 12 * 3


def test_runs_with_other_settings_have_folders_of_their_own_and_the_same_is_found(tmp_path, monkeypatch):
    monkeypatch.setattr(teaching.Run, "go", lambda run, *_: run)
    free, masked, again = (teaching.run(folder=tmp_path, **given) for given in ({"freely": True}, {"schedule": "stress"}, {"freely": True}))
    assert free.store.root == again.store.root != masked.store.root
    assert not free.recipe.restraint.feedback
    assert (masked.recipe.style.relief, masked.recipe.schedule.iterations) == (3.0, 40)
    with pytest.raises(BadInput):
        teaching.run(folder=tmp_path, no_such_setting=1)


def test_a_table_is_even_in_a_terminal_and_plain_in_a_notebook():
    made = teaching.Table(("run", "why"), [("a", "<b>x</b>"), ("long name", "y & z")])
    assert repr(made).splitlines() == ["run        why", "a          <b>x</b>", "long name  y & z"]
    assert made._repr_html_().count("<tr>") == 3
    assert "&lt;b&gt;" in made._repr_html_()
