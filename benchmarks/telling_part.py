"""Searches a part that makes the point: dented when it is styled freely, whole when the drop test watches.

    python benchmarks/telling_part.py PART STYLE --out rows/PART-STYLE.json
    python benchmarks/telling_part.py --table rows

PART is a model of the gallery or a shape of this file, with measures where they differ: `stem_stand:stem=7,head=24`. One call is one part
in one style at class size: freely and with feedback, dropped flat; where that tells something, with masks on the way and in all landings.
"""

from __future__ import annotations

import argparse
import json
import math
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from manifold3d import Manifold
from rich.console import Console
from rich.table import Table

import mechstyle as ms
from mechstyle import gallery
from mechstyle.errors import MechStyleError
from mechstyle.gallery import _solids
from mechstyle.records.mesh import SurfaceMesh

RESERVE = 1.3
"""What a plain part must survive over what is asked, else its style has no room and the cell is not run."""
KEPT = 0.6, 0.985
"""Share of the style from which feedback is worth a look, and up to which it has done something."""


def stem_stand(
    *, foot: float = 50.0, plate: float = 4.0, stem: float = 7.0, height: float = 40.0, head: float = 22.0, dish: float = 0.0
) -> SurfaceMesh:
    """A disc with a stem and a round head on it, such as a ring stand or a table number."""
    low, top, ball = plate, height, head / 2
    fillet = np.linspace(0.0, math.pi / 2, 9)
    flare = 0.9 * stem
    centre = top - ball
    start = math.asin(min(1.0, stem / 2 / ball))
    cap = np.linspace(math.pi - start, 0.0, 40)[:-1]
    profile = [(0.0, 0.0), (foot / 2 - 0.6, 0.0), (foot / 2, 0.6), (foot / 2, low - 1.2), (foot / 2 - 1.2, low)]
    profile += [(stem / 2 + flare * (1 - math.sin(a)), low + flare * (1 - math.cos(a))) for a in fillet]
    profile += [(ball * math.sin(a), centre + ball * math.cos(a)) for a in cap]
    profile += [(0.0, top)]
    section = _solids.polygon(profile)
    if dish:
        section -= _solids.disc(dish).translate((0.0, top + 0.35 * dish))
    return _solids.standing(_solids.revolved(section, soft=0.8))


def arm_stand(
    *, width: float = 36.0, depth: float = 60.0, plate: float = 5.0, thick: float = 9.0, tip: float = 7.0, height: float = 46.0,
    reach: float = 26.0, ball: float = 0.0,
) -> SurfaceMesh:  # fmt: skip
    """A plate with an arm that rises, leans over and ends round, such as a stand for a watch or a pair of headphones."""
    base = _solids.slab(_solids.box(width, depth, 0.4 * width), plate, top=1.5)
    bend = min(0.8 * reach, height - plate - 6.0)
    turn = np.linspace(0.0, math.pi / 2, 30)
    up = np.column_stack([np.zeros(20), np.linspace(0.5 * plate, height - bend, 20)])
    arc = np.column_stack([bend * (1 - np.cos(turn)), height - bend + bend * np.sin(turn)])
    over = np.column_stack([np.linspace(bend, reach, 12)[1:], np.full(11, height)])
    path = np.concatenate([up, arc[1:], over])
    way = np.concatenate([[0.0], np.linalg.norm(np.diff(path, axis=0), axis=1).cumsum()])
    share = way / way[-1]
    flare = 1.0 + 0.7 * np.exp(-np.maximum(way - 0.5 * plate, 0.0) / 4.0)
    size = thick + (tip - thick) * share
    left = (way[-1] - way) / (0.5 * tip)
    end = np.sqrt(np.clip(1.0 - (1.0 - np.clip(left, 0.0, 1.0)) ** 2, 0.03, 1.0))
    sizes = np.column_stack([1.25 * size * np.minimum(flare, 1.5), size * flare]) * end[:, None]
    body = base + _solids.swept(path - (0.3 * reach, 0.0), sizes)
    if ball:
        body += Manifold.sphere(ball / 2, 64).translate((0.0, float(path[-1, 0]) - 0.3 * reach, height))
    return _solids.standing(body)


def t_stand(
    *, width: float = 34.0, depth: float = 60.0, plate: float = 5.0, post: float = 9.0, height: float = 52.0, bar: float = 48.0,
    tip: float = 6.0,
) -> SurfaceMesh:  # fmt: skip
    """A plate with a post and two arms on it, thick at the post and slender at their ends, such as a stand for bracelets."""
    base = _solids.slab(_solids.box(width, depth, 0.35 * width), plate, top=1.5)
    z = np.linspace(0.5 * plate, height, 40)
    flare = 1.0 + 0.6 * np.exp(-np.maximum(z - 0.5 * plate, 0.0) / 4.0)
    column = _solids.swept(np.column_stack([np.zeros_like(z), z]), np.column_stack([1.2 * post * flare, post * flare]))
    y = np.linspace(-bar / 2, bar / 2, 81)
    size = tip + (post - tip) * (1 - np.abs(y) / (bar / 2)) ** 1.0
    end = np.sqrt(np.clip(1.0 - (1.0 - np.clip((bar / 2 - np.abs(y)) / (0.5 * tip), 0.0, 1.0)) ** 2, 0.03, 1.0))
    across = _solids.swept(np.column_stack([y, np.full_like(y, height)]), np.column_stack([1.1 * size * end, size * end]))
    return _solids.standing(base + column + across)


def goblet(
    *, foot: float = 44.0, stem: float = 8.0, height: float = 56.0, bowl: float = 36.0, wall: float = 3.0, share: float = 0.45
) -> SurfaceMesh:
    """A small cup on a stem, such as an egg cup."""
    plate, z0 = 3.5, (1.0 - share) * height
    r = bowl / 2
    turn = np.linspace(0.0, math.pi / 2, 16)
    flare = 0.9 * stem
    profile = [(0.0, 0.0), (foot / 2 - 0.6, 0.0), (foot / 2, 0.6), (foot / 2, plate - 1.0), (foot / 2 - 1.0, plate)]
    profile += [(stem / 2 + flare * (1 - math.sin(a)), plate + flare * (1 - math.cos(a))) for a in np.linspace(0, math.pi / 2, 9)]
    profile += [(stem / 2, z0 - 1.0)]
    deep = height - z0
    profile += [(max(r * math.sin(a), stem / 2), z0 + 0.7 * deep * (1 - math.cos(a))) for a in turn[1:]]
    profile += [(r, height), (r - wall, height)]
    profile += [((r - wall) * math.sin(a), z0 + wall + (0.7 * deep - wall) * (1 - math.cos(a)) ) for a in turn[::-1]]
    return _solids.standing(_solids.revolved(_solids.polygon(profile), soft=0.8))


SHAPES = {shape.__name__: shape for shape in (stem_stand, arm_stand, t_stand, goblet)}


HEADINGS = ("part", "style", "plain m", "free m", "z/H", *("fed", "sure", "m", "kept", "drops"), *("watched", "sure", "m", "kept", "drops"))
HEADINGS += ("all landings", "sure", "m", "kept", "drops", "s")


def built(words: str) -> SurfaceMesh:
    """The part of an address such as `wall_hook:reach=60`."""
    name, _, measures = words.partition(":")
    given = {key: float(value) for key, _, value in (one.partition("=") for one in filter(None, measures.split(",")))}
    return SHAPES[name](**given) if name in SHAPES else gallery.make(name, **given)


def rows_of(verdict: ms.Verdict) -> list[dict[str, Any]]:
    """Every test with what it came to."""
    return [
        {
            "test": row.test, "outcome": row.outcome, "landing": row.landing, "stress": round(row.stress, 2),
            "reserve": round(row.reserve, 3), "height": row.height, "original": row.original, "decides": row.decides,
        }
        for row in verdict.rows
    ]  # fmt: skip


def of_a_run(run: ms.Run) -> dict[str, Any]:
    """A finished run in figures, with the place of the largest stress of its last checkpoint that is not under the part."""
    summary, end = run.summary, run.checkpoint()
    surface = run.surface()
    stress = np.asarray(end.stress)
    high = surface.vertices[:, 2] > 1.0
    place = surface.vertices[high][stress[high].argmax()]
    mean = surface.vertices[stress >= np.quantile(stress, 0.99)].mean(axis=0)
    return {
        "outcome": summary.outcome, "sure": not summary.doubts, "doubts": [doubted(doubt) for doubt in summary.doubts],
        "rows": rows_of(run.verdict), "kept": round(summary.kept, 4), "carried": round(summary.carried, 4),
        "drops": [[line.iteration, line.outcome, round(line.stress, 2), line.reason] for line in summary.simulations],
        "place": [round(float(x), 1) for x in place], "mean_place": [round(float(x), 1) for x in mean],
        "visible_stress": round(float(stress[high].max()), 1), "seconds": round(sum(summary.seconds.values()), 1),
        "notes": list(summary.notes),
    }  # fmt: skip


def doubted(doubt: ms.Doubt) -> list[Any]:
    """A doubt in short."""
    return [doubt.about, doubt.test, round(doubt.value, 3)]


def cell(
    part: str, style: str, *, vertices: int, iterations: int, height: float, device: str, settings: dict[str, Any]
) -> dict[str, Any]:  # fmt: skip
    """One part in one style, three ways."""
    begun = time.perf_counter()
    mesh = built(part)
    row: dict[str, Any] = {"part": part, "style": style, "vertices": vertices, "iterations": iterations, "fall": height, **settings}
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    row["size"] = [round(float(x), 1) for x in high - low]
    common = {"vertices": vertices, "iterations": iterations, "height": height, "device": device, **settings}
    flat = {**common, "nearly_flat": False}

    def done(**more: Any) -> dict[str, Any]:
        return row | more | {"seconds": round(time.perf_counter() - begun, 1)}

    with tempfile.TemporaryDirectory() as folder:
        plain = ms.simulate(mesh, vertices=vertices, height=height, device=device, nearly_flat=False)
        row["plain"] = rows_of(plain.verdict)
        if not plain.verdict.rows or plain.verdict.rows[0].reserve < RESERVE:
            return done(skipped="the plain part has no room")
        row["free"] = of_a_run(ms.stylize(mesh, style, freestyle=True, out=f"{folder}/free", **flat))
        if row["free"]["outcome"] != "FAILS":
            return done(skipped="freestyle passes")
        row["fed"] = of_a_run(ms.stylize(mesh, style, out=f"{folder}/fed", **flat))
        if row["fed"]["outcome"] == "HOLDS" and row["fed"]["sure"] and KEPT[0] <= row["fed"]["kept"] <= KEPT[1]:
            row["watched"] = of_a_run(ms.stylize(mesh, style, schedule="stress", out=f"{folder}/watched", **flat))
            row["whole"] = of_a_run(ms.stylize(mesh, style, out=f"{folder}/whole", **common))
    return done()


def table(folder: Path) -> None:
    """The rows of a folder, the most telling first."""
    rows = [json.loads(path.read_text(encoding="utf-8")) for path in sorted(folder.glob("**/*.json"))]
    found = Table()
    for heading in HEADINGS:
        found.add_column(heading)

    def rank(row: dict[str, Any]) -> tuple[Any, ...]:
        runs = [row[name] for name in ("whole", "fed", "watched") if name in row]
        good = any(run["outcome"] == "HOLDS" and run["sure"] and 0.7 <= run["kept"] <= 0.96 for run in runs)
        holds = any(run["outcome"] == "HOLDS" for run in runs)
        return (not good, not holds, -max((len(run["drops"]) for run in runs), default=0))

    for row in sorted(rows, key=rank):
        if "fed" not in row:
            continue
        free = row["free"]
        cells = [row["part"], row["style"], f"{row['plain'][0]['height'] / 1e3:.1f}", f"{free['rows'][0]['height'] / 1e3:.2f}"]
        cells += [f"{free['place'][2] / row['size'][2]:.2f}"]
        for run in (row["fed"], row.get("watched"), row.get("whole")):
            if run is None:
                cells += [""] * 5
                continue
            tight = min((one for one in run["rows"] if one["decides"]), key=lambda one: one["reserve"])
            cells += [run["outcome"], "sure" if run["sure"] else "/".join(one[0] for one in run["doubts"])]
            cells += [f"{tight['height'] / 1e3:.2f}", f"{run['kept']:.0%}", " ".join(f"{one[2]:.0f}" for one in run["drops"])]
        found.add_row(*cells, f"{row['seconds']:.0f}")
    Console(width=260).print(found)


def main() -> None:
    """Run a cell, or print the table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("part", nargs="?", default="")
    parser.add_argument("style", nargs="?", default="brick")
    parser.add_argument("--out", type=Path, default=None)
    parser.add_argument("--vertices", type=int, default=3000)
    parser.add_argument("--iterations", type=int, default=40)
    parser.add_argument("--height", type=float, default=1500.0)
    parser.add_argument("--device", default="auto")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="a setting of the recipe, a number or a word")
    parser.add_argument("--table", type=Path, default=None)
    given = parser.parse_args()
    if given.table:
        table(given.table)
        return
    settings = {}
    for one in given.set:
        name, _, value = one.partition("=")
        settings[name] = float(value) if value.replace(".", "", 1).isdigit() else value
    try:
        asked = {"vertices": given.vertices, "iterations": given.iterations, "height": given.height, "device": given.device}
        row = cell(given.part, given.style, **asked, settings=settings)
    except MechStyleError as error:
        row = {"part": given.part, "style": given.style, "refused": str(error)}
    text = json.dumps(row, indent=1)
    if given.out:
        given.out.parent.mkdir(parents=True, exist_ok=True)
        given.out.write_text(text + "\n", encoding="utf-8")
    else:
        print(text)


if __name__ == "__main__":
    main()
