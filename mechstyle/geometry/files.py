"""Reading parts from files and writing them back, in millimetres, z up.

STL, OBJ and PLY have no unit and are taken as millimetres; 3MF names its unit; glTF is in metres with y up, by its standard.
"""

from __future__ import annotations

import os
import tempfile
import warnings
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import trimesh
from numpy.typing import NDArray

from mechstyle.errors import BadInput
from mechstyle.geometry.repair import repaired
from mechstyle.geometry.threemf import threemf_bytes
from mechstyle.mesh import Floats, SurfaceMesh

FORMATS = ("stl", "obj", "ply", "glb", "3mf")
MOST_FACES = 1_000_000
SMALLEST, LARGEST = 5.0, 1000.0
"""Sizes of a printable part, longest side [mm]."""
MILLIMETRES = {"micron": 1e-3, "millimeter": 1.0, "centimeter": 10.0, "inch": 25.4, "foot": 304.8, "meter": 1000.0, "meters": 1000.0}
Y_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""Rotation that takes a y-up position to a z-up one."""


class Loaded(NamedTuple):
    """A part and what had to be done to it, one sentence each."""

    mesh: SurfaceMesh
    notes: tuple[str, ...]


def load(path: str | Path, *, scale: float | None = None) -> SurfaceMesh:
    """One closed body from a file, repaired where needed; as `read`, without the notes."""
    return read(path, scale=scale).mesh


def read(path: str | Path, *, scale: float | None = None) -> Loaded:
    """One closed body from an STL, OBJ, PLY, GLB or 3MF file, and the repairs it took.

    Args:
        path: The file.
        scale: Factor from the file's coordinates to millimetres; None for the format's own unit.

    Raises:
        BadInput: If the file cannot be used, in one sentence that says why and what to do.
    """
    file = Path(path)
    if scale is not None and not (np.isfinite(scale) and scale > 0):
        raise BadInput(f"scale is {scale:g}, but must be a positive number, such as 25.4 for inches")
    vertices, faces, unit = _triangles(file)
    factor = unit if scale is None else scale
    vertices = vertices * factor
    _check_size(file.name, vertices, scale)
    mesh, notes = repaired(vertices, faces, file.name)
    if scale is None and unit != 1.0:
        notes = (f"converted to millimetres (times {unit:g})", *notes)
    return Loaded(mesh, notes)


def _triangles(file: Path) -> tuple[Floats, NDArray[np.int64], float]:
    """Vertices in file units, faces, and the millimetres of one file unit."""
    suffix = file.suffix.lower().lstrip(".")
    if suffix not in FORMATS:
        raise BadInput(f"{file.name}: cannot read .{suffix} files; convert it to {', '.join(FORMATS)}")
    if not file.is_file():
        raise BadInput(f"{file} does not exist; check the path")
    if file.stat().st_size == 0:
        raise BadInput(f"{file.name} is empty; export it again")
    scene = _scene(file)
    mesh = scene.to_mesh()
    vertices, faces = np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.int64)
    if not len(faces):
        raise BadInput(f"{file.name} holds no triangles: it is no mesh, or was cut off; export it again")
    if len(faces) > MOST_FACES:
        raise BadInput(f"{file.name} has {len(faces)} faces, more than {MOST_FACES}: simplify it in the program it was made with")
    if not np.isfinite(vertices).all():
        raise BadInput(f"{file.name} has vertices that are not finite numbers; export it again")
    if suffix == "glb":
        vertices = vertices @ Y_UP.T
    unit = MILLIMETRES.get(str(scene.units), 1.0) if suffix in ("glb", "3mf") else 1.0
    return vertices, faces, unit


def _scene(file: Path) -> Any:
    """What trimesh reads, with everything it may raise turned into one sentence."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a reader's remarks; what matters is checked afterwards
            return trimesh.load_scene(file, process=False)
    except Exception as error:
        raise BadInput(
            f"{file.name} cannot be read as {file.suffix.lstrip('.').upper()}: it is damaged, cut off, or something else; export it again"
        ) from error


def _check_size(name: str, vertices: Floats, scale: float | None) -> None:
    """Refuse a part that is not of a printable size, guessing at its unit."""
    size = float(np.ptp(vertices, axis=0).max())
    if SMALLEST <= size <= LARGEST:
        return
    if size == 0.0:
        raise BadInput(f"{name} has no extent: all its vertices coincide")
    if scale is not None:
        raise BadInput(f"{name} is {size:g} mm long with --scale {scale:g}; parts must be {SMALLEST:g} to {LARGEST:g} mm")
    guesses = [
        f"{unit} (--scale {factor:g})"
        for unit, factor in (("inches", 25.4), ("metres", 1000.0), ("centimetres", 10.0))
        if SMALLEST <= size * factor <= LARGEST
    ]
    if size > LARGEST:
        guesses = [f"micrometres (--scale {factor:g})" for factor in (0.001,) if SMALLEST <= size * factor <= LARGEST]
    hint = f"if it is in {' or '.join(guesses)}, say so" if guesses else "give a factor with --scale"
    raise BadInput(f"{name} is {size:.4g} mm long; parts must be {SMALLEST:g} to {LARGEST:g} mm: {hint}")


def save(mesh: SurfaceMesh, path: str | Path) -> Path:
    """Write a surface in the format its suffix names; colours survive in OBJ, PLY, GLB and 3MF. The file appears whole or not at all.

    Raises:
        BadInput: If the suffix is not one of FORMATS.
    """
    file = Path(path)
    suffix = file.suffix.lower().lstrip(".")
    if suffix not in FORMATS:
        raise BadInput(f"{file.name}: cannot write .{suffix} files; use {', '.join(FORMATS)}")
    content = threemf_bytes(mesh) if suffix == "3mf" else _exported(mesh, suffix)
    file.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=file.parent, prefix=".new-")
    try:
        with os.fdopen(handle, "wb") as aside:
            aside.write(content)
        Path(name).chmod(0o644)  # temporary files are private, parts are for sharing
        Path(name).replace(file)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise
    return file


def _exported(mesh: SurfaceMesh, suffix: str) -> bytes:
    """The file's content by trimesh."""
    vertices = mesh.vertices @ Y_UP / MILLIMETRES["meter"] if suffix == "glb" else mesh.vertices
    colours = None if mesh.colours is None else np.round(np.clip(mesh.colours, 0, 1) * 255).astype(np.uint8)
    written = trimesh.Trimesh(vertices, mesh.faces, vertex_colors=colours, process=False)
    content = written.export(file_type=suffix)
    return content.encode() if isinstance(content, str) else bytes(content)
