"""Makes the pictures and the film of README and pages again from runs with stored recipes, and notes of which physics they are.

    python benchmarks/pictures.py                 # all that show figures of a simulation, then the list in docs/pictures.json
    python benchmarks/pictures.py film tutorial   # some of them
    python benchmarks/pictures.py --note          # the list alone, for a picture of drawn styles that was made by hand

Runs go to build/pictures, each in a folder of its physics: what is there goes on or is only drawn again. The test beside this list finds a
picture that was changed by hand, that no page shows, or that is older than the physics it shows.
"""

from __future__ import annotations

import argparse
import hashlib
import io
import os
import re
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import msgspec
from PIL import Image
from sheets import model_sheet

import mechstyle as ms
from mechstyle._files import write_whole
from mechstyle.pictures.figure import Panel, figure_png
from mechstyle.pictures.panels import Picture
from mechstyle.records import Verdict, sentences
from mechstyle.runs.film import film
from mechstyle.runs.run import Run
from mechstyle.simulation.physics import PHYSICS_VERSION

ROOT = Path(__file__).parent.parent
DOCS, LIST = ROOT / "docs", ROOT / "docs" / "pictures.json"
WORK = ROOT / "build" / "pictures" / f"physics-{PHYSICS_VERSION}"
COLOURS, SIDE = 256, 240
"""Colours of a picture, and the side of one in a row [pixels], small enough that its words are read at the width of a page."""


class Made(msgspec.Struct, frozen=True):
    """A picture as it is in the repository.

    Attributes:
        digest: SHA-256 of the file.
        size: Width and height [pixels].
        physics: Version of the physics that it shows; None for one that shows no simulation.
        recipes: Digests of the recipes of its runs.
        by: What makes it, after `python benchmarks/`; "" for one made by hand.
    """

    digest: str
    size: tuple[int, int]
    physics: int | None
    recipes: tuple[str, ...]
    by: str


def demo() -> list[Run]:
    """The part of the demo: freely, with feedback."""
    folder = WORK / "demo"
    subprocess.run([sys.executable, "-m", "mechstyle", "demo", "--out", str(folder)], check=True)
    return [Run.open(folder / name, "cpu") for name in ("freestyle", "mechstyle")]


def row() -> list[Run]:
    """A pen holder plain and in three styles at the size of print, with what a fall leaves of each in three words below."""
    part, styles = ms.load("gallery:pen_holder"), ("brick", "dragon scales", "knit")
    runs = [ms.stylize(part, style, out=WORK / f"row-{style.split()[0]}", name="pen holder", device="cpu") for style in styles]
    keep("row", side_by_side(runs))
    return runs


def side_by_side(runs: Sequence[Run]) -> Picture:
    """The plain part and runs of it in one row, each above its outcome and what stays bent."""
    plain = Panel(runs[0].part.surface, "plain", note=in_three_words(runs[0].summary.plain))
    panels = [plain, *(Panel(run.surface(), run.recipe.style.prompt, note=in_three_words(run.verdict)) for run in runs)]
    return Picture(figure_png(panels, columns=len(panels), panel_size=(SIDE, SIDE)))


def in_three_words(verdict: Verdict) -> str:
    """The outcome, whether it is not sure, and what stays bent in the worst test."""
    found = sentences.found(verdict.deciding) if verdict.deciding else ""
    return ", ".join(filter(None, (verdict.outcome.lower(), "" if verdict.sure else "not sure", found)))


def fall() -> list[Run]:
    """The fall of the demo's part as a GIF: plain, freely and with feedback in one landing, then what stays bent of each."""
    runs = demo()
    film(runs, DOCS / "film.gif", frames=30, size=300)
    return runs


def tutorial() -> list[Run]:
    """The run of the tutorial: style, stress, mask."""
    knob, settings = ms.load("gallery:drawer_knob"), {"vertices": 2000, "iterations": 60, "schedule": "stress"}
    run = ms.stylize(knob, "brick", **settings, out=WORK / "tutorial", name="drawer knob", device="cpu")
    keep("tutorial", run.show())
    return [run]


def studio() -> list[Run]:
    """The Studio before and after a run, beside a branch and painted, and a report."""
    subprocess.run([sys.executable, str(ROOT / "benchmarks" / "screenshots.py")], check=True)
    return []


def models() -> list[Run]:
    """The models of the gallery."""
    model_sheet().save(DOCS / "gallery.png")
    return []


GROUPS: dict[str, tuple[Callable[[], list[Run]], tuple[str, ...], bool]] = {
    "row": (row, ("row",), True),
    "film": (fall, ("film",), True),
    "tutorial": (tutorial, ("tutorial",), True),
    "studio": (studio, ("studio-1", "studio-2", "studio-3", "studio-paint", "report"), True),
    "gallery": (models, ("gallery",), False),
}
"""What makes pictures, by its name: the function, the pictures in docs/, and whether they show a simulation."""


def keep(name: str, shown: Picture | Image.Image) -> None:
    """Save a picture in docs/ in few colours."""
    whole = Image.open(io.BytesIO(shown.png)).convert("RGB") if isinstance(shown, Picture) else shown
    small, written = whole.quantize(COLOURS, Image.Quantize.MAXCOVERAGE, kmeans=1, dither=Image.Dither.NONE), io.BytesIO()
    small.save(written, "PNG", optimize=True)
    write_whole(DOCS / f"{name}.png", written.getvalue())


def shown_in_pages() -> set[str]:
    """Pictures of docs/ that README, a page or what makes pages shows."""
    pages = [ROOT / "README.md", *DOCS.glob("*.md"), *DOCS.glob("site/*.py")]
    shown = re.compile(r"!\[[^\]]*\]\((?:docs/)?([\w-]+)\.(?:png|gif)\)")
    found = {name for page in pages for name in shown.findall(page.read_text(encoding="utf-8"))}
    return {name for name in found if file_of(name).is_file()}


def file_of(name: str) -> Path:
    """The file of a picture or a film."""
    return moving if (moving := DOCS / f"{name}.gif").is_file() else DOCS / f"{name}.png"


def note(made: dict[str, tuple[str, list[Run]]]) -> None:
    """Write the list: pictures that were made now with today's physics, others as they were noted."""
    known = msgspec.json.decode(LIST.read_bytes(), type=dict[str, Made]) if LIST.is_file() else {}
    listed: dict[str, Made] = {}
    for name in sorted(shown_in_pages()):
        data = file_of(name).read_bytes()
        group = next((group for group, (_, names, _) in GROUPS.items() if name in names), "")
        before = known.get(name)
        physics, recipes = (None, ()) if before is None else (before.physics, before.recipes)
        if name in made:
            physics = PHYSICS_VERSION if GROUPS[group][2] else None
            recipes = tuple(run.recipe.digest for run in made[name][1])
        size = Image.open(io.BytesIO(data)).size
        listed[name] = Made(hashlib.sha256(data).hexdigest(), size, physics, recipes, f"pictures.py {group}" if group else "")
    write_whole(LIST, msgspec.json.format(msgspec.json.encode(listed), indent=1) + b"\n")


def main() -> None:
    """Make pictures, and note them."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("groups", nargs="*", choices=[*GROUPS, []], metavar="GROUP", help=f"of {', '.join(GROUPS)}; all by default")
    parser.add_argument("--note", action="store_true", help="write the list alone")
    given = parser.parse_args()
    made: dict[str, tuple[str, list[Any]]] = {}
    for group in [] if given.note else given.groups or [name for name, (_, _, simulated) in GROUPS.items() if simulated]:
        draw, names, _ = GROUPS[group]
        print(f"{group}: {', '.join(names)}", flush=True)
        runs = draw()
        made |= dict.fromkeys(names, (group, runs))
        note(made)
    note(made)


if __name__ == "__main__":
    os.chdir(ROOT)
    main()
