"""The four applications of the published method (Faruqi et al. 2025), and one part stylized freely and with feedback, side by side."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

from mechstyle._files import write_whole
from mechstyle.errors import unknown
from mechstyle.pictures.panels import Picture, comparison
from mechstyle.records import sentences
from mechstyle.records.mesh import STANDARD_VERTICES
from mechstyle.runs.recipes import draft
from mechstyle.runs.run import Run
from mechstyle.study.ablation import markdown
from mechstyle.study.cells import Cell

COLUMNS = ("test", "plain", "Freestyle", "MechStyle", "asked")
"""Headings of the table of falls."""


@dataclass(frozen=True)
class Application:
    """A thing one would print, and a style for it.

    Attributes:
        model: A gallery model.
        prompt: The style, in words.
        about: What the strength is needed for, in one sentence.
        protect: Regions protected from the style, as they are written after `--protect`.
    """

    model: str
    prompt: str
    about: str
    protect: tuple[str, ...] = ()


APPLICATIONS: Mapping[str, Application] = MappingProxyType(
    {
        "eyeglasses": Application("spectacle_frame", "fish scales", "The thin nose bridge carries the frame and must not be weakened."),
        "pill_box": Application(
            "pill_box", "floral patterns", "Only the outside is stylized: pills slide out of smooth, plain cells.", ("inside colour",)
        ),
        "utensil_grip": Application("utensil_grip", "Damascus steel", "A grip falls often, and onto its ends."),
        "lampshade": Application("lampshade", "colorful mandala texture on mahogany wood", "A thin, wide wall hangs from a narrow collar."),
    }
)


def application_named(name: str) -> Application:
    """Application by name; BadInput names the known ones, nearest first."""
    if name not in APPLICATIONS:
        raise unknown("application", name, APPLICATIONS)
    return APPLICATIONS[name]


@dataclass(frozen=True, eq=False)
class Pair:
    """One part and one prompt, as finished runs without feedback and with it."""

    free: Run
    fed: Run

    def show(self) -> Picture:
        """Plain part and both results: look above, stress below and from underneath, each with the landing it is of."""
        finals = [(label, run.checkpoint(), run.recipe) for label, run in (("Freestyle", self.free), ("MechStyle", self.fed))]
        return comparison(self.free.part.surface, self.free.checkpoint(0), finals)

    def table(self) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
        """The fall or load that each part survives, test by test, as text: headings and rows, the style kept last."""
        rows = sentences.paired([self.free.verdict, self.fed.verdict])
        return COLUMNS, [*rows, ("style kept", "–", f"{self.free.summary.kept:.0%}", f"{self.fed.summary.kept:.0%}", "–")]

    def save(self, folder: Path) -> dict[str, str]:
        """Write `comparison.png` and `comparison.md` with the table and both verdicts; what each file is, and its path."""
        columns, rows = self.table()
        words = [f"{label}: {run.verdict.words}" for label, run in (("Freestyle", self.free), ("MechStyle", self.fed))]
        page = f"# {self.fed.record.name}: “{self.fed.recipe.style.prompt}”\n\n{markdown([columns, *rows])}\n{words[0]}\n\n{words[1]}\n"
        write_whole(folder / "comparison.md", page.encode())
        return {"comparison": str(self.show().save(folder / "comparison.png")), "table": str(folder / "comparison.md")}


def apply(name: str, out: str | Path, *, vertices: int = STANDARD_VERTICES, device: str = "auto", **settings: Any) -> Pair:
    """Carry out an application, freely and with feedback, on the gallery's model of it; what was begun in the folder goes on.

    `protect` among the settings takes the place of the application's own regions.

    Raises:
        BadInput: If there is no such application or setting.
    """
    chosen = application_named(name)
    shared = {"protect": chosen.protect, **settings}
    free, fed = (
        Cell(
            model=f"gallery:{chosen.model}", name=name, arm=label, recipe=draft(chosen.prompt, freestyle=freestyle, **shared),
            vertices=vertices, folder=label, device=device,
        ).run(Path(out))
        for label, freestyle in (("freestyle", True), ("mechstyle", False))
    )  # fmt: skip
    return Pair(free, fed)
