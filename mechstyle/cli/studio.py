"""The command that opens the Studio as a page of its own."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from pathlib import Path
from typing import Annotated

import typer

from mechstyle.cli.console import command
from mechstyle.errors import BadInput

app = typer.Typer()


@app.command("studio")
@command
def studio_command(
    part: Annotated[str, typer.Argument(help="gallery:NAME, a file, or the folder of a run; without it a finished run is on show.")] = "",
    *,
    language: Annotated[str, typer.Option(help="en or de.")] = "en",
    port: Annotated[int, typer.Option(help="The first port to try.")] = 8888,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Whether to open a browser, or only say the address.")] = True,
) -> None:
    """Open the Studio in a browser, on this machine alone, without a notebook."""
    if importlib.util.find_spec("jupyterlab") is None or importlib.util.find_spec("mechstyle_widgets") is None:
        raise BadInput("the Studio needs JupyterLab, which is not installed: pip install 'mechstyle[jupyter]'")
    if part:
        _check_part(part)
    given = [*([part] if part else []), "--language", language, "--port", str(port), *([] if browser else ["--no-browser"])]
    ended = subprocess.run([sys.executable, "-m", "mechstyle_widgets", *given], check=False)  # noqa: S603 — our own module
    raise typer.Exit(ended.returncode)


def _check_part(part: str) -> None:
    """Refuse what is neither a model of the gallery, nor a file, nor a run, before a server is started for it."""
    from mechstyle.gallery import PREFIX, addressed, entry  # noqa: PLC0415 — loaded when wanted
    from mechstyle.loop.store import Store, parse_address  # noqa: PLC0415

    if part.startswith(PREFIX):
        entry(part.removeprefix(PREFIX))
    elif not Path(addressed(part)[0]).is_file():
        Store.open(parse_address(part)[0])
