"""The four applications of the published method (Faruqi et al. 2025), and one part stylized freely and with feedback, side by side."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

from mechstyle._files import write_whole
from mechstyle.errors import unknown
from mechstyle.loop.history import Strength
from mechstyle.pictures.panels import Picture, comparison
from mechstyle.records.mesh import STANDARD_VERTICES
from mechstyle.runs.recipes import draft
from mechstyle.runs.run import Run
from mechstyle.study.cells import Cell

COLUMNS = ("", "verdict", "peak [MPa]", "allowed [MPa]", "safety", "all orientations", "simulations", "style kept")


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
        "lampshade": Application(
            "lampshade", "colorful mandala texture on mahogany wood", "A thin, wide wall hangs from a narrow collar."
        ),
    }
)


def application_named(name: str) -> Application:
    """Application by name; BadInput names the known ones, nearest first."""
    if name not in APPLICATIONS:
        raise unknown("application", name, APPLICATIONS)
    return APPLICATIONS[name]


@dataclass(frozen=True, eq=False)
class Pair:
    """One part and one prompt.

    Attributes:
        free: Finished run without feedback.
        fed: Finished run with feedback.
    """

    free: Run
    fed: Run

    def show(self) -> Picture:
        """The original and both results: look above, stress below and from underneath."""
        finals = [(label, run.checkpoint(), run.recipe) for label, run in (("Freestyle", self.free), ("MechStyle", self.fed))]
        found = (self.free.delivered(), self.fed.delivered())
        delivered = [None if one is None else one.styled for one in found]
        return comparison(self.free.part.surface, self.free.checkpoint(0), finals, delivered)

    def rows(self) -> list[tuple[str, ...]]:
        """The figures of the original part, of Freestyle and of MechStyle under `COLUMNS`."""
        rows = [("original", *_figures(self.fed.summary.baseline), "1", "–")]
        for label, run in (("Freestyle", self.free), ("MechStyle", self.fed)):
            summary = run.summary
            rows.append((label, *_figures(summary.result), str(len(summary.simulations)), f"{summary.kept:.0%}"))
        return rows

    def table(self) -> str:
        """`rows` as a Markdown table."""
        lines = [COLUMNS, tuple("---" for _ in COLUMNS), *self.rows()]
        return "".join(f"| {' | '.join(line)} |\n" for line in lines)

    def save(self, folder: Path) -> dict[str, str]:
        """Write `comparison.png` and `comparison.md`; what each file is, and its path."""
        prompt, words = self.fed.recipe.prompt, [run.summary.words for run in (self.free, self.fed)]
        page = f"# {self.fed.record.name}: “{prompt}”\n\n{self.table()}\nFreestyle: {words[0]}\n\nMechStyle: {words[1]}\n"
        write_whole(folder / "comparison.md", page.encode())
        return {"comparison": str(self.show().save(folder / "comparison.png")), "table": str(folder / "comparison.md")}


def _figures(strength: Strength) -> tuple[str, ...]:
    """Verdict, peak, limit, safety factor and p99 over all orientations relative to the original part."""
    safety = "–" if strength.safety_factor is None else f"{strength.safety_factor:.2f}"
    turns = "–" if strength.all_orientations is None else f"{strength.all_orientations:.2f} x"
    outcome = f"{strength.verdict}, MARGINAL" if strength.marginal else strength.verdict
    return outcome, f"{strength.peak_stress:.1f}", f"{strength.allowable:.1f}", safety, turns


def apply(name: str, out: str | Path, *, vertices: int = STANDARD_VERTICES, device: str = "auto", **settings: Any) -> Pair:
    """Carry out an application, freely and with feedback, on the gallery's model of it.

    Args:
        name: One of `APPLICATIONS`.
        out: Folder for the two run directories; what was begun there goes on.
        vertices: Vertices of the standardised surface.
        device: `auto`, `cpu` or `cuda`.
        settings: Fields of `Recipe` for both runs, such as iterations; `protect` in place of the application's own regions.

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
