"""Files and command lines as nobody should write them.

`python -m support.hostile FOLDER FIRST COUNT` tries that many cases from a number on and prints what came of them as JSON.
Each case is one seeded change of something sound: bytes flipped, cut out, doubled or swapped, numbers made huge, names made into paths,
records pointed
at the wrong thing, packages that unpack to gigabytes. What reads them may answer, or refuse in one sentence; it may not crash, hang,
show a traceback, or
take memory that the file does not account for. A case is named by its kind and number, and the same in every process.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import random
import resource
import shutil
import signal
import struct
import sys
import time
import zipfile
import zlib
from collections import Counter
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import trimesh

from mechstyle.errors import MechStyleError
from mechstyle.gallery import load
from mechstyle.geometry.files import bodies, read
from mechstyle.geometry.glb import glb_bytes
from mechstyle.geometry.threemf import threemf_bytes
from mechstyle.loop.objects import to_json
from mechstyle.records.load_cases import read_loads
from mechstyle.records.material import LIBRARY, read_material
from mechstyle.runs.run import Run
from mechstyle.styling.prompt import read as read_prompt
from support import gltf_files, part_files, slicer_files
from support.lanes import lane_on_a_sheet
from support.step_file import box_step

SECONDS = 20
"""CPU time after which a case hangs."""
MEMORY = 600_000_000
"""Bytes that a case may add to the memory of the process at its fullest: its files are a few kilobytes each."""

CASE, WRONG = "case ", "WRONG: "
"""How lines of stderr begin: the case that is about to be tried, and what was wrong with one."""

Case = Callable[[random.Random, Path], None]

WORDS = (b"nan", b"inf", b"-1", b"0", b"99999999999999999999", b"1e400", b"4294967295", b"-2147483648", b"9" * 5000, b"../../etc/passwd", b"file:///etc/passwd",
         b"http://127.0.0.1:9/x", b"\x1b]0;x\x07",
         b"[" * 3000, b"{" * 3000, b'"', b"'", b"<", b"&lol;", b"<!DOCTYPE x [<!ENTITY a 'b'>]>", b"[/red]",
         b"\x00", b"\xff\xfe", "größe".encode(), b"1000000000", b"true", b"null", b"[]", b"{}")  # fmt: skip
"""What a number or a name is replaced by."""


def mutated(draw: random.Random, content: bytes) -> bytes:
    """A few changes of some bytes."""
    data = bytearray(content)
    for _ in range(draw.choice((1, 1, 1, 2, 4, 16))):
        if not data:
            return b""
        at, length = draw.randrange(len(data)), draw.choice((1, 1, 2, 4, 12, 50, 200))
        change = draw.randrange(8)
        if change == 0:
            data[at] ^= 1 << draw.randrange(8)
        elif change == 1:
            del data[at : at + length]
        elif change == 2:
            data[at:at] = data[at : at + length] * draw.choice((1, 3, 100))
        elif change == 3:
            data[at : at + length] = draw.randbytes(length)
        elif change == 4:
            del data[at:]
        elif change == 5:
            data[at : at + 4] = struct.pack("<I", draw.choice((0, 1, 2**31 - 1, 2**31, 2**32 - 1, 10**9)))
        elif change == 6:
            data[at:at] = draw.choice(WORDS)
        else:
            _swap_a_word(draw, data)
    return bytes(data)


def _swap_a_word(draw: random.Random, data: bytearray) -> None:
    """Replace a run of letters or digits, which keeps what is around it sound."""
    at = draw.randrange(len(data))
    letters = b"abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789.-_+"
    low = high = at
    while low and data[low - 1] in letters and at - low < 100:
        low -= 1
    while high < len(data) and data[high] in letters and high - at < 100:
        high += 1
    data[low:high] = draw.choice(WORDS)


@cache
def sound(kind: str) -> bytes:
    """A file of a kind that can be read."""
    texts = {
        "material.toml": 'name = "x"\nyoungs_modulus = 2000.0\npoisson_ratio = 0.35\ndensity = 1.2e-3\n'
        'yield_strength = 40.0\nlayer_ratio = 0.5\nsource = "me"\n',
        "loads.toml": '[[case]]\nname = "hand"\n[[case.supports]]\nat = "resting face"\n'
        "[[case.loads]]\nat = {sphere = [1.0, 2.0, 3.0, 4.0]}\nforce = [0.0, 0.0, -10.0]\n",
    }  # fmt: skip
    if kind in texts:
        return texts[kind].encode()
    makers: dict[str, Callable[[], bytes]] = {
        "binary.stl": lambda: part_files.exported("stl"),
        "words.stl": lambda: part_files.exported("stl_ascii"),
        "part.obj": lambda: part_files.exported("obj"),
        "binary.ply": lambda: part_files.exported("ply"),
        "words.ply": part_files.ascii_ply,
        "part.glb": lambda: glb_bytes(part_files.PART.coloured(np.full((len(part_files.PART.vertices), 3), 0.5)), "part"),
        "node.glb": part_files.glb_with_node,
        "part.3mf": lambda: threemf_bytes(part_files.PART.coloured(np.full((len(part_files.PART.vertices), 3), 0.5))),
        "material.json": lambda: msgspec.json.encode(LIBRARY["PLA"]),
    }
    return makers[kind]()


def several(*boxes: tuple[str, tuple[float, ...], tuple[float, ...]]) -> bytes:
    """An OBJ file of boxes by name, each of a size and a lowest corner."""
    return slicer_files.named_obj("o", [(name, (size, place)) for name, size, place in boxes])


def exported_mesh(mesh: trimesh.Trimesh) -> bytes:
    """A mesh as STL."""
    return bytes(mesh.export(file_type="stl"))


def _zip_of(name: str, content: bytes) -> bytes:
    """An archive of one file."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        archive.writestr(name, content)
    return buffer.getvalue()


PLATE = "plate", (40, 30, 3), (0, 0, 0)
BOXES = ("box", slicer_files.PLATE), ("lid", slicer_files.BESIDE)
OF_SLICERS: dict[str, Callable[[], bytes]] = {
    "orca.3mf": lambda: slicer_files.orca("negative_part"),
    "apart.3mf": lambda: slicer_files.orca_apart("modifier_part"),
    "prusa.3mf": lambda: slicer_files.prusa("NegativeVolume"),
    "cura.3mf": lambda: slicer_files.cura("infill_mesh"),
    "assembly.3mf": lambda: slicer_files.assembly("negative_part"),
}
"""What slicers write; kinds of parts, of volumes and of plates are mutated with the models."""
OTHERS: dict[str, Callable[[], bytes]] = {
    "specks.obj": lambda: several(PLATE, *(("dot", (0.8, 0.8, 0.5), (x, 5, 3)) for x in range(4, 36, 4))),
    "sheet.obj": lambda: several(("box", (40, 30, 20), (0, 0, 0)), ("wall", (0, 30, 20), (20, 0, 0))),
    "plate.obj": lambda: several(("box", (20, 20, 9), (0, 0, 0)), ("box", (20, 20, 9), (30, 0, 0)), ("lid", (20, 20, 2), (60, 0, 0))),
    "groups.obj": lambda: slicer_files.named_obj("g", BOXES),
    "solids.stl": lambda: slicer_files.named_stl(BOXES),
    "thin.obj": lambda: several(("floor", (24, 24, 0.2), (0, 0, 0)), ("wall", (24, 0.2, 30), (0, 0, 0))),
    "touching.obj": lambda: several(("half", (20, 20, 20), (0, 0, 0)), ("half", (20, 20, 20), (20, 0, 0))),
    "nearly.obj": lambda: several(("half", (20, 20, 20), (0, 0, 0)), ("half", (20, 20, 20), (20.01, 0, 0))),
    "edge.obj": lambda: several(("half", (20, 20, 20), (0, 0, 0)), ("half", (20, 20, 20), (20, 20, 0))),
    "tube.stl": lambda: exported_mesh(trimesh.creation.annulus(r_min=9, r_max=12, height=30)),
    "end loop.stl": lambda: part_files.exported("stl_ascii").replace(b"endloop", b"end loop"),
    "comma.obj": lambda: part_files.exported("obj").replace(b".", b","),
    "zipped.stl": lambda: _zip_of("things/part.stl", part_files.exported("stl")),
    "renamed.stl": lambda: part_files.exported("ply"),
    "pointer.stl": lambda: b"version https://git-lfs.github.com/spec/v1\noid sha256:" + b"0" * 64 + b"\nsize 12345\n",
    "page.obj": lambda: b"<!DOCTYPE html>\n<html><title>Log in</title></html>",
    "box.step": lambda: box_step((40.0, 30.0, 20.0)).encode(),
    "quantised.glb": gltf_files.quantised,
    "sparse.glb": gltf_files.sparse,
    "alone.glb": lambda: gltf_files.sparse(based=False),
    "fans.glb": gltf_files.fans,
    "besides.glb": gltf_files.besides,
    "draco.glb": lambda: gltf_files.packed("KHR_draco_mesh_compression"),
    "meshopt.glb": lambda: gltf_files.packed("EXT_meshopt_compression", view=True),
    "tail.stl": lambda: part_files.exported("stl") + bytes(200),
}
"""Parts that need more than a parser: bodies apart, walls inside, sizes that are asked about, numbers that are packed."""
READINGS: tuple[dict[str, Any], ...] = (
    {"body": 1}, {"body": "plate"}, {"body": "lid"}, {"body": "9" * 40}, {"body": "\x1b[2J"}, {"unit": "cm"}, {"unit": "ell"},
    {"unit": "mm"}, {"size": 120.0}, {"size": float("nan")}, {"size": -1.0}, {"size": 1e300}, {"scale": 2.0, "size": 9.0},
)  # fmt: skip
"""How they are asked to be read."""
SAID = (b"body=lid", b"unit=cm", b"size=120,body=1", b"scale=2,up=-y,body=lid, left", b"unit=in,unit=mm")
"""The same after the path."""
PROMPTS = (
    b"outside: brick; rim 5 mm: gold studs", b"a wooden owl with gold eyes, 3 mm deep", b"no spikes, but dark blue scales on the top half",
    "außen: dünne Ziegel; Rand: goldene Nieten".encode(), "外側: レンガ; 縁: 金の鋲".encode(), "écailles bleues, 1/4 inch".encode(),
)  # fmt: skip
"""What a style is asked for with."""


def _prompt(draw: random.Random, _folder: Path) -> None:
    prompt = mutated(draw, draw.choice(PROMPTS)).decode(errors="replace")
    assert read_prompt(prompt).words, prompt


def _part(kind: str) -> Case:
    def case(draw: random.Random, folder: Path) -> None:
        content = {**OF_SLICERS, **OTHERS}[kind]()
        if kind.endswith(".3mf"):
            content = _repacked(draw, content, settings=True)
        elif kind.endswith(".glb") and draw.random() < 0.6:
            content = _document_changed(draw, content)
        elif draw.random() < 0.8:
            content = mutated(draw, content)
        file = folder / kind
        file.write_bytes(content)
        how = draw.choice(READINGS) if draw.random() < 0.4 else {}
        if draw.random() < 0.2:
            load(f"{file}#{mutated(draw, draw.choice(SAID)).decode(errors='replace')}")
        elif draw.random() < 0.2:
            bodies(file, **{name: value for name, value in how.items() if name != "body"})
        else:
            read(file, **how)

    return case


MESHES = ("binary.stl", "words.stl", "part.obj", "binary.ply", "words.ply", "part.glb", "node.glb", "part.3mf")


def _mesh(kind: str) -> Case:
    def case(draw: random.Random, folder: Path) -> None:
        content = sound(kind)
        if kind.endswith(".3mf") and draw.random() < 0.8:  # or a checksum hides every change
            content = _repacked(draw, content)
        elif kind.endswith(".glb") and draw.random() < 0.6:
            content = _document_changed(draw, content)
        else:
            content = mutated(draw, content)
        file = folder / kind
        file.write_bytes(content)
        read(file)

    return case


def _repacked(draw: random.Random, content: bytes, *, settings: bool = False) -> bytes:
    """A package whose models, and settings of slicers if told, are changed, not their packing; or one that unpacks to half a gigabyte."""
    if draw.random() < 0.02:
        return _bomb(content)
    made = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(content)) as old, zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as new:
        for entry in old.namelist():
            data = old.read(entry)
            if entry.endswith(".model") and (not settings or draw.random() < 0.4):
                data = _nested(draw, data) if draw.random() < 0.2 else mutated(draw, data)
            elif settings and entry.endswith((".config", ".rels")) and draw.random() < 0.6:
                data = mutated(draw, data)
            new.writestr(draw.choice((entry, entry, entry, entry, "../" + entry, entry.upper())), data)
    return made.getvalue()


@cache
def _bomb(content: bytes) -> bytes:
    """A package with half a gigabyte of nothing in it."""
    made = io.BytesIO(content)
    with zipfile.ZipFile(made, "a", zipfile.ZIP_DEFLATED, compresslevel=1) as package, package.open("bomb.model", "w") as entry:
        for _ in range(45):
            entry.write(bytes(10_000_000))
    return made.getvalue()


def _nested(draw: random.Random, model: bytes) -> bytes:
    """Objects each made of two of the one before: the last of them of more than there are atoms."""
    depth, twice = draw.choice((3, 30, 60)), draw.choice((1, 2))
    layers = "".join(
        f'<object id="{9 + i}" type="model"><components>'
        + f'<component objectid="{1 if i == 1 else 8 + i}"/>' * twice
        + "</components></object>"
        for i in range(1, depth)
    )
    model = model.replace(b"</resources>", layers.encode() + b"</resources>")
    return model.replace(b'item objectid="1"', f'item objectid="{8 + depth}"'.encode())


def _document_changed(draw: random.Random, content: bytes) -> bytes:
    """A container that is sound, around a document of which one value is another."""
    length = struct.unpack_from("<I", content, 12)[0]
    document, rest = json.loads(content[20 : 20 + length]), content[20 + length :]
    if draw.random() < 0.1:
        document["nodes"] = document["nodes"] + [{"mesh": 0}] * draw.choice((10, 30_000))
        document["scenes"] = [{"nodes": list(range(len(document["nodes"])))}]
    else:
        _change_a_value(draw, document)
    words = json.dumps(document).encode()
    words += b" " * (-len(words) % 4)
    return b"glTF" + struct.pack("<II", 2, 20 + len(words) + len(rest)) + struct.pack("<I", len(words)) + b"JSON" + words + rest


STRANGE = (None, True, -1, 0, 1, 2**31, 10**12, 10**30, 1e308, float("nan"), "", "x", "../../x", "/etc/passwd",
           "file:///etc/passwd", "http://127.0.0.1:9/", "\x1b[2J", "<script>",
           [], {}, [[]], [1] * 40, {"a": 1}, "9" * 5000)  # fmt: skip
"""What a value of a record is replaced by."""


def _change_a_value(draw: random.Random, document: object) -> None:
    """Replace one value, at any depth."""
    places = list(_places(document))
    if places:
        holder, key = draw.choice(places)
        if draw.random() < 0.15:
            del holder[key]  # type: ignore[attr-defined]
        else:
            holder[key] = draw.choice(STRANGE)  # type: ignore[index]


def _places(value: object) -> Iterator[tuple[object, object]]:
    for key in list(value) if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ():
        yield value, key
        yield from _places(value[key])  # type: ignore[index]


def _table(kind: str, reader: Callable[[Path], object]) -> Case:
    def case(draw: random.Random, folder: Path) -> None:
        content = sound(kind)
        if kind.endswith(".json") and draw.random() < 0.6:
            document = json.loads(content)
            _change_a_value(draw, document)
            content = json.dumps(document).encode()
        else:
            content = mutated(draw, content)
        (folder / kind).write_bytes(content)
        reader(folder / kind)

    return case


@cache
def _model_run(folder: Path) -> Path:
    return lane_on_a_sheet(folder / "sound run", iterations=2).store.root


def _copied(folder: Path) -> Run:
    root = folder / "run"
    shutil.rmtree(root, ignore_errors=True)
    shutil.copytree(_model_run(folder), root)
    return Run.open(root, "cpu")


def look(run: Run) -> None:
    """What `log`, `show`, `report` and the Studio read of a run, less the drawing."""
    with contextlib.suppress(MechStyleError):
        _ = run.record.stem, run.part
    with contextlib.suppress(MechStyleError):
        _ = run.summary
    _ = repr(run), run.history, run.recipe, run.verdict, run.finished
    _ = run.surface(), run.simulation(), run.checkpoint(0)


def _store(draw: random.Random, folder: Path) -> None:
    """A run of which one file is changed, or is packed for harm."""
    run = _copied(folder)
    files = [path for path in sorted(run.store.root.rglob("*")) if path.is_file() and path.stat().st_size]
    path = draw.choice(files)
    if path.suffix == ".json" and draw.random() < 0.7:
        document = json.loads(path.read_bytes())
        _change_a_value(draw, document)
        path.write_bytes(json.dumps(document).encode())
    elif draw.random() < 0.05:
        path.write_bytes(_packed_zeros())
    elif path.parent.parent.name == "objects" and draw.random() < 0.6:
        path.write_bytes(zlib.compress(mutated(draw, zlib.decompress(path.read_bytes())), 1))
    else:
        path.write_bytes(mutated(draw, path.read_bytes()))
    look(run)


@cache
def _packed_zeros() -> bytes:
    """A file of half a megabyte that unpacks to gigabytes: one flushed block, again and again."""
    packer = zlib.compressobj(1)
    block = packer.compress(bytes(20_000_000)) + packer.flush(zlib.Z_FULL_FLUSH)
    return block + block[2:] * 100


def _forged(draw: random.Random, folder: Path) -> None:
    """A run whose newest record was changed together with its name, which no digest can notice."""
    run = _copied(folder)
    lane, objects = run.store.lane(), run.store.objects
    head = json.loads(objects.get(lane.head))
    which = draw.choice(("head", "recipe", "simulation", "array"))
    if which == "array":
        name = draw.choice([name for name, value in head.items() if isinstance(value, str) and len(value) == 64])
        content = mutated(draw, objects.get(head[name])) if draw.random() < 0.5 else _strange_array(draw)
        head[name] = objects.put(content)
    elif which == "head":
        _change_a_value(draw, head)
    else:
        record = json.loads(objects.get(head[which]))
        _change_a_value(draw, record)
        head[which] = objects.put(to_json(record))
        if which == "recipe":
            lane = msgspec.structs.replace(lane, recipe=head[which])
    run.store.move("main", msgspec.structs.replace(lane, head=objects.put(to_json(head))))
    look(run)


def _strange_array(draw: random.Random) -> bytes:
    shape = draw.choice(("()", "(0,)", "(64,)", "(10000000000,)", "(64, 3)", "(-1,)", "(2, 2, 2)"))
    kind = draw.choice(("<f4", "<f8", "|O", "|b1", "<U9", "<c16", "<m8", "|V8", "[('a', '<f4')]"))
    header = f"{{'descr': {kind if kind[0] == '[' else repr(kind)}, 'fortran_order': False, 'shape': {shape}, }}".encode()
    header += b" " * (-(len(header) + 11) % 64) + b"\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header + draw.randbytes(draw.choice((0, 256, 768)))


VERBS = ("run", "freestyle", "branch", "simulate", "log", "show", "export", "report", "protect", "gallery", "materials", "styles",
         "doctor", "weights", "rerun", "gc")  # fmt: skip
ARGUMENTS = (
    "--prompt", "--material", "--iterations", "--vertices", "--tolerance", "--scale", "--unit", "--size", "--body", "--up", "--out",
    "--set", "--load", "--protect",
    "--amplitude", "--relief", "--seed", "--json", "--format", "--fine",
    "--lane", "--control", "--schedule", "--criterion", "--image", "--device", "-p", "-h", "--version", "--nonsense", "--",
    "-", "gallery:pen_holder", "gallery:nothing", "gallery:../x",
    "run", "run@2", "run@main:1", "run@999999999999", "run@other", "run@-1", "@", "x@y@z", "", " ", "nan", "-1", "1e400", "9" * 400,
    "x" * 5000, "[/red]", "x\\[/red].stl", "\x1b[2J", "größe", "brick",
    "outside: brick; rim: gold", "travel=nan", "protect=[1]", "loads=[]", "material={}", "image=1", "a=b=c", "=",
    "/dev/null", "/nowhere/x.stl", "..", "binary.stl", "PLA", "wood.toml", "list", "path",
)  # fmt: skip
"""Words of a command line; `run` is a folder with a run."""


def _command_line(draw: random.Random, folder: Path) -> None:
    """A command that is asked for anything; what would take minutes is cut short where it begins."""
    from mechstyle.cli.app import app  # noqa: PLC0415 — here only
    from mechstyle.errors import BadInput  # noqa: PLC0415

    _copied(folder)
    (folder / "binary.stl").write_bytes(sound("binary.stl"))

    def cut_short(*_args: object, **_options: object) -> None:
        raise BadInput("it would begin now")

    import mechstyle.runs.protection  # noqa: PLC0415
    import mechstyle.runs.run  # noqa: PLC0415
    import mechstyle.simulation.part  # noqa: PLC0415
    import mechstyle.simulation.part_test  # noqa: PLC0415

    slow = [
        (mechstyle.runs.run.Draft, "ready"), (mechstyle.simulation.part_test, "simulate"), (mechstyle.runs.run.Run, "go"),
        (mechstyle.runs.run.Run, "exported"),
        (mechstyle.runs.run.Run, "report"), (mechstyle.runs.run.Run, "show"),
        (mechstyle.simulation.part, "standardised"), (mechstyle.runs.protection, "protect"),
    ]  # fmt: skip
    words = [draw.choice(VERBS), *draw.choices(ARGUMENTS, k=draw.randrange(6))]
    if "fetch" in words:
        return
    said = io.StringIO()
    with contextlib.ExitStack() as stack:
        stack.enter_context(contextlib.chdir(folder))
        for owner, name in slow:
            before = getattr(owner, name)
            stack.callback(setattr, owner, name, before)
            setattr(owner, name, cut_short)
        stack.enter_context(contextlib.redirect_stdout(said))
        stack.enter_context(contextlib.redirect_stderr(said))
        try:
            app(args=words, standalone_mode=True)
        except SystemExit as left:
            if left.code not in (0, 1, 2, 130, None):
                raise AssertionError(f"{words} left with {left.code!r}") from left
    if "Traceback" in said.getvalue() or "\x1b" in said.getvalue().replace("\x1b[", ""):
        raise AssertionError(f"{words} said {said.getvalue()[-500:]!r}")


KINDS: dict[str, Case] = {
    **{kind: _mesh(kind) for kind in MESHES},
    **{kind: _part(kind) for kind in (*OF_SLICERS, *OTHERS)},
    "material.toml": _table("material.toml", read_material),
    "material.json": _table("material.json", read_material),
    "loads.toml": _table("loads.toml", read_loads),
    "store": _store,
    "forged": _forged,
    "command line": _command_line,
    "prompt": _prompt,
}


class Hangs(BaseException):
    """A case takes too long; no `except Exception` of what is tried may swallow it."""


def tried(kind: str, number: int, folder: Path) -> str:
    """What came of a case: read, refused, or what is wrong with it, which begins with its name."""

    def too_long(*_: object) -> None:
        raise Hangs

    draw = random.Random(f"{kind} {number}")
    before, children, handler = _fullest(), os.times().children_user, signal.signal(signal.SIGVTALRM, too_long)
    signal.setitimer(signal.ITIMER_VIRTUAL, SECONDS)
    said = io.StringIO()
    try:
        with contextlib.redirect_stderr(said):
            KINDS[kind](draw, folder)
        outcome = "read"
    except MechStyleError as error:
        outcome = "refused" if "\n" not in str(error).strip() and str(error) else f"{kind} {number}: no sentence: {error}"
    except Hangs:
        outcome = f"{kind} {number}: hangs"
    except Exception as error:  # noqa: BLE001 — this is what is looked for
        outcome = f"{kind} {number}: {type(error).__name__}: {str(error)[:300]}"
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.signal(signal.SIGVTALRM, handler)
    if said.getvalue():
        outcome = f"{kind} {number}: said {said.getvalue()[-300:]!r}"
    if os.times().children_user - children > SECONDS:
        outcome = f"{kind} {number}: hangs in another process"
    if (grown := _fullest() - before) > MEMORY:
        outcome = f"{kind} {number}: took {grown / 1e6:.0f} MB more than anything before"
    return outcome


def _fullest() -> int:
    """Most memory the process has held so far [bytes]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def main(folder: Path, first: int, count: int) -> dict[str, object]:
    """Try cases of all kinds in turn; a crash of the process ends it after the name of the case was printed to stderr."""
    folder.mkdir(parents=True, exist_ok=True)
    counts, wrong, begun = Counter[str](), list[str](), time.process_time()
    names = list(KINDS)
    _ = _bomb(sound("part.3mf")), _packed_zeros()  # what makes cases is no case
    for number in range(first, first + count):
        kind = names[number % len(names)]
        sys.stderr.write(f"{CASE}{kind} {number}\n")
        outcome = tried(kind, number, folder)
        counts[outcome if outcome in ("read", "refused") else "wrong"] += 1
        counts[kind] += 1
        if outcome not in ("read", "refused"):
            wrong.append(outcome)
            sys.stderr.write(f"{WRONG}{outcome!r}\n")
    return {"counts": dict(counts), "wrong": wrong, "cpu": round(time.process_time() - begun, 1), "megabytes": _fullest() // 1_000_000}


if __name__ == "__main__":
    sys.stdout.write(json.dumps(main(Path(sys.argv[1]), *map(int, sys.argv[2:4]))) + "\n")
