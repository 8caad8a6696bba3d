"""How a part is printed, by the comments in the G-code that a slicer made of it.

PrusaSlicer, SuperSlicer, Slic3r, OrcaSlicer and Bambu Studio write every setting they sliced with as `; name = value`; Cura writes those
that differ from its profile, as JSON that is cut into lines `;SETTING_3 …`. What a file does not say has to be given as well.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import msgspec

from mechstyle.errors import BadInput
from mechstyle.records.infill import PATTERNS
from mechstyle.records.recipe import Printed

LOOKED_AT = 4_000_000
"""Bytes at each end of a file in which comments are looked for: between them lies the way of the nozzle."""

STRAIGHT = {"rectilinear": "grid", "alignedrectilinear": "grid", "line": "grid", "lines": "grid", "zigzag": "grid", "zig-zag": "grid"}
"""Patterns of straight lines that cross, which are judged as a grid."""

OTHER_KINDS: Mapping[bytes, str] = {
    b"GCDE": "binary G-code: export it as text, in PrusaSlicer without *Supports binary G-code* in the settings of the printer",
    b"PK\x03\x04": "an archive: take the G-code out of it, or export it by itself",
}
"""What slicers write that holds no text, by its first bytes."""

Comments = Mapping[str, str]


def with_sliced(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Settings with what the file `sliced` among them says of the print, unless that is given; BadInput as for `sliced`."""
    others = {name: value for name, value in settings.items() if name != "sliced"}
    file = settings.get("sliced")
    return others if file in (None, "") else {**sliced(Path(str(file)), set(others)), **others}


def sliced(path: Path, given: set[str] = set()) -> dict[str, Any]:  # noqa: B006 - never changed
    """Walls, layers and infill with which a G-code file was sliced, by the names of settings; those that are `given` may be missing.

    BadInput if it is none of a slicer that is known, was cut off, or does not say them.
    """
    text = _ends_of(path)
    maker, read = next(((name, read) for name, (mark, read) in SLICERS.items() if f"\n{mark}" in text), ("", None))
    if read is None:
        raise BadInput(f"{path.name} is no G-code of {', '.join(SLICERS)}: slice the part with one of them, or give --walls and --infill")
    try:
        found = {name: value for name, value in read(text).items() if value not in (None, "") and name not in given}
        _check(found)
    except ValueError as error:
        raise BadInput(f"{path.name}: the settings that {maker} writes are cut off or damaged ({error}): slice the part again") from error
    pattern = found.get("infill_pattern", "")
    found["infill_pattern"] = STRAIGHT.get(pattern, pattern)
    if not pattern or found.get("infill") in (0.0, 1.0):
        found.pop("infill_pattern")  # which there is none of
    elif found["infill_pattern"] not in PATTERNS:
        known = " or ".join(PATTERNS)
        raise BadInput(f"{path.name}: it is not known how strong {pattern!r:.40} is: say what to take it for, --infill-pattern {known}")
    needed = (*NEEDED, "infill_pattern") if 0.0 < found.get("infill", 0.0) < 1.0 else NEEDED
    missing = [name for name in needed if name not in found and name not in given]
    if missing:
        flags = ", ".join(f"--{name.replace('_', '-')}" for name in missing)
        raise BadInput(f"{path.name}: {maker} does not say {', '.join(missing).replace('_', ' ')} in it: give {flags} beside it")
    return found


NEEDED = ("walls", "top", "bottom", "layer_height", "line_width", "infill")
"""What of a print decides, by the names of settings."""


def _check(found: Mapping[str, Any]) -> None:
    """ValueError if a print is none that a recipe can have."""
    for name, (low, high) in Printed.LIMITS.items():
        value = found.get(name, low)
        if not low <= value <= high:
            raise ValueError(f"{name} is {value:g}")


def _ends_of(path: Path) -> str:
    """The first and the last lines of a file, each after a newline; BadInput if it cannot be read, or is no text."""
    try:
        if path.exists() and not path.is_file():
            raise BadInput(f"{path.name} is no file: name the G-code that your slicer wrote")
        with path.open("rb") as file:
            both = file.read(2 * LOOKED_AT)
            size = file.seek(0, 2)
            if size > len(both):
                file.seek(size - LOOKED_AT)
                both = both[: both.rfind(b"\n", 0, LOOKED_AT) + 1] + file.read(LOOKED_AT).partition(b"\n")[2]  # lines that are whole
    except (OSError, ValueError) as error:
        raise BadInput(f"{path.name}: {getattr(error, 'strerror', None) or error}: name the G-code that your slicer wrote") from error
    for mark, kind in OTHER_KINDS.items():
        if both.startswith(mark):
            raise BadInput(f"{path.name} is {kind}")
    return "\n" + both.decode("utf-8-sig", "replace").replace("\r\n", "\n").replace("\r", "\n")


def _of_slic3r(text: str) -> dict[str, Any]:
    """Those of Slic3r and what descends from it, which say where settings end, while Slic3r itself only stops."""
    begin = next((mark for mark in ("\n; prusaslicer_config = begin", "\n; SuperSlicer_config = begin") if mark in text), "")
    at = _comments(_between(text, begin, begin.replace("begin", "end")) if begin else text)
    if not begin and not ("perimeters" in at and text.endswith("\n")):
        raise ValueError("their end is missing")
    width = re.search(r"^; perimeters extrusion width = (\S{1,20})mm", text, re.MULTILINE)
    return _print(
        at, {"walls": "perimeters", "infill": "fill_density", "infill_pattern": "fill_pattern", "vase": "spiral_vase"},
        layers=("top_solid_layers", "bottom_solid_layers"), thick=("top_solid_min_thickness", "bottom_solid_min_thickness"),
        width=_figure("line width", width[1]) if width else None,
    )  # fmt: skip


def _of_orca(text: str) -> dict[str, Any]:
    """Those of OrcaSlicer and Bambu Studio."""
    at = _comments(_between(text, "\n; CONFIG_BLOCK_START", "\n; CONFIG_BLOCK_END"))
    if "\n; EXECUTABLE_BLOCK_START" in text:
        _between(text, "\n; EXECUTABLE_BLOCK_START", "\n; EXECUTABLE_BLOCK_END")
    nozzle = _number(at, "nozzle_diameter") or 0.4
    widths = (_number(at, name, nozzle) for name in ("inner_wall_line_width", "line_width", "outer_wall_line_width"))
    return _print(
        at, {"walls": "wall_loops", "infill": "sparse_infill_density", "infill_pattern": "sparse_infill_pattern", "vase": "spiral_mode"},
        layers=("top_shell_layers", "bottom_shell_layers"), thick=("top_shell_thickness", "bottom_shell_thickness"),
        width=next((width for width in widths if width), 1.125 * nozzle),
    )  # fmt: skip


def _of_cura(text: str) -> dict[str, Any]:
    """Those of Cura that are not as in its profile."""
    written = "".join(re.findall(r"^;SETTING_3 (.*)", text, re.MULTILINE))
    if not written and "\n;End of Gcode" in text:
        written = "{}"  # as its engine by itself writes it
    try:
        kept = msgspec.json.decode(written)
    except (msgspec.DecodeError, RecursionError) as error:
        raise ValueError("their end is missing") from error
    chapters = [kept.get("global_quality", ""), *list(kept.get("extruder_quality", []))[:1]] if isinstance(kept, dict) else []
    at = dict[str, str]()
    for chapter in chapters:
        values = str(chapter).replace("\\n", "\n").partition("[values]")[2]
        at |= {name: value.strip() for name, value in re.findall(r"^(\w+) = (.*)$", values, re.MULTILINE) if not value.startswith("=")}
    height = re.search(r"^;Layer height: (\S{1,20})", text, re.MULTILINE)
    at.setdefault("layer_height", height[1] if height else "")
    at["infill_sparse_density"] = f"{at['infill_sparse_density']}%" if "infill_sparse_density" in at else ""
    width = next((name for name in ("wall_line_width_x", "wall_line_width") if name in at), "line_width")
    return _print(
        at, {"walls": "wall_line_count", "infill": "infill_sparse_density", "infill_pattern": "infill_pattern", "vase": "magic_spiralize"},
        layers=("top_layers", "bottom_layers"), thick=("top_thickness", "bottom_thickness"), width=_number(at, width),
    )  # fmt: skip


def _between(text: str, begin: str, end: str) -> str:
    """What stands between two marks; ValueError if one is missing."""
    block, closed, _ = text.partition(begin)[2].partition(end)
    if not closed:
        raise ValueError("their end is missing")
    return block


def _comments(text: str) -> dict[str, str]:
    """Settings that are written as `; name = value`, the last of each name."""
    return {name: value.strip() for name, value in re.findall(r"^; (\w+) = (.*)$", text, re.MULTILINE)}


def _print(at: Comments, names: Comments, *, layers: tuple[str, str], thick: tuple[str, str], width: float | None) -> dict[str, Any]:
    """A print by the slicer's names for it; ValueError if a number is none."""
    height = _number(at, "layer_height")
    found: dict[str, Any] = {"layer_height": height, "line_width": width or None, "walls": _count(at, names["walls"])}
    for name, count, least in zip(("top", "bottom"), layers, thick, strict=True):
        number, depth = _count(at, count), _number(at, least)
        deep = 0 if depth is None or not height else math.ceil(depth / height - 1e-6)
        found[name] = None if number is None and depth is None else max(number or 0, deep if number != 0 else 0)
    found["infill"] = _number(at, names["infill"], 1.0)
    found["infill_pattern"] = at.get(names["infill_pattern"], "")
    if at.get(names["vase"], "0").lower() in ("1", "true"):
        found |= {"walls": 1, "top": 0, "infill": 0.0}
    return found


def _count(at: Comments, name: str) -> int | None:
    """A whole number, None where it is not said."""
    number = _number(at, name)
    if number is not None and not number.is_integer():
        raise ValueError(f"{name} is {number:g}")
    return None if number is None else int(number)


def _number(at: Comments, name: str, whole: float | None = None) -> float | None:
    """A number of millimetres or times, or a percentage of the `whole`; None where it is not said."""
    value = at.get(name, "").partition(",")[0]
    if whole is not None and value.endswith("%"):
        return _figure(name, value[:-1]) * whole / 100.0
    return _figure(name, value) if value else None


def _figure(name: str, written: str) -> float:
    """A figure as slicers write them: digits and a point, neither signed nor in powers of ten."""
    if not re.fullmatch(r"[0-9]{1,9}(\.[0-9]{0,20})?|\.[0-9]{1,20}", written):
        raise ValueError(f"{name} is {written!r:.40}")
    return float(written)


SLICERS: Mapping[str, tuple[str, Callable[[str], dict[str, Any]]]] = {
    "PrusaSlicer": ("; generated by PrusaSlicer", _of_slic3r),
    "SuperSlicer": ("; generated by SuperSlicer", _of_slic3r),
    "Slic3r": ("; generated by Slic3r", _of_slic3r),
    "OrcaSlicer": ("; generated by OrcaSlicer", _of_orca),
    "Bambu Studio": ("; BambuStudio", _of_orca),
    "Cura": (";Generated with Cura_SteamEngine", _of_cura),
}
"""Slicers by the mark in what they write, and what reads their settings."""
