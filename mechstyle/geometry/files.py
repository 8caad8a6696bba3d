"""Reading parts from files and writing them back, in millimetres, z up.

STL, OBJ and PLY have no unit and are taken as millimetres; 3MF names its unit; glTF is in metres with y up, by its standard.
"""

from __future__ import annotations

import io
import logging
import struct
import warnings
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
import trimesh
from numpy.typing import NDArray

from mechstyle._files import write_aside
from mechstyle.errors import BadInput
from mechstyle.geometry.claims import MOST_BYTES, MOST_FACES, check_claims
from mechstyle.geometry.glb import DULL, Sheen, glb_bytes
from mechstyle.geometry.repair import repaired
from mechstyle.geometry.threemf import threemf_bytes
from mechstyle.geometry.upright import lying, upright
from mechstyle.records.mesh import Field, Floats, SurfaceMesh

logging.getLogger("trimesh").addHandler(logging.NullHandler())  # or its tracebacks go to people who log nothing

FORMATS = ("stl", "obj", "ply", "glb", "3mf")
SMALLEST, LARGEST = 5.0, 1000.0
"""Sizes of a printable part, longest side [mm]."""
FARTHEST = 1e7
"""From the origin [mm]: farther away the numbers of a file no longer tell a part's details apart."""
MILLIMETRES = {"micron": 1e-3, "millimeter": 1.0, "centimeter": 10.0, "inch": 25.4, "foot": 304.8, "meter": 1000.0}
"""Of the units that 3MF has."""
SPELLED = {"": "millimeter", "mm": "millimeter", "millimetre": "millimeter"}
"""What programs write for a unit instead, in small letters and without a plural."""
GUESSES = {"millimetres": 1.0, "inches": 25.4, "centimetres": 10.0, "metres": 1000.0, "micrometres": 1e-3}
"""Units that a file may be in without saying so, likeliest first, and their millimetres."""
DAMAGED = (
    ArithmeticError, AssertionError, AttributeError, EOFError, LookupError, MemoryError, OSError, RuntimeError, StopIteration, SyntaxError,
    TypeError, UnboundLocalError, ValueError, struct.error, zipfile.BadZipFile, zlib.error,
)  # fmt: skip
"""What parsers raise at damaged files: they notice damage where something is missing, too large, or of another kind."""
MEASURED = ("glb", "ply")
"""Formats that hold fields over the surface."""
NO_FIELDS: Mapping[str, Field] = MappingProxyType({})


class ReadPart(NamedTuple):
    """A part and what had to be done to it, one sentence each."""

    mesh: SurfaceMesh
    notes: tuple[str, ...]


def read(path: str | Path, *, scale: float | None = None, up: str = "") -> ReadPart:
    """Read one closed body from an STL, OBJ, PLY, GLB or 3MF file; also returns the repairs it took.

    Args:
        path: The file.
        scale: Factor from the file's coordinates to millimetres; None for the format's own unit.
        up: The axis of the file that points up as the part stands, one of UPS; "" for the format's own, y in GLB and z elsewhere.

    Raises:
        BadInput: If the file cannot be used, in one sentence that says why and what to do.
    """
    file = Path(path)
    own = "y" if file.suffix.lower() == ".glb" else "z"
    axes = upright(up or own)
    if scale is not None and not (np.isfinite(scale) and scale > 0):
        raise BadInput(f"scale is {scale:g}, but must be a positive number, such as 25.4 for inches")
    vertices, faces, unit = _triangles(file)
    factor = _millimetres(file.name, unit) if scale is None else scale
    _check_size(file.name, vertices[faces].reshape(-1, 3), factor)
    mesh, notes = repaired(vertices * factor @ axes.T, faces, file.name)
    if better := lying(mesh, axes):
        flat = f"it seems to lie on its side: it has a flat base there, and stands on nothing flat; --up {better} sets it upright"
        notes = (*notes, flat)
    if factor != 1.0:
        notes = (f"converted to millimetres (times {factor:g})", *notes)
    return ReadPart(mesh, notes)


def _triangles(file: Path) -> tuple[Floats, NDArray[np.int64], str]:
    """Vertices in file units, faces, and the unit."""
    suffix = file.suffix.lower().lstrip(".")
    if suffix not in FORMATS:
        raise BadInput(f"{file.name}: cannot read {_kind(suffix)}; convert it to {', '.join(FORMATS)}")
    content = _content(file)
    check_claims(file.name, content, suffix)
    vertices, faces, unit = _parsed(file.name, content, suffix)
    if not len(faces):
        raise BadInput(f"{file.name} holds no triangles: it is no mesh, or was cut off; export it again")
    if len(faces) > MOST_FACES:
        raise BadInput(f"{file.name} has {len(faces)} faces, more than {MOST_FACES}: simplify it in the program it was made with")
    if vertices.shape[1:] != (3,):
        raise BadInput(f"{file.name} has vertices of {vertices.shape[-1]} coordinates instead of 3; export it again as a part in space")
    if not np.isfinite(vertices).all():
        raise BadInput(f"{file.name} has vertices that are not finite numbers; export it again")
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise BadInput(f"{file.name} has faces with vertices that are not there: it is damaged or was cut off; export it again")
    return vertices, faces, unit


def _millimetres(name: str, unit: str) -> float:
    """Millimetres of a unit; BadInput for one that nobody knows."""
    plain = unit.strip().lower().removesuffix("s")
    plain = SPELLED.get(plain, plain)
    if plain not in MILLIMETRES:
        known = f"it has {', '.join(MILLIMETRES)}"
        raise BadInput(f"{name} is in {unit[:40]!r}, a unit that 3MF does not have ({known}): export it again, or give --scale")
    return MILLIMETRES[plain]


def _kind(suffix: str) -> str:
    return f".{suffix} files" if suffix else "files without a suffix"


def _content(file: Path) -> bytes:
    """The bytes of a file that is there and not empty."""
    if not file.exists():
        raise BadInput(f"{file} does not exist; check the path")
    if not file.is_file():
        raise BadInput(f"{file} is not a file; name the mesh file itself")
    try:
        if (size := file.stat().st_size) > MOST_BYTES:
            too_large = f"has {size / 1e6:.0f} MB, more than {MOST_BYTES / 1e6:.0f}"
            raise BadInput(f"{file.name} {too_large}: simplify it in the program it was made with")
        content = file.read_bytes()
    except OSError as error:
        raise BadInput(f"{file} cannot be opened: {error.strerror}; check its permissions") from error
    if not content:
        raise BadInput(f"{file.name} is empty; export it again")
    return content


def _parsed(name: str, content: bytes, suffix: str) -> tuple[Floats, NDArray[np.int64], str]:
    """The file as trimesh reads it; what its parsers raise becomes one sentence."""
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")  # a reader's remarks; what matters is checked afterwards
            # A texture may be a small file of huge pixels, and is of no use here.
            bare: dict[str, Any] = {"skip_materials": True} if suffix in ("glb", "obj", "ply") else {}
            scene: Any = trimesh.load_scene(io.BytesIO(content), file_type=suffix, process=False, **bare)
            mesh = scene.to_mesh()
            vertices, faces = np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.int64)
    except DAMAGED as error:
        if error.__traceback__ is not None and error.__traceback__.tb_next is None:
            raise  # by this function, not by a parser: it is no fault of the file
        raise BadInput(
            f"{name} cannot be read as {suffix.upper()}: it is damaged, was cut off, or is something else; export it again"
        ) from error
    if suffix == "glb":
        return vertices, faces, "meter"
    return vertices, faces, str(scene.units or "") if suffix == "3mf" else "millimeter"


def _check_size(name: str, vertices: Floats, factor: float) -> None:
    """Refuse a part that is not of a printable size, guessing at its unit.

    Args:
        name: What to call the file.
        vertices: Positions in file units, shape [n, 3].
        factor: Millimetres of one file unit, as far as is known.
    """
    length = float(np.ptp(vertices, axis=0).max())
    if (far := float(np.abs(vertices).max()) * factor) > FARTHEST and length * factor <= LARGEST:
        raise BadInput(f"{name} lies {far / 1e6:.3g} km from the origin of its coordinates: move it there in the program it was made with")
    if SMALLEST <= round(length * factor, 2) <= LARGEST:  # a metre converted from single precision is not exactly one
        return
    if length == 0.0:
        raise BadInput(f"{name} has no extent: all its vertices coincide")
    guesses = [f"{unit} (--scale {other:g})" for unit, other in GUESSES.items() if SMALLEST <= length * other <= LARGEST]
    hint = f"if its coordinates are {' or '.join(guesses)}, say so" if guesses else "give a factor with --scale"
    shown = f"{length * factor:.0f}" if 100.0 <= length * factor < 1e9 else f"{length * factor:.3g}"
    raise BadInput(f"{name} is {shown} mm long; parts must be {SMALLEST:g} to {LARGEST:g} mm: {hint}")


def save(mesh: SurfaceMesh, path: str | Path, *, name: str = "", fields: Mapping[str, Field] = NO_FIELDS, sheen: Sheen = DULL) -> Path:
    """Write a surface in the format its suffix names; colours survive in OBJ, PLY, GLB and 3MF. The file appears whole or not at all.

    Args:
        mesh: The surface [mm].
        path: The file.
        name: What the part is called in it, where the format has names; by default as it was loaded.
        fields: Values at its vertices by name, such as stress, shape [vertex_count]: properties in PLY, attributes in GLB, where `stress`
            is called `_STRESS`. Their units stay what they are.
        sheen: How the surface reflects, where the format says so: GLB.

    Raises:
        BadInput: If the suffix is not one of FORMATS, cannot hold fields, or the place cannot be written to.
    """
    file = Path(path)
    suffix = file.suffix.lower().lstrip(".")
    if suffix not in FORMATS:
        raise BadInput(f"{file.name}: cannot write {_kind(suffix)}; use {', '.join(FORMATS)}")
    if fields:
        check_holds_fields(file)
    called = name or getattr(mesh, "name", "") or "part"
    try:
        write_aside(file, _content_of(mesh, suffix, called, fields, sheen))
    except OSError as error:
        raise _no_room(file, error) from error
    return file


def write_file(path: Path, content: bytes) -> None:
    """Write a file whole or not at all; BadInput if the place cannot be written to."""
    try:
        write_aside(path, content)
    except OSError as error:
        raise _no_room(path, error) from error


def _no_room(file: Path, error: OSError) -> BadInput:
    return BadInput(f"cannot write {file}: {error.strerror}; choose another place, or make room")


def check_holds_fields(path: str | Path) -> None:
    """Refuse a format that holds no fields over the surface, before they are made, with BadInput."""
    suffix = Path(path).suffix.lower().lstrip(".")
    if suffix not in MEASURED:
        raise BadInput(f"{Path(path).name}: {suffix.upper()} holds no fields; use {' or '.join(MEASURED)}, or leave the fields out")


def _content_of(mesh: SurfaceMesh, suffix: str, name: str, fields: Mapping[str, Field], sheen: Sheen) -> bytes:
    if suffix == "3mf":
        return threemf_bytes(mesh, name)
    return glb_bytes(mesh, name, fields, sheen) if suffix == "glb" else _exported(mesh, suffix, fields)


def _exported(mesh: SurfaceMesh, suffix: str, fields: Mapping[str, Field]) -> bytes:
    """The file's content by trimesh."""
    colours = None if mesh.colours is None else np.round(np.clip(mesh.colours, 0, 1) * 255).astype(np.uint8)
    written = trimesh.Trimesh(mesh.vertices, mesh.faces, vertex_colors=colours, process=False)
    written.vertex_attributes.update({name: np.asarray(values, np.float32) for name, values in fields.items()})
    content = written.export(file_type=suffix)
    return content.encode() if isinstance(content, str) else bytes(content)
