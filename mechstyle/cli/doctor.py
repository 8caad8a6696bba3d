"""The command that checks the installation."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import platform
import shutil
from typing import Any

import typer

from mechstyle.cli.console import command, escape, out, print_json, table
from mechstyle.cli.options import Json

app = typer.Typer()

EXTRAS = {
    "jupyter": ("the notebook interface", ("jupyterlab", "ipywidgets", "pythreejs", "plotly", "anywidget")),
    "clip": ("styles from any prompt (guidance clip) and the X-Mesh network", ("torch", "transformers", "safetensors")),
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
    from mechstyle.fea.explicit import cores  # noqa: PLC0415

    packages = ("mechstyle", "numpy", "scipy", "trimesh", "manifold3d", "pytetwild", "warp-lang", "matplotlib")
    versions = {"python": platform.python_version(), "cores": str(cores())}
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
