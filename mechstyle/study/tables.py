"""The rows of studies as one table: Parquet where pyarrow is installed, JSON where it is not."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import msgspec

from mechstyle._files import write_whole
from mechstyle.errors import BadInput
from mechstyle.study.cells import Row, Rows

MEASURED = ("outcome", "sure", "flat_stress", "flat_height")
"""Columns by which a table is known to be of critical drop heights."""
FIELDS = Row.__struct_fields__


def write_table(rows: Sequence[Row], path: Path) -> Path:
    """Write rows to `path` with the suffix .parquet, or .json without pyarrow; the file appears whole or not at all.

    Returns:
        The file that was written.
    """
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
