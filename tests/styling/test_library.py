"""What holds for every style, whatever it draws."""

import importlib
import subprocess
import sys

import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.styling import styles
from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.library import FAMILIES, library, names, style_named
from mechstyle.styling.style import Style

STUDY = {"brick", "stone", "cactus", "realistic", "crochet", "green"}  # of Faruqi et al. (2025)


def test_the_styles_of_the_study_are_there_and_each_is_found_by_its_name():
    assert set(names()) >= STUDY
    assert [style.name for style in library().values()] == list(names())


@pytest.mark.parametrize("family", FAMILIES)
def test_a_family_holds_the_styles_it_is_listed_with(family):
    module = importlib.import_module(f"mechstyle.styling.styles.{family}")
    assert {name for name, value in vars(module).items() if isinstance(value, Style)} == set(FAMILIES[family])


def test_a_file_of_one_style_is_found_by_its_name(tmp_path, monkeypatch):
    program = "import numpy as np\n\nfrom mechstyle.styling.style import Relief, style\n\n\n"
    program += "@style('plain', feature_mm=5.0)\ndef slate(canvas):\n    return Relief(np.zeros(3), np.ones((3, 3)))\n"
    (tmp_path / "slate.py").write_text(program)
    monkeypatch.setattr(styles, "__path__", [*styles.__path__, str(tmp_path)])
    names.cache_clear()
    try:
        assert "slate" in names()
        assert style_named("slate").description == "plain"
        assert style_named("slate").program(None).height.shape == (3,)
    finally:
        names.cache_clear()
        sys.modules.pop("mechstyle.styling.styles.slate", None)


def test_an_unknown_style_is_refused_with_the_nearest_first():
    with pytest.raises(BadInput, match="did you mean 'brick'"):
        style_named("bricks")


def test_looking_at_the_names_loads_no_style():
    code = "import sys; from mechstyle.styling.library import names; assert names() and not any('.styles.' in m for m in sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.fixture(scope="module", params=names())
def style(request):
    """Every style in turn, for all tests that ask for it before the next: rows and columns of its size are solved once."""
    return style_named(request.param)


@pytest.mark.parametrize("part", ["cup", "stand", "ball"])
def test_a_style_draws_finite_relief_in_range_and_colours(style, part, blank, request):
    mesh = request.getfixturevalue(part)
    relief = style.program(blank(mesh))
    count = len(mesh.vertices)
    assert relief.height.shape == (count,)
    assert relief.colour.shape == (count, 3)
    assert np.isfinite(relief.height).all()
    assert relief.height.min() > -1.6
    assert relief.height.max() < 1.6
    # Most of it lies in about [-1, 1.2]: the amplitude means what it says.
    low, high = np.quantile(relief.height, [0.02, 0.98])
    assert -1.1 < low < high < 1.3
    assert high - low > 0.4
    assert relief.colour.min() >= 0.0
    assert relief.colour.max() <= 1.0


def test_a_style_is_decided_by_its_seed(style, cup, blank):
    first, again, other = (style.program(blank(cup, seed)) for seed in (1, 1, 2))
    assert first.height.tobytes() == again.height.tobytes()
    assert first.colour.tobytes() == again.colour.tobytes()
    assert not np.array_equal(first.height, other.height)


def test_a_style_declares_a_feature_a_print_can_show(style):
    assert 2.0 <= style.feature_mm <= 60.0
    assert style.description
    assert style.description[0].islower()


def test_courses_of_brick_are_as_high_as_declared(fine_wall):
    style = style_named("brick")
    canvas = Canvas(fine_wall, seed=0, size=1.5)
    height = style.program(canvas).height
    assert canvas.notes == []
    z = fine_wall.vertices[:, 2]
    front = np.abs(fine_wall.vertex_normals[:, 1]) > 0.9
    levels = np.unique(z[front])
    profile = np.array([height[front & (z == level)].mean() for level in levels])
    spectrum = np.abs(np.fft.rfft(profile - profile.mean()))
    courses = spectrum[1:].argmax() + 1
    # Whole courses fill the wall, so that the height is met to half a course in all.
    assert abs(np.ptp(levels) / courses / (style.feature_mm * canvas.scale) - 1.0) < 0.12


def test_mortar_is_lighter_and_deeper_than_brick(fine_wall):
    relief = style_named("brick").program(Canvas(fine_wall, seed=0, size=1.5))
    high, low = relief.height > 0.4, relief.height < -0.4
    assert low.sum() > 0.1 * len(low)
    assert relief.colour[low].mean(axis=0).min() > relief.colour[high].mean(axis=0).max()


def test_ribs_of_a_cactus_run_upwards(holder, outside):
    height = style_named("cactus").program(Canvas(holder, seed=0)).height
    angle = np.arctan2(holder.vertices[outside, 1], holder.vertices[outside, 0]).round(6)
    along = np.mean([height[outside][angle == value].var() for value in np.unique(angle)])
    assert along < 0.5 * height[outside].var()
