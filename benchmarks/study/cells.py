"""One cell of a study: a recipe on a model, run in one directory, with one row file. The rows on disk are the truth.

A row file is written aside and renamed, and named by the digest of what was asked for. Whoever walks over the cells skips those with a
row, so an interrupted study goes on where it stopped, on one machine or on many that share a folder. Loads are scaled to a share of what
the plain part carries, so that parts as different as a hook and a box are loaded as hard.
"""

from __future__ import annotations

import hashlib
import math
import os
import traceback
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from time import perf_counter
from typing import Any, Literal
from unittest.mock import patch

import msgspec

from mechstyle import __version__
from mechstyle._files import exclusive, file_stem, write_whole
from mechstyle.errors import BadInput, MechStyleError
from mechstyle.fea.statics import StaticTest
from mechstyle.gallery import PREFIX, addressed, load
from mechstyle.geometry.remeshing import filling
from mechstyle.geometry.remeshing.filling import VERSION as TETRAHEDRA
from mechstyle.loop.correction import NEAREST
from mechstyle.records import Recipe, Verdict, sentences
from mechstyle.records.load_cases import Load, LoadCase
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.runs.run import Draft, Run
from mechstyle.simulation import part
from mechstyle.simulation.part import prepare
from mechstyle.simulation.physics import PHYSICS_VERSION

Status = Literal["done", "refused", "failed"]


class Row(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One run in figures.

    Attributes:
        part: The model.
        prompt: The style.
        arm: Name of the cell beside the others of its part and style, such as "freestyle" or "stress × frozen".
        condition: Name of what is asked of the part, one of `grids.CONDITIONS`.
        control: How stress restrains the style.
        schedule: When it is simulated.
        amplitude: Half the relief's depth over local wall thickness; None for the depth that is the default.
        load: Name and size of its load cases, "" without any.
        fall: Height of the fall that is asked for [mm].
        tolerance: The most that may stay bent [mm].
        seed: Seed of the style.
        iterations: Stylization iterations.
        vertices: Vertices of the standardised surface.
        status: `done`; `refused` for a part or a setting that cannot be used; `failed` for a run that broke.
        refused: Why there is no run, "" if there is one.
        outcome: HOLDS, NO WORSE, FAILS, UNKNOWN, or "" without a run.
        sure: Whether no doubt is left.
        doubt: Why the outcome is not sure, "" if it is.
        decides: Name of the worst test, "" if nothing could be tested.
        place: Where it stays bent most in that test, in words.
        permanent_set: What stays bent in it [mm].
        plain_permanent_set: The same of the plain part.
        allowed: What may stay bent in it [mm].
        stress, plain_stress: By the published rule: the largest stress of an element, styled and plain [MPa].
        strength: Yield strength [MPa].
        contact_stiffness: Stiffness of its floor at each node [N/mm], 0 for a rigid one.
        floors: The finished part and the plain one dropped again on other floors: stiffness, stress, plain stress of each.
        plastic_strain: The most plastic strain in tension of all tests.
        carries: Times its loads that the part carries within the tolerance, of the load it carries least of; None without loads.
        kept: Share of the style's relief that is left, by what can be seen of it.
        style_loss: Loss of the delivered surface.
        simulations: Simulations of the styled part.
        tetrahedra: Tetrahedra of the run.
        mass_gained: Mass that strengthening added before the style [g].
        seconds, cpu_seconds: Wall time of the process that finished the run, and processor time of its processes [s].
        starts: How many times the cell was begun.
        device: Where it was simulated.
        program: Version of MechStyle.
        recipe: Digest of the recipe, before it was fitted to its part.
    """

    part: str
    prompt: str
    arm: str
    condition: str = "drop"
    control: str = ""
    schedule: str = ""
    amplitude: float | None = None
    load: str = ""
    fall: float = 0.0
    tolerance: float = 0.0
    seed: int = 0
    iterations: int = 0
    vertices: int = 0
    status: Status = "done"
    refused: str = ""
    outcome: str = ""
    sure: bool = False
    doubt: str = ""
    decides: str = ""
    place: str = ""
    permanent_set: float | None = None
    plain_permanent_set: float | None = None
    allowed: float | None = None
    stress: float | None = None
    plain_stress: float | None = None
    strength: float = 0.0
    contact_stiffness: float = 0.0
    floors: tuple[tuple[float, float, float], ...] = ()
    plastic_strain: float | None = None
    carries: float | None = None
    kept: float = 0.0
    style_loss: float = 0.0
    simulations: int = 0
    tetrahedra: int = 0
    mass_gained: float = 0.0
    seconds: float = 0.0
    cpu_seconds: float = 0.0
    starts: int = 0
    device: str = ""
    program: str = ""
    recipe: str = ""

    @property
    def passes(self) -> bool:
        """Whether the outcome is HOLDS or NO WORSE."""
        return self.outcome in ("HOLDS", "NO WORSE")


class Cell(msgspec.Struct, frozen=True, kw_only=True):
    """One run that a study asks for.

    Attributes:
        model: A file or `gallery:NAME`.
        arm: Its name beside the others of its part and style.
        recipe: All it asks for, before it is fitted to the part.
        vertices: Vertices of the standardised surface.
        condition: Name of what is asked of the part, one of `grids.CONDITIONS`.
        one_factor: Whether the whole relief is then lowered by the largest factor that passes.
        tetrahedra: About how many its meshes have, of the surface's triangles as many as belong to that; 0 for the usual number.
        floors: By the published rule: stiffnesses of floors on which the finished part is dropped again.
        load_share: Share of what the plain part carries that the loads of the recipe are scaled to; 0 leaves them as they are.
        folder: Its run directory under the study's folder; by default one named by its factors and key.
        device: `auto`, `cpu` or `cuda`.
        name: Name of the part; by default that of its model.
    """

    model: str
    arm: str
    recipe: Recipe
    vertices: int
    condition: str = "drop"
    one_factor: bool = False
    tetrahedra: int = 0
    floors: tuple[float, ...] = ()
    load_share: float = 0.0
    folder: str = ""
    device: str = "auto"
    name: str = ""

    @property
    def part(self) -> str:
        """Name of the part."""
        path, said = addressed(self.model)
        return self.name or "-".join([Path(path.removeprefix(PREFIX)).stem, *([said["body"]] if "body" in said else [])])

    @property
    def key(self) -> str:
        """Digest of what decides the result: all that is asked for, and this version's tetrahedra and physics."""
        version = f"{TETRAHEDRA}-{PHYSICS_VERSION}"
        asked = {
            "model": self.model, "recipe": self.recipe.digest, "vertices": self.vertices, "load_share": self.load_share, "version": version,
            "one_factor": self.one_factor, "floors": self.floors,
            "tetrahedra": self.tetrahedra,
        }  # fmt: skip
        return hashlib.sha256(msgspec.json.encode(asked, order="sorted")).hexdigest()[:24]

    def run(self, out: Path) -> Run:
        """Carry it out, or on, under a study's folder.

        Raises:
            MechStyleError: If the part or a setting cannot be used, or the run fails in a way that is known.
        """
        words = f"{self.part}-{self.recipe.style.prompt}-{self.condition}-{self.arm}".replace("×", " ").split()
        where = out / (self.folder or f"runs/{file_stem('-'.join(words))}-{self.key[:8]}")
        model, recipe = load(self.model), self.recipe
        if self.load_share:
            recipe = with_loads(recipe, model, self.vertices, share=self.load_share, folder=out / "loads")
        return Draft(recipe, model, self.vertices, self.part, where, self.device).begin().go()

    def row(self, **figures: Any) -> Row:
        """A row with its factors and these figures."""
        asked = self.recipe
        return Row(
            part=self.part, prompt=asked.style.prompt, arm=self.arm, condition=self.condition, control=asked.restraint.control,
            schedule=asked.schedule.when, amplitude=asked.style.amplitude, fall=asked.test.height,
            tolerance=asked.test.tolerance, seed=asked.style.seed, iterations=asked.schedule.iterations, vertices=self.vertices,
            program=__version__, recipe=asked.digest, **figures,
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
        return next(iter(_decoded(self.path(cell))), None)

    def settled(self, cell: Cell) -> Row | None:
        """The row of a cell that is not to be run: None if it was refused, too, as the file or program that was at fault may be another."""
        row = self.of(cell)
        return None if row is None or row.status == "refused" else row

    def all(self) -> list[Row]:
        """Every row that can be read, in the order of their keys."""
        return [row for path in sorted((self.folder / "rows").glob("*.json")) for row in _decoded(path)]

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


def _decoded(path: Path) -> list[Row]:
    """The row of a file, nothing if it cannot be read."""
    with suppress(OSError, msgspec.MsgspecError):
        return [msgspec.json.decode(path.read_bytes(), type=Row)]
    return []


def carry_out(cell: Cell, folder: str | Path) -> Row:
    """Run a cell, unless its row is there and it was not refused, and keep its row, whatever becomes of the run."""
    rows = Rows(folder)
    with exclusive(rows.folder / "locks" / cell.key, f"the run of {cell.part} as {cell.recipe.style.prompt!r}", wait=True):
        known = rows.settled(cell)
        if known is not None:
            return known
        starts = rows.begin(cell)
        wall, cpu = perf_counter(), sum(os.times()[:4])  # meshing processes included
        figures = _figures(cell, rows.folder)
        spent = {"seconds": round(perf_counter() - wall, 2), "cpu_seconds": round(sum(os.times()[:4]) - cpu, 2)}
        row = cell.row(starts=starts, **figures, **spent)
        rows.write(cell, row)
    return row


@contextmanager
def meshed(tetrahedra: int) -> Iterator[None]:
    """In the block parts are filled with about so many tetrahedra, which no recipe says: their number is no setting of the product."""
    if not tetrahedra:
        yield
        return
    kept = tuple(count for count in filling.KEPT if count >= 0.75 * tetrahedra) or filling.KEPT[:1]
    with patch.object(part, "TETS", tetrahedra), patch.object(filling, "KEPT", kept):
        yield


def _figures(cell: Cell, folder: Path) -> Mapping[str, Any]:
    with meshed(cell.tetrahedra):
        return _figures_of_cell(cell, folder)


def _figures_of_cell(cell: Cell, folder: Path) -> Mapping[str, Any]:
    try:
        run = cell.run(folder)
        return {**figures_of(run), **(one_factor(run) if cell.one_factor else {}), **on_floors(run, cell.floors)}
    except MechStyleError as error:
        return {"status": "refused", "refused": str(error)}
    except Exception as error:  # noqa: BLE001 — a study goes on; the reason is in the row, the traceback beside the runs
        write_whole(folder / "failures" / f"{cell.key}.txt", traceback.format_exc().encode())
        return {"status": "failed", "refused": f"{type(error).__name__}: {error}"}


def figures_of(run: Run) -> Mapping[str, Any]:
    """The figures of a finished run, as fields of a row."""
    summary = run.summary
    return {
        "load": "; ".join(map(words_of, run.recipe.test.loads)),
        **_judged(run.verdict),
        "kept": summary.kept,
        "style_loss": summary.style_loss,
        "simulations": len(summary.simulations),
        "tetrahedra": len(run.part.tets.volumes),
        "strength": run.verdict.strength,
        "contact_stiffness": run.recipe.test.floor,
        "mass_gained": run.part.mass_gained,
        "device": summary.device,
    }


def _judged(verdict: Verdict) -> Mapping[str, Any]:
    """A verdict, as fields of a row."""
    worst = verdict.deciding
    bent = {} if worst is None else {name: getattr(worst, name) for name in ("place", "permanent_set", "plain_permanent_set", "allowed")}
    return {
        "outcome": verdict.outcome,
        "sure": verdict.sure,
        "doubt": verdict.doubt,
        "decides": "" if worst is None else sentences.label(worst),
        "stress": None if worst is None else worst.stress,
        "plastic_strain": max((row.plastic_strain for row in verdict.rows), default=None),
        "carries": min((row.carries for row in verdict.rows if row.carries is not None), default=None),
        **bent,
    }


def one_factor(run: Run) -> Mapping[str, Any]:
    """What changes in a row where the whole relief is lowered by the largest factor that passes, found by halving to 1/16."""
    simulator, relief, verdict = run.simulator(run.recipe), run.checkpoint().displacement, run.verdict
    low, high, tests = (1.0 if verdict.passes else 0.0), 1.0, 0
    if not verdict.passes:
        verdict = simulator.judge(simulator.baseline)
    while high - low > NEAREST:
        factor = 0.5 * (low + high)
        found = simulator.judge(simulator.simulate((relief * factor + 0.0).astype(relief.dtype), thorough=True))
        low, high, verdict = (factor, high, found) if found.passes else (low, factor, verdict)
        tests += 1
    return {**_judged(verdict), "kept": low * run.summary.kept, "simulations": len(run.summary.simulations) + tests}


def on_floors(run: Run, floors: Sequence[float]) -> Mapping[str, Any]:
    """What a row says besides of a run by the published rule: the plain part, and both parts on other floors."""
    if run.recipe.test.criterion != "paper":
        return {}
    relief, found = run.checkpoint().displacement, list[tuple[float, float, float]]()
    for stiffness in floors:
        simulator = run.simulator(run.recipe.with_settings(contact_stiffness=stiffness))
        styled, plain = simulator.simulate(relief, thorough=True), simulator.baseline
        found.append((stiffness, *(math.inf if one.failure else one.maximum for one in (styled, plain))))
    return {"plain_stress": run.simulator(run.recipe).baseline.maximum, "floors": tuple(found)}


def with_loads(recipe: Recipe, model: SurfaceMesh, vertices: int, *, share: float, folder: Path) -> Recipe:
    """A recipe whose load cases are each a share of what the plain part carries within the tolerance.

    What it carries is kept in a folder, so that all runs of a study ask for the same load.

    Raises:
        BadInput: If the part or a case cannot be used.
        SimulationFailed: If the part cannot be meshed or the equations cannot be solved.
    """
    test = recipe.test
    asked = (model.digest, vertices, test.loads, test.material, test.element, test.across_layers, test.tolerance, PHYSICS_VERSION)
    name = hashlib.sha256(msgspec.json.encode(asked)).hexdigest()[:24]
    path = folder / f"{name}.json"
    with exclusive(folder / "locks" / name, f"the load of {test.loads[0].name!r}", wait=True):
        try:
            factors = msgspec.json.decode(path.read_bytes(), type=dict[str, float])
        except (OSError, msgspec.MsgspecError):
            factors = load_factors(recipe, model, vertices)
            write_whole(path, msgspec.json.format(msgspec.json.encode(factors), indent=1))
    return recipe.with_settings(loads=tuple(scaled(case, share * factors[case.name]) for case in test.loads))


MOST_TIMES = 8
"""How often a load is raised to what a part is known to carry, to see whether it carries more."""


def load_factors(recipe: Recipe, model: SurfaceMesh, vertices: int) -> dict[str, float]:
    """Times each load case of a recipe that a plain part carries, by its name; arguments and errors as for `with_loads`."""
    plain, test, found = prepare(model, vertices=vertices), recipe.test, dict[str, float]()
    for case in test.loads:
        factor = 1.0
        for _ in range(MOST_TIMES):
            loaded = StaticTest(plain.tets, (scaled(case, factor),), test.element).loaded(
                plain.tets, test.material, across=test.across_layers, tolerance=test.tolerance
            )[case.name]
            factor *= loaded.result.factor
            if loaded.result.reached:
                break
        found[case.name] = factor
    return found


def scaled(case: LoadCase, factor: float) -> LoadCase:
    """A load case with all its loads multiplied."""
    loads = []
    for one in case.loads:
        if one.force is not None:
            x, y, z = one.force
            loads.append(msgspec.structs.replace(one, force=(factor * x, factor * y, factor * z)))
        elif one.pressure is not None:
            loads.append(msgspec.structs.replace(one, pressure=factor * one.pressure))
        else:
            assert one.gravity is not None, "a load is a force, a pressure or gravity"
            loads.append(msgspec.structs.replace(one, gravity=factor * one.gravity))
    return msgspec.structs.replace(case, loads=tuple(loads))


def words_of(case: LoadCase) -> str:
    """Name and size of a load case, such as "heavy coat, 703 N"."""
    return ", ".join((case.name, *map(_size, case.loads)))


def _size(load: Load) -> str:
    if load.force is not None:
        size = math.hypot(*load.force)
        return f"{size:.0f} N" if size >= 100.0 else f"{size:.3g} N"
    return f"{load.gravity:.3g} × its weight" if load.gravity is not None else f"{load.pressure:.3g} MPa"


def write_table(rows: Sequence[Row], path: Path) -> Path:
    """Write rows to `path` with the suffix .json, a line each, and return it; it appears whole or not at all."""
    target = path.with_suffix(".json")
    write_whole(target, b"[\n" + b",\n".join(map(msgspec.json.encode, rows)) + b"\n]\n")
    return target


def read_table(source: str | Path) -> list[Row]:
    """The rows of a study's folder, or of a table made of one.

    Raises:
        BadInput: If there are none, or the table is another's or of another measure.
    """
    path = Path(source)
    if not path.exists():
        raise BadInput(f"{path} does not exist: name the folder of a study, or its table")
    try:
        rows = Rows(path).all() if path.is_dir() else msgspec.json.decode(path.read_bytes(), type=list[Row])
    except (msgspec.MsgspecError, OSError) as error:
        raise BadInput(f"{path} is no table of a study, or of an older measure ({error}): run the study again") from error
    if not rows:
        raise BadInput(f"{path} holds no rows of a study in mm: name the folder that was its --out, or its table, or run it again")
    return rows
