"""How a part is printed, by the comments in the G-code that a slicer made of it.

PrusaSlicer, OrcaSlicer and Bambu Studio write every setting they sliced with as `; name = value`; Cura writes those that differ from its
profile, as JSON that is cut into lines `;SETTING_3 …`. What a file does not say has to be given beside it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import msgspec

from mechstyle.errors import BadInput
from mechstyle.records.infill import PATTERNS

LOOKED_AT = 4_000_000
"""Bytes at each end of a file in which comments are looked for: between them lies the way of the nozzle."""

STRAIGHT = {"rectilinear": "grid", "alignedrectilinear": "grid", "line": "grid", "lines": "grid", "zigzag": "grid", "zig-zag": "grid"}
"""Patterns of straight lines that cross, which are judged as a grid."""

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
    maker, read = next(((name, read) for name, (mark, read) in SLICERS.items() if re.search(mark, text, re.MULTILINE)), ("", None))
    if read is None:
        raise BadInput(f"{path.name} is no G-code of {', '.join(SLICERS)}: slice the part with one of them, or give --walls and --infill")
    try:
        found = read(text)
    except ValueError as error:
        raise BadInput(f"{path.name}: the settings that {maker} writes are cut off or damaged ({error}): slice the part again") from error
    pattern = found.get("infill_pattern", "")
    found["infill_pattern"] = STRAIGHT.get(pattern, pattern)
    if found.get("infill", 0.0) in (0.0, 1.0):
        found.pop("infill_pattern")  # which there is none of
    elif pattern and found["infill_pattern"] not in PATTERNS and "infill_pattern" not in given:
        known = " or ".join(PATTERNS)
        raise BadInput(f"{path.name}: it is not known how strong {pattern!r:.40} is: say what to take it for, --infill-pattern {known}")
    missing = [name for name in NEEDED if found.get(name) in (None, "") and name not in given and name != "infill_pattern"]
    if missing:
        flags = ", ".join(f"--{name.replace('_', '-')}" for name in missing)
        raise BadInput(f"{path.name}: {maker} does not say {', '.join(missing).replace('_', ' ')} in it: give {flags} beside it")
    return {name: value for name, value in found.items() if value not in (None, "")}


NEEDED = ("walls", "top", "bottom", "layer_height", "line_width", "infill", "infill_pattern")
"""What of a print decides, by the names of settings."""


def _ends_of(path: Path) -> str:
    """The first and the last of a file; BadInput if it cannot be read."""
    try:
        with path.open("rb") as file:
            size = file.seek(0, 2)
            file.seek(0)
            head = file.read(LOOKED_AT)
            file.seek(max(size - LOOKED_AT, len(head)))
            return (head + b"\n" + file.read()).decode("utf-8", "replace")
    except OSError as error:
        raise BadInput(f"{path.name}: {error.strerror or error}: name the G-code that your slicer wrote") from error


def _of_prusa(text: str) -> dict[str, Any]:
    """Those of PrusaSlicer."""
    if not re.search(r"^; prusaslicer_config = end\s*$", text, re.MULTILINE):
        raise ValueError("their end is missing")
    at = _comments(text)
    width = re.search(r"^; perimeters extrusion width = ([\d.]+)mm", text, re.MULTILINE)
    return _print(
        at, {"walls": "perimeters", "infill": "fill_density", "infill_pattern": "fill_pattern", "vase": "spiral_vase"},
        layers=("top_solid_layers", "bottom_solid_layers"), thick=("top_solid_min_thickness", "bottom_solid_min_thickness"),
        width=float(width[1]) if width else None,
    )  # fmt: skip


def _of_orca(text: str) -> dict[str, Any]:
    """Those of OrcaSlicer and Bambu Studio."""
    block = re.search(r"^; CONFIG_BLOCK_START\s*$(.*?)^; CONFIG_BLOCK_END", text, re.MULTILINE | re.DOTALL)
    if block is None:
        raise ValueError("their end is missing")
    at = _comments(block[1])
    nozzle = float(at.get("nozzle_diameter", "0.4").split(",")[0])
    widths = (_of_nozzle(at.get(name, ""), nozzle) for name in ("inner_wall_line_width", "line_width", "outer_wall_line_width"))
    return _print(
        at, {"walls": "wall_loops", "infill": "sparse_infill_density", "infill_pattern": "sparse_infill_pattern", "vase": "spiral_mode"},
        layers=("top_shell_layers", "bottom_shell_layers"), thick=("top_shell_thickness", "bottom_shell_thickness"),
        width=next((width for width in widths if width), 1.125 * nozzle),
    )  # fmt: skip


def _of_nozzle(written: str, nozzle: float) -> float:
    """A width [mm] that may be written as a share of the nozzle's; 0 where the slicer chooses."""
    value = written.split(",", maxsplit=1)[0].strip()
    return 0.01 * float(value[:-1]) * nozzle if value.endswith("%") else float(value or 0.0)


def _of_cura(text: str) -> dict[str, Any]:
    """Those of Cura that are not as in its profile."""
    written = "".join(re.findall(r"^;SETTING_3 ([^\r\n]*)", text, re.MULTILINE))
    try:
        kept = msgspec.json.decode(written)
    except msgspec.DecodeError as error:
        raise ValueError("their end is missing") from error
    chapters = [kept.get("global_quality", ""), *list(kept.get("extruder_quality", []))[:1]] if isinstance(kept, dict) else []
    at = dict[str, str]()
    for chapter in chapters:
        values = str(chapter).replace("\\n", "\n").partition("[values]")[2]
        at |= {name: value for name, value in re.findall(r"^(\w+) = (.*)$", values, re.MULTILINE) if not value.startswith("=")}
    height = re.search(r"^;Layer height: ([\d.]+)", text, re.MULTILINE)
    at.setdefault("layer_height", height[1] if height else "")
    at["infill_sparse_density"] = f"{at['infill_sparse_density']}%" if "infill_sparse_density" in at else ""
    width = at.get("wall_line_width_x") or at.get("wall_line_width") or at.get("line_width")
    return _print(
        at, {"walls": "wall_line_count", "infill": "infill_sparse_density", "infill_pattern": "infill_pattern", "vase": "magic_spiralize"},
        layers=("top_layers", "bottom_layers"), thick=("top_thickness", "bottom_thickness"), width=float(width) if width else None,
    )  # fmt: skip


def _comments(text: str) -> dict[str, str]:
    """Settings that are written as `; name = value`, the first of each name."""
    pairs = re.findall(r"^; (\w+) = (.*?)\s*$", text, re.MULTILINE)
    return dict(reversed(pairs))


def _print(at: Comments, names: Comments, *, layers: tuple[str, str], thick: tuple[str, str], width: float | None) -> dict[str, Any]:
    """A print by the slicer's names for it; ValueError if a number is none."""
    height, walls = _number(at, "layer_height"), _number(at, names["walls"])
    found: dict[str, Any] = {"layer_height": height, "line_width": width, "walls": None if walls is None else int(walls)}
    for name, count, least in zip(("top", "bottom"), layers, thick, strict=True):
        number, depth = _number(at, count), _number(at, least)
        deep = 0 if depth is None or not height else math.ceil(depth / height - 1e-6)
        found[name] = None if number is None and depth is None else max(int(number or 0), deep if number != 0.0 else 0)
    density = at.get(names["infill"], "")
    if density:
        found["infill"] = min(0.01 * float(density.rstrip("%")), 1.0) if density.endswith("%") else float(density)
    found["infill_pattern"] = at.get(names["infill_pattern"], "")
    if at.get(names["vase"], "0").lower() in ("1", "true"):
        found |= {"walls": 1, "top": 0, "infill": 0.0}
    return found


def _number(at: Comments, name: str) -> float | None:
    """A number, None where it is not said."""
    value = at.get(name, "").split(",")[0]
    if not value:
        return None
    number = math.nan
    with suppress(ValueError):
        number = float(value)
    if not 0.0 <= number < 1e6:
        raise ValueError(f"{name} is {value!r:.40}")
    return number


SLICERS: Mapping[str, tuple[str, Callable[[str], dict[str, Any]]]] = {
    "PrusaSlicer": (r"^; generated by PrusaSlicer", _of_prusa),
    "OrcaSlicer": (r"^; generated by OrcaSlicer", _of_orca),
    "Bambu Studio": (r"^; BambuStudio", _of_orca),
    "Cura": (r"^;Generated with Cura_SteamEngine", _of_cura),
}
"""Slicers by the mark in what they write, and what reads their settings."""
