"""Every model of the gallery: one closed body with printable walls that stands as it is used."""

import inspect
import json
import os
from importlib import import_module
from pathlib import Path

import manifold3d
import numpy as np
import pytest
from scipy.spatial import ConvexHull

from mechstyle import gallery
from mechstyle.errors import BadInput

# What it is: genus by design, and the box it fits with its default measures [mm].
DESIGN = {
    "pen_holder": (0, (80.0, 80.0, 100.0)),
    "phone_stand": (1, (72.0, 96.0, 104.0)),  # the triangle under the back
    "tablet_stand": (2, (128.0, 116.7, 131.8)),  # a triangle at each side
    "spectacle_frame": (2, (139.0, 49.5, 4.4)),  # two lenses
    "pill_box": (0, (142.0, 30.0, 17.2)),
    "utensil_grip": (0, (34.0, 112.0, 27.0)),
    "key_turner": (1, (104.0, 40.0, 16.0)),  # slot and pin hole meet
    "bottle_opener": (2, (122.0, 54.0, 8.0)),  # mouth and eye
    "lampshade": (1, (125.0, 125.0, 104.0)),  # open at both ends
    "vase": (0, (101.0, 101.0, 150.0)),
    "planter": (5, (106.0, 106.0, 92.0)),  # five drain holes
    "wall_hook": (2, (34.0, 100.0, 49.5)),  # two screws
    "s_hook": (0, (42.0, 76.0, 9.0)),
    "coat_hook": (0, (92.8, 121.4, 26.0)),
    "shelf_bracket": (5, (128.0, 104.0, 24.0)),  # the opening over the brace, four screws
    "corner_bracket": (4, (58.0, 42.0, 58.0)),  # four screws
    "cable_clip": (0, (50.0, 20.0, 13.0)),
    "cable_winder": (0, (92.0, 46.0, 4.5)),
    "key_tag": (1, (64.0, 30.0, 4.4)),  # an eye
    "soap_dish": (4, (124.0, 86.0, 24.0)),  # four slits
    "toothbrush_holder": (0, (72.6, 56.7, 84.0)),
    "bag_clip": (0, (120.2, 26.4, 14.0)),
    "bag_carrier": (0, (182.6, 45.1, 22.0)),
    "drawer_knob": (0, (34.0, 34.0, 28.0)),
    "drawer_organiser": (0, (152.0, 104.0, 38.0)),
    "napkin_ring": (1, (49.2, 49.2, 30.0)),  # a bore
    "coaster": (0, (96.0, 96.0, 6.0)),
    "book_end": (1, (104.0, 102.5, 132.0)),  # a window
    "door_stop": (1, (44.0, 118.0, 29.5)),  # an eye
    "tealight_holder": (0, (82.0, 82.0, 40.0)),
}
NAMES = tuple(DESIGN)


def builder(name):
    return getattr(import_module(f"mechstyle.gallery.{gallery.entry(name).module}"), name)


def measures(name):
    return {key: value.default for key, value in inspect.signature(builder(name)).parameters.items()}


def solid(mesh):
    return manifold3d.Manifold(manifold3d.Mesh64(np.array(mesh.vertices), np.array(mesh.faces, dtype=np.uint64)))


def wall_thickness(mesh, count):
    """Lengths of rays straight through the part from random places [mm], where the far side faces away from the near one.

    A ray that leaves through a face turned by less than 120 degrees runs out at an edge, which has no thickness.
    """
    body, random = solid(mesh), np.random.default_rng(0)
    chosen = random.choice(len(mesh.faces), count, p=mesh.face_areas / mesh.face_areas.sum())
    spots = np.einsum("ij,ijk->ik", random.dirichlet((1, 1, 1), count), mesh.corners[chosen])
    lengths = []
    for spot, normal in zip(spots, mesh.face_normals[chosen], strict=True):
        hits = body.ray_cast(spot - 1e-4 * normal, spot - mesh.size * normal)
        if hits and np.dot(hits[0].normal, normal) < -0.5:
            lengths.append(np.linalg.norm(np.array(hits[0].position) - spot))
    return np.array(lengths)


def centre_of_mass(mesh):
    a, b, c = np.moveaxis(mesh.corners, 1, 0)
    volumes = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
    return (volumes[:, None] * (a + b + c) / 4.0).sum(axis=0) / volumes.sum()


def resting_faces(mesh):
    return (mesh.face_normals[:, 2] < -0.9999) & (mesh.corners[:, :, 2].max(axis=1) < 1e-6)


def test_the_gallery_lists_what_is_designed():
    assert gallery.names() == NAMES
    for name in NAMES:
        assert 15 < len(gallery.describe(name)) < 80
        assert "\n" not in gallery.describe(name)


@pytest.mark.parametrize("name", NAMES)
def test_a_model_is_one_closed_body_of_its_genus(name, models):
    mesh = models[name]
    genus, _ = DESIGN[name]
    assert mesh.is_closed
    assert mesh.volume > 0
    assert len(solid(mesh).decompose()) == 1
    assert len(mesh.vertices) - len(mesh.edges) + len(mesh.faces) == 2 - 2 * genus  # Euler


@pytest.mark.parametrize("name", NAMES)
def test_a_model_has_its_size_and_stands_on_the_origin(name, models):
    mesh = models[name]
    _, size = DESIGN[name]
    assert mesh.extents == pytest.approx(size, abs=1.5)
    assert mesh.vertices[:, 2].min() == 0.0
    assert 0.5 * (mesh.vertices.min(axis=0) + mesh.vertices.max(axis=0))[:2] == pytest.approx((0.0, 0.0), abs=1e-9)


STORED = Path(__file__).with_name("models.json")
"""Volume [mm³] and area [mm²] of each model; with $MECHSTYLE_STORE_MODELS at 1 they are those of now."""


@pytest.fixture(scope="module")
def before(models):
    if os.environ.get("MECHSTYLE_STORE_MODELS") == "1":
        lines = (f"{json.dumps(name)}: {json.dumps(figures_of(models[name]))}" for name in NAMES)
        STORED.write_text("{\n" + ",\n".join(lines) + "\n}\n")
    return json.loads(STORED.read_text())


def figures_of(mesh):
    return [round(float(mesh.volume), 3), round(float(mesh.face_areas.sum()), 3)]


@pytest.mark.parametrize("name", NAMES)
def test_a_model_is_the_part_it_was_before_unless_its_change_is_stored(name, models, before):
    """The table of the gallery and every lesson are of it: whoever changes it makes them again, and then stores these."""
    assert figures_of(models[name]) == pytest.approx(before[name], rel=1e-6)


@pytest.mark.parametrize("name", NAMES)
def test_a_model_rests_on_a_flat_face_and_does_not_tip_over(name, models):
    mesh = models[name]
    flat = resting_faces(mesh)
    assert mesh.face_areas[flat].sum() > 150.0  # mm²
    hull = ConvexHull(mesh.corners[flat][:, :, :2].reshape(-1, 2))
    outside = hull.equations[:, :2] @ centre_of_mass(mesh)[:2] + hull.equations[:, 2]
    assert outside.max() < -5.0  # mm inside the edge it would tip over


@pytest.mark.parametrize("name", NAMES)
def test_walls_can_be_printed(name, models):
    thickness = wall_thickness(models[name], 700)
    assert len(thickness) > 230
    assert thickness.min() >= 1.2  # three lines of a 0.4 mm nozzle


@pytest.mark.parametrize(("name", "measure"), [(name, measure) for name in NAMES for measure in measures(name)])
def test_every_measure_shows_in_the_model(name, measure, models):
    default = measures(name)[measure]
    changed = gallery.make(name, **{measure: type(default)(1.12 * default) if isinstance(default, float) else default + 1})
    assert changed.digest != models[name].digest
    assert changed.is_closed
    assert changed.vertices[:, 2].min() == 0.0


@pytest.mark.parametrize("name", NAMES)
def test_random_measures_give_a_sound_model_or_a_sentence(name):
    random = np.random.default_rng(7)
    built = 0
    for _ in range(5):
        chosen = {key: type(value)(round(value * random.uniform(0.8, 1.2), 2)) for key, value in measures(name).items()}
        try:
            mesh = gallery.make(name, **chosen)
        except BadInput:
            continue
        built += 1
        assert mesh.is_closed
        assert wall_thickness(mesh, 150).min() > 1.19
    assert built >= 2


@pytest.mark.parametrize("value", [0.0, -3.0, 1e4, np.nan, np.inf])
@pytest.mark.parametrize(("name", "measure"), [(name, next(iter(measures(name)))) for name in NAMES])
def test_measures_out_of_range_are_refused(name, measure, value):
    with pytest.raises(BadInput, match=rf"{measure.replace('_', ' ')} is .*, but must lie in"):
        gallery.make(name, **{measure: value})


@pytest.mark.parametrize(
    ("name", "measures", "words"),
    [
        ("vase", {"lobes": 20, "relief": 4.0}, "too steep"),
        ("lampshade", {"lower": 200.0, "height": 90.0}, "lean too far"),
        ("wall_hook", {"width": 60.0}, "no room for"),
        ("utensil_grip", {"slot_depth": 110.0}, "slot depth is 110"),
        ("lampshade", {"socket": 70.0}, "socket is 70"),
        ("lampshade", {"upper": 110.0, "socket": 30.0}, "too flat"),
        ("book_end", {"window": 60.0}, "window is 60"),
    ],
)
def test_measures_that_do_not_go_together_are_refused(name, measures, words):
    with pytest.raises(BadInput, match=words):
        gallery.make(name, **measures)


def test_unknown_names_are_answered_with_the_nearest():
    with pytest.raises(BadInput, match="unknown gallery model 'penholder': did you mean 'pen_holder'"):
        gallery.make("penholder")
    with pytest.raises(BadInput, match="unknown gallery model"):
        gallery.describe("")
    with pytest.raises(BadInput, match="unknown measure of vase 'hight': did you mean 'height'"):
        gallery.make("vase", hight=100.0)
