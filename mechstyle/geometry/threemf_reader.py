"""Reading 3MF as slicers write it: objects in several model parts, and what slicers keep beside the model of what is no material.

Identifiers of objects are unique within a model part only (3MF Core 1.3, 4.1; Production Extension 1.1.2), whose unit is that of its own
numbers. PrusaSlicer names roles by ranges of the triangles of an object, Bambu Studio and OrcaSlicer by components, Cura by words within
an object. All that a package claims is counted while it is read.
"""

from __future__ import annotations

import copy
import io
import posixpath
import zipfile
from array import array
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple
from xml.parsers import expat

import numpy as np

from mechstyle.geometry import claims
from mechstyle.geometry.claims import Beyond, too_many
from mechstyle.geometry.pieces import COLOURS_LEFT, Held, Piece, Thing, Unprinted, quoted_name
from mechstyle.records.mesh import Floats

MOST_MARKS = 16_000_000
"""Elements and attributes of XML; a million faces and their vertices take ten million."""
PIECE = 1_000_000
"""Bytes that are unpacked at a time."""
ENCRYPTED = 1
"""Of the flags of an entry of a ZIP package."""
ENCRYPTED_WORDS = "is encrypted: save it without a password"

MATERIAL, NEGATIVE = "", "negative volume"
ROLES = {
    "": MATERIAL, "ModelPart": MATERIAL, "normal_part": MATERIAL, "model": MATERIAL,
    "NegativeVolume": NEGATIVE, "negative_part": NEGATIVE,
    "ParameterModifier": "modifier", "modifier_part": "modifier",
    "SupportBlocker": "support blocker", "support_blocker": "support blocker",
    "SupportEnforcer": "support enforcer", "support_enforcer": "support enforcer",
    "support": "support", "solidsupport": "support", "surface": "surface that is not printed", "other": "object that is not printed",
    "infill_mesh": "modifier", "cutting_mesh": "modifier", "anti_overhang_mesh": "support blocker", "support_mesh": "support",
}  # fmt: skip
"""What PrusaSlicer, Bambu Studio and OrcaSlicer, types of 3MF objects, and Cura call what; any other word is no material either."""
MILLIMETRES = {"micron": 1e-3, "millimeter": 1.0, "centimeter": 10.0, "inch": 25.4, "foot": 304.8, "meter": 1000.0}
"""Of the units of 3MF."""
SHAPES = {
    "beam": "a beam lattice", "slicestack": "slices", "booleanshape": "a boolean of other objects", "levelset": "an implicit shape",
    "displacementmesh": "a displaced mesh",
}  # fmt: skip
"""Shapes of extensions of 3MF, by their elements."""


class _Key(NamedTuple):
    part: str  # the model part of an object …
    number: str  # … and its identifier there


class _Placement(NamedTuple):
    """An object in a place, shape [4, 4] for columns; an item may be one that is not printed."""

    key: _Key
    place: Floats
    printed: bool = True


class _Object:
    """An object as its model part has it."""

    def __init__(self, name: str, kind: str, *, coloured: bool) -> None:
        self.name, self.kind, self.coloured = name, kind, coloured
        self.numbers, self.indices = array("d"), array("q")
        self.components: list[_Placement] = []
        self.shapes: set[str] = set()

    def piece(self, name: str, place: Floats) -> Piece:
        """Its triangles in a place."""
        vertices = np.array(self.numbers, np.float64).reshape(-1, 3) @ place[:3, :3].T + place[:3, 3]
        faces = np.array(self.indices, np.int64).reshape(-1, 3)
        if len(faces) and not 0 <= faces.min() <= faces.max() < len(vertices):
            raise Beyond("has faces with vertices that are not there: it is damaged or was cut off; export it again")
        return Piece(name, vertices, faces[:, ::-1] if np.linalg.det(place[:3, :3]) < 0.0 else faces)


class _Volume(NamedTuple):
    """What a slicer says of a component, or of a stretch of triangles."""

    number: str
    first: int | None
    last: int | None
    facts: dict[str, str]

    @property
    def role(self) -> str:
        """What it is; "" for material."""
        word = self.facts.get("volume_type", self.facts.get("subtype", ""))
        if not word and self.facts.get("modifier") == "1":  # as it was written before there were types
            return "modifier"
        return ROLES.get(word, f"volume of the kind {quoted_name(word)}")


class _SlicerSettings:
    """What slicers say of objects, by their number: their names, and their volumes."""

    def __init__(self) -> None:
        self.names: dict[str, str] = {}
        self.volumes: dict[str, list[_Volume]] = {}
        self.coloured = False
        self._object, self._in_volume = "", False

    def element(self, kind: str, attributes: Mapping[str, str]) -> None:
        """Note an element of a settings file."""
        if kind == "object":
            self._object, self._in_volume = attributes.get("id", ""), False
        elif kind in ("volume", "part") and self._object:
            first, last = (int(attributes[key]) if kind == "volume" else None for key in ("firstid", "lastid"))
            facts = {"subtype": attributes.get("subtype", "")}
            self.volumes.setdefault(self._object, []).append(_Volume(attributes.get("id", ""), first, last, facts))
            self._in_volume = True
        elif kind == "metadata" and self._object:
            key, value = attributes.get("key", ""), attributes.get("value", "")
            self.coloured |= key == "extruder" and value not in ("", "0", "1")
            if self._in_volume and attributes.get("type") != "object":
                self.volumes[self._object][-1].facts[key] = value
            elif key == "name":
                self.names[self._object] = value
        elif kind == "plate":
            self._object = ""


class _Package:
    """The objects of all model parts of a package, and what is built of them."""

    def __init__(self) -> None:
        self.objects: dict[_Key, _Object] = {}
        self.items: dict[str, list[_Placement]] = {}
        self.units: dict[str, str] = {}
        self.said = _SlicerSettings()
        self.start = ""
        self._marks = 0
        self._part = ""
        self._object: _Object | None = None
        self._setting, self._words = "", ""
        self._parser: Any = None

    def read(self, name: str, file: Any) -> None:
        """Read an entry of the package: a model part, settings of a slicer, or where the package begins."""
        self._part, self._object = name, None
        handle = self._of_model if name.endswith(".model") else self.said.element

        def of_relations(kind: str, attributes: dict[str, str]) -> None:
            if kind == "Relationship" and attributes.get("Type", "").endswith("/3dmodel"):
                self.start = self.start or _path(attributes.get("Target", ""))

        def element(tag: str, attributes: dict[str, str]) -> None:
            self._marks += 1 + len(attributes)
            if self._marks > MOST_MARKS:
                raise Beyond(f"holds more than {MOST_MARKS / 1e6:.0f} million elements: simplify it in the program it was made with")
            (of_relations if name.endswith(".rels") else handle)(tag.rpartition(" ")[2], attributes)

        def doctype(*_: object) -> None:
            raise Beyond("declares a document type, which no 3MF file may: it is something else, or was made to do harm; export it again")

        parser = self._parser = expat.ParserCreate(namespace_separator=" ")
        parser.StartElementHandler, parser.StartDoctypeDeclHandler = element, doctype
        parser.ParseFile(file)

    def _of_model(self, kind: str, attributes: dict[str, str]) -> None:
        if kind == "object":
            self._begin(attributes)
        elif kind == "item":
            self.items.setdefault(self._part, []).append(self._placement(attributes))
        elif kind == "model":
            self.units[self._part] = attributes.get("unit", "millimeter")
        elif kind == "build":
            self._object = None
        elif self._object is not None:
            self._of_object(self._object, kind, attributes)

    def _of_object(self, thing: _Object, kind: str, attributes: dict[str, str]) -> None:
        if kind == "vertex":
            thing.numbers.extend((float(attributes["x"]), float(attributes["y"]), float(attributes["z"])))
        elif kind == "triangle":
            thing.indices.extend((int(attributes["v1"]), int(attributes["v2"]), int(attributes["v3"])))
            thing.coloured |= len(attributes) > 3
        elif kind == "component":
            thing.components.append(self._placement(attributes))
        elif kind in SHAPES:
            thing.shapes.add(SHAPES[kind])
        elif kind in ("metadata", "setting"):
            names = [value for name, value in attributes.items() if name.rpartition(" ")[2] in ("name", "key")]
            self._setting, self._words = (names or [""])[0].rpartition(":")[2], ""
            # Not called for a million other elements.
            self._parser.CharacterDataHandler, self._parser.EndElementHandler = self._word, self._end_of_setting

    def _word(self, words: str) -> None:
        """Text between elements; what Cura says of an object is a short word."""
        if len(self._words) < 8:
            self._words += words

    def _end_of_setting(self, _tag: str) -> None:
        self._parser.CharacterDataHandler = self._parser.EndElementHandler = None
        if self._object is not None:
            word = self._words.strip().lower()
            if self._setting.endswith("_mesh") and self._setting in ROLES and word == "true":
                self._object.kind = self._setting
            self.said.coloured |= self._setting == "extruder_nr" and word not in ("", "-1", "0")

    def _begin(self, attributes: dict[str, str]) -> None:
        key = _Key(self._part, attributes["id"])
        if key in self.objects:
            raise Beyond(f"has two objects {quoted_name(key.number)} in {key.part}: it is damaged; export it again")
        self._object = _Object(attributes.get("name", ""), attributes.get("type", "model"), coloured="pid" in attributes)
        if any(name.endswith("slicestackid") for name in attributes):
            self._object.shapes.add(SHAPES["slicestack"])
        self.objects[key] = self._object

    def _placement(self, attributes: dict[str, str]) -> _Placement:
        path = next((value for name, value in attributes.items() if name.rpartition(" ")[2] == "path"), "")
        place, words = np.eye(4), attributes.get("transform", "").split()
        if words:
            place[:3] = np.array([float(word) for word in words]).reshape(4, 3).T
        printed = attributes.get("printable", "1").strip().lower() not in ("0", "false")
        return _Placement(_Key(_path(path) if path else self._part, attributes["objectid"]), place, printed)


def _path(target: str) -> str:
    return posixpath.normpath("/" + target.strip().lstrip("/")).lower()


def read_threemf(content: bytes) -> Held:
    """All that a 3MF package builds, with what slicers say of it.

    Raises:
        Beyond: If it claims more than a part can have, or lacks what it is made of; a sentence without the file's name.
        ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error, expat.ExpatError and their kind: If it is damaged.
    """
    package = _Package()
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        entries = archive.infolist()
        too_many(len(entries))
        if sum(entry.file_size for entry in entries) > claims.MOST_BYTES:
            raise Beyond(f"unpacks to more than {claims.MOST_BYTES / 1e6:.0f} MB: simplify it in the program it was made with")
        if any(entry.filename.lower().endswith("/keystore.xml") for entry in entries):  # of the Secure Content extension
            raise Beyond(ENCRYPTED_WORDS)
        for entry in entries:
            if entry.flag_bits & ENCRYPTED:
                raise Beyond(ENCRYPTED_WORDS)
            if entry.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):  # of others no piece has a bound
                raise Beyond("is packed in a way that 3MF does not know: export it again")
            # Who reads an entry unpacks all of it: it must be of the size that the package says.
            unbelieved, size = copy.copy(entry), 0
            unbelieved.file_size, unbelieved.CRC = claims.MOST_BYTES + 1, None  # type: ignore[assignment]
            with archive.open(unbelieved) as file:
                while size <= entry.file_size and (piece := file.read(PIECE)):
                    size += len(piece)
            if size != entry.file_size:
                raise Beyond("unpacks to another size than it says: it is damaged or was made to do harm; export it again")
            name = _path(entry.filename)
            if name.endswith((".model", "_model.config", "/model_settings.config")) or name == "/_rels/.rels":
                with archive.open(entry) as file:
                    package.read(name, file)
    return _built(package)


class _Leaf(NamedTuple):
    """A stretch of triangles of an item, what it is, and the number of the object whose settings it falls under, 0 of none."""

    role: str
    piece: Piece
    owner: int = 0


def _built(package: _Package) -> Held:
    """What is built, item by item."""
    start = _start(package)
    if not start:
        raise Beyond("holds no model: it is no 3MF, or is damaged; export it again")
    things, unprinted, count = list[Thing](), list[Unprinted](), _Count()
    for item in package.items.get(start, ()):
        leaves = list(_leaves(package, item.key, item.place, count))
        body = package.objects[item.key]
        whole = ROLES.get(body.kind, f"object of the type {quoted_name(body.kind)}") if item.printed else "object that is not to be printed"
        if whole:
            unprinted += [Unprinted(whole, leaf.piece) for leaf in leaves]
            continue
        unprinted += [Unprinted(leaf.role, leaf.piece) for leaf in leaves if leaf.role not in (MATERIAL, NEGATIVE)]
        _sort_in(leaves, package.said.names.get(item.key.number, "") or body.name, things, unprinted)
    if not things:
        raise Beyond(_why_empty(package, start, unprinted))
    coloured = package.said.coloured or any(one.coloured for one in package.objects.values())
    notes: tuple[str, ...] = (COLOURS_LEFT,) if coloured else ()
    lattices = sorted({shape for one in package.objects.values() if one.indices for shape in one.shapes})
    notes += tuple(f"its triangles are read, and {shape} that it holds besides is left out" for shape in lattices)
    return Held(tuple(things), package.units[start], tuple(unprinted), notes)


def _start(package: _Package) -> str:
    """The model part where the package begins, "" if it has none."""
    return package.start if package.start in package.units else next(iter(package.items or package.units), "")


def _sort_in(leaves: list[_Leaf], name: str, things: list[Thing], unprinted: list[Unprinted]) -> None:
    """Add an item to what is printed: a negative volume takes from the object that its settings are of, and from no other."""
    cutting = {leaf.owner for leaf in leaves if leaf.role == NEGATIVE}
    groups: dict[int, list[_Leaf]] = {}
    for leaf in leaves:
        if leaf.role in (MATERIAL, NEGATIVE):
            groups.setdefault(leaf.owner if leaf.owner in cutting else -1, []).append(leaf)
    for group in groups.values():
        pieces, cuts = ([leaf.piece for leaf in group if leaf.role == role] for role in (MATERIAL, NEGATIVE))
        if len(pieces) == 1 and name:
            pieces = [pieces[0]._replace(name=pieces[0].name or name)]
        if pieces:
            things.append(Thing(name or pieces[0].name, tuple(pieces), tuple(cuts)))
        else:
            unprinted += [Unprinted(NEGATIVE, piece) for piece in cuts]


def _why_empty(package: _Package, start: str, unprinted: list[Unprinted]) -> str:
    """Why nothing of a package is printed."""
    if unprinted:
        named = "; ".join(f"{quoted_name(one.piece.name) if one.piece.name else 'it'} is {one.kind}" for one in unprinted[:3])
        named += "; …" if len(unprinted) > 3 else ""
        return f"holds nothing that is printed ({named}): make a part of it in the slicer, and save it again"
    if not package.items.get(start):
        return "has nothing on its plate: put the part on it in the program it was made with, and save it again"
    shapes = [(one.name, shape) for one in package.objects.values() for shape in sorted(one.shapes)]
    if shapes:
        name, shape = shapes[0]
        return f"holds {quoted_name(name) + ' as ' if name else ''}{shape}, and no triangles: export it as a mesh"
    return "holds no triangles: its objects are empty; export it again"


class _Count:
    """How much was built so far."""

    pieces = faces = 0

    def add(self, faces: int) -> None:
        self.pieces, self.faces = self.pieces + 1, self.faces + faces
        too_many(self.pieces)
        if self.faces > claims.MOST_FACES:
            raise Beyond(f"has more than {claims.MOST_FACES} faces: simplify it in the program it was made with")


def _leaves(
    package: _Package, key: _Key, place: Floats, count: _Count, name: str = "", role: str = MATERIAL, owner: int = 0,
    above: tuple[_Key, ...] = (),
) -> Iterator[_Leaf]:  # fmt: skip
    """The triangles of an object and of those that it is made of, each stretch with its role; all of an object has the role said of it."""
    if key in above:
        raise Beyond("has an object that is part of itself: it is damaged; export it again")
    count.add(0)
    body = _of(package, key)
    volumes = package.said.volumes.get(key.number, []) if key.part == _start(package) else []
    owner = count.pieces if volumes else owner
    ranges = [volume for volume in volumes if volume.first is not None]
    if body.indices and ranges:
        yield from (leaf._replace(role=role or leaf.role, owner=owner) for leaf in _stretches(body, place, ranges, count))
        return
    parts = [volume for volume in volumes if volume.first is None]
    if body.indices:
        count.add(len(body.indices) // 3)
        own = _role_of(parts, 0, [key.number])
        yield _Leaf(role or own[1], body.piece(name or own[0] or body.name, place), owner)
    numbers = [use.key.number for use in body.components]
    for index, use in enumerate(body.components):
        below = _of(package, use.key)
        its_name, its_role = _role_of(parts, index, numbers)
        listed = [part.number for part in parts]
        if listed != numbers and numbers[index] not in listed:
            its_role = ROLES.get(below.kind, MATERIAL)
        here, other = (MILLIMETRES.get(package.units[part]) for part in (key.part, use.key.part))  # model parts may be of different units
        there = place @ use.place @ (np.diag([other / here] * 3 + [1.0]) if here and other else np.eye(4))
        yield from _leaves(package, use.key, there, count, name or its_name, role or its_role, owner, (*above, key))


def _role_of(parts: list[_Volume], place: int, numbers: list[str]) -> tuple[str, str]:
    """The name and role of a component: by its place where the settings list them in order, else by its number."""
    in_order = [part.number for part in parts] == numbers
    found = parts[place] if in_order else next((part for part in parts if part.number == numbers[place]), None)
    return ("", MATERIAL) if found is None else (found.facts.get("name", ""), found.role)


def _stretches(body: _Object, place: Floats, ranges: list[_Volume], count: _Count) -> Iterator[_Leaf]:
    """The triangles of an object by the ranges of a slicer; what no range holds is material."""
    whole, free = body.piece(body.name, place), np.ones(len(body.indices) // 3, bool)
    for volume in ranges:
        assert volume.first is not None
        assert volume.last is not None
        stretch = slice(max(volume.first, 0), max(volume.last + 1, 0))
        free[stretch] = False
        if len(faces := whole.faces[stretch]):
            count.add(len(faces))
            yield _Leaf(volume.role, whole.submesh(faces, volume.facts.get("name", "")))
    if free.any():
        count.add(int(free.sum()))
        yield _Leaf(MATERIAL, whole.submesh(whole.faces[free]))


def _of(package: _Package, key: _Key) -> _Object:
    if key.part not in package.units:
        raise Beyond(f"lacks {quoted_name(key.part)}, of which its part is made: it is incomplete; export it again")
    if key not in package.objects:
        what = f"the object {quoted_name(key.number)} in {key.part}"
        raise Beyond(f"lacks {what}, of which its part is made: it is incomplete; export it again")
    return package.objects[key]
