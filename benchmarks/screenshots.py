"""Draws the pictures of the Studio and of a report in docs/ again, from the real ones in headless Chromium.

python benchmarks/screenshots.py                       # a run of the lessons' trophy, and a branch of it
python benchmarks/screenshots.py --states FOLDER       # every state of the Studio at four widths in both themes, to look at
python benchmarks/screenshots.py --states FOLDER --widths 1440 --themes Light
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from lab import Page, browser, laboratory

DOCS = Path(__file__).parent.parent / "docs"
WIDTH, HEIGHT = 1340, 1700  # of the window [pixels]
REPORT, SCALE = (1100, 1800), 0.75
PATIENCE = 900_000  # for a run [ms]
STUDIO = """
from mechstyle_widgets import Studio
studio = Studio(folder="trophy")
studio
"""
PAINTED = """
from mechstyle_widgets import Studio
from mechstyle_widgets.studio import TITLES
painted = Studio(protect=["sphere 12 -14 68 9", "sphere 0 -17 4 7"])
painted._groups[TITLES.index("Keep plain")].unfolded = True
painted
"""
BRANCH = "studio.branches.pin(); studio.controller.branch(20, lane='cautious', threshold=0.1)"
COMPARED = "studio._tabs.selected_index = 1; studio.state.layer = 'restraint'"


STATES = {
    "before": "pass",
    "unknown-prompt": "studio.prompt_box.prompt = 'my own idea'",
    "sheet": "studio.prompt_box.prompt = 'brick'; studio.prompt_box._chips.all = True",
    "page": "studio.prompt_box._chips.all = False; next(one for one in studio._groups if one.page).unfolded = True",
    "pull": "studio.close_page(); studio.viewer._clicks((12.0, 0.0, 82.2))",
    "finished": "studio.viewer.arrow = (); studio.controller.run()",
    "stress": "studio.state.layer = 'stress'; studio.viewer.stepped = True",
    "stays-bent": "studio.state.layer = 'stays_bent'",
    "what-if": "studio.viewer.stepped = False; studio.show_mask(); studio.mask_inspector.selector.threshold = 0.3",
    "both": "studio.state.layer = 'stress'; studio.controller.both()",
    "fallen": "studio.viewer.player.play()",
    "my-runs": "studio.viewer.player.put_away(); studio._groups[-1].unfolded = True",
    "another-part": "studio.close_page(); studio.state.pinned = None; studio.part_picker.choose('gallery:phone_stand')",
}
"""States of a Studio by name, each with what brings it on from the one before."""
WIDTHS, THEMES, BESIDE, TALL = (700, 1008, 1440, 2200), ("Light", "Dark"), 128, 3000
"""Widths of the Studio, themes of JupyterLab, what its page shows beside a Studio, and a height in which all of it is seen [pixels]."""


BUSY = "studio.previewer._busy or studio.state.status in ('preparing', 'running')"
BUSY += " or getattr(getattr(studio.viewer, 'player', None), 'working', False)"


def main() -> None:
    """Run, look and save."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--states", type=Path, metavar="FOLDER", help="put pictures of every state here instead")
    parser.add_argument("--widths", type=int, nargs="+", default=WIDTHS)
    parser.add_argument("--themes", nargs="+", choices=THEMES, default=THEMES)
    given = parser.parse_args()
    if given.states is not None:
        all_states(given.states, given.widths, given.themes)
        return
    with laboratory() as (chromium, lab, notebooks):
        of_a_run(Page(chromium, lab, "studio", STUDIO), chromium, notebooks)
        painted = Page(chromium, lab, "painted", PAINTED)
        painted.page.get_by_text("Changes as you choose").wait_for()
        keep(painted, "studio-paint")


def of_a_run(shown: Page, chromium: Any, notebooks: Path) -> None:
    """Before it, after it, and beside a branch; and its report."""
    shown.page.get_by_text("Changes as you choose").wait_for()
    keep(shown, "studio-1")
    shown.notebook.python("studio.controller.run()")
    shown.notebook.until("studio.state.status", "finished", PATIENCE)
    shown.page.locator(".mechstyle-badge").get_by_text(re.compile("HOLDS|NO WORSE|FAILS")).first.wait_for()
    keep(shown, "studio-2")
    shown.notebook.python("studio.run.report('report.html')")
    shown.notebook.python(BRANCH)
    shown.notebook.until("(studio.state.status, studio.state.lane)", "('finished', 'cautious')", PATIENCE)
    shown.notebook.python(COMPARED)
    shown.notebook.canvas(1).wait_for()
    keep(shown, "studio-3")
    size = {"width": REPORT[0], "height": REPORT[1]}
    page = chromium.new_context(viewport=size, device_scale_factor=SCALE, offline=True).new_page()
    page.goto((notebooks / "report.html").as_uri())
    page.locator("body[data-ready='replay']").wait_for()
    page.get_by_role("button", name="Beside the original").click()
    page.evaluate(browser.SETTLED)
    page.screenshot(path=DOCS / "report.png")


def all_states(folder: Path, widths: Sequence[int], themes: Sequence[str]) -> None:
    """Bring a Studio from state to state, and save each at every width in every theme."""
    folder.mkdir(parents=True, exist_ok=True)
    with laboratory() as (chromium, lab, _):
        shown = Page(chromium, lab, "states", STUDIO)
        for state, code in STATES.items():
            shown.notebook.python(code)
            shown.notebook.until(BUSY, False, PATIENCE)
            for theme in themes:
                shown.page.evaluate("theme => window.jupyterapp.commands.execute('apputils:change-theme', {theme})", f"JupyterLab {theme}")
                for width in widths:
                    shown.page.set_viewport_size({"width": width + BESIDE, "height": TALL})
                    shown.notebook.drawn()
                    shown.page.mouse.move(0, 0)
                    shown.page.evaluate(browser.SETTLED)
                    picture = folder / f"{state}-{width}-{theme.lower()}.png"
                    shown.page.locator(".mechstyle-studio").screenshot(path=picture, animations="disabled")


def keep(shown: Page, name: str) -> None:
    """Save a picture of the Studio, as soon as there is a part in it, at the size of its contents."""
    shown.page.set_viewport_size({"width": WIDTH, "height": HEIGHT})
    shown.notebook.drawn()
    shown.page.mouse.move(0, 0)
    shown.page.evaluate(browser.SETTLED)
    shown.page.locator(".mechstyle-studio").screenshot(path=DOCS / f"{name}.png", animations="disabled")


if __name__ == "__main__":
    main()
