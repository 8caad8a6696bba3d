"""One cell of a study: a recipe on a model, run in one directory, with one row file. The rows on disk are the truth.

A row file is written aside and renamed, and named by the digest of what was asked for. Whoever walks over the cells skips those with a
row, so an interrupted study goes on where it stopped, on one machine or on many that share a folder. Loads are scaled to a share of what
the plain part carries, so that parts as different as a hook and a box are loaded as hard. All rows are one table: Parquet where pyarrow is
installed, JSON where it is not.
"""

from __future__ import annotations

import hashlib
import math
import os
import traceback
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from time import perf_counter
from typing import Any, Literal

import msgspec

from mechstyle import __version__
from mechstyle._files import exclusive, file_stem, write_whole
from mechstyle.errors import BadInput, MechStyleError
from mechstyle.fea.statics import StaticTest
from mechstyle.fea.stressed_volume import LOADED, Walls, at_nodes, exceeded
from mechstyle.gallery import PREFIX, addressed, load
from mechstyle.geometry.remeshing.filling import VERSION as TETRAHEDRA
from mechstyle.records import Recipe
from mechstyle.records.load_cases import Load, LoadCase
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.runs.run import Run, started
from mechstyle.simulation.part import prepare
from mechstyle.simulation.physics import PHYSICS_VERSION

Status = Literal["done", "refused", "failed"]


class Row(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One run in figures.

    Heights are critical drop heights: how far the part may fall before a piece as large as a cube of 4 mm begins to yield.

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
        seed: Seed of the style.
        iterations: Stylization iterations.
        vertices: Vertices of the standardised surface.
        status: `done`; `refused` for a part or a setting that cannot be used; `failed` for a run that broke.
        refused: Why there is no run, "" if there is one.
        outcome: HOLDS, NO WORSE, FAILS, UNKNOWN, or "" without a run.
        sure: Whether no doubt is left.
        doubt: Why the outcome is not sure, "" if it is.
        decides: Test with the least reserve, "" if nothing could be tested.
        reserve: What is survived in that test over what is needed; below 1 it fails.
        flat_stress, nearly_stress: σ_V of the flat landing and of the worst nearly flat one, at the fall asked for [MPa].
        flat_height, nearly_height: Critical drop height of the styled part in each [mm].
        plain_flat_height, plain_nearly_height: Critical drop height of the plain part in each [mm].
        load_factor, plain_load_factor: The least load factor, and the plain part's under the same load; None without loads.
        published_factor: Yield strength over the largest stress at a point; the published rule asks for 1.
        safety_factor: Least yield strength over σ_V of the tests that decide, None if that is not known.
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
    seed: int = 0
    iterations: int = 0
    vertices: int = 0
    status: Status = "done"
    refused: str = ""
    outcome: str = ""
    sure: bool = False
    doubt: str = ""
    decides: str = ""
    reserve: float | None = None
    flat_stress: float | None = None
    nearly_stress: float | None = None
    flat_height: float | None = None
    nearly_height: float | None = None
    plain_flat_height: float | None = None
    plain_nearly_height: float | None = None
    load_factor: float | None = None
    plain_load_factor: float | None = None
    published_factor: float | None = None
    safety_factor: float | None = None
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

    @property
    def holds_flat(self) -> bool:
        """Whether the part survives the fall that is asked for where it lands flat."""
        return self.flat_height is not None and self.flat_height >= self.fall

    @property
    def passes_published(self) -> bool:
        """Whether it passes the published rule: the largest stress at a point within the yield strength."""
        return self.published_factor is not None and self.published_factor >= 1.0


class Cell(msgspec.Struct, frozen=True, kw_only=True):
    """One run that a study asks for.

    Attributes:
        model: A file or `gallery:NAME`.
        arm: Its name beside the others of its part and style.
        recipe: All it asks for, before it is fitted to the part.
        vertices: Vertices of the standardised surface.
        condition: Name of what is asked of the part, one of `grids.CONDITIONS`.
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
        """Digest of what decides the result: model, recipe, vertices, scale of loads, and this version's tetrahedra and physics."""
        version = f"{TETRAHEDRA}-{PHYSICS_VERSION}"
        asked = {
            "model": self.model, "recipe": self.recipe.digest, "vertices": self.vertices, "load_share": self.load_share, "version": version,
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
        return started(recipe, model, vertices=self.vertices, out=where, name=self.part, device=self.device).go()

    def row(self, **figures: Any) -> Row:
        """A row with its factors and these figures."""
        asked = self.recipe
        return Row(
            part=self.part, prompt=asked.style.prompt, arm=self.arm, condition=self.condition, control=asked.restraint.control,
            schedule=asked.schedule.when, amplitude=asked.style.amplitude, fall=asked.test.height, seed=asked.style.seed,
            iterations=asked.schedule.iterations, vertices=self.vertices, program=__version__, recipe=asked.digest, **figures,
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


def _figures(cell: Cell, folder: Path) -> Mapping[str, Any]:
    try:
        return figures_of(cell.run(folder))
    except MechStyleError as error:
        return {"status": "refused", "refused": str(error)}
    except Exception as error:  # noqa: BLE001 — a study goes on; the reason is in the row, the traceback beside the runs
        write_whole(folder / "failures" / f"{cell.key}.txt", traceback.format_exc().encode())
        return {"status": "failed", "refused": f"{type(error).__name__}: {error}"}


def figures_of(run: Run) -> Mapping[str, Any]:
    """The figures of a finished run, as fields of a row."""
    verdict, summary, decides = run.verdict, run.summary, run.verdict.deciding
    hardest = min((row for row in verdict.rows if row.test == "load"), key=lambda row: row.survived, default=None)
    flat, nearly, published = verdict.row("flat"), verdict.row("nearly flat"), verdict.published
    return {
        "load": "; ".join(map(words_of, run.recipe.test.loads)),
        "outcome": verdict.outcome,
        "sure": verdict.sure,
        "doubt": verdict.doubt,
        "decides": "" if decides is None else decides.test,
        "reserve": None if decides is None else decides.reserve,
        "flat_stress": None if flat is None else flat.stress,
        "nearly_stress": None if nearly is None else nearly.stress,
        "flat_height": None if flat is None else flat.height,
        "nearly_height": None if nearly is None else nearly.height,
        "plain_flat_height": None if flat is None else flat.original,
        "plain_nearly_height": None if nearly is None else nearly.original,
        "load_factor": None if hardest is None else hardest.factor,
        "plain_load_factor": None if hardest is None else hardest.original,
        "published_factor": None if published is None else published.factor,
        "safety_factor": verdict.safety_factor,
        "kept": summary.kept,
        "style_loss": summary.style_loss,
        "simulations": len(summary.simulations),
        "tetrahedra": len(run.part.tets.volumes),
        "mass_gained": run.part.mass_gained,
        "device": summary.device,
    }


class LoadFactor(msgspec.Struct, frozen=True, kw_only=True):
    """What a plain part carries of one load case: σ_V under it [MPa], and how many times the case before σ_V is the yield strength."""

    case: str
    stress: float
    factor: float


def with_loads(recipe: Recipe, model: SurfaceMesh, vertices: int, *, share: float, folder: Path) -> Recipe:
    """A recipe whose load cases are each a share of the load at which σ_V of the plain part is the yield strength.

    The load factors of the plain part are kept in a folder, so that all runs of a study ask for the same load.

    Raises:
        BadInput: If the part or a case cannot be used.
        SimulationFailed: If the part cannot be meshed or the equations cannot be solved.
    """
    asked = (model.digest, vertices, recipe.test.loads, recipe.test.material, recipe.test.element, recipe.test.across_layers)
    name = hashlib.sha256(msgspec.json.encode(asked)).hexdigest()[:24]
    path = folder / f"{name}.json"
    with exclusive(folder / "locks" / name, f"the load of {recipe.test.loads[0].name!r}", wait=True):
        try:
            known = msgspec.json.decode(path.read_bytes(), type=tuple[LoadFactor, ...])
        except (OSError, msgspec.MsgspecError):
            known = load_factors(recipe, model, vertices)
            write_whole(path, msgspec.json.format(msgspec.json.encode(known), indent=1))
    cases = tuple(scaled(case, share * one.factor) for case, one in zip(recipe.test.loads, known, strict=True))
    return recipe.with_settings(loads=cases)


def load_factors(recipe: Recipe, model: SurfaceMesh, vertices: int) -> tuple[LoadFactor, ...]:
    """Load factors of a plain part, one for each load case of a recipe; arguments and errors as for `with_loads`."""
    part = prepare(model, vertices=vertices)
    test = recipe.test
    responses = StaticTest(part.tets, test.loads, test.element).run(part.tets, test.material, test.across_layers)
    weights, found = Walls(part.surface.vertices, part.thickness).weights(part.tets), []
    for name, response in responses.items():
        stress = exceeded(part.tets, at_nodes(part.tets, response.corners), weights, LOADED**3).stress
        found.append(LoadFactor(case=name, stress=stress, factor=recipe.test.material.yield_strength / stress))
    return tuple(found)


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


MEASURED = ("outcome", "sure", "flat_stress", "flat_height")
"""Columns by which a table is known to be of critical drop heights."""
FIELDS = Row.__struct_fields__


def write_table(rows: Sequence[Row], path: Path) -> Path:
    """Write rows to `path` with the suffix .parquet, or .json without pyarrow, and return it; it appears whole or not at all."""
    pyarrow = _pyarrow()
    if pyarrow is None:
        target = path.with_suffix(".json")
        write_whole(target, msgspec.json.format(msgspec.json.encode(list(rows)), indent=1))
        return target
    target, sink = path.with_suffix(".parquet"), pyarrow.BufferOutputStream()
    from pyarrow import parquet  # noqa: PLC0415 — an extra

    columns = {name: [getattr(row, name) for row in rows] for name in Row.__struct_fields__}
    plain = {float: pyarrow.float64(), float | None: pyarrow.float64(), int: pyarrow.int64(), bool: pyarrow.bool_()}
    fields = [(field.name, plain.get(field.type, pyarrow.string())) for field in msgspec.structs.fields(Row)]  # all else as text
    parquet.write_table(pyarrow.table(columns, schema=pyarrow.schema(fields)), sink, compression="zstd")
    write_whole(target, sink.getvalue().to_pybytes())
    return target


def read_table(source: str | Path) -> list[Row]:
    """The rows of a study's folder, or of a table made of one, .parquet or .json.

    Raises:
        BadInput: If there are none, or the table is another's or of another measure.
    """
    path = Path(source)
    if path.is_dir():
        rows = Rows(path).all()
        for row in [] if rows else sorted((path / "rows").glob("*.json")):  # is there one of another measure?
            with suppress(OSError, msgspec.MsgspecError):
                check_measure(path, msgspec.json.decode(row.read_bytes(), type=dict[str, Any]))
    elif not path.is_file():
        raise BadInput(f"{path} does not exist: name the folder of a study, or its table")
    else:
        rows = _read(path)
    if not rows:
        raise BadInput(f"{path} holds no rows of a study: name the folder that was its --out, or its table")
    return rows


def check_measure(path: Path, columns: Iterable[str]) -> None:
    """Refuse a table whose columns are not those of critical drop heights, with BadInput in one sentence."""
    known = set(columns)
    missing, strange = ([name for name in names if name not in others] for names, others in ((MEASURED, known), (sorted(known), FIELDS)))
    if missing and known & set(FIELDS):
        theirs = f", and has {', '.join(strange[:4])} instead" if strange else ""
        raise BadInput(f"{path} is of another measure: it lacks the columns {', '.join(missing)}{theirs}; run the study again")


def _read(path: Path) -> list[Row]:
    try:
        rows: list[Any]
        if path.suffix == ".json":
            rows = msgspec.json.decode(path.read_bytes(), type=list[dict[str, Any]])
        elif _pyarrow() is None:
            raise BadInput(f"{path} is Parquet, which needs pyarrow: pip install 'mechstyle[study]'")
        else:
            from pyarrow import parquet  # noqa: PLC0415 — an extra

            rows = parquet.read_table(path).to_pylist()
        for row in rows[:1]:
            check_measure(path, row)
        return msgspec.convert(rows, list[Row])
    except (msgspec.MsgspecError, ValueError, OSError) as error:
        if isinstance(error, BadInput):
            raise
        raise BadInput(f"{path} is no table of a study ({error}): make it again with `mechstyle study`") from error


def _pyarrow() -> Any:
    """The package, or None where it is not installed."""
    return import_module("pyarrow") if find_spec("pyarrow") else None
