"""Commands about CLIP's weights: fetch, list, path. Nothing but fetch uses the network in MechStyle."""

from __future__ import annotations

from typing import Annotated

import typer

from mechstyle._files import clip_folder
from mechstyle.cli.console import command, err, escape, out, print_json, table
from mechstyle.cli.options import Json
from mechstyle.styling.learned.weights import DEFAULT, KNOWN, OWN_FOLDER, fetch, located, need_clip_extra, stored

app = typer.Typer()
family = typer.Typer(no_args_is_help=True, help="CLIP weights, which styles from any prompt need (--guidance clip).")
app.add_typer(family, name="weights")


@family.command("fetch")
@command
def fetch_command(name: Annotated[str, typer.Argument(help=f"One of {', '.join(KNOWN)}.")] = DEFAULT, as_json: Json = False) -> None:
    """Download weights once, with their checksums; what is there and sound is left as it is."""
    need_clip_extra()
    if not as_json:
        err.print(f"[dim]fetching {escape(name)} to {escape(str(clip_folder()))}[/]")
    found = fetch(name, clip_folder())
    if as_json:
        print_json({"name": name, "folder": found.folder, "identity": found.identity})
    else:
        out.print(f"{escape(name)}: {escape(str(found.folder))}")


@family.command("list")
@command
def list_command(as_json: Json = False) -> None:
    """List the weights there are and which of them are on this machine."""
    here = {folder.name: folder for folder in stored(clip_folder())}
    if as_json:
        print_json({"weights": [{"name": name, "source": source, "folder": here.get(name)} for name, source in KNOWN.items()]})
        return
    rows = table("weights", "source", "on this machine")
    for name, source in KNOWN.items():
        rows.add_row(escape(name), source, escape(str(here.get(name, f"no; get it with: mechstyle weights fetch {name}"))))
    out.print(rows)
    out.print(f"\nYour own: --clip DIR in a run, or ${OWN_FOLDER} for all of them.")


@family.command("path")
@command
def path_command(
    name: Annotated[
        str, typer.Argument(help=f"Name of weights, or a folder; without it those a run would use: ${OWN_FOLDER}, else {DEFAULT}.")
    ] = "",
    as_json: Json = False,
) -> None:
    """Say where weights are, after verifying them."""
    need_clip_extra()
    found = located(name, clip_folder())
    if as_json:
        print_json({"folder": found.folder, "identity": found.identity})
    else:
        out.print(escape(str(found.folder)))
