"""Commands that check the installation and the simulation: doctor, validate."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import os
import platform
import shutil
from pathlib import Path
from typing import Annotated, Any

import typer

from mechstyle.cli.console import command, escape, fail, out, print_json, table
from mechstyle.cli.options import Json

app = typer.Typer()

EXTRAS = {
    "jupyter": ("the notebook interface", ("jupyterlab", "ipywidgets", "pythreejs", "plotly", "anywidget")),
    "clip": ("styles from any prompt (guidance clip) and the X-Mesh network", ("torch", "transformers", "safetensors")),
    "study": ("studies on many machines (--scheduler) and tables as Parquet", ("distributed", "pyarrow")),
}
"""What each extra is for, and its modules."""


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
    """Versions, devices and folders, and optional things that are not here: why one would want them, and how to get them."""
    from mechstyle._files import cache_folder  # noqa: PLC0415
    from mechstyle.fea.drop import available_devices  # noqa: PLC0415 — loads Warp

    packages = ("mechstyle", "numpy", "scipy", "trimesh", "manifold3d", "pytetwild", "warp-lang", "matplotlib")
    versions = {"python": platform.python_version(), "cores": str(os.cpu_count())}
    versions |= {name: importlib.metadata.version(name) for name in packages}
    folder = cache_folder()
    size = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file()) if folder.is_dir() else 0
    there = next(path for path in (folder, *folder.parents) if path.exists())
    devices, missing = available_devices(), []
    cache = {"folder": str(folder), "megabytes": size / 1e6, "free_gigabytes": shutil.disk_usage(there).free / 1e9}
    for extra, (reason, modules) in EXTRAS.items():
        absent = [module for module in modules if importlib.util.find_spec(module) is None]
        if absent:
            missing.append({"what": ", ".join(absent), "why": f"needed for {reason}", "how": f"pip install 'mechstyle[{extra}]'"})
    if devices == ["cpu"]:
        why, how = "simulations run on the CPU, which works the same but slower", "an NVIDIA GPU with a current driver"
        missing.append({"what": "a CUDA device", "why": why, "how": how})
    return {"versions": versions, "devices": devices, "cache": cache, "missing": missing}


MARKS = {True: "[green]passed[/]", False: "[red]FAILED[/]", None: "[yellow]not run[/]"}


@app.command("validate")
@command
def validate_command(
    names: Annotated[list[str] | None, typer.Option("--case", metavar="NAME", help="Only this case; may be repeated.")] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Leave out what takes minutes.")] = False,
    folder: Annotated[Path | None, typer.Option("--out", help="Folder for a table and a plot.")] = None,
    page: Annotated[Path | None, typer.Option(help="Markdown page to write.")] = None,
    as_json: Json = False,
) -> None:
    """Hold the simulation against textbook solutions, CalculiX, finer meshes and other arithmetic; non-zero exit if it fails."""
    from mechstyle.simulation.validation import suite  # noqa: PLC0415 - physics is loaded when something is run
    from mechstyle.simulation.validation.cases import named  # noqa: PLC0415

    chosen = [named(name, suite.CASES) for name in names] if names else [case for case in suite.CASES.values() if not (quick and case.slow)]
    found = []
    for case, results in suite.run(chosen):
        found.append((case, results))
        if not as_json:
            rows = table("", "measured", "reference", "error", "limit", "", title=escape(case.title))
            for one in results:
                numbers = [f"{value:.4g}" for value in (one.measured, one.reference, one.error, one.limit)]
                rows.add_row(escape(one.case), *(numbers if one.passed is not None else [""] * 4), MARKS[one.passed])
            out.print(rows)
            out.print(*{f"  {escape(one.note)}" for one in results if one.passed is None})
    if folder is not None:
        suite.write_page(folder / "validation.md", found)
        suite.draw(folder / "validation.png", found)
    if page is not None:
        suite.write_page(page, found)
    if as_json:
        print_json({"cases": [one for _, results in found for one in results]})
    failed = [one.case for _, results in found for one in results if one.passed is False]
    if failed:
        fail(f"{len(failed)} of the figures lie outside their limits: {'; '.join(failed)}", 1, as_json=False)
