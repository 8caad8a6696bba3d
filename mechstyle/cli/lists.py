"""Commands that list what there is: materials, styles, gallery, doctor."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import os
import platform
import shutil
from pathlib import Path
from typing import Annotated, Any

import typer

from mechstyle.cli.console import command, escape, out, print_json, table, telling
from mechstyle.cli.run import Json
from mechstyle.errors import BadInput

app = typer.Typer()


@app.command("materials")
@command
def materials_command(as_json: Json = False) -> None:
    """List the material library with its sources."""
    from mechstyle.records.material import LIBRARY  # noqa: PLC0415 — loaded when wanted

    if as_json:
        print_json({"materials": list(LIBRARY.values())})
        return
    rows = table("material", "E [MPa]", "ν", "ρ [g/mm³]", "yield [MPa]", "source")
    for m in LIBRARY.values():
        rows.add_row(m.name, f"{m.youngs_modulus:g}", f"{m.poisson_ratio:g}", f"{m.density:g}", f"{m.yield_strength:g}", escape(m.source))
    out.print(rows)
    out.print("\nYour own: a .toml or .json file with name, youngs_modulus, poisson_ratio, density, yield_strength.")


@app.command("styles")
@command
def styles_command(
    sheet: Annotated[Path | None, typer.Option(help="PNG to write: every style on three parts, coloured and grey; takes minutes.")] = None,
    as_json: Json = False,
) -> None:
    """List the offline styles and the words that call them."""
    from mechstyle.styling.library import library  # noqa: PLC0415 — loaded when wanted

    if sheet is not None:
        written = _draw_sheet(sheet, quiet=as_json)
        print_json({"files": {"sheet": str(written)}}) if as_json else out.print(escape(str(written)))
        return
    known = library().values()
    if as_json:
        print_json(
            {"styles": [{"name": s.name, "words": s.words, "description": s.description, "feature_mm": s.feature_mm} for s in known]}
        )
        return
    rows = table("style", "also called", "what it is")
    for style in known:
        rows.add_row(style.name, escape(", ".join(style.words)), escape(style.description))
    out.print(rows)


def _draw_sheet(path: Path, *, quiet: bool) -> Path:
    """Draw the contact sheet with progress, after making sure that it can be written."""
    from mechstyle.gallery.style_sheet import PARTS, contact_sheet  # noqa: PLC0415 — loaded when wanted
    from mechstyle.styling.library import names  # noqa: PLC0415

    if path.suffix.lower() != ".png" or not path.absolute().parent.is_dir():
        raise BadInput(f"the sheet of styles cannot be written to {path}: name a .png file in a folder that exists")
    with telling(len(PARTS) + len(names()), quiet=quiet) as teller:
        return contact_sheet(stage=teller.step).save(path)


@app.command("gallery")
@command
def gallery_command(as_json: Json = False) -> None:
    """List the built-in parametric models."""
    from mechstyle.gallery import describe, names  # noqa: PLC0415 — loaded when wanted

    if as_json:
        print_json({"models": [{"name": name, "description": describe(name)} for name in names()]})
        return
    rows = table("model", "what it is")
    for name in names():
        rows.add_row(f"gallery:{name}", escape(describe(name)))
    out.print(rows)


EXTRAS = {
    "jupyter": ("jupyterlab", "ipywidgets", "pythreejs", "plotly", "anywidget"),
    "clip": ("torch", "transformers", "safetensors"),
    "study": ("pandas", "pingouin", "dask"),
}


@app.command("doctor")
@command
def doctor_command(as_json: Json = False) -> None:
    """Versions, devices, what is missing and how to get it."""
    report = examined()
    if as_json:
        print_json(report)
        return
    rows = table("", "")
    for name, value in report["versions"].items():
        rows.add_row(name, value)
    rows.add_row("devices", ", ".join(report["devices"]))
    cache = report["cache"]
    rows.add_row("cache", f"{cache['folder']} ({cache['megabytes']:.0f} MB, {cache['free_gigabytes']:.0f} GB free; safe to delete)")
    out.print(rows)
    for missing in report["missing"]:
        out.print(f"missing: {escape(missing['what'])} — {escape(missing['why'])}; get it with: {escape(missing['how'])}")
    if not report["missing"]:
        out.print("nothing is missing")


def examined() -> dict[str, Any]:
    """What `doctor` reports."""
    from mechstyle._files import cache_folder  # noqa: PLC0415
    from mechstyle.fea.drop import available_devices  # noqa: PLC0415 — loads Warp

    packages = ("mechstyle", "numpy", "scipy", "trimesh", "manifold3d", "gpytoolbox", "pytetwild", "warp-lang", "matplotlib")
    versions = {"python": platform.python_version(), "cores": str(os.cpu_count())} | {
        name: importlib.metadata.version(name) for name in packages
    }
    folder = cache_folder()
    size = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file()) if folder.is_dir() else 0
    there = next(path for path in (folder, *folder.parents) if path.exists())
    devices = available_devices()
    return {
        "versions": versions,
        "devices": devices,
        "cache": {"folder": str(folder), "megabytes": size / 1e6, "free_gigabytes": shutil.disk_usage(there).free / 1e9},
        "missing": missing_pieces(devices),
    }


def missing_pieces(devices: list[str]) -> list[dict[str, str]]:
    """Optional things that are not here, why one would want them, and the command that gets them."""
    reasons = {
        "jupyter": "the notebook interface",
        "clip": "styles from any prompt (guidance clip) and the X-Mesh network",
        "study": "parameter studies, which a later version brings",
    }
    missing = []
    for extra, modules in EXTRAS.items():
        absent = [module for module in modules if importlib.util.find_spec(module) is None]
        if absent:
            missing.append({"what": ", ".join(absent), "why": f"needed for {reasons[extra]}", "how": f"pip install 'mechstyle[{extra}]'"})
    if devices == ["cpu"]:
        missing.append(
            {
                "what": "a CUDA device",
                "why": "simulations run on the CPU, which works the same but slower",
                "how": "an NVIDIA GPU with a current driver",
            }
        )
    return missing
