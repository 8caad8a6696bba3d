"""Textures of drawn and of learnt styles: drawn anew where they can be, else what the vertices have, and nothing where it is plain."""

import msgspec
import numpy as np
import pytest
import trimesh

from mechstyle.geometry.texture import Atlas
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.runs import texture as module
from mechstyle.runs.run import Run, stylize
from mechstyle.runs.texture import Delivered, texture_of

QUICK = {"vertices": 900, "iterations": 60, "orientations": 1, "tilts": 0, "window": 0.2, "element": "tet4", "schedule": "never",
         "base": "free", "device": "cpu", "delivered": 0}  # fmt: skip


@pytest.fixture(scope="module")
def run(tmp_path_factory) -> Run:
    folder = tmp_path_factory.mktemp("texture")
    box = trimesh.creation.box((40.0, 30.0, 20.0))
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MECHSTYLE_CACHE", str(folder / "cache"))
        mesh = SurfaceMesh(box.vertices, box.faces)
        yield stylize(mesh, "8 mm brick", out=folder / "run", protect="above 4 colour", relief=0.2, **QUICK)


def shown(run: Run) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Colours of its texture at the texels, those of the vertices between them, and the heights of both [mm]."""
    surface = run.surface()
    atlas = Atlas(len(surface.faces), module.FINER)
    flat = module._between(atlas, surface, surface.colours)
    found = texture_of(run.store, run.part, run.store.find(None, run.lane), Delivered(None, surface))
    column, row = atlas._places(np.tile(atlas._lattice, (len(surface.faces), 1)), atlas.texels.face)
    return found.pixels[row, column] / 255.0, flat, module._between(atlas, surface, surface.vertices)[:, 2]


def test_a_drawn_style_is_drawn_anew_between_the_vertices(run):
    texture, flat, height = shown(run)
    low = height < 2.0
    assert np.abs(texture - flat)[low].mean() > 0.02
    assert texture[low].std() > flat[low].std(), "its joints are sharper"
    assert np.corrcoef(texture[low].ravel(), flat[low].ravel())[0, 1] > 0.8, "and the bricks are the same"


def test_where_a_part_keeps_its_colour_the_texture_does_too(run):
    texture, flat, height = shown(run)
    assert np.abs(texture - flat)[height > 9.0].max() < 0.004


def test_what_is_known_at_vertices_only_is_interpolated(run, monkeypatch):
    recipe = msgspec.structs.replace(run.recipe, field="network")
    monkeypatch.setattr(type(run.store), "recipe", lambda _store, _digest: recipe)
    texture, flat, _ = shown(run)
    assert np.abs(texture - flat).max() < 0.004


def test_beyond_what_can_be_drawn_it_is_interpolated(run, monkeypatch):
    monkeypatch.setattr(module, "MOST_DRAWN", 100)
    texture, flat, _ = shown(run)
    assert np.abs(texture - flat).max() < 0.004
