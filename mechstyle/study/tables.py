"""The rows of studies as one table: Parquet where pyarrow is installed, JSON where it is not."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import msgspec

from mechstyle._files import write_whole
from mechstyle.errors import BadInput
from mechstyle.study.cells import Row, Rows


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
    fields = [(field.name, _type(pyarrow, field.type)) for field in msgspec.structs.fields(Row)]
    parquet.write_table(pyarrow.table(columns, schema=pyarrow.schema(fields)), sink, compression="zstd")
    write_whole(target, sink.getvalue().to_pybytes())
    return target


def read_table(source: str | Path) -> list[Row]:
    """The rows of a study's folder, or of a table made of one, .parquet or .json.

    Raises:
        BadInput: If there are none, or the table is another's.
    """
    path = Path(source)
    if path.is_dir():
        rows = Rows(path).all()
    elif not path.is_file():
        raise BadInput(f"{path} does not exist: name the folder of a study, or its table")
    else:
        rows = _read(path)
    if not rows:
        raise BadInput(f"{path} holds no rows of a study: name the folder that was its --out, or its table")
    return rows


def _read(path: Path) -> list[Row]:
    try:
        if path.suffix == ".json":
            return msgspec.json.decode(path.read_bytes(), type=list[Row])
        if _pyarrow() is None:
            raise BadInput(f"{path} is Parquet, which needs pyarrow: pip install 'mechstyle[study]'")
        from pyarrow import parquet  # noqa: PLC0415 — an extra

        return msgspec.convert(parquet.read_table(path).to_pylist(), list[Row])
    except (msgspec.MsgspecError, ValueError, OSError) as error:
        if isinstance(error, BadInput):
            raise
        raise BadInput(f"{path} is no table of a study ({error}): make it again with `mechstyle study`") from error


def _pyarrow() -> Any:
    """The package, or None where it is not installed."""
    return import_module("pyarrow") if find_spec("pyarrow") else None


def _type(pyarrow: Any, kind: Any) -> Any:
    """The column type of a field: numbers and flags as they are, all else text."""
    plain = {float: pyarrow.float64(), float | None: pyarrow.float64(), int: pyarrow.int64(), bool: pyarrow.bool_()}
    return plain.get(kind, pyarrow.string())
