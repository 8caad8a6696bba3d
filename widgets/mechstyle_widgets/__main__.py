"""The Studio as a page of its own: JupyterLab on this machine alone, with one notebook whose one cell has run before the page is opened."""

from __future__ import annotations

import argparse
import asyncio
import json
import tempfile
import webbrowser
from pathlib import Path
from typing import Any

NAME = "studio.ipynb"
CELL = "import os\nos.chdir({folder!r})\nfrom mechstyle_widgets import Studio\nStudio({part!r}, language={language!r}, filled=True)"
SETTINGS = {
    "apputils-extension/notification": {"fetchNews": "false", "checkForUpdates": False},
    "docmanager-extension/plugin": {"autosave": False},
}
"""What JupyterLab is to do here: it asks nothing outside, and leaves the notebook as it is."""


def main() -> None:
    """Serve the page until it is stopped."""
    parser = argparse.ArgumentParser(prog="mechstyle studio", description="Open the Studio in a browser, without a notebook.")
    parser.add_argument("part", nargs="?", help="gallery:NAME, a file, or the folder of a run")
    parser.add_argument("--language", default="en", choices=("en", "de"))
    parser.add_argument("--port", type=int, default=8888, help="the first port to try")
    parser.add_argument("--no-browser", action="store_true", help="only say the address")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="mechstyle-studio-") as folder:
        serve(Path(folder), cell_for(given.part, given.language), given.port, browser=not given.no_browser)


def cell_for(part: str | None, language: str) -> str:
    """The cell that shows the Studio of a part, whose paths are those of the folder it is called in."""
    return CELL.format(folder=str(Path.cwd()), part=part, language=language)


def serve(home: Path, cell: str, port: int, *, browser: bool = True) -> None:
    """Serve a notebook of one cell from a folder, and open it once the cell has run; returns when the server is stopped."""
    from jupyterlab.labapp import LabApp  # type: ignore[import-untyped]  # noqa: PLC0415 — takes a second

    for name, settings in SETTINGS.items():
        place = home / "settings" / "@jupyterlab" / f"{name}.jupyterlab-settings"
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(json.dumps(settings), encoding="utf-8")
    (home / "notebook").mkdir()
    options = {
        "ServerApp.ip": "127.0.0.1", "ServerApp.port": port, "ServerApp.open_browser": False, "ServerApp.answer_yes": True,
        "ServerApp.root_dir": home / "notebook", "ServerApp.allow_remote_access": False, "ServerApp.allow_root": True,
        "LabApp.user_settings_dir": home / "settings", "LabApp.workspaces_dir": home / "workspaces", "ServerApp.log_level": "ERROR",
        "LabApp.extension_manager": "readonly",
    }  # fmt: skip
    server: Any = LabApp.initialize_server(argv=[f"--{name}={value}" for name, value in options.items()])
    server.io_loop.add_callback(_open, server, home / "notebook" / NAME, cell, browser=browser)
    server.start()


async def _open(server: Any, notebook: Path, cell: str, *, browser: bool) -> None:
    """Run the cell in a kernel of the server, which the page finds by the name of the notebook, then open that."""
    import nbformat  # noqa: PLC0415 — as above
    from nbclient import NotebookClient  # noqa: PLC0415

    files: Any = nbformat  # has no types
    made = files.v4.new_notebook(cells=[files.v4.new_code_cell(cell)])
    made.metadata["kernelspec"] = {"name": "python3", "display_name": "Python 3", "language": "python"}
    files.write(made, notebook)
    session = await server.session_manager.create_session(path=NAME, name=NAME, type="notebook", kernel_name="python3")
    kernel = server.kernel_manager.get_kernel(session["kernel"]["id"])
    client = NotebookClient(made, km=kernel, timeout=None, store_widget_state=False, allow_errors=True)
    async with client.async_setup_kernel(cleanup_kc=False):
        await client.async_execute_cell(made.cells[0], 0)
    files.write(made, notebook)
    server.contents_manager.notary.sign(made)  # what is not trusted shows no widget
    address = f"{server.connection_url}doc/tree/{NAME}?token={server.identity_provider.token}"
    print(f"The Studio is at {address}\nCtrl with C ends it.", flush=True)  # noqa: T201 — what a terminal shows
    if browser:
        await asyncio.to_thread(webbrowser.open, address)


if __name__ == "__main__":
    main()
