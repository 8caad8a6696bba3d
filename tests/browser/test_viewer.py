"""The viewer as a user meets it: the mouse turns it, a click asks, another layer paints it anew, the plain part stands beside it."""

from __future__ import annotations

import numpy as np
import pytest

from mechstyle.simulation.impact import FALLING

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def shown(notebook, finished_run):
    return notebook.open(
        f"""
from mechstyle import Run
from mechstyle_widgets import RunViewer
from mechstyle_widgets import StudioState
from ipywidgets.widgets import widget as library
run = Run.open({str(finished_run.store.root)!r})
state = StudioState(run)
viewer = RunViewer(state)
viewer
"""
    )


def position(shown):
    return shown.python("print(viewer._orbit.three.position)")


def test_dragging_turns_the_part(shown):
    before, stood = shown.drawn(), position(shown)
    shown.keep("viewer-style")
    shown.drag(shown.canvas(), (0.5, 0.5), (0.7, 0.45))
    shown.changed(shown.canvas(), before)
    shown.until(f"viewer._orbit.three.position != {stood}", True)


def test_a_layer_chosen_with_the_mouse_paints_the_part(shown):
    before = shown.drawn()
    shown.page.locator(".mechstyle-viewer select").first.select_option("stress")
    shown.changed(shown.canvas(), before, 0.05)
    shown.until("(viewer.layer, state.layer)", "('stress', 'stress')")
    assert "von Mises stress at the surface [MPa]" in shown.page.locator(".mechstyle-viewer").inner_text()
    shown.keep("viewer-stress")


def test_low_stress_has_the_colour_of_the_bar(shown):
    """It was olive-black between the facets, a colour that is not on the scale."""
    shown.python(
        "import numpy as np; from dataclasses import replace; from mechstyle._colour import linear_to_srgb;"
        "s = viewer.subject.layer('stress'); before = viewer.drawings;"
        "viewer.markers = False; viewer.put(replace(s, values=np.full(len(s.values), 0.1 * s.limits[1])))"
    )
    shown.until("viewer.drawings > before", True)
    pixels = shown.pixels(shown.canvas()).reshape(-1, 3).astype(float)
    bar = np.array(eval(shown.python("print((255 * linear_to_srgb(s.scale.colours(np.array([0.1 * s.limits[1]])))[0]).tolist())")))
    part = pixels[np.ptp(pixels, axis=1) > 0.5 * np.ptp(bar)]  # the ground is grey
    assert len(part) > 0.03 * len(pixels)
    hue = np.median(part / part.max(axis=1, keepdims=True), axis=0)
    assert np.abs(hue - bar / bar.max()).max() < 0.08
    assert np.median(part.max(axis=1)) > 0.7 * bar.max()
    shown.python("viewer.markers = True; viewer.put(s)")


def test_the_limit_is_outlined_and_hatched_above(shown):
    """With a limit at the median half of the part is above it."""
    before = shown.drawn()
    shown.python(
        "import numpy as np; from dataclasses import replace;"
        "s = viewer.subject.layer('stress'); viewer.put(replace(s, threshold=float(np.median(s.values))))"
    )
    after = shown.changed(shown.canvas(), before, 0.05).astype(int)
    shown.keep("viewer-limit")
    orange = (np.abs(after - after.reshape(-1, 3).max(axis=0)).sum(axis=-1) >= 0) & (after[..., 0] > after[..., 2] + 60)
    assert 0.03 < orange.mean() < 0.4


def test_a_click_tells_all_that_is_known_of_the_place(shown):
    box = shown.canvas().bounding_box()
    shown.at_rest("viewer")
    shown.page.mouse.click(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    shown.until("viewer.probed is not None", True)
    told = shown.page.locator(".mechstyle-viewer table").inner_text()
    for name in ("place", "von Mises stress", "demand", "held back", "displacement", "wall thickness", "touched the floor"):
        assert name in told
    seen = "viewer._orbit.seen.project(viewer.subject.mesh.vertices[[viewer.probed]])[0, :2]"
    assert shown.python(f"print(np.abs({seen}).max() < 0.1)") == "True"  # the vertex is where the mouse was
    shown.keep("viewer-probed")


def test_the_plain_part_stands_beside_and_turns_along(shown):
    shown.page.get_by_role("button", name="plain").click()
    first, second = shown.drawn(0), shown.drawn(1)
    shown.drag(shown.canvas(1), (0.5, 0.5), (0.8, 0.5))
    shown.changed(shown.canvas(1), second)
    shown.changed(shown.canvas(0), first)
    shown.keep("viewer-beside")
    shown.page.get_by_role("button", name="plain").click()
    shown.until("viewer.beside", False)


def test_the_picture_can_be_saved(shown):
    shown.page.locator(".mechstyle-viewer button[title^='Make a picture']").click()
    with shown.page.expect_download() as download:
        shown.page.get_by_text("save mechstyle-stress.png").click()
    assert download.value.path().read_bytes().startswith(b"\x89PNG")


def test_the_impact_can_be_watched_and_exaggerated(shown):
    before_it = shown.python("print(viewer.layer)")
    shown.page.get_by_role("button", name="impact").click()
    shown.until("(viewer.player.impact is not None, viewer.layer)", "(True, 'moment')")
    before = shown.drawn()
    assert shown.python("print(viewer.player.frame == viewer.player.impact.peak)") == "True"
    shown.keep("viewer-impact-peak")
    shown.page.locator(".mechstyle-viewer .noUi-handle:visible").first.focus()
    shown.page.keyboard.press("Home")
    shown.until("viewer.player.frame", -FALLING)
    for _ in range(FALLING + 4):
        shown.page.keyboard.press("ArrowRight")
    shown.until("viewer.player.frame", 4)
    early = shown.changed(shown.canvas(), before, 0.05)
    shown.keep("viewer-impact")
    shown.python("viewer.player.exaggeration = 100.0")
    shown.changed(shown.canvas(), early, 0.01)
    shown.page.locator(".mechstyle-viewer button[title^='Back to']").click()
    shown.until("(viewer.player.impact, viewer.layer)", f"(None, '{before_it}')")


def test_running_the_cell_again_leaves_nothing_behind(shown):
    shown.run_all()
    count = shown.python("print(len(library._instances))")
    shown.run_all()
    shown.drawn()
    assert shown.python("print(len(library._instances))") == count
    assert shown.page.locator(".mechstyle-viewer").count() == 1
