"""Reading parts from files and writing them back, in millimetres, z up.

STL, OBJ and PLY have no unit and are taken as millimetres; 3MF and STEP name their unit; glTF is in metres with y up, by its standard. A
size that nobody prints is asked about.
"""

from __future__ import annotations

import codecs
import io
import logging
import re
import struct
import warnings
import zipfile
import zlib
from collections.abc import Mapping
from numbers import Real
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple
from xml.parsers import expat

import numpy as np
import trimesh

from mechstyle._files import write_aside
from mechstyle.errors import BadInput, absent, unknown
from mechstyle.geometry import step
from mechstyle.geometry.claims import MOST_BYTES, MOST_FACES, Beyond, check_claims, stl_length
from mechstyle.geometry.glb import DULL, Sheen, glb_bytes, plain
from mechstyle.geometry.mistaken import mistaken
from mechstyle.geometry.one_body import Body, bodies_of, repaired
from mechstyle.geometry.pieces import COLOURS_LEFT, Held, Piece, Thing, size_words
from mechstyle.geometry.threemf import threemf_bytes
from mechstyle.geometry.threemf_reader import read_threemf
from mechstyle.geometry.upright import lying, on_edge, upright
from mechstyle.records.material import LIBRARY
from mechstyle.records.mesh import Field, Floats, SurfaceMesh

logging.getLogger("trimesh").addHandler(logging.NullHandler())  # or its tracebacks go to people who log nothing

FORMATS = ("stl", "obj", "ply", "glb", "3mf")
SMALLEST, LARGEST = 5.0, 1000.0
"""Sizes of a printable part, longest side [mm]."""
SMALL, THIN = 10.0, 0.3
"""A part that is shorter, or whose walls are thinner all over [mm], is more probably one of another unit."""
FARTHEST = 1e7
"""From the origin [mm]: farther away the numbers of a file cannot hold a part's details."""
ENDLESS = 1e150
"""Coordinates that are no numbers to reckon with: their squares are infinite."""
UNITS = {"mm": 1.0, "in": 25.4, "cm": 10.0, "m": 1000.0, "ft": 304.8, "um": 1e-3}
"""Units and their millimetres, those that a file may be in without saying so first."""
SPELLED = {
    "": "mm", "millimeter": "mm", "millimetre": "mm", "centimeter": "cm", "centimetre": "cm", "meter": "m", "metre": "m", "inch": "in",
    "inche": "in", '"': "in", "foot": "ft", "feet": "ft", "micron": "um", "micrometer": "um", "micrometre": "um", "µm": "um",
}  # fmt: skip
"""How 3MF and people spell them, in small letters and without a plural."""
DAMAGED = (
    ArithmeticError, AssertionError, AttributeError, EOFError, LookupError, MemoryError, OSError, RuntimeError, StopIteration, SyntaxError,
    TypeError, UnboundLocalError, ValueError, expat.ExpatError, struct.error, zipfile.BadZipFile, zlib.error,
)  # fmt: skip
"""What parsers raise at damaged files: they notice damage where something is missing, too large, or of another kind."""
MEASURED = ("glb", "ply")
"""Formats that hold fields over the surface."""
BARE = ("obj", "glb")
"""Formats read by trimesh that may have textures."""
MADE_UP = re.compile(r"(geometry|world|[\w.]*\.ply)?_?\d*")
"""Names that trimesh gives to what has none."""
WEIGHTED = 5
"""Words in the line of a vertex of an OBJ file that has a weight after its coordinates."""
MOST_COPIED = MOST_BYTES // 8
"""Bytes of an OBJ file times its objects up to which these are read one by one: the parser copies all vertices for each."""
MOST_SAID = 8
"""Sentences on what was left out."""
NO_FIELDS: Mapping[str, Field] = MappingProxyType({})


class ReadPart(NamedTuple):
    """A part and what had to be done to it, one sentence each."""

    mesh: SurfaceMesh
    notes: tuple[str, ...]


def read(
    path: str | Path, *, scale: float | None = None, up: str = "", unit: str = "", size: float | None = None, body: str | int = ""
) -> ReadPart:
    """Read one closed body from an STL, OBJ, PLY, GLB, 3MF or STEP file; also returns the repairs it took.

    Args:
        path: The file.
        scale: Factor from the file's coordinates to millimetres; None for the format's own unit.
        up: The axis of the file that points up as the part stands, one of UPS; "" for the format's own, y in GLB and z elsewhere.
        unit: The unit of the file's coordinates, one of UNITS, instead of a scale.
        size: The longest side of the part [mm], instead of a scale: for files that have no unit.
        body: Which of several bodies, by its name or number; "" if there is one, or copies of one.

    Raises:
        BadInput: If the file cannot be used, in one sentence that says why and what to do.
    """
    file, body = Path(path), str(body)
    held, factor = _scaled(file, scale, unit, size)
    axes = _axes(file, up)
    mesh, repairs = repaired(_placed(held.things, factor * axes), file.name, body)
    if size is not None:
        mesh = SurfaceMesh(mesh.vertices * (size / float(mesh.extents.max())), mesh.faces)
    elif scale is None and not unit:
        _check_plausible(file.name, mesh, factor)
    mass = mesh.volume * LIBRARY["PLA"].density
    notes = [f"{size_words(mesh.vertices)}, {f'{mass:.0f}' if mass >= 10.0 else f'{mass:.2g}'} g in solid PLA"]
    if factor != 1.0:
        notes.append(f"converted to millimetres (times {factor:g})")
    notes += _left_out(held, factor * axes)
    notes += [*held.notes, *repairs]
    if better := lying(mesh, axes):
        notes.append(f"it seems to lie on its side: it has a flat base there, and stands on nothing flat; --up {better} sets it upright")
    elif better := on_edge(mesh, axes):
        notes.append(f"it stands on its thin edge; --up {better} lays it flat")
    return ReadPart(mesh, tuple(notes))


def bodies(path: str | Path, *, scale: float | None = None, up: str = "", unit: str = "", size: float | None = None) -> tuple[Body, ...]:
    """List the separate bodies of a file, as `read` would choose among them; arguments and errors as there."""
    file = Path(path)
    held, factor = _scaled(file, scale, unit, size)
    return tuple(bodies_of(_placed(held.things, factor * _axes(file, up)), file.name, []))


def millimetres(unit: str) -> float:
    """Millimetres of a unit, spelled in any way; BadInput for one that nobody knows."""
    plain_word = unit.strip().lower().removesuffix("s")
    plain_word = SPELLED.get(plain_word, plain_word)
    if plain_word not in UNITS:
        raise unknown("unit", unit[:40], UNITS)
    return UNITS[plain_word]


def _axes(file: Path, up: str) -> Floats:
    """The rotation that sets a file upright, shape [3, 3]."""
    return upright(up or ("y" if file.suffix.lower() == ".glb" else "z"))


def _scaled(file: Path, scale: float | None, unit: str, size: float | None) -> tuple[Held, float]:
    """What a file holds and its millimetres, of a printable size; what was said of its unit is checked first."""
    given = {"a scale": scale is not None, "a unit": bool(unit), "a size": size is not None}
    if sum(given.values()) > 1:
        raise BadInput(f"{' and '.join(what for what, is_given in given.items() if is_given)} are given: one of them says it all")
    for what, number, example in (("scale", scale, "25.4 for inches"), ("size", size, "120 for 120 mm")):
        real = isinstance(number, Real)
        if number is not None and not (real and np.isfinite(number) and number > 0):
            raise BadInput(f"{what} is {f'{number:g}' if real else repr(number)}, but must be a positive number, such as {example}")
    factor_given = millimetres(unit) if unit else scale
    held = _checked_content(file)
    corners = np.concatenate([piece.corners for thing in held.things for piece in thing.pieces])
    longest = float(np.ptp(corners, axis=0).max())
    if size is not None and longest > 0.0:
        factor_given = size / longest
    try:
        factor = millimetres(held.unit) if factor_given is None else factor_given
    except BadInput as error:
        odd = f"{file.name} is in {held.unit[:40]!r}, a unit that 3MF does not have"
        raise BadInput(f"{odd}: export it again, or say its unit with --unit") from error
    _check_size(file.name, corners, factor)
    return held, factor


def _placed(things: tuple[Thing, ...], matrix: Floats) -> list[Thing]:
    """Objects turned and scaled, by a matrix for columns, shape [3, 3]."""

    def moved(pieces: tuple[Piece, ...]) -> tuple[Piece, ...]:
        return tuple(piece._replace(vertices=piece.vertices @ matrix.T) for piece in pieces)

    return [Thing(thing.name, moved(thing.pieces), moved(thing.cuts)) for thing in things]


def _left_out(held: Held, matrix: Floats) -> list[str]:
    """A sentence for each piece that is no material."""
    said = [f"left out {one.words(matrix)}" for one in held.unprinted[:MOST_SAID]]
    more = len(held.unprinted) - len(said)
    return [*said, *([f"left out {more} more that are not printed"] if more else [])]


def _checked_content(file: Path) -> Held:
    """What a file holds, in its units; at least one piece, with faces."""
    content, suffix = _known_content(file)
    if suffix != "3mf":
        check_claims(file.name, content, suffix)
    held = _parsed(file.name, content, suffix)
    pieces = [piece for thing in held.things for piece in (*thing.pieces, *thing.cuts)]
    count = sum(len(piece.faces) for piece in pieces)
    if not count:
        raise BadInput(f"{file.name} holds no triangles: it is no mesh, or was cut off; export it again")
    if count > MOST_FACES:
        raise BadInput(f"{file.name} has {count} faces, more than {MOST_FACES}: simplify it in the program it was made with")
    for _, vertices, faces in (*pieces, *(one.piece for one in held.unprinted)):
        if vertices.shape[1:] != (3,):
            raise BadInput(f"{file.name} has vertices of {vertices.shape[-1]} coordinates instead of 3; export it again as a part in space")
        if not (np.abs(vertices) < ENDLESS).all():
            raise BadInput(f"{file.name} has vertices that are not finite numbers; export it again")
        if len(faces) and (faces.min() < 0 or faces.max() >= len(vertices)):
            raise BadInput(f"{file.name} has faces with vertices that are not there: it is damaged or was cut off; export it again")
    return held


def _known_content(file: Path) -> tuple[bytes, str]:
    """The bytes of a file and the suffix of its format, one of FORMATS."""
    suffix = file.suffix.lower().lstrip(".")
    if not file.name.isprintable():
        raise BadInput(f"{file.name[:60]!r} holds signs that are no letters: give the file another name")
    _check_there(file)
    if suffix not in {*FORMATS, *step.SUFFIXES}:
        raise BadInput(
            f"{file.name}: cannot read {_kind(suffix)}; open it in the program it was made with and export it as {', '.join(FORMATS)}"
        )
    content = _normalised_text(_content(file), suffix)
    if what := mistaken(content, "step" if suffix in step.SUFFIXES else suffix):
        raise BadInput(f"{file.name} {what}")
    return (step.glb_of(file.name, content), "glb") if suffix in step.SUFFIXES else (content, suffix)


def _kind(suffix: str) -> str:
    return f".{suffix} files" if suffix else "files without a suffix"


def is_there(path: Path) -> bool:
    """Whether there is something at a path; of one that no system allows, as it is too long, there is nothing."""
    try:
        return path.exists()
    except (OSError, ValueError):
        return False


def _check_there(file: Path) -> None:
    """Refuse what is no file, with the folder in which a path that is not there was looked for."""
    if not is_there(file):
        raise absent(file)
    if not file.is_file():
        raise BadInput(f"{file} is a folder, not a file; name the mesh file itself")


def _content(file: Path) -> bytes:
    """The bytes of a file that is there and not empty."""
    _check_there(file)
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


def _normalised_text(content: bytes, suffix: str) -> bytes:
    """Text as trimesh reads it, which is stricter than the formats are; other files as they are."""
    if suffix in {"3mf", "glb"} or b"\0" in content:
        return content
    text = content if b"\n" in content else content.replace(b"\r", b"\n")
    if suffix == "obj":
        text = text.removeprefix(codecs.BOM_UTF8).replace(b"\r\n", b"\n").replace(b"\t", b" ").replace(b"\\\n", b" ")
        if b"\n " in text:
            text = re.sub(rb"(?m)^ +", b"", text)
        if b"#" in text:
            text = re.sub(rb"(?m)^((?:v|vn|vt|f) [^#\n]*)#.*$", rb"\1", text)
        first = re.search(rb"(?m)^v [^\n]*", text)
        if first and len(first[0].split()) == WEIGHTED:
            text = re.sub(rb"(?m)^(v(?: +[^ \n]+){3}) +[^ \n]+ *$", rb"\1", text)
    if suffix == "stl":
        text = re.sub(rb"(?mi)^([ \t]*end)[ \t]+(loop|facet|solid)\b", rb"\1\2", text)
    return text


def _parsed(name: str, content: bytes, suffix: str) -> Held:
    """What a file holds, in its units; what readers raise at damage becomes one sentence."""
    notes: tuple[str, ...] = ()
    try:
        if suffix == "3mf":
            return read_threemf(content)
        if suffix == "glb":
            content, notes = plain(content)
        if suffix == "stl" and 0 < (whole := stl_length(content)) < len(content):
            content, notes = content[:whole], (f"left out {len(content) - whole} bytes after its last triangle",)
    except Beyond as error:
        raise BadInput(f"{name} {error}") from error
    except DAMAGED as error:
        raise _damaged(name, suffix) from error
    pieces = _by_trimesh(name, content, suffix)
    coloured = (COLOURS_LEFT,) if _is_coloured(content, suffix) else ()
    return Held((Thing("", pieces),), "m" if suffix == "glb" else "mm", notes=(*notes, *coloured))


def _by_trimesh(name: str, content: bytes, suffix: str) -> tuple[Piece, ...]:
    """The objects of a file in their places, at least one."""
    # A texture may be a small file of huge pixels, and is of no use here.
    bare: dict[str, Any] = {"skip_materials": True} if suffix in BARE else {}
    if suffix == "obj":
        objects, groups = (len(re.findall(rb"(?m)^%b " % sign, content)) for sign in (b"o", b"g"))
        if len(content) * (objects or groups) <= MOST_COPIED:
            bare["split_objects" if objects else "split_groups"] = True
    pieces = []
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")  # a reader's remarks; what matters is checked afterwards
            scene: Any = trimesh.load_scene(io.BytesIO(content), file_type=suffix, process=False, **bare)
            nodes = list(scene.graph.nodes_geometry)
            for node in reversed(nodes) if suffix == "obj" else nodes:  # it reads OBJ from its end
                place, geometry = scene.graph[node]
                mesh = scene.geometry[geometry]
                if hasattr(mesh, "faces") and len(mesh.faces):  # of points and lines nothing is printed
                    vertices, faces = np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.int64)
                    moved = vertices @ place[:3, :3].T + place[:3, 3] if vertices.shape[1:] == (3,) else vertices
                    pieces.append(Piece("" if MADE_UP.fullmatch(str(node)) else str(node), moved, faces))
    except DAMAGED as error:
        if error.__traceback__ is not None and error.__traceback__.tb_next is None:
            raise  # by this function, not by a parser: it is no fault of the file
        raise _damaged(name, suffix) from error
    return tuple(pieces)


def _damaged(name: str, suffix: str) -> BadInput:
    return BadInput(f"{name} cannot be read as {suffix.upper()}: it is damaged, was cut off, or is something else; export it again")


def _is_coloured(content: bytes, suffix: str) -> bool:
    """Whether an STL, OBJ or PLY file holds colours."""
    if suffix == "ply":
        return bool(re.search(rb"property\s+\w+\s+(red|diffuse_red)\b|comment\s+TextureFile\b", content.partition(b"end_header")[0]))
    if suffix == "obj":
        return bool(re.search(rb"(?m)^[ \t]*(usemtl[ \t]|v(?:[ \t]+[-+.\deE]+){6,})", content))
    if suffix != "stl" or stl_length(content) != len(content):
        return False
    words = np.frombuffer(content, np.uint8, offset=84).reshape(-1, 50)[:, 49]
    return content.startswith(b"COLOR=") or bool((words & 0x80).any())  # Magics has it in the header, VisCAM in a bit of each face


def _check_size(name: str, vertices: Floats, factor: float) -> None:
    """Refuse positions in file units, shape [n, 3], of no printable size, guessing at their unit, of `factor` mm as far as is known."""
    length = float(np.ptp(vertices, axis=0).max())
    if (far := float(np.abs(vertices).max()) * factor) > FARTHEST and length * factor <= LARGEST:
        raise BadInput(f"{name} lies {far / 1e6:.3g} km from the origin of its coordinates: move it there in the program it was made with")
    if SMALLEST <= round(length * factor, 2) <= LARGEST:  # a metre converted from single precision is not exactly one
        return
    if length == 0.0:
        raise BadInput(f"{name} has no extent: all its vertices coincide")
    fitting = [f"--unit {unit}" for unit, other in UNITS.items() if SMALLEST <= length * other <= LARGEST]
    shown = f"{length * factor:.0f}" if 100.0 <= length * factor < 1e9 else f"{length * factor:.3g}"
    hint = f"say its unit, such as {' or '.join(fitting)}, or" if fitting else "say"
    known = f"{name} is {shown} mm long; parts must be {SMALLEST:g} to {LARGEST:g} mm"
    raise BadInput(f"{known}: {hint} how long it is to be, such as --size 120 for 120 mm")


def _check_plausible(name: str, mesh: SurfaceMesh, factor: float) -> None:
    """Refuse a part [mm] that can be printed hardly, if another unit makes a usual one of it; who means it so says its unit."""
    longest, wall = float(mesh.extents.max()), float(2.0 * mesh.volume / mesh.face_areas.sum())  # exactly so of a sheet
    if longest >= SMALL and wall >= THIN:
        return
    fitting = []
    for unit, other in UNITS.items():
        times = other / factor
        if times > 1.0 and SMALL <= longest * times <= LARGEST and wall * times >= THIN:
            fitting.append(f"--unit {unit} ({size_words(mesh.vertices * times)})")
    own = next((unit for unit, other in UNITS.items() if other == factor), "")
    thin = f" with walls of {wall:.2g} mm all over" if wall < THIN else ""
    so = f"--unit {own} if it is so small" if own else f"--scale {factor:g} if it is so small"
    raise BadInput(
        f"{name} would be {size_words(mesh.vertices)}{thin}, which hardly anybody prints: say its unit, {', '.join([*fitting, so])}, "
        "or how long it is to be, such as --size 120"
    )


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

    Example:
        >>> path = ms.save(ms.load("gallery:drawer_knob"), "knob.stl")
        >>> ms.load(path).faces.shape
        (19296, 3)
    """
    file = Path(path)
    suffix = file.suffix.lower().lstrip(".")
    if suffix not in FORMATS:
        raise BadInput(f"{file.name}: cannot write {_kind(suffix)}; use {', '.join(FORMATS)}")
    if fields:
        check_holds_fields(file)
    called = name or getattr(mesh, "name", "") or "part"
    if suffix == "3mf":
        content = threemf_bytes(mesh, called)
    else:
        content = glb_bytes(mesh, called, fields, sheen) if suffix == "glb" else _exported(mesh, suffix, fields)
    write_file(file, content)
    return file


def write_file(path: Path, content: bytes) -> None:
    """Write a file whole or not at all; BadInput if the place cannot be written to."""
    try:
        write_aside(path, content)
    except OSError as error:
        raise BadInput(f"cannot write {path}: {error.strerror}; choose another place, or make room") from error


def check_holds_fields(path: str | Path) -> None:
    """Refuse a format that holds no fields over the surface, before they are made, with BadInput."""
    suffix = Path(path).suffix.lower().lstrip(".")
    if suffix not in MEASURED:
        raise BadInput(f"{Path(path).name}: {suffix.upper()} holds no fields; use {' or '.join(MEASURED)}, or leave the fields out")


def _exported(mesh: SurfaceMesh, suffix: str, fields: Mapping[str, Field]) -> bytes:
    """The file's content by trimesh."""
    colours = None if mesh.colours is None else np.round(np.clip(mesh.colours, 0, 1) * 255).astype(np.uint8)
    written = trimesh.Trimesh(mesh.vertices, mesh.faces, vertex_colors=colours, process=False)
    written.vertex_attributes.update({name: np.asarray(values, np.float32) for name, values in fields.items()})
    content = written.export(file_type=suffix)
    return content.encode() if isinstance(content, str) else bytes(content)
