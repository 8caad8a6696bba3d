"""One cell of a study: a recipe on a model, run in one directory, told in one row file. The rows on disk are the truth.

A row file is written aside and renamed, and named by the digest of what was asked for. Whoever walks over the cells skips those with a
row, so an interrupted study goes on where it stopped, on one machine or on many that share a folder.
"""

from __future__ import annotations

import hashlib
import os
import traceback
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from time import perf_counter
from typing import Any, Literal

import msgspec

from mechstyle import __version__
from mechstyle._files import file_stem, write_whole
from mechstyle.errors import MechStyleError
from mechstyle.gallery import PREFIX, load
from mechstyle.geometry.tetrahedra import VERSION as TETRAHEDRA
from mechstyle.loop.lock import exclusive
from mechstyle.records import Judgement, Recipe
from mechstyle.runs.run import Run, started
from mechstyle.simulation.physics import PHYSICS_VERSION

Status = Literal["done", "refused", "failed"]


class Row(msgspec.Struct, frozen=True, kw_only=True):
    """One run in figures.

    Attributes:
        part: The model.
        prompt: The style.
        arm: What the cell is called beside the others of its part and style, such as "freestyle" or "stress × frozen".
        control: How stress restrains the style.
        schedule: When it is simulated.
        amplitude: Half the relief's depth over local wall thickness; None for the depth that is the default.
        loaded: Whether load cases are judged besides the drop.
        seed: Seed of the style.
        iterations: Stylization iterations.
        vertices: Vertices of the standardised surface.
        status: `done`; `refused` for a part or a setting that cannot be used; `failed` for a run that broke.
        refused: Why there is no run, "" if there is one.
        verdict: VIABLE, FAILS, UNKNOWN, or "" without a run.
        marginal: Whether a rule that counts is too close to its limit to be sure.
        as_placed: Stress as placed and under loads over its limit.
        tilted: Stress tilted a little over its limit, None if not run.
        all_orientations: Percentile over all orientations relative to the original, None if not run.
        literal: Literal maximum over the yield strength, the published rule.
        peak: Stress that decides as placed [MPa].
        limit: What it may at most be [MPa].
        safety: The least safety factor of all rules, None if that is not known.
        kept: Share of the freestyle displacement that was kept.
        style_loss: Loss of the delivered surface.
        simulations: Simulations of the styled part.
        original: The original's stress as placed over the yield strength.
        tetrahedra: Tetrahedra of the run.
        mass_gained: What strengthening added before the style [g].
        wall_seconds, cpu_seconds: Time of the process that finished the run, and what its processors worked [s].
        starts: How many times the cell was begun.
        device: Where it was simulated.
        program: Version of MechStyle.
        recipe: Digest of the recipe, before it was fitted to its part.
    """

    part: str
    prompt: str
    arm: str
    control: str = ""
    schedule: str = ""
    amplitude: float | None = None
    loaded: bool = False
    seed: int = 0
    iterations: int = 0
    vertices: int = 0
    status: Status = "done"
    refused: str = ""
    verdict: str = ""
    marginal: bool = False
    as_placed: float = 0.0
    tilted: float | None = None
    all_orientations: float | None = None
    literal: float = 0.0
    peak: float = 0.0
    limit: float = 0.0
    safety: float | None = None
    kept: float = 0.0
    style_loss: float = 0.0
    simulations: int = 0
    original: float = 0.0
    tetrahedra: int = 0
    mass_gained: float = 0.0
    wall_seconds: float = 0.0
    cpu_seconds: float = 0.0
    starts: int = 0
    device: str = ""
    program: str = ""
    recipe: str = ""

    @property
    def viable(self) -> bool:
        """Whether the part survives."""
        return self.verdict == "VIABLE"

    @property
    def a_holds(self) -> bool:
        """Whether the part holds as placed and under its loads."""
        return self.verdict not in ("UNKNOWN", "") and self.as_placed <= 1.0

    @property
    def literally_viable(self) -> bool:
        """Whether the published rule calls it viable: the literal maximum within the yield strength."""
        return self.verdict not in ("UNKNOWN", "") and self.literal <= 1.0


class Cell(msgspec.Struct, frozen=True, kw_only=True):
    """One run that a study asks for.

    Attributes:
        model: A file or `gallery:NAME`.
        arm: What it is called beside the others of its part and style.
        recipe: All it asks for, before it is fitted to the part.
        vertices: Vertices of the standardised surface.
        folder: Its run directory under the study's folder; by default one named by its factors and key.
        device: `auto`, `cpu` or `cuda`.
        name: What the part is called; by default as its model.
    """

    model: str
    arm: str
    recipe: Recipe
    vertices: int
    folder: str = ""
    device: str = "auto"
    name: str = ""

    @property
    def part(self) -> str:
        """Name of the part."""
        return self.name or Path(self.model.removeprefix(PREFIX)).stem

    @property
    def key(self) -> str:
        """Digest of what decides the result: model, recipe, vertices, and the tetrahedra and physics of this version."""
        version = f"{TETRAHEDRA}-{PHYSICS_VERSION}"
        asked = {"model": self.model, "recipe": self.recipe.digest, "vertices": self.vertices, "version": version}
        return hashlib.sha256(msgspec.json.encode(asked, order="sorted")).hexdigest()[:24]

    def run(self, out: Path) -> Run:
        """Carry it out, or on, under a study's folder.

        Raises:
            MechStyleError: If the part or a setting cannot be used, or the run fails in a way that is known.
        """
        where = out / (self.folder or f"runs/{self._slug}")
        return started(self.recipe, load(self.model), vertices=self.vertices, out=where, name=self.part, device=self.device).go()

    @property
    def _slug(self) -> str:
        words = f"{self.part}-{self.recipe.prompt}-{self.arm}"
        return f"{file_stem('-'.join(words.replace('×', ' ').split()))}-{self.key[:8]}"

    def row(self, **figures: Any) -> Row:
        """A row with its factors and these figures."""
        asked = self.recipe
        return Row(
            part=self.part, prompt=asked.prompt, arm=self.arm, control=asked.control, schedule=asked.schedule, amplitude=asked.amplitude,
            loaded=bool(asked.loads), seed=asked.seed, iterations=asked.iterations, vertices=self.vertices, program=__version__,
            recipe=asked.digest, **figures,
        )  # fmt: skip


class Rows:
    """The rows of a study's folder."""

    def __init__(self, folder: str | Path) -> None:
        """Read and write the rows of a folder, which need not exist yet."""
        self.folder = Path(folder)

    def path(self, cell: Cell) -> Path:
        """Where the row of a cell is, or will be."""
        return self.folder / "rows" / f"{cell.key}.json"

    def of(self, cell: Cell) -> Row | None:
        """The row of a cell; None if there is none, or it cannot be read and is to be made again."""
        try:
            return msgspec.json.decode(self.path(cell).read_bytes(), type=Row)
        except (OSError, msgspec.MsgspecError):
            return None

    def settled(self, cell: Cell) -> Row | None:
        """The row of a cell that is not to be run: None if it was refused, too, as the file or program that was at fault may be another."""
        row = self.of(cell)
        return None if row is None or row.status == "refused" else row

    def all(self) -> list[Row]:
        """Every row that can be read, in the order of their keys."""
        found = []
        for path in sorted((self.folder / "rows").glob("*.json")):
            try:
                found.append(msgspec.json.decode(path.read_bytes(), type=Row))
            except (OSError, msgspec.MsgspecError):
                continue
        return found

    def write(self, cell: Cell, row: Row) -> None:
        """Keep the row of a cell."""
        write_whole(self.path(cell), msgspec.json.format(msgspec.json.encode(row), indent=1))

    def begin(self, cell: Cell) -> int:
        """Note that a cell is begun; how many times it was by now."""
        path = self.folder / "starts" / cell.key
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("ab") as file:
            file.write(b"x")
        return path.stat().st_size


def carry_out(cell: Cell, folder: str | Path) -> Row:
    """Run a cell, unless its row is there and it was not refused, and keep its row, whatever becomes of the run."""
    rows = Rows(folder)
    with exclusive(rows.folder / "locks" / cell.key, f"the run of {cell.part} as {cell.recipe.prompt!r}", wait=True):
        known = rows.settled(cell)
        if known is not None:
            return known
        starts = rows.begin(cell)
        with _clocked() as spent:
            figures = _figures(cell, rows.folder)
        row = cell.row(starts=starts, **figures, **spent)
        rows.write(cell, row)
    return row


def _figures(cell: Cell, folder: Path) -> Mapping[str, Any]:
    """What became of a cell, as fields of its row."""
    try:
        return figures_of(cell.run(folder))
    except MechStyleError as error:
        return {"status": "refused", "refused": str(error)}
    except Exception as error:  # noqa: BLE001 — a study goes on; the reason is in the row, the traceback beside the runs
        write_whole(folder / "failures" / f"{cell.key}.txt", traceback.format_exc().encode())
        return {"status": "failed", "refused": f"{type(error).__name__}: {error}"}


def figures_of(run: Run) -> Mapping[str, Any]:
    """The figures of a finished run, as fields of a row."""
    verdict, summary = run.verdict, run.summary
    return {
        "verdict": verdict.outcome,
        "marginal": verdict.marginal,
        "as_placed": _use(verdict.as_placed),
        "tilted": None if verdict.tilted is None else _use(verdict.tilted),
        "all_orientations": None if verdict.all_orientations is None else verdict.all_orientations.value,
        "literal": _use(verdict.literal),
        "peak": summary.peak_stress,
        "limit": summary.allowable,
        "safety": summary.safety_factor,
        "kept": summary.kept,
        "style_loss": summary.style_loss,
        "simulations": len(summary.simulations),
        "original": summary.baseline.peak_stress / run.recipe.material.yield_strength,
        "tetrahedra": len(run.part.tets.volumes),
        "mass_gained": run.part.mass_gained,
        "device": summary.device,
    }


def _use(judgement: Judgement) -> float:
    return judgement.value / judgement.limit if judgement.limit else 0.0


@contextmanager
def _clocked() -> Iterator[dict[str, float]]:
    """Wall time and processor time of the block, meshing processes included [s]; filled in when it ends."""
    spent: dict[str, float] = {}
    wall, cpu = perf_counter(), sum(os.times()[:4])
    try:
        yield spent
    finally:
        spent.update(wall_seconds=round(perf_counter() - wall, 2), cpu_seconds=round(sum(os.times()[:4]) - cpu, 2))
